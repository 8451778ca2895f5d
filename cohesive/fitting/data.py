"""Measured rows as a fit counts them: pieces of a curve, and the openings at which a run is to stand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from ..arrays import Array, Index
from ..errors import SceneError
from ..measured.curve import Measured, Reference, outside

#: pieces of equal length into which a curve with more rows is gathered
PIECES = 100

#: number of measured places up to which a run stands at each; number of those of a curve with more
ROWS, TARGETS = 200, 100

LOSSES = ("linear", "soft_l1", "band")

#: residuals of a band's middle beside those of its bounds, so that a feasible fit is drawn to the middle
_PULL = 0.02


@dataclass(frozen=True)
class Data:
    """The rows of all measured curves of one scene.

    Attributes
    ----------
    against : column of the history that x was measured as
    curves : the measured curves
    x, low, high : (n,) arrays, the rows one curve after the other, mm and N
    gather : (p, n) matrix, the means over the pieces
    starts : (p,) array, whether a piece is the first of its curve
    peak : largest measured load, N
    loss : "linear", "soft_l1" or "band"
    """

    against: str
    curves: tuple[Measured, ...]
    x: Array
    low: Array
    high: Array
    gather: sp.csr_array
    starts: Array
    peak: float
    loss: str

    @classmethod
    def from_reference(cls, reference: Reference, weights: str, loss: str | None = None) -> Data:
        """The rows of a reference.

        Parameters
        ----------
        weights : "arc", pieces of equal length count alike, or "rows", all rows do.
        loss : default: "band" if all curves are bands, else "linear".

        Raises
        ------
        SceneError
            For a curve that cannot be fitted.
        """
        if weights not in ("arc", "rows"):
            raise SceneError(f"weights = {weights!r}: expected 'arc' or 'rows'", "weights")
        if loss is None:
            loss = "band" if all(each.is_band for each in reference.curves) else "linear"
        if loss not in LOSSES:
            raise SceneError(f"loss = {loss!r}: expected one of {', '.join(LOSSES)}", "loss")
        for each in reference.curves:
            _check(each)
        pieces = [_pieces(each) if weights == "arc" else np.arange(len(each.x)) for each in reference.curves]
        offset = np.cumsum([0, *(int(piece[-1]) + 1 for piece in pieces)])
        piece = np.concatenate([part + first for part, first in zip(pieces, offset[:-1], strict=True)])
        n, p = len(piece), int(offset[-1])
        share = 1.0 / np.bincount(piece, minlength=p)
        starts = np.zeros(p, dtype=bool)
        starts[offset[:-1]] = True
        arrays = zip(*((each.x, *each.bounds) for each in reference.curves), strict=True)
        x, low, high = (np.concatenate(each) for each in arrays)
        gather = sp.csr_array((share[piece], (piece, np.arange(n))), shape=(p, n))
        peak = float(abs(np.concatenate([each.y for each in reference.curves])).max())
        return cls(reference.against, reference.curves, x, low, high, gather, starts, peak, loss)

    @property
    def middle(self) -> Array:
        """The measured loads, of a band its middle, (n,), N."""
        return 0.5 * (self.low + self.high)

    def targets(self) -> list[float]:
        """The measured places at which a run stands, mm."""
        x = np.unique(self.x[self.x > 0])
        if len(x) > ROWS:
            longest = max(self.curves, key=lambda each: len(each.x))
            s = _arc(longest)
            x = np.unique(np.interp(np.linspace(0.0, s[-1], TARGETS + 1), s, longest.x))
            x = np.unique(np.append(x[x > 0], self.x.max()))
        apart = np.diff(x, prepend=0.0) > 1e-6 * x[-1]
        return [float(value) for value in x[apart]]

    def gap(self, load: Array) -> tuple[Array, Array]:
        """Distances of computed loads (n,) from the measured ones, over the peak, and their slopes in load over peak."""
        if self.loss != "band":
            return (load - self.middle) / self.peak, np.ones_like(load)
        away = outside(load, self.low, self.high)
        return away / self.peak, (away != 0.0).astype(float)

    @property
    def count(self) -> int:
        """Number of residuals, p; twice as many with the loss "band"."""
        return int(self.gather.shape[0]) * (2 if self.loss == "band" else 1)

    def residuals(self, load: Array) -> Array:
        """What computed loads (n,) leave in each piece, (count,); with the loss "band" a second half pulls to its middle."""
        return self._gathered(self.gap(load)[0], (load - self.middle) / self.peak)

    def jacobian(self, load: Array, slopes: Array) -> Array:
        """Derivatives of the residuals, (count, m), with those of the loads, (n, m), N."""
        relative = slopes / self.peak
        return self._gathered(self.gap(load)[1][:, None] * relative, relative)

    def _gathered(self, gap: Array, off_middle: Array) -> Array:
        parts = [self.gather @ gap, *([self.gather @ (_PULL * off_middle)] if self.loss == "band" else [])]
        return np.concatenate(parts)

    def inside(self, load: Array) -> int:
        """How many of the computed loads lie within the bounds."""
        slack = 1e-9 * self.peak
        return int(((load >= self.low - slack) & (load <= self.high + slack)).sum())


def _check(measured: Measured) -> None:
    if len(measured.x) < 3:
        raise SceneError(
            f"reference.file = {measured.name!r}: {len(measured.x)} row(s) with a growing x; expected a curve of at least 3",
            "reference.file",
        )
    measured.without_doubt()


def _arc(measured: Measured) -> Array:
    """Length along a curve up to each row, (n,), in its largest load and its range of x. Noise makes a curve of many rows
    long; it is averaged out over blocks of rows first."""
    n = len(measured.x)
    block = np.arange(n) * min(n, 2 * PIECES) // n
    count = np.bincount(block)
    x, y = (np.bincount(block, values) / count for values in (measured.x, measured.y))
    steps = np.hypot(np.diff(x) / np.ptp(measured.x), np.diff(y) / abs(measured.y).max())
    return np.interp(measured.x, x, np.r_[0.0, np.cumsum(steps)])


def _pieces(measured: Measured) -> Index:
    """Number of the piece of each row, from 0 on without gaps."""
    n = len(measured.x)
    if n <= PIECES:
        return np.arange(n)
    s = _arc(measured)
    piece = np.minimum((s / s[-1] * PIECES).astype(np.intp), PIECES - 1)
    return np.unique(piece, return_inverse=True)[1]


def effective_count(residuals: Sequence[Array]) -> float:
    """How many independent ones some sequences of residuals are worth, from their autocorrelation: n / (1 + 2 sum of rho), the
    sum up to the first lag that is not correlated."""
    n = sum(len(each) for each in residuals)
    power = sum(float(each @ each) for each in residuals)
    if power <= 0 or n < 2:
        return float(n)
    total = 1.0
    for lag in range(1, n):
        rho = sum(float(each[lag:] @ each[:-lag]) for each in residuals if len(each) > lag) / power
        if rho <= 0:
            break
        total += 2.0 * rho
    return n / total
