"""Insertion of zero-thickness crack cells by splitting node stars.

Around a node, the elements that still share an uncut facet (edge in 2D, face in 3D) belong together. A node is doubled once
for every further group, so tips and crack fronts inside the body, kinks, branches, crossings and ends at notches or free edges
need no special case.
"""

from __future__ import annotations

from typing import NamedTuple

import meshio
import numpy as np

from ..arrays import Array, Index
from ..cells import CELLS
from ..errors import MeshError
from ..paths import as_text
from .stars import Blocks, Star, bulk_cells, touching


class _Words(NamedTuple):
    """What the errors call things."""

    crack: str
    facet: str
    elsewhere: str  # it may run there by mistake
    whole: str  # why it may cut nothing


_PATH = _Words(
    "path",
    "edge",
    "outside the body",
    "none of which reaches a free edge or another one; expected at least two element edges in a row",
)
_SURFACE = _Words(
    "surface",
    "face",
    "outside the body or through its elements",
    "all of whose nodes lie on its front; expected at least two element faces from front to front, smaller elements",
)


def _words(star: Star) -> _Words:
    return _PATH if star.corners == 2 else _SURFACE


def insert_cracks(mesh: meshio.Mesh, crack: Index, slit: Index | None = None) -> meshio.Mesh:
    """A copy of a mesh that is cut along element edges, of a 3D mesh along element faces.

    Parameters
    ----------
    mesh : meshio.Mesh
        Of triangle, quad, triangle6 or quad8 cells in 2D, of tetra, tetra10 or hexahedron cells in 3D; cells of lower
        dimension are dropped.
    crack : (n, 2) array, of a 3D mesh (n, 3) or (n, 4)
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
    near, chosen = _around(cells, np.concatenate([crack, slit]), len(mesh.points))
    star = Star.from_cells(near)
    minus_row, plus_row = _sides(star, np.concatenate([crack, slit]), mesh.points)
    cut = np.unique(star.facet[minus_row])
    if len(cut) < len(minus_row):
        row = minus_row[np.argmax(np.bincount(star.facet[minus_row])[star.facet[minus_row]])]
        word, here = _words(star).crack, as_text(mesh.points[star.nodes[row, : star.corners]].mean(axis=0))
        raise MeshError(f"the crack {word} runs along a notch or along itself at {here}: expected {word}s that at most cross")
    near, original = star.split(near, cut, len(mesh.points))
    # the same rows of the split cells name the copies on either side
    rows = Star.from_cells(near).nodes
    minus, plus = (
        np.take_along_axis(rows[row], star.columns(row, crack), axis=1)
        for row in (minus_row[: len(crack)], plus_row[: len(crack)])
    )
    if (minus == plus)[:, : star.corners].all():
        word, facet, _, whole = _words(star)
        raise MeshError(f"the crack {word} cuts nothing: {len(crack)} element {facet}(s) inside the body, {whole}")
    return _with_crack_cells(mesh, _with(cells, chosen, near), original, minus, plus)


def _around(cells: Blocks, facets: Index, n_nodes: int) -> tuple[Blocks, list[Index]]:
    """The cells around the nodes of some facets: those that a cut there concerns."""
    inside = np.zeros(n_nodes, dtype=bool)
    inside[facets.ravel()] = True
    return touching(cells, inside)


def _with(cells: Blocks, chosen: list[Index], renumbered: Blocks) -> Blocks:
    """All cells, the chosen ones of each block with other nodes."""
    new = []
    for (kind, block), at, (_, part) in zip(cells, chosen, renumbered, strict=True):
        whole = block.copy()
        whole[at] = part
        new.append((kind, whole))
    return new


def cut_slits(mesh: meshio.Mesh, slit: Index) -> meshio.Mesh:
    """A copy of a mesh that is cut along the edges `slit` (n, 2), or faces (n, 3) or (n, 4), without crack cells.

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
        near, chosen = _around(cells, slit, len(mesh.points))
        star = Star.from_cells(near)
        minus_row, _ = _sides(star, slit, mesh.points)
        near, original = star.split(near, np.unique(star.facet[minus_row]), len(mesh.points))
        cells = _with(cells, chosen, near)
    return meshio.Mesh(
        mesh.points[original],
        cells,
        point_data={"original": original},
        point_sets=_grown(mesh, original),
        cell_sets={"body": [np.arange(len(block)) for _, block in cells]},
    )


def _grown(mesh: meshio.Mesh, original: Index) -> dict[str, Index]:
    """Point sets of a mesh with the copies of their nodes."""
    return {name: np.flatnonzero(np.isin(original, nodes)) for name, nodes in (mesh.point_sets or {}).items()}


def mirror_cracks(mesh: meshio.Mesh, crack: Index) -> meshio.Mesh:
    """Crack cells between one half of a symmetric body and its mirror image.

    Parameters
    ----------
    mesh : meshio.Mesh
        The half on the plus side: to the left of the path, or the side that the surface's normal points to.
    crack : (n, 2) array, of a 3D mesh (n, 3) or (n, 4)
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
    star = Star.from_cells(_around(cells, crack, len(mesh.points))[0])
    row = star.find(crack)
    if (row < 0).any() or (star.find(crack[:, ::-1]) >= 0).any():
        word, facet, _, _ = _words(star)
        side = "to the left" if star.corners == 2 else "where its normal points to"
        raise MeshError(f"the crack {word} of a half body: expected {facet}s on its boundary, the body {side}")
    plus = np.take_along_axis(star.nodes[row], star.columns(row, crack), axis=1)
    nodes, number = np.unique(plus, return_inverse=True)
    original = np.concatenate([np.arange(len(mesh.points)), nodes])
    return _with_crack_cells(mesh, cells, original, len(mesh.points) + number.reshape(plus.shape), plus)


def _with_crack_cells(mesh: meshio.Mesh, cells: Blocks, original: Index, minus: Index, plus: Index) -> meshio.Mesh:
    """The mesh that `insert_cracks` returns; minus and plus are the nodes of the facets on either side."""
    kind = CELLS[cells[0][0]].crack_cell
    crack_cells = np.concatenate([minus, plus], axis=1)[:, list(CELLS[kind].crack_columns)]
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
    """Rows of `star` on the minus and the plus side of each facet of a path or surface."""
    plus, minus = star.find(path), star.find(path[:, ::-1])
    word, _, elsewhere, _ = _words(star)
    for i in np.flatnonzero((plus < 0) | (minus < 0)).tolist():
        where = elsewhere if plus[i] == minus[i] else "along its boundary"
        here = as_text(points[path[i]].mean(axis=0))
        raise MeshError(f"the crack {word} runs {where} at {here}: expected a {word} inside the body")
    return minus, plus


def crack_front_length(mesh: meshio.Mesh) -> float:
    """Length of the crack front of a mesh as `insert_cracks` gives it, mm: the edge of a crack surface that is not split.

    0 in 2D.
    """
    if mesh.points.shape[1] == 2:
        return 0.0
    original: Index = mesh.point_data["original"]
    crack = mesh.cells[-1]
    facets = original[crack.data[:, : CELLS[crack.type].facet_corners]]
    edges = np.sort(np.stack([facets, np.roll(facets, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    edges, uses = np.unique(edges, axis=0, return_counts=True)
    is_whole = np.bincount(original)[edges] == 1
    ends = mesh.points[edges[(uses == 1) & is_whole.all(axis=1)]]
    return float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum())
