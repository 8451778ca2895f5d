"""Specimens in three dimensions: extruded ones, node by node, and the block with a plane crack."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import meshio
import numpy as np
import pytest

from meshing import MeshError, MeshSizes, NotchedBeam, PlaneSpecimen, PushOff, SingleCrack, SingleCrack3D
from meshing.generation.block import facing
from tests.meshing.measures import body_volume, check_crack, normals, pieces, sides, volumes

BEAMS: dict[str, dict[str, Any]] = {
    "slit": {"gauge": 20.0},
    "wide notch": {"notch_position": 20.0, "notch_width": 3.0, "gauge": 20.0},
    "bent": {"crack": [[0, 25], [4, 35], [4, 50]]},
}
BRANCHED = {"crack": [[[0, 25], [0, 50]], [[0, 35], [10, 50]]]}


class Extruded:
    """A plane specimen as it is meshed in three dimensions."""

    def __init__(self, flat: PlaneSpecimen) -> None:
        self.mesh = partial(flat.mesh, dimension=3)
        self.mesh_band = partial(flat.mesh_band, dimension=3)
        self.mesh_body = partial(flat.mesh_body, dimension=3)
        self.check_band = partial(flat.check_band, dimension=3)
        self.thickness = flat.thickness


def beams(name: str) -> tuple[NotchedBeam, Extruded]:
    flat = NotchedBeam(175, 125, 50, 40, 25, **BEAMS.get(name, BRANCHED))
    return flat, Extruded(flat)


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


@pytest.mark.parametrize("name", [*BEAMS, "branched"])
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


#               plane and solid specimen, width of the band, area of the body with its opened notch, length of the path
BANDS: dict[str, tuple[Any, Any, float, float, float]] = {
    "beam": (*beams("slit"), 2.0, 175 * 50 - 2 * 25, 25),
    "bent": (*beams("bent"), 2.0, 175 * 50 - 2 * 25, np.hypot(4, 10) + 15),
    "push-off": (PushOff(300, 300, 120), Extruded(PushOff(300, 300, 120)), 10.0, 300 * 300, 300),
}


@pytest.mark.parametrize("shape", ["triangle", "quad"])
@pytest.mark.parametrize("name", BANDS)
def test_bands_are_the_plane_mesh_extruded(name: str, shape: str) -> None:
    flat, solid, width, area, length = BANDS[name]
    mesh = solid.mesh_band(MeshSizes(2 * width, 30.0, shape, layers=3), width)
    check_extruded(flat.mesh_band(MeshSizes(2 * width, 30.0, shape), width), mesh, 3, solid.thickness)
    assert body_volume(mesh) == pytest.approx(area * solid.thickness)
    band = mesh.cells[-1]
    if name != "bent":  # the two sides of a mitre differ in length
        assert volumes(mesh.points, band.type, band.data).sum() == pytest.approx(width * length * solid.thickness)
    assert [len(i) for i in mesh.cell_sets["row"]] == [*(0 for _ in mesh.cells[:-1]), len(band.data)]
    # minus face first, plus face a width away along its normal
    minus, plus = sides(band)
    n = normals(mesh, minus)
    n /= np.linalg.norm(n, axis=1)[:, None]
    np.testing.assert_allclose(((mesh.points[plus] - mesh.points[minus]) * n[:, None]).sum(axis=2), width, rtol=1e-9)


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


def test_tetrahedra_without_the_crack_are_cut_along_the_notch() -> None:
    mesh = beams("slit")[1].mesh_body(MeshSizes(5.0, 12.0, order=2, layers=2))
    assert [b.type for b in mesh.cells] == ["tetra10"]
    assert body_volume(mesh) == pytest.approx(175 * 50 * 40)
    copied = mesh.points[mesh.point_data["original"].max() + 1 :]
    assert len(copied) and (abs(copied[:, 0]) < 1e-9).all() and (copied[:, 1] < 25 - 1e-6).all()


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


@pytest.mark.parametrize("shape", [{"crack_radius": 15.0}, {}, {"crack_length": 30.0, "crack_width": 26.0}])
def test_a_penny_shaped_notch(shape: dict[str, Any]) -> None:
    keys = {"angle": 20.0, "tilt": 10.0, "notch_radius": 8.0} | shape
    whole, notched = SingleCrack3D(40, 40, 40, **keys | {"notch_radius": 0.0}), SingleCrack3D(40, 40, 40, **keys)
    assert notched.crack_area == pytest.approx(whole.crack_area - np.pi * 64)
    mesh = notched.mesh(MeshSizes(3.0, 10.0))
    assert body_volume(mesh) == pytest.approx(64e3)
    check_crack(mesh)
    corners, _ = sides(mesh.cells[-1])
    area = normals(mesh, corners)
    size = np.linalg.norm(area, axis=1)
    np.testing.assert_allclose(area, size[:, None] * notched.normal, atol=1e-6)
    # both circles are polygons of edges of 3 mm: (3 / 8)^2 / 6 of the disc of 8 mm are missing
    assert size.sum() == pytest.approx(notched.crack_area, rel=0.04)
    assert (np.linalg.norm(mesh.points[corners].mean(axis=1), axis=1) > 7.5).all()
    # both sides of the notch are free: its nodes are doubled as those of the crack are
    _, first, copies = np.unique(mesh.point_data["original"], return_index=True, return_counts=True)
    at = mesh.points[first]
    inside = (abs(at @ notched.normal) < 1e-6) & (np.linalg.norm(at, axis=1) < 8.1)
    assert inside.sum() > 10 and (copies[inside] == 2).all()
    assert pieces(mesh) == (1 if shape else 2)
    anywhere = notched.mesh_body(MeshSizes(3.0, 10.0))
    copied = anywhere.points[anywhere.point_data["original"].max() + 1 :]
    assert [b.type for b in anywhere.cells] == ["tetra"] and len(copied)
    assert (abs(copied @ notched.normal) < 1e-6).all() and (np.linalg.norm(copied, axis=1) < 7.9).all()


def test_a_block_without_its_crack() -> None:
    mesh = SingleCrack3D(40, 40, 40, crack_radius=10.0).mesh_body(MeshSizes(3.0, 10.0, order=2))
    assert [b.type for b in mesh.cells] == ["tetra10"]
    assert body_volume(mesh) == pytest.approx(64e3)
    np.testing.assert_array_equal(mesh.point_data["original"], np.arange(len(mesh.points)))
    assert list(mesh.cell_sets) == ["body"]
    near = abs(mesh.points[mesh.cells[0].data[:, :4]].mean(axis=1)) < [5, 5, 5]
    v = volumes(mesh.points, "tetra10", mesh.cells[0].data)
    assert 3 * v[near.all(axis=1)].mean() < v.mean()  # fine where the crack would be


def test_triangles_face_the_plus_side() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])
    turned = facing(points, np.array([[0, 1, 2], [1, 2, 3]]), np.array([0.0, 0, 1]))
    np.testing.assert_array_equal(turned, [[0, 1, 2], [3, 2, 1]])


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"thickness": 0.0}, "thickness = 0.0: expected a number above 0"),
        ({"gauge": -1.0}, "gauge = -1.0: expected a number of at least 0"),
        ({"gauge": 40.0}, "gauge = 40.0: expected less than width, height and thickness"),
        ({"angle": -90.0}, "angle = -90.0: expected a number above -90 and at most 90, in degrees"),
        ({"tilt": 91.0}, "tilt = 91.0: expected a number above -90 and at most 90, in degrees"),
        ({"faces": "glued"}, "faces = 'glued': expected 'free' or 'clamped'"),
        ({"crack_radius": 0.0}, "crack_radius = 0.0: expected above 0 and below 20, to end inside the block"),
        ({"crack_radius": 20.0}, "crack_radius = 20.0: expected above 0 and below 20, to end inside the block"),
        ({"crack_radius": 5.0, "crack_length": 5.0}, "crack_length = 5.0: expected none beside crack_radius = 5"),
        ({"notch_radius": -1.0}, "notch_radius = -1.0: expected a number of at least 0"),
        ({"notch_radius": 20.0}, "notch_radius = 20.0: expected at least 0 and below 20, to end inside the crack"),
        ({"crack_radius": 5.0, "notch_radius": 5.0}, "notch_radius = 5.0: expected at least 0 and below 5, to end inside"),
        ({"crack_width": 9.0, "notch_radius": 5.0}, "notch_radius = 5.0: expected at least 0 and below 4.5, to end inside"),
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
    with pytest.raises(ValueError, match="layers = 0: expected a number of at least 1"):
        MeshSizes(1.0, 2.0, layers=0)
    with pytest.raises(ValueError, match=r"layers = 2\.5: expected a whole number of at least 1"):
        MeshSizes(1.0, 2.0, layers=2.5)  # type: ignore[arg-type]
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
        (lambda: block.mesh(MeshSizes(0.1, 12.0)), r"mesh.crack_size = 0.1: 1.6e\+05 elements on the crack; .* 0.13 mm"),
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
    for make in (lambda: NotchedBeam(175, 125, 50, 0, 25), lambda: PushOff(300, 300, 0)):
        with pytest.raises(MeshError, match="thickness = 0: expected a number above 0"):
            make()


@pytest.mark.parametrize("kind", [SingleCrack, SingleCrack3D])
def test_a_block_is_held_along_and_across_its_drive(kind: type[SingleCrack | SingleCrack3D]) -> None:
    """At 30 degrees to the normal of the top face; the directions stand at right angles."""
    axes = np.array(kind(40.0, 30.0, 10.0, drive_angle=30.0).drive_directions)
    np.testing.assert_allclose(axes @ axes.T, np.eye(len(axes)), atol=1e-15)
    np.testing.assert_allclose(axes[0, :2], [0.5, np.sqrt(0.75)])
