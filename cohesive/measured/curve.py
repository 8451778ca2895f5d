"""Measured curves and bands as arrays: what results, comparisons, fits and standards stand on.

A scene's [reference] becomes a `Reference` with one `Measured` for each file (`scenes.reference.load_reference`, which a
`Result` keeps as `result.reference`; None if the scene names none):

    reference.against                     the column of the history that its x is, as "opening" or "driven"
    for each in reference.curves:
        each.x, each.y                    mm and N, x rising strictly
        each.low, each.high               the bounds of a band; of a curve None
    reference.residuals(result.history)   computed less measured loads, N, as a least-squares fit needs them
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ..arrays import Array
from ..errors import SceneError
from .noise import outside_of, pooled, unloadings


@dataclass(frozen=True)
class Measured:
    """A measured curve, or the band of several.

    Attributes
    ----------
    name : name of its file
    x : (n,) array, mm, rising strictly; if noise makes it run back, means of neighbouring rows
    y : (n,) array, N, the measured load; of a band its middle
    low, high : (n,) arrays, N, the bounds of a band; None for a curve
    against : what x is: "cmod", "opening", "deflection", "driven" or another motion; empty if nobody said
    x_unit, y_unit : the units that the file or the scene names; empty if nobody said and mm and N were taken
    notes : remarks of the reading, one sentence each, `doubt` among them
    doubt : why its numbers cannot be meant, with the key that corrects it; empty if nothing speaks against them
    x_offset : what was taken off its gauge, mm
    noisy : x and y of every row, whose x runs back with noise; None if it does not
    content : the file as it was read
    dimensions : what the file says of its specimen, mm and kg by the keys of `evaluate`; nobody has taken it
    """

    name: str
    x: Array
    y: Array
    low: Array | None = None
    high: Array | None = None
    against: str = ""
    x_unit: str = ""
    y_unit: str = ""
    notes: tuple[str, ...] = ()
    doubt: str = ""
    x_offset: float = 0.0
    noisy: tuple[Array, Array] | None = field(default=None, repr=False)
    content: bytes = field(default=b"", repr=False)
    dimensions: Mapping[str, float] = field(default_factory=dict)

    @classmethod
    def from_curve(cls, x: Array, y: Array, name: str = "measured", against: str = "") -> Measured:
        """A single curve in mm and N. Rows of an unloading are left out; those that run back with noise stay in `rows`.

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
        loaded = outside_of(unloadings(x), len(x))
        rows = (x[loaded], y[loaded])
        is_noisy = bool((np.diff(rows[0]) < 0).any())
        x, y = rising(*(pooled(*rows) if is_noisy else rows))
        return cls(name, x, y, against=against, x_unit="mm", y_unit="N", noisy=rows if is_noisy else None)

    @classmethod
    def from_band(cls, x: Array, low: Array, high: Array, name: str = "measured", against: str = "") -> Measured:
        """A band in mm and N, its x rising strictly."""
        return cls(name, x, 0.5 * (low + high), low, high, against, x_unit="mm", y_unit="N")

    @property
    def rows(self) -> tuple[Array, Array]:
        """Motion and load of every row, (n,) each, mm and N: what a fit stands on."""
        return (self.x, self.y) if self.noisy is None else self.noisy

    @property
    def is_band(self) -> bool:
        """Whether it was measured as a band."""
        return self.low is not None

    @property
    def bounds(self) -> tuple[Array, Array]:
        """The loads between which nothing is wrong, N: those of a band; of a curve both are y."""
        return (self.y, self.y) if self.low is None or self.high is None else (self.low, self.high)

    def without_doubt(self) -> Measured:
        """Itself, for whoever takes numbers from it.

        Raises
        ------
        SceneError
            If its numbers cannot be meant: a doubtful unit or sign, a load that does not change or is nowhere above 0.
        """
        if self.doubt:
            raise SceneError.at("reference.file", f" = {self.name!r}: {self.doubt}")
        if not np.ptp(self.y) > 1e-9 * abs(self.y).max() or not self.y.max() > 0:
            raise SceneError.at(
                "reference.file",
                f" = {self.name!r}: the measured load does not change, or is nowhere above 0; expected a curve",
            )
        return self

    def residuals(self, x: Array, y: Array) -> Array:
        """Load of a computed curve at the measured points less the measured one, (n,), N.

        Inside a band the residual is 0, outside it is the distance from the nearer bound. Beyond the end of the computed
        curve its last load counts.

        Parameters
        ----------
        x, y : (m,) arrays, mm and N, the computed curve from the unloaded state on; see `rising`.
        """
        return outside(np.interp(self.x, *rising(x, y)), *self.bounds)


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

    @property
    def notes(self) -> list[str]:
        """The remarks of the reading, each with the name of its curve."""
        return [f"{self.name_of(each)}: {note}" for each in self.curves for note in each.notes]

    def name_of(self, curve: Measured) -> str:
        """Its label, with the name of the file if there are several."""
        return f"{self.label} ({curve.name})" if len(self.curves) > 1 else self.label

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


def outside(load: Array, low: Array, high: Array) -> Array:
    """Distance of loads from the nearer one of two bounds, N: above 0 over the upper one, below 0 under the lower one."""
    return np.asarray(np.maximum(load - high, 0.0) + np.minimum(load - low, 0.0))


def area_under(y: Array, x: Array) -> float:
    """Area under a polyline; np.trapezoid exists from NumPy 2.0 on only."""
    return float(0.5 * (y[1:] + y[:-1]) @ np.diff(x))
