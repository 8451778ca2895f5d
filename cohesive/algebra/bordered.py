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
from .threads import threads_for

#: rows, columns and values; entries at one position add up
Entries = tuple[Index, Index, Array]

#: (n, k) matrix of the motions that are allowed; None: all
Free: TypeAlias = sp.csr_array | None

#: the solution from a right-hand side, (n,) each; what `factored` returns takes m of them, (n, m)
Solve: TypeAlias = Callable[[Array], Array]

#: residual of a step by a reused factorization, relative to its forces: Newton's method still gains six digits
INEXACT = 1e-6

#: the same by a new one in single precision
_EXACT = 1e-10

#: by how much one call of GMRES reduces a residual at most: a preconditioner in single precision is good for no more
_INNER = 1e-5

#: calls of GMRES, each of which must bring the residual below this part of what it was
_CALLS, _PROGRESS = 6, 0.1

#: if a factorization is worth fewer iterations of GMRES, it is cheap
FEWEST = 8

#: rows of a dense matrix whose factorization is worth one more iteration
DENSE_WORTH = 180


@dataclass(frozen=True)
class Border:
    """What an iteration adds to the elastic stiffness K: the system [[K + crack, -load], [row, corner]] [v, factor], within
    v = free @ y if `free` is given.

    Attributes
    ----------
    crack : tangent stiffness of points and springs, N/mm
    load : (n,) array, forces of a unit of load
    row, corner : derivatives of a control's equation in the unknowns, (n,), and in the load
    free : see `Free`
    """

    crack: Entries
    load: Array
    row: Array
    corner: float
    free: Free = None

    def moved(self, x: Array) -> Array:
        """v from [y, factor]."""
        return x[:-1] if self.free is None else np.asarray(self.free @ x[:-1])

    def whole(self, x: Array) -> Array:
        """[v, factor] from [y, factor]."""
        return x if self.free is None else np.append(self.moved(x), x[-1])

    def forces(self, f: Array) -> Array:
        """On the motions y, from those on the unknowns."""
        return f if self.free is None else np.asarray(self.free.T @ f)


class Stiffness(Protocol):
    """The linear part of the problem."""

    def apply(self, v: Array) -> Array:
        """Forces of the unknowns v."""

    @property
    def scale(self) -> float:
        """Largest sum of absolute values in a row, for a bound on rounding."""

    def scaled(self, factor: float) -> Stiffness:
        """The stiffness times a factor, without the factorizations of this one."""

    def drop_factorization(self) -> None:
        """Factor anew in the next solve, whatever was solved before."""

    def solve(self, border: Border, right: Array, last: float, forcing: float = INEXACT) -> Array:
        """Solution [v, factor], (n + 1,), of the system that `border` describes, for the right-hand side [right, last].

        Parameters
        ----------
        forcing : residual that the solution may leave, relative to its forces; a direct solution leaves rounding.

        Raises
        ------
        NotConverged
            If the system is singular.
        """


class _Weighed(Border):
    """A border with `load` and `row` on the motions y, and the control's equation at the size of forces."""

    @cached_property
    def tangent(self) -> sp.csr_array:
        """`crack` as a matrix."""
        n = len(self.load) if self.free is None else self.free.shape[0]
        return sp.csr_array((self.crack[2], self.crack[:2]), shape=(n, n))

    def right(self, f: Array, last: float) -> Array:
        """The right-hand side, from the forces on the unknowns."""
        return np.append(self.forces(f), last)

    def apply(self, x: Array) -> Array:
        forces = self.forces(self.tangent @ self.moved(x))
        return np.append(forces - x[-1] * self.load, self.row @ x[:-1] + self.corner * x[-1])


@dataclass
class _Reused:
    """The factorization of an earlier iteration.

    Attributes
    ----------
    border : of its system
    made : how many factorizations there have been
    """

    border: _Weighed | None = None
    solve: Solve | None = None
    made: int = 0

    def takes(self, right: Array) -> bool:
        """Whether it is there, and of this size."""
        return self.solve is not None and self.border is not None and len(self.border.load) + 1 == len(right)


