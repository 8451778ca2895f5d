"""A run that was killed goes on from its last checkpoint, and its history is that of a run that was not."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cohesive import Result, Scene, SceneError, prepare, resume, run
from cohesive.commands.command_line import main
from cohesive.results.archive import classes_in, packed, unpacked
from cohesive.results.checkpoints import NAME
from cohesive.solver.loading import Actuator, Loading
from cohesive.solver.newton import Equilibrium
from cohesive.solver.problem import Springs, State
from cohesive.solver.stepper import EVERY
from cohesive.solver.steps import Step
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
    assert [untimed(note) for note in one.notes] == [untimed(note) for note in other.notes]


def untimed(note: str) -> str:
    """A note without the time that a search took."""
    return note.partition(" passes in ")[0]


@pytest.mark.parametrize(
    "row", [pytest.param(1, marks=pytest.mark.long), EVERY, pytest.param(EVERY + 1, marks=pytest.mark.long), 3 * EVERY - 1]
)
@pytest.mark.parametrize("model", ["discrete", "smeared"])
def test_a_resumed_run_equals_one_that_was_not_killed(row: int, model: str, tmp_path: Path) -> None:
    scene = block(stage=CYCLES, model__kind=model, solver__tol=1e-6)
    whole = run(scene)
    assert len(whole.history["step"]) > 3 * EVERY
    killed(scene, tmp_path, row)
    seen: list[float] = []
    resumed = resume(tmp_path, on_step=lambda step, now: seen.append(now["step"]))
    assert_equal(whole, resumed)
    assert seen[0] == row // EVERY * EVERY + 1 - (EVERY if row % EVERY == 0 else 0)  # that of the row itself was not written
    assert not (tmp_path / NAME).exists()
    lines = (tmp_path / "history.csv").read_text().splitlines()
    assert len(lines) == 1 + len(whole.history["step"])


SLIDING = [
    {"control": "opening", "to": 0.02, "steps": 6},
    {"control": "driven", "angle": 90.0, "hold": False, "to": 0.05, "steps": 8},
]
PUSHED = {"mesh.crack_size": 50.0, "mesh.far_size": 60.0, "output.frames": 0, "stage": SLIDING}

#: what else a stepper may know of when it is stopped: a turned platen with springs, dead loads, a found path, a solid
OTHERS: dict[str, tuple[str, dict[str, Any]]] = {
    "springs": ("push-off", PUSHED),
    "a turn": ("notched-beam", {"mesh.crack_size": 5.0, "mesh.far_size": 12.0,
                                "stage": [{"control": "opening", "to": [0.02, 0.01, 0.03], "steps": 4}]}),  # in row 10
    "weight": ("petersson", {"material.density": 2400.0, "mesh.crack_size": 10.0, "mesh.far_size": 40.0, "stage.0.steps": 13}),
    "found": ("notched-beam", {"specimen.crack": "grow", "specimen.notch_position": 20.0, "mesh.crack_size": 5.0,
                               "mesh.far_size": 12.0, "stage.0.steps": 13}),
    "solid": ("single-crack-3d", {"mesh.crack_size": 20.0, "mesh.far_size": 20.0,
                                  "stage": [{"control": "driven", "to": [0.02, 0.0], "steps": 6}]}),
}  # fmt: skip


@pytest.mark.parametrize("what", OTHERS)
def test_what_a_run_knows_is_in_its_checkpoint(what: str, tmp_path: Path) -> None:
    name, keys = OTHERS[what]
    scene = Scene.load(name).with_(**keys)
    whole = run(scene)
    killed(scene, tmp_path, EVERY + 1)
    resumed = resume(tmp_path)
    assert_equal(whole, resumed)
    assert (whole.found is None) == (resumed.found is None) and resumed.scene.data["specimen"] == whole.scene.data["specimen"]
    np.testing.assert_array_equal(resumed.frame(-1).displacement, whole.frame(-1).displacement)


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
    for content in (b"", b"no checkpoint at all", packed([1, 2]), packed({"version": "1"})):
        (tmp_path / NAME).write_bytes(content)
        with pytest.raises(SceneError, match=rf"^'.*{NAME}': (cannot be read: .*; expected the checkpoint|was written)"):
            resume(tmp_path)
    killed(block(stage=CYCLES), tmp_path, EVERY + 1)
    with open(tmp_path / NAME, "rb") as file:
        head, rest = unpacked(file), file.read()
    (tmp_path / NAME).write_bytes(packed(head | {"nodes": head["nodes"] + 1e-9}) + rest)
    with pytest.raises(SceneError, match="the mesh came out differently"):
        resume(tmp_path)
    broken = bytearray(rest)
    broken[len(rest) // 2] ^= 1
    (tmp_path / NAME).write_bytes(packed(head) + broken)
    with pytest.raises(SceneError, match="cannot be read: its content is not that which was written"):
        resume(tmp_path)
    (tmp_path / NAME).write_bytes(packed(head | {"version": "0.0"}) + rest)
    with pytest.raises(SceneError, match=r"was written by version 0\.0"):
        resume(tmp_path)
    assert main(["run", "notched-beam", "--resume", str(tmp_path)]) == 2
    assert "expected no SCENE" in capsys.readouterr().err
    assert main(["run"]) == 2
    assert "expected SCENE" in capsys.readouterr().err


def _heads(head: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """With a field of another type, and without it."""
    for key in head:
        yield {name: value for name, value in head.items() if name != key}
        for wrong in (1, [1], {}, np.zeros((2, 2)), {"a": 1.0}):
            yield head | {key: wrong}


def test_a_checkpoint_with_a_wrong_entry_is_refused(tmp_path: Path) -> None:
    scene = block(stage=CYCLES)
    killed(scene, tmp_path, EVERY + 1)
    with open(tmp_path / NAME, "rb") as file:
        head, rest = unpacked(file), file.read()
    for wrong in _heads(head):
        (tmp_path / NAME).write_bytes(packed(wrong) + rest)
        with pytest.raises(SceneError) as caught:
            resume(tmp_path)
        assert "\n" not in str(caught.value)


def _records(rows: Any, stood: dict[str, Any]) -> Iterator[Any]:
    """With rows, states, and what a stepper knows, of other types and shapes."""
    (first, state), *later = rows
    short = replace(state, v=state.v[:-1])
    for wrong in (None, 1, [1], [[1, 2]], [({}, state)], [(first | {"load": "x"}, state)], [(first, short)]):
        yield wrong, stood
    yield [(first | {"load": 1}, state), *later], stood
    for key in stood:
        yield rows, {name: value for name, value in stood.items() if name != key}
        for other in ([1], {"a": "b"}, 0.5):
            yield rows, stood | {key: other}
    for key in stood["path"]:
        yield rows, stood | {"path": stood["path"] | {key: ["x"]}}
    yield rows, stood | {"_number": 99}
    yield rows, stood | {"_slack": {}}
    yield rows, stood | {"_state": short}
    yield rows, stood | {"_state": replace(state, v=state.v.astype(str))}
    yield rows, stood | {"_state": replace(state, load="x")}


@pytest.mark.long
def test_a_record_with_a_wrong_entry_is_refused(tmp_path: Path) -> None:
    scene = block(stage=CYCLES)
    killed(scene, tmp_path, EVERY + 1)
    classes = {Actuator, Equilibrium, Loading, Springs, State, Step} | classes_in(prepare(scene).model.problem.initial())
    with open(tmp_path / NAME, "rb") as file:
        head, record = unpacked(file), unpacked(file, *classes)
    for i, wrong in enumerate(_records(*record)):
        (tmp_path / NAME).write_bytes(packed(head) + packed(wrong))
        with pytest.raises(SceneError, match=r"cannot be read: .*; expected the checkpoint of a run"):
            resume(tmp_path)
            pytest.fail(f"{i}: {wrong}")


def _killed_by_signal(folder: Path, after: float) -> bool:
    """A run in another process, killed some seconds after its first row; whether it was in time."""
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
