"""Rows of a run as they come: which states a long run keeps, and what an interruption leaves."""

from __future__ import annotations

import tracemalloc
from array import array
from typing import Any

import numpy as np
import pytest

from cohesive import Result, Scene, run
from cohesive.results.record import Record, States
from cohesive.solver.problem import State
from cohesive.solver.stepper import Step
from tests.builders import block, plate, run_and_keep


def state(number: int) -> State:
    return State(np.array([float(number)]), 0.0, None)


def kept_of(rows: int, peak: int, frames: int = 5) -> States:
    states = States(frames)
    for row in range(rows):
        states.append(state(row), -abs(row - peak))
    return states


@pytest.mark.parametrize("peak", [3, 777, 4999, 19999])
def test_a_long_run_keeps_an_even_spread_the_peak_and_the_last(peak: int) -> None:
    states = kept_of(20_000, peak)
    assert len(states) == 20_000 and len(states.kept) <= 1003
    assert {0, peak, 19_999} <= set(states.kept.tolist())
    assert np.diff(states.kept).max() <= 2 * 20_000 / 1000  # never less than half of what it may keep
    assert all(states[row].v[0] == row for row in states.kept) and states[-1].v[0] == 19_999


def test_memory_does_not_grow_from_row_to_row() -> None:
    counts = [len(kept_of(rows, 40).kept) for rows in (1001, 2001, 5000, 20_000, 70_000)]
    assert max(counts) <= 1003


def test_a_run_of_1000_rows_keeps_all_and_frames_ask_for_more() -> None:
    assert len(kept_of(1000, 10).kept) == 1000
    many = kept_of(20_000, 10, frames=1000)
    assert np.diff(many.kept).max() <= 4  # 20 rows from frame to frame, met within a tenth


def test_the_peak_is_the_first_of_the_largest_and_not_the_unloaded_row() -> None:
    states = States()
    loads = [0.0, *[-2.0] * 1500, -1.0, *[-1.0] * 2000]
    for row, load in enumerate(loads):
        states.append(state(row), load)
    assert 1501 in states.kept and 1502 not in states.kept[states.kept % 4 != 0]


def test_frames_of_a_long_run_are_the_nearest_that_there_are(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cohesive.results.record.ALL_KEPT", 10)
    result = run(block(stage=[{"control": "opening", "to": 0.05, "steps": 90}], output__frames=3))
    assert len(result.fields.rows) < 40
    assert result.frame_rows() == sorted({result.peak_row, 28, 60, 90})
    frame = result.frame(-1)
    assert frame.step == 90 and result.frame(result.peak_row).step == result.peak_row


def test_a_row_that_an_interruption_cut_short_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    result, states, built = run_and_keep(block())
    record = Record(built.problem)
    for row in range(3):
        record.append(result.row(row), states[row])

    class Interrupting(array):  # type: ignore[type-arg]
        def append(self, value: Any) -> None:
            raise KeyboardInterrupt

    record.columns["opening"] = Interrupting("d", record.columns["opening"])
    with pytest.raises(KeyboardInterrupt):
        record.append(result.row(3), states[3])
    assert {len(values) for values in record.history.values()} == {3} and len(record.drive_travel) == len(record.states) == 3


def test_the_history_begins_with_the_unloaded_state_and_counts_whole_numbers() -> None:
    result = run(block())
    assert isinstance(result, Result)
    first = result.row(0)
    assert {name: value for name, value in first.items() if value} in (
        {"stage": 1},
        {"stage": 1, "effective_length": first["effective_length"]},
    )
    assert result.steps == 8 and list(result.history["step"]) == list(range(9))
    assert {name for name, values in result.history.items() if values.dtype.kind == "i"} == {
        "step",
        "iterations",
        "cuts",
        "stage",
    }


def test_the_way_is_that_of_the_drive_there_and_back_or_of_a_platen() -> None:
    result = run(block(stage=[{"control": "driven", "to": [0.02, 0.01], "steps": 5}]))
    np.testing.assert_allclose(result.drive_travel, np.r_[0.0, np.cumsum(abs(np.diff(result.history["driven"])))], atol=1e-15)
    assert result.drive_travel[-1] == pytest.approx(0.03, rel=1e-8)
    oblique = run(plate(stage=[{"control": "driven", "to": 0.01, "steps": 3, "angle": 30}]))
    np.testing.assert_allclose(oblique.drive_travel, oblique.history["driven"], rtol=1e-12)


@pytest.mark.slow
def test_memory_of_two_hundred_cycles_is_that_of_the_rows() -> None:
    """20,000 rows: what is held besides their numbers is no more in the second half than in the first."""
    peaks = [to for cycle in range(100) for to in (0.2 + 0.002 * cycle, 0.02)]
    stages = [{"control": "opening", "to": to, "steps": 100} for to in peaks]
    scene = Scene.load("notched-beam").with_(**{"mesh.crack_size": 5.0, "mesh.far_size": 25.0, "stage": stages})
    held: list[int] = []

    def watch(step: Step, row: dict[str, float]) -> None:
        if row["step"] % 100 == 0:
            held.append(tracemalloc.get_traced_memory()[0] - row["step"] * 8 * (len(row) + 1))

    tracemalloc.start()
    try:
        result = run(scene, on_step=watch)
    finally:
        tracemalloc.stop()
    assert result.steps > 20_000
    half = len(held) // 2
    assert max(held[half:]) < 1.05 * max(held[:half])
