"""What a fit runs again and again is what `run` runs, to the last bit."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cohesive.scenes
from cohesive import Scene, run
from cohesive.fitting.data import Data
from cohesive.fitting.parameters import varied
from cohesive.fitting.problem import FitProblem
from cohesive.fitting.repeated_run import RepeatedRun, Rows
from cohesive.measured.curve import Measured, Reference
from tests.builders import block

BUILTIN = sorted(path.stem for path in (Path(cohesive.scenes.__file__).parent / "builtin").glob("*.toml"))

#: kg/m^3
WEIGHT = {"material.density": 2400.0}


def assert_same(rows: Rows) -> None:
    """That a run of the scene of some rows gives them once more."""
    history = run(rows.scene).history
    for name, column in rows.history.items():
        np.testing.assert_array_equal(column, history[name][1:], err_msg=name)


def other_numbers(scene: Scene) -> dict[str, float]:
    """Strength, energy and modulus a little off: the mesh and its condensed stiffness are kept."""
    material = scene.material
    return {"material.ft": 1.03 * material.ft, "material.Gf": 0.97 * material.Gf, "material.E": 1.1 * material.E}


SMALL: dict[str, dict[str, Any]] = {
    "plain": {},
    "weight": WEIGHT,
    "half": {"model.half": True} | WEIGHT,
    "until": {"stage.0.until": {"load_ratio": 0.5}} | WEIGHT,
    "unload": {"stage.0.unload": {"load": 0.0}, "stage.0.to": [0.02, 0.05], "stage.0.steps": 6} | WEIGHT,
    "smeared": {"model.kind": "smeared", "stage.0.steps": 6} | WEIGHT,
}


@pytest.mark.parametrize("changes", SMALL.values(), ids=SMALL)
def test_a_beam_is_run_as_ever(changes: dict[str, Any]) -> None:
    coarse = {"mesh.crack_size": 5.0, "mesh.far_size": 20.0, "stage.0.steps": 12}
    repeated = RepeatedRun(Scene.load("notched-beam").with_(**coarse | changes))
    for values in ({}, other_numbers(repeated.scene)):
        assert_same(repeated.run(values))


def test_a_fit_stands_at_its_rows_as_ever() -> None:
    scene = Scene.load("notched-beam").with_(**{"mesh.crack_size": 5.0, "mesh.far_size": 20.0, "stage.0.steps": 10} | WEIGHT)
    x = np.array([0.01, 0.03, 0.05, 0.1])
    data = Data.from_reference(Reference("own", "opening", (Measured.from_curve(x, 900.0 - 3e3 * x),)), "arc")
    problem = FitProblem([RepeatedRun(scene)], [data], varied([scene], {"material.Gf": (0.03, 0.3)}))
    assert_same(problem.evaluate(problem.start + 0.1).rows[0])


def test_springs_are_run_as_ever() -> None:
    assert_same(RepeatedRun(Scene.load("push-off").with_(**{"stage.0.steps": 10} | WEIGHT)).run({}))


def test_a_law_that_no_scene_names_is_refused() -> None:
    from dataclasses import replace

    from cohesive import SceneError, prepare

    prepared = prepare(block())
    other = replace(prepared.model.problem, point_law=prepare(block(material__Gf=0.05)).model.problem.point_law)
    with pytest.raises(SceneError, match="prepared: its problem has a law of its own"):
        run(block(), replace(prepared, model=replace(prepared.model, problem=other)))


@pytest.mark.slow
@pytest.mark.parametrize("weight", [{}, WEIGHT], ids=["plain", "weight"])
@pytest.mark.parametrize("name", BUILTIN)
def test_every_scene_is_run_as_ever(name: str, weight: dict[str, Any]) -> None:
    repeated = RepeatedRun(Scene.load(name).with_(**weight))
    for values in ({}, other_numbers(repeated.scene)):
        assert_same(repeated.run(values))
