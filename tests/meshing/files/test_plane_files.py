"""A user's own plane mesh, cut along a polyline or a named set."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest

from meshing import MeshError, read_mesh
from meshing.cutting.edges import edges_on_path
from tests.builders import grid
from tests.meshing.measures import pieces


@pytest.mark.parametrize("format", ["msh", "vtu", "inp"])
def test_a_users_mesh_with_a_polyline(tmp_path: Path, format: str) -> None:
    path = tmp_path / f"plate.{format}"
    plate = grid(kind="triangle")
    plate.points = np.column_stack([plate.points, np.zeros(len(plate.points))])
    plate.write(path, file_format="gmsh22" if format == "msh" else None)
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


@pytest.mark.parametrize("kind", ["quad", "triangle6"])
def test_a_users_mesh_with_a_node_set(tmp_path: Path, kind: str) -> None:
    plate = grid(kind=kind)
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
    with pytest.raises(MeshError, match=r"expected a file of gmsh"):
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


def test_a_set_of_elements_that_are_not_there_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plate = grid(kind="quad")
    plate.cell_sets = {"left": [np.array([0, 16])]}
    (tmp_path / "plate.med").write_text("")
    monkeypatch.setattr(meshio, "read", lambda path, form: plate)
    with pytest.raises(MeshError, match="set 'left' names quad 16 of 16, counted from 0"):
        read_mesh(tmp_path / "plate.med", [[(2, 0), (2, 4)]])
