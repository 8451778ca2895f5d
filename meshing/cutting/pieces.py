"""Pieces of a mesh: elements that hang together by whole facets, edges in 2D and faces in 3D."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from ..arrays import Index
from ..cells import CELLS
from .stars import Blocks, numbered


def pieces(blocks: Blocks) -> Index:
    """The piece of each element, (n,), blocks one after another; numbered from 0 in the order of their first elements.

    Elements that share single nodes only, in 3D an edge, are of different pieces: such a joint is a hinge.
    """
    facets, owner, offset = [], [], 0
    for kind, block in blocks:
        cell = CELLS[kind]
        corners = block[:, np.array(cell.facets)[:, : cell.facet_corners]].reshape(-1, cell.facet_corners)
        facets.append(corners)
        owner.append(np.repeat(np.arange(offset, offset + len(block)), len(cell.facets)))
        offset += len(block)
    number, cells = _numbered_together(facets), np.concatenate(owner)
    order = np.argsort(number, kind="stable")
    beside = np.flatnonzero(number[order][1:] == number[order][:-1])
    rows, columns = cells[order[beside]], cells[order[beside + 1]]
    graph = sp.coo_array((np.ones(len(rows)), (rows, columns)), shape=(offset, offset))
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
    ring = np.sort(corners, axis=1)
    distinct = 1 + (ring[:, 1:] != ring[:, :-1]).sum(axis=1)
    collapsed = np.flatnonzero(distinct < (2 if corners.shape[1] == 2 else 3))
    number[collapsed] = number.max(initial=0) + 1 + np.arange(len(collapsed))
    return number
