"""Newton's method: quadratic convergence, the line search, cracks slammed shut, the secant tangent."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from cohesive import NotConverged, Scene, run
from cohesive.solver.newton import MAX_ITERATIONS
from tests.builders import block

SHORT = {"solver.tol": 1e-11, "stage.0.to": [0.036, 0.03], "stage.0.steps": 5}


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


@pytest.mark.parametrize("of", ["path", "principal"])
def test_newton_converges_quadratically_with_a_band(beam: Scene, of: str) -> None:
    """In the steps that form no plane, by a constant that holds over the whole run (measured: 0.2)."""
    tails: list[list[float]] = []
    planes = [0]

    def keep(step: Any, row: dict[str, float]) -> None:
        planes.append(len(step.equilibrium.state.cracks.planes.point))
        if planes[-1] == planes[-2]:
            tails.append(step.equilibrium.residuals)

    wide = {"band.width": 2.5, "band.planes": of}
    run(beam.with_(**{"solver.tol": 1e-10, "stage.0.steps": 40}, **wide), model="smeared", on_step=keep)
    pairs = [(a, b) for residuals in tails for a, b in pairwise(residuals[1:]) if 1e-5 < a < 1e-3]
    assert len(pairs) >= 10 and planes[-1] > 5
    assert all(after < 2.0 * before**2 for before, after in pairs)


def test_the_line_search_is_needed_and_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    """Slammed shut to -100 MPa, where the smoothed contact is steepest: no cut with it, cuts or failure without."""
    scene = block(interface__width=0.05, solver__tol=1e-4)
    stages = [{"control": "opening", "to": 0.1, "steps": 20}, {"control": "load", "to": -40e3, "steps": 1}]
    assert run(scene.with_(stage=stages)).history["cuts"].sum() == 0
    monkeypatch.setattr("cohesive.solver.newton.DECREASE", -np.inf)  # any step is good enough
    with pytest.raises((AssertionError, NotConverged)):
        assert run(scene.with_(stage=stages)).history["cuts"].sum() == 0


@pytest.mark.parametrize("width", [0.05, 2.0, 60.0])
def test_a_crack_slammed_shut_in_one_step(width: float) -> None:
    scene = block(interface__width=width, solver__tol=1e-4)
    stages = [{"control": "opening", "to": 0.1, "steps": 20}, {"control": "load", "to": -4000.0, "steps": 1}]
    result = run(scene.with_(stage=stages))
    assert result.history["load"][-1] == pytest.approx(-4000.0, rel=1e-6)
    assert result.history["iterations"][20:].max() <= 12


def test_a_band_slammed_shut_in_one_step() -> None:
    for width in (1.0, 8.0):
        stages = [{"control": "opening", "to": 0.1, "steps": 20}, {"control": "load", "to": -4000.0, "steps": 1}]
        result = run(block(model__kind="smeared", band__width=width, solver__tol=1e-4, stage=stages))
        assert result.history["load"][-1] == pytest.approx(-4000.0, rel=1e-6)
        assert result.history["iterations"].max() < MAX_ITERATIONS


@pytest.mark.parametrize("model", ["discrete", pytest.param("smeared", marks=pytest.mark.long)])
def test_secant_finds_the_same_in_more_iterations(beam: Scene, model: str) -> None:
    """Past the peak and some way back."""
    scene = beam.with_(**SHORT, **{"model.kind": model})
    newton, secant = (run(scene, tangent=tangent) for tangent in ("consistent", "secant"))
    largest = abs(newton.history["load"]).max()
    # linear convergence: what is left is the last correction (1e-11) over 1 - its rate, here below 0.97
    np.testing.assert_allclose(secant.history["load"], newton.history["load"], atol=1e-9 * largest)
    np.testing.assert_allclose(secant.history["dissipated"], newton.history["dissipated"], rtol=1e-8)
    assert not secant.history["cuts"].any()
    assert secant.iterations > 5 * newton.iterations  # else it is the same tangent
    assert secant.history["iterations"].max() > MAX_ITERATIONS  # which would have cut the step


@pytest.mark.parametrize("control", ["opening", "load", "driven"])
def test_an_elastic_step_is_solved_at_once(control: str) -> None:
    """The first step moves to the target with unknowns and load: what is left is rounding, and one more iteration shows it."""
    steps: list[Any] = []
    to = {"opening": 1e-5, "load": 100.0, "driven": 1e-4}[control]
    run(block(stage=[{"control": control, "to": to, "steps": 1}]), on_step=lambda step, row: steps.append(step.equilibrium))
    assert steps[0].iterations <= 2
    assert steps[0].residuals[1] < 1e-11
