"""Splitting along faces, extruded specimens and the block with a plane crack."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import Any

import meshio
import numpy as np
import pytest
from numpy.typing import NDArray

from meshing import MeshError, MeshSizes, NotchedBeam, NotchedBeam3D, PushOff, PushOff3D, SingleCrack3D, insert_cracks
from meshing.cracks import cut_slits, mirror_cracks
from meshing.extrusion import with_mid_nodes
from meshing.star import FACES

from .test_meshing import pieces

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Where = Callable[[Array], NDArray[np.bool_]]

#: corners and mids of the faces of opened crack cells, normals inwards, and the part of them on the minus side
WEDGE = [(0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)]


def cubes(kind: str = "hexahedron", n: int = 4) -> meshio.Mesh:
    """Unit cubes (n x n x n) from the origin, or the six tetrahedra around the diagonal of each."""
    numbers = {p: i for i, p in enumerate(product(range(n + 1), repeat=3))}
    ring = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    cells = np.array([[numbers[tuple(np.add(o, r))] for r in ring] for o in product(range(n), repeat=3)])
    points = np.array(list(numbers), dtype=float)
    if kind == "hexahedron":
        return meshio.Mesh(points, [(kind, cells)])
    split = [(0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)]
    mesh = meshio.Mesh(points, [("tetra", cells[:, split].reshape(-1, 4))])
    return with_mid_nodes(mesh) if kind == "tetra10" else mesh


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


BEAMS: dict[str, dict[str, Any]] = {
    "slit": {"gauge": 20.0},
    "wide notch": {"notch_position": 20.0, "notch_width": 3.0, "gauge": 20.0},
    "bent": {"crack": [[0, 25], [4, 35], [4, 50]]},
}


def beams(name: str) -> tuple[NotchedBeam, NotchedBeam3D]:
    return tuple(kind(175, 125, 50, 40, 25, **BEAMS[name]) for kind in (NotchedBeam, NotchedBeam3D))  # type: ignore[return-value]


def check_extruded(flat: meshio.Mesh, solid: meshio.Mesh, layers: int, thickness: float) -> None:
    """Node by node: every level of the solid mesh is the plane mesh, with the same cells, copies, crack cells and sets."""
    of: dict[int, tuple[int, int]] = {}
    for plane, block in zip(flat.cells, solid.cells, strict=True):
        assert block.type == "hexahedron"
        ring = plane.data[:, [0, 1, 2, 3 if plane.type == "quad" else 2]]
        for k, cells in enumerate(np.split(block.data, layers)):
            for columns, level in (([3, 2, 6, 7], k), ([0, 1, 5, 4], k + 1)):
                for node, below in zip(cells[:, columns].ravel().tolist(), ring.ravel().tolist(), strict=True):
                    assert of.setdefault(node, (below, level)) == (below, level)
    assert set(of) == set(range(len(solid.points)))
    assert len(set(of.values())) == len(of) == len(flat.points) * (layers + 1)
    below, level = np.array([of[i] for i in range(len(of))]).T
    np.testing.assert_array_equal(solid.points[:, :2], flat.points[below])
    np.testing.assert_allclose(solid.points[:, 2], thickness * (level / layers - 0.5), atol=1e-12)
    # the copies of a node stay together: the same original in the plane and in its level
    m = flat.point_data["original"].max() + 1
    np.testing.assert_array_equal(solid.point_data["original"], flat.point_data["original"][below] + m * level)
    for name, nodes in flat.point_sets.items():
        assert set(solid.point_sets[name]) == set(np.flatnonzero(np.isin(below, nodes)))
    assert set(solid.point_sets["back"]) == set(np.flatnonzero(level == 0))
    assert set(solid.point_sets["front"]) == set(np.flatnonzero(level == layers))
    (pin,) = solid.point_sets["pin"]
    np.testing.assert_allclose(solid.points[pin], solid.points.min(axis=0), atol=1e-9)
    assert set(solid.cell_sets) == set(flat.cell_sets)
    for name, members in flat.cell_sets.items():
        assert [len(i) for i in solid.cell_sets[name]] == [layers * len(i) for i in members]


@pytest.mark.parametrize("name", BEAMS)
@pytest.mark.parametrize("layers", [1, 3])
def test_hexahedra_are_the_plane_mesh_extruded(name: str, layers: int) -> None:
    flat, solid = beams(name)
    sizes = MeshSizes(5.0, 12.0, "quad")
    mesh = solid.mesh(MeshSizes(5.0, 12.0, "quad", layers=layers))
    check_extruded(flat.mesh(sizes), mesh, layers, 40)
    check_crack(mesh)
    plane = flat.mesh(sizes)
    across = np.diff(plane.points[plane.cells[-1].data[:, :2]], axis=1)[:, 0] @ [[0, 1], [-1, 0]]
    area = np.tile(np.column_stack([across * 40 / layers, np.zeros(len(across))]), (layers, 1))
    np.testing.assert_allclose(normals(mesh, sides(mesh.cells[-1])[0]), area, atol=1e-9)
    body = solid.mesh_body(MeshSizes(5.0, 12.0, "quad", layers=layers))
    check_extruded(flat.mesh_body(sizes), body, layers, 40)


@pytest.mark.parametrize("shape", ["triangle", "quad"])
def test_bands_are_the_plane_mesh_extruded(shape: str) -> None:
    for flat, solid, width in ((*beams("slit"), 2.0), (PushOff(300, 300, 120), PushOff3D(300, 300, 120), 10.0)):
        sizes, volume = (MeshSizes(size, 30.0, shape, layers=3) for size in (width, 2 * width)), 0.0
        for size in sizes:
            mesh = solid.mesh_band(size, width)
            check_extruded(flat.mesh_band(MeshSizes(size.crack_size, 30.0, shape), width), mesh, 3, solid.thickness)
            band, (minus, plus) = mesh.cells[-1], sides(mesh.cells[-1])
            gap = mesh.points[plus] - mesh.points[minus]
            n = normals(mesh, minus)
            n /= np.linalg.norm(n, axis=1)[:, None]
            np.testing.assert_allclose(gap, np.broadcast_to(width * n[:, None], gap.shape), atol=1e-9)
            length = 25 if isinstance(flat, NotchedBeam) else 300
            volume = volumes(mesh.points, band.type, band.data).sum()
            assert volume == pytest.approx(width * length * solid.thickness)
            whole = 175 * 50 - 2 * 25 if isinstance(flat, NotchedBeam) else 300 * 300
            assert body_volume(mesh) == pytest.approx(whole * solid.thickness)
            assert mesh.cell_sets["row"] is mesh.cell_sets["band"] or len(mesh.cell_sets["row"][-1]) == len(band.data)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("name", BEAMS)
def test_tetrahedra_of_a_beam(name: str, order: int) -> None:
    flat, solid = beams(name)
    mesh = solid.mesh(MeshSizes(5.0, 12.0, order=order, layers=4))
    plane = flat.mesh(MeshSizes(5.0, 12.0))
    assert [b.type for b in mesh.cells] == [["tetra", "wedge"], ["tetra10", "wedge15"]][order - 1]
    assert [len(b.data) for b in mesh.cells] == [3 * 4 * len(plane.cells[0].data), 2 * 4 * len(plane.cells[1].data)]
    assert body_volume(mesh) == pytest.approx((175 * 50 - (75 if name == "wide notch" else 0)) * 40)
    area = normals(mesh, sides(mesh.cells[-1])[0])
    length = np.hypot(4, 10) + 15 if name == "bent" else 25
    assert np.linalg.norm(area, axis=1).sum() == pytest.approx(length * 40)
    assert (area[:, 0] < 0).all()
    check_crack(mesh)
    assert pieces(mesh) == 2
    n_lines = 5 if order == 1 else 9
    for set_name, nodes in plane.point_sets.items():
        assert len(mesh.point_sets[set_name]) == n_lines * len(nodes)
    # symmetric about the middle of the thickness: no diagonal prevails
    at = {tuple(p) for p in np.round(mesh.points[mesh.cells[0].data[:, :4]].mean(axis=1), 6).tolist()}
    assert at == {(x, y, -z + 0.0) for x, y, z in at}


@pytest.mark.parametrize("sizes", [MeshSizes(5.0, 12.0, "quad"), MeshSizes(5.0, 12.0, order=2)])
def test_half_a_beam(sizes: MeshSizes) -> None:
    _, solid = beams("slit")
    mesh = solid.mesh(sizes, half=True)
    assert body_volume(meshio.Mesh(mesh.points, mesh.cells[:-1])) == pytest.approx(175 * 50 * 40 / 2)
    area = normals(mesh, sides(mesh.cells[-1])[0])
    np.testing.assert_allclose(area.sum(axis=0), [-25 * 40, 0, 0], atol=1e-9)
    assert "gauge_plus" in mesh.point_sets and "gauge_minus" not in mesh.point_sets


def test_layers_are_as_thick_as_the_far_size_by_default() -> None:
    _, solid = beams("slit")
    for far, layers in ((12.0, 3), (100.0, 1), (8.0, 5)):
        assert len(np.unique(solid.mesh(MeshSizes(8.0, far, "quad")).points[:, 2])) == layers + 1


BLOCKS: dict[str, dict[str, Any]] = {
    "level": {},
    "turned": {"angle": 30.0},
    "turned and tilted": {"angle": 30.0, "tilt": 20.0, "gauge": 5.0},
    "through edges": {"angle": 45.0},
    "hexagon": {"angle": 45.0, "tilt": 35.26438968},
    "upright": {"tilt": 90.0},
    "strip": {"angle": 10.0, "tilt": 30.0, "crack_length": 20.0},
    "strip along the trace": {"angle": 90.0, "crack_width": 20.0},
    "rectangle": {"angle": 20.0, "tilt": 10.0, "crack_length": 12.0, "crack_width": 16.0},
    "penny": {"angle": 20.0, "tilt": -50.0, "crack_radius": 10.0, "gauge": 5.0},
}


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("name", BLOCKS)
def test_blocks(name: str, order: int) -> None:
    specimen = SingleCrack3D(40, 40, 40, **BLOCKS[name])
    mesh = specimen.mesh(MeshSizes(4.0, 10.0, order=order))
    n = specimen.normal
    a, t = np.radians([specimen.angle, specimen.tilt])
    np.testing.assert_allclose(n, [-np.sin(a) * np.cos(t), np.cos(a) * np.cos(t), np.sin(t)], atol=1e-12)
    assert body_volume(mesh) == pytest.approx(64e3)
    crack = mesh.cells[-1]
    area = normals(mesh, sides(crack)[0])
    size = np.linalg.norm(area, axis=1)
    np.testing.assert_allclose(area, size[:, None] * n, atol=1e-6)
    if name == "penny":  # an inscribed polygon
        assert 0.95 * specimen.crack_area < size.sum() < specimen.crack_area == np.pi * 100
    else:
        assert size.sum() == pytest.approx(specimen.crack_area)
    check_crack(mesh)
    # about equilateral triangles of the wanted size, in a small disc fewer than fit
    assert np.median(size) == pytest.approx(np.sqrt(3) / 4 * 4.0**2, rel=0.4)
    through = not {"crack_radius", "crack_length", "crack_width"} & set(BLOCKS[name])
    assert pieces(mesh) == (2 if through else 1)
    # the front inside the body is not divided, all other nodes of the surface are
    original = mesh.point_data["original"]
    nodes, copies = np.unique(original[np.unique(crack.data)], return_counts=True)
    u, v = (abs(mesh.points[nodes] @ axis) for axis in (specimen.crack.along, specimen.crack.across))
    if specimen.crack_radius:  # mid nodes of the front lie inside the circle
        on_front = copies == 1
        assert (np.hypot(u, v)[on_front] > 9.5).all() and (np.hypot(u, v)[~on_front] < 9.5).all()
    else:
        length, width = specimen.crack_length or np.inf, specimen.crack_width or np.inf
        np.testing.assert_array_equal(copies, np.where((u > length / 2 - 1e-9) | (v > width / 2 - 1e-9), 1, 2))
    # sets
    for key, axis, at in (("base", 1, -20), ("top", 1, 20), ("back", 2, -20), ("front", 2, 20)):
        assert set(mesh.point_sets[key]) == set(np.flatnonzero(abs(mesh.points[:, axis] - at) < 1e-6))
    np.testing.assert_allclose(mesh.points[mesh.point_sets["base_corner"], :2], -20)
    np.testing.assert_allclose(mesh.points[mesh.point_sets["pin"]], -20)
    if specimen.gauge:
        for key, sign in (("gauge_minus", -1), ("gauge_plus", 1)):
            np.testing.assert_allclose(mesh.points[mesh.point_sets[key]], [sign * 2.5 * n], atol=1e-9)


def test_a_block_without_its_crack() -> None:
    mesh = SingleCrack3D(40, 40, 40, crack_radius=10.0).mesh_body(MeshSizes(3.0, 10.0, order=2))
    assert [b.type for b in mesh.cells] == ["tetra10"]
    assert body_volume(mesh) == pytest.approx(64e3)
    np.testing.assert_array_equal(mesh.point_data["original"], np.arange(len(mesh.points)))
    assert list(mesh.cell_sets) == ["body"]
    near = abs(mesh.points[mesh.cells[0].data[:, :4]].mean(axis=1)) < [5, 5, 5]
    v = volumes(mesh.points, "tetra10", mesh.cells[0].data)
    assert 3 * v[near.all(axis=1)].mean() < v.mean()  # fine where the crack would be


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"thickness": 0.0}, "thickness = 0.0: expected a number above 0"),
        ({"gauge": -1.0}, "gauge = -1.0: expected a number of at least 0"),
        ({"gauge": 40.0}, "gauge = 40.0: expected less than width, height and thickness"),
        ({"angle": -90.0}, "angle = -90.0: expected above -90 and at most 90 degrees"),
        ({"tilt": 91.0}, "tilt = 91.0: expected above -90 and at most 90 degrees"),
        ({"faces": "glued"}, "faces = 'glued': expected 'free' or 'clamped'"),
        ({"crack_radius": 0.0}, "crack_radius = 0.0: expected above 0 and below 20, to end inside the block"),
        ({"crack_radius": 20.0}, "crack_radius = 20.0: expected above 0 and below 20, to end inside the block"),
        ({"crack_radius": 5.0, "crack_length": 5.0}, "crack_length = 5.0: expected none beside crack_radius = 5"),
        ({"crack_length": 40.0}, "crack_length = 40.0: expected above 0 and below 40, to end inside the block"),
        ({"crack_width": -1.0}, "crack_width = -1.0: expected above 0 and below 40, to end inside the block"),
        (
            {"angle": 45.0, "tilt": 90.0, "crack_length": 30.0, "crack_width": 28.0},
            "crack_length = 30.0: expected above 0 and",
        ),
    ],
)
def test_keys_of_a_block_that_do_not_work_are_named(keys: dict[str, Any], message: str) -> None:
    with pytest.raises(MeshError, match=message):
        SingleCrack3D(**{"width": 40, "height": 40, "thickness": 40, **keys})


def test_sizes_that_do_not_work_are_named() -> None:
    with pytest.raises(ValueError, match="layers = 0: expected a whole number of at least 1"):
        MeshSizes(1.0, 2.0, layers=0)
    flat, solid = beams("slit")
    block = SingleCrack3D(40, 40, 40)
    layered = MeshSizes(5.0, 12.0, layers=2)
    cases: list[tuple[Callable[[], object], str]] = [
        (lambda: flat.mesh(layered), "mesh.layers = 2: this specimen is not extruded"),
        (lambda: flat.mesh_band(layered, 2.0), "mesh.layers = 2: this specimen is not extruded"),
        (lambda: flat.mesh_body(layered), "mesh.layers = 2: this specimen is not extruded"),
        (lambda: block.mesh(layered), "mesh.layers = 2: this specimen is not extruded"),
        (lambda: block.mesh(MeshSizes(5.0, 12.0, "quad")), "mesh.shape = 'quad': this specimen is of tetrahedra"),
        (
            lambda: block.mesh(MeshSizes(0.01, 12.0)),
            r"mesh.crack_size = 0.01: 1.6e\+07 elements on the crack; expected at least",
        ),
        (
            lambda: block.mesh(MeshSizes(0.2, 0.2)),
            "mesh.far_size = 0.2: 8e.06 elements in the body; expected at least 0.23 mm",
        ),
        (lambda: block.mesh_band(MeshSizes(5.0, 12.0), 2.0), "band.where = 'path': there is no crack band for a crack at any"),
        (lambda: solid.mesh(MeshSizes(5.0, 12.0, "quad", 2)), "mesh.order = 2: hexahedra are of first order"),
        (lambda: solid.mesh_body(MeshSizes(5.0, 12.0, "quad", 2)), "mesh.order = 2: hexahedra are of first order"),
        (lambda: solid.mesh_band(MeshSizes(5.0, 12.0, order=2), 2.0), "mesh.order = 2: the elements of a crack band in three"),
        (lambda: solid.mesh(MeshSizes(5.0, 12.0, layers=10**6)), "mesh.layers = 1000000: .* elements in the body, .* in each"),
    ]
    for make, message in cases:
        with pytest.raises(MeshError, match=message):
            make()
    for make in (lambda: NotchedBeam3D(175, 125, 50, 0, 25), lambda: PushOff3D(300, 300, 0)):
        with pytest.raises(MeshError, match="thickness = 0: expected a number above 0"):
            make()
