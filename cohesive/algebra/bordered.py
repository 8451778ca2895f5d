"""The linear algebra of one Newton iteration: a bordered solve with the elastic stiffness, dense or sparse."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Protocol, TypeAlias

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from numpy.typing import NDArray
from scipy.linalg import blas, lapack

from ..arrays import Array, Index
from ..errors import NotConverged

#: rows, columns and values; entries at one position add up
Entries = tuple[Index, Index, Array]

#: (n, k) matrix of the motions that are allowed; None: all
Free: TypeAlias = sp.csr_array | None

#: the solution from a right-hand side, (n,) each; what `factored` returns takes m of them, (n, m)
Solve: TypeAlias = Callable[[Array], Array]

#: residual of a step by a reused factorization, relative to its forces: Newton's method still gains six digits
_INEXACT = 1e-6

#: the same by a new one in single precision
_EXACT = 1e-10

#: by how much one call of GMRES reduces a residual at most: a preconditioner in single precision is good for no more
_INNER = 1e-5

#: calls of GMRES
_CALLS = 6

#: if a factorization is worth fewer iterations of GMRES, it is cheap
FEWEST = 8

#: rows of a dense matrix whose factorization is worth one more iteration
DENSE_WORTH = 130


class Stiffness(Protocol):
    """The linear part of the problem."""

    def apply(self, v: Array) -> Array:
        """Forces of the unknowns v."""

    @property
    def scale(self) -> float:
        """Largest sum of absolute values in a row, for a bound on rounding."""

    def scaled(self, factor: float) -> Stiffness:
        """The stiffness times a factor, without the factorizations of this one."""

    def forget(self) -> None:
        """Factor anew in the next solve, whatever was solved before."""

    def solve(
        self, crack: Entries, load: Array, row: Array, corner: float, right: Array, last: float, free: Free = None
    ) -> Array:
        """Solve [[K + crack, -load], [row, corner]] [v, factor] = [right, last], within v = free @ y if `free` is given.

        Raises
        ------
        NotConverged
            If the system is singular.
        """


@dataclass
class _Reused:
    """The factorization of an earlier iteration.

    Attributes
    ----------
    size : of its system
    made : how many factorizations there have been
    """

    size: int = 0
    solve: Solve | None = None
    made: int = 0


@dataclass(frozen=True)
class _Bordered(ABC):
    """A stiffness whose last factorization serves as a preconditioner for as long as that is cheaper than another one.

    From one iteration to the next the tangent changes at the points where damage grows or faces meet. GMRES takes about as
    many iterations as there are such points.
    """

    matrix: Any
    _reused: _Reused = field(default_factory=_Reused, compare=False, kw_only=True)

    def apply(self, v: Array) -> Array:
        return np.asarray(self.matrix @ v)

    @cached_property
    def scale(self) -> float:
        return float(abs(self.matrix).sum(axis=1).max())

    def scaled(self, factor: float) -> Stiffness:
        matrix = self.matrix if factor == 1.0 else factor * self.matrix
        return replace(self, matrix=matrix, _reused=_Reused())

    def forget(self) -> None:
        self._reused.solve = None

    @property
    def factorizations(self) -> int:
        """How many factorizations there have been."""
        return self._reused.made

    def factored(self, crack: Entries, load: Array, row: Array, corner: float, free: Free = None) -> Solve:
        """The system of `solve`, factored anew for many right-hand sides: from [right, last], (n + 1, m), to [v, factor], as
        many, as exact as rounding allows.

        Raises
        ------
        NotConverged
            If the system is singular.
        """
        if free is not None:
            load, row = free.T @ load, free.T @ row
        unit = self._unit(crack, row)
        inner = self._factor(crack, load, unit * row, unit * corner, free)

        def one(right: Array) -> Array:
            forces = right[:-1] if free is None else free.T @ right[:-1]
            x = inner(np.append(forces, unit * right[-1]))
            return x if free is None else np.append(free @ x[:-1], x[-1])

        def solve(right: Array) -> Array:  # one by one: LAPACK would start threads for several, which take longer to meet
            return np.stack([one(column) for column in right.T], axis=1)

        return solve

    def _unit(self, crack: Entries, row: Array) -> float:
        """What brings the equation of a control to the size of forces."""
        size = float(np.linalg.norm(row))
        return (self._stiffest or float(abs(crack[2]).max())) / size if size else 1.0

    @abstractmethod
    def _worth(self) -> int:
        """Iterations of GMRES at the price of half a factorization."""

    @cached_property
    def _stiffest(self) -> float:
        return float(abs(self.matrix.diagonal()).max())

    @abstractmethod
    def _factor(self, crack: Entries, load: Array, row: Array, corner: float, free: Free) -> Solve:
        """Factor the bordered system."""

    def _rough(self, crack: Entries, load: Array, row: Array, corner: float, free: Free) -> Solve | None:
        """A cheaper factorization that is good enough for a preconditioner, if there is one."""
        return None

    def solve(
        self, crack: Entries, load: Array, row: Array, corner: float, right: Array, last: float, free: Free = None
    ) -> Array:
        n = len(right)
        if free is not None:
            load, row, right = free.T @ load, free.T @ row, free.T @ right
        unit = self._unit(crack, row)
        row, corner, right = unit * row, unit * corner, np.append(right, unit * last)

        tangent = sp.csr_array((crack[2], crack[:2]), shape=(n, n))

        def forces(x: Array) -> Array:
            v = x[:-1] if free is None else free @ x[:-1]
            force = self.apply(v) + tangent @ v
            return np.asarray(force if free is None else free.T @ force)

        def bordered(x: Array) -> Array:
            return np.append(forces(x) - x[-1] * load, row @ x[:-1] + corner * x[-1])

        x = None
        if self._reused.solve is not None and self._reused.size == len(right) and self._worth() >= FEWEST:
            x = self._iterate(self._reused.solve, forces, bordered, right)
        if x is None:
            self._reused.solve = None  # first, so that no memory is needed for two
            self._reused.size, self._reused.made = len(right), self._reused.made + 1
            rough = self._rough(crack, load, row, corner, free) if self._worth() >= FEWEST else None
            if rough is not None and (x := self._iterate(rough, forces, bordered, right, _EXACT)) is not None:
                self._reused.solve = rough
        if x is None:
            self._reused.solve = self._factor(crack, load, row, corner, free)
            x = self._reused.solve(right)
        return x if free is None else np.append(free @ x[:-1], x[-1])

    def _iterate(
        self, reused: Solve, forces: Solve, bordered: Solve, right: Array, tolerance: float = _INEXACT
    ) -> Array | None:
        """The solution by means of another factorization; None if that takes too long."""
        n, most = len(right), self._worth()
        # preconditioned from the right, so that the residual is that of the system
        system = spla.LinearOperator((n, n), lambda y: bordered(reused(y)), dtype=float)
        x = reused(right)
        for _ in range(_CALLS):  # a guess that is far off has large forces, beside which much is small
            left = right - bordered(x)
            enough = tolerance * max(float(np.linalg.norm(right[:-1])), float(np.linalg.norm(forces(x))))
            if np.linalg.norm(left) <= enough:
                return x
            y, failed = spla.gmres(system, left, rtol=_INNER, atol=enough, restart=most, maxiter=1)
            if failed:
                return None
            x += reused(y)
        return None


@dataclass(frozen=True)
class DenseStiffness(_Bordered):
    """A condensed stiffness, (n, n)."""

    matrix: Array

    def _worth(self) -> int:
        return len(self.matrix) // DENSE_WORTH

    def apply(self, v: Array) -> Array:
        if self._worth() < FEWEST:
            return super().apply(v)
        by_columns = self.matrix if self.matrix.flags.f_contiguous else self.matrix.T
        return np.asarray(blas.dsymv(1.0, by_columns, v, lower=1))  # which reads half of the matrix

    def _factor(self, crack: Entries, load: Array, row: Array, corner: float, free: Free) -> Solve:
        lu, pivots, info = lapack.dgetrf(self._system(crack, load, row, corner, free, np.float64), overwrite_a=True)
        if info:
            raise NotConverged("the tangent stiffness is singular")
        return lambda right: np.asarray(lapack.dgetrs(lu, pivots, right)[0])

    def _rough(self, crack: Entries, load: Array, row: Array, corner: float, free: Free) -> Solve | None:
        """In single precision, which takes half the memory, and less than half the time of a factorization and of a solve."""
        lu, pivots, info = lapack.sgetrf(self._system(crack, load, row, corner, free, np.float32), overwrite_a=True)
        if info:
            return None

        def solve(right: Array) -> Array:
            largest = float(abs(right).max()) or 1.0  # single precision has no numbers below 1e-38
            x = lapack.sgetrs(lu, pivots, (right / largest).astype(np.float32))[0]
            return np.asarray(largest * x.astype(float))

        return solve

    def _system(
        self, crack: Entries, load: Array, row: Array, corner: float, free: Free, precision: type[np.floating[Any]]
    ) -> NDArray[Any]:
        """The bordered matrix, by columns."""
        m, n = len(self.matrix), len(load)
        A: NDArray[Any] = np.empty((m + 1, m + 1), precision, order="F")
        A[:m, :m] = self.matrix
        np.add.at(A, crack[:2], crack[2])
        if free is not None:
            inner = free.T @ (free.T @ A[:m, :m].T).T
            A = np.empty((n + 1, n + 1), precision, order="F")
            A[:n, :n] = inner
        A[:n, n], A[n, :n], A[n, n] = -load, row, corner
        return A


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
        back = np.argsort(order)
        moved = factor.solve(load[order])[back]
        slope = float(row @ moved) + corner
        if not slope:
            raise NotConverged("the tangent stiffness is singular: the load does not change what controls it")

        def solve(right: Array) -> Array:
            v = factor.solve(right[:-1][order])[back]
            change = (right[-1] - row @ v) / slope
            return np.append(v + change * moved, change)

        return solve
