"""Load over the measure in charge: how far two computed curves lie apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..arrays import Array
from ..measured.curve import area_under

if TYPE_CHECKING:
    from ..results.run_data import RunData


@dataclass(frozen=True)
class Curve:
    """The curve of one run from the unloaded state on.

    Attributes
    ----------
    x, load, work : (n,) arrays, mm, N, N mm; x is the measure in charge, as the opening of a gauge, cmod or driven
    platen : (n,) array, mm, the travel of a platen that moves in two directions, over which its load is drawn; None if the
        load is drawn over x
    peak, at_peak : largest load (N) and x there (mm), see `RunData.peak`
    """

    x: Array
    load: Array
    work: Array
    platen: Array | None
    peak: float
    at_peak: float


def curve_of(data: RunData, measure: str | None = None) -> Curve:
    """The curve of a run over a column of its history, by default that in charge."""
    x, load, work = (data.history[name] for name in (measure or data.controlled, "load", "work"))
    platen = data.drive_travel if data.facts.has_platen else None
    return Curve(x, load, work, platen, data.peak_load, data.at_peak(x))


@dataclass(frozen=True)
class Pair:
    """Two curves over a parameter that both have in common: what they travelled of x, or of the platen's travel.

    Attributes
    ----------
    curves : two of Curve
    travelled : (n,) array for each, mm
    end : the end that both reach, mm
    """

    curves: Sequence[Curve]
    travelled: list[Array]
    end: float

    @classmethod
    def from_curves(cls, first: Curve, second: Curve) -> Pair:
        """Two curves of the same scene."""
        curves = (first, second)
        platens = [curve.platen for curve in curves]
        travelled = _travelled([c.x for c in curves]) if platens[0] is None or platens[1] is None else [platens[0], platens[1]]
        return cls(curves, travelled, float(min(s[-1] for s in travelled)))

    def upto_end(self, i: int) -> tuple[Array, Array, Array]:
        """Parameter, x and load of one of the curves up to the common end."""
        s, curve = self.travelled[i], self.curves[i]
        keep = np.r_[s[s < self.end], self.end]
        return keep, np.asarray(np.interp(keep, s, curve.x)), np.asarray(np.interp(keep, s, curve.load))

    def energy(self, i: int) -> float:
        """Area under load over x up to the common end, or the work of the platen, N mm."""
        if self.curves[i].platen is not None:
            return float(np.interp(self.end, self.travelled[i], self.curves[i].work))
        _, x, load = self.upto_end(i)
        return area_under(load, x)

    def under(self, i: int) -> float:
        """Area under the size of the load over the parameter, N mm."""
        s, _, load = self.upto_end(i)
        return area_under(abs(load), s)

    def difference(self) -> tuple[Array, Array]:
        """Load of the second curve less that of the first (N), over the parameter (mm)."""
        (s0, _, load0), (s1, _, load1) = self.upto_end(0), self.upto_end(1)
        s = np.union1d(s0, s1)
        gap = np.interp(s, s1, load1) - np.interp(s, s0, load0)
        cross = np.flatnonzero(gap[1:] * gap[:-1] < 0)  # where the curves cross, the difference has a corner at 0
        root = s[cross] + (s[cross + 1] - s[cross]) * gap[cross] / (gap[cross] - gap[cross + 1])
        return np.insert(s, cross + 1, root), np.insert(gap, cross + 1, 0.0)

    def between(self) -> float:
        """Area between the curves, N mm."""
        s, gap = self.difference()
        return area_under(abs(gap), s)


def _travelled(positions: Sequence[Array]) -> list[Array]:
    """Length travelled, forth and back, for each curve, mm.

    If both curves turn equally often, what they travel between two turns is counted as the mean of both, so that a run
    that closes a little further does not fall behind the other.
    """
    turns = []
    for x in positions:
        moves = np.sign(np.diff(x))
        rows = np.flatnonzero(moves)
        turns.append(np.r_[0, rows[1:][moves[rows[1:]] != moves[rows[:-1]]], len(x) - 1])
    travelled = [np.r_[0.0, np.cumsum(abs(np.diff(x)))] for x in positions]
    if len(turns[0]) != len(turns[1]) or len(turns[0]) == 2:
        return travelled
    at_turns = np.mean([s[turn] for s, turn in zip(travelled, turns, strict=True)], axis=0)
    scaled = []
    for s, turn in zip(travelled, turns, strict=True):
        common = np.interp(s, s[turn], at_turns)
        last = s > s[turn[-2]]  # one run may end before the other
        common[last] = at_turns[-2] + s[last] - s[turn[-2]]
        scaled.append(common)
    return scaled
