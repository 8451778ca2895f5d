"""The rows of a bordered system, shared out to the ranks of an MPI run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import scipy.sparse as sp

from ...arrays import Array, Index
from ..bordered import Free


@dataclass(frozen=True, eq=False)
class Layout:
    """Where the entries of bulk and cracks are in the matrix of one system, whose rows go to the ranks in order.

    Attributes
    ----------
    rows, columns, free : of the cracks' entries, and the motions that are allowed: what the layout was made for
    start : (m + 1,) array, where the entries of each row of the matrix begin
    column : (e,) array, their columns
    bulk : (e,) array, their values without cracks
    changing : (c,) array, indices of the entries at which there are cracks
    add : (c, k) matrix that sums up the values of the cracks' entries
    """

    rows: Index
    columns: Index
    free: Free
    start: Index
    column: Index
    bulk: Array
    changing: Index
    add: sp.csr_array

    #: the one whose matrix the ranks hold
    latest: ClassVar[Layout | None] = None

    @classmethod
    def from_entries(cls, matrix: sp.csc_array, rows: Index, columns: Index, free: Free) -> Layout:
        """From the stiffness of the bulk and the positions of the cracks' entries."""
        K, n = matrix.tocoo(), matrix.shape[0]
        if free is None:
            number, weight, m = np.arange(n), np.ones(n), n
        else:  # every unknown follows one of those that are left, or is held
            moves, m = np.diff(free.indptr) > 0, free.shape[1]
            number, weight = np.zeros(n, dtype=np.int64), np.zeros(n)
            number[moves], weight[moves] = free.indices, free.data

        in_bulk, in_cracks = number[K.row] * m + number[K.col], number[rows] * m + number[columns]
        diagonal = np.arange(m) * (m + 1)  # which some solvers want to be there
        positions = np.unique(np.concatenate([in_bulk, in_cracks, diagonal]))
        bulk: Array = np.bincount(
            np.searchsorted(positions, in_bulk), weight[K.row] * weight[K.col] * K.data, len(positions)
        ).astype(float)
        changing, which = np.unique(np.searchsorted(positions, in_cracks), return_inverse=True)
        add = sp.csr_array((weight[rows] * weight[columns], (which, np.arange(len(rows)))), shape=(len(changing), len(rows)))
        start = np.searchsorted(positions, np.arange(m + 1) * m)
        return cls(rows, columns, free, start, positions % m, bulk, changing, add)

    def fits(self, rows: Index, columns: Index, free: Free) -> bool:
        """Whether it is the layout of a system with these entries."""
        if self.free is None or free is None:
            alike = self.free is free
        else:
            parts = ((self.free.indptr, free.indptr), (self.free.indices, free.indices), (self.free.data, free.data))
            alike = all(np.array_equal(own, other) for own, other in parts)
        return alike and np.array_equal(self.rows, rows) and np.array_equal(self.columns, columns)

    def _bounds(self, ranks: int) -> tuple[Index, Index]:
        """First row of each rank and the end, likewise first of `changing`."""
        row = np.linspace(0, len(self.start) - 1, ranks + 1).astype(np.int64)
        return row, np.searchsorted(self.changing, self.start[row])

    def shares(self, ranks: int) -> list[tuple[Any, ...]]:
        """The rows of each rank."""
        row, change = self._bounds(ranks)
        shares = []
        for p in range(ranks):
            here = slice(self.start[row[p]], self.start[row[p + 1]])
            changing = self.changing[change[p] : change[p + 1]] - here.start
            start = self.start[row[p] : row[p + 1] + 1] - here.start
            shares.append((len(self.start) - 1, start, self.column[here], self.bulk[here], changing))
        return shares

    def split(self, values: Array, right: Array, load: Array, ranks: int) -> list[tuple[Any, ...]]:
        """What is new in a system, for each rank: values of the changing entries, and two right-hand sides."""
        row, change = self._bounds(ranks)
        added = self.add @ values
        return [
            (added[change[p] : change[p + 1]], right[row[p] : row[p + 1]], load[row[p] : row[p + 1]]) for p in range(ranks)
        ]
