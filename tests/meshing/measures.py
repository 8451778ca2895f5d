"""What is measured on cracked meshes, plane and solid, by nothing but their points and cells."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import meshio
import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from cohesive.arrays import Array, Index, Mask
from meshing.cells import CELLS
from tests.builders import MIDS

Where = Callable[[Array], Mask]
X, Y, Z = 0, 1, 2

#: corners of the faces of opened wedges, normals inwards
WEDGE = [(0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)]
#: columns of the corners of crack cells on the minus and the plus side
SIDES = {"quad": ([0, 1], [3, 2]), "wedge": ([0, 1, 2], [3, 4, 5]), "hexahedron": ([0, 1, 2, 3], [4, 5, 6, 7])}
#: columns of the mid nodes of second-order crack cells on the minus and the plus side, in the order of the corners
MID_SIDES = {"quad8": ([4], [6]), "wedge15": ([6, 7, 8], [9, 10, 11])}


def n_corners(kind: str) -> int:
    """Of a cell of the bulk."""
    return {"triangle": 3, "quad": 4, "tetra": 4, "hexahedron": 8}[kind.rstrip("0123456789")]


def corners(mesh: meshio.Mesh, block: meshio.CellBlock) -> Array:
    """Of the cells of a block: (n, k, d)."""
    return np.asarray(mesh.points[block.data[:, : n_corners(block.type)]])


def pieces(mesh: meshio.Mesh) -> int:
    """Connected parts of the bulk, from connectivity alone."""
    rows, columns = [], []
    for block in mesh.cells[:-1]:
        rows.append(np.repeat(block.data[:, 0], block.data.shape[1]))
        columns.append(block.data.ravel())
    r, c = np.concatenate(rows), np.concatenate(columns)
    graph = sp.coo_array((np.ones(len(r)), (r, c)), shape=(len(mesh.points),) * 2)
    return int(connected_components(graph, directed=False)[0])


def areas(mesh: meshio.Mesh) -> list[Array]:
    """Signed areas of the cells, block by block."""
    result = []
    for block in mesh.cells:
        x, y = np.moveaxis(corners(mesh, block), 2, 0)
        result.append((x * np.roll(y, -1, axis=1) - np.roll(x, -1, axis=1) * y).sum(axis=1) / 2)
    return result


def faces_on(mesh: meshio.Mesh, normal: Any, where: Where) -> Index:
    """Element faces with a normal, whose corners all lie where wanted, in the sense of the normal."""
    (block,) = mesh.cells
    k = 4 if block.type == "hexahedron" else 3
    faces = block.data[:, [face[:k] for face in CELLS[block.type].faces]].reshape(-1, k)
    p = mesh.points[faces]
    turn = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]) @ np.asarray(normal, dtype=float)
    return faces[(turn > 1e-9) & where(p.reshape(-1, 3)).reshape(-1, k).all(axis=1)]


def on(axis: int, at: float, *limits: tuple[int, float, float]) -> tuple[Array, Where]:
    """A plane across an axis, with limits (axis, low, high) of the others."""

    def where(p: Array) -> Mask:
        inside = [(p[:, i] >= low) & (p[:, i] <= high) for i, low, high in limits]
        return np.asarray(np.all([p[:, axis] == at, *inside], axis=0))

    return np.eye(3)[axis], where


def volumes(points: Array, kind: str, cells: Index) -> Array:
    """Of cells with plane faces, from their faces."""
    faces = WEDGE if kind.startswith("wedge") else [f[: 4 if kind == "hexahedron" else 3] for f in CELLS[kind].faces]
    total = np.zeros(len(cells))
    for face in faces:
        for i in range(1, len(face) - 1):
            a, b, c = (points[cells[:, face[j]]] for j in (0, i, i + 1))
            total -= np.einsum("ni,ni->n", np.cross(a, b), c) / 6
    return total


def body_volume(mesh: meshio.Mesh) -> float:
    cells = [volumes(mesh.points, b.type, b.data) for b in mesh.cells if b.type not in ("wedge", "wedge15")]
    assert all((v > -1e-9 * abs(v).max()).all() for v in cells)
    return float(sum(v.sum() for v in cells))


def sides(block: meshio.CellBlock) -> tuple[Index, Index]:
    """Corners of the minus and of the plus side of crack cells."""
    minus, plus = SIDES[block.type.rstrip("0123456789")]
    return block.data[:, minus], block.data[:, plus]


def normals(mesh: meshio.Mesh, faces: Index) -> Array:
    """Normals of plane faces, of the size of their area, or of edges, to the left and of the size of their length."""
    p = mesh.points[faces]
    if faces.shape[1] == 2:
        return np.asarray(np.diff(p, axis=1)[:, 0] @ [[0, 1], [-1, 0]])
    return np.asarray(sum(np.cross(p[:, i] - p[:, 0], p[:, i + 1] - p[:, 0]) for i in range(1, faces.shape[1] - 1)) / 2)


def check_crack(mesh: meshio.Mesh) -> None:
    """Crack cells join coincident faces of two elements, their mid nodes too; the plus side is where their normal points."""
    block = mesh.cells[-1]
    (minus, plus), original = sides(block), mesh.point_data["original"]
    np.testing.assert_array_equal(original[minus], original[plus])
    np.testing.assert_array_equal(mesh.points[minus], mesh.points[plus])
    if mesh.points.shape[1] == 2:
        _check_edges(mesh, minus, plus)
    else:
        _check_faces(mesh, minus, plus)
    if block.type in MID_SIDES:
        _check_mids(mesh, minus, plus)


def _check_edges(mesh: meshio.Mesh, minus: Index, plus: Index) -> None:
    """Each side is an edge of exactly one element, which lies on its side."""
    for edges, sign in ((minus, -1.0), (plus, 1.0)):
        for (first, last), normal in zip(edges, normals(mesh, edges), strict=True):
            (centre,) = [
                mesh.points[cell[: n_corners(b.type)]].mean(axis=0)
                for b in mesh.cells[:-1] for cell in b.data if first in cell and last in cell
            ]  # fmt: skip
            assert sign * (centre - mesh.points[first]) @ normal > 0


def _check_faces(mesh: meshio.Mesh, minus: Index, plus: Index) -> None:
    """Cells open with a positive volume; each side is a face of exactly one element, plus with its normal inwards."""
    block, k = mesh.cells[-1], minus.shape[1]
    area = normals(mesh, minus)
    size = np.linalg.norm(area, axis=1)
    # each cell by itself, its plus side moved by a unit along the normal
    copies = mesh.points[block.data]
    own = np.arange(copies.shape[0] * copies.shape[1]).reshape(block.data.shape)
    copies[:, k : 2 * k] += (area / size[:, None])[:, None]
    np.testing.assert_allclose(volumes(copies.reshape(-1, 3), block.type, own), size, rtol=1e-9)
    faces: dict[tuple[int, ...], int] = {}
    for b in mesh.cells[:-1]:
        for ring in b.data[:, [f[:k] for f in CELLS[b.type].faces]].reshape(-1, k).tolist():
            start = ring.index(min(ring))
            turned = tuple(ring[start:] + ring[:start])
            faces[turned] = faces.get(turned, 0) + 1
    for ring, step in [(r, 1) for r in plus.tolist()] + [(r, -1) for r in minus.tolist()]:
        start = ring.index(min(ring))
        assert faces[tuple((ring[start:] + ring[:start]) if step == 1 else [ring[start - i] for i in range(k)])] == 1


def _check_mids(mesh: meshio.Mesh, minus: Index, plus: Index) -> None:
    """Mid nodes lie between their corners, coincide, and belong to the elements beside; sides across have none."""
    block, original = mesh.cells[-1], mesh.point_data["original"]
    c, (low, high) = block.data, MID_SIDES[block.type]
    for edge, columns in ((minus, low), (plus, high)):
        for i, column in enumerate(columns):
            ends = edge[:, [i, (i + 1) % edge.shape[1]]]
            np.testing.assert_allclose(mesh.points[c[:, column]], mesh.points[ends].mean(axis=1), atol=1e-9)
            beside = {
                (*sorted((cell[a], cell[b])), cell[mid])
                for b_ in mesh.cells[:-1] for cell in b_.data.tolist() for mid, a, b in MIDS[b_.type]
            }  # fmt: skip
            assert {(*sorted(pair), mid) for pair, mid in zip(ends.tolist(), c[:, column].tolist(), strict=True)} <= beside
    np.testing.assert_array_equal(original[c[:, low]], original[c[:, high]])
    if block.type == "wedge15":
        np.testing.assert_array_equal(c[:, 12:], c[:, :3])
    else:
        np.testing.assert_array_equal(c[:, [5, 7]], c[:, [1, 3]])
