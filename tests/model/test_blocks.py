"""Smeared runs from scene to result: energy whatever the mesh, balance, reduction, reversals, refusals."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest

from cohesive import NotConverged, Result, Scene, run
from cohesive.solver.newton import MAX_ITERATIONS
from meshing import MeshError
from tests.builders import block
from tests.model.test_runs import same

#: the block of conftest: crack area in mm^2
AREA = 400.0


def smeared(**changes: Any) -> Scene:
    return block(model__kind="smeared", **changes)


def excess(scene: Scene, width: float) -> float:
    """Energy beyond Gf that a band of this width dissipates, N/mm."""
    m = scene.material
    return m.ft**2 * width / (2 * m.E)


@pytest.mark.parametrize("shape", ["triangle", "quad"])
@pytest.mark.parametrize("along", [1, 3, 9])
@pytest.mark.parametrize("width", [1.0, 8.0, 30.0])
def test_a_bar_dissipates_the_same_on_any_mesh(width: float, along: int, shape: str) -> None:
    """The row has so many elements along the path; opened to 2 Zm, where e^-10 (1 + 5) of the energy is left."""
    scene = smeared(band__width=width, mesh__crack_size=40.0 / along, mesh__far_size=40.0, mesh__shape=shape)
    Zm = scene.material.Zm
    stages = [{"control": "driven", "to": 0.02 * Zm, "steps": 6}, {"control": "driven", "to": 2.0 * Zm, "steps": 60}]
    result = run(scene.with_(stage=stages))
    assert len(result.model.cracks.weights) == 2 * along
    expected = (scene.material.Gf + excess(scene, width)) * AREA
    assert result.full_energy == pytest.approx(expected, rel=1e-12)
    assert result.dissipated_energy == pytest.approx(expected, rel=0.01)
    # the law of the band's width in series with the rest of the bar, whose lateral motion is free
    law, h = result.problem.point_law.plane.with_width(width), result.history
    Z = np.zeros(1)
    for state, load, driven in zip(result.states, h["load"], h["driven"], strict=True):
        cracks = state.cracks.planes
        if not len(cracks.point):
            assert driven == pytest.approx(load / AREA * 40.0 / scene.material.E, rel=1e-9)
            continue
        u = cracks.jump[:, 0].mean()
        traction, Z = law.traction(np.array([[u, 0.0]]), Z)
        assert load == pytest.approx(AREA * traction[0, 0], abs=1e-6 * AREA)
        assert driven == pytest.approx(u + load / AREA * (40.0 - width) / scene.material.E, abs=1e-8)
    np.testing.assert_allclose(state.cracks.planes.length, width, rtol=1e-9)


@pytest.mark.parametrize(("shape", "order"), [("triangle", 1), ("quad", 1), ("triangle", 2)])
@pytest.mark.parametrize("angle", [0.0, 20.0])
def test_a_turned_block_has_the_same_history(angle: float, shape: str, order: int) -> None:
    """Opened and nearly closed, also on an inclined path, where the crack slides. There gmsh pairs the triangles of a
    turned block to other quadrilaterals: two meshes, whose loads differ by 2e-4."""
    options: dict[str, Any] = {"mesh__shape": shape, "mesh__order": order, "specimen__angle": angle}
    options["stage__0__to"] = [0.05, 0.01]
    straight = run(smeared(**options))
    assert straight.dissipated_energy > 1.0
    assert (abs(straight.history["sliding"]).max() > 1e-3) == (angle > 0)
    for turn in (45.0, 90.0, 137.2):
        other_mesh = angle > 0 and shape == "quad"
        same(straight, run(smeared(specimen__rotation=turn, **options)), 1e-3 if other_mesh else 1e-8)


@pytest.mark.parametrize("to", [[0.12], [0.06, 0.0, 0.12]], ids=["opened", "opened, closed, reopened"])
def test_the_energies_of_a_beam_add_up(beam: Scene, to: list[float]) -> None:
    """The trapezoidal work of a step is second order in it: half the steps, a quarter of the error (2e-4 at 80)."""
    errors = []
    for steps in (40, 80):
        result = run(beam.with_(**{"model.kind": "smeared", "stage.0.to": to, "stage.0.steps": steps}))
        errors.append(result.energy_error)
        assert result.history["opening"][-1] == pytest.approx(to[-1], rel=1e-5)
    assert errors[1] < 5e-4
    assert errors[1] < 0.4 * errors[0]
    if len(to) > 1:
        h = result.history
        assert h["load"][h["opening"] < 0.005].min() < 0  # it takes a push to close rough faces
        closed, opened = (int(i) for i in (h["opening"][60:].argmin() + 60, h["opening"].argmax()))
        assert h["dissipated"][closed] < 1.02 * h["dissipated"][np.flatnonzero(h["opening"] > 0.0599)[0]]
        assert h["dissipated"][opened] > 1.2 * h["dissipated"][closed]


def test_newton_converges_quadratically(beam: Scene) -> None:
    """In the steps that form no plane, by a constant that holds over the whole run (measured: 0.2)."""
    tails: list[list[float]] = []
    planes = [0]

    def keep(step: Any, row: dict[str, float]) -> None:
        planes.append(len(step.equilibrium.state.cracks.planes.point))
        if planes[-1] == planes[-2]:
            tails.append(step.equilibrium.residuals)

    run(beam.with_(**{"solver.tol": 1e-10, "stage.0.steps": 40}), model="smeared", on_step=keep)
    pairs = [(a, b) for residuals in tails for a, b in pairwise(residuals[1:]) if 1e-5 < a < 1e-3]
    assert len(pairs) >= 10 and planes[-1] > 5
    assert all(after < 2.0 * before**2 for before, after in pairs)


def test_condensed_and_full_newton_agree(beam: Scene) -> None:
    exact = beam.with_(**{"solver.tol": 1e-11, "stage.0.to": [0.06, 0.02, 0.09], "stage.0.steps": 10})
    condensed, full = (run(exact.with_(**{"solver.reduction": r}), model="smeared") for r in ("condensed", "none"))
    assert condensed.active_dofs < 0.3 * full.active_dofs == 0.3 * condensed.total_dofs
    same(condensed, full, 1e-8)
    a, b = condensed.frame(-1), full.frame(-1)
    np.testing.assert_allclose(a.displacement, b.displacement, atol=1e-8 * abs(b.displacement).max())
    for one, other in zip(a.stress, b.stress, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-7 * exact.material.ft)


def test_dissipation_control_ends_at_its_targets(beam: Scene) -> None:
    result = run(beam.with_(stage=[{"control": "dissipation", "to": [20.0, 40.0], "steps": 10}]), model="smeared")
    assert result.dissipated_energy == pytest.approx(40.0, abs=1e-3)
    by_opening = run(beam.with_(**{"stage.0.steps": 60}), model="smeared").history
    # two ways through the same equilibria, each a polygon of its own steps
    h = result.history
    between = np.interp(h["opening"], by_opening["opening"], by_opening["load"])
    np.testing.assert_allclose(h["load"][1:], between[1:], atol=0.02 * h["load"].max())


def test_a_long_bar_snaps_back_under_dissipation_control() -> None:
    scene = smeared(specimen__height=1200.0, specimen__width=20.0, mesh__far_size=40.0, mesh__crack_size=20.0, band__width=4.0)
    scene = scene.with_(**{"solver.tol": 1e-8})  # at the onset planes are formed 1e-9 ft late
    result = run(scene.with_(stage=[{"control": "dissipation", "to": 20.0, "steps": 30}]))
    h = result.history
    assert h["dissipated"][-1] == pytest.approx(20.0, rel=1e-9)
    assert np.diff(h["driven"]).min() < -1e-3
    assert result.energy_error < 2e-3


@pytest.mark.parametrize(
    "changes",
    [{}, {"model.plane": "strain"}, {"mesh.order": 2}, {"mesh.shape": "quad"}, {"mesh.shape": "quad", "mesh.order": 2}],
    ids=lambda c: ", ".join(map(str, c.values())) or "as it is",
)
def test_the_beam_agrees_with_the_discrete_crack(beam: Scene, changes: dict[str, Any]) -> None:
    """A band of 2.5 mm, a tenth of the ligament, against the interface: the peak within 1 %, the tail within 5 %, where
    elements of first order are 3 % off and those of second order 1 %."""
    scene = beam.with_(**changes)
    band, crack = run(scene, model="smeared"), run(scene)
    assert band.peak_load == pytest.approx(crack.peak_load, rel=0.01)
    end = [np.interp(0.1, r.history["opening"], r.history["load"]) for r in (band, crack)]
    assert end[0] == pytest.approx(end[1], rel=0.05)
    assert band.dissipated_energy == pytest.approx(crack.dissipated_energy, rel=0.03)


@pytest.mark.parametrize(("shape", "order"), [("triangle", 1), ("quad", 1)])
def test_everywhere_cracks_near_the_path(beam: Scene, shape: str, order: int) -> None:
    scene = beam.with_(**{"band.where": "everywhere", "mesh.shape": shape, "mesh.order": order, "mesh.crack_size": 4.0})
    result = run(scene.with_(**{"stage.0.steps": 12, "stage.0.to": 0.05}), model="smeared")
    state, part = result.states[-1], result.model.cracks
    cracks = state.cracks.planes
    wide = cracks.length * (cracks.strain[:, 0] - cracks.traction[:, 0] / scene.material.E) > 0.005
    assert wide.sum() >= 4
    assert abs(part.where[cracks.point[wide], 0]).max() < 2.5 * 4.0
    assert abs(cracks.rotation[wide, 0, 0]).min() > 0.7  # they stand across the beam, as the notch does
    assert result.energy_error < 0.02
    assert result.history["residual"].max() <= scene.solver.tol
    # triangles of first order lock: the beam is too strong, not too weak
    assert 1000 < result.peak_load < 1500


def test_a_band_slammed_shut_in_one_step() -> None:
    for width in (1.0, 8.0):
        stages = [{"control": "opening", "to": 0.1, "steps": 20}, {"control": "load", "to": -4000.0, "steps": 1}]
        result = run(smeared(band__width=width, solver__tol=1e-4, stage=stages))
        assert result.history["load"][-1] == pytest.approx(-4000.0, rel=1e-6)
        assert result.history["iterations"].max() < MAX_ITERATIONS


def test_a_separated_body_ends_the_run() -> None:
    Zm = block().material.Zm
    result = run(smeared(stage=[{"control": "opening", "to": 100 * Zm, "steps": 200}]))
    assert "run through" in result.notes[-1]
    assert result.history["opening"][-1] < 20 * Zm


def test_the_width_of_the_band_is_warned_of_and_refused() -> None:
    """ft^2 l / 2E over Gf: above 5 % a note, above 100 % no run."""
    limit = 2 * block().material.characteristic_length  # 820 mm
    tall = {"specimen__height": 2000.0, "specimen__width": 900.0, "mesh__far_size": 450.0, "mesh__crack_size": 450.0}
    first = [{"control": "driven", "to": 0.01, "steps": 1}]
    for part, noted in ((0.049, False), (0.051, True), (0.5, True)):
        result = run(smeared(band__width=part * limit, stage=first, **tall))
        assert (len(result.notes) == 1 and f"{100 * part:.1f} % more than Gf" in result.notes[0]) == noted
    with pytest.raises(ValueError, match=r"^band.width = 828.5\d+: .* 201 % of Gf .*expected less than 820.3 mm$"):
        run(smeared(band__width=1.01 * limit, stage=first, **tall))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"specimen.crack": [[0, 25], [0, 60]]}, r"^specimen.crack|^specimen: the crack path ends outside the body"),
        (
            {"specimen.crack": [[86, 0], [86, 50]], "band.width": 5.0},
            r"^band.width = 5: the band leaves the body at \(86, 0\)",
        ),
        ({"specimen.notch_width": 2.0, "band.width": 5.0}, r"^band.width = 5: wider than the notch"),
        ({"band.width": 0.0}, r"^band.width = 0.0: expected a number above 0"),
        ({"band.where": "nowhere"}, r"^band.where = 'nowhere': expected"),
        ({"band.max_cracks": 4}, r"^band.max_cracks = 4: expected 1, 2 or 3"),
        ({"band.threshold_angle": 95.0}, r"^band.threshold_angle = 95.0: expected"),
        ({"model.half": True}, r"^model.half = true: the crack band lies on both sides"),
        ({"stage.0.angle": 90.0}, r"^stage.0.angle = 90.0: this specimen is driven in one direction"),
        ({"specimen.gauge": 0.0, "band.where": "everywhere"}, r"^specimen.gauge: this band has no faces"),
        ({"stage.0.control": "dissipation", "stage.0.to": 500.0}, r"^stage.0.to = 500: the crack can dissipate"),
    ],
)
def test_what_does_not_fit_is_named_in_one_line(beam: Scene, changes: dict[str, Any], message: str) -> None:
    with pytest.raises((ValueError, MeshError), match=message) as caught:
        run(beam.with_(**{"model.kind": "smeared"}).with_(**changes))
    assert "\n" not in str(caught.value)


def test_a_failure_names_where_and_keeps_the_run(beam: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """A local iteration that is cut short after the first steps: a crack plane fails, and the run says at which place."""

    def spoil(step: Any, row: dict[str, float]) -> None:
        if row["step"] == 8:
            monkeypatch.setattr("cohesive.cracks.band_iteration.MAX_ITERATIONS", 0)

    with pytest.raises(
        NotConverged, match=r"stage 1: the step from opening = .* point\(s\) have no solution .* at \("
    ) as caught:
        run(beam, model="smeared", on_step=spoil)
    result = caught.value.result
    assert isinstance(result, Result)
    assert len(result.history["step"]) == 8


def test_a_band_from_a_file_is_that_of_the_specimen(tmp_path: Path) -> None:
    """The row of quadrilaterals of a built-in mesh, written, shuffled and read back."""
    scene = block(mesh__crack_size=4.0, stage__0__steps=5, band__width=2.0)
    mesh = scene.specimen.mesh_band(scene.sizes, 2.0)  # type: ignore[union-attr,arg-type]
    *bulk, (kind, row) = [(cells.type, cells.data) for cells in mesh.cells]
    shuffled = np.roll(row[np.random.default_rng(3).permutation(len(row))], 1, axis=1)
    sets = {"ROW": [*(np.empty(0, dtype=int) for _ in bulk), np.arange(len(row))]}
    points = np.column_stack([mesh.points, np.zeros(len(mesh.points))])
    meshio.Mesh(points, [*bulk, (kind, shuffled)], cell_sets=sets, point_sets=mesh.point_sets).write(tmp_path / "block.inp")
    data = {key: value for key, value in scene.data.items() if key not in ("mesh", "band")}
    data["specimen"] = {
        "kind": "mesh", "file": "block.inp", "thickness": 10.0, "crack": [[-20.0, 0.0], [20.0, 0.0]], "band": "ROW",
        "supports": [{"at": "base", "direction": [0, 1]}, {"at": "base_corner", "direction": [1, 0]}],
        "drive": {"at": "top", "direction": [0, 1]},
    }  # fmt: skip
    mine, own = run(Scene(data, tmp_path), "smeared"), run(scene, "smeared")
    assert mine.model.cracks.width == pytest.approx(2.0) and mine.full_energy == pytest.approx(own.full_energy)
    for name in ("load", "opening", "driven", "dissipated", "stress_n"):
        np.testing.assert_allclose(mine.history[name], own.history[name], rtol=1e-8, err_msg=name)
    # as a region where the crack may form there is no path: no area, and the opening needs a gauge
    data["band"] = {"where": "everywhere"}
    with pytest.raises(ValueError, match=r"specimen.gauge_minus, specimen.gauge_plus: this band has no faces"):
        run(Scene(data, tmp_path), "smeared")
    data["specimen"] |= {"gauge_minus": "base", "gauge_plus": "top"}
    anywhere = run(Scene(data, tmp_path), "smeared")
    assert anywhere.full_energy is None and "dissipated: " in anywhere.summary()


def test_a_band_has_no_width_of_its_own_where_its_elements_give_it() -> None:
    with pytest.raises(ValueError, match=r"band.width = 2: with band.where = 'everywhere' the elements give it"):
        block(band__width=2.0, band__where="everywhere")
