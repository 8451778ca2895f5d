"""Files and pictures of a run in 3D."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest

from cohesive.commands.command_line import main
from cohesive.figures.solid import outer_faces

QUICK = ["--set", "mesh.crack_size=3.0", "--set", "mesh.layers=2", "--set", "stage.0.steps=6"]


def test_files_of_a_run_in_3d(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "notched-beam-3d", "-o", str(tmp_path), *QUICK]) == 0
    assert "in three dimensions with front and back free" in capsys.readouterr().out
    names = {path.name for path in tmp_path.iterdir()}
    assert {"history.csv", "curve.png", "deformed.png", "frames.pvd", "run.json", "scene.toml"} <= names
    mesh = meshio.read(sorted(tmp_path.glob("frame_*.vtu"))[-1])
    (block,) = mesh.cells
    assert block.type == "hexahedron"
    is_crack, u = mesh.cell_data["is_crack"][0] > 0, mesh.point_data["displacement"]
    jump = (u[block.data[is_crack, 4:]] - u[block.data[is_crack, :4]]).mean(axis=1)
    assert abs(jump[:, 0]).max() > 0.07
    np.testing.assert_allclose(mesh.cell_data["opening"][0][is_crack], -jump[:, 0], atol=1e-9)  # the normal is along -x
    assert not mesh.cell_data["opening"][0][~is_crack].any()
    assert {"sliding", "damage", "stress_max", "stress"} < set(mesh.cell_data)
    again = tmp_path / "again"
    assert main(["run", str(tmp_path / "scene.toml"), "-o", str(again)]) == 0
    assert (again / "history.csv").read_text().splitlines()[-1].split(",")[:3] == (
        (tmp_path / "history.csv").read_text().splitlines()[-1].split(",")[:3]
    )


def test_outer_faces_of_prisms_and_cubes() -> None:
    """A cube cut into two prisms, two of them in a row: no face inside the body is drawn."""
    points = np.array([(x, y, z) for z in (0.0, 1.0, 2.0) for y in (0.0, 1.0) for x in (0.0, 1.0)])
    prisms = np.array([[k, k + 1, k + 3, k + 3, k + 4, k + 5, k + 7, k + 7] for k in (0, 4)])
    others = np.array([[k, k + 3, k + 2, k + 2, k + 4, k + 7, k + 6, k + 6] for k in (0, 4)])
    faces, cell = outer_faces([("hexahedron", prisms), ("hexahedron", others)])
    corners = points[faces]
    area = 0.5 * np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    assert np.linalg.norm(area, axis=1).sum() == pytest.approx(10.0)
    np.testing.assert_allclose(area.sum(axis=0), 0.0, atol=1e-12)
    inside = points[np.concatenate([prisms, others])].mean(axis=1)[cell]
    assert ((area * (inside - corners.mean(axis=1))).sum(axis=1)[np.linalg.norm(area, axis=1) > 0] > 0).all()
