"""A run that was killed goes on from its last checkpoint, and its history is that of a run that was not."""

from __future__ import annotations

import os
import pickle
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from cohesive import Result, Scene, SceneError, resume, run
from cohesive.commands.command_line import main
from cohesive.results.checkpoints import EVERY, NAME
from tests.builders import block

CYCLES = [
    {"control": "opening", "to": 0.04, "steps": 15, "unload": {"load": 0.0}},
    {"control": "driven", "to": 0.08, "steps": 12, "until": {"opening": 0.06}},
    {"control": "opening", "to": 0.02, "steps": 6},
]


class Killed(BaseException):
    """Ends a run without a word, as SIGKILL does."""


def killed(scene: Scene, folder: Path, row: int) -> None:
    """A run of which all is lost but its files."""

    def on_step(step: object, now: dict[str, float]) -> None:
        if now["step"] == row:
            kept.append((folder / NAME).read_bytes())
            raise Killed

    kept: list[bytes] = []
    with pytest.raises(Killed):
        run(scene, output=folder, on_step=on_step)
    (folder / NAME).write_bytes(kept[0])


def assert_equal(one: Result, other: Result) -> None:
    for name, column in one.history.items():
        if name != "wall_time":  # the same operations in the same order: equal, and not to a tolerance
            np.testing.assert_array_equal(other.history[name], column, err_msg=name)
    assert one.notes == other.notes


@pytest.mark.parametrize(
    "row", [pytest.param(1, marks=pytest.mark.long), EVERY, pytest.param(EVERY + 1, marks=pytest.mark.long), 3 * EVERY - 1]
)
@pytest.mark.parametrize("model", ["discrete", "smeared"])
def test_a_resumed_run_equals_one_that_was_not_killed(row: int, model: str, tmp_path: Path) -> None:
    scene = block(stage=CYCLES, model__kind=model, solver__tol=1e-6)
    if model == "smeared":
        del scene.data["interface"]
        scene = Scene(scene.data)
    whole = run(scene)
    assert len(whole.states) > 3 * EVERY
    killed(scene, tmp_path, row)
    seen: list[float] = []
    resumed = resume(tmp_path, on_step=lambda step, now: seen.append(now["step"]))
    assert_equal(whole, resumed)
    assert seen[0] == row // EVERY * EVERY + 1 - (EVERY if row % EVERY == 0 else 0)  # that of the row itself was not written
    assert not (tmp_path / NAME).exists()
    lines = (tmp_path / "history.csv").read_text().splitlines()
    assert len(lines) == 1 + len(whole.states)


@pytest.mark.long
def test_a_snap_back_is_resumed_within(tmp_path: Path) -> None:
    """Steps that were found and not handed out yet are part of the state."""
    scene = block(specimen__height=1200.0, specimen__width=20.0, mesh__far_size=40.0, mesh__crack_size=4.0)
    scene = scene.with_(stage=[{"control": "driven", "to": 0.3, "steps": 40}])
    whole = run(scene)
    assert any("goes back from" in note for note in whole.notes)
    ways = whole.history["driven"]
    rows = [row for row in range(EVERY, len(ways), EVERY) if ways[row] < ways[row - 1]]
    assert rows  # a checkpoint lies on the way back
    for row in rows[:1]:
        killed(scene, tmp_path, row + 1)
        assert_equal(whole, resume(tmp_path))


@pytest.mark.parametrize("worth", [1, 4])  # the elastic factorization serves to the end, or some iterations factor anew
def test_reused_factorizations_are_forgotten_at_checkpoints(
    worth: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """If a system is so large that a factorization is kept, GMRES leaves a trace of what it began with."""
    monkeypatch.setattr("cohesive.algebra.bordered.DENSE_WORTH", worth)
    scene = Scene.load("notched-beam").with_(**{"mesh.crack_size": 2.5, "mesh.far_size": 12.0, "stage.0.steps": 30})
    whole = run(scene)
    assert whole.model.problem.stiffness.factorizations < whole.iterations  # type: ignore[attr-defined]
    killed(scene, tmp_path, 2 * EVERY + 3)
    assert_equal(whole, resume(tmp_path))


def test_a_record_that_was_not_written_whole_is_left_out(tmp_path: Path) -> None:
    scene = block(stage=CYCLES)
    killed(scene, tmp_path, 3 * EVERY - 1)
    whole = (tmp_path / NAME).read_bytes()
    (tmp_path / NAME).write_bytes(whole[:-100])
    seen: list[float] = []
    assert_equal(run(scene), resume(tmp_path, on_step=lambda step, now: seen.append(now["step"])))
    assert seen[0] == EVERY + 1


def test_an_interrupted_run_can_be_resumed_and_one_at_its_end_cannot(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupt(step: object, row: dict[str, float]) -> None:
        if row["step"] == EVERY + 2:
            raise KeyboardInterrupt

    scene = block(stage=CYCLES, output__frames=0)
    with pytest.raises(KeyboardInterrupt):
        run(scene, output=tmp_path, on_step=interrupt)
    assert main(["run", "--resume", str(tmp_path)]) == 0
    assert main(["run", "--resume", str(tmp_path)]) == 2
    assert f"there is no {NAME} to resume from" in capsys.readouterr().err


def test_what_cannot_be_resumed_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / NAME).write_bytes(b"not a pickle")
    with pytest.raises(SceneError, match="cannot be read"):
        resume(tmp_path)
    killed(block(stage=CYCLES), tmp_path, EVERY + 1)
    with open(tmp_path / NAME, "rb") as file:
        head, rest = pickle.load(file), file.read()
    (tmp_path / NAME).write_bytes(pickle.dumps(head | {"nodes": head["nodes"] + 1e-9}) + rest)
    with pytest.raises(SceneError, match="the mesh came out differently"):
        resume(tmp_path)
    (tmp_path / NAME).write_bytes(pickle.dumps(head | {"version": "0.0"}) + rest)
    with pytest.raises(SceneError, match=r"was written by version 0\.0"):
        resume(tmp_path)
    assert main(["run", "notched-beam", "--resume", str(tmp_path)]) == 2
    assert "expected no SCENE" in capsys.readouterr().err
    assert main(["run"]) == 2
    assert "expected SCENE" in capsys.readouterr().err


def _killed_by_signal(folder: Path, after: float) -> bool:
    """A run in another process, killed so many seconds after its first row; whether it was in time."""
    command = [sys.executable, "-m", "cohesive", "run", "notched-beam", "-o", str(folder), "--set", "stage.0.steps=200"]
    process = subprocess.Popen([*command, "--set", "output.frames=0"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    history = folder / "history.csv"
    while process.poll() is None and not (history.exists() and history.read_text().count("\n") > 1):
        time.sleep(0.01)
    time.sleep(after)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    return (folder / NAME).exists()


def _assert_resumed(moments: list[float], folder: Path) -> None:
    whole = run(Scene.load("notched-beam").with_(**{"stage.0.steps": 200, "output.frames": 0}))
    in_time = [i for i, after in enumerate(moments) if _killed_by_signal(folder / str(i), after)]
    assert len(in_time) > len(moments) // 2
    for i in in_time:
        assert_equal(whole, resume(folder / str(i)))


@pytest.mark.long
@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="POSIX")
def test_resumed_after_sigkill(tmp_path: Path) -> None:
    _assert_resumed([0.05, 0.2], tmp_path)


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="POSIX")
def test_resumed_after_sigkill_at_ten_random_moments(tmp_path: Path) -> None:
    _assert_resumed([random.Random(i).uniform(0.0, 0.6) for i in range(10)], tmp_path)
