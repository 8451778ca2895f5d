"""Derivatives of the history in parameters."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from cohesive import Scene, SceneError, run, sensitivities
from cohesive.fitting.repeated_run import RepeatedRun
from cohesive.fitting.sensitivities import target_rows, with_all_steps

#: derivatives against central differences of whole runs, over the largest of the column. Runs are converged to 1e-11 of
#: their forces, which a change of 2e-5 turns into some 1e-6; the truncation is (2e-5)^2 times the third derivative
CLOSE = 1e-5

#: columns without those that only rounding fills in mode I
COLUMNS = ("load", "opening", "driven", "work", "elastic", "stored", "dissipated")

LAW = ["material.E", "material.ft", "material.Gf"]
CURVES: dict[str, tuple[Any, list[str]]] = {
    "exponential": ("exponential", LAW),
    "hordijk": ("hordijk", LAW),
    "kink": ({"kink": [0.8, 0.3]}, [*LAW, "material.softening.kink.0", "material.softening.kink.1"]),
    "points": (
        {"points": [[0.0, 3.0], [0.02, 1.2], [0.05, 0.5], [0.15, 0.0]]},
        ["material.E", "material.softening.points.0.1", "material.softening.points.1.0", "material.softening.points.2.1"],
    ),
}
STAGES: dict[str, dict[str, Any]] = {
    "opening": {"control": "opening", "to": 0.08, "steps": 10},
    "cycle": {"control": "opening", "to": [0.03, 0.012, 0.06], "steps": 4},
    "driven": {"control": "driven", "to": 0.1, "steps": 10},
    "dissipation": {"control": "dissipation", "to": 80.0, "steps": 8},
}

#: kg/m^3: that of concrete sixty times over, so that the weight is 40 % of what the small beam bears
HEAVY = 60 * 2400.0


def beam(softening: Any, stage: dict[str, Any], **changes: Any) -> Scene:
    material = {"E": 30e3, "nu": 0.2, "softening": softening}
    if not (isinstance(softening, dict) and "points" in softening):
        material |= {"ft": 3.0, "Gf": 0.1}
    data = {
        "specimen": {
            "kind": "notched-beam", "length": 175.0, "span": 150.0, "depth": 50.0, "thickness": 50.0, "notch": 15.0,
            "gauge": 20.0,
        },
        "mesh": {"crack_size": 5.0, "far_size": 15.0, "shape": "quad"},
        "interface": {"width": 0.2},
        "solver": {"tol": 1e-11},
        "material": material,
        "stage": [stage],
    }  # fmt: skip
    return Scene(data).with_(**changes)


def by_differences(repeated: RepeatedRun, key: str) -> dict[str, Any]:
    """Central differences of whole runs at the targets."""
    stages = with_all_steps(repeated.scene.stages)
    value = repeated.scene.data
    for part in key.split("."):
        value = value[int(part)] if isinstance(value, list) else value[part]
    half = 2e-5 * value
    low, high = (repeated.run({key: value + by}, stages) for by in (-half, half))
    at = target_rows(low), target_rows(high)
    return {name: (high.history[name][at[1]] - low.history[name][at[0]]) / (2.0 * half) for name in COLUMNS}


@pytest.mark.parametrize(
    ("curve", "stage"),
    [(c, "opening") for c in CURVES] + [(c, "cycle") for c in CURVES] + [("kink", "driven"), ("exponential", "dissipation")],
)
def test_derivatives_are_those_of_whole_runs(curve: str, stage: str) -> None:
    softening, keys = CURVES[curve]
    prescribed = {"cycle": "opening", "dissipation": "dissipated"}.get(stage, stage)
    assert_derivatives(beam(softening, STAGES[stage]), keys, {prescribed})


def assert_derivatives(scene: Scene, keys: list[str], prescribed: set[str]) -> None:
    """That they are those of whole runs in all columns, but for what is prescribed."""
    moved = sensitivities(scene, keys)
    assert moved.is_exact
    repeated = RepeatedRun(scene)
    for key in keys:
        wanted = by_differences(repeated, key)
        for name in COLUMNS:
            if name not in prescribed:
                size = abs(wanted[name]).max()
                np.testing.assert_allclose(
                    moved[key][name], wanted[name], atol=CLOSE * size, rtol=0.0, err_msg=f"{key} {name}"
                )


@pytest.mark.parametrize("stage", ["opening", "driven", "dissipation"])
def test_the_state_under_dead_loads_moves_with_the_parameters(stage: str) -> None:
    """Its own derivative starts the run; the density moves nothing else."""
    scene = beam("hordijk", STAGES[stage], **{"material.density": HEAVY})
    assert_derivatives(scene, [*LAW, "material.density"], {{"dissipation": "dissipated"}.get(stage, stage)})


def test_a_weight_that_damages() -> None:
    """The crack begins before the first stage, whose dissipation counts on from there."""
    scene = beam("hordijk", {"control": "dissipation", "to": [20.0, 40.0], "steps": 1}, **{"material.density": 2.0 * HEAVY})
    assert run(scene).history["dissipated"][0] > 0.05  # N mm
    assert_derivatives(scene, [*LAW, "material.density"], {"dissipated"})


def test_a_dissipation_is_prescribed_after_a_motion() -> None:
    stages = [STAGES["opening"] | {"to": 0.02, "steps": 3}, {"control": "dissipation", "to": [40.0, 60.0], "steps": 1}]
    scene = Scene(beam("hordijk", stages[0]).data | {"stage": stages})
    assert_derivatives(scene, LAW, {"opening", "dissipated"})


def test_contact_while_a_crack_closes() -> None:
    scene = beam("hordijk", {"control": "opening", "to": [0.03, 0.001, 0.06], "steps": 4})
    moved = sensitivities(scene, ["material.c_zn"])
    wanted = by_differences(RepeatedRun(scene.with_(**{"material.c_zn": 9.0})), "material.c_zn")
    np.testing.assert_allclose(moved["material.c_zn"]["load"], wanted["load"], atol=CLOSE * abs(wanted["load"]).max())
    assert abs(wanted["load"]).max() > 0.1  # N: the faces do touch


def test_cuts_do_not_move_the_rows() -> None:
    """A dissipation that begins at the onset, and steps that are too large, insert rows; those of the targets stay."""
    scene = beam("exponential", STAGES["dissipation"])
    moved = sensitivities(scene, ["material.Gf"])
    np.testing.assert_allclose(moved.history["dissipated"], np.arange(1, 9) * 10.0, rtol=1e-8)
    assert abs(moved["material.Gf"]["dissipated"]).max() < 1e-6  # what is prescribed


def test_the_smeared_model_is_differenced() -> None:
    scene = beam("exponential", {"control": "opening", "to": 0.03, "steps": 3}, **{"model.kind": "smeared", "interface": {}})
    moved = sensitivities(scene, ["material.Gf"])
    assert not moved.is_exact
    assert moved["material.Gf"]["load"][-1] > 0


@pytest.mark.parametrize("event", [{"until": {"load": 100.0}}, {"unload": {"load": 0.0}}])
def test_events_are_refused(event: dict[str, Any]) -> None:
    with pytest.raises(SceneError, match="moves with the parameters"):
        sensitivities(beam("exponential", STAGES["opening"] | event), ["material.Gf"])


@pytest.mark.parametrize("key", ["stage.0.steps", "stage.0.to", "mesh.crack_size", "solver.tol"])
def test_what_has_no_derivative_is_refused(key: str) -> None:
    with pytest.raises(SceneError, match=f"{key}: the history has no derivative in it"):
        sensitivities(beam("exponential", STAGES["opening"]), [key])


def test_a_key_without_a_number_is_refused() -> None:
    with pytest.raises(SceneError, match=r"material\.softening\.kink\.0: the scene has no number there"):
        sensitivities(beam("exponential", STAGES["opening"]), ["material.softening.kink.0"])
