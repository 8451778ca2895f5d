"""The whole chain, against closed forms and invariants."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from numpy.typing import NDArray

from cohesive import NotConverged, Result, Scene, run
from cohesive.model.build import build
from cohesive.model.interface import default_width
from cohesive.results.report import warnings
from cohesive.solver.newton import advance
from meshing import MeshSizes, SingleCrack
from tests.builders import block

Array = NDArray[np.float64]

COMPARED = ("load", "opening", "sliding", "driven", "work", "elastic", "stored", "dissipated", "contact_work")


def same(a: Result, b: Result, tolerance: float, names: tuple[str, ...] = COMPARED) -> None:
    """Equal histories, in parts of the largest value of the same unit."""
    lengths, energies = ("opening", "sliding", "driven"), ("work", "elastic", "stored", "dissipated", "contact_work")
    for name in names:
        unit = next((group for group in (lengths, energies) if name in group), (name,))
        scale = max(abs(a.history[other]).max() for other in unit)
        np.testing.assert_allclose(a.history[name], b.history[name], atol=tolerance * scale, rtol=0, err_msg=name)


@pytest.mark.parametrize(("shape", "order"), [("triangle", 1), ("triangle", 2), ("quad", 1), ("quad", 2)])
@pytest.mark.parametrize("rotation", [0.0, 30.0, 45.0, 90.0, 137.2])
def test_block_in_tension_is_the_law_in_series_with_elasticity(rotation: float, shape: str, order: int) -> None:
    to = [0.02, 0.005, 0.05, 0.0]  # opened, nearly closed, opened further, closed
    result = run(block(specimen__rotation=rotation, mesh__shape=shape, mesh__order=order, **{"stage__0__to": to}))
    law, area = result.problem.point_law.plane, 400.0
    Z = np.zeros(1)
    for u, load, driven, sliding in zip(*(result.history[k] for k in ("opening", "load", "driven", "sliding")), strict=True):
        traction, Z = law.traction(np.array([[u, 0.0]]), Z)
        stress = traction[0, 0]
        assert load == pytest.approx(area * stress, rel=1e-6, abs=1e-6 * area)
        assert driven == pytest.approx(u + stress * 40.0 / law.concrete.E, rel=1e-6, abs=1e-9)
        assert abs(sliding) < 1e-9


def as_file(tmp_path: Path, mesh: meshio.Mesh, turn: Array, name: str, crack: list[list[float]], **changes: Any) -> Scene:
    """A scene on a mesh that is turned with everything that belongs to it."""
    plain = meshio.Mesh(np.column_stack([mesh.points @ turn.T, np.zeros(len(mesh.points))]), mesh.cells[:-1])
    plain.write(tmp_path / name)
    data = {
        "specimen": {
            "kind": "mesh", "file": name, "thickness": 10.0, "crack": [(turn @ p).tolist() for p in np.array(crack)],
            "supports": [
                {"at": (turn @ [x, -15.0]).tolist(), "direction": (turn @ d).tolist()}
                for x, d in ((-20.0, [1.0, 0.0]), (-20.0, [0.0, 1.0]), (20.0, [0.0, 1.0]))
            ],
            "drive": {"at": (turn @ [-20.0, 15.0]).tolist(), "direction": (turn @ [-0.6, 0.8]).tolist()},
            "gauge_minus": (turn @ [-20.0, -15.0]).tolist(), "gauge_plus": (turn @ [-20.0, 15.0]).tolist(),
        },
        "material": {"preset": "reinhardt"},
        "interface": {"width": 0.3},
        "solver": {"tol": 1e-11},
        "stage": [{"control": "opening", "to": [0.1, 0.06], "steps": 8}],
    }  # fmt: skip
    return Scene(data, tmp_path).with_(**changes)


@pytest.mark.parametrize("angle", [30.0, 45.0, 90.0, 137.2])
def test_turning_the_whole_scene_changes_nothing(tmp_path: Path, angle: float) -> None:
    path = [[-20.0, 0.0], [0.0, 4.0], [10.0, 0.0]]  # a kinked crack with its tip inside
    specimen = SingleCrack(40.0, 30.0, 10.0, crack=path)
    mesh = specimen.mesh(MeshSizes(5.0, 8.0))
    # the uncut mesh: copies given back their first number
    original = mesh.point_data["original"]
    mesh.cells[0].data[:] = original[mesh.cells[0].data]
    mesh.points = mesh.points[: original.max() + 1]
    t = np.radians(angle)
    turn = np.array([[np.cos(t), -np.sin(t)], [np.sin(t), np.cos(t)]])
    straight = run(as_file(tmp_path, mesh, np.eye(2), "straight.vtu", path))
    turned = run(as_file(tmp_path, mesh, turn, "turned.vtu", path))
    assert straight.dissipated_energy > 1.0
    same(straight, turned, 1e-8)


def test_condensed_and_full_newton_agree(beam: Scene) -> None:
    exact = beam.with_(**{"solver.tol": 1e-11, "stage.0.to": [0.06, 0.03, 0.1], "specimen.notch_position": 10.0})
    condensed = run(exact.with_(**{"solver.reduction": "condensed"}))
    full = run(exact.with_(**{"solver.reduction": "none"}))
    assert condensed.active_dofs < 60 < condensed.total_dofs == full.total_dofs == full.active_dofs
    same(condensed, full, 1e-8)
    for row in (3, -1):
        a, b = condensed.frame(row), full.frame(row)
        np.testing.assert_allclose(a.displacement, b.displacement, atol=1e-8 * abs(b.displacement).max())


@pytest.mark.parametrize("kind", ["notched-beam", "notched-tension"])
def test_half_of_a_symmetric_specimen_stands_for_the_whole(kind: str) -> None:
    scene = Scene.load(kind).with_(**{"mesh.crack_size": 1.25, "mesh.far_size": 4.0})
    scene = scene.with_(stage=[{"control": "opening", "to": 0.06, "steps": 20}])
    whole, half = run(scene), run(scene.with_(**{"model.half": True}))
    assert half.total_dofs < 0.6 * whole.total_dofs
    # two meshes: the difference is the discretization's
    same(whole, half, 5e-3, ("load", "opening", "driven", "work", "dissipated", "elastic"))
    assert half.peak_load == pytest.approx(whole.peak_load, rel=2e-3)
    assert half.full_energy == pytest.approx(whole.full_energy, rel=1e-12)


def test_half_is_exact_on_the_mirrored_mesh() -> None:
    """A bar in tension: uniform, so that the half's numbers are the whole's on any mesh."""
    bar = {
        "specimen": {"kind": "notched-tension", "length": 40.0, "width": 20.0, "thickness": 10.0, "notch": 0.0},
        "mesh": {"crack_size": 5.0, "far_size": 5.0},
        "material": {"E": 30e3, "nu": 0.0, "ft": 3.0, "Gf": 0.1},
        "solver": {"tol": 1e-11},
        "stage": [{"control": "driven", "to": 0.06, "steps": 12}],
    }
    whole, half = run(Scene(bar)), run(Scene(bar).with_(**{"model.half": True}))
    same(whole, half, 1e-8)


def pulled(steps: int, tol: float = 1e-4) -> Scene:
    """The notched plate until every point of the ligament is past 1.4 Zm."""
    scene = Scene.load("notched-tension").with_(**{"mesh.crack_size": 2.0, "mesh.far_size": 12.0, "solver.tol": tol})
    Zm = scene.material.Zm
    stages = [{"control": "opening", "to": 0.02, "steps": steps}, {"control": "opening", "to": 1.6 * Zm, "steps": 2 * steps}]
    return scene.with_(stage=stages)


def test_notched_plate_dissipates_the_fracture_energy() -> None:
    result = run(pulled(40))
    state = result.states[-1]
    assert state.cracks.deformation[:, 0].min() > 1.4 * result.scene.material.Zm
    assert abs(state.cracks.stress).max() < 1e-3 * result.scene.material.ft
    assert result.dissipated_energy == pytest.approx(result.full_energy, rel=0.01)
    assert result.dissipated_energy < result.full_energy  # the tail is not cut off


def test_energy_balance_closes_as_the_steps_shrink() -> None:
    errors = [run(pulled(steps)).energy_error for steps in (20, 40, 80)]
    assert errors[1] < 1e-3
    assert errors[2] < 0.5 * errors[1] < 0.25 * errors[0]  # at least first order, through the peak's corner


def test_pure_shear_without_contact() -> None:
    width = 0.3
    scene = block(
        specimen__faces="clamped", specimen__drive_angle=90.0, interface__width=width, material__u_phi0=-100.0,
        solver__tol=1e-8, **{"stage__0": {"control": "sliding", "to": 1.6, "steps": 100}},
    )  # fmt: skip
    result = run(scene)
    m = scene.material
    assert abs(result.history["opening"]).max() < 1e-9
    GIIf = m.r_sigma**2 * (m.E / m.G) * (m.Gf + m.ft**2 * width / (2 * m.E))
    assert result.dissipated_energy == pytest.approx(GIIf * 400.0, rel=1e-3)  # e^-7 is left at s = 1.6 mm
    assert result.history["load"].max() <= m.r_sigma * m.ft * 400.0


def test_a_crack_that_opens_under_dissipation_control_snaps_back() -> None:
    """A long bar stores more than the crack takes: load and driven motion both fall after the peak."""
    scene = block(specimen__height=1200.0, specimen__width=20.0, mesh__far_size=40.0, mesh__crack_size=4.0)
    scene = scene.with_(stage=[{"control": "dissipation", "to": 20.0, "steps": 40}])
    result = run(scene)
    h = result.history
    assert h["dissipated"][-1] == pytest.approx(20.0, rel=1e-9)
    assert np.diff(h["driven"]).min() < -1e-3
    assert result.energy_error < 1e-3
    law, Z = result.problem.point_law.plane, np.zeros(1)
    for u, load in zip(h["opening"], h["load"], strict=True):
        traction, Z = law.traction(np.array([[u, 0.0]]), Z)
        assert load == pytest.approx(200.0 * traction[0, 0], rel=0.05)  # on the mean jump: the bar bends while it snaps back


@pytest.mark.parametrize("model", ["discrete", "smeared"])
def test_a_bar_that_snaps_back_under_its_platen_is_followed_back(model: str) -> None:
    """The same bar pulled by its platen: at the peak its next equilibrium lies behind it, and dissipation leads there."""
    scene = block(specimen__height=1200.0, specimen__width=20.0, mesh__far_size=40.0, mesh__crack_size=4.0, model__kind=model)
    result = run(scene.with_(stage=[{"control": "driven", "to": 0.3, "steps": 40}]))
    h = result.history
    assert h["driven"][-1] == pytest.approx(0.3, rel=1e-4)
    back = [note for note in result.notes if "driven goes back from" in note]
    assert len(back) == 1 and not any("snaps" in note for note in result.notes)
    start, end = (float(word) for word in back[0].replace(",", "").split() if word[:2] == "0.")
    ft_times_length = result.scene.material.ft * 1200.0 / result.scene.material.E
    assert start == pytest.approx(ft_times_length, rel=2e-3)
    assert end == pytest.approx(h["driven"][h["dissipated"] > 1.0].min(), rel=1e-4)
    assert end < 0.85 * start
    assert h["residual"].max() < 1e-9  # tolerance 1e-11, and the rounding of a bar that long
    # every step is an equilibrium: nothing is set free but what the trapezoidal rule of the work misses in large steps
    assert result.energy_error < 0.02


@pytest.mark.parametrize("steps", [10, 40])
def test_a_step_that_jumps_over_a_snap_back_is_not_taken(steps: int) -> None:
    """An inclined band in a tall block has an equilibrium with no load a step further, and Newton's method finds it."""
    scene = Scene.load("single-crack").with_(
        **{"specimen.height": 1200.0, "model.kind": "smeared", "stage": [{"control": "driven", "to": 0.3, "steps": steps}]}
    )
    result = run(scene)
    assert any("driven goes back from 0.090" in note for note in result.notes)
    assert result.energy_error < 0.02  # of the trapezoidal rule; 0.2 to 0.4 where it is jumped over


