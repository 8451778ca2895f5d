"""`cohesive show`: a scene before it runs."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from cohesive.commands.command_line import main


def shown(capsys: pytest.CaptureFixture[str], *arguments: str) -> list[str]:
    assert main(["show", *arguments]) == 0
    return capsys.readouterr().out.splitlines()


def test_a_scene_is_shown_without_solving_anything(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """What would solve it is not there."""
    monkeypatch.setitem(sys.modules, "petsc4py", None)
    changes = ["--set", "mesh.crack_size=5", "--set", "solver.condensation=petsc"]
    assert main(["run", "notched-beam", "-o", str(tmp_path / "out"), *changes]) == 2 and "petsc4py" in capsys.readouterr().err
    lines = shown(capsys, "notched-beam", "-o", str(tmp_path), *changes)
    assert lines[0] == "Half-notched beam in three-point bending"
    assert "crack:     9 zero-thickness cells, path (0, 25) to (0, 50), 25 mm" in lines
    assert "held:      support_left, along y and x" in lines
    assert "driven:    load, load along -y" in lines
    assert "measured:  deflection, tip against yoke along -y" in lines
    assert "stage 1:   opening to 0.18" in lines
    assert "set:       load: 1 node, x 0, y 50" in lines or "set:       load: 2 nodes, x 0, y 50" in lines
    assert [path.name for path in tmp_path.iterdir()] == ["mesh.png"]


def test_models_and_halves_are_told_apart(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    band = shown(capsys, "notched-beam", "-o", str(tmp_path), "--model", "smeared")
    assert any(line.startswith("crack:     22 elements that may crack") for line in band)
    half = shown(capsys, "notched-beam", "-o", str(tmp_path), "--set", "model.half=true")
    assert any(line.endswith("one half of the body") for line in half)
    assert "held:      the plane of symmetry, along x, where the crack opens" in half
    grown = shown(capsys, "notched-beam", "-o", str(tmp_path), "--set", "specimen.crack=grow")
    assert any(line.startswith("crack: ") and line.endswith("the run looks for its path") for line in grown)


def test_bad_input_is_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["show", "notched-beam", "-o", str(tmp_path), "--set", "specimen.notch=80"]) == 2
    err = capsys.readouterr().err
    assert err.startswith("cohesive: specimen.notch = 80") and len(err.splitlines()) == 1


@pytest.mark.parametrize(
    ("curve", "match"),
    [
        ("['deflection']", r"output.curve = ['deflection']: expected two of step, load"),
        ("['deflektion', 'load']", "did you mean 'deflection'?"),
        ("'load'", "output.curve = 'load': expected two of"),
        ("[1, 2]", "output.curve = [1, 2]: expected two of"),
        ("[[], {}]", "expected two of"),
    ],
)
def test_a_curve_of_unknown_columns_is_refused(
    curve: str, match: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["show", "notched-beam", "-o", str(tmp_path), "--set", f"output.curve={curve}"]) == 2
    err = capsys.readouterr().err
    assert match in err and len(err.splitlines()) == 1


@pytest.mark.long
def test_the_law_is_drawn_with_the_width_of_a_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for width, expected in (((), "width of the crack plane 0.5333 mm"), (("--width", "h"), "width of the crack plane 56 mm")):
        assert main(["law", "-o", str(tmp_path), *width]) == 0
        assert expected in capsys.readouterr().out
