"""Both models on one scene, and the examples that compare them."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import trapezoid

from cohesive import Comparison, Scene, compare, run
from cohesive.commands.command_line import main
from cohesive.elements.registry import ELEMENTS
from examples import discrete_and_smeared, sandwich_panel
from meshing.paths import along_paths
from tests.builders import block

QUANTITIES = ["peak", "opening_at_peak", "energy", "dissipated", "curve_distance", "iterations", "seconds"]


@pytest.fixture(scope="module")
def comparison() -> Comparison:
    scene = Scene.load("notched-beam").with_(**{"mesh.crack_size": 2.5, "mesh.far_size": 12.0, "stage.0.steps": 20})
    return compare(scene)


def test_table(comparison: Comparison) -> None:
    table, (d, s) = comparison.table, (comparison.discrete, comparison.smeared)
    assert list(table) == QUANTITIES
    assert all(list(row) == ["discrete", "smeared", "relative_difference"] for row in table.values())
    assert (table["peak"]["discrete"], table["peak"]["smeared"]) == (d.peak_load, s.peak_load)
    assert table["peak"]["relative_difference"] == pytest.approx(s.peak_load / d.peak_load - 1)
    assert table["iterations"]["smeared"] == s.iterations
    # the areas by hand: both runs end at 0.18 mm
    energy = [trapezoid(np.r_[0, r.history["load"]], np.r_[0, r.history["opening"]]) for r in (d, s)]
    assert [table["energy"][model] for model in ("discrete", "smeared")] == pytest.approx(energy, rel=1e-9)
    ends = [r.dissipated_energy for r in (d, s)]
    assert [table["dissipated"][model] for model in ("discrete", "smeared")] == pytest.approx(ends, rel=1e-9)
    x = np.linspace(0, 0.18, 20001)
    loads = [np.interp(x, np.r_[0, r.history["opening"]], np.r_[0, r.history["load"]]) for r in (d, s)]
    between = trapezoid(abs(loads[1] - loads[0]), x)
    assert table["curve_distance"]["discrete"] == pytest.approx(between / energy[0], rel=1e-3)
    assert table["curve_distance"]["relative_difference"] == pytest.approx(2 * between / sum(energy), rel=1e-3)


def test_models_agree_on_the_beam(comparison: Comparison) -> None:
    """Coarse: crack and band of 2.5 mm; examples/discrete_and_smeared.py shows how they close in."""
    assert abs(comparison.table["peak"]["relative_difference"]) < 0.02
    assert comparison.table["curve_distance"]["relative_difference"] < 0.02


def test_profiles_lie_on_each_other(comparison: Comparison) -> None:
    profiles = comparison.profiles()
    assert len(profiles) == 3
    for _, by_model in profiles:
        (s, discrete), (s_band, smeared) = by_model["discrete"], by_model["smeared"]
        assert (np.diff(s) >= 0).all() and s[0] == 0 and s[-1] == pytest.approx(25.0)
        assert 0 < s_band[0] < 2.5 and 22.5 < s_band[-1] < 25.0
        assert abs(np.interp(s_band, s, discrete) - smeared).max() < 0.02 * discrete.max() + 3e-4


def test_files(comparison: Comparison, tmp_path: Path) -> None:
    comparison.save(tmp_path)
    with open(tmp_path / "comparison.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["quantity"] for row in rows] == QUANTITIES
    assert float(rows[0]["discrete"]) == pytest.approx(comparison.discrete.peak_load)
    for name in ("comparison.png", "discrete/curve.png", "smeared/deformed.png", "smeared/frames.pvd", "smeared/scene.toml"):
        assert (tmp_path / name).stat().st_size > 100
    again = run(Scene.load(tmp_path / "smeared" / "scene.toml"))
    np.testing.assert_array_equal(again.history["load"], comparison.smeared.history["load"])
    # the table as it is printed names each quantity once
    text = comparison.summary()
    assert all(sum(line.startswith(name.replace("_", " ")) for line in text.splitlines()) == 1 for name in QUANTITIES[:6])


def test_curves_that_go_back_are_compared_over_the_opening_travelled() -> None:
    scene = block(**{"stage__0__to": [0.03, 0.01, 0.05], "mesh__crack_size": 2.0})
    result = compare(scene)
    assert result.table["curve_distance"]["relative_difference"] < 0.05
    s, gap = result.difference()
    assert s[-1] == pytest.approx(0.03 + 0.02 + 0.04, rel=1e-6)
    assert abs(gap).max() < 0.1 * result.discrete.peak_load


def test_half_a_body_stands_for_the_whole_in_both_models(beam: Scene) -> None:
    """Half the band mirrors itself: the meshes of the bulk differ, by .1 % in what they give."""
    half, whole = (compare(beam.with_(**{"model.half": half, "stage.0.to": 0.04})) for half in (True, False))
    assert half.smeared.scene.model.half and half.smeared.total_dofs < 0.6 * whole.smeared.total_dofs
    for one, other in zip(half.runs.values(), whole.runs.values(), strict=True):
        assert one.peak_load == pytest.approx(other.peak_load, rel=3e-3)
        assert one.dissipated_energy == pytest.approx(other.dissipated_energy, rel=3e-3)


def test_models_that_lie_far_apart_do_not_check_each_other() -> None:
    """A slanted crack of the block, its planes across the pull or on the path."""
    path = [[-20.0, -14.0], [20.0, 14.0]]
    scene = block(specimen__crack=path, stage__0__to=0.03, **{"output__frames": 0})
    apart = compare(scene.with_(**{"band.planes": "principal"}))
    assert abs(apart.table["dissipated"]["relative_difference"]) > 0.05
    assert apart.notes[0].startswith("the comparison is void, smeared over discrete ")
    assert apart.notes[0].endswith(": the planes of the band depart from the path by 35 degrees in the mean")
    assert apart.notes[0] in apart.summary()
    assert not any("void" in note for note in compare(scene).notes)
    # the first damage at a notch's tip is no measure
    early = compare(Scene.load("notched-beam").with_(**{"stage.0.to": 0.004, "stage.0.steps": 4, "output.frames": 0}))
    assert abs(early.table["dissipated"]["relative_difference"]) > 0.05
    assert not any("void" in note for note in early.notes)


def test_along_paths_a_kinked_path() -> None:
    lines = [[(0.0, 0.0), (3.0, 0.0), (3.0, 4.0)]]
    points = np.array([[1.0, 0.1], [3.2, 2.0], [3.0, 4.0], [-1.0, 0.0]])
    np.testing.assert_allclose(along_paths(points, lines), [1.0, 5.0, 7.0, 0.0])
    np.testing.assert_allclose(along_paths(np.array([[0.0, 1.0], [0.1, 4.0]]), []), [0.0, 3.0])


@pytest.mark.long
def test_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    changes = ["mesh.crack_size=5.0", "mesh.far_size=12.0", "stage.0.steps=8", "output.frames=1"]
    arguments = ["compare", "notched-beam", "-o", str(tmp_path / "out")]
    assert main([*arguments, *(word for change in changes for word in ("--set", change))]) == 0
    out = capsys.readouterr().out
    assert "discrete     smeared  difference" in out and "curve distance" in out
    assert (tmp_path / "out" / "comparison.png").exists()
    assert len((tmp_path / "out" / "smeared" / "history.csv").read_text().splitlines()) == 10


@pytest.mark.long
def test_a_run_that_stops_is_compared_as_far_as_it_came(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A load beyond the peak has no equilibrium in either model."""
    changes = ["mesh.crack_size=12.5", "mesh.far_size=12.5", "stage.0.control=load", "stage.0.to=1600.0", "stage.0.steps=1"]
    arguments = ["compare", "notched-beam", "-o", str(tmp_path / "out")]
    assert main([*arguments, *(word for change in changes for word in ("--set", change))]) == 1
    out = capsys.readouterr().out
    assert "discrete: stopped: " in out and "smeared: stopped: " in out and "peak (N)" in out
    assert (tmp_path / "out" / "comparison.csv").exists()


