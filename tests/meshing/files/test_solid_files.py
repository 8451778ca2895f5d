"""A user's own solid mesh, cut along a named surface."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from numpy.typing import NDArray

from meshing import MeshError, read_band_mesh, read_mesh
from meshing.cutting.orientation import flipped
from meshing.files.defects import check_elements
from meshing.generation.refinement import with_mid_nodes
from meshing.generation.session import session
from tests.builders import cubes
from tests.meshing.measures import X, Y, Z, body_volume, check_crack, faces_on, normals, on, pieces, sides

Index = NDArray[np.int64]


def a_file(path: Path, kind: str, faces: Index, **others: Index) -> Path:
    """A gmsh file of 4 x 4 x 4 unit cubes with physical groups of faces."""
    mesh = cubes(kind)
    groups = {"fault": faces, **others}
    cells = [mesh.cells[0], *(({3: "triangle", 4: "quad", 6: "triangle6"}[f.shape[1]], f) for f in groups.values())]
    data = [np.full(len(block[1] if isinstance(block, tuple) else block.data), i + 1) for i, block in enumerate(cells)]
    names = {name: np.array([i, 2 if i > 1 else 3]) for i, name in enumerate(["body", *groups], start=1)}
    whole = meshio.Mesh(
        mesh.points, cells, field_data=names, cell_data={"gmsh:physical": data, "gmsh:geometrical": [d.copy() for d in data]}
    )
    meshio.write(path, whole, file_format="gmsh22", binary=False)
    return path


def shuffled(faces: Index) -> Index:
    """Faces turned over and round at will, but for the first one."""
    rng = np.random.default_rng(3)
    turned = [np.roll(f[:: rng.choice([-1, 1])], rng.integers(4)) for f in faces]
    return np.array([faces[0], *turned[1:]])


@pytest.mark.parametrize("kind", ["hexahedron", "tetra", "tetra10"])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_named_surface(tmp_path: Path, kind: str, sign: int) -> None:
    faces = faces_on(cubes(kind), [sign, 0, 0], on(X, 2)[1])
    base = faces_on(cubes(kind), *on(Z, 0))
    mesh = read_mesh(a_file(tmp_path / "block.msh", kind, shuffled(faces), base=base), "fault")
    assert pieces(mesh) == 2
    check_crack(mesh)
    np.testing.assert_allclose(normals(mesh, sides(mesh.cells[-1])[0]).sum(axis=0), [sign * 16, 0, 0])
    bottom = np.flatnonzero(mesh.points[:, Z] == 0)
    corners = bottom[mesh.point_data["original"][bottom] < 125]
    assert set(mesh.point_sets["base"]) == set(corners)  # the copies too


def test_sheets_that_cross_are_turned_each_by_itself(tmp_path: Path) -> None:
    mesh = cubes()
    sheets = [shuffled(faces_on(mesh, n, on(*s)[1])) for n, s in (
        ([1, 0, 0], (X, 2, (Y, 0, 2))), ([1, 0, 0], (X, 2, (Y, 2, 4))), ([0, -1, 0], (Y, 2, (X, 0, 2))),
        ([0, 1, 0], (Y, 2, (X, 2, 4))),
    )]  # fmt: skip
    result = read_mesh(a_file(tmp_path / "block.msh", "hexahedron", np.concatenate(sheets)), "fault")
    assert pieces(result) == 4
    check_crack(result)
    n = normals(result, sides(result.cells[-1])[0])
    np.testing.assert_allclose(n, np.repeat([[1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0]], 8, axis=0))


@pytest.mark.parametrize("kind", ["hexahedron", "tetra", "tetra10"])
def test_a_set_of_nodes(tmp_path: Path, kind: str) -> None:
    mesh = cubes(kind)
    for axis in (X, Y, Z):
        p = mesh.points
        mesh.point_sets = {"FAULT": np.flatnonzero((p[:, axis] == 2) & (p[:, axis - 1] <= 3))}
        mesh.write(tmp_path / "block.inp")
        result = read_mesh(tmp_path / "block.inp", "FAULT")
        assert pieces(result) == 1  # the front ends inside
        check_crack(result)
        np.testing.assert_allclose(normals(result, sides(result.cells[-1])[0]).sum(axis=0), 12 * np.eye(3)[axis])


@pytest.mark.parametrize("order", [1, 2])
def test_a_mesh_that_gmsh_wrote(tmp_path: Path, order: int) -> None:
    """A disc in a cube, with gmsh's own order of the nodes of tetra10, and faces in as many blocks as it likes."""
    with session() as gmsh:
        box, disc = (3, gmsh.model.occ.addBox(0, 0, 0, 4, 4, 4)), (2, gmsh.model.occ.addDisk(2, 2, 2, 1, 1))
        _, (body, faces) = gmsh.model.occ.fragment([box], [disc])
        gmsh.model.occ.synchronize()
        for i, (name, entities) in enumerate({"body": body, "crack": faces}.items()):
            gmsh.model.addPhysicalGroup(3 - i, [tag for _, tag in entities], name=name)
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.7)
        gmsh.model.mesh.generate(3)
        gmsh.option.setNumber("Mesh.SecondOrderLinear", 1)
        gmsh.model.mesh.setOrder(order)
        gmsh.write(str(tmp_path / "disc.msh"))
    mesh = read_mesh(tmp_path / "disc.msh", "crack")
    assert [b.type for b in mesh.cells] == [["tetra", "wedge"], ["tetra10", "wedge15"]][order - 1]
    assert body_volume(mesh) == pytest.approx(64)
    check_crack(mesh)
    assert 0.9 * np.pi < np.linalg.norm(normals(mesh, sides(mesh.cells[-1])[0]).sum(axis=0)) < np.pi
    radius = np.linalg.norm(mesh.points[mesh.point_data["original"][mesh.point_sets["crack"]]] - 2, axis=1)
    copies = np.unique(mesh.point_data["original"][mesh.point_sets["crack"]], return_counts=True)[1]
    assert (copies == 2).sum() * 2 == (radius < 0.93).sum()  # all but those of the front
    if order == 2:
        cells = mesh.cells[0].data
        for i, (a, b) in enumerate([(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]):
            np.testing.assert_allclose(mesh.points[cells[:, 4 + i]], mesh.points[cells[:, [a, b]]].mean(axis=1), atol=1e-9)


def written(path: Path, mesh: meshio.Mesh, **sets: Index) -> Path:
    mesh.point_sets = sets
    mesh.write(path)
    return path


def test_a_solid_mesh_that_does_not_work_is_named(tmp_path: Path) -> None:
    mesh, tetrahedra = cubes(), cubes("tetra")
    fault = faces_on(mesh, *on(X, 2))
    path = a_file(tmp_path / "block.msh", "hexahedron", fault, outside=faces_on(mesh, *on(X, 0)))
    half_out = np.concatenate([faces_on(mesh, *on(X, 2)), faces_on(mesh, [0, -1, 0], on(Y, 4, (X, 2, 4))[1])])
    cases: list[tuple[Path, Any, str]] = [
        (path, [[(2, 0), (2, 4)]], "crack = .*: the mesh is solid; expected the name of a set of faces or nodes"),
        (path, "crack", "crack = 'crack': the file has no such set; it has body, fault, outside"),
        (path, "body", "crack = 'body': this set has all corners of element 0; expected nodes on one surface"),
        (path, "outside", "the crack surface runs along its boundary at"),
        (a_file(tmp_path / "out.msh", "hexahedron", half_out), "fault", r"runs along its boundary at \(2\.5, 4,"),
        (
            a_file(tmp_path / "loose.msh", "hexahedron", np.array([[0, 6, 12, 18]])),
            "fault",
            r"it mixes solid and plane cells, quad 0 at \(0, 1\.5, 1\.5\) is no face",
        ),
        (
            a_file(tmp_path / "kinds.msh", "hexahedron", fault[:, :3]),
            "fault",
            "it mixes solid and plane cells, triangle 0 at",
        ),
        (
            written(tmp_path / "line.inp", mesh, AXIS=np.flatnonzero((mesh.points[:, 1:] == 2).all(axis=1))),
            "AXIS",
            "crack = 'AXIS': no element face joins nodes of this set; expected surface cells or nodes on the surface",
        ),
        (
            written(tmp_path / "thick.inp", tetrahedra, SLAB=np.flatnonzero(abs(tetrahedra.points[:, 0] - 1.5) < 1)),
            "SLAB",
            "crack = 'SLAB': this set has all corners of element",
        ),
    ]
    turned = cubes("tetra")
    turned.cells[0].data[7] = turned.cells[0].data[7][[1, 0, 2, 3]]
    cases.append(
        (written(tmp_path / "turned.inp", turned, A=fault[0]), "A", "tetra 7 at .* is inverted or flat; expected cells")
    )
    upside_down = cubes()
    upside_down.cells[0].data[5] = upside_down.cells[0].data[5][[4, 5, 6, 7, 0, 1, 2, 3]]
    cases.append(
        (written(tmp_path / "upside_down.inp", upside_down, A=fault[0]), "A", "hexahedron 5 at .* is inverted or flat")
    )
    prism = meshio.Mesh(np.eye(6, 3), [("wedge", np.arange(6)[None])])
    cases.append((written(tmp_path / "prism.vtu", prism), "A", "its cells are wedge; expected tetra, tetra10, hexahedron"))
    mixed = meshio.Mesh(mesh.points, [mesh.cells[0], ("tetra", tetrahedra.cells[0].data)])
    cases.append(
        (written(tmp_path / "mixed.inp", mixed, A=fault[0]), "A", "mixes solid cells that share no faces: hexahedron, tetra")
    )
    for file, crack, message in cases:
        with pytest.raises(MeshError, match=message):
            read_mesh(file, crack)


def test_a_surface_with_one_side_is_named() -> None:
    strip = np.array([[0, 1, 2], [1, 2, 3], [2, 3, 4], [3, 4, 0], [4, 0, 1]])  # of Moebius
    with pytest.raises(MeshError, match="crack = 'fault': this surface has only one side"):
        flipped("fault", strip)


def test_a_solid_band_is_a_set_of_elements(tmp_path: Path) -> None:
    mesh = cubes()
    middle = np.flatnonzero(abs(mesh.points[mesh.cells[0].data].mean(axis=1)[:, 0] - 1.5) < 0.1)
    mesh.cell_sets = {"MIDDLE": [middle]}
    mesh.write(tmp_path / "block.inp")
    band = read_band_mesh(tmp_path / "block.inp", "MIDDLE")
    assert [(b.type, len(b.data)) for b in band.cells] == [("hexahedron", 48), ("hexahedron", 16)]
    assert set(band.cell_sets) == {"body", "band"}
    everywhere = read_band_mesh(tmp_path / "block.inp")
    assert [(b.type, len(b.data)) for b in everywhere.cells] == [("hexahedron", 64)]
    with pytest.raises(MeshError, match="band = 'NONE': the file has no such set of elements; it has MIDDLE"):
        read_band_mesh(tmp_path / "block.inp", "NONE")


@pytest.mark.parametrize("size", [1e-4, 1.0, 1e4])
def test_a_corner_that_is_pushed_in_is_found_at_any_size(tmp_path: Path, size: float) -> None:
    """The last corner of a cube lies beyond the plane of its three neighbours, by a ten-thousandth of the cube's size."""
    mesh = cubes("hexahedron", 1)
    points = np.where((mesh.points == 1.0).all(axis=1)[:, None], 2.0 / 3.0 - 1e-4, mesh.points)
    meshio.Mesh(size * points, mesh.cells, point_sets={"A": np.arange(4)}).write(tmp_path / "cube.inp")
    with pytest.raises(MeshError, match=r"hexahedron 0 at .* is inverted or flat"):
        read_mesh(tmp_path / "cube.inp", "A")


def test_mid_nodes_are_shared_between_blocks() -> None:
    mesh = cubes("tetra", 2)
    cells = mesh.cells[0].data
    one = with_mid_nodes(mesh)
    three = with_mid_nodes(meshio.Mesh(mesh.points, [("tetra", part) for part in np.split(cells, [5, 20])]))
    np.testing.assert_array_equal(three.points, one.points)
    np.testing.assert_array_equal(np.concatenate([block.data for block in three.cells]), one.cells[0].data)


@pytest.mark.parametrize(("shift", "touching"), [((0.0, 0.0, 0.0), 13), ((0.5, 0.0, 0.0), 8), ((2.2, 0.0, -1.0), 0)])
def test_nodes_within_faces_that_do_not_have_them(shift: tuple[float, float, float], touching: int) -> None:
    """Four unit cubes on one of 2 x 2 x 1 mm: five nodes within its face and four pairs at its corners; moved by half a cube,
    those that still lie on it and the two that now lie under a cube; beside it, level with its face, none."""
    points, cube = cubes("hexahedron", 1).points, cubes("hexahedron", 1).cells[0].data
    small = cubes("hexahedron", 2)
    four = small.cells[0].data[(small.points[small.cells[0].data][:, :, 2] <= 1.0).all(axis=1)]
    both = np.concatenate([points * [2, 2, 1], small.points + np.add(shift, [0, 0, 1])])
    blocks = [("hexahedron", cube), ("hexahedron", four + len(points))]
    if touching:
        with pytest.raises(MeshError, match=f"2 pieces, and {touching} nodes of the boundary touch"):
            check_elements("a.msh", both, blocks)
    else:
        assert not check_elements("a.msh", both, blocks)


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("size", [0.1, 10.0])
def test_a_set_of_nodes_has_its_plus_side_further_along(tmp_path: Path, axis: int, order: int, size: float) -> None:
    """Whichever side the first element is on, also where the faces together are smaller than a square millimetre."""
    mesh = cubes("hexahedron", 2)
    fault, cells = np.flatnonzero(mesh.points[:, axis] == 1.0), mesh.cells[0].data[::order]
    meshio.Mesh(size * mesh.points, [("hexahedron", cells)], point_sets={"A": fault}).write(tmp_path / "cubes.inp")
    cracked = read_mesh(tmp_path / "cubes.inp", "A")
    crack = cracked.cells[-1].data
    for nodes, side in ((crack[:, :4], -1), (crack[:, 4:], 1)):
        owners = [cell for cell in cracked.cells[0].data if np.isin(nodes[0], cell).all()]
        assert len(owners) == 1 and side * (cracked.points[owners[0]].mean(axis=0)[axis] - size) > 0