@pytest.mark.parametrize(
    ("name", "value"),
    [("load_ratio", 0.6), ("opening", 0.01), ("opening", 0.015), ("dissipated", 5.0), ("dissipated", 10.0)],
)
def test_an_event_on_the_way_back_ends_the_stage_there(name: str, value: float) -> None:
    """Also where a step stops just short of it."""
    scene = block(specimen__height=3000.0, specimen__width=20.0, mesh__far_size=40.0, mesh__crack_size=4.0)
    scene = scene.with_(stage=[{"control": "driven", "to": 0.5, "steps": 20, "until": {name: value}}])
    result = run(scene)
    h = result.history
    last = h["load"][-1] / h["load"].max() if name == "load_ratio" else h[name][-1]
    assert last == pytest.approx(value, rel=2e-3)
    assert h["driven"][-1] < h["driven"].max()
    assert f"stage 1 ended where {name} = {value:g}" in result.notes
    assert not any("snaps" in note for note in result.notes)


def test_nothing_is_followed_back_where_a_block_is_pushed_or_unloaded(monkeypatch: pytest.MonkeyPatch) -> None:
    """A failure there is not that of a crack which sets energy free: dissipation lies the other way."""
    from cohesive.solver import snap as loading

    def fail(problem: Any, start: Any, control: str, *rest: Any, **more: Any) -> Any:
        if control == "driven" and start.driven <= -0.002:
            raise NotConverged("simulated")
        return advance(problem, start, control, *rest, **more)

    advance = loading.advance
    monkeypatch.setattr(loading, "advance", fail)
    monkeypatch.setattr(loading, "snap_through", fail)
    with pytest.raises(NotConverged, match="simulated") as stopped:
        run(block(stage=[{"control": "driven", "to": -0.02, "steps": 8}]))
    driven = stopped.value.result.history["driven"]  # type: ignore[attr-defined]
    assert driven.max() < 0


