"""However a run ends, its history is on disk, in whole rows."""

from __future__ import annotations

import csv
import errno
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

import cohesive.algebra.choice
import cohesive.figures.pictures
import cohesive.results.files
import cohesive.solver.newton
import meshing.generation.polygon
from cohesive import Scene, SceneError, run
from cohesive.__main__ import main
from cohesive.results.checkpoints import NAME
from cohesive.solver.columns import COLUMN_NAMES

QUICK = ["--set", "mesh.crack_size=2.5", "--set", "mesh.far_size=12.0", "--set", "stage.0.steps=20"]

#: where a run is when the signal comes: module, function, and which call of it
PLACES = {
    "meshing": (meshing.generation.polygon, "set_sizes", 1),
    "condensation": (cohesive.algebra.choice, "nested_dissection", 1),
    "the first step": (cohesive.solver.newton, "next_state", 1),
    "Newton": (cohesive.solver.newton, "next_state", 8),
    "the pictures": (cohesive.figures.pictures, "save_curve", 1),
    "renaming a file": (os, "replace", 4),
}


def rows(folder: Path) -> int:
    """Number of steps in the history; every row of it is whole."""
    text = (folder / "history.csv").read_text()
    assert text.endswith("\n")
    table = list(csv.reader(text.splitlines()))
    assert tuple(table[0])[: len(COLUMN_NAMES)] == COLUMN_NAMES
    assert all(len(row) == len(table[0]) for row in table)
    assert [int(row[0]) for row in table[1:]] == list(range(len(table) - 1))
    return len(table) - 2


def before(monkeypatch: pytest.MonkeyPatch, place: tuple[object, str, int], then: Callable[[], None]) -> None:
    """Let something happen before the given call of a function."""
    module, name, at = place
    original, calls = getattr(module, name), 0

    def wrapper(*arguments: object, **named: object) -> object:
        nonlocal calls
        calls += 1
        if calls == at:
            then()
        return original(*arguments, **named)

    monkeypatch.setattr(module, name, wrapper)


@pytest.fixture
def command(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., int]]:
    """The entry point; the handlers of signals are put back afterwards."""
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a parent in the background may have switched it off

    def call(*arguments: str) -> int:
        monkeypatch.setattr(sys, "argv", ["cohesive", *arguments])
        return main()

    yield call
    for number, handler in handlers.items():
        signal.signal(number, handler)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("place", PLACES)
