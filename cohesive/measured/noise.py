"""A measured motion that runs back: unloading, which is meant, is told from noise by its length."""

from __future__ import annotations

import numpy as np

from ..arrays import Array, Mask

#: rows from which on noise can be told from steps, and its standard deviations that a single row runs back at most, and on
#: average behind the furthest row
_FEW, _FURTHEST, _USUAL = 30, 10.0, 3.0

#: standard deviation of a normal distribution over its median deviation, and noise of a row less the mean of its neighbours
_NORMAL, _SECOND = 1.4826, np.sqrt(1.5)

#: smallest standard deviation of the noise over the resolution of a gauge
_RESOLUTION = 0.3


def deviation_of(x: Array) -> float:
    """Standard deviation of the noise in a motion, from its second differences; 0 for a curve of few rows."""
    if len(x) < _FEW:
        return 0.0
    steps = abs(np.diff(x))
    resolution = float(steps[steps > 1e-9 * np.ptp(x)].min(initial=np.inf))
    away = _NORMAL * float(np.median(abs(x[1:-1] - 0.5 * (x[2:] + x[:-2])))) / _SECOND
    return float(max(away, _RESOLUTION * resolution)) if np.isfinite(resolution) else away


def unloadings(x: Array) -> list[tuple[int, int]]:
    """The stretches of rows in which a motion runs back further than noise does, each as its first row and the one behind its
    last."""
    deviation = deviation_of(x)
    clean = np.median([x[:-2], x[1:-1], x[2:]], axis=0) if deviation else x[1:-1]  # a single row may be an outlier
    clean = np.r_[x[:1], clean, x[-1:]] if len(x) > 2 else x
    depth = np.maximum.accumulate(clean) - clean
    behind = np.r_[False, depth > _USUAL * deviation, False]
    first, last = np.flatnonzero(np.diff(behind.astype(int)) == 1), np.flatnonzero(np.diff(behind.astype(int)) == -1)
    if not len(first):
        return []
    deepest = np.maximum.reduceat(np.r_[depth, 0.0], np.ravel(np.stack([first, last], axis=1)))[::2]
    meant = deepest > _FURTHEST * deviation
    return [(int(a), int(b)) for a, b in zip(first[meant], last[meant], strict=True)]


def outside_of(stretches: list[tuple[int, int]], count: int) -> Mask:
    """Which of some rows lie in no stretch."""
    edge = np.zeros(count + 1, dtype=int)
    for first, last in stretches:
        edge[first] += 1
        edge[last] -= 1
    return np.asarray(np.cumsum(edge)[:-1] == 0)


def pooled(x: Array, y: Array) -> tuple[Array, Array]:
    """Means of neighbouring rows, so few that x rises: its isotonic regression over the order of the rows."""
    from scipy.optimize import isotonic_regression  # slow to import

    starts = isotonic_regression(x).blocks[:-1]
    count = np.diff(np.r_[starts, len(x)])
    return np.add.reduceat(x, starts) / count, np.add.reduceat(y, starts) / count
