"""Several specimens of one concrete: their table of dimensions, and the statistics of what came out of each.

EN 1990:2002, Annex D, D.7.2: the characteristic value of a property that is normally distributed, from n tests, is
m (1 - k_n V) with mean m and coefficient of variation V. Table D1 gives k_n for the 5 % fractile; if V is not known from
before, it is that of the tests, and k_n = t_.95(n - 1) sqrt(1 + 1/n), t being the fractile of Student's distribution.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from scipy.special import stdtrit

from ..errors import SceneError
from .columns import plain
from .fields import Dialect, TableError
from .heading import dimension_of, factor_to
from .text_table import read_tables
from .units import split_title

#: columns of a table of specimens that are not dimensions, with what they are in a scene
_KEYS = {"file": "reference.file", "sheet": "reference.sheet", "block": "reference.block", "x": "reference.x",
         "y": "reference.y", "x unit": "reference.x_unit", "y unit": "reference.y_unit", "against": "reference.against",
         "name": "name", "mass loading": "mass_loading", "gauge holder": "gauge_holder"}  # fmt: skip
_COLUMNS = ("reference.x", "reference.y")

#: rows of statistics, and the attributes that they show
_STATISTICS = {"mean": "mean", "standard deviation": "deviation", "coefficient of variation": "variation", "n": "count",
               "k_n": "k_n", "characteristic value": "characteristic"}  # fmt: skip

#: what a characteristic value is, in words
CHARACTERISTIC = "mean - k_n s, 5 % fractile of a normal distribution, EN 1990 Annex D, table D1, V_X unknown"


@dataclass(frozen=True)
class Specimen:
    """One specimen of a series.

    Attributes
    ----------
    name : in the table, else that of its block, sheet or file
    file : with its curve
    values : what the table says of it, by the keys of a scene and of `evaluate`: mm and kg
    """

    name: str
    file: Path
    values: Mapping[str, float | str]


@dataclass(frozen=True)
class Statistics:
    """Statistics of one quantity over a series.

    Attributes
    ----------
    count : number of specimens that have it
    mean, deviation : with n - 1; NaN for a single one
    variation : deviation over mean
    k_n : factor of EN 1990, table D1, V_X unknown
    characteristic : mean - k_n deviation, the 5 % fractile
    """

    count: int
    mean: float
    deviation: float
    variation: float
    k_n: float
    characteristic: float


@dataclass(frozen=True)
class Series:
    """Numbers of several specimens, and their statistics.

    Attributes
    ----------
    names : of the specimens
    values : for each quantity the numbers of all, None if a curve does not reach so far
    units : of the quantities
    intervals : of some quantities the ends for each specimen, None if they are not known
    """

    names: Sequence[str]
    values: Mapping[str, Sequence[float | None]]
    units: Mapping[str, str]
    intervals: Mapping[str, Sequence[Sequence[float | None]]] = field(default_factory=dict)

    @property
    def statistics(self) -> dict[str, Statistics]:
        """Of each quantity."""
        return {name: statistics([value for value in each if value is not None]) for name, each in self.values.items()}

    def rows(self) -> list[list[str | float | None]]:
        """The table: a heading, each specimen with its intervals, then the statistics."""
        every = self.statistics

        def row(title: str, cells: Mapping[str, Any], ends: Mapping[str, Sequence[Any]]) -> list[str | float | None]:
            both = ((cell, *(ends.get(name, (None, None)) if name in self.intervals else ())) for name, cell in cells.items())
            return [title, *(_finite(value) for pair in both for value in pair)]

        titles = {name: f"{name} [{self.units[name]}]".removesuffix(" []") for name in self.values}
        head = row("specimen", titles, {name: (f"{name} from", f"{name} to") for name in titles})
        each = [
            row(title, {name: column[i] for name, column in self.values.items()}, {k: v[i] for k, v in self.intervals.items()})
            for i, title in enumerate(self.names)
        ]
        summed = [
            row(title, {name: getattr(one, own) for name, one in every.items()}, {}) for title, own in _STATISTICS.items()
        ]
        return [head, *each, *summed]

    def summary(self) -> str:
        """The printed table."""
        rows = [
            ["-" if cell is None else cell if isinstance(cell, str) else f"{cell:.4g}" for cell in each]
            for each in self.rows()
        ]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        lines = [
            row[0].ljust(widths[0]) + "".join(f"  {cell:>{width}}" for cell, width in zip(row[1:], widths[1:], strict=True))
            for row in rows
        ]
        return "\n".join([*lines, f"characteristic value: {CHARACTERISTIC}"])


def _finite(value: float | str | None) -> float | str | None:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def statistics(values: Sequence[float]) -> Statistics:
    """Mean, scatter and characteristic value of some tests."""
    count, mean = len(values), float(np.mean(values)) if values else math.nan
    if count < 2:
        return Statistics(count, mean, math.nan, math.nan, math.nan, math.nan)
    deviation, factor = float(np.std(values, ddof=1)), k_n(count)
    variation = deviation / abs(mean) if mean else math.nan
    return Statistics(count, mean, deviation, variation, factor, mean - factor * deviation)


def k_n(count: int) -> float:
    """Factor of EN 1990, table D1, V_X unknown, from the number of tests."""
    return float(stdtrit(count - 1, 0.95)) * math.sqrt(1.0 + 1.0 / count)


def specimens_of(files: Sequence[str | Path], table: str | Path | None = None) -> list[Specimen]:
    """The specimens of a series: each row of a table is one, whose curve is in one of the files; without a table each file.

    The table is text or a workbook with a heading: `file` (needed if there are several files), `name`, `sheet`, `block`, span,
    depth, thickness (or width), notch, length, mass, mass_loading, reference keys such as `y_unit`. Lengths are mm and masses
    kg, unless the heading names a unit.

    Raises
    ------
    SceneError
        Naming row and column of the table, if it cannot be read, or if rows and files do not fit.
    """
    paths = [Path(file) for file in files]
    if table is None:
        return [Specimen(path.stem, path, {}) for path in paths]
    table = Path(table)
    try:
        found = [_specimen(table, number, row, paths) for number, row in _rows(table)]
    except TableError as error:
        raise SceneError(f"--specimens {table}: {error}", "specimens") from None
    except OSError as error:
        raise SceneError(f"--specimens {table}: cannot be read: {error.strerror or error}", "specimens") from None
    if unused := [path for path in paths if path not in {each.file for each in found}]:
        raise SceneError(f"--specimens {table}: no row names the file {unused[0]}; expected one for each", "specimens")
    names = [each.name for each in found]
    return [
        each if names.count(each.name) == 1 else Specimen(f"{each.name} ({i})", each.file, each.values)
        for i, each in enumerate(found, start=1)
    ]


def _rows(table: Path) -> list[tuple[int, dict[str, str]]]:
    """Rows of a table by the titles of their columns, with their numbers in the file."""
    texts = list(read_tables(table)[0].values())
    if len(texts) > 1:
        raise TableError(f"it has {len(texts)} sheets; expected one")
    lines = [(i, line) for i, line in enumerate(texts[0].splitlines(), start=1) if line.strip(" \t;,")]
    if len(lines) < 2:
        raise TableError("expected a heading and a row for each specimen")
    separator = max("\t;,", key=lines[0][1].count)
    dialect = Dialect(separator, ".", '"' in texts[0])
    titles = dialect.fields(lines[0][1])
    rows = []
    for i, line in lines[1:]:
        fields = dialect.fields(line)
        if len(fields) != len(titles):
            raise TableError(f"line {i}: it has {len(fields)} fields, the heading {len(titles)}")
        rows.append((i, dict(zip(titles, fields, strict=True))))
    return rows


def _specimen(table: Path, number: int, row: Mapping[str, str], paths: Sequence[Path]) -> Specimen:
    values: dict[str, float | str] = {}
    for title, text in row.items():
        name, unit = split_title(title)
        bare = plain(name.removeprefix("specimen.").removeprefix("reference."))
        key = _KEYS.get(bare) or dimension_of(bare)
        if not key:
            expected = ", ".join([*_KEYS, "span", "depth", "thickness", "notch", "length", "mass"])
            raise TableError(f"column {title!r} is not known; expected {expected}")
        if not text:
            continue
        if key.startswith("reference.") or key == "name":
            values[key] = int(text) if key in _COLUMNS and text.isdigit() else text
            continue
        factor = factor_to(key, unit)
        dialects = (Dialect("\t", "."), Dialect("\t", ","))
        value = next((value for each in dialects if each.is_plain(text) and (value := each.value(text)) is not None), None)
        if value is None or factor is None or not value >= 0:
            raise TableError(f"line {number}, column {title!r}: {text!r}: expected a number of at least 0, in mm or kg")
        values[key] = value * factor
    file = str(values.pop("reference.file", ""))
    chosen = [path for path in paths if file in (str(path), path.name, path.stem)] if file else list(paths)
    if len(chosen) != 1:
        what = f"{file!r} is none of the files" if file else "it names no file"
        raise TableError(f"line {number}: {what} {', '.join(map(str, paths))}; expected column file to name one of them")
    name = str(values.pop("name", "") or values.get("reference.block") or values.get("reference.sheet") or chosen[0].stem)
    return Specimen(name, chosen[0], values)
