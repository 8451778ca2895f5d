"""Splitting of meshes by node stars, along lines in 2D and along faces in 3D."""

from __future__ import annotations

import meshio
import numpy as np
import pytest

from cohesive.arrays import Array, Index
from meshing import MeshError, insert_cracks
from meshing.cutting.edges import edges_on_path
from meshing.cutting.insertion import crack_front_length, cut_slits, mirror_cracks
from tests.builders import MIDS, cubes, grid
from tests.meshing.measures import (
    Where,
    X,
    Y,
    Z,
    areas,
    body_volume,
    check_crack,
    faces_on,
    n_corners,
    normals,
    on,
    pieces,
    sides,
)  # fmt: skip

#: cell of the bulk, and of the crack
CRACK_CELLS = {
    "triangle": "quad", "triangle6": "quad8", "quad": "quad", "quad8": "quad8",
    "tetra": "wedge", "tetra10": "wedge15", "hexahedron": "hexahedron",
}  # fmt: skip

#                   paths, copies of corner nodes, unit lengths, pieces (4 x 4 unit squares)
LINES: dict[str, tuple[list[list[tuple[int, int]]], int, int, int]] = {
    "straight through": ([[(2, 0), (2, 4)]], 5, 4, 2),
    "tip inside": ([[(2, 0), (2, 3)]], 3, 3, 1),
    "both tips inside": ([[(2, 1), (2, 3)]], 1, 2, 1),
    "kink": ([[(2, 0), (2, 2), (4, 2)]], 5, 4, 2),
    "T-branch": ([[(0, 2), (4, 2)], [(2, 2), (2, 4)]], 8, 6, 3),
    "crossing": ([[(0, 2), (4, 2)], [(2, 0), (2, 4)]], 11, 8, 4),
    "crossing inside": ([[(1, 2), (3, 2)], [(2, 1), (2, 3)]], 3, 4, 1),
    "two parallel": ([[(1, 0), (1, 4)], [(3, 0), (3, 4)]], 10, 8, 3),
}

