"""`cohesive law`."""

from __future__ import annotations

import argparse
import math
from functools import partial
from pathlib import Path

import numpy as np

from ..errors import ParameterError, SceneError
from ..law.concrete import PRESETS, Concrete
from ..law.crack_plane import CrackPlane
from ..law.softening import SOFTENING
from ..law.softening_choice import softening_name
from ..law.widths import default_width
from ..results.files import make_folder, write_file, write_table
from .common import Commands, add_set, assignments


def add_parser(commands: Commands) -> None:
    """The command's arguments."""
    p = commands.add_parser("law", help="draw and tabulate the law at a point")
    p.add_argument("--preset", default="crack-plane", help=f"material: {', '.join(PRESETS)} (default: crack-plane)")
    add_set(p, "change a parameter, as in Gf=0.1")
    p.add_argument(
        "--width", help="width of the crack plane in mm, or h (default: that of a run with a long crack, 0.4 %% of E Gf/ft^2)"
    )
    p.add_argument(
        "--curves", metavar="LIST", help="softening curves to draw side by side, as in 'exponential, hordijk' (default: all)"
    )
    p.add_argument("-o", "--output", metavar="DIR", default="law", help="folder for the files (default: law)")
    p.set_defaults(execute=_execute)


def _execute(options: argparse.Namespace) -> int:
    from ..studies import law_responses as responses

    law = _plane(options)
    folder = Path(options.output)
    make_folder(folder)
    m = law.concrete
    print(
        f"width of the crack plane {law.width:.4g} mm, jump at the onset of damage Zt = {law.Zt:.4g} mm, length of "
        f"the asperities Zm = {m.Zm:.4g} mm, characteristic length E Gf / ft^2 = {m.characteristic_length:.4g} mm"
    )
    tables = responses.tables(law)
    for name, (header, table) in tables.items():
        write_table(folder / f"{name}.csv", header.split(","), ([f"{value:.9g}" for value in row] for row in table))
    write_file(folder / "law.png", partial(responses.save_figure, law))
    curves = [name.strip() for name in options.curves.split(",")] if options.curves else list(SOFTENING)
    if m.softening not in curves:
        curves.append(m.softening)
    try:
        write_file(folder / "softening.png", lambda path: responses.save_softening_figure(m, path, curves))
    except ParameterError as error:
        raise SceneError(f"--curves {options.curves}: {error}", "curves") from None
    print(f"softening: {softening_name(m.softening)}; no traction from {m.fully_softened:.4g} mm on")
    for name, (header, table) in tables.items():
        print(f"\n{name}\n  " + "  ".join(f"{column:>15}" for column in header.split(",")))
        for row in table[np.linspace(0, len(table) - 1, 9).round().astype(int)]:
            print("  " + "  ".join(f"{value:15.6g}" for value in row))
    print(f"\nfiles: {folder}/  (law.png, softening.png and one CSV for each response)")
    return 0


def _plane(options: argparse.Namespace) -> CrackPlane:
    """The crack plane that the options describe."""
    changes = assignments(options.set)
    for key in changes:
        if key not in Concrete.__dataclass_fields__:
            raise SceneError(f"{key}: unknown parameter; expected one of {', '.join(Concrete.__dataclass_fields__)}", key)
    try:
        width = float(options.width) if options.width not in (None, "h") else None
    except ValueError:
        raise SceneError(f"width = {options.width!r}: expected a number in mm, or h", "width") from None
    try:
        concrete = Concrete.preset(options.preset, **changes)
        return CrackPlane(concrete, default_width(math.inf, concrete.zone_length) if options.width is None else width)
    except ValueError as error:
        raise SceneError(str(error)) from None
