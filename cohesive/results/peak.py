"""The peak of a curve, which lies between its rows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial

from ..arrays import Array, Index

#: rows next to the largest one count from this part of its load on
_HIGH = 0.985

#: unknowns of the cubic, and fewest rows
_TERMS = 4


@dataclass(frozen=True)
class Peak:
    """The largest load of a run, and where it comes, see `peak_weights`.

    Attributes
    ----------
    load : N
    at : mm, of the measure in charge
    measure : its column of the history, as "cmod" or "driven"
    """

    load: float
    at: float
    measure: str


def peak_weights(motions: Array, load: Array) -> tuple[Index, Array]:
    """Rows at the largest load, and what each counts at the peak: any quantity has there the value weights @ quantity[rows].

    A cubic of least squares goes through the rows about the largest one with at least 98.5 % of its load, over the length of
    the curve, since a motion may stand still or run back in a snap-back. Its top is the peak; all quantities follow from
    cubics through the same rows. The largest row (the first of equal ones) itself is the peak if the rows are fewer than
    four, if it is the first or the last of them, as before a brittle drop, if the cubic has no top between its ends, or one
    higher above that row than it is above its neighbours: such rows tell too little. A load that is not positive has no
    peak between rows.

    Parameters
    ----------
    motions : (m, n) array, mm, at least one motion and one row; a further one tells rows apart where one turns
    load : (n,) array, N

    Returns
    -------
    rows, weights : (k,) arrays; the weights add up to 1
    """
    largest = int(load.argmax())
    alone = np.array([largest]), np.ones(1)
    away = np.flatnonzero(load < _HIGH * load[largest])
    after = int(np.searchsorted(away, largest))
    first = int(away[after - 1]) + 1 if after else 0
    end = int(away[after]) if after < len(away) else len(load)
    if load[largest] <= 0 or end - first < _TERMS or not first < largest < end - 1:
        return alone
    rows = np.arange(first, end)
    curve = np.vstack([motions, load])[:, rows]
    steps = np.diff(curve) / np.maximum(abs(curve).max(axis=1, keepdims=True), 1e-300)
    length = np.r_[0.0, np.linalg.norm(steps, axis=0).cumsum()]
    if not length[-1] > 0:  # or not a number
        return alone
    powers = np.vander(2.0 * length / length[-1] - 1.0, _TERMS, increasing=True)
    if np.linalg.matrix_rank(powers) < _TERMS:  # rows coincide
        return alone
    values, load, largest = np.linalg.pinv(powers), curve[-1], largest - first
    c = values @ load
    flat = Polynomial(c).deriv().roots()
    flat = flat.real[(flat.imag == 0.0) & (abs(flat) < 1.0)]
    tops = flat[c[2] + 3.0 * c[3] * flat < 0.0]
    if not len(tops):
        return alone
    weights = np.vander(tops, _TERMS, increasing=True)[0] @ values
    peak, highest = float(weights @ load), float(2.0 * load[largest] - load[[largest - 1, largest + 1]].min())
    if not float((powers[[0, -1]] @ values @ load).max()) < peak <= highest:
        return alone
    return rows, weights
