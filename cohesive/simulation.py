"""`run`: from a scene to a result, the one place that wires the rooms together."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from .errors import Interrupted, NotConverged, SceneError
from .growth.found import FoundPath
from .growth.search import find_path, found_scene
from .measured.curve import Reference
from .model.build import build
from .model.model import Model
from .model.prepared import Prepared
from .outcome.notebook import notebook_progress
from .outcome.result import Result
from .results.checkpoints import Checkpoint, Done, checkpoint_writer
from .results.files import history_writer
from .results.locking import lock_folder
from .results.record import Record
from .scenes.reference import load_reference
from .scenes.scene import Scene
from .solver.problem import State
from .solver.stepper import EVERY, Step, solve


def run(
    scene: Scene,
    model: str | Prepared | None = None,
    output: str | Path | None = None,
    on_step: Callable[[Step, dict[str, float]], None] | None = None,
    tangent: str = "consistent",
    on_phase: Callable[[str], None] | None = None,
) -> Result:
    """Run a scene.

    Parameters
    ----------
    scene : Scene
    model : overrides the scene's model.kind; or what `prepare` made of a scene that differs in the law, the modulus and the
        stages only, whose mesh and condensed stiffness serve again.
    output : folder whose history.csv grows row by row during the run; `Result.save` writes the rest.
    on_step : called after every converged step with it and its row of the history; without one a bar shows the progress in
        a notebook.
    on_phase : called with "mesh", "assemble" and "condense" as each begins, before the first step.
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

    Examples
    --------
    >>> from cohesive import Scene, run
    >>> result = run(Scene.load("notched-beam"))
    >>> print(f"{result.peak_load:.2g} N at an opening of {result.opening_at_peak:.2g} mm")
    1e+03 N at an opening of 0.029 mm
    """
    if not isinstance(scene, Scene):
        raise TypeError(f"run(scene) got {scene!r}: expected a Scene, as from Scene.load(name)")
    if tangent not in ("consistent", "secant"):
        raise ValueError(f"tangent = {tangent!r}: expected 'consistent' or 'secant'")
    if isinstance(model, Prepared):
        scene = model.scene_of(scene)
    elif model is not None:
        scene = scene.with_(**{"model.kind": model})
    found = None if scene.grow is None else find_path(scene)
    if found is not None:
        scene = found_scene(scene, found)
    reference = load_reference(scene)
    built = build(scene, tangent, on_phase, model.model if isinstance(model, Prepared) else None)
    with notebook_progress(scene.stages, on_step) as then:
        return _march(scene, built, reference, tangent, output, then, found=found)


def resume(
    folder: str | Path,
    on_step: Callable[[Step, dict[str, float]], None] | None = None,
    on_phase: Callable[[str], None] | None = None,
) -> Result:
    """Go on with a run that was killed or interrupted, from its last checkpoint: the history is that of a run that was not.

    Parameters
    ----------
    folder : `output` of that run, which is written on.
    on_step, on_phase : see `run`

    Raises
    ------
    SceneError
        If there is nothing to resume; else as `run`.
    """
    last = Checkpoint.read(Path(folder))
    built = build(last.scene, last.tangent, on_phase)
    with notebook_progress(last.scene.stages, on_step) as then:
        return _march(last.scene, built, load_reference(last.scene), last.tangent, folder, then, last, last.found)


def _march(
    scene: Scene,
    built: Model,
    reference: Reference | None,
    tangent: str,
    output: str | Path | None,
    on_step: Callable[[Step, dict[str, float]], None] | None,
    last: Checkpoint | None = None,
    found: FoundPath | None = None,
) -> Result:
    """Take a model through the stages of its scene, from the beginning or from a checkpoint."""
    notes = [*([] if found is None else found.notes), *built.notes]
    done, stood, size = ([], None, None) if last is None else last.done(built)
    record = Record(built.problem, scene.output.frames, done)
    unsaved: list[Done] = []  # rows since the last checkpoint
    clock = time.perf_counter() - (done[-1][0]["wall_time"] if done else 0.0)

    def result(note: str | None = None) -> Result:
        stopped = [] if note is None else [f"stopped: {note}"]
        return Result.from_run(scene, built, record, notes + stopped, time.perf_counter() - clock, reference, found)

    def observed(state: State) -> dict[str, float]:
        return built.record(state) | built.crack_lengths(state)

    def keep(row: dict[str, float], state: State) -> None:
        record.append(row, state)
        unsaved.append((row, state))
        write(row)

    try:
        with lock_folder(output), history_writer(output, [column.name for column in built.columns]) as write:
            for row, _ in done:
                write(row)
            stepper = solve(built.problem, scene.stages, built.recorded, scene.solver.step_growth, notes)
            built = replace(built, problem=stepper.problem)
            if last is not None and stood is not None:
                last.restore(stepper, stood)
                notes = stepper.notes
            with checkpoint_writer(output, scene, tangent, found, built.mesh.points, size) as set_down:
                if not record.rows:
                    keep(_row(0, None, observed(built.problem.initial()), 0.0), built.problem.initial())
                for step in stepper:
                    state = step.equilibrium.state
                    row = _row(record.rows, step, observed(state), time.perf_counter() - clock)
                    keep(row, state)
                    if on_step is not None:
                        on_step(step, row)
                    if row["step"] % EVERY == 0:
                        set_down(unsaved, stepper)
                        unsaved.clear()
    except (NotConverged, SceneError) as error:
        error.result = result(str(error))
        raise
    except KeyboardInterrupt as error:
        interrupted = Interrupted(*error.args)
        interrupted.result = result(str(error) or "interrupted")
        raise interrupted from error
    return result()


def _row(number: int, step: Step | None, record: dict[str, float], wall_time: float) -> dict[str, float]:
    """A row of the history; without a step that before the first one."""
    iterations, cuts, residual, stage = 0, 0, 0.0, 1
    if step is not None:
        iterations, cuts, stage = step.equilibrium.iterations, step.cuts, step.stage
        residual = step.equilibrium.residuals[-1]
    facts = {"iterations": iterations, "cuts": cuts, "residual": residual, "wall_time": wall_time, "stage": stage}
    return {"step": number, **record, **facts}
