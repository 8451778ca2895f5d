"""What the data say of fitted numbers: covariance, profile likelihood, the feasible set of a band, and all that in words."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Array, Mask
from .data import effective_count
from .parameters import Varied
from .problem import FitEvaluation, FitProblem

#: confidence of the intervals
CONFIDENCE = 0.95

#: correlation from which on two numbers trade, and half width of an interval over the value from which on one is hardly seen
_TRADES, _WIDE = 0.9, 0.5

#: variance along a direction that no row sees
_UNSEEN = 1e4

#: components of a direction that are named, over the largest one
_SHARE = 0.3

#: how closely the ends of a profile are found, in units of its distance, and with how many fits each
_CLOSE, _FITS = 0.1, 4

#: fits of the other numbers to the minimum, with two of them fixed: (z, cost)
Refit = Callable[[int, float, Array], tuple[Array, float]]


@dataclass(frozen=True)
class Statistics:
    """What a minimum says of its numbers, scaled as the optimiser sees them.

    Attributes
    ----------
    covariance : (m, m) array
    count : effective number of independent residuals
    quantile : of Student's t, half an interval in standard deviations
    """

    covariance: Array
    count: float
    quantile: float

    @property
    def deviation(self) -> Array:
        """Standard deviations, (m,)."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def correlation(self) -> Array:
        """(m, m) array."""
        size = np.where(self.deviation > 0, self.deviation, 1.0)
        return np.asarray(self.covariance / np.outer(size, size))

    @property
    def freedom(self) -> float:
        """Effective residuals beyond the numbers, at least 1."""
        return max(self.count - len(self.covariance), 1.0)


def statistics(problem: FitProblem, evaluation: FitEvaluation, scatter: Array | None = None) -> Statistics:
    """Covariance at a minimum: s^2 (J'J)^-1 with the effective number of residuals in place of their number.

    Residuals along a curve are correlated. With n of them worth n_eff, s^2 = S/(n_eff - m) n_eff/n and J'J counts n_eff/n.
    Rows inside a band are no residuals.

    Parameters
    ----------
    scatter : (m, m) covariance that known scatter of the test adds.
    """
    from scipy.stats import t as student  # slow to import

    residuals, jacobian = evaluation.residuals, problem.jacobian(evaluation.z)
    m = jacobian.shape[1]
    along = sequences(problem, residuals)
    if "band" in problem.loss:
        along = [each[each != 0.0] for each in along]
    count = effective_count(along)
    freedom = max(count - m, 1.0)
    _, singular, directions = np.linalg.svd(jacobian, full_matrices=len(jacobian) < m)
    seen = np.r_[singular, np.zeros(m - len(singular))]
    seen = np.maximum(seen, 1e-9 * singular[0])
    variance = np.minimum(float(residuals @ residuals) / freedom / seen**2, _UNSEEN)
    variance[seen <= 1e-9 * singular[0]] = _UNSEEN
    covariance = (directions.T * variance) @ directions
    if scatter is not None:
        covariance = covariance + scatter
    return Statistics(covariance, count, float(student.ppf(0.5 + 0.5 * CONFIDENCE, freedom)))


def sequences(problem: FitProblem, residuals: Array) -> list[Array]:
    """The residuals of each curve along it."""
    pieces, at = [], 0
    for data in problem.data:
        p = data.gather.shape[0]
        pieces += np.split(residuals[at : at + p], np.flatnonzero(data.starts)[1:])
        at += data.count
    return pieces


def covariance_ends(problem: FitProblem, z: Array, statistics: Statistics) -> Array:
    """Ends of the intervals from the covariance, (m, 2), scaled; they may lie beyond the bounds."""
    half = statistics.quantile * statistics.deviation
    return np.stack([z - half, z + half], axis=1)


def profile_ends(problem: FitProblem, z: Array, cost: float, statistics: Statistics, refit: Refit) -> Array:
    """Ends of the intervals by profile likelihood, (m, 2), scaled: where the best fit with one number fixed is worse by
    S/S_min - 1 = t^2/(n_eff - m). An end beyond a bound is that bound."""
    ends = np.empty((len(z), 2))
    for j, each in enumerate(problem.parameters):
        low, high = each.bounds
        for side, sign, bound in ((0, -1.0, low), (1, 1.0, high)):
            ends[j, side] = _profile_end(j, sign, bound, z, cost, statistics, refit)
    return ends


def _profile_end(j: int, sign: float, bound: float, z: Array, cost: float, statistics: Statistics, refit: Refit) -> float:
    """One end, by the secant on the root of the rise, which is almost linear in the number."""
    room, wanted = abs(bound - z[j]), statistics.quantile
    step = min(statistics.quantile * max(float(statistics.deviation[j]), 1e-9), room)
    along = statistics.covariance[:, j] / max(statistics.covariance[j, j], 1e-300)
    inner, outer = (0.0, 0.0), (np.inf, np.inf)
    for _ in range(_FITS):
        _, worse = refit(j, float(z[j] + sign * step), z + sign * step * along)
        rise = np.sqrt(max(worse / cost - 1.0, 0.0) * statistics.freedom) if cost > 0 else np.inf
        if abs(rise - wanted) <= _CLOSE * wanted:
            return float(z[j] + sign * min(step * wanted / rise, room))
        if rise < wanted:
            if step >= room:
                return bound
            inner = (step, rise)
        else:
            outer = (step, rise)
        if np.isfinite(outer[1]):
            part = (wanted - inner[1]) / (outer[1] - inner[1])
            step = inner[0] + float(np.clip(part, 0.1, 0.9)) * (outer[0] - inner[0])
        else:
            step = min(step * min(wanted / max(rise, 1e-9), 3.0), room) if rise > 0 else min(3.0 * step, room)
    return float(z[j] + sign * step)


