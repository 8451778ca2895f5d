"""What the README says is what happens."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from cohesive import Scene
from cohesive.commands.command_line import main
from cohesive.solver.columns import COLUMN_NAMES as COLUMNS

ROOT = Path(__file__).parents[1]
GUIDE = ROOT / "examples" / "guide"
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_python_lines_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    (code,) = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)
    assert len([line for line in code.splitlines() if line.strip()]) <= 20
    monkeypatch.chdir(tmp_path)
    exec(compile(code, "README.md", "exec"), {})
    assert "iterations on" in capsys.readouterr().out
    assert (tmp_path / "finer" / "curve.png").exists()


def test_the_command_runs_and_the_figures_are_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (arguments,) = re.findall(r"\.venv/bin/cohesive (run .*)", README)
    monkeypatch.chdir(tmp_path)
    assert main(arguments.split()) == 0
    out = capsys.readouterr().out
    assert len(README.splitlines()) <= 120
    said = [float(number) for number in re.findall(r"computed peak of (\d+) N comes at (\S+) mm", README)[0]]
    got = [float(number) for number in re.findall(r"peak load: (\S+) N at opening (\S+) mm", out)[0]]
    assert got == pytest.approx(said, rel=1e-3)  # the text is rounded
    inside = re.search(r"(\d+) of the 13 measured points", README)
    assert inside is not None and f"{inside[1]} of 13 points inside the band" in out
    assert (tmp_path / "out" / "frames.pvd").exists()


def test_history_columns_are_documented() -> None:
    page = (GUIDE / "reference" / "python.md").read_text(encoding="utf-8")
    listed = re.findall(r"`(step, load.*?)`", page.replace("\n", " "))[0]
    assert tuple(name.strip() for name in listed.split(",")) == COLUMNS


def test_the_fit_is_that_of_the_scene() -> None:
    material = Scene.load("notched-beam").material
    assert f"ft = {material.ft:g} MPa and Gf = {material.Gf:g} N/mm" in README


def test_ci_runs_the_test_command() -> None:
    assert "README.md" in (ROOT / ".ci" / "run").read_text()
    assert re.search(r"python3 -m venv \.venv && .*pytest$", README, flags=re.MULTILINE)
