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
    cells : arrays (n, nodes per element), one for each block.
    last : nodes that come after all others. Where they cut the mesh in two, these are the first two halves.

    Returns
    -------
    group : (m,) array, numbers of the groups in the order of elimination: a group follows all that it separates. That of
        `last` is the largest.
    """
    m = len(points)
    centres = np.concatenate([points[block].mean(axis=1) for block in cells])
    node = np.concatenate([block.ravel() for block in cells])
    element = np.repeat(np.arange(len(centres)), np.concatenate([np.full(len(b), b.shape[1]) for b in cells]))
    by_node = np.argsort(node, kind="stable")
    by_node = by_node[~np.isin(node[by_node], last)]
    node, element = node[by_node], element[by_node]

    levels = max(1, int(np.ceil(np.log2(points.size / _LEAF))))
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
        start = np.minimum(np.concatenate([[0], np.cumsum(count)[:-1]]), len(part) - 1)  # of an empty part any
        of = part[grouped]
        upper = np.arange(len(part)) - start[of] >= count[of] // 2
        first = np.flatnonzero(np.r_[True, node[1:] != node[:-1]])
        best, fewest = grouped, np.full(1 << level, m + 1)
        for axis in range(points.shape[1]):
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
        grouped = best
        part[grouped] = 2 * of + upper
        lowest, shared = _halves(part[element], first)
        separator = node[first][shared]
        depth[separator] = levels - level
        end[separator] = ((lowest[shared] >> 1) + 1) << (levels - level)
        keep = np.repeat(~shared, np.diff(np.r_[first, len(node)]))
        node, element = node[keep], element[keep]
    end[node] = part[element] + 1
    group: Index = np.unique(end * (levels + 2) + depth, return_inverse=True)[1].astype(np.int64)
    return group


def _halves(part: Index, first: Index) -> tuple[Index, Mask]:
    """Of the parts around each node the lowest, and whether there is another one."""
    lowest = np.minimum.reduceat(part, first)
    return lowest, lowest != np.maximum.reduceat(part, first)
