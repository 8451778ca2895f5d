"""`cohesive report DIR [DIR]`."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from .common import Commands


def add_parser(commands: Commands) -> None:
    """The command's arguments."""
    p = commands.add_parser(
        "report",
        help="one HTML file with the steps of a run under a slider",
        description="From the folder of a run: one HTML file, without server or network, in which a slider over the frames "
        "moves body, load, crack profile, tractions, softening curve and energies. With a second folder two runs side by "
        "side. More frames: cohesive run SCENE --set output.frames=40.",
    )
    p.add_argument("folders", metavar="DIR", nargs="+", help="folder of a run, or of two; of a comparison both")
    p.add_argument("-o", "--output", metavar="FILE", help="file to write (default: report.html in the first folder)")
    p.set_defaults(execute=_execute)


def _execute(options: argparse.Namespace) -> int:
    from ..errors import SceneError
    from ..outcome.page import write_page
    from ..outcome.result import Result
    from ..outcome.views import Views

    folders = [Path(folder) for folder in options.folders]
    path = Path(options.output) if options.output else folders[0] / "report.html"
    if len(folders) == 1 and os.path.isfile(folders[0] / "discrete" / "run.json"):
        folders = [folders[0] / "discrete", folders[0] / "smeared"]
    if len(folders) > 2:
        raise SceneError(f"report: {len(folders)} folders; expected one or two")
    write_page([Views.from_result(Result.load(folder)) for folder in folders], path)
    print(f"{path}  ({path.stat().st_size / 1e6:.2g} MB)")
    return 0
