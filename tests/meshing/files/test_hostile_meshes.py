"""Meshes that no one should trust: one sentence and status 2, or they run."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

from cohesive import Scene, run
from cohesive.commands.command_line import main
from cohesive.scenes.scene import dump_toml
from tests.hostile import MESHES, NO_MESHES, write_mesh


def scene_on(folder: Path, name: str, is_solid: bool = False) -> str:
    """A scene on a mesh of 4 x 4 squares or 2 x 2 x 2 cubes, one step; its file."""
    if is_solid:
        axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
        supports = [{"at": [0.0, 0.0, 0.0], "direction": axis} for axis in axes]
        supports += [{"at": [2.0, 0.0, 0.0], "direction": axis} for axis in axes[1:]]
        supports += [{"at": [0.0, 2.0, 0.0], "direction": axes[2]}]
        data = {"crack": "crack", "supports": supports, "drive": {"at": [2.0, 2.0, 2.0], "direction": [0, 0, 1]}}
    else:
        supports = [{"at": [0.0, 0.0], "direction": [1, 0]}, {"at": [0.0, 0.0], "direction": [0, 1]}]
        supports += [{"at": [0.0, 4.0], "direction": [1, 0]}]
        drive = {"at": [4.0, 4.0], "direction": [1, 0]}
        data = {"crack": [[2.0, 0.0], [2.0, 4.0]], "thickness": 1.0, "supports": supports, "drive": drive}
    scene = {
        "specimen": {"kind": "mesh", "file": name, **data},
        "material": {"preset": "reinhardt"},
        "output": {"frames": 0},
        "stage": [{"control": "driven", "to": 1e-4, "steps": 1}],
    }
    (folder / "scene.toml").write_text(dump_toml(scene))
    return str(folder / "scene.toml")


def assert_said(arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Status 2 and one line with a message; status 0 without one."""
    capsys.readouterr()  # of what wrote the file
    status = main(arguments)
    error = capsys.readouterr().err
    assert (status, len(error.splitlines())) == ((2, 1) if message else (0, 0)), error
    assert re.search(message, error) and len(error) < 2500, error
    assert "Traceback" not in error


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", MESHES)
def test_a_mesh(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    make, message = MESHES[name]
    points, cells, sets = make()
    is_solid = len(points) > 0 and any(kind in ("hexahedron", "tetra", "pyramid") for kind, _ in cells)
    if is_solid and cells[0][0] != "pyramid":
        sets = sets | {"crack": [i for i, p in enumerate(points) if p[2] == 1]}
    file = write_mesh(tmp_path, (points, cells, sets))
    scene = scene_on(tmp_path, file, is_solid)
    if not message:  # without pictures, which are another matter
        assert run(Scene.load(scene), output=tmp_path / "out").steps == 1
        return
    assert_said(["run", scene, "-o", str(tmp_path / "out")], message, capsys)


@pytest.mark.parametrize("name", NO_MESHES)
def test_no_mesh(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, text = NO_MESHES[name]
    (tmp_path / file).write_text(text)
    assert_said(["run", scene_on(tmp_path, file), "-o", str(tmp_path / "out")], r"specimen.file = '", capsys)


def test_a_pipe_or_a_folder_is_no_mesh(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    os.mkfifo(tmp_path / "pipe.msh")
    (tmp_path / "folder.msh").mkdir()
    for file, message in (
        ("pipe.msh", "it is a pipe or a device; expected a file"),
        ("/dev/zero", "it is a pipe or a device; expected a file"),
        ("folder.msh", "there is no such file"),
        ("x" * 5000, "there is no such file"),
    ):
        assert_said(["run", scene_on(tmp_path, file), "-o", str(tmp_path / "out")], message, capsys)
