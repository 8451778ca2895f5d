"""Splitting of solid meshes along faces."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import meshio
import numpy as np
import pytest
from numpy.typing import NDArray

from meshing import MeshError, insert_cracks
from meshing.cracks import cut_slits, mirror_cracks
from meshing.star import FACES
from tests.builders import cubes
from tests.meshing.test_plane_meshes import pieces

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Where = Callable[[Array], NDArray[np.bool_]]

#: corners and mids of the faces of opened crack cells, normals inwards, and the part of them on the minus side
WEDGE = [(0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)]


def faces_on(mesh: meshio.Mesh, normal: Any, where: Where) -> Index:
    """Element faces with a normal, whose corners all lie where wanted, in the sense of the normal."""
    (block,) = mesh.cells
    k = 4 if block.type == "hexahedron" else 3
    faces = block.data[:, [face[:k] for face in FACES[block.type]]].reshape(-1, k)
    p = mesh.points[faces]
    turn = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]) @ np.asarray(normal, dtype=float)
    return faces[(turn > 1e-9) & where(p.reshape(-1, 3)).reshape(-1, k).all(axis=1)]


def on(axis: int, at: float, *limits: tuple[int, float, float]) -> tuple[Array, Where]:
    """A plane across an axis, with limits (axis, low, high) of the others."""

    def where(p: Array) -> NDArray[np.bool_]:
        inside = [(p[:, i] >= low) & (p[:, i] <= high) for i, low, high in limits]
        return np.asarray(np.all([p[:, axis] == at, *inside], axis=0))

    return np.eye(3)[axis], where


def volumes(points: Array, kind: str, cells: Index) -> Array:
    """Of cells with plane faces, from their faces."""
    faces = WEDGE if kind.startswith("wedge") else [f[: 4 if kind == "hexahedron" else 3] for f in FACES[kind]]
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
    """Corners of the minus and of the plus face."""
    k = 4 if block.type == "hexahedron" else 3
    return block.data[:, :k], block.data[:, k : 2 * k]


def normals(mesh: meshio.Mesh, faces: Index) -> Array:
    """Area vectors of plane faces."""
    p = mesh.points[faces]
    return np.asarray(sum(np.cross(p[:, i] - p[:, 0], p[:, i + 1] - p[:, 0]) for i in range(1, faces.shape[1] - 1)) / 2)


def check_crack(mesh: meshio.Mesh) -> None:
    """Crack cells join coincident faces of two elements, and open with a positive volume along their normal."""
    block = mesh.cells[-1]
    (minus, plus), original = sides(block), mesh.point_data["original"]
    np.testing.assert_array_equal(original[minus], original[plus])
    np.testing.assert_array_equal(mesh.points[minus], mesh.points[plus])
    area = normals(mesh, minus)
    size = np.linalg.norm(area, axis=1)
    # each cell by itself, its plus side moved by a unit along the normal
    copies = mesh.points[block.data]
    own = np.arange(copies.shape[0] * copies.shape[1]).reshape(block.data.shape)
    k = minus.shape[1]
    copies[:, k : 2 * k] += (area / size[:, None])[:, None]
    np.testing.assert_allclose(volumes(copies.reshape(-1, 3), block.type, own), size, rtol=1e-9)
    # the elements beside it: each side is a face of exactly one element, the plus side with its normal inwards
    faces: dict[tuple[int, ...], int] = {}
    for b in mesh.cells[:-1]:
        for ring in b.data[:, [f[:k] for f in FACES[b.type]]].reshape(-1, k).tolist():
            start = ring.index(min(ring))
            turned = tuple(ring[start:] + ring[:start])
            faces[turned] = faces.get(turned, 0) + 1
    for ring, step in [(r, 1) for r in plus.tolist()] + [(r, -1) for r in minus.tolist()]:
        start = ring.index(min(ring))
        assert faces[tuple((ring[start:] + ring[:start]) if step == 1 else [ring[start - i] for i in range(k)])] == 1
    if block.type == "wedge15":
        c = block.data
        for column, a, b in ((6, 0, 1), (7, 1, 2), (8, 2, 0), (9, 3, 4), (10, 4, 5), (11, 5, 3)):
            middle = mesh.points[c[:, [a, b]]].mean(axis=1)
            np.testing.assert_allclose(mesh.points[c[:, column]], middle, atol=1e-9)
        np.testing.assert_array_equal(original[c[:, 6:9]], original[c[:, 9:12]])
        np.testing.assert_array_equal(c[:, 12:], c[:, :3])
        mids = {
            tuple(row) for b in mesh.cells[:-1] for f in FACES["tetra10"] for row in np.sort(b.data[:, f], axis=1).tolist()
        }
        for columns in ([0, 1, 2, 6, 7, 8], [3, 4, 5, 9, 10, 11]):
            assert {tuple(row) for row in np.sort(c[:, columns], axis=1).tolist()} <= mids


X, Y, Z = 0, 1, 2
#               surfaces, copies of corner nodes, unit squares, pieces (4 x 4 x 4 unit cubes)
CASES: dict[str, tuple[list[tuple[Array, Where]], int, int, int]] = {
    "through": ([on(X, 2)], 25, 16, 2),
    "front inside": ([on(X, 2, (Y, 0, 3))], 15, 12, 1),
    "front all around": ([on(X, 2, (Y, 1, 3), (Z, 1, 3))], 1, 4, 1),
    "kink": ([on(X, 2, (Y, 0, 2)), on(Y, 2, (X, 2, 4))], 25, 16, 2),
    "corner": ([on(X, 2, (Y, 0, 2), (Z, 0, 2)), on(Y, 2, (X, 0, 2), (Z, 0, 2)), on(Z, 2, (X, 0, 2), (Y, 0, 2))], 19, 12, 2),
    "T-branch": ([on(Y, 2), on(X, 2, (Y, 2, 4))], 25 + 15, 24, 3),
    "crossing": ([on(X, 2), on(Y, 2)], 40 + 3 * 5, 32, 4),
    "crossing inside": ([on(X, 2, (Y, 1, 3)), on(Y, 2, (X, 1, 3))], 3 * 5, 16, 1),
    "three planes": ([on(X, 2), on(Y, 2), on(Z, 2)], 3 * 16 + 3 * 4 * 3 + 7, 48, 8),
    "two parallel": ([on(Z, 1), on(Z, 3)], 50, 32, 3),
}


@pytest.mark.parametrize("kind", ["hexahedron", "tetra", "tetra10"])
@pytest.mark.parametrize("case", CASES)
def test_splitting(case: str, kind: str) -> None:
    surfaces, copies, squares, parts = CASES[case]
    mesh = cubes(kind)
    surface = np.concatenate([faces_on(mesh, *s) for s in surfaces])
    result = insert_cracks(mesh, surface)
    crack = result.cells[-1]
    assert crack.type == {"hexahedron": "hexahedron", "tetra": "wedge", "tetra10": "wedge15"}[kind]
    assert len(crack.data) == squares * (1 if kind == "hexahedron" else 2)
    n_corners = len(cubes("tetra").points)
    assert (result.point_data["original"][len(mesh.points) :] < n_corners).sum() == copies
    assert pieces(result) == parts
    np.testing.assert_array_equal(result.points, mesh.points[result.point_data["original"]])
    assert body_volume(meshio.Mesh(result.points, result.cells[:-1])) == pytest.approx(64)
    assert np.linalg.norm(normals(result, sides(crack)[0]), axis=1).sum() == pytest.approx(squares)
    np.testing.assert_allclose(normals(result, sides(crack)[0]), normals(mesh, surface))
    check_crack(result)
    if kind == "tetra10":  # no element lost a mid node: each still lies between its corners
        for block in result.cells[:-1]:
            for i, (a, b) in enumerate([(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]):
                np.testing.assert_allclose(
                    result.points[block.data[:, 4 + i]], result.points[block.data[:, [a, b]]].mean(axis=1)
                )


@pytest.mark.parametrize("kind", ["tetra", "tetra10"])
def test_mid_nodes_are_doubled_but_on_the_front(kind: str) -> None:
    mesh = cubes(kind)
    result = insert_cracks(mesh, faces_on(mesh, *on(X, 2, (Y, 1, 3), (Z, 1, 3))))
    copied = mesh.points[result.point_data["original"][len(mesh.points) :]]
    inside = (copied[:, 1:] > 1) & (copied[:, 1:] < 3)
    assert inside.all() and (copied[:, 0] == 2).all()
    in_plane = (mesh.points[:, 0] == 2) & ((mesh.points[:, 1:] > 1) & (mesh.points[:, 1:] < 3)).all(axis=1)
    assert len(copied) == in_plane.sum()


def test_slits_half_and_sets() -> None:
    mesh = cubes()
    mesh.point_sets = {"line": np.flatnonzero((mesh.points[:, :2] == [2, 4]).all(axis=1))}
    crack, slit = faces_on(mesh, *on(X, 2, (Y, 2, 4))), faces_on(mesh, *on(X, 2, (Y, 0, 2)))
    result = insert_cracks(mesh, crack, slit)
    assert (len(result.cells[-1].data), pieces(result), len(result.point_sets["line"])) == (8, 2, 10)
    opened = cut_slits(mesh, slit)
    assert (len(opened.points) - 125, [b.type for b in opened.cells]) == (10, ["hexahedron"])
    face = faces_on(mesh, *on(X, 0))
    half = mirror_cracks(mesh, face)
    assert len(half.points) == 125 + 25
    minus, plus = sides(half.cells[-1])
    assert (plus < 125).all() and (minus >= 125).all()
    np.testing.assert_allclose(normals(half, minus), np.tile([1.0, 0, 0], (16, 1)))
    for wrong in (face[:, ::-1], faces_on(mesh, *on(X, 2))):
        with pytest.raises(
            MeshError, match="surface of a half body: expected faces on its boundary, the body where its normal"
        ):
            mirror_cracks(mesh, wrong)


def test_a_surface_that_does_not_work_is_named() -> None:
    mesh = cubes()
    through = faces_on(mesh, *on(X, 2))
    for surface, message in (
        (faces_on(mesh, *on(X, 2, (Y, 1, 2), (Z, 1, 2))), r"surface cuts nothing: 1 element face\(s\) inside the body"),
        (faces_on(mesh, *on(X, 0)), r"surface runs along its boundary at \(0, 0\.5, 0\.5\): expected a surface inside"),
        (np.array([[0, 6, 12, 18]]), "surface runs outside the body or through its elements at"),
        (np.concatenate([through, through[:1, ::-1]]), "surface runs along a notch or along itself at"),
    ):
        with pytest.raises(MeshError, match=message):
            insert_cracks(mesh, surface)
    mixed = meshio.Mesh(mesh.points, [*mesh.cells, ("tetra", np.array([[0, 1, 5, 25]]))])
    with pytest.raises(MeshError, match="mixes solid cells that share no faces: hexahedron, tetra"):
        insert_cracks(mixed, through)
