"""Insertion of zero-thickness crack cells by splitting node stars.

Around a node, the elements that still share an uncut edge belong together. A node is doubled once for
every further group, so tips inside the body, kinks, branches, crossings and ends at notches or free
edges need no special case.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import meshio
import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from .errors import MeshError

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Point = tuple[float, float]
Line = Sequence[Point]

#: local edges (first corner, second corner[, mid-side]) of the bulk cells, meshio's node order
EDGES: dict[str, list[tuple[int, ...]]] = {
    "triangle": [(0, 1), (1, 2), (2, 0)],
    "triangle6": [(0, 1, 3), (1, 2, 4), (2, 0, 5)],
    "quad": [(0, 1), (1, 2), (2, 3), (3, 0)],
    "quad8": [(0, 1, 4), (1, 2, 5), (2, 3, 6), (3, 0, 7)],
}
#: crack cell of a linear and of a quadratic edge
CRACK_CELLS = {2: "quad", 3: "quad8"}


@dataclass(frozen=True)
class _Star:
    """Element-edge incidences: one row for each edge of each bulk cell."""

    cell: Index  # running number over all blocks
    edge: Index  # number of the edge, the same from both sides
    nodes: Index  # (rows, 2 or 3): corners in the cell's order, mid-side node

    @classmethod
    def of(cls, cells: Sequence[tuple[str, Index]]) -> _Star:
        owner, nodes, offset = [], [], 0
        for kind, block in cells:
            edges = np.array(EDGES[kind])
            nodes.append(block[:, edges].reshape(-1, edges.shape[1]))
            owner.append(np.repeat(np.arange(offset, offset + len(block)), len(edges)))
            offset += len(block)
        rows = np.concatenate(nodes)
        low, high = rows[:, :2].min(axis=1), rows[:, :2].max(axis=1)
        _, edge = np.unique(low * (high.max() + 1) + high, return_inverse=True)
        return cls(np.concatenate(owner), edge, rows)

    def find(self, directed: Index) -> Index:
        """Rows of edges (n, 2) in that direction, -1 where there is none."""
        size = max(int(self.nodes.max()), int(directed.max(initial=0))) + 1
        keys = self.nodes[:, 0] * size + self.nodes[:, 1]
        order = np.argsort(keys)
        wanted = directed[:, 0] * size + directed[:, 1]
        place = np.minimum(np.searchsorted(keys[order], wanted), len(keys) - 1)
        return np.where(keys[order[place]] == wanted, order[place], -1)


def edges_on_path(mesh: meshio.Mesh, name: str, lines: Sequence[Line]) -> Index:
    """Element edges that lie on polylines, in the direction of the path: (n, 2) corner nodes.

    Raises
    ------
    MeshError
        If a polyline has no length, or is not covered by element edges from end to end.
    """
    star = _Star.of([(block.type, block.data.astype(np.int64)) for block in mesh.cells if block.type in EDGES])
    _, first = np.unique(star.edge, return_index=True)
    edges, points = star.nodes[first, :2], mesh.points[:, :2]
    slack = 1e-6 * float(np.ptp(points, axis=0).max())
    total, covered = path_length(name, lines), 0.0
    found = [np.empty((0, 2), dtype=np.int64)]
    for line in lines:
        for a, b in pairwise(line):
            on = edges[nodes_on_segment(points, a, b, slack)[edges].all(axis=1)]
            along = (points[on[:, 1]] - points[on[:, 0]]) @ (np.subtract(b, a) / math.dist(a, b))
            found.append(np.where((along > 0)[:, None], on, on[:, ::-1]))
            covered += float(abs(along).sum())
    if abs(covered - total) > 1e-6 * total:
        raise MeshError(
            f"{name} path of length {total:g} mm: {covered:g} mm of it follow element edges inside the body; expected "
            "all of it"
        )
    return np.concatenate(found)


def path_length(name: str, lines: Sequence[Line]) -> float:
    """Total length of polylines, or a MeshError for one with fewer than two points or a segment without length."""
    total = 0.0
    for line in lines:
        if len(line) < 2:
            raise MeshError(f"{name} path {list(line)}: expected at least two points")
        for a, b in pairwise(line):
            length = math.dist(a, b)
            if not 0 < length < math.inf:
                raise MeshError(f"{name} path: segment from {tuple(a)} to {tuple(b)} has length {length:g}; expected > 0")
            total += length
    return total


def nodes_on_segment(points: Array, a: Point, b: Point, slack: float) -> NDArray[np.bool_]:
    """Which points lie on the segment from a to b, within a distance `slack`."""
    tangent = np.subtract(b, a) / math.dist(a, b)
    along, across = (points - a) @ tangent, (points - a) @ np.array([-tangent[1], tangent[0]])
    on = (abs(across) < slack) & (along > -slack) & (along < math.dist(a, b) + slack)
    return np.asarray(on)


def insert_cracks(mesh: meshio.Mesh, crack: Index, slit: Index | None = None) -> meshio.Mesh:
    """A copy of `mesh` that is cut along edges.

    Parameters
    ----------
    mesh : meshio.Mesh
        Plane mesh of triangle, quad, triangle6 or quad8 cells; other cells are dropped.
    crack : (n, 2) array
        Corner nodes of the edges that get a crack cell, each in the direction of the path. The plus side
        lies to the left of that direction.
    slit : (n, 2) array, optional
        Edges that are cut and left empty: a notch without width.

    Returns
    -------
    meshio.Mesh
        Bulk blocks with doubled nodes, then one block of crack cells: `quad` [a-, b-, b+, a+] or `quad8`
        [a-, b-, b+, a+, mid-, b-, mid+, a+] (the short sides have no mid node: a corner stands in). Cell sets
        `body` and `crack`; point sets of `mesh` grow by the copies of their nodes. `point_data["original"]`
        holds the node number before the cut.

    Raises
    ------
    MeshError
        For an edge that is not in the mesh or lies on its boundary, mixed orders, or a path that cuts nothing.
    """
    slit = np.empty((0, 2), dtype=np.int64) if slit is None else slit
    cells = plane_cells(mesh)
    star = _Star.of(cells)
    minus_row, plus_row = _sides(star, np.concatenate([crack, slit]), mesh.points)
    cut = np.unique(star.edge[minus_row])
    if len(cut) < len(minus_row):
        row = minus_row[np.argmax(np.bincount(star.edge[minus_row])[star.edge[minus_row]])]
        x, y = mesh.points[star.nodes[row, :2], :2].mean(axis=0)
        raise MeshError(
            f"the crack path runs along a notch or along itself at ({x:g}, {y:g}): expected paths that at most cross"
        )
    cells, original = _split(star, cells, cut, len(mesh.points))
    # the same rows of the split cells name the copies on either side
    rows = _Star.of(cells).nodes
    # the plus side lies to the left, so its cell runs along the path and the minus cell against it
    turned = [1, 0, 2][: rows.shape[1]]
    minus, plus = rows[minus_row[: len(crack)]][:, turned], rows[plus_row[: len(crack)]]
    if (minus[:, :2] == plus[:, :2]).all():
        raise MeshError(
            f"the crack path cuts nothing: {len(crack)} element edge(s) inside the body, none of which reaches a free "
            "edge or another one; expected at least two element edges in a row"
        )
    return _with_crack_cells(mesh, cells, original, minus, plus)


def cut_slits(mesh: meshio.Mesh, slit: Index) -> meshio.Mesh:
    """A copy of `mesh` that is cut along the edges `slit` (n, 2), without crack cells.

    Returns
    -------
    meshio.Mesh
        The blocks of `mesh` in their order, with doubled nodes; the cell set `body` of them all. Point sets grow by
        the copies of their nodes. `point_data["original"]` holds the node number before the cut.

    Raises
    ------
    MeshError
        For an edge that is not in the mesh or lies on its boundary, or mixed orders.
    """
    cells, original = plane_cells(mesh), np.arange(len(mesh.points))
    if len(slit):
        star = _Star.of(cells)
        minus_row, _ = _sides(star, slit, mesh.points)
        cells, original = _split(star, cells, np.unique(star.edge[minus_row]), len(mesh.points))
    return meshio.Mesh(
        mesh.points[original],
        cells,
        point_data={"original": original},
        point_sets=_grown(mesh, original),
        cell_sets={"body": [np.arange(len(block)) for _, block in cells]},
    )


def plane_cells(mesh: meshio.Mesh) -> list[tuple[str, Index]]:
    """The triangles and quadrilaterals of a mesh; MeshError if it has none, or mixes first and second order."""
    cells = [(block.type, block.data.astype(np.int64)) for block in mesh.cells if block.type in EDGES]
    if not cells:
        raise MeshError(f"the mesh has no cells of type {', '.join(EDGES)}")
    if len({len(EDGES[kind][0]) for kind, _ in cells}) > 1:
        raise MeshError(f"the mesh mixes first and second order cells: {', '.join(kind for kind, _ in cells)}")
    return cells


def _grown(mesh: meshio.Mesh, original: Index) -> dict[str, Index]:
    """Point sets of a mesh with the copies of their nodes."""
    return {name: np.flatnonzero(np.isin(original, nodes)) for name, nodes in (mesh.point_sets or {}).items()}


def mirror_cracks(mesh: meshio.Mesh, crack: Index) -> meshio.Mesh:
    """Crack cells between one half of a symmetric body and its mirror image.

    Parameters
    ----------
    mesh : meshio.Mesh
        The half on the plus side, to the left of the path.
    crack : (n, 2) array
        Corner nodes of boundary edges on the plane of symmetry, each in the direction of the path.

    Returns
    -------
    meshio.Mesh
        As from `insert_cracks`; the minus nodes stand for the mirror image and belong to no bulk cell.

    Raises
    ------
    MeshError
        For an edge that is not on the boundary of the body.
    """
    cells = [(block.type, block.data.astype(np.int64)) for block in mesh.cells if block.type in EDGES]
    star = _Star.of(cells)
    row = star.find(crack)
    if (row < 0).any() or (star.find(crack[:, ::-1]) >= 0).any():
        raise MeshError("the crack path of a half body: expected edges on its boundary, the body to the left")
    plus = star.nodes[row]
    nodes, number = np.unique(plus, return_inverse=True)
    original = np.concatenate([np.arange(len(mesh.points)), nodes])
    return _with_crack_cells(mesh, cells, original, len(mesh.points) + number.reshape(plus.shape), plus)


def _with_crack_cells(
    mesh: meshio.Mesh, cells: list[tuple[str, Index]], original: Index, minus: Index, plus: Index
) -> meshio.Mesh:
    """The mesh that `insert_cracks` returns; minus and plus are (n, 2 or 3): a, b[, mid] of each crack cell."""
    columns = [minus[:, 0], minus[:, 1], plus[:, 1], plus[:, 0]]
    if plus.shape[1] == 3:
        columns += [minus[:, 2], minus[:, 1], plus[:, 2], plus[:, 0]]
    crack_cells = np.stack(columns, axis=1)
    body = [np.arange(len(block)) for _, block in cells]
    nothing = [np.empty(0, dtype=np.int64) for _ in cells]
    return meshio.Mesh(
        mesh.points[original],
        [*cells, (CRACK_CELLS[plus.shape[1]], crack_cells)],
        point_data={"original": original},
        point_sets=_grown(mesh, original),
        cell_sets={"body": [*body, nothing[0]], "crack": [*nothing, np.arange(len(crack_cells))]},
    )


def _sides(star: _Star, path: Index, points: Array) -> tuple[Index, Index]:
    """Rows of `star` on the minus and plus side of each path edge."""
    plus, minus = star.find(path), star.find(path[:, ::-1])
    for i in np.flatnonzero((plus < 0) | (minus < 0)).tolist():
        where = "outside the body" if plus[i] == minus[i] else "along its boundary"
        x, y = points[path[i], :2].mean(axis=0)
        raise MeshError(f"the crack path runs {where} at ({x:g}, {y:g}): expected a path inside the body")
    return minus, plus


def _split(
    star: _Star, cells: Sequence[tuple[str, Index]], cut: Index, n_points: int
) -> tuple[list[tuple[str, Index]], Index]:
    """Cells with the copies in place, and for each node of the new mesh the node it copies."""
    is_cut = np.isin(star.edge, cut)
    touched = np.zeros(n_points, dtype=bool)
    touched[star.nodes[is_cut].ravel()] = True

    # corners = incidences (cell, node) at touched nodes; two are joined across an uncut edge at that node
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
    inner = np.flatnonzero(~is_cut & touched[star.nodes].any(axis=1))
    inner = inner[np.argsort(star.edge[inner], kind="stable")]
    twin = np.flatnonzero(star.edge[inner][1:] == star.edge[inner][:-1])
    first, second = inner[twin], inner[twin + 1]
    for column in range(star.nodes.shape[1]):
        node = star.nodes[first, column]
        use = touched[node]
        joined.append((corner_index(star.cell[first][use], node[use]), corner_index(star.cell[second][use], node[use])))
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
    new = [(kind, part.reshape(block.shape)) for (kind, block), part in zip(cells, np.split(renumbered, ends), strict=True)]
    return new, np.concatenate([np.arange(n_points), pairs[fresh, 0]])
