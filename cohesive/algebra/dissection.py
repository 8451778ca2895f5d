"""Order of elimination of a mesh's nodes, by nested dissection."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from ..arrays import Array, Index, Mask

#: parts with about this many unknowns are not dissected further: below it dense algebra costs more calls than work
_LEAF = 200


def nested_dissection(points: Array, cells: Sequence[Index], last: Index) -> Index:
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
    """
    m = len(points)
    centres = np.concatenate([points[block].mean(axis=1) for block in cells])
    node, element = _incidence(cells, last)
    levels = max(1, int(np.ceil(np.log2(points.size / _LEAF))))
    depth = np.zeros(m, dtype=np.int64)  # of the part that a separator divides, the whole being `levels`
    end = np.zeros(m, dtype=np.int64)  # where that part ends, counted in leaves
    depth[last], end[last] = levels + 1, 1 << levels
    part, top = _first_parts(node, element, len(centres), m)
    grouped = np.argsort(part, kind="stable")  # the elements, part by part
    for level in range(top, levels):
        first = np.flatnonzero(np.r_[True, node[1:] != node[:-1]])
        grouped = _halved(level, centres, grouped, part, element, first)
        lowest, shared = _halves(part[element], first)
        separator = node[first][shared]
        depth[separator] = levels - level
        end[separator] = ((lowest[shared] >> 1) + 1) << (levels - level)
        keep = np.repeat(~shared, np.diff(np.r_[first, len(node)]))
        node, element = node[keep], element[keep]
    end[node] = part[element] + 1
    group: Index = np.unique(end * (levels + 2) + depth, return_inverse=True)[1].astype(np.int64)
    return group


def _incidence(cells: Sequence[Index], last: Index) -> tuple[Index, Index]:
    """Pairs of a node and an element around it, node by node, without the nodes `last`."""
    node = np.concatenate([block.ravel() for block in cells])
    sizes = np.concatenate([np.full(len(block), block.shape[1]) for block in cells])
    element = np.repeat(np.arange(len(sizes)), sizes)
    by_node = np.argsort(node, kind="stable")
    by_node = by_node[~np.isin(node[by_node], last)]
    return node[by_node], element[by_node]


def _first_parts(node: Index, element: Index, n: int, m: int) -> tuple[Index, int]:
    """Part of each of the n elements, and the level at which these are the parts: 1 if the mesh is in two already."""
    links = sp.coo_array((np.ones(len(node)), (element, n + node)), shape=(n + m,) * 2)
    part = connected_components(links, directed=False)[1][:n].astype(np.int64)
    if part.max() == 1:
        return part, 1
    part[:] = 0
    return part, 0


def _halved(level: int, centres: Array, grouped: Index, part: Index, element: Index, first: Index) -> Index:
    """Halve all parts of a level, each along its best axis.

    Parameters
    ----------
    grouped : (e,) array, the elements, part by part
    part : (e,) array, of each element; those of the next level are written into it
    element : elements around the nodes that separate nothing yet, node by node
    first : where those of each node begin

    Returns
    -------
    grouped : as before, in the order along the axis within each part
    """
    count = np.bincount(part, minlength=1 << level)
    start = np.minimum(np.concatenate([[0], np.cumsum(count)[:-1]]), len(part) - 1)  # of an empty part any
    of = part[grouped]
    upper = np.arange(len(part)) - start[of] >= count[of] // 2
    best, fewest = grouped, np.full(1 << level, len(element) + 1)
    for axis in range(centres.shape[1]):
        at = centres[grouped, axis]
        low = np.minimum.reduceat(at, start)
        extent = np.maximum.reduceat(at, start) - low
        along = (at - low[of]) / (1.001 * extent[of] + 1e-300)  # below 1
        ordered = grouped[np.argsort(of + along)]
        part[ordered] = 2 * of + upper
        lowest, shared = _halves(part[element], first)
        found = np.bincount(lowest[shared] >> 1, minlength=1 << level)
        best = np.where((found < fewest)[of], ordered, best)
        fewest = np.minimum(found, fewest)
    part[best] = 2 * of + upper
    return best


def _halves(part: Index, first: Index) -> tuple[Index, Mask]:
    """The lowest of the parts around each node, and whether there is another one."""
    lowest = np.minimum.reduceat(part, first)
    return lowest, lowest != np.maximum.reduceat(part, first)