def test_work_that_is_not_accounted_for_is_a_warning() -> None:
    result = run(block(stage=[{"control": "opening", "to": 0.2, "steps": 1}]))
    assert result.energy_error > 0.05
    assert any("% of the work are unaccounted for" in note for note in warnings(result))


def test_load_control_up_and_down() -> None:
    result = run(block(stage=[{"control": "load", "to": [1000.0, 200.0, -800.0], "steps": 4}]))
    assert result.history["load"][-1] == pytest.approx(-800.0)
    assert result.dissipated_energy == 0.0
    stiffness = result.history["load"] / result.history["driven"]
    np.testing.assert_allclose(stiffness, stiffness[0], rtol=1e-8)


@pytest.mark.parametrize("width", [0.05, 2.0, 60.0])
def test_a_crack_slammed_shut_in_one_step(width: float) -> None:
    scene = block(interface__width=width, solver__tol=1e-4)
    stages = [{"control": "opening", "to": 0.1, "steps": 20}, {"control": "load", "to": -4000.0, "steps": 1}]
    result = run(scene.with_(stage=stages))
    assert result.history["load"][-1] == pytest.approx(-4000.0, rel=1e-6)
    assert result.history["iterations"][20:].max() <= 12


def test_until_ends_a_stage_where_it_says() -> None:
    stages = [
        {"control": "opening", "to": 0.1, "steps": 25, "until": {"load_ratio": 0.5}},
        {"control": "opening", "to": 0.0, "steps": 10, "until": {"load": -300.0}},
    ]
    result = run(block(stage=stages))
    h = result.history
    turn = int(h["opening"].argmax())
    assert h["load"][turn] == pytest.approx(0.5 * result.peak_load, rel=1e-3)
    assert h["load"][-1] == pytest.approx(-300.0, rel=1e-3)