def feasible_ends(problem: FitProblem, z: Array, refit: Refit, steps: int = 4) -> Array:
    """Ends of the set of numbers with which every measured row lies in its band, (m, 2), scaled, each by bisection."""
    ends = np.empty((len(z), 2))
    for j, each in enumerate(problem.parameters):
        for side, bound in enumerate(each.bounds):
            good, bad, at = 0.0, None, z
            part = 0.1
            for _ in range(steps):
                fixed = float(z[j] + part * (bound - z[j]))
                there, cost = refit(j, fixed, at)
                if cost <= 0.0:
                    good, at = part, there
                    part = min(2.0 * part, 1.0) if bad is None else 0.5 * (good + bad)
                else:
                    bad = part
                    part = 0.5 * (good + bad)
                if good == 1.0:
                    break
            ends[j, side] = z[j] + good * (bound - z[j])
    return ends


def interval_words(low: float, high: float) -> str:
    """An interval as it is printed."""
    return "not known" if np.isnan(low) else f"{low:.4g} to {high:.4g}"


def in_words(parameters: Sequence[Varied], z: Array, ends: Array, spread: Statistics, kind: str) -> list[str]:
    """What the test does not see, one sentence each; else that it sees everything."""
    sentences, correlation, count, m = [], spread.correlation, spread.count, len(z)
    for each, is_at in zip(parameters, _at_bounds(parameters, z), strict=True):
        if is_at:
            sentences.append(f"{each.short} stands at its bound, which decides it and not the data")
    for i in range(m):
        for j in range(i):
            if abs(correlation[i, j]) >= _TRADES:
                r = f"{correlation[i, j]:.2f}".replace("0.", ".")
                sentences.append(f"{parameters[j].short} and {parameters[i].short} trade: r = {r}")
    for each, at, (low, high) in zip(parameters, z, ends, strict=True):
        value, bottom, top = each.value(float(at)), each.value(float(low)), each.value(float(high))
        if each.curve is None and top - bottom > 2.0 * _WIDE * abs(value):  # an offset may be 0
            sentences.append(f"{each.short} is hardly seen: {value:.3g}, between {bottom:.3g} and {top:.3g}")
    if kind == "unknown":
        remedy = "a profile (--profile) finds some" if count > m else f"too few for {m} numbers, --loss linear fits the middle"
        sentences.append(
            f"intervals are not known: rows inside a band have no weight, and those outside are worth {count:.1f}; {remedy}"
        )
    elif kind != "feasible" and count < 2.0 * m + 1.0:
        sentences.append(
            f"the residuals are worth {count:.1f} independent ones, which hardly bear {m} numbers: fewer would do as well"
        )
    if not sentences:
        largest = float(abs(correlation - np.eye(m)).max()) if m > 1 else 0.0
        sentences.append(f"every number is seen on its own: largest correlation {largest:.2f}")
    return sentences


def unseen_direction(problem: FitProblem, evaluation: FitEvaluation) -> list[str]:
    """The direction that the data see least, if they do not see it: numbers change along it together by a factor e, or by
    their range, and the loads by less than they are off the measured ones, or the middle of a band. One sentence, or none."""
    slopes = [data.gather @ (problem.slopes(i, evaluation) / data.peak) for i, data in enumerate(problem.data)]
    both = zip(problem.data, evaluation.loads, strict=True)
    off = np.concatenate([data.gather @ ((load - data.middle) / data.peak) for data, load in both])
    _, singular, directions = np.linalg.svd(np.concatenate(slopes))
    changes = np.r_[singular, np.zeros(len(directions) - len(singular))]
    unseen = int((changes < np.linalg.norm(off)).sum())
    if not unseen:
        return []
    moved = [
        f"{each.short} from {each.value(float(at)):.3g} to {each.value(float(at + by)):.3g}"
        for each, at, by in zip(problem.parameters, evaluation.z, directions[-1], strict=True)
        if abs(by) > _SHARE * abs(directions[-1]).max()
    ]
    percent = 100.0 * changes[-1] / np.sqrt(len(off))
    more = f"; nor {unseen - 1} more direction{'s' * (unseen > 2)}" if unseen > 1 else ""
    return [f"the data do not see {' with '.join(moved)}, which moves the loads by {percent:.2g} % of the peak{more}"]


def _at_bounds(parameters: Sequence[Varied], z: Array) -> Mask:
    low, high = np.array([each.bounds for each in parameters]).T
    return np.asarray(np.minimum(z - low, high - z) < 2e-3 * (high - low))
