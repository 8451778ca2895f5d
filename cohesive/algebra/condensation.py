"""Static condensation of the elastic bulk, group by group along an elimination tree of dense frontal matrices."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
import scipy.sparse as sp
from scipy.linalg import blas, lapack

from ..arrays import Array, Index
from .threads import threads_for

#: a pivot below this part of the stiffness that it began with is rounding: the body can move without a force
_SMALLEST_PIVOT = 1e-11

#: rows or columns that are worked on at once
BLOCK = 64

#: frontal matrices with fewer numbers are assembled as one
SMALL = 40_000

#: numbers of a rectangle that are added as fast by slices as one by one, in chunks that stay in the cache
LONG, CHUNK = 2_500, 16_384

NOT_HELD = "the body is not held: its stiffness is singular. Expected supports against every motion"


@dataclass(frozen=True)
class EliminationTree:
    """What is eliminated with what, found from the pattern of a matrix alone.

    The unknowns are eliminated group by group. A group and the later unknowns to which it is coupled, directly or through
    groups before it, form its frontal matrix, which is small and dense.

    Attributes
    ----------
    start : (g + 1,) array, first unknown of each group, and of the ones left, in the order of elimination
    borders : for each group the later unknowns of its frontal matrix, ascending
    parents : for each group the one that takes up its Schur complement: that of its first later unknown; -1: the ones left
    """

    start: Index
    borders: list[Index]
    parents: list[int]

    @classmethod
    def from_pattern(cls, A: sp.csc_array, start: Index) -> EliminationTree:
        """From a symmetric matrix in the order of elimination, of which the lower triangle counts."""
        group = np.repeat(np.arange(len(start) - 1), np.diff(start))
        borders: list[Index] = []
        parents: list[int] = []
        below: list[list[Index]] = [[] for _ in start[1:]]
        for g, (a, b) in enumerate(zip(start[:-1].tolist(), start[1:].tolist(), strict=True)):
            rows = A.indices[A.indptr[a] : A.indptr[b]]
            border = np.unique(np.concatenate([rows[rows >= b], *(rest[np.searchsorted(rest, b) :] for rest in below[g])]))
            below[g] = []
            parent = int(group[border[0]]) if len(border) and border[0] < start[-1] else -1
            if parent >= 0:
                below[parent].append(border)
            borders.append(border)
            parents.append(parent)
        return cls(start, borders, parents)

    @cached_property
    def places(self) -> Places:
        """Where the Schur complements lie."""
        return Places.from_tree(self)

    def cost(self, sizes: Index | None = None) -> tuple[float, float]:
        """Floating-point operations of the elimination, and how many numbers the factor has.

        Parameters
        ----------
        sizes : unknowns of each row of a matrix whose rows are nodes.
        """
        before = self.start if sizes is None else np.append(0, np.cumsum(sizes))[self.start]
        k = np.diff(before).astype(float)
        m = np.array([len(border) if sizes is None else sizes[border].sum() for border in self.borders], dtype=float)
        return float((k**3 / 3 + k**2 * m + k * m**2).sum()), float((k**2 + k * m).sum())


@dataclass(frozen=True)
class _Eliminated:
    """Rows of a triangular factor: pivots L and the rows below them."""

    pivots: Array
    below: Array

    @classmethod
    def from_front(cls, own: Array, below: Array, rest: Array) -> tuple[_Eliminated, Array]:
        """Eliminate the first unknowns of a frontal matrix [[own, .], [below, rest]], of which the lower triangle counts; the
        three blocks are overwritten.

        Returns
        -------
        rows : _Eliminated
        complement : lower triangle of the Schur complement

        Raises
        ------
        ValueError
            If a pivot is not positive.
        """
        before = own.diagonal().copy()
        with threads_for(len(own) + len(below)):
            pivots, info = lapack.dpotrf(own, lower=1, clean=0, overwrite_a=1)
            if info or (pivots.diagonal() ** 2 < _SMALLEST_PIVOT * before).any():
                raise ValueError(NOT_HELD)
            if len(below):
                below = blas.dtrsm(1.0, pivots, below, side=1, lower=1, trans_a=1, overwrite_b=1)
                rest = blas.dsyrk(-1.0, below, beta=1.0, c=rest, lower=1, overwrite_c=1)
        return cls(pivots, below), rest

    def solve(self, later: Array) -> Array:
        """The eliminated unknowns from the later ones, (n,) or (n, k), if no force acts on them."""
        forces = -(later.T @ self.below)
        if not forces.size:
            return forces.T
        if forces.ndim == 1:
            return np.asarray(blas.dtrsv(self.pivots, forces, lower=1, trans=1))
        return np.asarray(blas.dtrsm(1.0, self.pivots, forces.T, lower=1, trans_a=1, overwrite_b=1))


@dataclass(frozen=True)
class Condensed:
    """The elastic bulk seen from the active unknowns.

    Attributes
    ----------
    stiffness : (n, n) array, N/mm, the Schur complement of the passive unknowns.
    """

    stiffness: Array
    _tree: EliminationTree
    _eliminated: list[_Eliminated]
    _last: _Eliminated
    _basis: sp.csr_array
    _passive: Index
    _active: Index

    @classmethod
    def eliminate(cls, K: sp.csc_array, tree: EliminationTree, basis: sp.csr_array, active: Index) -> Condensed:
        """Eliminate all groups, express the unknowns left by others, and eliminate all of these but `active`.

        Parameters
        ----------
        K : (N, N) sparse symmetric matrix in the order of elimination, lower triangle, N/mm; positive definite on what is
            eliminated.
        tree : of K
        basis : (s, t) matrix, the s unknowns left from t others.
        active : (n,) array, indices among these t.

        Raises
        ------
        ValueError
            If the passive part is singular: the body is not held.
        """
        unit = 2.0 ** np.frexp(K.diagonal().max(initial=0.0))[1]  # twice the stiffness gives twice the result, bit by bit
        eliminated, complements = _eliminate(K, tree, unit)
        passive, first = np.setdiff1d(np.arange(basis.shape[1]), active), tree.start[-1]
        ordered = basis.tocsc()[:, np.append(passive, active)]
        blocks = _expressed(K[first:, first:] / unit, complements, ordered, len(passive))
        del complements  # and their memory
        last, stiffness = _Eliminated.from_front(*blocks)
        stiffness *= unit
        return cls(_symmetric(stiffness), tree, eliminated, last, basis, passive, active)

    def recover(self, v: Array) -> Array:
        """All N unknowns in the order of elimination from the active ones, (n,) or (n, k), if no force acts on the others."""
        others = np.empty((self._basis.shape[1], *v.shape[1:]))
        others[self._active], others[self._passive] = v, self._last.solve(v)
        start = self._tree.start
        result = np.concatenate([np.empty((start[-1], *v.shape[1:])), self._basis @ others])
        for g in range(len(self._eliminated) - 1, -1, -1):
            result[start[g] : start[g + 1]] = self._eliminated[g].solve(result[self._tree.borders[g]])
        return result


#: unknowns of a Schur complement, and its lower triangle
_Update = tuple[Index, Array]


@dataclass(frozen=True)
class Places:
    """Where Schur complements lie in memory that is used again and again: to write to fresh memory takes ten times as long.

    They lie in two stacks: the complement of a group in one, those that the group takes up in the other. What no group takes
    up stays.

    Attributes
    ----------
    stack, start : for each group in which stack its complement lies, and from where on
    sizes : of the stacks, in numbers
    """

    stack: list[int]
    start: list[int]
    sizes: list[int]

    @classmethod
    def from_tree(cls, tree: EliminationTree) -> Places:
        parents, numbers = tree.parents, [len(border) ** 2 for border in tree.borders]
        stack = [0] * len(parents)
        for g in range(len(parents) - 1, -1, -1):
            stack[g] = 1 - stack[parents[g]] if parents[g] >= 0 else 0
        start: list[int] = []
        sizes = [0, 0]
        there: list[list[int]] = [[], []]  # groups, in the order of their places; most are taken up from the end
        for g, below in enumerate(there[which] for which in stack):
            while below and 0 <= parents[below[-1]] < g:
                below.pop()
            start.append(start[below[-1]] + numbers[below[-1]] if below else 0)
            below.append(g)
            sizes[stack[g]] = max(sizes[stack[g]], start[g] + numbers[g])
        return cls(stack, start, sizes)


def _eliminate(K: sp.csc_array, tree: EliminationTree, unit: float) -> tuple[list[_Eliminated], list[_Update]]:
    """Eliminate K / unit group by group; the rows of the factor, and what adds to the unknowns left, counted from 0."""
    places, first = tree.places, int(tree.start[-1])
    memory = [np.empty(size) for size in places.sizes]
    eliminated, left = [], []
    waiting: list[list[_Update]] = [[] for _ in tree.borders]
    for g, (border, parent) in enumerate(zip(tree.borders, tree.parents, strict=True)):
        n, begin = len(border), places.start[g]
        place = memory[places.stack[g]][begin : begin + n * n].reshape(n, n)
        frontal = _frontal(K, unit, int(tree.start[g]), int(tree.start[g + 1]), border, waiting[g], place)
        done, complement = _Eliminated.from_front(*frontal)
        eliminated.append(done)
        waiting[g] = []
        if parent >= 0:
            waiting[parent].append((border, complement))
        elif n:
            left.append((border - first, complement))
    return eliminated, left


def _frontal(
    K: sp.csc_array, unit: float, a: int, b: int, border: Index, updates: list[_Update], place: Array
) -> tuple[Array, Array, Array]:
    """The frontal matrix [[own, .], [below, rest]] of the group of the unknowns from a to b: entries of K / unit and the
    Schur complements of earlier groups; `rest` lies in `place`."""
    k, n = b - a, b - a + len(border)
    entries = slice(K.indptr[a], K.indptr[b])
    values = K.data[entries] / unit
    rows, columns = K.indices[entries], np.repeat(np.arange(k), np.diff(K.indptr[a : b + 1]))
    rows = np.where(rows < b, rows - a, k + np.searchsorted(border, rows))
    # all blocks are transposed: their upper triangles count
    if n * n < SMALL:
        front = np.zeros((n, n))
        front.reshape(-1)[columns * n + rows] = values
        for unknowns, lower in updates:
            cut = int(np.searchsorted(unknowns, b))
            at = np.concatenate([unknowns[:cut] - a, k + np.searchsorted(border, unknowns[cut:])])
            _add_numbers(front, at, at, lower.T)
        place[:] = front[k:, k:]
        return front[:k, :k].copy().T, front[:k, k:].copy().T, place.T
    own, below, place[:] = np.zeros((k, k)), np.zeros((k, n - k)), 0.0
    inner = rows < k
    own[columns[inner], rows[inner]] = values[inner]
    below[columns[~inner], rows[~inner] - k] = values[~inner]
    for unknowns, lower in updates:
        cut, part = int(np.searchsorted(unknowns, b)), lower.T
        first, later = unknowns[:cut] - a, np.searchsorted(border, unknowns[cut:])
        _add(own, first, first, part[:cut, :cut])
        _add(below, first, later, part[:cut, cut:])
        _add(place, later, later, part[cut:, cut:])
    return own.T, below.T, place.T


def _add(to: Array, rows: Index, columns: Index, part: Array) -> None:
    """Add to these rows and columns of a matrix by rows; if rows and columns are the same, the upper triangle counts."""
    triangle = columns is rows
    across, down = runs(columns), runs(rows)
    if part.size > LONG * len(across) * len(down):
        for a, b in down:
            for c, d in across:
                if not triangle or c >= a:
                    to[rows[a] : rows[a] + b - a, columns[c] : columns[c] + d - c] += part[a:b, c:d]
        return
    step = max(1, CHUNK // max(1, len(columns)))
    for a in range(0, len(rows), step):
        first = a if triangle else 0
        _add_numbers(to, rows[a : a + step], columns[first:], part[a : a + step, first:])


def _add_numbers(to: Array, rows: Index, columns: Index, part: Array) -> None:
    """The same number by number, as a list of numbers in one row, which takes half the time of rows and columns."""
    to.reshape(-1)[(rows[:, None] * to.shape[1] + columns).ravel()] += part.reshape(-1)


def runs(numbers: Index) -> list[tuple[int, int]]:
    """Where each run of ascending numbers without a gap begins and ends."""
    ends = [0, *(np.flatnonzero(np.diff(numbers) != 1) + 1).tolist(), len(numbers)]
    return list(pairwise(ends))


def _expressed(K: sp.csc_array, complements: list[_Update], basis: sp.csc_array, n: int) -> tuple[Array, Array, Array]:
    """The blocks [[own, .], [below, rest]], n first, of basis.T @ S @ basis, S being the sparse K and the complements, lower
    triangles all of them; the complements are overwritten."""
    m = basis.shape[1] - n
    own, below, rest = np.empty((n, n), order="F"), np.empty((m, n), order="F"), np.empty((m, m), order="F")
    sparse = (basis.T @ (K + sp.tril(K, -1).T) @ basis).tocsc()
    dense = [(basis[unknowns], _symmetric(lower)) for unknowns, lower in complements]
    for first in range(0, n + m, BLOCK):
        end = min(first + BLOCK, n + m)
        columns = sparse[:, first:end].toarray(order="F")
        for part, S in dense:
            half = np.ascontiguousarray((part[:, first:end].T @ S.T).T)  # S.T by rows, else the product would copy it
            columns += part.T @ half
        k = max(min(n, end) - first, 0)
        own[:, first : first + k], below[:, first : first + k] = columns[:n, :k], columns[n:, :k]
        rest[:, first + k - n : end - n] = columns[n:, k:]
    return own, below, rest


def _symmetric(lower: Array) -> Array:
    """A matrix from its lower triangle, in its place: there may be no memory for a copy."""
    for a in range(0, len(lower), BLOCK):
        b = a + BLOCK
        own = np.tril(lower[a:b, a:b])
        lower[a:b, a:b] = own + np.tril(own, -1).T
        lower[a:b, b:] = lower[b:, a:b].T
    return lower
