"""Node stars: which cells meet in a node, and which of them a cut leaves together. The same in 2D and 3D.

A facet is what two cells share: an edge in 2D, a face in 3D.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import meshio
import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from ..arrays import Array, Index, Mask
from ..cells import BULK_2D, BULK_3D, CELLS
from ..errors import MeshError

Blocks = list[tuple[str, Index]]


def bulk_cells(mesh: meshio.Mesh) -> Blocks:
    """The 3D cells of a mesh, or the 2D ones if it has none of them; MeshError if it has neither, or mixes cells whose facets
    differ: first and second order, tetrahedra and hexahedra."""
    solid = any(block.type in BULK_3D for block in mesh.cells)
    known = BULK_3D if solid else BULK_2D
    cells = [(block.type, block.data.astype(np.int64)) for block in mesh.cells if block.type in known]
    if not cells:
        raise MeshError(f"the mesh has no cells of type {', '.join(BULK_2D + BULK_3D)}")
    kinds = {kind: len(CELLS[kind].facets[0]) for kind, _ in cells}
    if len(set(kinds.values())) > 1:
        what = "solid cells that share no faces" if solid else "first and second order cells"
        raise MeshError(f"the mesh mixes {what}: {', '.join(kinds)}")
    return cells


def touching(cells: Sequence[tuple[str, Index]], nodes: Mask, least: int = 1) -> tuple[Blocks, list[Index]]:
    """The cells with at least `least` of some nodes, in their blocks, and which ones of each block they are."""
    chosen = []
    for _, block in cells:
        inside = nodes[block]
        chosen.append(np.flatnonzero(inside.any(axis=1) if least == 1 else inside.sum(axis=1) >= least))
    return [(kind, block[at]) for (kind, block), at in zip(cells, chosen, strict=True)], chosen


def numbered(corners: Index, directed: bool) -> Index:
    """Running numbers of facets, corners (n, k): the same for the same nodes, if `directed` in the same direction or sense."""
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
        size = len(beside)  # above every number in `second`
    _, number = np.unique(first * size + second, return_inverse=True)
    return np.asarray(number)


def owners(cells: Sequence[tuple[str, Index]], parts: Sequence[int]) -> Index:
    """The cell of each part, in blocks whose cells have `parts` of them each; cells numbered over all blocks."""
    count = [len(block) for _, block in cells]
    return np.repeat(np.arange(sum(count)), np.repeat(parts, count))


def distinct(rows: Index) -> Index:
    """How many different numbers each row has."""
    ordered = np.sort(rows, axis=1)
    return np.asarray(1 + (ordered[:, 1:] != ordered[:, :-1]).sum(axis=1))


def directed_areas(corners: Array) -> Array:
    """Normals of edges, to their left, or of faces, (b - a) x (c - a), times length or area, (n, d); corners (n, k, d)."""
    if corners.shape[2] == 2:
        along = corners[:, 1] - corners[:, 0]
        return np.stack([-along[:, 1], along[:, 0]], axis=1)
    if corners.shape[1] == 3:
        return np.asarray(0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    return np.asarray(0.5 * np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]))


@dataclass(frozen=True)
class Star:
    """Incidences of cells and facets: one row for each facet of each bulk cell."""

    cell: Index  # running number over all blocks
    facet: Index  # number of the facet, the same from both sides
    nodes: Index  # corners in the order of the cell type's facets, then mid nodes
    corners: int  # of a facet

    @classmethod
    def from_cells(cls, cells: Sequence[tuple[str, Index]]) -> Star:
        """The star of blocks whose facets have the same number of nodes."""
        facets = [np.array(CELLS[kind].facets) for kind, _ in cells]
        rows = np.concatenate([block[:, at].reshape(-1, at.shape[1]) for (_, block), at in zip(cells, facets, strict=True)])
        k = CELLS[cells[0][0]].facet_corners
        return cls(owners(cells, [len(at) for at in facets]), numbered(rows[:, :k], directed=False), rows, k)

    def find(self, directed: Index) -> Index:
        """Rows of facets, corners (n, k) in that direction or sense; -1 for one that there is not."""
        number = numbered(np.concatenate([self.nodes[:, : self.corners], directed]), directed=True)
        row = np.full(int(number.max(initial=0)) + 1, -1)
        row[number[: len(self.nodes)]] = np.arange(len(self.nodes))
        return np.asarray(row[number[len(self.nodes) :]])

    def outward(self, points: Array) -> Array:
        """Normals out of the cells times lengths or areas, one for each row, (n, d): an edge has its cell on its left, the
        normal of a face's ring points into its cell."""
        return -directed_areas(points[self.nodes[:, : self.corners]])

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

    def split(self, cells: Sequence[tuple[str, Index]], cut: Index, n_nodes: int) -> tuple[Blocks, Index]:
        """Cells that are separated along some facets.

        Around a node, the cells that still share a facet belong together; each further group of them gets a copy of the node.

        Parameters
        ----------
        cells : the blocks that this star was made of.
        cut : numbers of the facets.
        n_nodes : number of nodes of the mesh.

        Returns
        -------
        cells, original : the blocks with new node numbers, and for each node of the new mesh the node it copies.
        """
        is_cut = np.isin(self.facet, cut)
        touched = np.zeros(n_nodes, dtype=bool)
        touched[self.nodes[is_cut].ravel()] = True
        node_of = np.concatenate([block.ravel() for _, block in cells])
        cell_of = owners(cells, [block.shape[1] for _, block in cells])
        at = np.flatnonzero(touched[node_of])
        group = self._groups(is_cut, touched, cell_of[at] * n_nodes + node_of[at])

        # the first group of a node keeps its number
        pairs = np.unique(np.stack([node_of[at], group], axis=1), axis=0)
        fresh = np.r_[False, pairs[1:, 0] == pairs[:-1, 0]]
        number = np.where(fresh, n_nodes + np.cumsum(fresh) - 1, pairs[:, 0])
        of_group = np.empty(group.max() + 1, dtype=np.int64)
        of_group[pairs[:, 1]] = number
        renumbered = node_of.copy()
        renumbered[at] = of_group[group]
        ends = np.cumsum([block.size for _, block in cells])[:-1]
        parts = np.split(renumbered, ends)
        new = [(kind, part.reshape(block.shape)) for (kind, block), part in zip(cells, parts, strict=True)]
        return new, np.concatenate([np.arange(n_nodes), pairs[fresh, 0]])

    def _groups(self, is_cut: Mask, touched: Mask, key: Index) -> Index:
        """Groups of the incidences (cell, node) at touched nodes, by their keys: cell times the number of nodes plus node.

        Two are joined across an uncut facet at their node.
        """
        order = np.argsort(key)

        def incidence(cell: Index, node: Index) -> Index:
            return order[np.searchsorted(key[order], cell * len(touched) + node)]

        joined: list[tuple[Index, Index]] = []
        inner = np.flatnonzero(~is_cut & touched[self.nodes].any(axis=1))
        inner = inner[np.argsort(self.facet[inner], kind="stable")]
        twin = np.flatnonzero(self.facet[inner][1:] == self.facet[inner][:-1])
        first, second = inner[twin], inner[twin + 1]
        for column in range(self.nodes.shape[1]):
            node = self.nodes[first, column]
            use = touched[node]
            joined.append((incidence(self.cell[first][use], node[use]), incidence(self.cell[second][use], node[use])))
        rows, columns = (np.concatenate(side) for side in zip(*joined, strict=True))
        graph = sp.coo_array((np.ones(len(rows)), (rows, columns)), shape=(len(key), len(key)))
        return np.asarray(connected_components(graph, directed=False)[1])
