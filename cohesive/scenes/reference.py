"""The measured curves that a scene names, read from their files: which columns, in which units, against what."""

from __future__ import annotations

import reprlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..arrays import Array
from ..errors import SceneError
from ..solver.columns import columns_of
from .measured import Measured, Reference, rising
from .scene import Scene
from .tables import ReferenceOptions
from .text_table import TableError, TextTable, read_table
from .units import FORCES, LENGTHS, factor_of

#: what names of columns say of themselves, the first is looked for first
_WORDS = {
    "opening": ("opening", "cod"),
    "cmod": ("crack mouth", "clip gauge", "clip gage"),
    "deflection": ("mid span", "midspan"),
    "ctod": (),
    "driven": ("driven", "displacement", "stroke", "crosshead", "cross head", "actuator", "piston", "load point"),
    "sliding": ("sliding", "slip", "cmsd", "csd"),
}
_LOADS = ("load", "force")
#: how such names end in German
_ENDINGS = {"opening": "öffnung", "deflection": "durchbiegung", "driven": "weg", "load": "kraft"}
_LOWER, _UPPER = ("min", "lower", "low"), ("max", "upper", "high")


def load_reference(scene: Scene) -> Reference | None:
    """The measured curves that the scene names.

    Raises
    ------
    SceneError
        Naming file, line and column, if a file is no table of finite numbers, a column is missing or named twice, a unit is
        unknown, or a band is none; naming the key, if the run has no column to compare with.
    """
    options = scene.reference
    if options is None:
        return None
    columns = _columns_of(scene)
    if options.against is not None and options.against not in columns:
        raise SceneError(
            f"reference.against = {options.against!r}: expected a column of the history in mm: {', '.join(columns)}",
            "reference.against",
        )
    against, curves = options.against, []
    for name in options.files:
        measured, column = _load(scene.file(name), f"reference.file = {name!r}", options, against, columns)
        if column == "cmod" and options.against is None and scene.specimen.has_main_gauge:
            column = "opening"  # the main gauge is the clip gauge of the test
        against = against or column  # the first file says it for all
        curves.append(measured)
    assert against is not None
    return Reference(options.label, against, tuple(curves))


def _columns_of(scene: Scene) -> list[str]:
    """Columns of the history that a measured x may be, those in mm."""
    every = columns_of(scene.specimen.gauges(), list(scene.specimen.drives()))
    return [column.name for column in every if column.unit == "mm"]


def _load(
    path: Path, key: str, options: ReferenceOptions, against: str | None, columns: Sequence[str]
) -> tuple[Measured, str]:
    """One file, and the column of the history that its x is."""
    try:
        table, content = read_table(path)
        x, loads = _choose(table, options, against)
        against = against or _said(table, x, columns)
        x_unit, x_factor = _unit(table, x, options.x_unit, LENGTHS, "x")
        units = [_unit(table, y, options.y_unit, FORCES, "y") for y in loads]
        values = table.values([x, *loads])
        values *= [x_factor, *(factor for _, factor in units)]
        notes = []
        if not table.has_titles:
            notes.append(f"its columns have no names: column {x + 1} is taken as {against}, column {loads[0] + 1} as load")
        if len(loads) == 2:
            _check_band(table, x, values)
        else:
            notes += _remarks(values[:, 0], against)
    except TableError as error:
        raise SceneError(f"{key}: {error}", "reference.file") from None
    except OSError as error:
        raise SceneError(f"{key}: cannot be read: {error.strerror or error}", "reference.file") from None
    kept, low = rising(values[:, 0], values[:, 1])
    high = rising(values[:, 0], values[:, -1])[1]
    y_unit = units[0][0]
    return Measured(path.name, kept, low, high, len(loads) == 2, x_unit, y_unit, tuple(notes), content), against


# -- which columns ----------------------------------------------------------------------------------


def _choose(table: TextTable, options: ReferenceOptions, against: str | None) -> tuple[int, list[int]]:
    """Number of the column that is x, and of the load or of the two bounds of a band, from 0."""
    wanted = options.y if isinstance(options.y, list) else None if options.y is None else [options.y]
    if not table.has_titles and options.x is None and wanted is None and len(table.titles) == 2:
        return 0, [1]
    loads = _loads(table) if wanted is None else [_named(table, name, "y") for name in wanted]
    x = _abscissa(table, against) if options.x is None else _named(table, options.x, "x")
    if x is None or not loads:
        what, missing = ("x", "an opening or a deflection") if x is None else ("y", "a load, or load_min and load_max")
        if not table.has_titles:
            raise TableError(
                f"its {len(table.titles)} columns have no names; expected reference.{what} = number of the column"
            )
        raise TableError(
            f"its columns are {_list(table.titles)}; expected {missing} among them, or reference.{what} = name of the column"
        )
    return x, loads


def _list(titles: Sequence[str]) -> str:
    """Titles of columns in an error, not more than a line of them."""
    shown = [reprlib.repr(title)[1:-1] for title in titles[:12]]
    return ", ".join(shown) + (f" and {len(titles) - 12} more" if len(titles) > 12 else "")


def _plain(title: str) -> str:
    return " ".join(title.lower().replace("_", " ").replace("-", " ").split())


