"""What the law and the rules for widths read off a softening curve: its first branch, where it rises, where it is spent."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from .softening import Softening

#: a curve without an end is taken as spent when this part of its area is left: 2.5e-8, at 17.5 Gf/ft of the exponential one
_SPENT = math.exp(-17.5)

#: openings at which a curve is looked at, besides its kinks
_SAMPLES = 1000


def fully_softened(curve: Softening) -> float:
    """Opening from which on no traction can come back by opening, mm: the end, or what comes near to it."""
    if math.isfinite(curve.end):
        return float(curve.end)
    Gf = float(curve.work(np.array([math.inf]))[0])
    low, high = 0.0, Gf / float(curve.stress(np.zeros(1))[0])

    def left(w: float) -> float:
        return Gf - float(curve.work(np.array([w]))[0])

    while left(high) > _SPENT * Gf:
        low, high = high, 2.0 * high
    while high - low > 1e-12 * high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if left(middle) > _SPENT * Gf else (low, middle)
    return high


def first_branch(curve: Softening) -> float:
    """Opening at which the first branch of a curve ends, mm: its first kink or minimum, else its end (which may be inf).

    Only a kink beyond which the curve falls less than half as steeply ends a branch, or else many points that trace a smooth
    curve would end it at once.
    """
    for kink in getattr(curve, "kinks", ()):
        before, after = (float(curve.slope(np.array([w]))[0]) for w in (kink * (1.0 - 1e-9), kink))
        if after > 0.5 * before and before < 0:
            return float(kink)
    w = _openings(curve)
    slope = curve.slope(w)
    rising = np.flatnonzero((slope[:-1] < 0) & (slope[1:] > 0))
    if not rising.size:
        return float(curve.end)
    low, high = w[rising[0]], w[rising[0] + 1]
    while high - low > 1e-12 * high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if curve.slope(np.array([middle]))[0] < 0 else (low, middle)
    return float(high)


def opening_of_first_branch(curve: Softening) -> float:
    """Opening at which the steepest secant from the strength through the first branch reaches zero stress, mm: Gf/ft for the
    exponential curve. inf if the curve rises above its strength there."""
    w = _openings(curve)
    w = w[(w > 0) & (w <= first_branch(curve))]
    ft, stress = float(curve.stress(np.zeros(1))[0]), curve.stress(w)
    if (stress > ft * (1.0 + 1e-12)).any():
        return math.inf
    fallen = np.maximum(ft - stress, np.finfo(float).tiny)
    with np.errstate(over="ignore"):
        return float((ft * w / fallen).min())


class Rise(NamedTuple):
    """Where a curve rises most steeply against its secant.

    Attributes
    ----------
    w, stress, slope : of that place, mm, MPa, MPa/mm.
    largest_Zt : the secant falls everywhere, slope (Zt + w) < stress, if Zt is below this opening, mm.
    """

    w: float
    stress: float
    slope: float
    largest_Zt: float


def steepest_rise(curve: Softening) -> Rise | None:
    """The place that limits the width of a crack plane, or None if the curve never rises."""
    w = _openings(curve)
    stress, slope = curve.stress(w), curve.slope(w)
    rising = slope > 0
    if not rising.any():
        return None
    w, stress, slope = w[rising], stress[rising], slope[rising]
    largest = stress / slope - w
    # along a straight branch all places are equal but for rounding: its beginning
    i = int(np.argmax(largest <= largest.min() + 1e-9 * (w + stress / slope)))
    return Rise(float(w[i]), float(stress[i]), float(slope[i]), float(largest[i]))


def _openings(curve: Softening) -> Array:
    """Openings over the whole curve, fine near 0, with its kinks and its end."""
    last = fully_softened(curve)
    kinks = np.asarray(getattr(curve, "kinks", ()), dtype=float)
    return np.unique(np.concatenate([[0.0, last], kinks, last * np.linspace(0.0, 1.0, _SAMPLES) ** 2]))
