"""The local iteration of a crack band, Box 1 of the paper: the strains of the crack planes of a point, see `band_points`."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..arrays import Array, Index, Mask
from ..elements.rotations import stress_transformation
from ..law.crack_plane import CrackPlane
from .crack_planes import CrackPlanes

MAX_ITERATIONS = 15  # of Box 1

#: allowed stress error (41), as a part of ft; the paper takes 1e-6
TOL = 1e-11

#: singular values of M below this part of the largest one are taken as 0
CUT_OFF = 1e-10

#: a point without a solution is led to its strain from the committed one: part of the way that is tried first, and at least
_FIRST_PART, _SMALLEST_PART = 0.25, 1.0 / 64.0

#: the local line search wants the stress error to fall by this part of the step length; its lengths below 1
_DECREASE = 1e-4

_LENGTHS = 0.5 ** np.arange(1, 8)


class Group:
    """The points with the same number m of crack planes, and their local iteration.

    `frozen` leaves the damage as it was committed, see `CrackPlane.update`. In the local iteration that holds for its first
    evaluation only: the first direction is then the elastic one, the iterates that follow may damage.

    Parameters
    ----------
    plane : CrackPlane, of any width; each crack takes l_ch for its own.
    D : (k, k) array, MPa, elasticity.
    compliance : (d,) array, 1/MPa, diagonal of C.
    cracks : CrackPlanes of all points, as committed.
    planes : (g, m) array, their numbers in that list, a row for each of the g points.
    strain : (g, k) array, to which the points are led.
    """

    def __init__(
        self, plane: CrackPlane, D: Array, compliance: Array, cracks: CrackPlanes, planes: Index, strain: Array
    ) -> None:
        self.plane, self.D, self.strain = plane, D, strain
        g, m = planes.shape
        flat = planes.ravel()
        d = cracks.strain.shape[1]
        self.shape = (g, m, d)
        self.length = cracks.length[flat]
        self.N = stress_transformation(cracks.rotation[flat]).reshape(g, m * d, -1)
        self.ND = self.N @ D
        self.P = self.ND @ self.N.transpose(0, 2, 1)
        self.C = np.tile(compliance, m)
        self.Z0 = cracks.Z[flat]
        self.e0 = cracks.strain[planes].reshape(g, m * d)
        self.scale = TOL * plane.concrete.ft
        self.e = self.e0.copy()  # what `solve` finds

    def _at(self, e: Array, strain: Array, rows: Index, frozen: bool = False) -> tuple[Array, Array, Array, Array, Array]:
        """Stress error (41), T, tractions, history and stress of some points of the group."""
        _, m, d = self.shape
        flat = (rows[:, None] * m + np.arange(m)).ravel()
        law = self.plane.with_width(self.length[flat])
        jump = e.reshape(-1, d) * self.length[flat, None]
        traction, tangent, Z = law.update(jump, self.Z0[flat], frozen)
        tangent *= self.length[flat, None, None]
        s = traction.reshape(len(rows), m * d)
        T = np.zeros((len(rows), m * d, m * d))
        for i in range(m):
            T[:, i * d : (i + 1) * d, i * d : (i + 1) * d] = tangent.reshape(len(rows), m, d, d)[:, i]
        fracture = e - self.C * s
        stress = (strain - np.einsum("gak,ga->gk", self.N[rows], fracture)) @ self.D.T
        return np.einsum("gak,gk->ga", self.N[rows], stress) - s, T, s, Z, stress

    def _matrix(self, T: Array, rows: Index) -> Array:
        """M = T + N De N^T (I - C T)."""
        return np.asarray(T + self.P[rows] - self.P[rows] @ (self.C[:, None] * T))

    def _newton(self, e: Array, strain: Array, rows: Index, frozen: bool) -> tuple[Array, Mask]:
        """Local iteration of Box 1 from the local strains `e` of some points, with a line search; the history stays what it
        was. Local strains, and whether they solve their point on the branch that begins elastic."""
        e = e.copy()
        floor = 8 * np.finfo(float).eps * float(abs(self.D).max())
        error, T, *_ = self._at(e, strain, rows, frozen)
        for _ in range(MAX_ITERATIONS):
            done = abs(error).max(axis=1) <= np.maximum(self.scale, floor * abs(e).max(axis=1))
            left = np.flatnonzero(~done)
            if not left.size:
                break
            at = rows[left]
            step = _least_norm(self._matrix(T[left], at), error[left, :, None])[:, :, 0]
            start, norm = e[left], np.linalg.norm(error[left], axis=1)
            e[left] += step
            error[left], T[left], *_ = self._at(e[left], strain[left], at)
            # if the full step raises the error the first shorter one is taken that does not, else the full one
            rising = np.flatnonzero(~(np.linalg.norm(error[left], axis=1) < (1.0 - _DECREASE) * norm))
            for length in _LENGTHS:
                if not rising.size:
                    break
                shorter = start[rising] + length * step[rising]
                new_error, new_T, *_ = self._at(shorter, strain[left[rising]], at[rising])
                better = np.linalg.norm(new_error, axis=1) < (1.0 - _DECREASE * length) * norm[rising]
                found = left[rising[better]]
                e[found], error[found], T[found] = shorter[better], new_error[better], new_T[better]
                rising = rising[~better]
        done = abs(error).max(axis=1) <= np.maximum(self.scale, floor * abs(e).max(axis=1))
        if self.shape[1] == 1:  # elastic it is positive; beyond a fold it has changed its sign
            done &= np.linalg.det(self._matrix(T, rows)) > 0
        return e, done

    def solve(self, committed: Array, frozen: bool) -> Mask:
        """Local strains at `strain`, from those at the strain `committed`. Whether each point has been solved."""
        every = np.arange(self.shape[0])
        solved = np.zeros(len(every), dtype=bool)
        for first_frozen in (frozen, not frozen):
            rows = every[~solved]
            if not rows.size:
                break
            e, ok = self._newton(self.e0[rows], self.strain[rows], rows, first_frozen)
            self.e[rows[ok]] = e[ok]
            solved[rows[ok]] = True
        # led there from the committed strain, each point in steps of its own
        e, there, part = self.e0.copy(), np.zeros(len(every)), np.full(len(every), _FIRST_PART)
        while (rows := every[~solved & (part >= _SMALLEST_PART)]).size:
            to = np.minimum(there[rows] + part[rows], 1.0)
            strain = committed[rows] + to[:, None] * (self.strain[rows] - committed[rows])
            found, ok = self._newton(e[rows], strain, rows, False)
            e[rows[ok]], there[rows[ok]] = found[ok], to[ok]
            part[rows] *= np.where(ok, 2.0, 0.5)
            solved |= there >= 1.0
        led = there >= 1.0
        self.e[led] = e[led]
        return solved

    def respond(self, frozen: bool) -> tuple[Array, Array, Array, Array, Array]:
        """At the solution: stress, consistent tangent (37), tractions, history and de / deps."""
        g, m, d = self.shape
        rows = np.arange(g)
        _, T, s, Z, stress = self._at(self.e, self.strain, rows, frozen)
        slope = _least_norm(self._matrix(T, rows), self.ND)
        release = self.N.transpose(0, 2, 1) @ (slope - self.C[:, None] * (T @ slope))
        tangent = self.D - self.D @ release
        return stress, tangent, s.reshape(g, m, d), Z.reshape(g, m), slope.reshape(g, m, d, -1)


def groups(point: Index) -> Iterator[tuple[Index, Index]]:
    """Points with the same number m of planes, (g,), and the numbers of their planes, (g, m)."""
    points, count = np.unique(point, return_counts=True)
    order = np.argsort(point, kind="stable")
    first = np.cumsum(count) - count
    for m in np.unique(count).tolist():
        at = np.flatnonzero(count == m)
        yield points[at], order[first[at, None] + np.arange(m)]


def _least_norm(M: Array, right: Array) -> Array:
    """Solutions of M x = right, (n, a, b), of minimum norm if M is singular."""
    if M.shape[1] <= 3:  # a single plane: regular but at a fold
        try:
            return np.asarray(np.linalg.solve(M, right))
        except np.linalg.LinAlgError:
            pass
    return np.asarray(np.linalg.pinv(M, rcond=CUT_OFF) @ right)
