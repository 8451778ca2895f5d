"""What becomes of a command whose streams are closed, full, narrow, or left by their reader: its results are there."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from cohesive.commands.command_line import main

pytestmark = pytest.mark.skipif(os.name != "posix", reason="POSIX")

QUICK = "--set mesh.crack_size=5 --set mesh.far_size=20 --set stage.0.steps=3 --set output.frames=0"


def shell(line: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """A line of the shell in which `cohesive` is the command."""
    line = line.replace("cohesive", f"{sys.executable} -m cohesive", 1)
    return subprocess.run(
        ["bash", "-c", line], capture_output=True, text=True, timeout=60, check=False, env=os.environ | environment
    )


@pytest.mark.parametrize(
    ("streams", "said"),
    [
        ("2>&-", ""),
        pytest.param(">&-", "", marks=pytest.mark.long),
        pytest.param("<&- >&- 2>&-", "", marks=pytest.mark.long),
        (">/dev/full", "cohesive: what was printed could not be written: No space left on device"),
        pytest.param(
            "-v >/dev/full", "cohesive: what was printed could not be written: No space left on device", marks=pytest.mark.long
        ),
        pytest.param("2>/dev/full", "", marks=pytest.mark.long),
        ("-v | head -1; exit ${PIPESTATUS[0]}", ""),
        pytest.param("| true; exit ${PIPESTATUS[0]}", "", marks=pytest.mark.long),
    ],
)
def test_a_run_is_saved_whatever_its_streams_are(streams: str, said: str, tmp_path: Path) -> None:
    ended = shell(f"cohesive run notched-beam -o {tmp_path}/out {QUICK} {streams}")
    assert (ended.returncode, ended.stderr.strip()) == (2 if said else 0, said)
    assert (tmp_path / "out" / "result.npz").is_file()
    assert (tmp_path / "out" / "history.csv").read_text().startswith("step,")  # and nothing that was printed


def test_a_pipe_that_does_not_block_loses_nothing(tmp_path: Path) -> None:
    """Its reader is slow, and what is printed is more than the pipe holds."""
    read, write = os.pipe()
    os.set_blocking(write, False)
    room = os.write(write, bytes(10_000_000))  # until it is full
    words = ["run", "notched-beam", "-v", "-o", str(tmp_path / "out"), *QUICK.split()]
    with subprocess.Popen([sys.executable, "-m", "cohesive", *words], stdout=write, stderr=subprocess.PIPE) as process:
        os.close(write)
        while process.poll() is None and not (tmp_path / "out" / "scene.toml").exists():
            time.sleep(0.05)
        time.sleep(0.5)
        with os.fdopen(read, "rb") as pipe:
            printed = pipe.read()[room:].decode()
        assert process.wait(60) == 0
    assert printed.startswith("step    1") and "files: " in printed
    assert (tmp_path / "out" / "result.npz").is_file()


def test_a_narrow_encoding_takes_any_title(tmp_path: Path) -> None:
    title = "title=Bruchzähes 混凝土"
    line = f"cohesive run notched-beam -o {tmp_path}/out {QUICK} --set '{title}'"
    ended = shell(line, PYTHONIOENCODING="ascii", PYTHONUTF8="1")
    assert (ended.returncode, ended.stderr) == (0, "")
    assert r"Bruchz\xe4hes \u6df7" in ended.stdout
    assert (tmp_path / "out" / "curve.png").is_file()


@pytest.mark.parametrize("name", ["film.avi", "film", "none/film.gif", f"{'x' * 300}.gif", "../out"])
def test_a_movie_that_cannot_be_is_refused_before_the_run(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", "notched-beam", "-o", str(tmp_path / "out"), "--movie", name]) == 2
    assert capsys.readouterr().err.startswith("cohesive: movie '")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("command", [["run", "notched-beam", "-o"], ["run", "--resume"], ["report"], ["show"], ["explore"]])
def test_a_name_that_is_too_long_is_told(command: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*command, "x" * 300]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1
