"""Which columns of a measured table are the motion and the load, from keys, headings and units."""

from __future__ import annotations

import re
import reprlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from .fields import TableError
from .text_table import TextTable
from .units import FORCES, LENGTHS, SIDES, factor_in, known_unit

#: what names of columns say of themselves, the first is looked for first
_WORDS = {
    "cmod": ("crack mouth", "clip gauge", "clip gage"),
    "opening": ("opening", "cod"),
    "deflection": ("mid span", "midspan"),
    "ctod": (),
    "driven": ("driven", "displacement", "stroke", "crosshead", "cross head", "actuator", "piston", "load point"),
    "sliding": ("sliding", "slip", "cmsd", "csd"),
}
#: motions that a measured x may be, if no scene says more
MOTIONS = tuple(_WORDS)
_LOADS = ("load", "force")
#: how such names end in German and in French
_ENDINGS = {"opening": ("öffnung", "ouverture", "ouverture de fissure"), "deflection": ("durchbiegung", "flèche", "fleche"),
            "driven": ("weg", "déplacement", "deplacement"), "load": ("kraft", "force", "effort", "charge")}  # fmt: skip
_LOWER, _UPPER = {"min", "minimum", "lower", "low"}, {"max", "maximum", "upper", "high"}


@dataclass(frozen=True)
class Choice:
    """The columns that are taken, their numbers from 0.

    Attributes
    ----------
    x : one, or several gauges of one quantity, of which the mean counts
    y : the load, or the two bounds of a band
    against : the motion that x is
    notes : what else there was
    """

    x: list[int]
    y: list[int]
    against: str
    notes: list[str]


def choose(
    table: TextTable,
    x: str | int | Sequence[str | int] | None,
    y: str | int | Sequence[str | int] | None,
    against: str | None,
    motions: Sequence[str],
) -> Choice:
    """The columns of a table.

    Raises
    ------
    TableError
        If there is no such column, or if nothing says which of several is meant.
    """
    notes: list[str] = []
    wanted, gauges = _listed(y), _listed(x)
    if wanted is not None and len(wanted) not in (1, 2):
        raise TableError(f"reference.y = {y!r}: expected one column, or a list of two, lower and upper bound")
    if not table.has_titles and x is None and wanted is None and len(table.titles) == 2:
        motion = against or ("cmod" if "cmod" in motions else "opening")
        return Choice([0], [1], motion, [f"its columns have no names: column 1 is taken as {motion}, column 2 as load"])
    loads = _loads(table, notes) if wanted is None else [_named(table, name, "y") for name in wanted]
    at = _abscissa(table, against, notes) if gauges is None else [_named(table, name, "x") for name in gauges]
    if len(set(at)) < len(at):
        raise TableError(f"reference.x = {x!r}: expected different columns, of which the mean counts")
    if not at or not loads:
        what, missing = ("x", "an opening or a deflection") if not at else ("y", "a load, or load_min and load_max")
        if not table.has_titles:
            raise TableError(
                f"its {len(table.titles)} columns have no names; expected reference.{what} = number of the column"
            )
        raise TableError(
            f"its columns are {_list(table.titles)}; expected {missing} among them, or reference.{what} = name of the column"
        )
    motion = against or _said(table, at[0], motions, notes)
    if not table.has_titles:
        notes.append(f"its columns have no names: column {at[0] + 1} is taken as {motion}, column {loads[0] + 1} as load")
    return Choice(at, loads, motion, notes)


def _listed(given: str | int | Sequence[str | int] | None) -> list[str | int] | None:
    return None if given is None else [given] if isinstance(given, (str, int)) else list(given)


def _list(titles: Sequence[str]) -> str:
    """Titles of columns in an error, not more than a line of them."""
    shown = [reprlib.repr(title)[1:-1] for title in titles[:12]]
    return ", ".join(shown) + (f" and {len(titles) - 12} more" if len(titles) > 12 else "")


def _numbered(table: TextTable, columns: Iterable[int]) -> str:
    """Columns by number and title."""
    return ", ".join(f"{i + 1} ({reprlib.repr(table.titles[i])[1:-1]})" for i in columns)


def plain(title: str) -> str:
    """A title in lower case, its words parted by spaces, numbers from words too."""
    spaced = re.sub(r"(?<=[^\W\d])(?=\d)", " ", title.lower())
    return " ".join(re.split(r"[\s_()\[\]-]+", spaced)).strip()


def _named(table: TextTable, name: str | int, key: str) -> int:
    """The column that a key names by title, with its unit or without, or by number."""
    if isinstance(name, int):
        if not 1 <= name <= len(table.titles):
            raise TableError(f"it has {len(table.titles)} columns; expected reference.{key} = {name} to be one of them")
        return name - 1
    titles = list(zip(table.titles, table.full_titles, strict=True))
    exactly = [i for i, both in enumerate(titles) if name.strip() and name.strip() in both]
    nearly = [i for i, both in enumerate(titles) if plain(name) and plain(name) in map(plain, both)]
    for columns in (exactly, nearly):
        if len(columns) > 1:
            numbers = " and ".join(str(i + 1) for i in columns)
            raise TableError(
                f"columns {numbers} have the same name, {table.titles[columns[0]]!r}; expected reference.{key} = number of "
                "the one meant"
            )
        if columns:
            return columns[0]
    what = f"its columns are {_list(table.titles)}" if table.has_titles else "its columns have no names"
    raise TableError(f"there is no column {name!r} (reference.{key}); {what}")


