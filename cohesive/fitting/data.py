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
ROWS, TARGETS = 200, 150

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
    curve, piece : (n,) arrays, the number of the curve and of the piece of each row
    gather : (p, n) matrix, the means over the pieces, times the root of their weights if noise has told them
    starts : (p,) array, whether a piece is the first of its curve
    peak : largest measured load, N
    loss : "linear", "soft_l1" or "band"
    """

    against: str
    curves: tuple[Measured, ...]
    x: Array
    low: Array
    high: Array
    curve: Index
    piece: Index
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
        pieces = [_pieces(each) if weights == "arc" else np.arange(len(each.rows[0])) for each in reference.curves]
        offset = np.cumsum([0, *(int(piece[-1]) + 1 for piece in pieces)])
        piece = np.concatenate([part + first for part, first in zip(pieces, offset[:-1], strict=True)])
        curve = np.repeat(np.arange(len(pieces)), [len(part) for part in pieces])
        starts = np.zeros(int(offset[-1]), dtype=bool)
        starts[offset[:-1]] = True
        rows = [(each.x, *each.bounds) if each.is_band else (*each.rows, each.rows[1]) for each in reference.curves]
        x, low, high = (np.concatenate(each) for each in zip(*rows, strict=True))
        peak = float(abs(np.concatenate([each.y for each in reference.curves])).max())
        gather = means(piece, np.ones(len(piece)))
        return cls(reference.against, reference.curves, x, low, high, curve, piece, gather, starts, peak, loss)

    @property
    def middle(self) -> Array:
        """The measured loads, of a band its middle, (n,), N."""
        return 0.5 * (self.low + self.high)

    def targets(self) -> list[float]:
        """The measured places at which a run stands, mm."""
        x = np.unique(self.x[self.x > 0])
        if len(x) > ROWS or any(each.noisy is not None for each in self.curves):
            longest = max(self.curves, key=lambda each: len(each.rows[0]))
            at, s = _arc(longest)
            places = np.maximum.accumulate(np.interp(np.linspace(0.0, s[-1], TARGETS + 1), s, at))
            x = np.unique(np.append(places[places > 0], self.x.max()))
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

    def inside(self, load: Array, margin: float = 0.0) -> int:
        """How many of the computed loads lie within the bounds, or off them by no more than a part `margin` of the bound."""
        slack = 1e-9 * self.peak
        low, high = self.low - margin * abs(self.low) - slack, self.high + margin * abs(self.high) + slack
        return int(((load >= low) & (load <= high)).sum())


def _check(measured: Measured) -> None:
    if len(measured.x) < 3:
        raise SceneError(
            f"reference.file = {measured.name!r}: {len(measured.x)} row(s) with a growing x; expected a curve of at least 3",
            "reference.file",
        )
    measured.without_doubt()


def means(piece: Index, weights: Array) -> sp.csr_array:
    """The weighted means of rows over their pieces, as a matrix (p, n)."""
    share = weights / np.bincount(piece, weights)[piece]
    return sp.csr_array((share, (piece, np.arange(len(piece)))))


def _arc(measured: Measured) -> tuple[Array, Array]:
    """Places along a curve, and the length up to each in its largest load and its range of x. Noise makes a curve of many rows
    long; it is averaged out over blocks of rows first."""
    x, y = measured.rows
    n = len(x)
    block = np.arange(n) * min(n, 2 * PIECES) // n
    count = np.bincount(block)
    x, y = (np.bincount(block, values) / count for values in (x, y))
    steps = np.hypot(np.diff(x) / np.ptp(measured.x), np.diff(y) / abs(measured.y).max())
    return x, np.r_[0.0, np.cumsum(steps)]


def _pieces(measured: Measured) -> Index:
    """Number of the piece of each row, from 0 on without gaps: neighbours in the order in which they were measured, for their
    noise must not choose their piece."""
    n = len(measured.rows[0])
    if n <= PIECES:
        return np.arange(n)
    s = _arc(measured)[1]
    s = np.interp(np.arange(n), (np.arange(len(s)) + 0.5) * n / len(s) - 0.5, s)
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
