"""One mesh and one condensation for many materials: the same results as with fresh ones, and what does not fit is refused."""

from __future__ import annotations

import numpy as np
import pytest

from cohesive import Scene, SceneError, prepare, run

from ..builders import assert_same_history

#: coarse, few steps, converged to rounding
TIGHT = {"mesh.crack_size": 5.0, "mesh.far_size": 20.0, "stage.0.to": 0.03, "stage.0.steps": 6, "solver.tol": 1e-11}

#: another material, with another modulus
OTHER = {"material.E": 29000.0, "material.ft": 3.0, "material.Gf": 0.09, "material.softening": "hordijk"}


def beam(**changes: object) -> Scene:
    return Scene.load("notched-beam").with_(**{**TIGHT, **changes})


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"model.kind": "smeared"},
        {"model.half": True},
        {"model.dimension": 3, "mesh.crack_size": 12.5, "mesh.far_size": 25.0, "stage.0.steps": 2},
        {"solver.condensation": "never"},
        {"material.density": 2400.0},
    ],
    ids=["discrete", "smeared", "half", "solid", "whole", "own weight"],
)
def test_another_material_on_a_prepared_mesh_equals_a_fresh_run(changes: dict[str, object]) -> None:
    start = beam(**changes)
    prepared = prepare(start)
    other = start.with_(**OTHER)
    # steps converged to 1e-11, over a stiffness whose rounding a condition of some hundreds magnifies
    assert_same_history(run(other, prepared), run(prepared.scene_of(other)), 1e-9)


def test_runs_leave_nothing_behind_in_what_is_prepared() -> None:
    prepared = prepare(beam())
    first = run(beam(), prepared)
    run(beam(**OTHER), prepared)
    again = run(beam(), prepared)
    for name, column in first.history.items():
        assert name == "wall_time" or np.array_equal(again.history[name], column, equal_nan=True), name


def test_sizes_by_rule_are_those_of_the_start_values() -> None:
    start = Scene.load("notched-beam")
    start = Scene({key: value for key, value in start.data.items() if key not in ("mesh", "reference")})
    prepared = prepare(start.with_(**{"stage.0.steps": 2, "stage.0.to": 0.01}))
    brittle = start.with_(**{"material.ft": 6.0, "material.Gf": 0.01, "stage.0.steps": 2, "stage.0.to": 0.01})
    assert brittle.sizes is not None and prepared.crack_size is not None
    assert brittle.sizes.crack_size < 0.9 * prepared.crack_size  # by the rule it would have a mesh of its own
    result = run(brittle, prepared)
    assert result.scene.data["mesh"] == {"crack_size": prepared.crack_size, "far_size": prepared.far_size}
    assert result.scene.data["interface"]["width"] == result.width == prepared.width
    assert result.fields.mesh is prepared.model.mesh
    for word in ("notched-beam", f"crack_size = {prepared.crack_size:.4g} mm", f"width = {prepared.width:.4g} mm", "by rule"):
        assert word in repr(prepared)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("specimen.notch", 20.0),
        ("specimen.crack", "grow"),
        ("mesh.crack_size", 2.0),
        ("mesh.far_size", 10.0),
        ("mesh.order", 1),
        ("material.nu", 0.18),
        ("material.density", 2400.0),
        ("model.half", True),
        ("model.plane", "strain"),
        ("interface.quadrature", "gauss"),
        ("solver.condensation", "never"),
    ],
)
def test_what_asks_for_another_stiffness_is_refused(key: str, value: object) -> None:
    prepared = prepare(beam())
    with pytest.raises(SceneError, match=rf"^{key} = .*: .*prepared with .*; expected that$") as refused:
        run(beam(**{key: value}), prepared)
    assert refused.value.key == key


def test_the_width_of_a_band_is_that_of_its_mesh() -> None:
    prepared = prepare(beam(), model="smeared")
    with pytest.raises(SceneError, match=r"^band\.width = 1\.0: .* prepared with 0\.25"):
        run(beam(**{"model.kind": "smeared", "band.width": 1.0}), prepared)
    with pytest.raises(SceneError, match=r"^model\.kind = 'discrete'"):
        run(beam(), prepared)


def test_the_width_of_an_interface_is_free() -> None:
    prepared = prepare(beam())
    wide = beam(**{"interface.width": 0.5})
    assert run(wide, prepared).width == 0.5
