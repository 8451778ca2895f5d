"""The tangent and the growing steps: they change the cost of a run, not what it finds."""

from __future__ import annotations

import numpy as np
import pytest

from cohesive import Scene, SceneError, run
from cohesive.model.build import build
from cohesive.solver.steps import next_size
from tests.builders import block


def test_steps_that_converge_easily_grow_and_end_at_the_same_target(beam: Scene) -> None:
    scene = beam.with_(**{"stage.0.steps": 60})
    plain, growing = (run(scene.with_(**{"solver.step_growth": most})) for most in (1.0, 4.0))
    assert not growing.history["cuts"].any()
    sizes, nominal = np.diff(growing.history["opening"]), 0.18 / 60
    assert 1.9 * nominal < sizes.max() < 4.001 * nominal
    assert len(growing.history["step"]) < 0.8 * len(plain.history["step"])
    assert growing.history["opening"][-1] == pytest.approx(plain.history["opening"][-1], rel=1e-4)  # the tolerance
    assert growing.history["load"][-1] == pytest.approx(plain.history["load"][-1], rel=1e-3)  # a converged state, but for it
    np.testing.assert_allclose(np.diff(plain.history["opening"]), nominal, rtol=1e-3)  # never by themselves


@pytest.mark.parametrize(("tangent", "per_step"), [("consistent", 1), ("secant", 40)])
def test_how_a_step_grows(tangent: str, per_step: int) -> None:
    """A cut step doubles up to the nominal one, after an easy step; beyond after a very easy one; and falls back after a hard
    one. The secant tangent takes 40 times the iterations for the same."""
    problem = build(block(), tangent).problem
    for size, iterations, following in (
        (0.25, 6, 0.5), (0.25, 7, 0.25), (1.0, 6, 1.0), (1.0, 2, 2.0), (3.0, 2, 4.0), (3.0, 3, 3.0), (4.0, 7, 2.0),
        (1.5, 7, 1.0),
    ):  # fmt: skip
        assert next_size(problem, size, per_step * iterations, 1.0, 4.0) == following


@pytest.mark.parametrize(
    ("key", "value", "expected"),
    [
        ("step_growth", 0.5, "expected a number of at least 1"),
        ("step_growth", "much", "expected a finite number"),
    ],
)
def test_bad_values_are_refused(key: str, value: object, expected: str) -> None:
    with pytest.raises(SceneError, match=f"solver.{key} = .*: {expected}"):
        block(**{f"solver__{key}": value})


def test_another_tangent_is_refused() -> None:
    with pytest.raises(ValueError, match=r"^tangent = 'initial': expected 'consistent' or 'secant'$"):
        run(block(), tangent="initial")
