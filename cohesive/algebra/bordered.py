"""The linear algebra of one Newton iteration: a bordered solve with the elastic stiffness, dense or sparse."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Protocol, TypeAlias

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from scipy.linalg import lapack

from ..arrays import Array, Index
from ..errors import NotConverged

Entries = tuple[Index, Index, Array]

Free: TypeAlias = sp.csr_array | None

Solve: TypeAlias = Callable[[Array], Array]

#: residual of a step that an older factorization gave, relative to its forces: Newton's method still gains six digits
_INEXACT = 1e-6

#: below so many iterations of GMRES the factorization is cheap
FEWEST = 8

#: of a dense matrix the rows for each of these iterations, at its half
DENSE_WORTH = 130


class Stiffness(Protocol):
    """The linear part of the problem."""

    def apply(self, v: Array) -> Array:
        """Forces of the unknowns v."""

    @property
    def scale(self) -> float:
        """Largest sum of absolute values in a row, for a bound on rounding."""

    def solve(
        self, crack: Entries, load: Array, row: Array, corner: float, right: Array, last: float, free: Free = None
    ) -> Array:
        """Solve [[K + crack, -load], [row, corner]] [v, factor] = [right, last], within v = free @ y if given."""


@dataclass
class _Older:
    """A factorization of an earlier iteration."""

    size: int = 0
    solve: Solve | None = None
    made: int = 0


@dataclass(frozen=True)
class _Bordered(ABC):
    """A stiffness whose last factorization serves as a preconditioner for as long as that is cheaper than another one.

    From one iteration to the next the tangent changes where damage grows or faces meet, and GMRES takes about as many
    iterations as there are such places.
    """

    matrix: Any
    _older: _Older = field(default_factory=_Older, compare=False, kw_only=True)

    def apply(self, v: Array) -> Array:
        return np.asarray(self.matrix @ v)

    @cached_property
    def scale(self) -> float:
        return float(abs(self.matrix).sum(axis=1).max())

    @property
    def factorizations(self) -> int:
        """How many there have been."""
        return self._older.made

    @abstractmethod
    def _worth(self) -> int:
        """Iterations of GMRES at the price of half a factorization."""

    @cached_property
    def _stiffest(self) -> float:
        return float(abs(self.matrix.diagonal()).max())

    @abstractmethod
    def _factor(self, crack: Entries, load: Array, row: Array, corner: float, free: Free) -> Solve:
        """Factor the bordered system."""

    def solve(
        self, crack: Entries, load: Array, row: Array, corner: float, right: Array, last: float, free: Free = None
    ) -> Array:
        n = len(right)
        if free is not None:
            load, row, right = free.T @ load, free.T @ row, free.T @ right
        # the control in forces, too
        size = float(np.linalg.norm(row))
        unit = (self._stiffest or float(abs(crack[2]).max())) / size if size else 1.0
        row, corner, right = unit * row, unit * corner, np.append(right, unit * last)

        x = None
        if self._older.solve is not None and self._older.size == len(right) and self._worth() >= FEWEST:
            tangent = sp.csr_array((crack[2], crack[:2]), shape=(n, n))

            def forces(x: Array) -> Array:
                v = x[:-1] if free is None else free @ x[:-1]
                force = self.apply(v) + tangent @ v
                return np.asarray(force if free is None else free.T @ force)

            def bordered(x: Array) -> Array:
                return np.append(forces(x) - x[-1] * load, row @ x[:-1] + corner * x[-1])

            x = self._iterate(self._older.solve, forces, bordered, right)
        if x is None:
            self._older.solve = None  # first, so that there is no need for room for two
            self._older.size, self._older.solve = len(right), self._factor(crack, load, row, corner, free)
            self._older.made += 1
            x = self._older.solve(right)
        return x if free is None else np.append(free @ x[:-1], x[-1])

    def _iterate(self, older: Solve, forces: Solve, bordered: Solve, right: Array) -> Array | None:
        """The solution by means of the older factorization; None where that takes too long."""
        n, most = len(right), self._worth()
        # preconditioned from the right, so that the residual is that of the system
        system = spla.LinearOperator((n, n), lambda y: bordered(older(y)), dtype=float)
        x = older(right)
        for _ in range(3):  # a guess that is far off has large forces, beside which much is small
            left = right - bordered(x)
            enough = _INEXACT * max(float(np.linalg.norm(right[:-1])), float(np.linalg.norm(forces(x))))
            if np.linalg.norm(left) <= enough:
                return x
            y, failed = spla.gmres(system, left, rtol=0.0, atol=enough, restart=most, maxiter=1)
            if failed:
                return None
            x += older(y)
        return None


@dataclass(frozen=True)
class DenseStiffness(_Bordered):
    """A condensed stiffness, (n, n)."""

    matrix: Array

    def _worth(self) -> int:
        return len(self.matrix) // DENSE_WORTH

    def _factor(self, crack: Entries, load: Array, row: Array, corner: float, free: Free) -> Solve:
        m, n = len(self.matrix), len(load)
        A = np.empty((m + 1, m + 1), order="F")
        A[:m, :m] = self.matrix
        np.add.at(A, crack[:2], crack[2])
        if free is not None:
            inner = free.T @ (free.T @ A[:m, :m].T).T
            A = np.empty((n + 1, n + 1), order="F")
            A[:n, :n] = inner
        A[:n, n], A[n, :n], A[n, n] = -load, row, corner
        lu, pivots, info = lapack.dgetrf(A, overwrite_a=True)
        if info:
            raise NotConverged("the tangent stiffness is singular")
        return lambda right: np.asarray(lapack.dgetrs(lu, pivots, right)[0])


@dataclass(frozen=True)
class SparseStiffness(_Bordered):
    """The stiffness of all unknowns.

    Attributes
    ----------
    matrix : (n, n)
    order : (n,) array, the unknowns in an order that keeps factors sparse, the drives last.
    worth : iterations of GMRES at the price of half a factorization
    """

    matrix: sp.csc_array
    order: Index
    worth: int

    def _worth(self) -> int:
        return self.worth

    def _factor(self, crack: Entries, load: Array, row: Array, corner: float, free: Free) -> Solve:
        A = self.matrix + sp.coo_array((crack[2], crack[:2]), shape=self.matrix.shape)
        order = self.order[: len(load)]
        if free is not None:  # the free motions are numbered alike, but for the drives
            A = free.T @ A @ free
        A = sp.csc_array(A)[order][:, order]
        try:
            factor = spla.splu(A, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        except RuntimeError:
            raise NotConverged("the tangent stiffness is singular") from None
        place = np.argsort(order)
        moved = factor.solve(load[order])[place]
        slope = float(row @ moved) + corner
        if not slope:
            raise NotConverged("the tangent stiffness is singular: the load does not change what controls it")

        def solve(right: Array) -> Array:
            v = factor.solve(right[:-1][order])[place]
            change = (right[-1] - row @ v) / slope
            return np.append(v + change * moved, change)

        return solve
