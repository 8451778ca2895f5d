"""`cohesive sweep SCENE --vary KEY=VALUES`."""

from __future__ import annotations

import argparse
import sys
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import SceneError
from ..results.locking import lock_folder
from .common import INTERRUPTED, STOPPED, Commands, add_scene, load_scene, progress, save_and_tell, value_of


def add_parser(commands: Commands) -> None:
    """The command's arguments."""
    p = commands.add_parser(
        "sweep",
        help="run a scene with every combination of some values",
        description="Run a scene with every combination of some values, on all cores; write a table, a figure of all curves "
        "and the files of each run. Runs that differ in the law, the modulus and the stages only share a mesh.",
    )
    add_scene(p, "the scene's name and -sweep", "mesh.crack_size=1")
    p.add_argument(
        "--vary", action="append", required=True, metavar="KEY=VALUES",
        help="values by commas, or FIRST:LAST:COUNT, as in material.Gf=0.05:0.10:6 or mesh.crack_size=0.5,1,2",
    )  # fmt: skip
    p.add_argument("--pictures", action="store_true", help="draw those of each run, too, which takes longer than a small run")
    p.add_argument("--workers", type=int, metavar="N", help="processes (default: one for each core)")
    p.add_argument("--dask", metavar="ADDRESS", help="run on the Dask cluster of a scheduler, or 'local' for one here")
    p.set_defaults(execute=_execute)


def _execute(options: argparse.Namespace) -> int:
    from ..studies.pool import dask_executor
    from ..studies.sweep import Sweep, SweptRun, sweep

    if options.workers is not None and options.workers < 1:
        raise SceneError(f"--workers {options.workers}: expected at least 1")
    scene, vary = load_scene(options), _values(options.vary)
    folder = Path(options.output or f"{Path(options.scene).stem}-sweep")
    status, total = 0, int(np.prod([len(each) for each in vary.values()], dtype=float))
    with lock_folder(folder), dask_executor(options.dask) as executor, progress(total, "run") as bar:

        def on_run(run: SweptRun) -> None:
            bar.update()
            bar.set_postfix_str(run.name)

        try:
            swept = sweep(
                scene, vary, options.workers, executor=executor, output=folder, pictures=options.pictures, on_run=on_run
            )
        except KeyboardInterrupt as error:
            if not isinstance(partial := getattr(error, "result", None), Sweep):
                raise
            swept, status = partial, INTERRUPTED
    save_and_tell(swept, folder, "sweep.csv, sweep.png, sweep.txt, and the files of each run in its subfolder")
    missing = sum(not each.is_done for each in swept.runs)
    if missing:
        print(f"cohesive: {missing} of {len(swept.runs)} runs did not come to their end; see their reasons", file=sys.stderr)
    return status or (STOPPED if missing else 0)


def _values(pairs: Sequence[str]) -> dict[str, list[Any]]:
    """KEY=VALUES with TOML values or strings."""
    values: dict[str, list[Any]] = {}
    for pair in pairs:
        key, separator, text = (part.strip() for part in pair.partition("="))
        if not separator or not key or not text:
            raise SceneError(f"--vary {pair}: expected KEY=VALUES, as in material.Gf=0.05:0.10:6 or material.Gf=0.05,0.1")
        if key in values:
            raise SceneError(f"--vary {pair}: {key} is varied already; expected each key once", key)
        values[key] = _range(pair, text.split(":")) if text.count(":") == 2 else _listed(text)
    return values


def _range(pair: str, parts: list[str]) -> list[Any]:
    """FIRST:LAST:COUNT."""
    try:
        first, last, count = float(parts[0]), float(parts[1]), int(parts[2])
    except ValueError:
        count, first, last = 0, 0.0, 0.0
    if not 2 <= count <= 10_000 or not np.isfinite([first, last]).all():
        raise SceneError(f"--vary {pair}: expected FIRST:LAST:COUNT, two numbers and a count from 2 to 10000")
    return [float(f"{value:.12g}") for value in np.linspace(first, last, count)]


def _listed(text: str) -> list[Any]:
    """Values between commas."""
    try:
        return list(tomllib.loads(f"value = [{text}]")["value"])
    except tomllib.TOMLDecodeError:
        return [value_of(part) for part in text.split(",")]
