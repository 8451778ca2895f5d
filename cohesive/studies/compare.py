"""Both models on one scene: how far apart are the discrete crack and the crack band?"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from meshing.errors import MeshError

from ..errors import Interrupted, NotConverged, SceneError
from ..model.build import build
from ..outcome.result import Result
from ..results.files import make_folder
from ..results.report import warnings
from ..scenes.scene import Scene
from ..simulation import run
from ..solver.stepper import Step
from .comparison import MODELS, Comparison


def compare(
    scene: Scene,
    output: str | Path | None = None,
    on_step: Callable[[Step, dict[str, float]], None] | None = None,
) -> Comparison:
    """Run a scene with zero-thickness interface elements and with the crack band.

    A run that stops early is compared as far as it came, and the notes say why it stopped. Cracks that may form everywhere
    need the whole body: `model.half` then holds for the discrete run only.

    Parameters
    ----------
    scene : Scene; its model.kind does not matter.
    output : folder in whose subfolders discrete and smeared the histories grow during the runs.
    on_step : as in `run`.

    Raises
    ------
    SceneError
        For bad input.
    NotConverged, Interrupted (a KeyboardInterrupt)
        If not even one step of a run converged, and for an interruption, with the exception's `result` if there is
        one. What was finished before is in `finished`, also that of a SceneError.

    Examples
    --------
    >>> from cohesive import Scene, compare
    >>> comparison = compare(Scene.load("single-crack"))
    >>> abs(comparison.smeared.peak_load / comparison.discrete.peak_load - 1) < 0.01
    True
    """
    results: list[Result] = []
    notes: list[str] = []
    is_half = scene.model.half and scene.band.where == "path"
    scenes = [scene.with_(**{"model.kind": "discrete"}), scene.with_(**{"model.kind": "smeared", "model.half": is_half})]
    if scene.sizes is None and not scene.specimen.has_main_gauge:
        build(scenes[1])  # a band without faces has no opening: refused now, not after the first run
    if output is not None:
        make_folder(Path(output))
        for old in Path(output).glob("comparison.*"):  # of an earlier run into the same folder
            old.unlink()
    for name, one in zip(MODELS, scenes, strict=True):
        try:
            result = run(one, output=None if output is None else Path(output) / name, on_step=on_step)
        except (NotConverged, SceneError, Interrupted) as error:
            error.finished = results
            stopped = error.result
            if not isinstance(error, NotConverged) or not isinstance(stopped, Result) or not stopped.steps:
                raise
            result = stopped
        except (MeshError, KeyboardInterrupt) as error:  # before the first step
            ended = SceneError(str(error), error.key) if isinstance(error, MeshError) else Interrupted(*error.args)
            ended.finished = results
            raise ended from error
        notes += [f"{name}: {note}" for note in (*result.notes, *warnings(result))]
        results.append(result)
    if scene.model.half and not is_half:
        notes.append("smeared: the whole body; model.half holds for the discrete run only")
    return Comparison(results[0], results[1], notes)
