"""Measured curves and bands as arrays: what results, comparisons and fits stand on.

A scene's [reference] becomes a `Reference` with one `Measured` for each file (`scenes.reference.load_reference`, which a
`Result` keeps as `result.reference`; None if the scene names none):

    reference.against                     the column of the history that its x is, as "opening" or "driven"
    for each in reference.curves:
        each.x, each.y                    mm and N, x rising strictly
        each.is_band, each.low, each.high the bounds of a band; of a curve both are y
    reference.residuals(result.history)   computed less measured loads, N, as a least-squares fit needs them
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ..arrays import Array
from ..errors import SceneError


@dataclass(frozen=True)
class Measured:
    """A measured curve, or the band of several.

    Attributes
    ----------
    name : name of its file
    x : (n,) array, mm, rising strictly
    low, high : (n,) arrays, N, the bounds of a band; of a curve both are the measured load
    is_band : whether it was measured as a band
    x_unit, y_unit : the units that the file or the scene names; empty if nobody said and mm and N were taken
    notes : remarks of the reading, one sentence each
    content : the file as it was read
    """

    name: str
    x: Array
    low: Array
    high: Array
    is_band: bool = False
    x_unit: str = ""
    y_unit: str = ""
    notes: tuple[str, ...] = ()
    content: bytes = field(default=b"", repr=False)

    @classmethod
    def from_curve(cls, x: Array, y: Array, name: str = "measured") -> Measured:
        """A single curve in mm and N; points at which x runs back are left out.

        Raises
        ------
        SceneError
            If x and y are not equally long, or not finite.
        """
        x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
        if x.ndim != 1 or x.shape != y.shape:
            raise SceneError(f"{name} curve: x {x.shape} and y {y.shape}; expected two sequences of the same length")
        if not (np.isfinite(x) & np.isfinite(y)).all():
            row = int(np.argmin(np.isfinite(x) & np.isfinite(y)))
            raise SceneError(f"{name} curve, row {row}: ({x[row]}, {y[row]}); expected finite numbers")
        x, y = rising(x, y)
        return cls(name, x, y, y, x_unit="mm", y_unit="N")

    @property
    def y(self) -> Array:
        """The measured load, (n,), N; of a band its middle."""
        return 0.5 * (self.low + self.high) if self.is_band else self.low

    def residuals(self, x: Array, y: Array) -> Array:
        """Load of a computed curve at the measured points less the measured one, (n,), N.

        Inside a band the residual is 0, outside it is the distance from the nearer bound. Beyond the end of the computed
        curve its last load counts.

        Parameters
        ----------
        x, y : (m,) arrays, mm and N, the computed curve from the unloaded state on; see `rising`.
        """
        load = np.interp(self.x, *rising(x, y))
        return np.asarray(np.maximum(load - self.high, 0.0) + np.minimum(load - self.low, 0.0))


@dataclass(frozen=True)
class Reference:
    """What a scene is compared with.

    Attributes
    ----------
    label : its name in the legend
    against : name of the history's column that x was measured as
    curves : one for each file, at least one
    """

    label: str
    against: str
    curves: tuple[Measured, ...]

    def computed(self, history: Mapping[str, Array]) -> tuple[Array, Array]:
        """The computed curve from the unloaded state on: x (mm) and load (N), (m,) each, see `rising`; that state alone if the
        run has no such column, as for a gauge that its mesh cannot place."""
        if self.against not in history:
            return np.zeros(1), np.zeros(1)
        return rising(np.r_[0.0, history[self.against]], np.r_[0.0, history["load"]])

    def residuals(self, history: Mapping[str, Array]) -> Array:
        """The residuals of all curves against a history, one curve after the other, (k,), N: always as many."""
        computed = self.computed(history)
        return np.concatenate([each.residuals(*computed) for each in self.curves])

    def mean(self) -> tuple[Measured, Array] | None:
        """Mean and standard deviation (N) of several curves over the x that all have; None for one curve or bands."""
        if len(self.curves) < 2 or any(each.is_band for each in self.curves):
            return None
        start, end = max(each.x[0] for each in self.curves), min(each.x[-1] for each in self.curves)
        if not end > start:
            return None
        at = np.unique(np.concatenate([each.x for each in self.curves]))
        at = at[(at >= start) & (at <= end)]
        loads = np.array([np.interp(at, each.x, each.y) for each in self.curves])
        mean = Measured.from_curve(at, loads.mean(axis=0), f"mean of {len(self.curves)}")
        return mean, np.asarray(loads.std(axis=0, ddof=1))


def rising(x: Array, y: Array) -> tuple[Array, Array]:
    """The points of a curve at which x goes further than ever before; if x runs back, the y counts with which it is
    reached first."""
    first = np.diff(np.maximum.accumulate(x), prepend=-np.inf) > 0
    return x[first], y[first]
