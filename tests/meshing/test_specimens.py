"""Splitting by node stars, specimens, and reading a user's mesh."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from cohesive.elements.bulk import ElasticBlock, elasticity
from meshing import MeshError, MeshSizes, NotchedBeam, NotchedTension, SingleCrack, insert_cracks, mesh_polygon, read_mesh
from meshing.cracks import edges_on_path, mirror_cracks
from tests.builders import grid

Index = NDArray[np.int64]


def cut(mesh: meshio.Mesh, *paths: list[tuple[float, float]]) -> meshio.Mesh:
    return insert_cracks(mesh, edges_on_path(mesh, "crack", paths))


def pieces(mesh: meshio.Mesh) -> int:
    """Connected parts of the bulk, from connectivity alone."""
    rows, columns = [], []
    for block in mesh.cells[:-1]:
        rows.append(np.repeat(block.data[:, 0], block.data.shape[1]))
        columns.append(block.data.ravel())
    r, c = np.concatenate(rows), np.concatenate(columns)
    graph = sp.coo_array((np.ones(len(r)), (r, c)), shape=(len(mesh.points),) * 2)
    return int(connected_components(graph, directed=False)[0])


#                   paths, copies made, crack cells, pieces (4 x 4 unit squares)
CASES = {
    "straight through": ([[(2, 0), (2, 4)]], 5, 4, 2),
    "tip inside": ([[(2, 0), (2, 3)]], 3, 3, 1),
    "both tips inside": ([[(2, 1), (2, 3)]], 1, 2, 1),
    "kink": ([[(2, 0), (2, 2), (4, 2)]], 5, 4, 2),
    "T-branch": ([[(0, 2), (4, 2)], [(2, 2), (2, 4)]], 8, 6, 3),
    "crossing": ([[(0, 2), (4, 2)], [(2, 0), (2, 4)]], 11, 8, 4),
    "crossing inside": ([[(1, 2), (3, 2)], [(2, 1), (2, 3)]], 3, 4, 1),
    "two parallel": ([[(1, 0), (1, 4)], [(3, 0), (3, 4)]], 10, 8, 3),
}


@pytest.mark.parametrize("kind", ["quad", "quad8", "triangle", "triangle6"])
@pytest.mark.parametrize("case", CASES)
def test_splitting(case: str, kind: str) -> None:
    paths, copies, cells, parts = CASES[case]
    mesh = grid(kind=kind)
    result = cut(mesh, *paths)
    crack = result.cells[-1]
    second_order = kind in ("quad8", "triangle6")
    assert crack.type == ("quad8" if second_order else "quad")
    assert len(crack.data) == cells
    # the mid-side node of every cut edge is doubled too
    assert len(result.points) - len(mesh.points) == copies + (cells if second_order else 0)
    assert pieces(result) == parts
    assert [block.data.shape for block in result.cells[:-1]] == [block.data.shape for block in mesh.cells]
    # the two sides coincide, and copy the same nodes
    a, b, c, d = crack.data[:, :4].T
    original = result.point_data["original"]
    for minus, plus in ((a, d), (b, c)):
        np.testing.assert_array_equal(result.points[minus], result.points[plus])
        np.testing.assert_array_equal(original[minus], original[plus])
    np.testing.assert_array_equal(result.points, mesh.points[original])
    # minus and plus faces are edges of the bulk, on opposite sides of the crack
    for low, high, sign in ((a, b, -1.0), (d, c, 1.0)):
        for first, last in zip(low, high, strict=True):
            (owner,) = [cell for block in result.cells[:-1] for cell in block.data if first in cell and last in cell]
            p, q = result.points[first], result.points[last]
            normal = np.array([-(q - p)[1], (q - p)[0]])
            n_corners = 3 if kind.startswith("triangle") else 4
            assert sign * (result.points[owner[:n_corners]].mean(axis=0) - p) @ normal > 0


def test_the_plus_side_lies_to_the_left_of_the_path() -> None:
    up, down = cut(grid(), [(2, 0), (2, 4)]), cut(grid(), [(2, 4), (2, 0)])
    for mesh, side in ((up, -1), (down, 1)):
        plus = set(mesh.cells[-1].data[:, 2:].ravel())
        touching = [cell for cell in mesh.cells[0].data if plus & set(cell)]
        assert all(side * (mesh.points[cell].mean(axis=0)[0] - 2) > 0 for cell in touching)


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


def test_half_needs_a_boundary_with_the_body_to_the_left() -> None:
    mesh = grid()
    assert len(mirror_cracks(mesh, edges_on_path(mesh, "crack", [[(4, 0), (4, 4)]])).points) == 25 + 5
    for wrong in ([(4, 4), (4, 0)], [(2, 0), (2, 4)]):
        with pytest.raises(MeshError, match="half body"):
            mirror_cracks(mesh, edges_on_path(mesh, "crack", [wrong]))


SPECIMENS = {
    "beam": (NotchedBeam(175, 125, 50, 50, 25, gauge=20.0), 175 * 50, 25),
    "eccentric, wide notch": (
        NotchedBeam(175, 125, 50, 50, 25, notch_position=20, notch_width=3, gauge=20.0),
        175 * 50 - 75,
        25,
    ),
    "bent path": (NotchedBeam(175, 125, 50, 50, 20, crack=[[0, 20], [4, 35], [4, 50]]), 175 * 50, np.hypot(4, 15) + 15),
    "double": (NotchedTension(120, 60, 50, 10, gauge=35.0), 120 * 60, 40),
    "double, wide": (NotchedTension(120, 60, 50, 10, notch_width=4, gauge=35.0), 120 * 60 - 80, 40),
    "single": (NotchedTension(120, 60, 50, 10, "single", 4, gauge=35.0), 120 * 60 - 40, 50),
    "block": (SingleCrack(40, 30, 10, angle=30), 1200, 40 / np.cos(np.radians(30))),
    "block, tips inside": (SingleCrack(40, 30, 10, angle=-70, crack_length=12, rotation=33, gauge=4), 1200, 12),
    "block, upright": (SingleCrack(40, 30, 10, angle=90), 1200, 30),
}


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("shape", ["triangle", "quad"])
@pytest.mark.parametrize("name", SPECIMENS)
def test_specimens(name: str, shape: str, order: int) -> None:
    specimen, area, crack = SPECIMENS[name]
    mesh = specimen.mesh(MeshSizes(2.0, 8.0, shape, order))
    blocks = [ElasticBlock(b.type, mesh.points, b.data, elasticity(1, 0, "stress"), 1.0) for b in mesh.cells[:-1]]
    assert sum(block.volumes().sum() for block in blocks) == pytest.approx(area, rel=1e-9)
    minus = mesh.cells[-1].data[:, :2]
    lengths = np.linalg.norm(mesh.points[minus[:, 1]] - mesh.points[minus[:, 0]], axis=1)
    assert lengths.sum() == pytest.approx(crack, rel=1e-9)
    assert lengths.max() < 1.35 * 2.0  # gmsh divides every piece evenly
    if shape == "quad":
        assert [b.type for b in mesh.cells[:-1]] == ["quad" if order == 1 else "quad8"]
    assert all(len(nodes) for nodes in mesh.point_sets.values())


@pytest.mark.parametrize("name", ["beam", "double", "single", "double, wide"])
def test_half_specimens(name: str) -> None:
    specimen, area, crack = SPECIMENS[name]
    mesh = specimen.mesh(MeshSizes(2.0, 8.0), half=True)
    block = ElasticBlock("triangle", mesh.points, mesh.cells[0].data, elasticity(1, 0, "stress"), 1.0)
    assert block.volumes().sum() == pytest.approx(area / 2, rel=1e-9)
    minus = mesh.points[mesh.cells[-1].data[:, :2]]
    assert np.linalg.norm(minus[:, 1] - minus[:, 0], axis=1).sum() == pytest.approx(crack, rel=1e-9)
    assert len(mesh.point_sets["load" if name == "beam" else "top"]) >= 2


def test_a_point_outside_the_body_is_named() -> None:
    with pytest.raises(MeshError, match=r"load = \(9, 9\): expected a point of the body"):
        mesh_polygon([(0, 0), (4, 0), (4, 4), (0, 4)], [[(2, 0), (2, 4)]], MeshSizes(1, 1), nodes={"load": [(9, 9)]})


@pytest.mark.parametrize("format", ["msh", "vtu", "inp"])
def test_a_users_mesh_with_a_polyline(tmp_path: Path, format: str) -> None:
    path = tmp_path / f"plate.{format}"
    plate = grid(kind="triangle")
    plate.points = np.column_stack([plate.points, np.zeros(len(plate.points))])
    plate.write(path)
    mesh = read_mesh(path, [[(2, 0), (2, 4)]])
    assert len(mesh.cells[-1].data) == 4
    assert pieces(mesh) == 2


def with_sets(path: Path) -> Path:
    """A gmsh file with physical groups for body, crack and base."""
    plate = grid(kind="quad")
    lines = edges_on_path(plate, "crack", [[(2, 0), (2, 4)]])
    base = edges_on_path(plate, "base", [[(0, 0), (4, 0)]])
    mesh = meshio.Mesh(
        np.column_stack([plate.points, np.zeros(len(plate.points))]),
        [("quad", plate.cells[0].data), ("line", np.concatenate([lines[:, ::-1], base]))],
        field_data={"body": np.array([1, 2]), "fault": np.array([2, 1]), "base": np.array([3, 1])},
        cell_data={key: [np.ones(16, dtype=int), np.repeat([2, 3], 4)] for key in ("gmsh:physical", "gmsh:geometrical")},
    )
    meshio.write(path, mesh, file_format="gmsh22", binary=False)
    return path


def test_a_users_mesh_with_a_named_set(tmp_path: Path) -> None:
    mesh = read_mesh(with_sets(tmp_path / "plate.msh"), "fault")
    assert len(mesh.cells[-1].data) == 4
    assert len(mesh.point_sets["base"]) == 6  # 5 nodes, one of them doubled
    assert pieces(mesh) == 2


def test_a_users_mesh_with_a_node_set(tmp_path: Path) -> None:
    plate = grid(kind="quad")
    plate.points = np.column_stack([plate.points, np.zeros(len(plate.points))])
    plate.point_sets = {"FAULT": np.flatnonzero(plate.points[:, 0] == 2)}
    plate.write(tmp_path / "plate.inp")
    mesh = read_mesh(tmp_path / "plate.inp", "FAULT")
    assert len(mesh.cells[-1].data) == 4
    assert pieces(mesh) == 2


def test_a_users_mesh_that_does_not_work_is_named(tmp_path: Path) -> None:
    path = with_sets(tmp_path / "plate.msh")
    with pytest.raises(MeshError, match="crack = 'crack': the file has no such set; it has base, body, fault"):
        read_mesh(path, "crack")
    with pytest.raises(MeshError, match="there is no such file"):
        read_mesh(tmp_path / "none.msh", "fault")
    (tmp_path / "text.msh").write_text("nothing")
    with pytest.raises(MeshError, match=r"cannot read it|not a mesh"):
        read_mesh(tmp_path / "text.msh", "fault")
    (tmp_path / "text.doc").write_text("nothing")
    with pytest.raises(MeshError, match=r"cannot read it|not a mesh"):
        read_mesh(tmp_path / "text.doc", "fault")
    plate = grid()
    solid = np.column_stack([plate.points, plate.points[:, 0]])
    meshio.Mesh(solid, plate.cells).write(tmp_path / "solid.vtu")
    with pytest.raises(MeshError, match="expected a plane mesh"):
        read_mesh(tmp_path / "solid.vtu", "fault")
    meshio.Mesh(solid * [1, 1, 0], [("line", np.array([[0, 1]]))]).write(tmp_path / "line.vtu")
    with pytest.raises(MeshError, match="its cells are line; expected triangle"):
        read_mesh(tmp_path / "line.vtu", "fault")
    broken = solid * [1, 1, 0]
    broken[3, 0] = np.nan
    meshio.Mesh(broken, plate.cells).write(tmp_path / "broken.vtu")
    with pytest.raises(MeshError, match="node 3 is not finite"):
        read_mesh(tmp_path / "broken.vtu", "fault")
