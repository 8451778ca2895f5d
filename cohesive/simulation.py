"""From a scene to a result: the only place that wires meshing, law, elements and solver together."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from meshing import Specimen, crack_front_length

from .errors import NotConverged, SceneError
from .model.build import build
from .model.checks import check_stages
from .model.cracks import band_note
from .results.files import HistoryWriter
from .results.result import Result
from .scenes.reference import load_reference
from .scenes.scene import Scene
from .scenes.tables import UserMesh
from .solver.march import March, Step
from .solver.problem import State


def run(
    scene: Scene,
    model: str | None = None,
    output: str | Path | None = None,
    on_step: Callable[[Step, dict[str, float]], None] | None = None,
) -> Result:
    """Run a scene.

    Parameters
    ----------
    scene : Scene
    model : overrides the scene's model.kind.
    output : folder whose history.csv grows row by row during the run; `Result.save` writes the rest.
    on_step : called after every converged step with it and its row of the history.

    Returns
    -------
    Result

    Raises
    ------
    SceneError, MeshError
        For bad input.
    NotConverged, KeyboardInterrupt, and SceneError where history.csv cannot grow
        With everything computed so far in the exception's `result`.
    """
    if not isinstance(scene, Scene):
        raise TypeError(f"run(scene) got {scene!r}: expected a Scene, as from Scene.load(name)")
    if model is not None:
        scene = scene.with_(**{"model.kind": model})
    reference = load_reference(scene)
    built = build(scene)
    check_stages(scene, built.problem, built.cracks.width)
    march = March(built.problem, scene.stages, built.record, step_growth=scene.solver.largest_step)
    if built.is_smeared and (warning := band_note(scene, built.cracks.width)):
        march.notes.append(warning)
    if isinstance(scene.specimen, Specimen) and scene.specimen.is_off_the_notch():
        march.notes.append("warning: the crack path neither begins nor ends at a notch, which stays closed to it")
    if isinstance(scene.specimen, UserMesh) and not built.is_smeared and (length := crack_front_length(built.mesh)):
        march.notes.append(f"the crack surface ends inside the body along {length:.4g} mm of its edge; there is the front")
    done: list[tuple[dict[str, float], State]] = []
    clock = time.perf_counter()

    def result() -> Result:
        built.timings["newton"] = time.perf_counter() - clock
        return Result(scene, built, [row for row, _ in done], [state for _, state in done], march.notes, reference)

    with HistoryWriter(output) as writer:
        try:
            for step in march:
                row = {
                    "step": len(done) + 1,
                    **built.record(step.equilibrium.state),
                    "iterations": step.equilibrium.iterations,
                    "cuts": step.cuts,
                    "residual": step.equilibrium.residuals[-1],
                    "wall_time": time.perf_counter() - clock,
                    "stage": step.stage,
                }
                done.append((row, step.equilibrium.state))  # both or, where an interruption comes between, none
                writer.write(row)
                if on_step is not None:
                    on_step(step, row)
        except (NotConverged, KeyboardInterrupt, SceneError) as error:
            march.notes.append(f"stopped: {str(error) or 'interrupted'}")
            error.result = result()  # type: ignore[union-attr]
            raise
    return result()
