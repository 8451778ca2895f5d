"""Which of several specimens in one file is meant: sheets of a workbook, tables one below the other, columns side by side."""

from __future__ import annotations

import re
import reprlib
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..arrays import Array
from .columns import is_load, is_motion, plain
from .fields import TableError
from .heading import name_in
from .text_table import TextTable, parse_tables

#: a table continues the one before it if its first row is nearer to the last row of that than this part of the way from its
#: first one
_NEAR = 0.5

#: how all specimens of a file are taken
_SERIES = "; evaluate and fit take all of them with --specimens TABLE"

#: rows from which the width of a column is taken
_SAMPLE = 100


def one_block(texts: Mapping[str, str], sheet: str | int | None, block: str | int | None) -> tuple[TextTable, list[str]]:
    """The table of one specimen, and what was done to get it, a sentence each.

    Raises
    ------
    TableError
        If there is none of this name, or if nothing says which of several is meant.
    """
    tables, notes = _of_sheet(texts, sheet)
    if below := tables[-1].below:
        first = reprlib.repr(below[0].strip())
        notes.append(f"{len(below)} line(s) below its rows are text, from {first} on, and are left out")
    tables, joined = _joined(tables)
    notes += joined
    own = _distinct([name_in(table.above, table.dialect)[0] for table in tables]) if len(tables) > 1 else [""] * len(tables)
    named: list[tuple[list[str], TextTable]] = []
    for table, name in zip(tables, own, strict=True):
        named += [([each for each in (name, column) if each], part) for column, part in _side_by_side(table)]
    if len(named) == 1:
        table = named[0][1]
        name = name_in(table.above, table.dialect)[0]
        if block not in (None, 1, name):
            raise TableError(f"reference.block = {block!r}: it holds one table" + (f", {name!r}" if name else ""))
        return table, notes
    names = [" ".join(words) or str(number) for number, (words, _) in enumerate(named, start=1)]
    shown = ", ".join(map(repr, names[:12])) + (f" and {len(names) - 12} more" if len(names) > 12 else "")
    if block is None:
        raise TableError(
            f"it holds {len(names)} specimens, {shown}: expected reference.block = the name or number of one{_SERIES}"
        )
    chosen = [i for i, name in enumerate(names) if plain(str(block)) == plain(name)]
    if not chosen and isinstance(block, int) and 1 <= block <= len(names):
        chosen = [block - 1]
    if len(chosen) != 1:
        raise TableError(f"reference.block = {reprlib.repr(block)}: expected one of {shown}, or a number up to {len(names)}")
    return named[chosen[0]][1], notes


def _of_sheet(texts: Mapping[str, str], sheet: str | int | None) -> tuple[list[TextTable], list[str]]:
    """The tables of the sheet that is meant."""
    names = list(texts)
    if sheet is not None:
        if names == [""]:
            raise TableError(f"reference.sheet = {sheet!r}: it is no workbook")
        number = sheet - 1 if isinstance(sheet, int) and str(sheet) not in names else None
        name = names[number] if number is not None and 0 <= number < len(names) else str(sheet)
        if name not in names:
            raise TableError(f"reference.sheet = {sheet!r}: expected one of {', '.join(map(repr, names))}")
        return parse_tables(texts[name]), []
    if len(names) == 1:
        return parse_tables(texts[names[0]]), []
    found, errors = {}, {}
    for name in names:
        try:
            found[name] = parse_tables(texts[name])
        except TableError as error:
            errors[name] = error
    if not found:
        raise TableError("; ".join(f"sheet {name!r} {error}" for name, error in errors.items()))
    if len(found) > 1:
        shown = ", ".join(map(repr, found))
        raise TableError(f"it has tables on the sheets {shown}: expected reference.sheet = the name or number of one{_SERIES}")
    (name,) = found
    return found[name], [f"sheet {name!r} is read; {', '.join(map(repr, errors))} has no table of numbers"]


def _joined(tables: Sequence[TextTable]) -> tuple[list[TextTable], list[str]]:
    """Tables that go on where the one before them ends, as machines that repeat their heading write them, put together."""
    wholes, counts, last = [tables[0]], [1], tables[0]
    for table in tables[1:]:
        if _continues(wholes[-1], last, table):
            whole = wholes[-1]
            wholes[-1] = replace(whole, rows=[*whole.rows, *table.rows], numbers=np.r_[whole.numbers, table.numbers])
            counts[-1] += 1
        else:
            wholes.append(table)
            counts.append(1)
        last = table
    most = max(counts)
    return wholes, [f"{most} tables of one heading go on where the one before ends, and count as one"] if most > 1 else []


