"""Tables of numbers in text files as laboratories export them: any separator, decimal sign, encoding and heading."""

from __future__ import annotations

import codecs
import csv
import os
import re
import reprlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..arrays import Array
from .units import bare_unit, split_title

#: larger files are refused, bytes
_LARGEST = 500_000_000

#: a longer line is no row of a table, characters; the csv module stops there
_LONGEST = csv.field_size_limit()

#: lines from which separator and decimal sign are found
_SAMPLE = 200

_COMMENT = ("#", "%", "//")
_SPACE = " "  # stands for any number of spaces and tabs


@dataclass(frozen=True)
class Dialect:
    """Separator (tab, ";", "," or " ") and decimal sign, and whether fields stand in quotation marks."""

    separator: str
    decimal: str
    is_quoted: bool = False

    def fields(self, line: str) -> list[str]:
        """The fields of one line."""
        if self.is_quoted and self.separator != _SPACE:
            return [field.strip() for field in next(csv.reader([line], delimiter=self.separator))]
        return line.split() if self.separator == _SPACE else [field.strip() for field in line.split(self.separator)]

    def is_number(self, field: str) -> bool:
        """Whether a field is a number, NaN and infinity included, so that they are refused as values, not as words."""
        return bool(_NUMBER[self.decimal].match(field))


_NUMBER = {
    sign: re.compile(rf"^[+-]?(\d+({sign_}\d*)?|{sign_}\d+)([eE][+-]?\d+)?$|^[+-]?(nan|inf|infinity)$", re.IGNORECASE)
    for sign, sign_ in ((".", r"\."), (",", ","))
}


class TableError(ValueError):
    """A file that is no table of numbers; the message names line and column if there is one."""


@dataclass(frozen=True)
class TextTable:
    """A table of text, its columns not yet converted.

    Attributes
    ----------
    titles : name of each column, without its unit; empty strings if the file has no heading
    full_titles : the headings as they are
    units : unit of each column; empty if none is said
    rows : lines of data
    numbers : (n,) array, the number of each of them in the file, the first is 1
    dialect : how they are written
    """

    titles: Sequence[str]
    full_titles: Sequence[str]
    units: Sequence[str]
    rows: Sequence[str]
    numbers: Array
    dialect: Dialect

    @property
    def has_titles(self) -> bool:
        """Whether the file names its columns."""
        return any(self.titles)

    def place(self, row: int, column: int) -> str:
        """Line and column in words."""
        title = f" ({self.titles[column]})" if self.titles[column] else ""
        return f"line {int(self.numbers[row])}, column {column + 1}{title}"

    def is_constant(self, column: int) -> bool:
        """Whether every row has the same text in a column."""
        first = self.dialect.fields(self.rows[0])[column]
        return len(self.rows) > 1 and all(self.dialect.fields(row)[column] == first for row in self.rows)

    def values(self, columns: Sequence[int]) -> Array:
        """Some columns as numbers, (n, k).

        Raises
        ------
        TableError
            At the first field that is no number, or is not finite.
        """
        values = np.empty((len(self.rows), len(columns)))
        for row, line in enumerate(self.rows):
            fields = self.dialect.fields(line)
            for k, column in enumerate(columns):
                field = fields[column]
                if not self.dialect.is_number(field):
                    what = f"{reprlib.repr(field)} is no number" if field else "it is empty"
                    raise TableError(f"{self.place(row, column)}: {what}")
                values[row, k] = float(field.replace(",", "."))
        if (wrong := np.argwhere(~np.isfinite(values))).size:
            row, k = wrong[0]
            field = self.dialect.fields(self.rows[row])[columns[k]]
            raise TableError(f"{self.place(row, columns[k])}: {reprlib.repr(field)} is not finite")
        return values


def read_table(path: Path) -> tuple[TextTable, bytes]:
    """The table of a file, and the file as it was read.

    Raises
    ------
    TableError
        If it is not a regular file of text with at least two columns of numbers and as many fields in every row.
    OSError
        If it cannot be read.
    """
    if not os.path.isfile(path):
        raise TableError("is not a regular file")
    if path.stat().st_size > _LARGEST:
        raise TableError(f"has {path.stat().st_size / 1e6:.0f} MB; expected at most {_LARGEST / 1e6:.0f}")
    content = path.read_bytes()
    return parse_table(_decoded(content)), content


def _decoded(content: bytes) -> str:
    """Text in UTF-8, with or without a mark, UTF-16 or, if it is neither, Latin-1."""
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        encodings = ["utf-16"]
    elif content[1:200:2].count(0) > 50:
        encodings = ["utf-16-le"]
    elif content[0:200:2].count(0) > 50:
        encodings = ["utf-16-be"]
    else:
        encodings = ["utf-8-sig", "latin-1"]
    for encoding in encodings:
        try:
            text = content.decode(encoding)
        except UnicodeDecodeError:
            continue
        if "\0" not in text:
            return text
    raise TableError("is not text; expected a table of text, as a spreadsheet exports it")


def parse_table(text: str) -> TextTable:
    """The table in a text; see `read_table`."""
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    full = [i for i, line in enumerate(lines) if line.strip(" \t;,")]
    data = [i for i in full if not lines[i].lstrip().startswith(_COMMENT)]
    if not data:
        raise TableError("is empty")
    if long := [i for i in data if len(lines[i]) > _LONGEST]:
        raise TableError(f"line {long[0] + 1}: it has {len(lines[long[0]])} characters; expected at most {_LONGEST}")
    dialect = _dialect(lines, data)
    start, first = _first_row(lines, data, dialect)
    heading = [i for i in full if i < data[start]]
    titles, headings, units = _titles(lines, heading, data[start], first, dialect)
    rows = [lines[i] for i in data[start:]]
    _check_counts(rows, data[start:], dialect, len(first))
    return TextTable(titles, headings, units, rows, np.array(data[start:]) + 1, dialect)