def test_a_separated_body_ends_the_run_and_says_so() -> None:
    Zm = block().material.Zm
    result = run(block(stage=[{"control": "opening", "to": 100 * Zm, "steps": 200}]))
    assert "run through" in result.notes[-1]
    assert result.history["opening"][-1] < 20 * Zm
    assert np.isfinite(result.history["load"]).all()


def test_a_crack_that_carries_nothing_for_a_moment_is_not_separated() -> None:
    stages = [{"control": "opening", "to": 0.05, "steps": 5}, {"control": "load", "to": 0.0, "steps": 5}]
    result = run(block(stage=[*stages, {"control": "opening", "to": 0.1, "steps": 5}]))
    assert result.history["opening"][-1] == pytest.approx(0.1)
    assert not result.notes


def test_steps_are_cut_and_recover(beam: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """One huge step far beyond the peak, in few iterations: whatever it takes, the end is that of small steps."""
    fine = run(beam.with_(**{"stage.0.steps": 40, "stage.0.to": 0.1}))
    monkeypatch.setattr("cohesive.solver.newton.MAX_ITERATIONS", 4)
    coarse = run(beam.with_(**{"stage.0.steps": 4, "stage.0.to": 0.1}))
    assert coarse.history["cuts"].sum() >= 2
    assert (np.diff(coarse.history["opening"]) > 0).all()
    assert coarse.history["opening"][-1] == pytest.approx(0.1, rel=1e-6)
    assert coarse.history["load"][-1] == pytest.approx(fine.history["load"][-1], rel=1e-3)
    # a rejected step leaves no damage behind
    assert coarse.history["dissipated"][-1] == pytest.approx(fine.history["dissipated"][-1], rel=5e-3)


@pytest.mark.parametrize("tol", [1e-2, 1e-4, 1e-6])
def test_dissipation_stages_end_at_their_targets(beam: Scene, tol: float) -> None:
    stages = [{"control": "dissipation", "to": [20.0, 40.0], "steps": 20}]
    result = run(beam.with_(**{"solver.tol": tol}).with_(stage=stages))
    assert result.dissipated_energy == pytest.approx(40.0, abs=3 * tol)
    assert np.diff(result.history["dissipated"]).min() > 0.4  # whole or halved steps of 1 N mm, no step for a rest within tol


def test_reversals_start_small_whatever_controls_them() -> None:
    stages = [{"control": "opening", "to": 0.08, "steps": 8}, {"control": "driven", "to": 0.04, "steps": 8}]
    driven = run(block(stage=stages)).history["driven"]
    assert driven[8] - driven[7] == pytest.approx((0.04 - driven[7]) / 8 / 4, rel=1e-6)


def test_energy_balance_holds_through_contact() -> None:
    to = [0.08, -0.004, 0.08]
    result = run(block(specimen__angle=20.0, mesh__crack_size=4.0, stage=[{"control": "driven", "to": to, "steps": 150}]))
    h = result.history
    assert abs(h["contact_work"]).max() > 0.02 * h["work"].max()
    assert result.energy_error < 1e-3


def test_the_line_search_is_needed_and_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    """Slammed shut to -100 MPa, where the smoothed contact is steepest: no cut with it, cuts or failure without."""
    scene = block(interface__width=0.05, solver__tol=1e-4)
    stages = [{"control": "opening", "to": 0.1, "steps": 20}, {"control": "load", "to": -40e3, "steps": 1}]
    assert run(scene.with_(stage=stages)).history["cuts"].sum() == 0
    monkeypatch.setattr(
        "cohesive.solver.newton._search", lambda at, now, step: (at(now.v + step[:-1], now.load + step[-1]), 1.0)
    )
    with pytest.raises((AssertionError, NotConverged)):
        assert run(scene.with_(stage=stages)).history["cuts"].sum() == 0


def test_added_compliance_of_a_block_is_the_width_over_its_height() -> None:
    result = run(block(stage=[{"control": "driven", "to": 1e-4, "steps": 1}]))
    assert result.added_compliance() == pytest.approx(0.3 / 40.0, rel=1e-4)  # the rigid crack plane is 1e6 times stiffer


def test_the_gauge_measures_what_the_crack_does() -> None:
    """Far beyond its strength a block slides and opens as its crack does: gauge and mean jump agree in sign and size."""
    stages = [{"control": "driven", "to": 0.3, "steps": 30}]
    shear = {"specimen__faces": "clamped", "specimen__drive_angle": 60.0, "specimen__rotation": 20.0}
    jump, gauge = (run(block(**shear, specimen__gauge=g, stage=stages, solver__tol=1e-6)) for g in (0.0, 20.0))
    for name in ("opening", "sliding"):
        assert gauge.history[name][-1] == pytest.approx(jump.history[name][-1], rel=0.1)
    assert abs(jump.history["sliding"][-1]) > 0.1


def test_a_crack_without_an_equilibrium_close_by_snaps_to_the_next_one() -> None:
    """A T-branch sheared open: a narrow plane that is first damaged under compression and shear falls to contact at once."""
    scene = Scene.load("single-crack").with_(
        **{"specimen.crack": [[[-30, 0], [30, 0]], [[0, 0], [0, 30]]], "specimen.drive_angle": 45.0}
    )
    result = run(scene)
    h = result.history
    assert h["driven"].max() == pytest.approx(0.06, rel=1e-4)
    snaps = [note for note in result.notes if "snaps at driven" in note]
    assert 1 <= len(snaps) <= 3
    released = [float(note.split("sets ")[1].split()[0]) for note in snaps]
    assert all(0 < energy < 1e-2 * h["work"].max() for energy in released)  # a snap sets energy free, a little
    assert h["residual"].max() <= scene.solver.tol  # and ends in equilibrium
    assert result.energy_error < 1e-3


def test_an_event_within_a_snap_ends_the_stage_behind_it() -> None:
    scene = Scene.load("single-crack").with_(
        **{"specimen.crack": [[[-30, 0], [30, 0]], [[0, 0], [0, 30]]], "specimen.drive_angle": 45.0}
    )
    whole = run(scene)
    at = int(whole.history["cuts"].argmax())  # no step is cut as often as the one that must snap
    before, after = whole.history["dissipated"][at - 1 : at + 1]
    assert after - before > 0.1
    scene = scene.with_(**{"stage.0.until": {"dissipated": 0.5 * float(before + after)}, "stage.0.to": 0.06})
    result = run(scene)
    assert len([note for note in result.notes if "snaps" in note]) == 1
    assert "stage 1 ended where dissipated" in result.notes[-1]
    assert result.history["dissipated"][-1] == pytest.approx(after, rel=0.05)


def test_a_load_beyond_the_largest_one_fails_and_says_what_helps(beam: Scene) -> None:
    with pytest.raises(NotConverged, match="control = 'opening' or 'driven' goes on past the peak") as caught:
        run(beam.with_(stage=[{"control": "load", "to": 2000.0, "steps": 20}]))
    result = caught.value.result
    assert isinstance(result, Result)
    assert 900 < result.peak_load < 1100


def test_failure_is_named_and_keeps_what_was_computed(beam: Scene, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("cohesive.solver.newton.MAX_ITERATIONS", 2)  # enough for elastic steps only
    monkeypatch.setattr("cohesive.solver.leg.SMALLEST_STEP", 0.3)
    monkeypatch.setattr("cohesive.solver.snap.SNAPPING_STEPS", 0)
    monkeypatch.setattr("cohesive.solver.controls.Measured.is_motion", False)  # no way back by dissipation either
    with pytest.raises(NotConverged, match=r"stage 1: the step from opening = .* failed down to") as caught:
        run(beam.with_(**{"stage.0.steps": 2000}), output=tmp_path)
    result = caught.value.result
    assert isinstance(result, Result)
    rows = (tmp_path / "history.csv").read_text().splitlines()
    assert len(rows) == 1 + len(result.history["step"]) > 2
    result.save(tmp_path)
    assert (tmp_path / "curve.png").stat().st_size > 5000


def test_newton_converges_quadratically(beam: Scene) -> None:
    tails: list[list[float]] = []
    result = run(beam.with_(**{"solver.tol": 1e-11}), on_step=lambda step, row: tails.append(step.equilibrium.residuals))
    checked = 0
    for residuals in tails:
        for before, after in pairwise(residuals[1:]):
            if 1e-6 < before < 1e-3:
                assert after < 1e3 * before**2  # the constant holds over the whole run
                checked += 1
    assert checked >= 10
    assert result.history["residual"].max() < 1e-11


def test_gauss_quadrature_oscillates_and_nodal_does_not(beam: Scene) -> None:
    """Elastic tractions between stiff faces, which in truth fall from the notch tip to the load point."""

    def tractions(quadrature: str) -> Array:
        model = build(beam.with_(**{"interface.width": 0.001, "interface.quadrature": quadrature}))
        state = advance(model.problem, model.problem.initial(), "load", 20.0).state
        _, place = np.unique(model.cracks.where[:, 1].round(9), return_index=True)
        values: Array = state.cracks.stress[place, 0]
        return values

    nodal, gauss = tractions("nodal"), tractions("gauss")
    assert (np.diff(nodal) < 0).all()
    assert (np.diff(gauss) > 0).sum() >= 2
    assert gauss[:4].min() < -0.05 * gauss.max()  # compression right behind the notch tip, where there is tension


def test_width_rule_costs_less_than_one_percent() -> None:
    scene = Scene.load("notched-beam").with_(**{"stage.0.to": 0.04, "stage.0.steps": 80, "solver.tol": 1e-7})
    ruled, thin = run(scene), run(scene.with_(**{"interface.width": 0.01}))
    assert ruled.problem.point_law.plane.width == pytest.approx(default_width(25.0, scene.material)) == pytest.approx(0.25)
    for opening in (0.005, 0.01):
        loads = [np.interp(opening, r.history["opening"], r.history["load"]) for r in (ruled, thin)]
        assert 0 < 1 - loads[0] / loads[1] < 0.01
    assert abs(1 - ruled.peak_load / thin.peak_load) < 0.01
    # the printed rule w = h, against which the small width is chosen
    wide = run(scene.with_(**{"interface.width": "h"}))
    assert np.interp(0.005, wide.history["opening"], wide.history["load"]) < 0.4 * loads[1]
    assert wide.added_compliance() > 1.0 > 0.05 > ruled.added_compliance()


def test_gregoire_beam_meets_the_measured_band() -> None:
    result = run(Scene.load("notched-beam"))
    assert result.reference is not None
    checks = result.reference.check(result.history["opening"], result.history["load"])
    inside = {x: ok for x, _, _, ok in checks}
    assert len(checks) == 13
    assert sum(inside.values()) >= 11
    assert inside[0.005] and inside[0.01]  # the rising branch
    assert all(abs(away) < 0.05 for _, _, away, _ in checks)


def test_plane_strain_is_stiffer(beam: Scene) -> None:
    first = beam.with_(**{"stage.0.to": 0.001, "stage.0.steps": 1})
    stress, strain = run(first), run(first.with_(**{"model.plane": "strain"}))
    ratio = strain.history["load"][0] / stress.history["load"][0]
    assert 1.0 < ratio < 1 / (1 - 0.2**2) + 1e-3


def test_the_body_must_be_held(tmp_path: Path) -> None:
    mesh = SingleCrack(40.0, 30.0, 10.0).mesh(MeshSizes(5.0, 8.0))
    original = mesh.point_data["original"]
    mesh.cells[0].data[:] = original[mesh.cells[0].data]
    mesh.points = mesh.points[: original.max() + 1]
    scene = as_file(tmp_path, mesh, np.eye(2), "loose.vtu", [[-20.0, 0.0], [20.0, 0.0]])
    loose = scene.data["specimen"]["supports"][:1]
    with pytest.raises(ValueError, match="not held"):
        run(scene.with_(**{"specimen.supports": loose}))


@pytest.mark.parametrize("reduction", ["condensed", "none"])
def test_a_plate_on_hinges_comes_apart_at_the_smallest_tolerance(reduction: str) -> None:
    """As nothing but the softening's tail keeps its halves from turning, corrections of 1e-8 to 1e-7 remain, all rounding."""
    scene = Scene.load("notched-tension").with_(
        **{"specimen.platens": "hinged", "mesh.crack_size": 3.0, "mesh.far_size": 12.0, "solver.tol": 1e-11,
           "solver.reduction": reduction, "stage.0.steps": 8, "stage.1.to": 3.0, "stage.1.steps": 20}
    )  # fmt: skip
    result = run(scene)
    assert any("run through" in note for note in result.notes)
    assert result.dissipated_energy == pytest.approx(result.full_energy, rel=1e-6)