def _named(table: TextTable, name: str | int, key: str) -> int:
    """The column that a key names by title, with its unit or without, or by number."""
    if isinstance(name, int):
        if not 1 <= name <= len(table.titles):
            raise TableError(f"it has {len(table.titles)} columns; expected reference.{key} = {name} to be one of them")
        return name - 1
    titles = list(zip(table.titles, table.full_titles, strict=True))
    exactly = [i for i, both in enumerate(titles) if name.strip() and name.strip() in both]
    nearly = [i for i, both in enumerate(titles) if _plain(name) and _plain(name) in map(_plain, both)]
    for found in (exactly, nearly):
        if len(found) > 1:
            raise TableError(_twice(table, found, key))
        if found:
            return found[0]
    what = f"its columns are {_list(table.titles)}" if table.has_titles else "its columns have no names"
    raise TableError(f"there is no column {name!r} (reference.{key}); {what}")


def _twice(table: TextTable, found: Sequence[int], key: str) -> str:
    numbers = " and ".join(str(i + 1) for i in found)
    return (
        f"columns {numbers} have the same name, {table.titles[found[0]]!r}; expected reference.{key} = number of the one meant"
    )


def _loads(table: TextTable) -> list[int]:
    """The column with a load, or the two with the bounds of a band; empty if there is none."""
    every = [i for i, title in enumerate(table.titles) if _is_load(title)]
    lower, upper = ([i for i in every if _plain(table.titles[i]).split()[-1] in words] for words in (_LOWER, _UPPER))
    single = [i for i in every if i not in lower + upper]
    if lower and upper and not single:
        return [_only(table, lower, "y"), _only(table, upper, "y")]
    return [_only(table, single, "y")] if single else []


def _is_load(title: str) -> bool:
    words = _plain(title).split()
    return any(word in _LOADS or word.endswith(_ENDINGS["load"]) for word in words) and "point" not in words


def _only(table: TextTable, found: Sequence[int], key: str) -> int:
    """The first of some columns; refused if another one has its name."""
    same = [i for i in found if _plain(table.titles[i]) == _plain(table.titles[found[0]])]
    if len(same) > 1:
        raise TableError(_twice(table, same, key))
    return same[0]


def _abscissa(table: TextTable, against: str | None) -> int | None:
    """The first column whose name says that it is what x is drawn against, or an opening, else a deflection, and so on."""
    for column in _WORDS if against is None else (against, *_WORDS):
        found = [i for i, title in enumerate(table.titles) if _says(title, column)]
        exact = [i for i in found if _plain(table.titles[i]) == column]
        if found:
            return _only(table, exact or found, "x")
    return None


def _says(title: str, column: str) -> bool:
    plain = f" {_plain(title)} "
    found = any(f" {word} " in plain for word in (_plain(column), *_WORDS.get(column, ())))
    return (found or plain.rstrip().endswith(_ENDINGS.get(column, "\n"))) and not _is_load(title)


def _said(table: TextTable, x: int, columns: Sequence[str]) -> str:
    """The column of the history that the name of x says: that name itself, or one that its words stand for."""
    title = table.titles[x]
    if not table.has_titles:
        return "opening"
    own = [column for column in columns if _plain(title) == _plain(column)]
    column = own[0] if own else next((column for column in _WORDS if _says(title, column)), None)
    if column == "cmod" and column not in columns:
        column = "opening"
    if column is None or column not in columns:
        what = "says no column of the history" if column is None else f"says {column}, which this run has not"
        raise TableError(f"the name of column {x + 1}, {title!r}, {what}; expected reference.against = {_or(columns)}")
    return column


def _or(names: Sequence[str]) -> str:
    return " or ".join(f"'{name}'" for name in names)


# -- units and checks -------------------------------------------------------------------------------


def _unit(table: TextTable, column: int, given: str | None, known: dict[str, float], key: str) -> tuple[str, float]:
    """Unit of a column, that of the scene before that of the file, and its factor; without one it is mm or N."""
    if given is not None:
        return given, factor_of(given, known, f"reference.{key}_unit")
    unit = table.units[column]
    if unit and unit not in known:
        what = "length" if known is LENGTHS else "force"
        raise TableError(
            f"column {column + 1} ({table.titles[column]}): its unit {unit} is no {what}; expected another column, or "
            f"reference.{key}_unit"
        )
    return unit, known.get(unit, 1.0)


def _check_band(table: TextTable, x: int, values: Array) -> None:
    """Refuse a band whose x does not rise, or whose lower bound is above the upper one."""
    if (back := np.flatnonzero(np.diff(values[:, 0]) <= 0)).size:
        raise TableError(f"{table.place(int(back[0]) + 1, x)}: it does not rise; the x of a band has to")
    if (crossed := np.flatnonzero(values[:, 1] > values[:, 2])).size:
        row = int(crossed[0])
        raise TableError(
            f"line {int(table.numbers[row])}: the lower bound {values[row, 1]:g} N is above the upper, {values[row, 2]:g} N"
        )


def _remarks(x: Array, against: str) -> list[str]:
    """What is left out of a curve whose x runs back; refused if hardly anything is left."""
    furthest = np.maximum.accumulate(x)
    back = x < furthest
    kept = int((np.diff(furthest) > 0).sum()) + 1
    if kept < 2:
        raise TableError(
            "its x never goes further than in the first row; expected it to rise, or reference.x_unit = '-mm' to turn it"
        )
    if not back.any():
        return []
    return [
        f"{against} runs back in {int(back.sum())} of its {len(x)} rows, by up to {float((furthest - x).max()):.3g} mm; the "
        "load counts with which it is reached first"
    ]
