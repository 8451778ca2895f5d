"""Tables of numbers in text files as laboratories export them: any separator, decimal sign, encoding and heading."""

from __future__ import annotations

import codecs
import csv
import os
import re
import reprlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..arrays import Array, Index
from .fields import SPACE, Dialect, TableError, is_lost
from .units import bare_unit, split_title
from .workbook import MARK, OLD_MARK, sheets_of

#: larger files are refused, bytes
_LARGEST = 500_000_000

#: a longer line is no row of a table, characters; the csv module stops there
_LONGEST = csv.field_size_limit()

#: lines from which separator and decimal sign are found
_SAMPLE = 200

#: part of the rows that may have lost a value
_LOST_PART = 0.1

#: number of digits in groups, as a part of one without: a plain reading comes first
_GROUPED = 0.9

#: longest heading within a file, lines
_HEADING = 200

_COMMENT = ("#", "%", "//")

#: what a spreadsheet writes into a cell whose formula fails: no comment, though the row may begin with it
_FAILED = ("#N/A", "#DIV/0!", "#VALUE!", "#REF!", "#NUM!", "#NAME?", "#NULL!")
_LETTER = re.compile(r"[^\W\d_]")


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
    groups : what stands over the title of each column, if several columns share it; empty if nothing does
    above : the lines above its titles
    below : lines of text after the last table
    """

    titles: Sequence[str]
    full_titles: Sequence[str]
    units: Sequence[str]
    rows: Sequence[str]
    numbers: Array
    dialect: Dialect
    groups: Sequence[str] = ()
    above: Sequence[str] = ()
    below: Sequence[str] = ()

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
        """Some columns as numbers, (n, k); NaN if a value is lost.

        Raises
        ------
        TableError
            At the first field that is no number, or is infinite.
        """
        values, fields = np.empty((len(self.rows), len(columns))), [self.dialect.fields(row) for row in self.rows]
        for k, column in enumerate(columns):
            texts = [each[column] for each in fields]
            try:
                self.dialect.check_groups(texts)
            except TableError as error:
                raise TableError(f"column {column + 1} ({self.titles[column]}): {error}") from None
            for row, field in enumerate(texts):
                value = self.dialect.value(field)
                if value is None and not is_lost(field):
                    raise TableError(f"{self.place(row, column)}: {reprlib.repr(field)} is no number")
                values[row, k] = np.nan if value is None else value
        if (wrong := np.argwhere(np.isinf(values))).size:
            row, k = wrong[0]
            raise TableError(f"{self.place(row, columns[k])}: {reprlib.repr(fields[row][columns[k]])} is not finite")
        return values

    def without_lost(self, columns: Sequence[int]) -> tuple[TextTable, Array, list[str]]:
        """The table without rows in which a value of some columns is lost, these as numbers, and a sentence on it.

        Raises
        ------
        TableError
            As `values`; if more than a tenth of the rows are without a value.
        """
        end = len(self.rows)
        while end and not any(self.dialect.fields(self.rows[end - 1])[column] for column in columns):
            end -= 1  # a shorter one of several side by side
        if not end:
            raise TableError(f"column {columns[0] + 1} ({self.titles[columns[0]]}) is empty")
        if end < len(self.rows):
            return self.part(np.arange(end)).without_lost(columns)
        values = self.values(columns)
        lost = np.argwhere(np.isnan(values))
        if not lost.size:
            return self, values, []
        row, column = int(lost[0, 0]), columns[int(lost[0, 1])]
        field, count = self.dialect.fields(self.rows[row])[column], len(np.unique(lost[:, 0]))
        what = f"{self.place(row, column)}: " + (f"{reprlib.repr(field)} is no value" if field else "it is empty")
        if count > _LOST_PART * len(values):
            more = f", and {count - 1} more of its {len(values)} rows have none" if count > 1 else ""
            raise TableError(f"{what}{more}; expected at most {100 * _LOST_PART:g} % of the rows without a value")
        kept = np.flatnonzero(np.isfinite(values).all(axis=1))
        said = f"{count} of its {len(values)} rows are left out, because a value is lost; the first is {what}"
        return self.part(kept), values[kept], [said]

    def part(self, rows: Index) -> TextTable:
        """The table with some of its rows."""
        return replace(self, rows=[self.rows[row] for row in rows], numbers=self.numbers[rows])


def read_tables(path: Path) -> tuple[dict[str, str], bytes]:
    """The texts of a file by name of the sheet, of a file of text one without a name; and the file as it was read.

    Raises
    ------
    TableError
        If it is not a regular file of text, nor a workbook.
    OSError
        If it cannot be read.
    """
    if not os.path.isfile(path):
        raise TableError("is not a regular file")
    if path.stat().st_size > _LARGEST:
        raise TableError(f"has {path.stat().st_size / 1e6:.0f} MB; expected at most {_LARGEST / 1e6:.0f}")
    content = path.read_bytes()
    if content.startswith(OLD_MARK):
        raise TableError("is a workbook of the time before 2007: expected it saved as xlsx, or a sheet exported as text")
    return (sheets_of(content, _LARGEST) if content.startswith(MARK) else {"": _decoded(content)}), content


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


def parse_tables(text: str) -> list[TextTable]:
    """The tables in a text, one below the other, each with the lines above it.

    A heading ends a table, and so do blank lines and comments between rows, if more than two rows stand between any of them.

    Raises
    ------
    TableError
        If it has not at least two columns of numbers and as many fields in every row.
    """
    lines = text.replace("\r\n", "\n").replace("\r", "\n").replace("\xa0", " ").replace("\u202f", " ").split("\n")
    full = [i for i, line in enumerate(lines) if line.strip(" \t;,")]
    data = [i for i in full if not lines[i].lstrip().startswith(_COMMENT) or lines[i].lstrip().startswith(_FAILED)]
    if not data:
        raise TableError("is empty")
    if long := [i for i in data if len(lines[i]) > _LONGEST]:
        raise TableError(f"line {long[0] + 1}: it has {len(lines[long[0]])} characters; expected at most {_LONGEST}")
    dialect = _dialect(lines, data)
    start = _first_row(lines, data, dialect)
    end = len(data)
    while end > start + 2 and _is_text(dialect.fields(lines[data[end - 1]]), dialect):
        end -= 1
    below, data = [lines[i] for i in data[end:]], data[:end]
    parts = _parts(lines, data[start:], dialect)
    tables: list[TextTable] = []
    after = -1
    for rows in parts:
        heading = [i for i in full if after < i < rows[0]] if not tables else _between(lines, after, rows[0])
        fields = dialect.fields(lines[rows[0]])
        titles, headings, units, groups = _titles(lines, heading, rows[0], fields, dialect)
        if tables and not any(titles) and len(fields) == len(tables[-1].titles):
            titles, headings, units, groups = tables[-1].titles, tables[-1].full_titles, tables[-1].units, tables[-1].groups
        texts = [lines[i] for i in rows]
        _check_counts(texts, rows, dialect, len(fields))
        above = [lines[i] for i in heading]
        tables.append(TextTable(titles, headings, units, texts, np.array(rows) + 1, dialect, groups, above))
        after = rows[-1]
    tables[-1] = replace(tables[-1], below=below)
    return tables


def _is_text(fields: Sequence[str], dialect: Dialect) -> bool:
    """Whether a line is no row, not even one whose values are all lost."""
    return not any(dialect.is_number(field) or is_lost(field) for field in filter(None, fields))


def _between(lines: Sequence[str], after: int, before: int) -> list[int]:
    """The lines between two rows that are not blank."""
    return [i for i in range(after + 1, before) if lines[i].strip(" \t;,")]


def _parts(lines: Sequence[str], data: Sequence[int], dialect: Dialect) -> list[list[int]]:
    """The rows of each table, by the numbers of their lines; a line that is wrong stays a row, to be refused by its number."""
    parts, k = [[data[0]]], 1
    while k < len(data):
        if _LETTER.search(lines[data[k]]) and (end := _end_of_heading(lines, data, k, dialect)):
            parts.append([data[end]])
            k = end + 1
            continue
        parts[-1].append(data[k])
        k += 1
    return [piece for part in parts for piece in _split_at_gaps(part)]


def _end_of_heading(lines: Sequence[str], data: Sequence[int], k: int, dialect: Dialect) -> int:
    """The first row of numbers after a heading that begins at k; 0 if no line there is the titles of its columns."""
    counts: list[tuple[int, int]] = []
    for end in range(k, min(k + _HEADING, len(data))):
        fields = dialect.fields(lines[data[end]])
        numbers = sum(map(dialect.is_number, fields))
        if numbers >= 1 and numbers + sum(map(is_lost, filter(None, fields))) >= 2:
            return end if any(words >= 2 and count == len(fields) for count, words in counts) else 0
        counts.append((len(fields), 0 if numbers else sum(map(bool, fields))))
    return 0


def _split_at_gaps(rows: list[int]) -> list[list[int]]:
    """Rows with blank lines or comments between them, if all parts are longer than two rows."""
    gaps = np.flatnonzero(np.diff(rows) > 1) + 1
    parts = [list(part) for part in np.split(np.array(rows), gaps)] if gaps.size else [rows]
    return parts if all(len(part) > 2 for part in parts) else [rows]


def _dialect(lines: Sequence[str], data: Sequence[int]) -> Dialect:
    """The separator and decimal sign with which most fields are numbers, in lines of which the last ones are data."""
    first = 0 if len(data) <= _SAMPLE else len(data) // 2
    sample = [lines[data[k]] for k in np.unique(np.linspace(first, len(data) - 1, _SAMPLE).astype(int))]
    is_quoted = any('"' in line for line in sample)
    best, most = None, 0.0
    for separator in ("\t", ";", ",", SPACE):
        for decimal in (".", ","):
            if decimal == separator and not is_quoted:
                continue
            dialect = Dialect(separator, decimal, is_quoted)
            scores: dict[int, float] = {}  # by the number of fields, which headings between the rows do not share
            for line in sample:
                fields = dialect.fields(line)
                count = sum(1.0 if dialect.is_plain(each) else _GROUPED * dialect.is_grouped(each) for each in fields)
                if count >= 2 * _GROUPED:
                    scores[len(fields)] = scores.get(len(fields), 0.0) + count / len(fields)
            score = max(scores.values(), default=0.0)
            if score > most * (1 + 1e-9):
                best, most = dialect, score
    if best is None:
        raise _no_row(lines, data)
    return best


def _no_row(lines: Sequence[str], data: Sequence[int]) -> TableError:
    """The error for a file without two columns of numbers."""
    last = reprlib.repr(lines[data[-1]].strip())
    return TableError(f"has no row with two numbers; its last one, line {data[-1] + 1}, is {last}")


def _first_row(lines: Sequence[str], data: Sequence[int], dialect: Dialect) -> int:
    """Where the data begin: the first of two rows, or of the last one, with at least two numbers and as many fields.

    The row before them must not be half a row of numbers.
    """
    before: list[str] = []
    for k, i in enumerate(data):
        fields = dialect.fields(lines[i])
        numbers = [dialect.is_number(field) for field in fields]
        after = dialect.fields(lines[data[k + 1]]) if k + 1 < len(data) else fields
        lost = [not number and field != "" and is_lost(field) for number, field in zip(numbers, fields, strict=True)]
        is_row = any(numbers) and sum(numbers) + sum(lost) >= 2
        if is_row and len(after) == len(fields) and any(map(dialect.is_number, after)):
            words = [column for column, field in enumerate(before) if not dialect.is_number(field) and not is_lost(field)]
            if len(before) == len(fields) and words and any(map(dialect.is_number, before)):
                wrong = [column for column in words if numbers[column]]
                if wrong:
                    what = reprlib.repr(before[wrong[0]])
                    raise TableError(f"line {data[k - 1] + 1}, column {wrong[0] + 1}: {what} is no number")
            return k
        before = fields
    raise _no_row(lines, data)


def _titles(
    lines: Sequence[str], heading: Sequence[int], after: int, row: Sequence[str], dialect: Dialect
) -> tuple[Sequence[str], ...]:
    """Names, whole headings, units and groups of the columns, from the lines above the first `row` of data in line `after`,
    the nearest first."""
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
            said = [unit or below for (_, unit), below in zip(split, units, strict=True)]
            over = fields_of(heading[k - 1]) if k else []
            return names, fields, said, _groups(over) if len(over) == count else []
        if not is_comment and len(fields) > 1:
            raise TableError(
                f"line {after + 1}: it has {count} fields, the row before it {len(fields)}"
                if sum(map(dialect.is_number, fields)) > 1
                else f"line {i + 1}: the heading has {len(fields)} fields and the rows below it {count}; expected as many, "
                "and another separator than the decimal sign"
            )
        if not is_comment:
            break
    return [""] * count, [""] * count, units, []


def _groups(over: Sequence[str]) -> list[str]:
    """What stands over each column, a name counting for the empty fields behind it too; nothing if it is one name, or many."""
    names: list[str] = []
    for field in over:
        names.append(field or (names[-1] if names else ""))
    each = [name for name in over if name]
    return names if len(each) > 1 and any(names.count(name) > 1 for name in each) else []


def _heading_fields(line: str, dialect: Dialect, count: int) -> list[str]:
    """The fields of a heading: "CMOD, mm, Load, N" has a unit in every second one, and names may hold spaces."""
    if dialect.separator == SPACE:
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
    if dialect.separator == SPACE or dialect.is_quoted:
        counts = (len(dialect.fields(row)) for row in rows)
    else:
        counts = (row.count(dialect.separator) + 1 for row in rows)
    for i, fields in zip(numbers, counts, strict=True):
        if fields != count:
            raise TableError(f"line {i + 1}: it has {fields} field{'s' * (fields != 1)}, the rows before it {count}")
