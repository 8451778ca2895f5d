"""Node stars: which elements meet in a node, and which of them a cut leaves together. The same in the plane and in space.

A facet is what two elements share: an edge in the plane, a face in space.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import meshio
import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Blocks = list[tuple[str, Index]]

#: local edges (first corner, second corner[, mid-side]) of the plane cells, the cell to the left; meshio's node order
EDGES: dict[str, list[tuple[int, ...]]] = {
    "triangle": [(0, 1), (1, 2), (2, 0)],
    "triangle6": [(0, 1, 3), (1, 2, 4), (2, 0, 5)],
    "quad": [(0, 1), (1, 2), (2, 3), (3, 0)],
    "quad8": [(0, 1, 4), (1, 2, 5), (2, 3, 6), (3, 0, 7)],
}
#: local faces (corners[, mids of their edges]) of the solid cells, turned so that their normal points into the cell
FACES: dict[str, list[tuple[int, ...]]] = {
    "tetra": [(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)],
    "tetra10": [(0, 1, 2, 4, 5, 6), (0, 3, 1, 7, 8, 4), (0, 2, 3, 6, 9, 7), (1, 3, 2, 8, 9, 5)],
    "hexahedron": [(0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)],
}
FACETS = EDGES | FACES

#: (corners, nodes) of a facet: crack cell, and where its nodes stand in the minus facet followed by the plus facet. Where
#: sides across the crack have no mid node of their own, a corner of the minus side (of quad8: of either) stands in.
CRACK_CELLS: dict[tuple[int, int], tuple[str, list[int]]] = {
    (2, 2): ("quad", [0, 1, 3, 2]),
    (2, 3): ("quad8", [0, 1, 4, 3, 2, 1, 5, 3]),
    (3, 3): ("wedge", [0, 1, 2, 3, 4, 5]),
    (3, 6): ("wedge15", [0, 1, 2, 6, 7, 8, 3, 4, 5, 9, 10, 11, 0, 1, 2]),
    (4, 4): ("hexahedron", [0, 1, 2, 3, 4, 5, 6, 7]),
}
# meshio 5.3 reads and writes this cell type, but its table of dimensions, without which there is no such block, leaves it out
meshio._mesh.topological_dimension.setdefault("wedge15", 3)


def n_corners(kind: str) -> int:
    """Corners of a facet of a cell type; of a crack cell, of either side of it."""
    return 2 if kind in EDGES else 4 if kind == "hexahedron" else 3


def numbered(corners: Index, directed: bool) -> Index:
    """Running numbers of facets (n, k): the same for the same nodes, if `directed` in the same direction or sense of turn."""
    size = int(corners.max(initial=0)) + 1
    if corners.shape[1] == 2:
        first, second = corners.T if directed else np.sort(corners, axis=1).T
    else:  # a node and its two neighbours tell the facet
        k, at = corners.shape[1], corners.argmin(axis=1)
        row = np.arange(len(corners))
        beside = np.stack([corners[row, (at + 1) % k], corners[row, at - 1]], axis=1)
        if not directed:
            beside.sort(axis=1)
        first = corners[row, at]
        _, second = np.unique(beside[:, 0] * size + beside[:, 1], return_inverse=True)
        size = max(size, len(beside))
    _, number = np.unique(first * size + second, return_inverse=True)
    return np.asarray(number)


@dataclass(frozen=True)
class Star:
    """Element-facet incidences: one row for each facet of each bulk cell."""

    cell: Index  # running number over all blocks
    facet: Index  # number of the facet, the same from both sides
    nodes: Index  # corners in the order of FACETS, then mid-side nodes
    corners: int

    @classmethod
    def from_cells(cls, cells: Sequence[tuple[str, Index]]) -> Star:
        """Of blocks whose facets have the same number of nodes."""
        owner, nodes, offset = [], [], 0
        for kind, block in cells:
            facets = np.array(FACETS[kind])
            nodes.append(block[:, facets].reshape(-1, facets.shape[1]))
            owner.append(np.repeat(np.arange(offset, offset + len(block)), len(facets)))
            offset += len(block)
        rows, k = np.concatenate(nodes), n_corners(cells[0][0])
        return cls(np.concatenate(owner), numbered(rows[:, :k], directed=False), rows, k)

    def find(self, directed: Index) -> Index:
        """Rows of facets, corners (n, k) in that direction or sense of turn, -1 where there is none."""
        number = numbered(np.concatenate([self.nodes[:, : self.corners], directed]), directed=True)
        row = np.full(int(number.max(initial=0)) + 1, -1)
        row[number[: len(self.nodes)]] = np.arange(len(self.nodes))
        return np.asarray(row[number[len(self.nodes) :]])

    def columns(self, rows: Index, corners: Index) -> Index:
        """Where in some rows the nodes of the same facets stand if they begin with `corners` (n, k), in that order."""
        k = self.corners
        at = (self.nodes[rows, None, :k] == corners[:, :, None]).argmax(axis=2)
        following = np.roll(at, -1, axis=1)
        n_mids = self.nodes.shape[1] - k
        if not n_mids:
            return np.asarray(at)
        # the mid of the edge between two corners follows the number of the first, seen in the sense of the row
        mids = np.where(following == (at + 1) % k, at, following)[:, :n_mids] % n_mids
        return np.concatenate([at, k + mids], axis=1)

    def split(self, cells: Sequence[tuple[str, Index]], cut: Index, n_points: int) -> tuple[Blocks, Index]:
        """Cells with a copy of a node for every further group of elements around it that the facets numbered `cut`
        separate, and for each node of the new mesh the node it copies."""
        is_cut = np.isin(self.facet, cut)
        touched = np.zeros(n_points, dtype=bool)
        touched[self.nodes[is_cut].ravel()] = True

        # corners = incidences (cell, node) at touched nodes; two are joined across an uncut facet at that node
        place, owner, offset = [], [], 0
        for _, block in cells:
            place.append(block.ravel())
            owner.append(np.repeat(np.arange(offset, offset + len(block)), block.shape[1]))
            offset += len(block)
        node_of, cell_of = np.concatenate(place), np.concatenate(owner)
        corner = np.flatnonzero(touched[node_of])
        key = cell_of[corner] * n_points + node_of[corner]
        order = np.argsort(key)

        def corner_index(cell: Index, node: Index) -> Index:
            return order[np.searchsorted(key[order], cell * n_points + node)]

        joined: list[tuple[Index, Index]] = []
        inner = np.flatnonzero(~is_cut & touched[self.nodes].any(axis=1))
        inner = inner[np.argsort(self.facet[inner], kind="stable")]
        twin = np.flatnonzero(self.facet[inner][1:] == self.facet[inner][:-1])
        first, second = inner[twin], inner[twin + 1]
        for column in range(self.nodes.shape[1]):
            node = self.nodes[first, column]
            use = touched[node]
            joined.append((corner_index(self.cell[first][use], node[use]), corner_index(self.cell[second][use], node[use])))
        rows, columns = (np.concatenate(side) for side in zip(*joined, strict=True))
        graph = sp.coo_array((np.ones(len(rows)), (rows, columns)), shape=(len(corner), len(corner)))
        _, group = connected_components(graph, directed=False)

        # the first group of a node keeps its number
        pairs = np.unique(np.stack([node_of[corner], group], axis=1), axis=0)
        fresh = np.r_[False, pairs[1:, 0] == pairs[:-1, 0]]
        number = np.where(fresh, n_points + np.cumsum(fresh) - 1, pairs[:, 0])
        of_group = np.empty(group.max() + 1, dtype=np.int64)
        of_group[pairs[:, 1]] = number
        renumbered = node_of.copy()
        renumbered[corner] = of_group[group]
        ends = np.cumsum([block.size for _, block in cells])[:-1]
        parts = np.split(renumbered, ends)
        new = [(kind, part.reshape(block.shape)) for (kind, block), part in zip(cells, parts, strict=True)]
        return new, np.concatenate([np.arange(n_points), pairs[fresh, 0]])
