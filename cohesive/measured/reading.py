"""`read_measured`: a measured curve or band from its file; columns, units, sign and offset are checked here only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..arrays import Array
from ..errors import ParameterError, SceneError
from .blocks import one_block
from .columns import MOTIONS, Choice, choose
from .curve import Measured
from .fields import TableError
from .heading import dimensions_in
from .loading import Corrections, loading
from .text_table import TextTable, read_tables
from .units import FORCES, LENGTHS, factor_in, factor_of

#: largest measured load over the area of the crack, MPa, and motion at it over the root of that area, of any concrete
_STRESSES, _MOTIONS = (0.02, 100.0), (1e-5, 0.1)

#: secant from 0 to the first row, over the slope from there on, below which a curve does not begin at 0
_LEADS_BACK = 0.5

#: two gauges of one quantity are no pair if one moves by less than this part of the other
_DEAD = 0.2

#: a curve that begins under more than this part of the largest load does not begin at its zero
_UNLOADED = 0.1


def read_measured(
    path: str | Path,
    x: str | int | Sequence[str | int] | None = None,
    y: str | int | Sequence[str | int] | None = None,
    x_unit: str | None = None,
    y_unit: str | None = None,
    against: str | None = None,
    *,
    block: str | int | None = None,
    sheet: str | int | None = None,
    motions: Sequence[str] = MOTIONS,
    crack_area: float | None = None,
    x_offset: float | None = None,
    y_offset: float | None = None,
    rows: Sequence[int] | None = None,
    from_load: float | None = None,
    toe: Sequence[float] | None = None,
    smooth: int | None = None,
) -> Measured:
    """A measured curve, or a band, from a table of text or a sheet of a workbook (with openpyxl, the optional extra `excel`).

    Separator, decimal sign, encoding, lines before the data and units are found from the file. A column whose heading names
    quantity and unit comes before one that does not; a constant column is none; load_min and load_max are a band; the mean of
    two gauges of one quantity counts. Thousands may be set apart, rows without a value are left out, headings repeated within
    one test are passed over. Pre-loads before the test, unloading in it and after it are left out; what runs back with noise
    is kept. What was taken, and what else there was, is said in `Measured.notes`; dimensions that the lines above the table
    name stand in `Measured.dimensions`, and are not used.

    Parameters
    ----------
    path : the file
    x, y : name or number (the first is 1) of the column with the motion, and with the load; for x also several gauges, of
        which the mean counts, for y also two, the bounds of a band. Default: from the headings
    x_unit, y_unit : as "um", "kN", "10^-3 mm"; a minus before it turns the sign. Default: from the headings, else mm and N
    against : what x is, as "cmod". Default: what its heading says
    block : name or number of the specimen, if the file holds several, one below the other or side by side
    sheet : name or number of the sheet of a workbook. Default: the only one with a table
    motions : what x may be
    crack_area : mm^2, with which loads without a unit are judged: a thousandth of a concrete's strength is asked about
    x_offset, y_offset : what gauge (mm) and load cell (N) show before the test, which is taken off. Default: of a gauge that
        was not set to zero what it shows first, else nothing
    rows : first and last row of data that count, the first is 1
    from_load : N; rows before it is reached are left out
    toe : parts of the largest load, as (0.2, 0.4), between which the rise is taken as straight: x is counted from where that
        line meets no load
    smooth : number of neighbouring rows that count by their mean

    Raises
    ------
    SceneError
        In one sentence with file, line and column, if there is no such table or column, if its unit is not known, or if
        nothing says which of several columns is meant.

    Examples
    --------
    >>> from cohesive import Scene, read_measured
    >>> measured = read_measured(Scene.load("notched-beam").file("gregoire-2013-half-notched-d50.csv"))
    >>> measured.against, len(measured.x), measured.low is None
    ('cmod', 13, False)
    """
    path = Path(path)
    try:
        texts, content = read_tables(path)
        table, said = one_block(texts, sheet, block)
        choice = choose(table, x, y, against, motions)
        given = Corrections(x_offset, y_offset, rows, from_load, toe, smooth)
        measured = _measured(path, table, choice, (x_unit, y_unit), crack_area, content, given)
    except (TableError, ParameterError) as error:
        raise SceneError.at("reference.file", f" = {path.name!r}: {error}") from None
    except OSError as error:
        reason = f"cannot be read: {error.strerror or error}"
        raise SceneError.at("reference.file", f" = {path.name!r}: {reason}") from None
    dimensions = dimensions_in(table.above, table.dialect)
    offered = ", ".join(f"{key.removeprefix('specimen.')} {value:.6g}" for key, value in dimensions.items())
    said += [f"its heading says {offered} (mm, kg); nothing of it is taken"] if offered else []
    return replace(measured, notes=(*said, *measured.notes), dimensions=dimensions)


def _measured(
    path: Path,
    table: TextTable,
    choice: Choice,
    given: tuple[str | None, str | None],
    crack_area: float | None,
    content: bytes,
    corrections: Corrections,
) -> Measured:
    x_units = [_unit(table, column, given[0], LENGTHS, "x") for column in choice.x]
    y_units = [_unit(table, column, given[1], FORCES, "y") for column in choice.y]
    table, values, lost = table.without_lost([*choice.x, *choice.y])
    values = values * [factor for _, factor in (*x_units, *y_units)]
    gauges, loads = np.split(values, [len(choice.x)], axis=1)
    travels = np.ptp(gauges, axis=0)
    if travels.min() < _DEAD * travels.max():
        moved = " and ".join(f"{travel:.3g}" for travel in travels)
        raise TableError(f"its gauges of one quantity move by {moved} mm: expected reference.x = the column of one that lives")
    x = gauges.mean(axis=1)
    if len(x) > 1 and not np.ptp(loads, axis=0).any():
        raise TableError(f"its load is {loads[0, 0]:g} N in every row; expected reference.y = a column that changes")
    if is_band := len(choice.y) == 2:
        _check_band(table, choice.x[0], x, loads)
    test = loading(x, loads, choice.against, corrections)
    if is_band:
        curve = Measured.from_band(test.x, test.loads[:, 0], test.loads[:, 1], path.name, choice.against)
    else:
        curve = Measured.from_curve(test.x, test.loads[:, 0], path.name, choice.against)
    curve = replace(curve, x_unit=x_units[0][0], y_unit=y_units[0][0], x_offset=test.x_offset, content=content)
    doubt = _sign(curve) or _scale(curve, crack_area, given) or _start(curve)
    return replace(curve, notes=(*choice.notes, *lost, *test.notes, *([doubt] if doubt else [])), doubt=doubt)


def _unit(table: TextTable, column: int, given: str | None, known: dict[str, float], key: str) -> tuple[str, float]:
    """Unit of a column, that of the key before that of the file, and its factor; without one it is mm or N."""
    if given is not None:
        return given, factor_of(given, known, f"reference.{key}_unit")
    unit = table.units[column]
    factor = factor_in(unit, known) if unit else 1.0
    if factor is None:
        what = "length" if known is LENGTHS else "force"
        raise TableError(
            f"column {column + 1} ({table.titles[column]}): its unit {unit} is no {what} that is known; expected another "
            f"column, or reference.{key}_unit"
        )
    return unit, factor


# -- checks -----------------------------------------------------------------------------------------


def _sign(curve: Measured) -> str:
    """One sentence with the key that corrects it, if the largest load is negative while x grows; empty if it is not."""
    peak = int(abs(curve.y).argmax())
    if not curve.y[peak] < 0 < curve.x[peak]:
        return ""
    turned = f"-{curve.y_unit or 'N'}".removeprefix("--")
    return f"its largest load is {curve.y[peak]:.4g} N, which is negative: reference.y_unit = '{turned}' turns the sign"


def _start(curve: Measured) -> str:
    """One sentence, if a curve begins under load at a place from which its slope does not lead back to 0: its gauge was not
    set to zero, for a body that softens is stiffer up to there than from there on."""
    peak = int(abs(curve.y).argmax())
    load = curve.y * np.sign(curve.y[peak])
    if not peak or load[0] <= _UNLOADED * load[peak]:
        return ""  # which `loading` counts from its first row
    half = int(np.argmax(load >= 0.5 * (load[0] + load[peak])))
    slope = (load[half] - load[0]) / (curve.x[half] - curve.x[0])
    if load[0] >= _LEADS_BACK * slope * curve.x[0] and curve.x[0] >= 0:
        return ""
    return (
        f"its {curve.against} begins at {curve.x[0]:.4g} mm under {100 * load[0] / load[peak]:.2g} % of the largest load, "
        "from where its slope does not lead back to 0: expected a gauge that was set to zero, or x with that taken off"
    )


def _scale(curve: Measured, crack_area: float | None, given: tuple[str | None, str | None]) -> str:
    """One sentence with the key that corrects it, if a curve whose unit no key gives is far off what a concrete bears or opens
    by, and another unit brings it there; empty if neither."""
    if crack_area is None:
        return ""
    peak, length = int(abs(curve.y).argmax()), crack_area**0.5
    load, motion = abs(float(curve.y[peak])), float(curve.x[peak])
    size = f"for a crack of {crack_area:.4g} mm^2"
    load_there, motion_there = f"largest load is {load:.4g} N {size}", f"motion at the largest load is {motion:.4g} mm {size}"
    pairs = (
        ("y", given[1], curve.y_unit, "N", ("kN", "MN", "mN", "N"), FORCES, load / crack_area, _STRESSES, load_there),
        ("x", given[0], curve.x_unit, "mm", ("um", "m", "mm"), LENGTHS, motion / length, _MOTIONS, motion_there),
    )
    for key, said, own, unit, others, factors, value, (low, high), what in pairs:
        if said or not value > 0 or low <= value <= high:
            continue
        in_file = value / (factor_in(own, factors) or 1.0)
        if other := next((other for other in others if low <= in_file * factors[other] <= high), ""):
            named = f"its heading says {own}" if own else "no unit is named"
            return f"its {what}, and {named}: if it is in {other}, say reference.{key}_unit = '{other}', else '{own or unit}'"
    return ""


def _check_band(table: TextTable, column: int, x: Array, loads: Array) -> None:
    """Refuse a band whose x does not rise, or whose lower bound is above the upper one."""
    if (back := np.flatnonzero(np.diff(x) <= 0)).size:
        raise TableError(f"{table.place(int(back[0]) + 1, column)}: it does not rise; the x of a band has to")
    if (crossed := np.flatnonzero(loads[:, 0] > loads[:, 1])).size:
        row = int(crossed[0])
        raise TableError(
            f"line {int(table.numbers[row])}: the lower bound {loads[row, 0]:g} N is above the upper, {loads[row, 1]:g} N"
        )
