"""Order of elimination of a mesh's nodes, by nested dissection."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from ..arrays import Array, Index, Mask

#: parts with about this many unknowns are not dissected further: below it dense algebra costs more calls than work
_LEAF = 150


def nested_dissection(points: Array, cells: Sequence[Index], last: Index) -> tuple[Index, Index]:
    """Groups of nodes that are eliminated together, from the coordinates alone.

    Every part of the mesh is halved at the median of its element centres along an axis, the one for which the fewest nodes
    are shared by both halves; these separate them and come after both. All parts of a level are halved at once. What
    separates two parts is a group, and so is a part that is not halved any more.

    Parameters
    ----------
    points : (m, d) array
    cells : arrays (n, nodes per element), one for each block of elements.
    last : nodes that come after all others. If they cut the mesh in two, these are the first two halves.

    Returns
    -------
    group : (m,) array, indices of the groups in the order of elimination: a group follows all that it separates. That of
        `last` is the largest.
    beside : (m,) array, the first of the smallest parts around each node. Nodes of a group in this order touch what was
        eliminated before in long runs.
    """
    m = len(points)
    centres = np.concatenate([points[block].mean(axis=1) for block in cells])
    touching = incidence(cells, m).tocsc()
    every, around = np.repeat(np.arange(m), np.diff(touching.indptr)), touching.indices.astype(np.int64)
    keep = np.isin(every, last, invert=True)
    node, element = every[keep], around[keep]
    levels = max(1, int(np.ceil(np.log2(points.size / _LEAF))))
    depth = np.zeros(m, dtype=np.int64)  # of the part that a separator divides, the whole being `levels`
    end = np.zeros(m, dtype=np.int64)  # where that part ends, counted in leaves
    depth[last], end[last] = levels + 1, 1 << levels
    part, top = _first_parts(node, element, len(centres), m)
    orders = [along.argsort() for along in centres.T]
    for level in range(top, levels):
        first = _first(node)
        orders = [_by_part(order, part, levels) for order in orders]
        _halve(level, orders, part, element, first)
        lowest, shared = _halves(part[element], first)
        separator = node[first][shared]
        depth[separator] = levels - level
        end[separator] = ((lowest[shared] >> 1) + 1) << (levels - level)
        keep = np.repeat(~shared, np.diff(np.r_[first, len(node)]))
        node, element = node[keep], element[keep]
    end[node] = part[element] + 1
    group: Index = np.unique(end * (levels + 2) + depth, return_inverse=True)[1].astype(np.int64)
    beside, first = np.zeros(m, dtype=np.int64), _first(every)
    beside[every[first]] = _halves(part[around], first)[0]
    return group, beside


def incidence(cells: Sequence[Index], m: int) -> sp.csr_array:
    """Which of the m nodes each element has, (elements, m), bool."""
    corners = np.concatenate([np.full(len(block), block.shape[1]) for block in cells])
    nodes = np.concatenate([block.ravel() for block in cells])
    start = np.append(0, np.cumsum(corners))
    return sp.csr_array((np.ones(len(nodes), dtype=bool), nodes, start), shape=(len(corners), m))


def _first(node: Index) -> Index:
    """Where the pairs of each node begin."""
    return np.flatnonzero(np.append(True, node[1:] != node[:-1]))


def _first_parts(node: Index, element: Index, n: int, m: int) -> tuple[Index, int]:
    """Part of each of the n elements, and the level at which these are the parts: 1 if the mesh is in two already."""
    links = sp.coo_array((np.ones(len(node)), (element, n + node)), shape=(n + m,) * 2)
    part = connected_components(links, directed=False)[1][:n].astype(np.int64)
    if part.max() == 1:
        return part, 1
    part[:] = 0
    return part, 0


def _by_part(order: Index, part: Index, levels: int) -> Index:
    """The elements part by part, those of a part in the order that they had."""
    short = part[order].astype(np.min_scalar_type(1 << levels))  # of up to 16 bits, which are sorted without comparing
    return np.asarray(order[short.argsort(kind="stable")])


def _halve(level: int, orders: list[Index], part: Index, element: Index, first: Index) -> None:
    """Halve all parts of a level, each along its best axis.

    Parameters
    ----------
    orders : for each axis the e elements part by part, those of a part in their order along the axis
    part : (e,) array, of each element; those of the next level are written into it
    element : elements around the nodes that separate nothing yet, node by node
    first : where those of each node begin
    """
    count = np.bincount(part, minlength=1 << level)
    of = np.repeat(np.arange(1 << level), count)
    place = np.arange(len(part)) - (np.cumsum(count) - count)[of]
    halved = 2 * of + (place >= count[of] // 2)
    best, fewest = orders[0], np.full(1 << level, len(element) + 1)
    for order in orders:
        part[order] = halved
        lowest, shared = _halves(part[element], first)
        counts = np.bincount(lowest[shared] >> 1, minlength=1 << level)
        best = np.where((counts < fewest)[of], order, best)
        fewest = np.minimum(counts, fewest)
    part[best] = halved


def _halves(part: Index, first: Index) -> tuple[Index, Mask]:
    """The lowest of the parts around each node, and whether there is another one."""
    lowest = np.minimum.reduceat(part, first)
    return lowest, lowest != np.maximum.reduceat(part, first)
