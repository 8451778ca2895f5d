"""`run`: from a scene to a result, the one place that wires the rooms together."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from .errors import Interrupted, NotConverged, SceneError
from .model.build import build
from .results.files import HistoryWriter
from .results.result import Result
from .scenes.reference import load_reference
from .scenes.scene import Scene
from .solver.march import March, Step, under_dead_loads
from .solver.problem import State


def run(
    scene: Scene,
    model: str | None = None,
    output: str | Path | None = None,
    on_step: Callable[[Step, dict[str, float]], None] | None = None,
    tangent: str = "consistent",
) -> Result:
    """Run a scene.

    Parameters
    ----------
    scene : Scene
    model : overrides the scene's model.kind.
    output : folder whose history.csv grows row by row during the run; `Result.save` writes the rest.
    on_step : called after every converged step with it and its row of the history.
    tangent : "consistent", or "secant" to see what Newton's method is worth: a step may then take 1000 iterations.

    Returns
    -------
    Result

    Raises
    ------
    SceneError, MeshError
        For bad input.
    NotConverged, Interrupted (a KeyboardInterrupt), and SceneError if history.csv cannot grow
        With everything computed so far in the exception's `result`.
    """
    if not isinstance(scene, Scene):
        raise TypeError(f"run(scene) got {scene!r}: expected a Scene, as from Scene.load(name)")
    if tangent not in ("consistent", "secant"):
        raise ValueError(f"tangent = {tangent!r}: expected 'consistent' or 'secant'")
    if model is not None:
        scene = scene.with_(**{"model.kind": model})
    reference = load_reference(scene)
    built = build(scene, tangent)
    notes = list(built.notes)
    done: list[tuple[dict[str, float], State]] = []
    clock = time.perf_counter()

    def result(note: str | None = None) -> Result:
        stopped = [] if note is None else [f"stopped: {note}"]
        built.timings["newton"] = time.perf_counter() - clock
        return Result(scene, built, [row for row, _ in done], [state for _, state in done], notes + stopped, reference)

    with HistoryWriter(output, [column.name for column in built.columns]) as writer:
        try:
            built = replace(built, problem=under_dead_loads(built.problem))
            for step in March(built.problem, scene.stages, built.record, scene.solver.step_growth, notes):
                row = _row(len(done) + 1, step, built.record(step.equilibrium.state), time.perf_counter() - clock)
                done.append((row, step.equilibrium.state))  # both or, if an interruption comes between, none
                writer.write(row)
                if on_step is not None:
                    on_step(step, row)
        except (NotConverged, SceneError) as error:
            error.result = result(str(error))
            raise
        except KeyboardInterrupt as error:
            interrupted = Interrupted(*error.args)
            interrupted.result = result(str(error) or "interrupted")
            raise interrupted from error
    return result()


def _row(number: int, step: Step, record: dict[str, float], wall_time: float) -> dict[str, float]:
    """A row of the history."""
    return {
        "step": number,
        **record,
        "iterations": step.equilibrium.iterations,
        "cuts": step.cuts,
        "residual": step.equilibrium.residuals[-1],
        "wall_time": wall_time,
        "stage": step.stage,
    }
