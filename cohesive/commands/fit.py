"""`cohesive fit SCENE...`."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..errors import SceneError
from ..results.files import make_folder
from ..scenes.scene import Scene
from .common import Commands, add_set, assignments


def add_parser(commands: Commands) -> None:
    """The command's arguments."""
    p = commands.add_parser(
        "fit",
        help="find the numbers of a scene from its measured curve",
        description="Fit numbers of one or several scenes to the measured curves that they name; write figure, table, "
        "fit.json, the fitted scene, and the softening curve for other programs.",
    )
    p.add_argument("scenes", metavar="SCENE", nargs="+", help="TOML files, or built-in scenes")
    p.add_argument("-o", "--output", metavar="DIR", help="folder for the files (default: the first scene's name and -fit)")
    add_set(p, "change a key of all scenes")
    p.add_argument(
        "--vary", action="append", default=[], metavar="KEY=LOW:HIGH", help="a number and its bounds, as material.ft=2:5"
    )
    p.add_argument("--own", action="append", default=[], metavar="KEY", help="each scene has its own number of this key")
    p.add_argument("--softening", metavar="CURVES", help="compare curves, as in exponential,hordijk,kink,points:4")
    p.add_argument("--loss", choices=("linear", "soft_l1", "band"), help="default: band for a measured band, else linear")
    p.add_argument("--weights", choices=("arc", "rows"), default="arc", help="what counts alike: length of curve, or rows")
    p.add_argument("--starts", type=int, default=1, metavar="N", help="number of starts, all distinct minima (default: 1)")
    p.add_argument("--profile", action="store_true", help="intervals by profile likelihood")
    p.add_argument(
        "--scatter", action="append", default=[], metavar="KEY=DEVIATION", help="known scatter, as specimen.notch=0.5"
    )
    p.add_argument("--export", choices=("abaqus", "diana", "atena"), help="print the fitted curve as input of a program")
    p.set_defaults(execute=_execute)


def _execute(options: argparse.Namespace) -> int:
    from ..fitting.curve_choice import fit_curves
    from ..fitting.export import EXPORTS
    from ..fitting.fit import fit

    scenes = [Scene.load(source, options.run_scripts).with_(**assignments(options.set)) for source in options.scenes]
    folder = Path(options.output or f"{Path(options.scenes[0]).stem}-fit")
    make_folder(folder)  # refused now, not after the fit
    vary = {key: bounds for key, bounds in map(_bounds, options.vary)}
    chosen = {
        "loss": options.loss,
        "weights": options.weights,
        "own": tuple(options.own),
        "starts": options.starts,
        "profile": options.profile,
        "scatter": assignments(options.scatter),
    }
    if options.softening:
        choice = fit_curves(scenes, vary, options.softening.split(","), **chosen)
        choice.save(folder)
        print(choice.summary())
        best = choice.fits[choice.best]
    else:
        best = fit(scenes, vary, **chosen)
        best.save(folder)
        print(best.summary())
    if options.export:
        print(EXPORTS[options.export][1](best.scenes[0].material), end="")
    print(f"files: {folder}/")
    return 0


def _bounds(text: str) -> tuple[str, tuple[float, float]]:
    """KEY=LOW:HIGH."""
    key, _, ends = text.partition("=")
    low, _, high = ends.partition(":")
    try:
        return key.strip(), (float(low), float(high))
    except ValueError:
        raise SceneError(f"--vary {text}: expected KEY=LOW:HIGH, as in material.ft=2:5", key.strip()) from None