# -- two defaults of the band, and what they are for ---------------------------------------------


def fine_beam(**changes: object) -> tuple[float, float]:
    """Peak and energy of the smeared beam with elements of 1 mm."""
    scene = Scene.load("notched-beam").with_(**{"material.ft": 3.6, "output.frames": 0, "model.kind": "smeared"})
    h = run(scene.with_(**changes)).history
    return h["load"].max(), float(trapezoid(np.r_[0, h["load"]], np.r_[0, h["opening"]]))


@pytest.mark.long
def test_points_off_the_centre_line_lock_the_band(monkeypatch: pytest.MonkeyPatch) -> None:
    """With planes on the path the energy of wide elements, across the principal stress peak and energy of narrow ones too."""
    wide, principal = {"mesh.crack_size": 5.0, "band.width": 5.0}, {"band.planes": "principal"}
    (_, energy), (peak, _) = fine_beam(**wide), fine_beam(**principal)
    monkeypatch.setattr("cohesive.model.band.centre_rule", lambda kind: ELEMENTS["quad"].rule)
    assert fine_beam(**wide)[1] > 1.02 * energy
    assert fine_beam(**principal)[0] > 1.03 * peak


@pytest.mark.slow
def test_a_new_plane_turns_at_will_where_the_principal_stresses_are_alike() -> None:
    energies = [fine_beam(**{"stage.0.steps": steps})[1] for steps in (60, 120)]
    assert energies[1] == pytest.approx(energies[0], rel=2e-3)
    assert fine_beam(**{"stage.0.steps": 120, "band.planes": "principal"})[1] > 1.02 * energies[1]


# -- the examples, small ------------------------------------------------------------------------


@pytest.mark.long
def test_shear_scaling_makes_meshes_agree(tmp_path: Path) -> None:
    result = sandwich_panel.main(sizes=(100.0, 50.0), plot=tmp_path / "panel.png")
    assert result["spread with scaling"] < 0.02
    assert result["spread without scaling"] > 0.3
    assert result["discrete against the finest band"] < 0.05
    assert (tmp_path / "panel.png").stat().st_size > 1e4


@pytest.mark.long
def test_discrete_and_smeared_close_in(tmp_path: Path) -> None:
    rows = discrete_and_smeared.main((5.0, 1.0, 0.2), (5.0, 2.5), steps=30, plot=tmp_path / "both.png")
    discrete, smeared = ([row.peak for row in rows[model]] for model in ("discrete", "smeared"))
    assert sorted([*discrete, *smeared[::-1]]) == [*discrete, *smeared[::-1]]  # one from below, one from above
    assert smeared[-1] / discrete[-1] - 1 < 0.02
    assert abs(rows["smeared"][-1].energy / rows["discrete"][-1].energy - 1) < 0.02
    assert rows["smeared"][-1].lateral < rows["smeared"][0].lateral
    assert (tmp_path / "both.png").stat().st_size > 1e4