def test_a_signal_ends_a_run_and_keeps_its_history(
    number: signal.Signals,
    place: str,
    command: Callable[..., int],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    before(monkeypatch, PLACES[place], lambda: signal.raise_signal(number))
    assert command("run", "notched-beam", "-o", str(tmp_path), *QUICK) == 128 + number  # 130, 143
    out, err = capsys.readouterr()
    word = "interrupted" if number == signal.SIGINT else "terminated"
    assert err.startswith("cohesive: ") and word in err and "Traceback" not in err
    assert not list(tmp_path.glob(".*partial*"))
    if place in ("meshing", "condensation"):
        assert not list(tmp_path.iterdir())
        return
    done = rows(tmp_path)
    if place in ("the first step", "Newton"):
        assert done == (0 if place == "the first step" else done) < 20
        assert f"stopped: {word}" in out
        assert (tmp_path / "run.json").exists() and (tmp_path / "curve.png").exists() == (done > 0)
    else:
        assert done == 20
        assert "peak load:" in out


@pytest.mark.parametrize(
    ("place", "discrete", "smeared"),
    [
        ((meshing.generation.polygon, "set_sizes", 1), False, False),
        ((cohesive.solver.newton, "next_state", 8), True, False),
        ((cohesive.algebra.choice, "nested_dissection", 2), True, False),  # the second model, before its first step
        pytest.param((cohesive.solver.newton, "next_state", 30), True, True, marks=pytest.mark.long),
    ],
)
def test_a_signal_ends_a_comparison(
    place: tuple[object, str, int],
    discrete: bool,
    smeared: bool,
    command: Callable[..., int],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    before(monkeypatch, place, lambda: signal.raise_signal(signal.SIGTERM))
    assert command("compare", "notched-beam", "-o", str(tmp_path), *QUICK) == 143
    err = capsys.readouterr().err
    assert "terminated" in err and "Traceback" not in err
    for name, kept in (("discrete", discrete), ("smeared", smeared)):
        assert (tmp_path / name / "curve.png").exists() == kept
        if kept:
            assert rows(tmp_path / name) > 0


def test_a_second_sigterm_does_not_end_the_saving(
    command: Callable[..., int], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for place in ("Newton", "the pictures"):  # `timeout` sends it to the process and to its group
        before(monkeypatch, PLACES[place], lambda: signal.raise_signal(signal.SIGTERM))
    assert command("run", "notched-beam", "-o", str(tmp_path), *QUICK) == 143
    assert rows(tmp_path) > 0
    assert (tmp_path / "deformed.png").exists() and (tmp_path / "run.json").exists()


class FullDisk:
    """A file on a disk with room for a number of bytes."""

    def __init__(self, file: object, room: int) -> None:
        self._file, self._room = file, room

    def write(self, data: bytes) -> int:
        if not self._room:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        part = data[: self._room]
        self._room -= len(part)
        return int(self._file.write(part))  # type: ignore[attr-defined]

    def __getattr__(self, name: str) -> object:
        return getattr(self._file, name)


@pytest.fixture
def full_disk(monkeypatch: pytest.MonkeyPatch) -> None:
    """history.csv fills the disk in the middle of a row."""

    def full(path: Path, mode: str, buffering: int) -> FullDisk:
        return FullDisk(open(path, mode, buffering), 1000)

    monkeypatch.setattr(cohesive.results.files, "open", full, raising=False)


@pytest.mark.usefixtures("full_disk")
def test_a_full_disk_ends_a_run_with_whole_rows(tmp_path: Path) -> None:
    scene = Scene.load("notched-beam").with_(**{"mesh.crack_size": 2.5, "mesh.far_size": 12.0})
    with pytest.raises(SceneError, match=r"history.csv': cannot be written: No space left on device") as caught:
        run(scene, output=tmp_path)
    done = rows(tmp_path)
    assert 0 < done < 10
    assert caught.value.result.steps == done + 1  # type: ignore[attr-defined]  # the last one did not fit


@pytest.mark.usefixtures("full_disk")
@pytest.mark.parametrize("name", ["run", "compare"])
def test_the_command_names_the_full_disk(
    name: str, command: Callable[..., int], capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """Where there is room again, for the pictures at least, everything up to there is saved."""
    assert command(name, "notched-beam", "-o", str(tmp_path), *QUICK) == 2
    err = capsys.readouterr().err
    assert "No space left on device" in err and "Traceback" not in err
    folder = tmp_path if name == "run" else tmp_path / "discrete"
    assert rows(folder) > 0
    assert (folder / "curve.png").exists()


def test_a_disk_that_stays_full_leaves_the_rows_that_fit(
    full_disk: None, command: Callable[..., int], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:  # fmt: skip
    def refuse(path: Path, text: str, encoding: str) -> None:
        path.touch()
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(Path, "write_text", refuse)
    assert command("run", "notched-beam", "-o", str(tmp_path), *QUICK) == 2
    out, err = capsys.readouterr()
    assert "peak load:" in out  # the numbers are told, whatever became of the files
    assert "No space left on device" in err and "Traceback" not in err
    assert rows(tmp_path) > 0
    # text does not fit, the copies do; the run can be resumed if there is room again
    assert {path.name for path in tmp_path.iterdir()} == {"history.csv", "inputs", NAME}


@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="Linux")
@pytest.mark.parametrize("name", ["run", "compare"])
def test_a_folder_that_cannot_be_written_is_refused_before_meshing(
    name: str, command: Callable[..., int], capsys: pytest.CaptureFixture[str]
) -> None:
    """There is a folder, and nobody may write to it; that the mesh cannot be made either is not found out."""
    unmeshable = ["--set", "mesh.crack_size=0.001", "--set", "mesh.far_size=0.01"]  # no memory holds that
    assert command(name, "notched-beam", "-o", "/proc/self", *unmeshable) == 2
    assert "output folder '/proc/self': cannot be written: " in capsys.readouterr().err


@pytest.mark.parametrize("number", [pytest.param(signal.SIGINT, marks=pytest.mark.long), signal.SIGTERM, signal.SIGKILL])
@pytest.mark.parametrize("name", ["run", pytest.param("compare", marks=pytest.mark.long)])
def test_a_process_keeps_the_history(number: signal.Signals, name: str, tmp_path: Path) -> None:
    """The same from outside, where nothing is in the way of the signal."""
    command = [sys.executable, "-m", "cohesive", name, "notched-beam", "-o", str(tmp_path), "--set", "stage.0.steps=20000"]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )  # fmt: skip
    folder = tmp_path if name == "run" else tmp_path / "discrete"
    history = folder / "history.csv"
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline and not (history.exists() and len(history.read_text().splitlines()) > 21):
        time.sleep(0.05)
    process.send_signal(number)
    out, err = process.communicate(timeout=60)
    assert rows(folder) >= 20
    assert "Traceback" not in err
    if number == signal.SIGKILL:
        assert process.returncode == -9
        return
    assert process.returncode == 128 + number
    word = "interrupted" if number == signal.SIGINT else "terminated"
    assert word in err
    assert name == "compare" or f"stopped: {word}" in out
    assert (folder / "curve.png").exists()


@pytest.mark.parametrize("delay", [0.0, 0.05, 0.1, 0.2])
def test_an_interruption_while_modules_are_loaded_leaves_no_traceback(delay: float, tmp_path: Path) -> None:
    """From the moment when the first line of ours runs; before it is the interpreter's own start."""
    code = "import sys, cohesive.__main__ as entry; print('up', flush=True); sys.exit(entry.main())"
    command = [sys.executable, "-c", code, "run", "notched-beam", "-o", str(tmp_path), "--set", "stage.0.steps=20000"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    process.stdout.readline()
    time.sleep(delay)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    assert (process.returncode, "Traceback" in err) == (130, False), err
    assert "cohesive: interrupted" in err or "stopped" in err


# -- signals at any moment, and a disk that is full at any file ------------------------------------


def started(folder: Path, *changes: str) -> subprocess.Popen[str]:
    """A run in a process of its own."""
    sets = [word for change in changes for word in ("--set", change)]
    command = [sys.executable, "-m", "cohesive", "run", "notched-beam", "-o", str(folder), *sets]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def is_whole(folder: Path) -> None:
    """No file is half-written, and every row of the history is whole."""
    assert not list(folder.rglob(".*partial*"))
    if (folder / "history.csv").exists():
        rows(folder)


@pytest.mark.long
def test_a_signal_ends_a_long_call(tmp_path: Path) -> None:
    """gmsh is at work for minutes, and comes to no signal by itself."""
    process = started(tmp_path, "mesh.crack_size=0.001", "mesh.far_size=8", "mesh.order=1")
    time.sleep(3.0)
    clock = time.monotonic()
    process.send_signal(signal.SIGTERM)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 128 + signal.SIGTERM
    assert time.monotonic() - clock < 10.0  # 1 second, on a machine that is not busy
    assert "cohesive: terminated" in err and "Traceback" not in err
    is_whole(tmp_path)


@pytest.mark.slow
def test_sixty_interruptions(tmp_path: Path) -> None:
    """At random moments: status, whole files, and the history of a run that was not interrupted once it is resumed."""
    changes = ("mesh.crack_size=0.3", "mesh.far_size=3.0", "stage.0.steps=200")
    clock = time.monotonic()
    process = started(tmp_path / "whole", *changes)
    assert process.communicate()[1] == ""
    duration = time.monotonic() - clock
    expected = (tmp_path / "whole" / "history.csv").read_text().splitlines()
    random = np.random.default_rng(5)
    for i in range(60):
        folder, number = tmp_path / str(i), (signal.SIGINT, signal.SIGTERM, signal.SIGKILL)[i % 3]
        process = started(folder, *changes)
        time.sleep(random.uniform(0.15, 1.05 * duration))  # before that the interpreter itself is starting
        clock = time.monotonic()
        process.send_signal(number)
        _, err = process.communicate(timeout=60)
        assert "Traceback" not in err, err
        assert process.returncode in (0, -signal.SIGKILL if number == signal.SIGKILL else 128 + number), (i, err)
        assert time.monotonic() - clock < 10.0
        if number != signal.SIGKILL:
            is_whole(folder)
        if not (folder / NAME).exists():
            continue
        assert main_of("run", "--resume", str(folder)) == 0
        found = (folder / "history.csv").read_text().splitlines()
        at = expected[0].split(",").index("wall_time")
        assert [without(line, at) for line in found] == [without(line, at) for line in expected]


def without(line: str, at: int) -> list[str]:
    """The values of a row but for one."""
    values = line.split(",")
    return values[:at] + values[at + 1 :]


def main_of(*arguments: str) -> int:
    """Exit status of the command in a process of its own."""
    return subprocess.run([sys.executable, "-m", "cohesive", *arguments], capture_output=True, check=False).returncode


@pytest.mark.parametrize("at", [1, 3, 6, *(pytest.param(at, marks=pytest.mark.slow) for at in (2, 4, 5, *range(7, 26)))])
def test_a_disk_that_is_full_at_any_file(
    at: int, command: Callable[..., int], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """Renaming the file fails: the message names it, and what is there is whole."""
    refused: list[str] = []
    replace = os.replace

    def full(source: Path, target: Path) -> None:
        refused.append(str(target))
        if len(refused) >= at:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        replace(source, target)

    monkeypatch.setattr(os, "replace", full)
    status = command("run", "notched-beam", "-o", str(tmp_path), *QUICK)
    err = capsys.readouterr().err
    assert status == (2 if len(refused) >= at else 0), refused
    assert "Traceback" not in err and (not status or "No space left on device" in err)
    is_whole(tmp_path)