#               surfaces, copies of corner nodes, unit squares, pieces (4 x 4 x 4 unit cubes)
SURFACES: dict[str, tuple[list[tuple[Array, Where]], int, int, int]] = {
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

PLANE, SOLID = ["quad", "quad8", "triangle", "triangle6"], ["hexahedron", "tetra", "tetra10"]
CASES = [*((kind, case) for kind in PLANE for case in LINES), *((kind, case) for kind in SOLID for case in SURFACES)]


def uncut(kind: str) -> meshio.Mesh:
    """4 unit squares or cubes along each axis."""
    return grid(kind=kind) if kind in PLANE else cubes(kind)


def facets(mesh: meshio.Mesh, case: str) -> tuple[Index, int, int, int]:
    """Of the crack, with what is counted."""
    if mesh.points.shape[1] == 2:
        paths, *counts = LINES[case]
        return (edges_on_path(mesh, "crack", paths), *counts)
    surfaces, *counts = SURFACES[case]
    return (np.concatenate([faces_on(mesh, *surface) for surface in surfaces]), *counts)


@pytest.mark.parametrize(("kind", "case"), CASES)
def test_splitting(kind: str, case: str) -> None:
    mesh = uncut(kind)
    surface, copies, size, parts = facets(mesh, case)
    result = insert_cracks(mesh, surface)
    crack, original = result.cells[-1], result.point_data["original"]
    assert crack.type == CRACK_CELLS[kind]
    assert len(crack.data) == size * (2 if kind.startswith("tetra") else 1)
    is_corner = np.isin(original[len(mesh.points) :], mesh.cells[0].data[:, : n_corners(kind)])
    assert is_corner.sum() == copies
    if kind in PLANE:  # the mid-side node of every cut edge is doubled too
        assert (~is_corner).sum() == (size if kind in MIDS else 0)
    assert pieces(result) == parts
    assert [block.data.shape for block in result.cells[:-1]] == [block.data.shape for block in mesh.cells]
    np.testing.assert_array_equal(result.points, mesh.points[original])
    bulk = meshio.Mesh(result.points, result.cells[:-1])
    if kind in PLANE:
        assert sum(a.sum() for a in areas(bulk)) == pytest.approx(16)
    else:
        assert body_volume(bulk) == pytest.approx(64)
    area = normals(result, sides(crack)[0])
    assert np.linalg.norm(area, axis=1).sum() == pytest.approx(size)
    np.testing.assert_allclose(area, normals(mesh, surface))
    check_crack(result)
    for mid, a, b in MIDS.get(kind, []):  # no element lost a mid node: each still lies between its corners
        for block in result.cells[:-1]:
            middle = result.points[block.data[:, [a, b]]].mean(axis=1)
            np.testing.assert_allclose(result.points[block.data[:, mid]], middle)


def cut(mesh: meshio.Mesh, *paths: list[tuple[float, float]]) -> meshio.Mesh:
    return insert_cracks(mesh, edges_on_path(mesh, "crack", paths))


def test_the_plus_side_lies_to_the_left_of_the_path() -> None:
    up, down = cut(grid(), [(2, 0), (2, 4)]), cut(grid(), [(2, 4), (2, 0)])
    for mesh, side in ((up, -1), (down, 1)):
        plus = set(mesh.cells[-1].data[:, 2:].ravel())
        touching = [cell for cell in mesh.cells[0].data if plus & set(cell)]
        assert all(side * (mesh.points[cell].mean(axis=0)[0] - 2) > 0 for cell in touching)


@pytest.mark.parametrize("kind", ["tetra", "tetra10"])
def test_mid_nodes_are_doubled_but_on_the_front(kind: str) -> None:
    mesh = cubes(kind)
    result = insert_cracks(mesh, faces_on(mesh, *on(X, 2, (Y, 1, 3), (Z, 1, 3))))
    copied = mesh.points[result.point_data["original"][len(mesh.points) :]]
    inside = (copied[:, 1:] > 1) & (copied[:, 1:] < 3)
    assert inside.all() and (copied[:, 0] == 2).all()
    in_plane = (mesh.points[:, 0] == 2) & ((mesh.points[:, 1:] > 1) & (mesh.points[:, 1:] < 3)).all(axis=1)
    assert len(copied) == in_plane.sum()


def test_slits_are_cut_and_left_empty() -> None:
    mesh = grid()
    crack, slit = (edges_on_path(mesh, "path", [line]) for line in ([(2, 2), (2, 4)], [(2, 0), (2, 2)]))
    result = insert_cracks(mesh, crack, slit)
    assert len(result.cells[-1].data) == 2
    assert len(result.points) - len(mesh.points) == 5
    assert pieces(result) == 2


def test_point_sets_grow_by_the_copies() -> None:
    mesh = grid()
    mesh.point_sets = {"load": np.flatnonzero((mesh.points == [2, 4]).all(axis=1))}
    assert len(cut(mesh, [(2, 0), (2, 4)]).point_sets["load"]) == 2


def test_slits_half_and_sets_in_3d() -> None:
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


def test_half_needs_a_boundary_with_the_body_to_the_left() -> None:
    mesh = grid()
    assert len(mirror_cracks(mesh, edges_on_path(mesh, "crack", [[(4, 0), (4, 4)]])).points) == 25 + 5
    for wrong in ([(4, 4), (4, 0)], [(2, 0), (2, 4)]):
        with pytest.raises(MeshError, match="half body"):
            mirror_cracks(mesh, edges_on_path(mesh, "crack", [wrong]))


@pytest.mark.parametrize(
    ("paths", "message"),
    [
        ([[(2, 1), (2, 2)]], "cuts nothing"),
        ([[(0, 0), (0, 4)]], "along its boundary"),
        ([[(2, 0), (2, 6)]], "length 6 mm: 4 mm of it"),
        ([[(0.5, 0), (0.5, 4)]], "length 4 mm: 0 mm of it"),
        ([[(2, 0), (2, 0)]], "has length 0"),
        ([[(2, 0)]], "at least two points"),
        ([[(2, 0), (2, 4)], [(2, 1), (2, 3)]], "along a notch or along itself"),
    ],
)
def test_a_path_that_does_not_work_is_named(paths: list[list[tuple[float, float]]], message: str) -> None:
    with pytest.raises(MeshError, match=message):
        cut(grid(), *paths)


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


def test_the_front_ends_at_the_sides_of_the_body() -> None:
    """Half of a cube of 4 mm is cut: the front is 4 mm long, and the edges that lead to its ends are no part of it."""
    mesh = cubes("hexahedron")
    half = insert_cracks(mesh, faces_on(mesh, *on(Z, 2, (X, 0, 2), (Y, 0, 4))))
    assert crack_front_length(half) == pytest.approx(4.0)
    assert crack_front_length(cut(grid(), [(0.0, 2.0), (2.0, 2.0)])) == 0.0
