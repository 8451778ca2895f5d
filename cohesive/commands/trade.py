"""`cohesive trade SCENE`."""

from __future__ import annotations

import argparse
import sys
from contextlib import nullcontext
from pathlib import Path

from ..errors import NotConverged
from ..results.files import make_folder
from .common import INTERRUPTED, STOPPED, Commands, add_scene, load_scene, progress, trade_folder


def add_parser(commands: Commands) -> None:
    """The command's arguments."""
    p = commands.add_parser(
        "trade",
        help="measure accuracy against cost",
        description="Turn the knobs of a scene one at a time, then those that pay together: error against CPU time.",
    )
    add_scene(p, "the scene's name and -trade", "model.kind=smeared")
    p.add_argument("--knobs", metavar="LIST", help="turn these only, as in 'crack size, steps' (default: all that it has)")
    p.add_argument("--dask", metavar="ADDRESS", help="run the trials on a Dask cluster: its scheduler's address, or local")
    p.set_defaults(execute=_execute)


def _execute(options: argparse.Namespace) -> int:
    from ..studies.pool import dask_executor
    from ..studies.trade import trade
    from ..studies.trials import Trial

    scene = load_scene(options)
    knobs = [knob.strip() for knob in options.knobs.split(",")] if options.knobs else None
    folder = Path(options.output) if options.output else trade_folder(options.scene)
    make_folder(folder)
    with dask_executor(options.dask) if options.dask else nullcontext() as executor, progress(unit="run") as bar:

        def on_trial(trial: Trial) -> None:
            bar.update()
            bar.set_postfix_str(trial.label)

        try:
            found = trade(scene, executor, on_trial, knobs)
        except NotConverged as error:
            print(f"cohesive: the reference did not converge: {error}", file=sys.stderr)
            return STOPPED
        except KeyboardInterrupt as error:
            print(f"cohesive: {str(error) or 'interrupted'}; the table is written when all runs are done", file=sys.stderr)
            return INTERRUPTED
    try:
        found.save(folder)
    finally:
        print(found.summary())
    print(f"files: {folder}/  (trade.csv, trade.png, trade.txt)")
    return 0
