"""`cohesive fit SCENE... [CSV...]`."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import SceneError
from ..results.files import make_folder
from ..scenes.keys import key_units
from ..scenes.scene import Scene
from .common import Commands, add_set, assignments, is_scene

if TYPE_CHECKING:
    from ..measured.curve import Measured
    from ..measured.series import Specimen


def add_parser(commands: Commands) -> None:
    """The command's arguments."""
    p = commands.add_parser(
        "fit",
        help="find the numbers of a scene from its measured curve",
        description="Fit numbers of one or several scenes to the measured curves that they name; write figure, table, "
        "fit.json, the fitted scene, and the softening curve for other programs. With one scene and files of curves each "
        "specimen is fitted by itself; then come mean, scatter and characteristic values.",
    )
    p.add_argument("scenes", metavar="SCENE|CSV", nargs="+", help="TOML files, or built-in scenes; after one, files of curves")
    p.add_argument(
        "--specimens", metavar="TABLE", help="table with a row for each specimen: file, sheet, block, span, depth ..."
    )
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
    from ..measured.series import specimens_of

    curves = [source for source in options.scenes if not is_scene(source)]
    names = [source for source in options.scenes if is_scene(source)]
    if options.specimens and not curves:
        raise SceneError("--specimens: expected a scene and the files of curves that the table names", "specimens")
    if curves and len(names) != 1:
        raise SceneError(f"{len(names)} scenes with files of curves: expected one, SCENE CSV...", "scenes")
    scenes = [Scene.load(source, options.run_scripts).with_(**assignments(options.set)) for source in names]
    folder = Path(options.output or f"{Path(names[0]).stem}-fit")
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
    if curves:
        if options.softening or options.export:
            raise SceneError("--softening, --export: expected scenes that are fitted together, not files of curves", "scenes")
        _fit_each(scenes[0], specimens_of(curves, options.specimens), vary, chosen, folder)
    elif options.softening:
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


def _fit_each(
    scene: Scene,
    specimens: Sequence[Specimen],
    vary: Mapping[str, tuple[float, float]],
    chosen: Mapping[str, Any],
    folder: Path,
) -> None:
    """Fit each specimen by itself, write each into a folder of its own, and print and write the statistics of all."""
    from ..figures.series import write_series
    from ..fitting.fit import fit
    from ..measured.series import Series

    columns: dict[str, list[float | None]] = {}
    curves: list[Measured] = []
    intervals: dict[str, list[list[float | None]]] = {}
    for specimen in specimens:
        own = {key: value for key, value in specimen.values.items() if key.startswith(("specimen.", "reference."))}
        file = {"reference.file": str(specimen.file.resolve()), "reference.label": specimen.name}
        fitted = fit([scene.with_(**file, **own)], vary, **chosen)
        inside = folder / "".join(each if each.isalnum() or each in "-_" else "_" for each in specimen.name)
        make_folder(inside)
        fitted.save(inside)
        print(f"{specimen.name}: {fitted.summary()}")
        for key, value in fitted.values.items():
            columns.setdefault(key, []).append(value)
            intervals.setdefault(key, []).append([end if isfinite(end) else None for end in fitted.intervals[key]])
        curves += fitted.problem.data[0].curves
    units = key_units(scene)
    series = Series([each.name for each in specimens], columns, {key: units.get(key, "") for key in columns}, intervals)
    print(series.summary())
    write_series(folder, series, curves, {}, scene.output)


def _bounds(text: str) -> tuple[str, tuple[float, float]]:
    """KEY=LOW:HIGH."""
    key, _, ends = text.partition("=")
    low, _, high = ends.partition(":")
    try:
        return key.strip(), (float(low), float(high))
    except ValueError:
        raise SceneError(f"--vary {text}: expected KEY=LOW:HIGH, as in material.ft=2:5", key.strip()) from None
