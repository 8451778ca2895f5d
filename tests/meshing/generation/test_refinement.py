"""Large meshes whose cells are divided: areas, sets, paths, curved outlines, and when they are."""

import meshio
import numpy as np
import pytest

from meshing.generation import refinement
from meshing.generation.outline import Outline
from meshing.generation.polygon import mesh_face, mesh_polygon
from meshing.generation.refinement import halved, halvings
from meshing.generation.session import collect_halved, session
from meshing.generation.sizes import MeshSizes

#: a plate with a notch slit, an inclined path and a named point and edge
PLATE = Outline(
    [(0.0, 0.0), (60.0, 0.0), (60.0, 40.0), (0.0, 40.0)],
    [[(20.0, 10.0), (25.0, 25.0), (24.0, 40.0)]],
    [[(20.0, 0.0), (20.0, 10.0)]],
    {"gauge": [(40.0, 40.0)]},
    {"base": [(0.0, 0.0), (60.0, 0.0)]},
)


def area(points, cells):
    corners = points[cells[:, :4] if cells.shape[1] in (4, 8) else cells[:, :3]]
    x, y = corners[..., 0], corners[..., 1]
    return 0.5 * (x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1)


@pytest.fixture
def soon(monkeypatch):
    """Meshes are divided from 100 nodes on: calling it says so."""
    return lambda: monkeypatch.setattr(refinement, "WHOLE_UP_TO", 100)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("shape", ["triangle", "quad"])
def test_a_divided_mesh_is_one_that_gmsh_might_have_made(soon, shape, order):
    sizes = MeshSizes(0.5, 1.0, shape, order)
    mesh = mesh_polygon(PLATE, sizes)
    soon()
    assert halvings(PLATE, sizes) == 2
    divided = mesh_polygon(PLATE, sizes)
    assert [block.type for block in divided.cells] == [block.type for block in mesh.cells]
    bulk = divided.cells[0].data
    assert np.unique(bulk).size == len(divided.points)  # every node is used
    areas = area(divided.points, bulk)
    assert areas.min() > 0
    assert areas.sum() == pytest.approx(2400.0, rel=1e-12)
    # sizes near and far are those of gmsh's own mesh: the number of cells along the path to 5 %. In all there are more, since
    # sizes grow over fewer coarse cells: by 61 % here with 74 quadrilaterals, by 11 % where meshes are divided without a test
    assert len(divided.cells[-1].data) == pytest.approx(len(mesh.cells[-1].data), rel=0.05)
    assert 0.9 < len(bulk) / len(mesh.cells[0].data) < 1.7
    assert (divided.points[divided.point_sets["gauge"]] == [[40.0, 40.0]]).all()
    base = divided.points[divided.point_sets["base"]]
    assert (base[:, 1] == 0).all()
    assert np.diff(np.sort(base[:, 0])).max() < 3.0  # no node is left out
    if order == 2:  # mid nodes stand in the middle of their edges
        n = bulk.shape[1] // 2
        ends = divided.points[bulk[:, :n]]
        assert divided.points[bulk[:, n:]] == pytest.approx(0.5 * (ends + np.roll(ends, -1, axis=1)), abs=1e-12)


def test_small_meshes_and_coarse_paths_are_left_to_gmsh():
    assert halvings(PLATE, MeshSizes(0.5, 2.0)) == 0
    assert halvings(PLATE, MeshSizes(0.2, 0.3)) == 1
    assert halvings(PLATE, MeshSizes(0.05, 0.2)) == 2
    kinked = [(20.0, 10.0 + 0.5 * i) for i in range(61)]  # of its segments each takes two elements
    assert halvings(Outline(PLATE.corners, [kinked]), MeshSizes(0.25, 0.25)) == 0


def test_neighbours_share_the_nodes_of_their_edge():
    points = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [2.0, 0.5]])
    mesh = meshio.Mesh(points, [("quad", np.array([[0, 1, 2, 3]])), ("triangle", np.array([[1, 4, 2]]))])
    fine = halved(mesh, {}, lambda tag, at: at, 1)
    assert [len(block.data) for block in fine.cells] == [4, 4]
    assert len(fine.points) == 5 + 6 + 1  # corners, middles of edges, the centre of the quadrilateral
    assert len(np.unique(fine.points, axis=0)) == len(fine.points)


@pytest.mark.parametrize("order", [1, 2])
def test_new_nodes_of_a_curved_outline_lie_on_it(order):
    with session() as gmsh:
        gmsh.model.occ.addDisk(0, 0, 0, 10.0, 10.0)
        gmsh.model.occ.synchronize()
        gmsh.option.setNumber("Mesh.MeshSizeMax", 3.0)
        gmsh.model.mesh.generate(2)
        mesh = collect_halved(gmsh, 2, order)
    cells = mesh.cells[0].data[:, :3]
    edges = np.sort(np.concatenate([cells[:, [0, 1]], cells[:, [1, 2]], cells[:, [2, 0]]]), axis=1)
    edges, uses = np.unique(edges, axis=0, return_counts=True)
    rim = edges[uses == 1]
    assert np.hypot(*mesh.points[rim].reshape(-1, 2).T) == pytest.approx(10.0, rel=1e-9)
    # a polygon with n sides has the area of the circle but for (2 pi/n)^2/6; projected nodes are nearly evenly spaced
    missing = 1 - area(mesh.points, cells).sum() / (np.pi * 100.0)
    assert missing == pytest.approx((2 * np.pi / len(rim)) ** 2 / 6, rel=0.05)
    if order == 2:
        radius = np.hypot(*mesh.points.T)
        assert np.count_nonzero(abs(radius - 10.0) < 1e-9) == 2 * len(rim)


def test_a_face_that_is_divided_keeps_its_path(soon):
    soon()
    mesh = mesh_face(PLATE, MeshSizes(0.5, 2.0), conforming=False)  # fine near the path, not aligned with it
    near = np.hypot(*(mesh.points - (25.0, 25.0)).T) < 2.0
    far = mesh.points[:, 0] > 50.0
    assert near.sum() / (np.pi * 4.0) > 5 * far.sum() / 400.0


@pytest.mark.parametrize("hinge", [(24.0, 40.0), (-24.0, 40.0), (-24.0, -40.0), (-1e-16, 40.0)])
def test_the_size_at_a_hinge_is_the_same_wherever_the_body_lies(hinge):
    """A negative coordinate, or one that rounding has left, is a number for gmsh too, which ends the process for `x - -24`."""
    x, y = hinge[0] - 24.0, hinge[1] - 40.0
    corners = [(x, y), (60.0 + x, y), (60.0 + x, 40.0 + y), (x, 40.0 + y)]
    plate = Outline(corners, [[(20.0 + x, 10.0 + y), hinge]], [[(20.0 + x, y), (20.0 + x, 10.0 + y)]], hinges=[hinge])
    mesh = mesh_polygon(plate, MeshSizes(2.0, 8.0, "triangle", 1))
    distance = np.sort(np.hypot(*(mesh.points - hinge).T))
    assert distance[distance > 1e-9][0] < 0.5 and abs(area(mesh.points, mesh.cells[0].data).sum() - 2400.0) < 1e-6