def _dialect(lines: Sequence[str], data: Sequence[int]) -> Dialect:
    """The separator and decimal sign with which most fields are numbers, in lines of which the last ones are data."""
    first = 0 if len(data) <= _SAMPLE else len(data) // 2
    sample = [lines[data[k]] for k in np.unique(np.linspace(first, len(data) - 1, _SAMPLE).astype(int))]
    is_quoted = any('"' in line for line in sample)
    best, most = None, 0.0
    for separator in ("\t", ";", ",", _SPACE):
        for decimal in (".", ","):
            if decimal == separator and not is_quoted:
                continue
            dialect = Dialect(separator, decimal, is_quoted)
            score = 0.0
            for line in sample:
                fields = dialect.fields(line)
                count = sum(map(dialect.is_number, fields))
                score += count / len(fields) if count >= 2 else 0.0
            if score > most * (1 + 1e-9):
                best, most = dialect, score
    if best is None:
        raise _no_row(lines, data)
    return best


def _no_row(lines: Sequence[str], data: Sequence[int]) -> TableError:
    """The error for a file without two columns of numbers."""
    last = reprlib.repr(lines[data[-1]].strip())
    return TableError(f"has no row with two numbers; its last one, line {data[-1] + 1}, is {last}")


def _first_row(lines: Sequence[str], data: Sequence[int], dialect: Dialect) -> tuple[int, list[str]]:
    """Where the data begin: the first of two rows, or of the last one, with at least two numbers and as many fields.

    The row before them must not be half a row of numbers.
    """
    before: list[str] = []
    for k, i in enumerate(data):
        fields = dialect.fields(lines[i])
        numbers = [dialect.is_number(field) for field in fields]
        after = dialect.fields(lines[data[k + 1]]) if k + 1 < len(data) else fields
        if sum(numbers) >= 2 and len(after) == len(fields) and sum(map(dialect.is_number, after)) >= 1:
            words = [column for column, field in enumerate(before) if not dialect.is_number(field)]
            if len(before) == len(fields) and 0 < len(words) < len(before):
                wrong = [column for column in words if numbers[column]]
                if wrong:
                    what = reprlib.repr(before[wrong[0]])
                    raise TableError(f"line {data[k - 1] + 1}, column {wrong[0] + 1}: {what} is no number")
            return k, fields
        before = fields
    raise _no_row(lines, data)


def _titles(
    lines: Sequence[str], heading: Sequence[int], after: int, row: Sequence[str], dialect: Dialect
) -> tuple[list[str], ...]:
    """Names, whole headings and units of the columns, from the lines above the first `row` of data in line `after`, the
    nearest first."""
    count, units = len(row), [""] * len(row)

    def fields_of(i: int) -> list[str]:
        line = lines[i].lstrip()
        fields = _heading_fields(line.lstrip("#%/") if line.startswith(_COMMENT) else lines[i], dialect, count)
        is_short = len(fields) == count - 1 and not row[-1]  # every row ends with a separator
        return [*fields, ""] if is_short else fields

    for k in reversed(range(len(heading))):
        i = heading[k]
        is_comment = lines[i].lstrip().startswith(_COMMENT)
        fields = fields_of(i)
        if len(fields) == count:
            filled = [field for field in fields if field not in ("", "-", "[-]")]
            known = sum(bool(bare_unit(field)) for field in filled)
            is_below = k > 0 and len(fields_of(heading[k - 1])) == count
            if known and (known == len(filled) or (is_below and 2 * known >= len(filled))):  # else refused by its name
                units = [bare_unit(field) or (field if field in filled else "") for field in fields]
                continue
            split = [split_title(field) for field in fields]
            names = [name for name, _ in split]
            return names, fields, [unit or below for (_, unit), below in zip(split, units, strict=True)]
        if not is_comment and len(fields) > 1:
            raise TableError(
                f"line {after + 1}: it has {count} fields, the row before it {len(fields)}"
                if sum(map(dialect.is_number, fields)) > 1
                else f"line {i + 1}: the heading has {len(fields)} fields and the rows below it {count}; expected as many, "
                "and another separator than the decimal sign"
            )
        if not is_comment:
            break
    return [""] * count, [""] * count, units


def _heading_fields(line: str, dialect: Dialect, count: int) -> list[str]:
    """The fields of a heading: "CMOD, mm, Load, N" has a unit in every second one, and names may hold spaces."""
    if dialect.separator == _SPACE:
        patterns = (r"\s{2,}|\t", r"\s+(?![\[(])", r"\s+")
        splits = [re.split(pattern, line.strip()) for pattern in patterns]
        return next((fields for fields in splits if len(fields) == count), splits[0])
    fields = Dialect(dialect.separator, dialect.decimal, '"' in line).fields(line)
    if len(fields) == 2 * count and all(map(bare_unit, fields[1::2])):
        return [f"{name} [{unit}]" for name, unit in zip(fields[::2], fields[1::2], strict=True)]
    return fields


def _check_counts(rows: Sequence[str], numbers: Sequence[int], dialect: Dialect, count: int) -> None:
    """Refuse the first row with another number of fields."""
    counts: Iterator[int]
    if dialect.separator == _SPACE or dialect.is_quoted:
        counts = (len(dialect.fields(row)) for row in rows)
    else:
        counts = (row.count(dialect.separator) + 1 for row in rows)
    for i, fields in zip(numbers, counts, strict=True):
        if fields != count:
            raise TableError(f"line {i + 1}: it has {fields} field{'s' * (fields != 1)}, the rows before it {count}")