def _candidates(table: TextTable, every: list[int], known: dict[str, float]) -> list[int]:
    """Columns that may be meant: those that change, and whose unit is not of another kind; if there are none, all."""
    kind = [i for i in every if not known_unit(table.units[i]) or factor_in(table.units[i], known) is not None] or every
    return kind if len(kind) < 2 else [i for i in kind if not table.is_constant(i)] or kind


def _has_unit(table: TextTable, column: int, known: dict[str, float]) -> bool:
    return factor_in(table.units[column], known) is not None


# -- loads ------------------------------------------------------------------------------------------


def _loads(table: TextTable, notes: list[str]) -> list[int]:
    """The column with a load, or the two with the bounds of a band; empty if there is none."""
    named = [i for i, title in enumerate(table.titles) if is_load(title)]
    if any(plain(table.titles[i]) == "load" for i in named):  # of a history with several drives: "load" is that of the stage
        named = [i for i in named if not re.match(r"load\.\D", table.titles[i])]
    every = _candidates(table, named, FORCES)
    lower, upper = ([i for i in every if words & set(plain(table.titles[i]).split())] for words in (_LOWER, _UPPER))
    lower, upper = (_best(table, side) for side in (lower, upper))
    if len(lower) == 1 and len(upper) == 1:
        if others := [i for i in named if i not in lower + upper]:
            band, rest = _numbered(table, lower + upper), _numbered(table, others)
            notes.append(f"columns {band} are taken as a band; it also has {rest}")
        return lower + upper
    single = _best(table, [i for i in every if i not in lower + upper])
    if len(single) > 1:
        raise TableError(
            f"columns {_numbered(table, single)} are all loads: are they different specimens? expected reference.x and "
            "reference.y = names or numbers of the columns of one"
        )
    if single and (others := [i for i in named if i not in single]):
        notes.append(f"column {_numbered(table, single)} is taken as load; it also has {_numbered(table, others)}")
    return single


def _best(table: TextTable, columns: list[int]) -> list[int]:
    """Those that name their unit, if any does."""
    return [i for i in columns if _has_unit(table, i, FORCES)] or columns


def is_load(title: str) -> bool:
    """Whether a title names a load."""
    words = plain(title).split()
    return any(word in _LOADS or word.endswith(_ENDINGS["load"]) for word in words) and "point" not in words


# -- motions ----------------------------------------------------------------------------------------


def _abscissa(table: TextTable, against: str | None, notes: list[str]) -> list[int]:
    """The columns whose name says the first motion that there is: what x is drawn against, or cmod, an opening, a deflection
    and so on, one with its unit before one without; several if they are gauges of one quantity."""
    order = [*([] if against is None else [against]), *MOTIONS]
    motion_of = {
        i: next((place for place, motion in enumerate(order) if _says(title, motion)), None)
        for i, title in enumerate(table.titles)
    }
    named = [i for i, place in motion_of.items() if place is not None]
    every = _candidates(table, named, LENGTHS)
    if not every:
        return []

    def rank(i: int) -> tuple[bool, bool, int]:
        place = motion_of[i]
        assert place is not None
        return place > 0 or against is None, not _has_unit(table, i, LENGTHS), place

    first = min(every, key=rank)
    alike = [i for i in every if rank(i) == rank(first)]
    exact = [i for i in alike if plain(table.titles[i]) == order[rank(first)[2]]]
    gauges = [i for i in alike if _stem(table.titles[i]) == _stem(table.titles[first])]
    taken = gauges if len(gauges) > 1 else exact[:1] or [first]
    others = [i for i in named if i not in taken]
    also = f"; it also has {_numbered(table, others)}" if others else ""
    if len(taken) > 1:
        notes.append(f"columns {_numbered(table, taken)} are gauges of one quantity: x is their mean{also}")
    elif others:
        notes.append(f"column {_numbered(table, taken)} is taken as x{also}")
    return taken


def _stem(title: str) -> str:
    """A title without what tells gauges of one quantity apart."""
    return " ".join(word for word in plain(title).split() if not word.isdecimal() and word not in SIDES)


def is_motion(title: str) -> bool:
    """Whether a title names a motion that x may be."""
    return any(_says(title, motion) for motion in MOTIONS)


def _says(title: str, motion: str) -> bool:
    words = plain(title).split()
    says = any(f" {word} " in f" {plain(title)} " for word in (plain(motion), *_WORDS.get(motion, ())))
    ends = any(word.endswith(_ENDINGS.get(motion, ("\n",))) for word in words)
    return (says or ends) and not is_load(title)


def _said(table: TextTable, x: int, motions: Sequence[str], notes: list[str]) -> str:
    """The motion that the name of x says: that name itself, or one that its words stand for."""
    title = table.titles[x]
    own = [motion for motion in motions if plain(title) == plain(motion)]
    motion = own[0] if own else next((motion for motion in MOTIONS if _says(title, motion)), None)
    if not table.has_titles:
        motion = "opening"
    if motion == "opening" and "cmod" in motions:
        motion = "cmod"  # over a notch a gauge measures the opening of the crack mouth
        if own == ["opening"]:
            notes.append(
                f"column {x + 1} ({title}) is taken as cmod, that of the gauge over the notch; if it is the mean jump of the "
                "crack, say reference.against = 'opening'"
            )
    if motion == "cmod" and "cmod" not in motions:
        motion = "opening"
    if motion is None or motion not in motions:
        what = "says no column of the history" if motion is None else f"says {motion}, which this run has not"
        raise TableError(
            f"the name of column {x + 1}, {title!r}, {what}; expected reference.against = "
            + " or ".join(f"'{name}'" for name in motions)
        )
    return motion