@dataclass(frozen=True)
class _Bordered(ABC):
    """A stiffness, `factor` times a matrix, whose last factorization serves as a preconditioner for as long as that is
    cheaper than another one.

    From one iteration to the next the tangent changes at the points where damage grows or faces meet. GMRES takes about as
    many iterations as there are such points.
    """

    matrix: Any
    factor: float = field(default=1.0, kw_only=True)
    _reused: _Reused = field(default_factory=_Reused, compare=False, kw_only=True)

    def apply(self, v: Array) -> Array:
        return np.asarray(self.factor * (self.matrix @ v))

    @cached_property
    def scale(self) -> float:
        return self.factor * float(abs(self.matrix).sum(axis=1).max())

    def scaled(self, factor: float) -> Stiffness:
        return replace(self, factor=factor * self.factor, _reused=_Reused())

    def drop_factorization(self) -> None:
        self._reused.solve = None

    @property
    def factorizations(self) -> int:
        """How many factorizations there have been."""
        return self._reused.made

    def factored(self, border: Border) -> Solve:
        """The system of `solve`, factored anew for many right-hand sides: from [right, last], (n + 1, m), to [v, factor], as
        many, as exact as rounding allows.

        Raises
        ------
        NotConverged
            If the system is singular.
        """
        weighed, unit = self._weighed(border)
        inner = self._factor(weighed)

        def one(right: Array) -> Array:
            return weighed.whole(inner(weighed.right(right[:-1], unit * right[-1])))

        def solve(right: Array) -> Array:  # one by one: LAPACK would start threads for several, which take longer to meet
            return np.stack([one(column) for column in right.T], axis=1)

        return solve

    def _weighed(self, border: Border) -> tuple[_Weighed, float]:
        """The border on y, and what brings the equation of its control to the size of forces."""
        load, row = border.forces(border.load), border.forces(border.row)
        size = float(np.linalg.norm(row))
        unit = (self._stiffest or float(abs(border.crack[2]).max())) / size if size else 1.0
        return _Weighed(border.crack, load, unit * row, unit * border.corner, border.free), unit

    @abstractmethod
    def _worth(self) -> int:
        """Iterations of GMRES at the price of half a factorization."""

    @cached_property
    def _stiffest(self) -> float:
        return self.factor * float(abs(self.matrix.diagonal()).max())

    @abstractmethod
    def _factor(self, border: _Weighed) -> Solve:
        """Factor the bordered system."""

    def _rough(self, border: _Weighed) -> Solve | None:
        """A cheaper factorization that is good enough for a preconditioner, if there is one."""
        return None

    def solve(self, border: Border, right: Array, last: float, forcing: float = INEXACT) -> Array:
        reused = self._reused
        weighed, unit = self._weighed(border)
        right = weighed.right(right, unit * last)
        x = None
        if self._worth() >= FEWEST:
            if reused.takes(right):
                x = self._iterate(weighed, right, forcing)
            if x is None:
                reused.solve = None  # first, so that no memory is needed for two
                reused.solve, reused.border = self._rough(weighed), weighed
                if reused.takes(right):
                    reused.made += 1
                    x = self._iterate(weighed, right, _EXACT)
        if x is None:
            reused.solve = None
            reused.solve, reused.made = self._factor(weighed), reused.made + 1
            x = reused.solve(right)
        return weighed.whole(x)

    def _iterate(self, border: _Weighed, right: Array, tolerance: float) -> Array | None:
        """The solution by means of the factorization that there is; None if that takes too long.

        It is preconditioned from the right, so that the residual is that of the system. The factored system differs from
        this one by the borders alone: the product of this system with a solution y of that one is the right-hand side of y
        and the difference of the borders times y. What rounding in single precision leaves is for the next call.
        """
        then, solve, most, used = self._reused.border, self._reused.solve, self._worth(), 0
        assert then is not None and solve is not None

        def product(y: Array) -> Array:
            nonlocal used
            used += 1
            z = solve(y)
            return y + border.apply(z) - then.apply(z)

        system = spla.LinearOperator((len(right),) * 2, product, dtype=float)
        x, before = solve(right), np.inf
        for _ in range(_CALLS):  # a guess that is far off has large forces, beside which much is small
            have = border.apply(x)
            have[:-1] += border.forces(self.apply(border.moved(x)))
            left = right - have
            enough = tolerance * float(max(np.linalg.norm(right[:-1]), np.linalg.norm(have[:-1] + x[-1] * border.load)))
            size = float(np.linalg.norm(left))
            if size <= enough:
                if used > most:  # the next one is better off with its own
                    self._reused.solve = None
                return x
            if not size < _PROGRESS * before or used >= 2 * most:
                return None
            y, _ = spla.gmres(system, left, rtol=_INNER, atol=0.5 * enough, restart=2 * most - used, maxiter=1)
            x, before = x + solve(y), size
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
        return np.asarray(blas.dsymv(self.factor, by_columns, v, lower=1))  # which reads half of the matrix

    def _factor(self, border: _Weighed) -> Solve:
        A = self._system(border, np.float64)
        with threads_for(len(A)):
            lu, pivots, info = lapack.dgetrf(A, overwrite_a=True)
        if info:
            raise NotConverged("the tangent stiffness is singular")
        return lambda right: np.asarray(lapack.dgetrs(lu, pivots, right)[0])

    def _rough(self, border: _Weighed) -> Solve | None:
        """In single precision, which takes half the memory, and less than half the time of a factorization and of a solve."""
        A = self._system(border, np.float32)
        with threads_for(len(A)):
            lu, pivots, info = lapack.sgetrf(A, overwrite_a=True)
        if info:
            return None

        def solve(right: Array) -> Array:
            largest = float(abs(right).max()) or 1.0  # single precision has no numbers below 1e-38
            x = lapack.sgetrs(lu, pivots, (right / largest).astype(np.float32))[0]
            return np.asarray(largest * x.astype(float))

        return solve

    def _system(self, border: _Weighed, precision: type[np.floating[Any]]) -> NDArray[Any]:
        """The bordered matrix, by columns."""
        m, n, crack, free = len(self.matrix), len(border.load), border.crack, border.free
        A: NDArray[Any] = np.empty((m + 1, m + 1), precision, order="F")
        np.multiply(self.matrix, self.factor, out=A[:m, :m], casting="same_kind")
        np.add.at(A, crack[:2], crack[2])
        if free is not None:
            inner = free.T @ (free.T @ A[:m, :m].T).T
            A = np.empty((n + 1, n + 1), precision, order="F")
            A[:n, :n] = inner
        A[:n, n], A[n, :n], A[n, n] = -border.load, border.row, border.corner
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

    def _factor(self, border: _Weighed) -> Solve:
        A, load, row, free = self.factor * self.matrix + border.tangent, border.load, border.row, border.free
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
        slope = float(row @ moved) + border.corner
        if not slope:
            raise NotConverged("the tangent stiffness is singular: the load does not change what controls it")

        def solve(right: Array) -> Array:
            v = factor.solve(right[:-1][order])[back]
            change = (right[-1] - row @ v) / slope
            return np.append(v + change * moved, change)

        return solve
