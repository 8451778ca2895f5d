"""`cohesive compare SCENE`."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from ..outcome.result import Result
from ..results.locking import lock_folder
from ..solver.stages import expected_steps
from .common import ENDS, STOPPED, Commands, add_scene, add_verbose, load_scene, progress, reporter, save_and_tell, status_of


def add_parser(commands: Commands) -> None:
    """The command's arguments."""
    p = commands.add_parser(
        "compare",
        help="run a scene in both models",
        description="Run a scene with discrete cracks and with the crack band, and write table, figure and both runs' files.",
    )
    add_scene(p, "the scene's name and -compare", "band.width=0.5")
    add_verbose(p)
    p.set_defaults(execute=_execute, can_share=True)


def _execute(options: argparse.Namespace) -> int:
    from ..studies.compare import compare

    scene = load_scene(options)
    folder = Path(options.output or f"{Path(options.scene).stem}-compare")
    with lock_folder(folder), progress(2 * expected_steps(scene.stages)) as bar:
        try:
            comparison = compare(scene, output=folder, on_step=reporter(bar, options.verbose))
        except ENDS as error:
            if (status := _save_finished(error, folder)) is None:
                raise
            return status
    save_and_tell(comparison, folder, "comparison.png, comparison.csv, and the files of both runs in discrete/ and smeared/")
    return STOPPED if any(": stopped: " in note for note in comparison.notes) else 0


def _save_finished(error: BaseException, folder: Path) -> int | None:
    """Save what was computed before an error; the exit status, or None if there is no result to speak of."""
    stopped = getattr(error, "result", None)
    for result in (*(getattr(error, "finished", None) or ()), stopped):
        if isinstance(result, Result):
            result.save(folder / result.scene.model.kind)
    if not isinstance(stopped, Result):
        return None
    note = f"{stopped.scene.model.kind}: {stopped.notes[-1]}"
    print(f"cohesive: {note}; everything up to there is in {folder}/", file=sys.stderr)
    return status_of(error)
