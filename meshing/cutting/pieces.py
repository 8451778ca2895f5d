"""Pieces of a mesh: elements that hang together by whole facets, edges in 2D and faces in 3D."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from ..arrays import Index
from ..cells import CELLS
from .stars import Blocks, distinct, numbered, owners


def pieces(blocks: Blocks) -> Index:
    """The piece of each element, (n,), blocks one after another; numbered from 0 in the order of their first elements.

    Elements that share single nodes only, in 3D an edge, are of different pieces: such a joint is a hinge.
    """
    facets = []
    for kind, block in blocks:
        cell = CELLS[kind]
        facets.append(block[:, np.array(cell.facets)[:, : cell.facet_corners]].reshape(-1, cell.facet_corners))
    number, cells = _numbered_together(facets), owners(blocks, [len(CELLS[kind].facets) for kind, _ in blocks])
    order = np.argsort(number, kind="stable")
    beside = np.flatnonzero(number[order][1:] == number[order][:-1])
    rows, columns = cells[order[beside]], cells[order[beside + 1]]
    count = sum(len(block) for _, block in blocks)
    graph = sp.coo_array((np.ones(len(rows)), (rows, columns)), shape=(count, count))
    label = connected_components(graph, directed=False)[1]
    _, first, label = np.unique(label, return_index=True, return_inverse=True)
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return np.asarray(rank[label])


def _numbered_together(facets: Sequence[Index]) -> Index:
    """Running numbers of facets, all with as many corners; collapsed ones, as of a prism that is a hexahedron with equal
    nodes, get numbers of their own."""
    corners = np.concatenate(facets)
    number = numbered(corners, directed=False)
    collapsed = np.flatnonzero(distinct(corners) < min(corners.shape[1], 3))
    number[collapsed] = number.max(initial=0) + 1 + np.arange(len(collapsed))
    return number
