"""The command line and the files it leaves."""

from __future__ import annotations

import csv
import json
import xml.etree.ElementTree as ET
from pathlib import Path

import meshio
import numpy as np
import pytest

from cohesive.commands.command_line import main
from cohesive.commands.common import assignments
from cohesive.solver.columns import COLUMN_NAMES as COLUMNS

QUICK = ["--set", "mesh.crack_size=2.5", "--set", "mesh.far_size=12.0", "--set", "stage.0.steps=20"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("beam") / "out"
    assert main(["run", "notched-beam", "-o", str(path), *QUICK]) == 0
    return path


def test_files_of_a_run(folder: Path) -> None:
    names = {path.name for path in folder.iterdir()}
    assert {"history.csv", "curve.png", "deformed.png", "frames.pvd", "run.json", "scene.toml"} <= names
    assert not [name for name in names if "partial" in name]
    with open(folder / "history.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert tuple(rows[0]) == (*COLUMNS, "deflection", "cmod", "ctod")
    assert [int(row["step"]) for row in rows] == list(range(21))
    facts = json.loads((folder / "run.json").read_text())
    assert facts["peak_load"] == pytest.approx(max(float(row["load"]) for row in rows))
    assert set(facts["timings"]) == {"mesh", "assemble", "condense", "newton", "output"}
    assert {"numpy", "scipy", "gmsh", "cohesive-cracks"} <= set(facts["versions"])
    for name in ("curve.png", "deformed.png"):
        assert (folder / name).read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"


def test_frames_show_the_crack_open(folder: Path) -> None:
    files = [entry.get("file") for entry in ET.parse(folder / "frames.pvd").iter("DataSet")]
    assert len(files) >= 5
    mesh = meshio.read(folder / str(files[-1]))
    crack = mesh.cells[-1]
    assert crack.type == "quad8"
    u = mesh.point_data["displacement"]
    jump = np.linalg.norm(u[crack.data[:, 3]] - u[crack.data[:, 0]], axis=1)
    assert jump.max() > 0.08  # 0.18 mm at the mouth, half of it half-way up
    opening = mesh.cell_data["opening"][-1]
    assert opening.max() == pytest.approx(jump.max(), rel=0.1)
    assert mesh.cell_data["damage"][-1].max() > 0.99
    assert all(np.isfinite(values).all() for blocks in mesh.cell_data.values() for values in blocks)


def test_the_saved_scene_runs_again_and_gives_the_same(folder: Path, tmp_path: Path) -> None:
    assert main(["run", str(folder / "scene.toml"), "-o", str(tmp_path)]) == 0
    first, second = (np.genfromtxt(path / "history.csv", delimiter=",", names=True) for path in (folder, tmp_path))
    np.testing.assert_array_equal(first["load"], second["load"])


def test_the_summary_says_what_was_modelled(folder: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    main(["run", "notched-beam", "-o", str(tmp_path), *QUICK])
    out, err = capsys.readouterr()
    for words in ("modelled:", "solved:", "left out:", "peak load:", "dissipated:", "energy balance:", "elastic compliance",
                  "iterations:", "of 13 points inside the band"):  # fmt: skip
        assert words in out
    assert err == ""  # quiet where nobody watches


def test_verbose_lists_the_residuals(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    main(["run", "notched-beam", "-v", "-o", str(tmp_path), *QUICK])
    steps = [line for line in capsys.readouterr().out.splitlines() if line.startswith("step ")]
    assert len(steps) == 20
    assert all("residuals" in line for line in steps)


def test_law(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["law", "--preset", "jacobsen", "--width", "2", "--set", "Gf=0.1", "-o", str(tmp_path)]) == 0
    assert "cyclic_tension" in capsys.readouterr().out
    table = np.genfromtxt(tmp_path / "cyclic_tension.csv", delimiter=",", names=True)
    assert table["traction_n_MPa"].max() == pytest.approx(3.0, rel=0.02)
    assert table["traction_n_MPa"].min() < 0  # it closes
    sheared = [np.genfromtxt(path, delimiter=",", names=True) for path in sorted(tmp_path.glob("shear_at_*"))]
    assert len(sheared) == 2
    assert all(table["traction_n_MPa"][-1] < 0 for table in sheared)  # aggregate interlock pushes apart
    closing = [np.genfromtxt(tmp_path / f"closing_c_zn_{c}.csv", delimiter=",", names=True) for c in (5, 9, 50)]
    at = [np.interp(-0.1 * 0.1, t["jump_n_mm"][::-1], t["traction_n_MPa"][::-1]) for t in closing]
    assert at[0] < at[1] < at[2]  # the softer the closure, the earlier it carries
    assert (tmp_path / "law.png").stat().st_size > 20_000


def test_scenes(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["scenes"]) == 0
    assert {"notched-beam", "notched-tension", "single-crack"} <= {
        line.split()[0] for line in capsys.readouterr().out.splitlines()
    }
    assert main(["scenes", "notched-beam"]) == 0
    assert 'kind = "notched-beam"' in capsys.readouterr().out


@pytest.mark.parametrize(
    ("text", "value"),
    [(".5", 0.5), ("5.", 5.0), ("-.5e-1", -0.05), ("007", 7.0), ("1_000", 1000), ("5 mm", "5 mm"), (".", "."), ("e5", "e5")],
)
def test_numbers_are_read_as_people_write_them(text: str, value: object) -> None:
    found = assignments([f"mesh.crack_size={text}"])["mesh.crack_size"]
    assert found == value and type(found) is type(value)
