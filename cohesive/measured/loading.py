"""The rows of a measured table that belong to its test, and what its motion is counted from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from .fields import TableError
from .noise import deviation_of, outside_of, unloadings

#: a gauge that begins further from 0 than this part of its way to the largest load, under less than that part of it, was not
#: set to zero; from the smaller part on it is said
_OFFSET, _SAID, _UNLOADED = 0.25, 0.02, 0.1

#: part of the largest load from which on a load at the start is said
_PRELOAD = 0.01

#: a cycle up to this part of the largest load, before it, that ends under less than that part of its own, is a pre-load
_SEATING, _RELEASED = 0.6, 0.5

#: rows from which on a straight line finds the first motion better than the first row does
_LINE = 10


@dataclass(frozen=True)
class Corrections:
    """What a user says of the rows, see `read_measured`."""

    x_offset: float | None = None
    y_offset: float | None = None
    rows: Sequence[int] | None = None
    from_load: float | None = None
    toe: Sequence[float] | None = None
    smooth: int | None = None


@dataclass(frozen=True)
class Loading:
    """The rows of a test.

    Attributes
    ----------
    x : (n,) array, mm
    loads : (n, 1) or (n, 2) array, N, of a band its bounds
    x_offset : what was taken off x, mm
    notes : what was cut, counted from and left out
    """

    x: Array
    loads: Array
    x_offset: float
    notes: list[str]


def loading(x: Array, loads: Array, motion: str, given: Corrections) -> Loading:
    """The rows of a test, corrected as its user says.

    Raises
    ------
    TableError
        For rows that there are not, a load that is not reached, or a toe without a straight line.
    """
    notes: list[str] = []
    chosen = slice(*_rows(given.rows, len(x)))
    x, loads = x[chosen], loads[chosen]
    if given.smooth is not None:
        starts = np.arange(0, len(x), given.smooth)
        count = np.diff(np.r_[starts, len(x)])
        x, loads = np.add.reduceat(x, starts) / count, np.add.reduceat(loads, starts) / count[:, None]
        notes.append(f"means of {given.smooth} rows are taken")
    loads = loads - (given.y_offset or 0.0)
    if loads.shape[1] == 1:
        x, loads = _test(x, loads, motion, notes)
    if given.from_load is not None:
        x, loads = _from_load(x, loads, given.from_load)
    load = loads.mean(axis=1)
    if given.x_offset is not None:
        shift = given.x_offset
    elif given.toe is not None:
        shift, begins = _toe(x, load, given.toe)
        notes.append(f"toe: the straight line meets no load at a {motion} of {shift:.4g} mm, which is counted from there")
        x, loads = x[begins:], loads[begins:]
    else:
        shift, said = _offset(x, load, motion)
        notes += said
    return Loading(x - shift, loads, shift, notes)


def _rows(given: Sequence[int] | None, count: int) -> tuple[int, int]:
    if given is None:
        return 0, count
    first, last = given
    if not 1 <= first < last <= count:
        raise TableError(f"it has {count} rows of data, the first is 1; expected reference.rows = {list(given)} among them")
    return first - 1, last


def _peak(load: Array) -> tuple[int, Array]:
    """Row of the largest load, and loads of which that is positive."""
    peak = int(abs(load).argmax())
    return peak, load * np.sign(load[peak])


def _test(x: Array, loads: Array, motion: str, notes: list[str]) -> tuple[Array, Array]:
    """Without pre-loads and the last unloading; what else runs back is said."""
    begins = _pre_load(x, *_peak(loads[:, 0]))
    if begins:
        largest = abs(loads[:begins, 0]).max()
        notes.append(f"a pre-load up to {largest:.4g} N is cut: the test begins at row {begins + 1}")
    x, loads = x[begins:], loads[begins:]
    stretches = unloadings(x)
    if stretches and stretches[-1][1] == len(x):
        end = stretches.pop()[0]
        notes.append(
            f"the unloading after the test is cut: {len(x) - end} of {len(x)} rows, from {motion} = {x[end]:.4g} mm on"
        )
        x, loads = x[:end], loads[:end]
    furthest = np.maximum.accumulate(x)
    if not len(x) > 1 or not furthest[-1] > x[0]:
        raise TableError(
            "its x never goes further than in the first row; expected it to rise, or reference.x_unit = '-mm' to turn it"
        )
    loaded = outside_of(stretches, len(x))
    if stretches:
        notes.append(
            f"{motion} runs back in {int((~loaded).sum())} of its {len(x)} rows, in {len(stretches)} unloading(s) by up to "
            f"{float((furthest - x)[~loaded].max()):.3g} mm, which are left out"
        )
    back = (x < furthest) & loaded
    if back.any():
        notes.append(
            f"noise lets {motion} run back in {int(back.sum())} of its {len(x)} rows, by up to "
            f"{(furthest - x)[back].max():.3g} mm: a fit takes every row, a curve means of neighbours"
        )
    return x, loads


def _pre_load(x: Array, peak: int, load: Array) -> int:
    """The first row behind the last pre-load; 0 if there is none."""
    begins = 0
    for first, last in unloadings(x):
        lowest = first + int(x[first:last].argmin())
        turned = float(load[: first + 1].max())
        if lowest < peak and turned <= _SEATING * load[peak] and load[lowest] < _RELEASED * turned:
            begins = lowest
    return begins


def _from_load(x: Array, loads: Array, least: float) -> tuple[Array, Array]:
    """The rows from a load on."""
    peak, load = _peak(loads.mean(axis=1))
    if load[peak] <= least:
        raise TableError(f"its largest load is {load[peak]:.4g} N; expected more than reference.from_load = {least:g} N")
    begins = int(np.flatnonzero(np.r_[-np.inf, load[:peak]] < least)[-1])
    return x[begins:], loads[begins:]


def _toe(x: Array, load: Array, parts: Sequence[float]) -> tuple[float, int]:
    """Where the straight part of the rise meets no load, mm, and the first row of that part."""
    peak, load = _peak(load)
    low, high = (part * load[peak] for part in parts)
    rising = np.flatnonzero((load[: peak + 1] >= low) & (load[: peak + 1] <= high))
    if len(rising) < 2 or not np.ptp(load[rising]) > 0:
        raise TableError(
            f"{len(rising)} of its rows lie between {low:.4g} and {high:.4g} N before the peak; expected reference.toe with "
            "at least 2 rows and a load that rises"
        )
    return float(np.polyfit(load[rising], x[rising], 1)[1]), int(rising[0])


def _offset(x: Array, load: Array, motion: str) -> tuple[float, list[str]]:
    """What a gauge shows before the test, mm, and a sentence on it and on the load that stands then."""
    peak, turned = _peak(load)
    largest, begin = max(float(turned[peak]), 1e-300), _first_motion(x, load, peak)
    travel, first = float(x[peak] - begin), abs(float(load[0])) / largest
    if not travel > 0 or first > _UNLOADED:
        return 0.0, []
    shift = begin if abs(begin) > _OFFSET * travel else 0.0
    notes = []
    part = f"{100 * first:.2g} % of the largest load"
    if shift:
        notes.append(f"{motion} begins at {shift:.4g} mm under {part}: it is counted from there")
    elif abs(begin) > _SAID * travel and abs(begin) > deviation_of(x) and first < _PRELOAD:
        notes.append(
            f"{motion} begins at {begin:.4g} mm under {part}, {100 * abs(begin) / travel:.2g} % of its way to it: "
            f"reference.x_offset = {begin:.4g} counts from there"
        )
    if first > _PRELOAD and abs(begin - shift) < 1e-3 * travel:
        notes.append(
            f"the load at the start is {load[0]:.4g} N, {100 * first:.2g} % of the largest one, and is kept: "
            f"reference.y_offset = {load[0]:.4g} takes it off"
        )
    return shift, notes


def _first_motion(x: Array, load: Array, peak: int) -> float:
    """The motion under the first load: of a straight line through the rows up to a tenth of the way to the largest one, for
    the first row alone has all its noise."""
    rise = load[: peak + 1] - load[0]
    early = int(np.argmax(abs(rise) > _UNLOADED * abs(rise[-1]))) if peak else 0
    if early < _LINE or not np.ptp(load[:early]) > 0:
        return float(x[0])
    return float(np.polyval(np.polyfit(load[:early], x[:early], 1), load[0]))
