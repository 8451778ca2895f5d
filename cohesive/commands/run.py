"""`cohesive run SCENE`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from meshing.errors import MeshError

from ..errors import NotConverged, SceneError
from ..model.estimate import Estimate, estimate
from ..outcome.result import Result
from ..results.checkpoints import NAME as CHECKPOINT
from ..results.files import FILES
from ..results.locking import lock_folder
from ..scenes.scene import Scene
from ..simulation import resume, run
from ..solver.stages import expected_steps
from .common import (
    ENDS,
    Commands,
    add_model,
    add_scene,
    add_verbose,
    assignments,
    load_scene,
    phase_reporter,
    progress,
    reporter,
    status_of,
    trade_folder,
)

#: frames of a run with a movie, at least
MOVIE_FRAMES = 40

#: expected seconds from which on a run says beforehand what it will take
LONG = 10.0

#: seconds of a run up to which the place where its body would rather break is run too
SHORT = 5.0


def add_parser(commands: Commands) -> None:
    """The command's arguments."""
    p = commands.add_parser("run", help="run a scene", description="Run a scene and write curve, pictures and fields.")
    add_scene(p, "the scene's name", "material.Gf=0.1", may_lack=True)
    p.add_argument("--resume", metavar="DIR", help="go on with a run that was killed or interrupted, in its folder; no SCENE")
    add_model(p)
    p.add_argument(
        "--movie", nargs="?", const="movie.gif", metavar="FILE", help="also an animation: movie.gif, or FILE (.gif or .mp4)"
    )
    p.add_argument("--accuracy", metavar="A", help="choose mesh, steps and solver for a relative error, as in 1%% or 0.01")
    add_verbose(p)
    p.set_defaults(execute=_execute, can_share=True)


def _execute(options: argparse.Namespace) -> int:
    if options.resume is not None:
        resumed = _resumed(options)
        with lock_folder(options.resume):
            return _finished(options, Path(options.resume), resumed)
    scene = load_scene(options)
    if options.movie:
        scene = scene.with_(**{"output.frames": max(scene.output.frames, MOVIE_FRAMES)})
    folder = Path(options.output or Path(options.scene).stem)
    with lock_folder(folder):  # refused now, not after an hour
        notes = []
        if options.accuracy is not None:
            scene, chosen = _accurate(scene, options)
            notes = [chosen]
            print(chosen, flush=True)
        start = partial(run, scene, output=folder)
        return _finished(options, folder, start, expected_steps(scene.stages), notes, estimate(scene))


def _resumed(options: argparse.Namespace) -> Callable[..., Result]:
    """What goes on with a run; refused besides what would change its scene."""
    for name in ("scene", "output", "set", "model", "accuracy"):
        if getattr(options, name):
            given = "SCENE" if name == "scene" else f"--{name}"
            raise SceneError(
                f"--resume {options.resume}: goes on with the scene of that run, in its folder; expected no {given}"
            )
    return partial(resume, options.resume)


def _finished(
    options: argparse.Namespace,
    folder: Path,
    execute: Callable[..., Result],
    steps: int | None = None,
    notes: Sequence[str] = (),
    expected: Estimate | None = None,
) -> int:
    """Run, save and tell; the exit status."""
    status = 0
    if options.movie:
        from ..outcome.movie import check_movie  # with matplotlib

        check_movie(folder / options.movie)
    with progress(steps) as bar:
        if expected is not None and expected.seconds > LONG:
            bar.write(f"expected: {expected.text}", sys.stderr)
        try:
            result = execute(on_step=reporter(bar, options.verbose), on_phase=phase_reporter(bar))
        except ENDS as error:
            partial_result = getattr(error, "result", None)
            if not isinstance(partial_result, Result):
                raise
            result, status = partial_result, status_of(error)
    result.notes[:0] = notes
    if sum(result.timings.values()) < SHORT:
        result.notes += _elsewhere(result)
    try:
        result.save(folder)
    finally:  # the numbers are there, whatever became of the files
        print(result.summary())
    if options.movie and result.steps:
        _save_movie(result, folder / options.movie)
    print(f"files: {folder}/  ({', '.join(name for name in FILES if (folder / name).exists())})")
    if status:
        print(f"cohesive: {result.notes[-1]}; everything up to there is in {folder}/", file=sys.stderr)
        if (folder / CHECKPOINT).exists():
            print(f"cohesive: to go on: cohesive run --resume {folder}", file=sys.stderr)
    return status


def _elsewhere(result: Result) -> list[str]:
    """The peak of a crack where the body would rather break, if it would."""
    off = result.off_path
    if off is None or off.is_even or not off.line:
        return []
    try:
        peak = run(off.scene(result.scene)).peak_load
    except NotConverged as error:
        assert isinstance(error.result, Result)
        peak = error.result.peak_load
    except (MeshError, SceneError) as error:  # the line is a guess
        return [f"a straight crack there: {error}"]
    return [f"a straight crack there gives a peak load of {peak:.5g} N instead of {result.peak_load:.5g} N"]


def _save_movie(result: Result, path: Path) -> None:
    """The movie of a run."""
    from ..outcome.movie import write_movie  # with matplotlib
    from ..outcome.views import Views

    views = Views.from_result(result)
    with progress(len(views.rows), "frame") as bar:
        write_movie(views, path, bar.update)
    print(f"movie: {path}  ({path.stat().st_size / 1e6:.2g} MB)")


def _accurate(scene: Scene, options: argparse.Namespace) -> tuple[Scene, str]:
    """The scene with the settings for an accuracy, and where they come from."""
    from ..studies.accuracy import settings_for  # with multiprocessing, which a plain run need not load

    choice = settings_for(scene, options.accuracy, trade_folder(options.scene) / "trade.csv")
    if both := sorted(set(choice.changes) & set(assignments(options.set))):
        raise SceneError(f"--set {both[0]}: --accuracy chooses it; expected one of the two", both[0])
    return scene.with_(**choice.changes), choice.text
