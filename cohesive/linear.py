"""The linear algebra of one Newton iteration: a bordered solve with the elastic stiffness, dense or sparse."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol, TypeAlias

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Entries = tuple[Index, Index, Array]
Free: TypeAlias = sp.csr_array | None


class NotConverged(RuntimeError):
    """A step that did not converge. `result` holds everything computed before it, once `run` has passed it on;
    `finished` the runs that `compare` had finished."""

    result: object = None
    finished: object = None


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


@dataclass(frozen=True)
class DenseStiffness:
    """A condensed stiffness, (n, n)."""

    matrix: Array

    def apply(self, v: Array) -> Array:
        return np.asarray(self.matrix @ v)

    @cached_property
    def scale(self) -> float:
        return float(abs(self.matrix).sum(axis=1).max())

    def solve(
        self, crack: Entries, load: Array, row: Array, corner: float, right: Array, last: float, free: Free = None
    ) -> Array:
        n = len(right)
        A = np.empty((n + 1, n + 1), order="F")
        A[:n, :n] = self.matrix
        np.add.at(A, crack[:2], crack[2])
        if free is not None:
            inner = free.T @ (free.T @ A[:n, :n].T).T
            load, row, right, n = free.T @ load, free.T @ row, free.T @ right, free.shape[1]
            A = np.empty((n + 1, n + 1), order="F")
            A[:n, :n] = inner
        unit = abs(self.matrix[range(n), range(n)]).max()  # rows of one magnitude, for the pivoting
        A[:n, n], A[n, :n], A[n, n] = -load, unit * row, unit * corner
        lu, pivots, info = scipy.linalg.lapack.dgetrf(A, overwrite_a=True)
        if info:
            raise NotConverged("the tangent stiffness is singular")
        result = np.asarray(scipy.linalg.lapack.dgetrs(lu, pivots, np.append(right, unit * last))[0])
        return result if free is None else np.append(free @ result[:-1], result[-1])


@dataclass(frozen=True)
class SparseStiffness:
    """The stiffness of all unknowns, factored together with the crack in every iteration."""

    matrix: sp.csc_array

    def apply(self, v: Array) -> Array:
        return np.asarray(self.matrix @ v)

    @cached_property
    def scale(self) -> float:
        return float(abs(self.matrix).sum(axis=1).max())

    def solve(
        self, crack: Entries, load: Array, row: Array, corner: float, right: Array, last: float, free: Free = None
    ) -> Array:
        rows, columns, values = crack
        A = (self.matrix + sp.coo_array((values, (rows, columns)), shape=self.matrix.shape)).tocsc()
        if free is not None:
            A, load, row, right = (free.T @ A @ free).tocsc(), free.T @ load, free.T @ row, free.T @ right
        try:
            factor = spla.splu(A, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        except RuntimeError:
            raise NotConverged("the tangent stiffness is singular") from None
        both = factor.solve(np.stack([right, load], axis=1))
        change = (last - row @ both[:, 0]) / (row @ both[:, 1] + corner)
        step = both[:, 0] + change * both[:, 1]
        return np.append(step if free is None else free @ step, change)
