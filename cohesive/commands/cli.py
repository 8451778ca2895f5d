"""The command line: `cohesive run`, `cohesive compare`, `cohesive trade`, `cohesive law`, `cohesive scenes`."""

from __future__ import annotations

import argparse
import os
import sys
import tomllib
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from functools import partial
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from meshing import MeshError

from ..algebra.petsc.ranks import rank_and_size
from ..errors import NotConverged, SceneError
from ..law.concrete import PRESETS, Concrete
from ..law.crack_plane import CrackPlane
from ..results.files import make_folder, write_file
from ..results.result import Result
from ..scenes.scene import Scene, built_in
from ..simulation import run
from ..solver.march import Step
from ..studies import law_responses as responses
from ..studies.compare import compare

#: a run that stopped before its end, bad input or a file that cannot be written, interrupted
_STOPPED, _BAD_INPUT, _INTERRUPTED = 1, 2, 130

#: of a run; a run without a converged step leaves no pictures and no frames
_FILES = ("curve.png", "deformed.png", "history.csv", "frames.pvd", "run.json", "scene.toml")

#: what ends a run early, with everything before it in the exception's `result`
_ENDS = (NotConverged, KeyboardInterrupt, SceneError, MeshError)


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point; returns the exit status."""
    options = _parser().parse_args(arguments)
    try:
        _gather(options)
        return int(options.command(options))
    except (SceneError, MeshError) as error:
        print(f"cohesive: {error}", file=sys.stderr)
        return _BAD_INPUT
    except KeyboardInterrupt as error:
        print(f"cohesive: {str(error) or 'interrupted'}; what was written until then is complete", file=sys.stderr)
        return _INTERRUPTED
    except BrokenPipeError:  # the reader of the output has left, as `head` does
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0


def _gather(options: argparse.Namespace) -> None:
    """Under mpiexec process 0 goes on alone; the others compute for it, and end with it."""
    count = rank_and_size()[1]
    if count == 1:
        return
    can_share = options.command in (_run, _compare)
    if not can_share or Scene.load(options.scene).with_(**_assignments(options.set)).solver.reduction != "petsc":
        raise SceneError(
            f"mpiexec started {count} processes: expected one, or the command run or compare with solver.reduction = 'petsc'"
        )
    from ..algebra.petsc.stiffness import start  # with MPI

    start()


def _status(error: BaseException) -> int:
    """Exit status of a run that ended early."""
    if isinstance(error, KeyboardInterrupt):
        return _INTERRUPTED
    return _STOPPED if isinstance(error, NotConverged) else _BAD_INPUT


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="cohesive", description="Rough cracks in concrete, discrete and smeared.")
    parser.add_argument("--version", action="version", version=_version())
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")

    p = commands.add_parser("run", help="run a scene", description="Run a scene and write curve, pictures and fields.")
    _add_scene(p, "the scene's name")
    p.add_argument("--model", help="discrete or smeared, overrides model.kind")
    p.add_argument("--accuracy", metavar="A", help="choose mesh, steps and solver for a relative error, as in 1%% or 0.01")
    p.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="change a key, as in material.Gf=0.1")
    p.add_argument("-v", "--verbose", action="store_true", help="print the Newton residuals of every step")
    p.set_defaults(command=_run)

    p = commands.add_parser(
        "compare",
        help="run a scene in both models",
        description="Run a scene with discrete cracks and with the crack band, and write table, figure and both runs' files.",
    )
    _add_scene(p, "the scene's name and -compare")
    p.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="change a key, as in band.width=0.5")
    p.add_argument("-v", "--verbose", action="store_true", help="print the Newton residuals of every step")
    p.set_defaults(command=_compare)

    p = commands.add_parser(
        "trade",
        help="measure accuracy against cost",
        description="Turn the knobs of a scene one at a time, then those that pay together: error against CPU time.",
    )
    _add_scene(p, "the scene's name and -trade")
    p.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="change a key, as in model.kind=smeared")
    p.add_argument("--knobs", metavar="LIST", help="turn these only, as in 'crack size, steps' (default: all that it has)")
    p.add_argument("--dask", metavar="ADDRESS", help="run the trials on a Dask cluster: its scheduler's address, or local")
    p.set_defaults(command=_trade)

    p = commands.add_parser("law", help="draw and tabulate the law at a point")
    p.add_argument("--preset", default="crack-plane", help=f"material: {', '.join(PRESETS)} (default: crack-plane)")
    p.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="change a parameter, as in Gf=0.1")
    p.add_argument("--width", default="h", help="width of the crack plane in mm, or h (default: h)")
    p.add_argument("-o", "--output", metavar="DIR", default="law", help="folder for the files (default: law)")
    p.set_defaults(command=_law)

    p = commands.add_parser("scenes", help="list the built-in scenes, or print one", description="Built-in scenes.")
    p.add_argument("name", nargs="?", help="print this scene's TOML, a start for your own")
    p.set_defaults(command=_scenes)
    return parser


def _add_scene(parser: argparse.ArgumentParser, default: str) -> None:
    """The scene and the folder for its files, of every command that runs one."""
    parser.add_argument("scene", metavar="SCENE", help="a TOML file, or a built-in scene (see `cohesive scenes`)")
    parser.add_argument("-o", "--output", metavar="DIR", help=f"folder for the files (default: {default})")


def _run(options: argparse.Namespace) -> int:
    assigned = _assignments(options.set)
    scene = Scene.load(options.scene).with_(**assigned)
    if options.model:
        scene = scene.with_(**{"model.kind": options.model})
    folder = Path(options.output or Path(options.scene).stem)
    make_folder(folder)  # refused now, not after an hour
    notes = []
    if options.accuracy is not None:
        from ..studies.accuracy import settings_for  # with multiprocessing, which a plain run need not load

        choice = settings_for(scene, options.accuracy, _trade_folder(options.scene) / "trade.csv")
        if both := sorted(set(choice.changes) & set(assigned)):
            raise SceneError(f"--set {both[0]}: --accuracy chooses it; expected one of the two")
        scene, notes = scene.with_(**choice.changes), [choice.text]
        print(choice.text, flush=True)
    status = 0
    with tqdm(total=_expected_steps(scene), unit="step", disable=not sys.stderr.isatty(), leave=False) as bar:
        try:
            result = run(scene, output=folder, on_step=_reporter(bar, options.verbose))
        except _ENDS as error:
            partial_result = getattr(error, "result", None)
            if not isinstance(partial_result, Result):
                raise
            result = partial_result
            status = _status(error)
    result.notes[:0] = notes
    try:
        result.save(folder)
    finally:  # the numbers are there, whatever became of the files
        print(result.summary())
    names = [name for name in _FILES if (folder / name).exists()]
    print(f"files: {folder}/  ({', '.join(names)})")
    if status:
        print(f"cohesive: {result.notes[-1]}; everything up to there is in {folder}/", file=sys.stderr)
    return status


def _compare(options: argparse.Namespace) -> int:
    scene = Scene.load(options.scene).with_(**_assignments(options.set))
    folder = Path(options.output or f"{Path(options.scene).stem}-compare")
    with tqdm(total=2 * _expected_steps(scene), unit="step", disable=not sys.stderr.isatty(), leave=False) as bar:
        try:
            comparison = compare(scene, output=folder, on_step=_reporter(bar, options.verbose))
        except _ENDS as error:
            partial_result = getattr(error, "result", None)
            for result in (*getattr(error, "finished", ()), partial_result):
                if isinstance(result, Result):
                    result.save(folder / result.scene.model.kind)
            if not isinstance(partial_result, Result):
                raise
            note = f"{partial_result.scene.model.kind}: {partial_result.notes[-1]}"
            print(f"cohesive: {note}; everything up to there is in {folder}/", file=sys.stderr)
            return _status(error)
    try:
        comparison.save(folder)
    finally:
        print(comparison.summary())
    print(f"files: {folder}/  (comparison.png, comparison.csv, and the files of both runs in discrete/ and smeared/)")
    return _STOPPED if any(": stopped: " in note for note in comparison.notes) else 0


def _trade(options: argparse.Namespace) -> int:
    from ..studies.pool import dask_executor
    from ..studies.trade import trade
    from ..studies.trials import Trial

    scene = Scene.load(options.scene).with_(**_assignments(options.set))
    knobs = [knob.strip() for knob in options.knobs.split(",")] if options.knobs else None
    folder = Path(options.output) if options.output else _trade_folder(options.scene)
    make_folder(folder)
    with (
        dask_executor(options.dask) if options.dask else nullcontext() as executor,
        tqdm(unit="run", disable=not sys.stderr.isatty(), leave=False) as bar,
    ):

        def on_trial(trial: Trial) -> None:
            bar.update()
            bar.set_postfix_str(trial.label)

        try:
            found = trade(scene, executor, on_trial, knobs)
        except NotConverged as error:
            print(f"cohesive: the reference did not converge: {error}", file=sys.stderr)
            return _STOPPED
        except KeyboardInterrupt as error:
            print(f"cohesive: {str(error) or 'interrupted'}; the table is written when all runs are done", file=sys.stderr)
            return _INTERRUPTED
    try:
        found.save(folder)
    finally:
        print(found.summary())
    print(f"files: {folder}/  (trade.csv, trade.png, trade.txt)")
    return 0


def _trade_folder(scene: str) -> Path:
    """Where `trade` leaves its files, and `run --accuracy` looks for them."""
    return Path(f"{Path(scene).stem}-trade")


def _reporter(bar: tqdm[Any], verbose: bool) -> Callable[[Step, dict[str, float]], None]:
    def on_step(step: Step, row: dict[str, float]) -> None:
        bar.update()
        bar.set_postfix_str(f"{step.control} {step.value:.4g}, load {row['load']:.4g} N, {row['iterations']} iterations")
        if verbose:
            residuals = " ".join(f"{r:.0e}" for r in step.equilibrium.residuals)
            bar.write(
                f"step {row['step']:4d}  {step.control} {step.value:.5g}  cuts {step.cuts}  residuals {residuals}", sys.stdout
            )

    return on_step


def _expected_steps(scene: Scene) -> int:
    total, value = 0.0, 0.0
    for stage in scene.stages:
        for target in stage.targets:
            total += stage.count(abs(target - value)) + (stage.count(abs(target)) if stage.unload else 0.0)
            value = 0.0 if stage.unload else target
        value = 0.0
    return round(total)


def _law(options: argparse.Namespace) -> int:
    changes = _assignments(options.set)
    unknown = [key for key in changes if key not in Concrete.__dataclass_fields__]
    if unknown:
        raise SceneError(f"{unknown[0]}: unknown parameter; expected one of {', '.join(Concrete.__dataclass_fields__)}")
    try:
        concrete = Concrete.preset(options.preset, **changes)
        width = None if options.width == "h" else float(options.width)
        law = CrackPlane(concrete, width)
    except ValueError as error:
        message = f"width = {options.width!r}: expected a number in mm, or h" if "float" in str(error) else str(error)
        raise SceneError(message) from None
    folder = Path(options.output)
    make_folder(folder)
    print(f"Zm = {concrete.Zm:.4g} mm, Zt = {law.Zt:.4g} mm, E Gf / ft^2 = {concrete.characteristic_length:.4g} mm")
    tables = responses.tables(law)
    for name, (header, table) in tables.items():
        write_file(folder / f"{name}.csv", partial(np.savetxt, X=table, fmt="%.9g", delimiter=",", header=header, comments=""))
    write_file(folder / "law.png", partial(responses.save_figure, law))
    for name, (header, table) in tables.items():
        print(f"\n{name}\n  " + "  ".join(f"{column:>15}" for column in header.split(",")))
        for row in table[np.linspace(0, len(table) - 1, 9).round().astype(int)]:
            print("  " + "  ".join(f"{value:15.6g}" for value in row))
    print(f"\nfiles: {folder}/  (law.png and one CSV for each curve)")
    return 0


def _scenes(options: argparse.Namespace) -> int:
    if options.name:
        scene = Scene.load(options.name)
        print((scene.folder / f"{options.name}.toml").read_text(encoding="utf-8"), end="")
        return 0
    for name in built_in():
        print(f"{name:18s} {Scene.load(name).title}")
    return 0


def _assignments(pairs: Sequence[str]) -> dict[str, Any]:
    """KEY=VALUE with a TOML value; what is not TOML is a string."""
    result = {}
    for pair in pairs:
        key, separator, text = pair.partition("=")
        if not separator or not key.strip():
            raise SceneError(f"--set {pair}: expected KEY=VALUE, as in material.Gf=0.1")
        try:
            result[key.strip()] = tomllib.loads(f"value = {text}")["value"]
        except tomllib.TOMLDecodeError:
            result[key.strip()] = text.strip()
    return result


def _version() -> str:
    return f"cohesive-cracks {metadata.version('cohesive-cracks')}"
