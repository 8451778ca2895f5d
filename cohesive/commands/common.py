"""What several commands share: the scene and its changes, the progress bar, exit statuses."""

from __future__ import annotations

import argparse
import re
import sys
import threading
import tomllib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from tqdm import tqdm

from meshing.errors import MeshError

from ..algebra.petsc.ranks import rank_and_size
from ..errors import NotConverged, SceneError
from ..scenes.scene import Scene
from ..solver.stepper import Step

if TYPE_CHECKING:
    from ..studies.comparison import Comparison
    from ..studies.sweep import Sweep
    from ..studies.trade import Trade

#: exit statuses: a run that stopped before its end, bad input or a file that cannot be written, interrupted
STOPPED, BAD_INPUT, INTERRUPTED = 1, 2, 130

#: what ends a run early, with everything before it in the exception's `result`
ENDS = (NotConverged, KeyboardInterrupt, SceneError, MeshError)

#: seconds after which the bar is drawn again
_TICK = 0.5

#: what the bar says before the first step
_PHASES = {"mesh": "meshing", "assemble": "assembling", "condense": "condensing"}

Commands: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"


def add_set(parser: argparse.ArgumentParser, meaning: str) -> None:
    """The changes of keys, and the consent to scripts."""
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help=meaning)
    parser.add_argument("--run-scripts", action="store_true", help="run .geo files that are more than a shape: programs")


def add_scene(parser: argparse.ArgumentParser, default: str, example: str, may_lack: bool = False) -> None:
    """The scene, its changes and the folder for its files, of every command that runs one."""
    count = "?" if may_lack else None
    parser.add_argument("scene", metavar="SCENE", nargs=count, help="a TOML file, or a built-in scene (see `cohesive scenes`)")
    parser.add_argument("-o", "--output", metavar="DIR", help=f"folder for the files (default: {default})")
    add_set(parser, f"change a key, as in {example} (see `cohesive keys`)")


def add_model(parser: argparse.ArgumentParser) -> None:
    """The model, of commands that take one."""
    parser.add_argument("--model", help="discrete or smeared, overrides model.kind")


def add_verbose(parser: argparse.ArgumentParser) -> None:
    """Whether residuals are printed."""
    parser.add_argument("-v", "--verbose", action="store_true", help="print the Newton residuals of every step")


def load_scene(options: argparse.Namespace) -> Scene:
    """The scene of a command line with its changes."""
    if options.scene is None:
        raise SceneError("no scene: expected SCENE, a TOML file or the name of a built-in scene, or --resume DIR")
    scene = Scene.load(options.scene, options.run_scripts).with_(**assignments(options.set))
    return scene.with_(**{"model.kind": options.model}) if getattr(options, "model", None) else scene


#: numbers as people write them, which TOML does not know: .5, 5. or 007
_LOOSE_NUMBER = re.compile(r"[+-]?(\d{1,20}\.?\d{0,20}|\.\d{1,20})([eE][+-]?\d{1,3})?")


def value_of(text: str) -> Any:
    """A TOML value; what is not TOML is a number as `.5`, else a string."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return float(text) if _LOOSE_NUMBER.fullmatch(text.strip()) else text.strip()


def assignments(pairs: Sequence[str]) -> dict[str, Any]:
    """KEY=VALUE with a value as of `value_of`."""
    result = {}
    for pair in pairs:
        key, separator, text = pair.partition("=")
        if not separator or not key.strip():
            raise SceneError(f"--set {pair}: expected KEY=VALUE, as in material.Gf=0.1")
        try:
            result[key.strip()] = value_of(text)
        except (ValueError, RecursionError) as error:  # thousands of digits or levels
            raise SceneError(f"--set {pair}: {error}; expected a value that a scene can hold") from None
    return result


def is_scene(source: str) -> bool:
    """Whether a source is a scene, not a file with a curve."""
    path = Path(source)
    return path.suffix == ".toml" or not path.is_file()


def gather_ranks(options: argparse.Namespace) -> None:
    """Under mpiexec rank 0 goes on alone; the others compute for it, and end with it."""
    count = rank_and_size()[1]
    if count == 1:
        return
    if not getattr(options, "can_share", False) or load_scene(options).solver.condensation != "petsc":
        raise SceneError(
            f"mpiexec started {count} processes: expected one, or the command run or compare with "
            "solver.condensation = 'petsc'"
        )
    from ..algebra.petsc.stiffness import start  # with MPI

    start()


def status_of(error: BaseException) -> int:
    """Exit status of a run that ended early."""
    if isinstance(error, KeyboardInterrupt):
        return INTERRUPTED
    return STOPPED if isinstance(error, NotConverged) else BAD_INPUT


def save_and_tell(outcome: Comparison | Sweep | Trade, folder: Path, files: str) -> None:
    """Save an outcome, print its summary whatever becomes of the files, and say what they are."""
    try:
        outcome.save(folder)
    finally:
        print(outcome.summary())
    print(f"files: {folder}/  ({files})")


def trade_folder(scene: str) -> Path:
    """Where `trade` leaves its files, and `run --accuracy` looks for them."""
    return Path(f"{Path(scene).stem}-trade")


@contextmanager
def progress(total: int | None = None, unit: str = "step") -> Iterator[tqdm[Any]]:
    """A bar on a terminal, whose clock goes on in long phases too; nothing in a pipe."""
    with tqdm(total=total, unit=unit, disable=not sys.stderr.isatty(), leave=False) as bar:
        if bar.disable:
            yield bar
            return
        ended = threading.Event()

        def tick() -> None:
            while not ended.wait(_TICK):
                bar.refresh()

        clock = threading.Thread(target=tick, daemon=True)
        clock.start()
        try:
            yield bar
        finally:
            ended.set()
            clock.join()


def phase_reporter(bar: tqdm[Any]) -> Callable[[str], None]:
    """What names each phase before the first step on the bar."""

    def on_phase(name: str) -> None:
        bar.set_description_str(_PHASES[name])

    return on_phase


def reporter(bar: tqdm[Any], verbose: bool) -> Callable[[Step, dict[str, float]], None]:
    """What moves the bar after each step."""

    def on_step(step: Step, row: dict[str, float]) -> None:
        bar.set_description_str(refresh=False)
        bar.update()
        bar.set_postfix_str(f"{step.control} {step.value:.4g}, load {row['load']:.4g} N, {row['iterations']} iterations")
        if verbose:
            residuals = " ".join(f"{r:.0e}" for r in step.equilibrium.residuals)
            bar.write(
                f"step {row['step']:4d}  {step.control} {step.value:.5g}  cuts {step.cuts}  residuals {residuals}", sys.stdout
            )

    return on_step
