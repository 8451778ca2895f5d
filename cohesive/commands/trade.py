"""`cohesive trade SCENE`."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from ..errors import NotConverged
from ..results.files import make_folder
from .common import INTERRUPTED, STOPPED, Commands, add_scene, load_scene, progress, save_and_tell, trade_folder


def add_parser(commands: Commands) -> None:
    """The command's arguments."""
    p = commands.add_parser(
        "trade",
        help="measure accuracy against cost",
        description="Change the settings of a scene one at a time, then those that pay together: error against CPU time.",
    )
    add_scene(p, "the scene's name and -trade", "model.kind=smeared")
    p.add_argument("--settings", metavar="LIST", help="change these only, as in 'crack size, steps' (default: all)")
    p.add_argument("--knobs", help=argparse.SUPPRESS)  # its old name, for one release
    p.add_argument("--dask", metavar="ADDRESS", help="run the trials on a Dask cluster: its scheduler's address, or local")
    p.set_defaults(execute=_execute)


def _execute(options: argparse.Namespace) -> int:
    from ..studies.pool import dask_executor
    from ..studies.trade import trade
    from ..studies.trials import SweepSetting

    scene = load_scene(options)
    if options.knobs:
        print("cohesive: --knobs is now --settings", file=sys.stderr)
    names = options.settings or options.knobs
    settings = [name.strip() for name in names.split(",")] if names else None
    folder = Path(options.output) if options.output else trade_folder(options.scene)
    make_folder(folder)
    with dask_executor(options.dask) as executor, progress(unit="run") as bar:

        def on_trial(trial: SweepSetting) -> None:
            bar.update()
            bar.set_postfix_str(trial.label)

        try:
            done = trade(scene, executor, on_trial, settings)
        except NotConverged as error:
            print(f"cohesive: the reference did not converge: {error}", file=sys.stderr)
            return STOPPED
        except KeyboardInterrupt as error:
            print(f"cohesive: {str(error) or 'interrupted'}; the table is written when all runs are done", file=sys.stderr)
            return INTERRUPTED
    save_and_tell(done, folder, "trade.csv, trade.png, trade.txt")
    return 0