def _continues(whole: TextTable, last: TextTable, table: TextTable) -> bool:
    """Whether a table goes on where `last`, the end of `whole`, stops: by its titles, its specimen and its numbers."""
    if list(last.full_titles) != list(table.full_titles) or len(last.titles) != len(table.titles):
        return False
    first, own = name_in(whole.above, whole.dialect), name_in(table.above, table.dialect)
    if own[1] and first != own:
        return False
    begin, end, after = (_numbers(each, row) for each, row in ((whole, 0), (last, -1), (table, 0)))
    some = np.linspace(0, len(whole.rows) - 1, _SAMPLE).astype(int)
    width = np.ptp([*(_numbers(whole, row) for row in some), after], axis=0)
    is_known = np.isfinite(width) & (width > 0)
    to_end, to_begin = (np.linalg.norm((after - each)[is_known] / width[is_known]) for each in (end, begin))
    return bool(to_end < _NEAR * to_begin)


def _numbers(table: TextTable, row: int) -> Array:
    values = [table.dialect.value(field) for field in table.dialect.fields(table.rows[row])]
    return np.array([np.nan if value is None else value for value in values])


def _side_by_side(table: TextTable) -> list[tuple[str, TextTable]]:
    """The columns of each specimen with its name, if there are several; columns that belong to none are shared."""
    groups = _by_group(table) or _by_word(table) or _by_order(table)
    if not groups:
        return [("", table)]
    own = {i for columns in groups.values() for i in columns}
    parts = []
    for name, columns in groups.items():
        hidden = own - set(columns)
        titles = ["" if i in hidden else _bare(title) for i, title in enumerate(table.titles)]
        full = ["" if i in hidden else title for i, title in enumerate(table.full_titles)]
        parts.append((name, replace(table, titles=titles, full_titles=full)))
    return parts


def _bare(title: str) -> str:
    """A title without the number by which pandas tells it from one before it, as in "load.1"."""
    return re.sub(r"\.\d+$", "", title)


def _whole(table: TextTable, groups: Mapping[str, list[int]]) -> dict[str, list[int]]:
    """The groups with a load and a motion, if they are several and share no column."""
    titles = [_bare(title) for title in table.titles]
    found = {
        name: columns
        for name, columns in groups.items()
        if any(is_load(titles[i]) for i in columns) and any(is_motion(titles[i]) for i in columns)
    }
    every = [i for columns in found.values() for i in columns]
    return found if len(found) > 1 and len(set(every)) == len(every) else {}


def _by_group(table: TextTable) -> dict[str, list[int]]:
    """By what stands over the titles."""
    return _whole(table, {name: [i for i, own in enumerate(table.groups) if own == name] for name in table.groups if name})


def _by_word(table: TextTable) -> dict[str, list[int]]:
    """By a word with a digit, or a single letter, that titles share, as in "Load B1" and "CMOD B1"."""
    words = [
        [word for word in re.split(r"[\s_.()\[\]-]+", title) if re.search(r"\d", word) or re.fullmatch(r"[A-Z]", word)]
        for title in table.titles
    ]
    shared = dict.fromkeys(word for each in words for word in each)
    return _whole(table, {word: [i for i, each in enumerate(words) if word in each] for word in shared})


def _by_order(table: TextTable) -> dict[str, list[int]]:
    """By the titles themselves, of which the whole list is repeated: numbered from 1."""
    titles = [_bare(title).lower() for title in table.titles]
    count = len(titles)
    periods = [k for k in range(2, count // 2 + 1) if count % k == 0 and titles == titles[:k] * (count // k)]
    if not periods:
        return {}
    period = periods[0]
    return _whole(table, {str(k // period + 1): list(range(k, k + period)) for k in range(0, count, period)})


def _distinct(names: Sequence[str]) -> list[str]:
    """Names that differ: numbers if some are the same or empty."""
    return list(names) if all(names) and len(set(names)) == len(names) else [str(i + 1) for i in range(len(names))]
