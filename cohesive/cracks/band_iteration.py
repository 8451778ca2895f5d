"""The local iteration of a crack band, Box 1 of the paper: the strains of the crack planes of a point, see `band_points`."""

from __future__ import annotations

import numpy as np

from ..arrays import Array, Index, Mask
from ..elements.rotations import stress_transformation
from ..law.registry import Law
from .crack_planes import CrackPlanes

MAX_ITERATIONS = 15  # of Box 1, each with one evaluation of the law

#: allowed stress error (41), as a part of ft; the paper takes 1e-6
TOL = 1e-11

#: singular values of M below this part of the largest one are taken as 0
CUT_OFF = 1e-10

#: condition of M from which on its singular values are looked at
_CLOSE = 1e4

#: a point without a solution is led to its strain from the committed one: part of the way that is tried first, and at least
_FIRST_PART, _SMALLEST_PART = 0.25, 1.0 / 64.0

#: the local line search wants the stress error to fall by this part of the step length; its lengths below 1
_DECREASE = 1e-4

_LENGTHS = 0.5 ** np.arange(1, 8)


class LocalIteration:
    """The points that have crack planes, and their local iteration: all of them at once, each with its own number of planes.

    `frozen` leaves the damage as it was committed, see `Law.update`. In the local iteration that holds for its first
    evaluation only: the first direction is then the elastic one, the iterates that follow may damage.

    Arrays over the planes of a point have room for m planes, as many as a point has at most; what is beyond the number of
    planes of a point is 0.

    Parameters
    ----------
    law : Law that takes a width, of any; each crack takes l_ch for its own.
    D : (k, k) array, MPa, elasticity.
    compliance : (d,) array, 1/MPa, diagonal of C.
    cracks : CrackPlanes of all points, as committed.
    strain : (p, k) array, to which the points are led.

    Attributes
    ----------
    points : (g,) array, the points that have planes
    planes : (c,) array, the planes of the first of them, of the second, and so on
    """

    def __init__(self, law: Law, D: Array, compliance: Array, cracks: CrackPlanes, strain: Array) -> None:
        self.points, of, self.count = np.unique(cracks.point, return_inverse=True, return_counts=True)
        self.planes = np.argsort(of, kind="stable")
        self.law, self.D, self.strain = law, D, strain[self.points]
        g, m, d = len(self.points), int(self.count.max(initial=0)), cracks.strain.shape[1]
        self.shape = (g, m, d)
        self.has = np.arange(m) < self.count[:, None]  # (g, m), whether a point has such a plane
        self.length = self._on_points(cracks.length)
        self.N = self._on_points(stress_transformation(cracks.rotation)).reshape(g, m * d, -1)
        self.ND = self.N @ D
        self.P = self.ND @ self.N.transpose(0, 2, 1)
        self.C = np.tile(compliance, m)
        self.history0 = self._on_points(cracks.history)
        self.e0 = self._on_points(cracks.strain).reshape(g, m * d)
        self.slope0 = self._on_points(cracks.slope).reshape(g, m * d, -1)
        self.has_slopes = (self._on_points(cracks.slope.any(axis=(1, 2)).astype(float)) == self.has).all(axis=1)
        self.scale = TOL * law.strength
        self.e = self.e0.copy()  # what `solve` finds, and what there is then
        self._values: list[Array] = []
        self._is_frozen = np.zeros(g, dtype=bool)

    def _on_points(self, values: Array) -> Array:
        """(g, m, ...) array, from one number or more for each plane."""
        result: Array = np.zeros((*self.has.shape, *values.shape[1:]))
        result[self.has] = values[self.planes]
        return result

    def on_planes(self, values: Array) -> Array:
        """(c, ...) array, in the order of `planes`, from a (g, m, ...) array."""
        return np.asarray(values[self.has])

    def _at(self, e: Array, strain: Array, rows: Index, frozen: bool = False) -> list[Array]:
        """Stress error (41), T, tractions, history and stress of some points."""
        _, m, d = self.shape
        has = self.has[rows]
        length = self.length[rows][has]
        law = self.law.with_width(length)
        on_planes = law.update(e.reshape(-1, m, d)[has] * length[:, None], self.history0[rows][has], frozen)
        s, T, Z = np.zeros((len(rows), m * d)), np.zeros((len(rows), m * d, m * d)), np.zeros(self.history0[rows].shape)
        s.reshape(-1, m, d)[has], Z[has] = on_planes[0], on_planes[2]
        row, i = np.nonzero(has)
        T.reshape(-1, m, d, m, d)[row, i, :, i] = on_planes[1] * length[:, None, None]
        fracture = e - self.C * s
        stress = (strain - np.einsum("gak,ga->gk", self.N[rows], fracture)) @ self.D.T
        return [np.einsum("gak,gk->ga", self.N[rows], stress) - s, T, s, Z, stress]

    def _matrix(self, T: Array, rows: Index) -> Array:
        """M = T + N De N^T (I - C T)."""
        return np.asarray(T + self.P[rows] - self.P[rows] @ (self.C[:, None] * T))

    def _solve(self, T: Array, right: Array, rows: Index) -> Array:
        """Solutions of M x = right, (n, m d, b), on the planes that there are."""
        M, result, d = self._matrix(T, rows), np.zeros_like(right), self.shape[2]
        count = self.count[rows]
        for m in range(1, self.shape[1] + 1):
            at, size = np.flatnonzero(count == m), m * d
            if at.size:
                result[at, :size] = _least_norm(M[at, :size, :size], right[at, :size])
        return result

    def _newton(
        self, e: Array, strain: Array, rows: Index, frozen: bool, change: Array | None = None
    ) -> tuple[Array, Mask, list[Array], Mask]:
        """Local iteration of Box 1 from the local strains `e` of some points, with a line search; the history stays what it
        was.

        Parameters
        ----------
        change : (n, k) array, of the strains from the committed ones, if `e` are the committed local strains: stress error and
            first step then follow from the committed slopes, if all planes of a point have one.

        Returns
        -------
        e : local strains
        done : whether they solve their point on the branch that begins elastic
        values, is_frozen : what `_at` finds there, and whether frozen
        """
        e, (_, m, d), n = e.copy(), self.shape, len(rows)
        floor = 8 * np.finfo(float).eps * float(abs(self.D).max())
        shapes = (m * d,), (m * d, m * d), (m * d,), self.history0.shape[1:], strain.shape[1:]
        values = [np.zeros((n, *shape)) for shape in shapes]
        error, T, is_frozen = values[0], values[1], np.full(n, frozen)
        error[:] = np.inf  # until it is known

        def is_solved() -> Mask:
            return np.asarray(abs(error).max(axis=1) <= np.maximum(self.scale, floor * abs(e).max(axis=1)))

        step, norm = np.zeros_like(e), np.full(n, np.inf)  # of the error before the step
        if change is not None:
            error[:] = np.einsum("gak,gk->ga", self.ND[rows], change)
            first = self.has_slopes[rows] & ~is_solved()
            step[first] = np.einsum("gak,gk->ga", self.slope0[rows[first]], change[first])
            norm[first] = np.linalg.norm(error[first], axis=1)
        left = np.arange(n)
        for _ in range(MAX_ITERATIONS):
            start = e[left]
            e[left], is_frozen[left] = start + step[left], frozen
            _store(values, left, self._at(e[left], strain[left], rows[left], frozen))
            frozen = False
            # if the full step raises the error the first shorter one is taken that does not, else the full one
            rising = np.flatnonzero(~(np.linalg.norm(error[left], axis=1) < (1.0 - _DECREASE) * norm[left]))
            for length in _LENGTHS:
                if not rising.size:
                    break
                at = left[rising]
                shorter = start[rising] + length * step[at]
                new = self._at(shorter, strain[at], rows[at])
                better = np.linalg.norm(new[0], axis=1) < (1.0 - _DECREASE * length) * norm[at]
                e[at[better]] = shorter[better]
                _store(values, at[better], [each[better] for each in new])
                rising = rising[~better]
            left = np.flatnonzero(~is_solved())
            if not left.size:
                break
            step[left] = self._solve(T[left], error[left, :, None], rows[left])[:, :, 0]
            norm[left] = np.linalg.norm(error[left], axis=1)
        done = is_solved()
        # of one plane: elastic it is positive; beyond a fold it has changed its sign
        single, d = np.flatnonzero(self.count[rows] == 1), self.shape[2]
        done[single] &= np.linalg.det(self._matrix(T[single], rows[single])[:, :d, :d]) > 0
        return e, done, values, is_frozen

    def solve(self, committed: Array, frozen: bool) -> Mask:
        """Local strains at `strain`, from those at the strain `committed`, (p, k). Whether each point has been solved."""
        every, committed = np.arange(self.shape[0]), committed[self.points]
        solved = np.zeros(len(every), dtype=bool)
        for first_frozen in (frozen, not frozen):
            rows = every[~solved]
            if not rows.size:
                break
            change = None if first_frozen else self.strain[rows] - committed[rows]
            e, ok, values, is_frozen = self._newton(self.e0[rows], self.strain[rows], rows, first_frozen, change)
            self._keep(rows, e, values, is_frozen, ok)
            solved[rows[ok]] = True
        # led there from the committed strain, each point in steps of its own
        e, there, part = self.e0.copy(), np.zeros(len(every)), np.full(len(every), _FIRST_PART)
        while (rows := every[~solved & (part >= _SMALLEST_PART)]).size:
            to = np.minimum(there[rows] + part[rows], 1.0)
            strain = committed[rows] + to[:, None] * (self.strain[rows] - committed[rows])
            new, ok, values, is_frozen = self._newton(e[rows], strain, rows, False)
            e[rows[ok]], there[rows[ok]] = new[ok], to[ok]
            part[rows] *= np.where(ok, 2.0, 0.5)
            self._keep(rows, new, values, is_frozen, ok & (to >= 1.0))
            solved |= there >= 1.0
        return solved

    def _keep(self, rows: Index, e: Array, values: list[Array], is_frozen: Mask, ok: Mask) -> None:
        """Keep the solutions of some points, and what there is at them."""
        if not self._values:
            self._values = [np.zeros((self.shape[0], *each.shape[1:])) for each in values]
        at = rows[ok]
        self.e[at], self._is_frozen[at] = e[ok], is_frozen[ok]
        _store(self._values, at, [each[ok] for each in values])

    def respond(self, frozen: bool) -> tuple[Array, Array, Array, Array, Array]:
        """At the solution: stress, consistent tangent (37), tractions, history and de / deps."""
        g, m, d = self.shape
        other = np.flatnonzero(self._is_frozen != frozen)
        if other.size:
            _store(self._values, other, self._at(self.e[other], self.strain[other], other, frozen))
        _, T, s, Z, stress = self._values
        slope = self._solve(T, self.ND, np.arange(g))
        release = self.N.transpose(0, 2, 1) @ (slope - self.C[:, None] * (T @ slope))
        tangent = self.D - self.D @ release
        return stress, tangent, s.reshape(g, m, d), Z, slope.reshape(g, m, d, -1)


def _store(kept: list[Array], at: Index, new: list[Array]) -> None:
    """Write what `_at` finds at some points over what is kept of them."""
    for old, one in zip(kept, new, strict=True):
        old[at] = one


def _least_norm(M: Array, right: Array) -> Array:
    """Solutions of M x = right, (n, a, b), of minimum norm where M is singular, or close to it."""
    try:
        inverse = np.linalg.inv(M)
    except np.linalg.LinAlgError:
        inverse = np.linalg.pinv(M, rcond=CUT_OFF)
    else:
        if M.shape[1] > 3:  # a single plane is regular but at a fold
            close = np.linalg.norm(M, axis=(1, 2)) * np.linalg.norm(inverse, axis=(1, 2)) > _CLOSE
            inverse[close] = np.linalg.pinv(M[close], rcond=CUT_OFF)
    return np.asarray(inverse @ right)
