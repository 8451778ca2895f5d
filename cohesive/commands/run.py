"""`cohesive run SCENE`."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from ..errors import SceneError
from ..results.files import make_folder
from ..results.result import Result
from ..scenes.scene import Scene
from ..simulation import run
from .common import (
    ENDS,
    Commands,
    add_scene,
    add_verbose,
    assignments,
    expected_steps,
    load_scene,
    progress,
    reporter,
    status_of,
    trade_folder,
)

#: files of a run; one without a converged step leaves no pictures and no frames
_FILES = ("curve.png", "deformed.png", "path.png", "path.csv", "history.csv", "frames.pvd", "run.json", "scene.toml")


def add_parser(commands: Commands) -> None:
    """The command's arguments."""
    p = commands.add_parser("run", help="run a scene", description="Run a scene and write curve, pictures and fields.")
    add_scene(p, "the scene's name", "material.Gf=0.1")
    p.add_argument("--model", help="discrete or smeared, overrides model.kind")
    p.add_argument("--accuracy", metavar="A", help="choose mesh, steps and solver for a relative error, as in 1%% or 0.01")
    add_verbose(p)
    p.set_defaults(execute=_execute, can_share=True)


def _execute(options: argparse.Namespace) -> int:
    scene = load_scene(options)
    if options.model:
        scene = scene.with_(**{"model.kind": options.model})
    folder = Path(options.output or Path(options.scene).stem)
    make_folder(folder)  # refused now, not after an hour
    notes = []
    if options.accuracy is not None:
        scene, chosen = _accurate(scene, options)
        notes = [chosen]
        print(chosen, flush=True)
    status = 0
    with progress(expected_steps(scene)) as bar:
        try:
            result = run(scene, output=folder, on_step=reporter(bar, options.verbose))
        except ENDS as error:
            partial_result = getattr(error, "result", None)
            if not isinstance(partial_result, Result):
                raise
            result, status = partial_result, status_of(error)
    result.notes[:0] = notes
    try:
        result.save(folder)
    finally:  # the numbers are there, whatever became of the files
        print(result.summary())
    print(f"files: {folder}/  ({', '.join(name for name in _FILES if (folder / name).exists())})")
    if status:
        print(f"cohesive: {result.notes[-1]}; everything up to there is in {folder}/", file=sys.stderr)
    return status


def _accurate(scene: Scene, options: argparse.Namespace) -> tuple[Scene, str]:
    """The scene with the settings for an accuracy, and where they come from."""
    from ..studies.accuracy import settings_for  # with multiprocessing, which a plain run need not load

    choice = settings_for(scene, options.accuracy, trade_folder(options.scene) / "trade.csv")
    if both := sorted(set(choice.changes) & set(assignments(options.set))):
        raise SceneError(f"--set {both[0]}: --accuracy chooses it; expected one of the two", both[0])
    return scene.with_(**choice.changes), choice.text
