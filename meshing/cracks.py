"""Insertion of zero-thickness crack cells by splitting node stars.

Around a node, the elements that still share an uncut facet (edge in the plane, face in space) belong together. A node is
doubled once for every further group, so tips and fronts inside the body, kinks, branches, crossings and ends at notches or
free edges need no special case.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import meshio
import numpy as np
from numpy.typing import NDArray

from .errors import MeshError
from .star import CRACK_CELLS, EDGES, FACES, FACETS, Blocks, Star, n_corners

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Point = tuple[float, float]
Line = Sequence[Point]


def edges_on_path(mesh: meshio.Mesh, name: str, lines: Sequence[Line]) -> Index:
    """Element edges that lie on polylines, in the direction of the path: (n, 2) corner nodes.

    Raises
    ------
    MeshError
        If a polyline has no length, or is not covered by element edges from end to end.
    """
    star = Star.from_cells([(block.type, block.data.astype(np.int64)) for block in mesh.cells if block.type in EDGES])
    _, first = np.unique(star.facet, return_index=True)
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
    """A copy of `mesh` that is cut along element edges, of a solid mesh along element faces.

    Parameters
    ----------
    mesh : meshio.Mesh
        Plane mesh of triangle, quad, triangle6 or quad8 cells, or solid mesh of tetra, tetra10 or hexahedron cells; cells
        of lower dimension are dropped.
    crack : (n, 2) array, of a solid mesh (n, 3) or (n, 4)
        Corner nodes of the edges that get a crack cell, each in the direction of the path: the plus side lies to the left
        of it. Of faces a, b, c(, d): the plus side is the one that the normal (b - a) x (c - a) points to.
    slit : array like `crack`, optional
        Edges or faces that are cut and left empty: a notch without width.

    Returns
    -------
    meshio.Mesh
        Bulk blocks with doubled nodes, then one block of crack cells: `quad` [a-, b-, b+, a+] or `quad8`
        [a-, b-, b+, a+, mid-, b-, mid+, a+] (the short sides have no mid node: a corner stands in); of faces `wedge`
        [a-, b-, c-, a+, b+, c+], `hexahedron` [a-, b-, c-, d-, a+, b+, c+, d+], or `wedge15` [corners as wedge, ab-, bc-,
        ca-, ab+, bc+, ca+, a-, b-, c-] (again corners stand in). Cell sets `body` and `crack`; point sets of `mesh` grow by
        the copies of their nodes. `point_data["original"]` holds the node number before the cut.

    Raises
    ------
    MeshError
        For an edge or face that is not in the mesh or lies on its boundary, mixed cells, or a path that cuts nothing.
    """
    slit = np.empty((0, crack.shape[1]), dtype=np.int64) if slit is None else slit
    cells = bulk_cells(mesh)
    star = Star.from_cells(cells)
    minus_row, plus_row = _sides(star, np.concatenate([crack, slit]), mesh.points)
    cut = np.unique(star.facet[minus_row])
    if len(cut) < len(minus_row):
        row = minus_row[np.argmax(np.bincount(star.facet[minus_row])[star.facet[minus_row]])]
        raise MeshError(
            f"the crack {_WORDS[star.corners][0]} runs along a notch or along itself at {_middle(mesh, star, row)}: expected "
            f"{_WORDS[star.corners][0]}s that at most cross"
        )
    cells, original = star.split(cells, cut, len(mesh.points))
    # the same rows of the split cells name the copies on either side
    rows = Star.from_cells(cells).nodes
    minus, plus = (
        np.take_along_axis(rows[row], star.columns(row, crack), axis=1)
        for row in (minus_row[: len(crack)], plus_row[: len(crack)])
    )
    if (minus == plus)[:, : star.corners].all():
        word, facet, _, reason = _WORDS[star.corners]
        raise MeshError(f"the crack {word} cuts nothing: {len(crack)} element {facet}(s) inside the body, {reason}")
    return _with_crack_cells(mesh, star, cells, original, minus, plus)


#: by the corners of a facet: what a crack runs along, what that consists of, where else it may run by mistake, and why it
#: may cut nothing
_WORDS = {
    2: (
        "path",
        "edge",
        "outside the body",
        "none of which reaches a free edge or another one; expected at least two element edges in a row",
    ),
    3: (
        "surface",
        "face",
        "outside the body or through its elements",
        "all of whose nodes lie on its front; expected at least two element faces from front to front, smaller elements",
    ),
}
_WORDS[4] = _WORDS[3]


def _middle(mesh: meshio.Mesh, star: Star, row: int) -> str:
    return as_text(mesh.points[star.nodes[row, : star.corners]].mean(axis=0))


def as_text(point: Sequence[float] | Array) -> str:
    """A point as text."""
    return f"({', '.join(f'{c:g}' for c in point)})"


def cut_slits(mesh: meshio.Mesh, slit: Index) -> meshio.Mesh:
    """A copy of `mesh` that is cut along the edges `slit` (n, 2), or faces (n, 3) or (n, 4), without crack cells.

    Returns
    -------
    meshio.Mesh
        The blocks of `mesh` in their order, with doubled nodes; the cell set `body` of them all. Point sets grow by
        the copies of their nodes. `point_data["original"]` holds the node number before the cut.

    Raises
    ------
    MeshError
        For an edge or face that is not in the mesh or lies on its boundary, or mixed cells.
    """
    cells, original = bulk_cells(mesh), np.arange(len(mesh.points))
    if len(slit):
        star = Star.from_cells(cells)
        minus_row, _ = _sides(star, slit, mesh.points)
        cells, original = star.split(cells, np.unique(star.facet[minus_row]), len(mesh.points))
    return meshio.Mesh(
        mesh.points[original],
        cells,
        point_data={"original": original},
        point_sets=_grown(mesh, original),
        cell_sets={"body": [np.arange(len(block)) for _, block in cells]},
    )


def bulk_cells(mesh: meshio.Mesh) -> Blocks:
    """The solid cells of a mesh, or the plane ones if it has none of them.

    Raises
    ------
    MeshError
        If it has neither, mixes first and second order, or mixes solid cells.
    """
    solid = any(block.type in FACES for block in mesh.cells)
    cells = [(block.type, block.data.astype(np.int64)) for block in mesh.cells if block.type in (FACES if solid else EDGES)]
    if not cells:
        raise MeshError(f"the mesh has no cells of type {', '.join(FACETS)}")
    kinds = {kind: len(FACETS[kind][0]) for kind, _ in cells}
    if len(set(kinds.values())) > 1:
        what = "solid cells that share no faces" if solid else "first and second order cells"
        raise MeshError(f"the mesh mixes {what}: {', '.join(kinds)}")
    return cells


def _grown(mesh: meshio.Mesh, original: Index) -> dict[str, Index]:
    """Point sets of a mesh with the copies of their nodes."""
    return {name: np.flatnonzero(np.isin(original, nodes)) for name, nodes in (mesh.point_sets or {}).items()}


def mirror_cracks(mesh: meshio.Mesh, crack: Index) -> meshio.Mesh:
    """Crack cells between one half of a symmetric body and its mirror image.

    Parameters
    ----------
    mesh : meshio.Mesh
        The half on the plus side: to the left of the path, or where the surface's normal points to.
    crack : (n, 2) array, of a solid mesh (n, 3) or (n, 4)
        Corner nodes of boundary edges or faces on the plane of symmetry, directed as for `insert_cracks`.

    Returns
    -------
    meshio.Mesh
        As from `insert_cracks`; the minus nodes stand for the mirror image and belong to no bulk cell.

    Raises
    ------
    MeshError
        For an edge or face that is not on the boundary of the body.
    """
    cells = bulk_cells(mesh)
    star = Star.from_cells(cells)
    row = star.find(crack)
    if (row < 0).any() or (star.find(crack[:, ::-1]) >= 0).any():
        word, facet, _, _ = _WORDS[star.corners]
        side = "to the left" if star.corners == 2 else "where its normal points to"
        raise MeshError(f"the crack {word} of a half body: expected {facet}s on its boundary, the body {side}")
    plus = np.take_along_axis(star.nodes[row], star.columns(row, crack), axis=1)
    nodes, number = np.unique(plus, return_inverse=True)
    original = np.concatenate([np.arange(len(mesh.points)), nodes])
    return _with_crack_cells(mesh, star, cells, original, len(mesh.points) + number.reshape(plus.shape), plus)


def _with_crack_cells(mesh: meshio.Mesh, star: Star, cells: Blocks, original: Index, minus: Index, plus: Index) -> meshio.Mesh:
    """The mesh that `insert_cracks` returns; minus and plus are the nodes of the facets on either side."""
    kind, columns = CRACK_CELLS[star.corners, star.nodes.shape[1]]
    crack_cells = np.concatenate([minus, plus], axis=1)[:, columns]
    body = [np.arange(len(block)) for _, block in cells]
    nothing = [np.empty(0, dtype=np.int64) for _ in cells]
    return meshio.Mesh(
        mesh.points[original],
        [*cells, (kind, crack_cells)],
        point_data={"original": original},
        point_sets=_grown(mesh, original),
        cell_sets={"body": [*body, nothing[0]], "crack": [*nothing, np.arange(len(crack_cells))]},
    )


def _sides(star: Star, path: Index, points: Array) -> tuple[Index, Index]:
    """Rows of `star` on the minus and plus side of each facet of a path or surface."""
    plus, minus = star.find(path), star.find(path[:, ::-1])
    word, _, outside, _ = _WORDS[star.corners]
    for i in np.flatnonzero((plus < 0) | (minus < 0)).tolist():
        where = outside if plus[i] == minus[i] else "along its boundary"
        here = as_text(points[path[i]].mean(axis=0))
        raise MeshError(f"the crack {word} runs {where} at {here}: expected a {word} inside the body")
    return minus, plus


def crack_front_length(mesh: meshio.Mesh) -> float:
    """Length of the edge of a crack surface that is not split, mm; 0 in the plane."""
    if mesh.points.shape[1] == 2:
        return 0.0
    original: Index = mesh.point_data["original"]
    crack = mesh.cells[-1]
    facets = original[crack.data[:, : n_corners(crack.type)]]
    edges = np.sort(np.stack([facets, np.roll(facets, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    edges, uses = np.unique(edges, axis=0, return_counts=True)
    is_whole = np.bincount(original)[edges] == 1
    ends = mesh.points[edges[(uses == 1) & is_whole.all(axis=1)]]
    return float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum())
