"""Exact elimination of the elastic bulk: one sparse factorization gives the stiffness of the active unknowns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: parts of about this many elements are not dissected further
_LEAF = 8


def nested_dissection(points: Array, cells: Sequence[Index], last: Index) -> Index:
    """Elimination order of the nodes of a mesh, from the coordinates alone.

    Every part of the mesh is halved at the median of its element centres along its longest side; the nodes
    that both halves share separate them and come after both. All parts of a level are halved at once.

    Parameters
    ----------
    points : (m, d) array
    cells : arrays (n, nodes per element), one for each block.
    last : nodes that come after all others. Where they cut the mesh in two, these are the first two halves.

    Returns
    -------
    order : (m,) array, the nodes in the order of elimination.
    """
    m = len(points)
    centres = np.concatenate([points[block].mean(axis=1) for block in cells])
    node = np.concatenate([block.ravel() for block in cells])
    element = np.repeat(np.arange(len(centres)), np.concatenate([np.full(len(b), b.shape[1]) for b in cells]))
    by_node = np.argsort(node, kind="stable")
    by_node = by_node[~np.isin(node[by_node], last)]
    node, element = node[by_node], element[by_node]

    levels = max(1, int(np.ceil(np.log2(len(centres) / _LEAF))))
    depth = np.zeros(m, dtype=np.int64)  # of the part that a separator divides, the whole being `levels`
    end = np.zeros(m, dtype=np.int64)  # where that part ends, counted in leaves
    depth[last], end[last] = levels + 1, 1 << levels
    links = sp.coo_array((np.ones(len(node)), (element, len(centres) + node)), shape=(len(centres) + m,) * 2)
    part = connected_components(links, directed=False)[1][: len(centres)].astype(np.int64)
    top = 1 if part.max() == 1 else 0
    if not top:
        part[:] = 0
    grouped = np.argsort(part, kind="stable")  # the elements, part by part
    for level in range(top, levels):
        count = np.bincount(part, minlength=1 << level)
        start = np.concatenate([[0], np.cumsum(count)[:-1]])
        at, of = centres[grouped], part[grouped]
        low = np.minimum.reduceat(at, start, axis=0)
        extent = np.maximum.reduceat(at, start, axis=0) - low
        axis = extent.argmax(axis=1)
        place = np.arange(len(part))
        along = (at[place, axis[of]] - low[of, axis[of]]) / (1.001 * extent[of, axis[of]] + 1e-300)  # below 1
        grouped = grouped[np.argsort(of + along)]
        part[grouped] = 2 * of + (place - start[of] >= count[of] // 2)

        first = np.flatnonzero(np.r_[True, node[1:] != node[:-1]])
        lowest = np.minimum.reduceat(part[element], first)
        shared = lowest != np.maximum.reduceat(part[element], first)
        separator = node[first][shared]
        depth[separator] = levels - level
        end[separator] = ((lowest[shared] >> 1) + 1) << (levels - level)
        keep = np.repeat(~shared, np.diff(np.r_[first, len(node)]))
        node, element = node[keep], element[keep]
    end[node] = part[element] + 1
    return np.lexsort((depth, end))


@dataclass(frozen=True)
class Condensed:
    """The elastic bulk seen from the active unknowns.

    Attributes
    ----------
    stiffness : (n, n) array, N/mm, the Schur complement of the passive unknowns.
    active : (n,) array, numbers of the active unknowns among all.
    """

    stiffness: Array
    active: Index
    _factor: spla.SuperLU
    _order: Index
    _shift: float

    @classmethod
    def eliminate(cls, K: sp.csc_array, active: Index, node: Index, node_order: Index) -> Condensed:
        """Eliminate all unknowns but `active`.

        Parameters
        ----------
        K : (N, N) sparse symmetric matrix, N/mm, positive definite on the passive unknowns.
        active : (n,) array
        node : (N,) array, the node of each unknown.
        node_order : (m,) array, the nodes in the order of elimination, see `nested_dissection`.

        Raises
        ------
        ValueError
            If the passive part is singular: the body is not supported.
        """
        n = len(active)
        rank = np.empty(len(node_order), dtype=np.int64)
        rank[node_order] = np.arange(len(rank))
        key = rank[node]
        key[active] = len(rank)
        order = np.argsort(key, kind="stable")
        order[len(order) - n :] = active
        A = K[order][:, order].tocsc()
        # The active block is shifted so that the factorization never pivots there, whatever its own rank.
        shift = float(A.diagonal().max())
        last = np.arange(len(order) - n, len(order))
        A = (A + sp.csc_array((np.full(n, shift), (last, last)), shape=A.shape)).tocsc()
        not_held = "the body is not held: its stiffness is singular. Expected supports against every motion"
        try:
            factor = spla.splu(A, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True, "Equil": False})
        except RuntimeError:
            raise ValueError(not_held) from None
        # rounding hides a zero pivot; then a known motion is not found from its forces
        motion = np.random.default_rng(0).normal(size=len(order))
        if not np.linalg.norm(factor.solve(A @ motion) - motion) < 1e-3 * np.linalg.norm(motion):
            raise ValueError(not_held)
        # SuperLU postorders the columns; the active ones stay last, in an order of their own
        place = factor.perm_c[last] - last[0] if n else last
        if (place < 0).any() or not np.array_equal(factor.perm_c, factor.perm_r):
            raise RuntimeError("the factorization moved the active unknowns")
        tail_L = factor.L[last[0] :, last[0] :].toarray() if n else np.zeros((0, 0))
        tail_U = factor.U[last[0] :, last[0] :].toarray() if n else np.zeros((0, 0))
        S = (tail_L @ tail_U)[np.ix_(place, place)]
        S[range(n), range(n)] -= shift
        return cls(0.5 * (S + S.T), active, factor, order, shift)

    def recover(self, v: Array) -> Array:
        """All unknowns (N,) from the active ones (n,), no force acting on the passive ones."""
        load = np.zeros(len(self._order))
        # with this load on the shifted active block, its solution is v itself
        load[len(load) - len(v) :] = self.stiffness @ v + self._shift * v
        result = np.empty_like(load)
        result[self._order] = self._factor.solve(load)
        return result
