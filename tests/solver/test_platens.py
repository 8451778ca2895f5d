"""Platens that move both ways, hold, turn, or feel a spring."""

from __future__ import annotations

import numpy as np
import pytest

from cohesive import Scene, SceneError, run
from tests.builders import plate, run_and_keep


@pytest.mark.parametrize("model", ["discrete", "smeared"])
def test_the_ratio_is_that_of_the_platens_motion(model: str) -> None:
    result, states, built = run_and_keep(plate(**{"stage.1.to": 0.2, "stage.1.step": 0.02}), model)
    drives = np.array([state.v[built.problem.drives] for state in states])
    first = np.flatnonzero(result.history["opening"] <= 0.025 * (1 + 1e-9))[-1]
    moved = np.diff(drives[first:], axis=0)
    np.testing.assert_allclose(moved[:, 0] / moved[:, 1], np.tan(np.radians(40.0)), rtol=1e-6)
    np.testing.assert_allclose(drives[: first + 1, 1], 0.0, atol=1e-15)  # held across, before
    # across the drive a reaction does no work: the load is the force along it
    assert result.energy_error < 2e-2


@pytest.mark.parametrize("model", ["discrete", pytest.param("smeared", marks=pytest.mark.long)])
def test_a_platen_free_across_feels_its_spring_only(model: str) -> None:
    scene = Scene.load("push-off").with_(
        **{"mesh.crack_size": 50.0, "mesh.far_size": 60.0, "stage.1.to": 1.0, "stage.1.steps": 20, "output.frames": 0}
    )
    result, states, built = run_and_keep(scene.with_(**{"solver.tol": 1e-9}), model)
    h = result.history
    sheared = h["driven"][1:] < h["driven"][:-1]
    first = int(np.flatnonzero(sheared)[0]) + 1
    normal = np.array([state.v[built.problem.drives[0]] for state in states[first - 1 :]])
    area = 300.0 * 120.0
    # the bars take over the force at the end of the first stage, and carry the mean normal traction of the plane
    tolerance = 1e-6 if model == "discrete" else 0.01
    expected = h["load"][first - 1] - 1e5 * (normal[1:] - normal[0])
    np.testing.assert_allclose(h["stress_n"][first:] * area, expected, atol=tolerance * 2e5)
    assert normal[-1] > normal[0] + 0.1  # it dilates
    assert result.energy_error < 1e-2
    stiff = run(scene.with_(**{"specimen.restraint": 1e6}), model)
    assert stiff.history["stress_n"][-1] < h["stress_n"][-1] and stiff.history["stress_s"][-1] > h["stress_s"][-1]


def test_springs_take_over_the_force_that_holds_the_platen() -> None:
    """Elastic, pulled with 40 kN: nothing jumps when the springs take over, and their preload is not work of the run."""
    scene = Scene.load("push-off").with_(**{"mesh.crack_size": 50.0, "mesh.far_size": 60.0, "output.frames": 0})
    stages = [
        {"control": "load", "to": 4e4, "steps": 4},
        {"control": "driven", "angle": 90.0, "hold": False, "to": 0.005, "steps": 4},
    ]
    result = run(scene.with_(stage=stages))
    h, area = result.history, 300.0 * 120.0
    assert result.steps == 8 and h["dissipated"][-1] == 0
    np.testing.assert_allclose(h["stress_n"][4:] * area, 4e4, rtol=1e-3)  # the bars give way by micrometres only
    assert result.energy_error < 1e-6


def test_hinged_platens_turn_and_fixed_ones_do_not() -> None:
    """A plate notched from one side: free to turn, it opens as in eccentric tension."""
    scene = Scene.load("notched-tension").with_(
        **{
            "mesh.crack_size": 5.0,
            "mesh.far_size": 20.0,
            "specimen.notches": "single",
            "stage": [{"control": "load", "to": 500.0, "steps": 1}],
        }
    )
    turned = {}
    for platens in ("fixed", "hinged"):
        result = run(scene.with_(**{"specimen.platens": platens, "solver.tol": 1e-10}))
        u = result.frame(1).displacement
        top = result.fields.mesh.sets["top"]
        x, uy = result.fields.mesh.points[top, 0], u[top, 1]
        slope, mean = np.polyfit(x, uy, 1)
        np.testing.assert_allclose(uy, mean + slope * x, atol=1e-12)  # rigid
        np.testing.assert_allclose(u[top, 0], 0.0, atol=1e-15)
        assert mean == pytest.approx(result.history["driven"][1], rel=1e-9)
        turned[platens] = slope
    assert abs(turned["fixed"]) < 1e-15
    assert turned["hinged"] < -1e-6  # the notched side, on the left, opens more


def test_half_of_a_plate_with_hinged_platens_is_refused() -> None:
    with pytest.raises(SceneError, match=r"model.half = true"):
        Scene.load("notched-tension").with_(**{"specimen.platens": "hinged", "model.half": True})


def test_the_load_is_that_along_the_drive_when_the_direction_changes() -> None:
    """Turning the drive by 0 degrees changes nothing; by 90 the load of the normal motion becomes a reaction."""
    scene = Scene.load("sandwich-panel").with_(**{"mesh.crack_size": 100.0, "mesh.far_size": 100.0, "output.frames": 0})
    _, states, built = run_and_keep(scene.with_(**{"stage.1.steps": 5, "stage.0.steps": 20}))
    before = states[20]
    same = built.problem.driven(0.0).with_driven_load(before)
    assert same.load == pytest.approx(before.load, rel=1e-6)
    across = built.problem.driven(90.0).with_driven_load(before)
    assert abs(across.load) < 1e-3 * before.load and across.driven == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("model", ["discrete", "smeared"])
def test_a_platen_sheared_at_constant_opening(model: str) -> None:
    changes = {"mesh.crack_size": 100.0, "mesh.far_size": 100.0, "stage.0.steps": 20, "stage.1.steps": 10, "output.frames": 0}
    scene = Scene.load("sandwich-panel").with_(**changes, **{"model.kind": model, "solver.tol": 1e-11})
    result, states, built = run_and_keep(scene)
    h, last = result.history, states[-1]
    drives = [state.v[built.problem.drives] for state in (states[20], last)]
    np.testing.assert_allclose(drives, [[0.1, 0.0], [0.1, 0.2]], atol=1e-12)  # normal and shear motion of the platen
    assert h["driven"][20] == pytest.approx(0.1) and h["driven"][-1] == pytest.approx(0.2)
    # the load is the force along the drive: the mean traction on the crack times its area
    area = 400.0 * 100.0
    np.testing.assert_allclose(h["load"][1:21], area * h["stress_n"][1:21], rtol=1e-6 if model == "discrete" else 2e-2)
    np.testing.assert_allclose(h["load"][21:], area * h["stress_s"][21:], atol=2e-2 * h["load"][21:].max())
    assert result.energy_error < 2e-2


def test_an_oblique_platen_moves_along_its_angle() -> None:
    scene = Scene.load("sandwich-panel").with_(
        **{
            "mesh.crack_size": 100.0,
            "mesh.far_size": 100.0,
            "stage": [{"control": "driven", "to": 0.05, "steps": 10, "angle": 30}],
        }
    )
    result, states, built = run_and_keep(scene)
    moved = np.array([state.v[built.problem.drives] for state in states])
    t = np.radians(30)
    np.testing.assert_allclose(moved, result.history["driven"][:, None] * [np.cos(t), np.sin(t)], atol=1e-15)
    assert result.energy_error < 2e-2
