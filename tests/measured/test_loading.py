"""Which rows of a file belong to the test, and what its motion is counted from."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cohesive import Measured, Scene, SceneError, read_measured
from cohesive.arrays import Array
from cohesive.measured.noise import deviation_of, pooled, unloadings
from cohesive.scenes.reference import load_reference
from tests.builders import coarse_beam
from tests.measured.files import table

STIFFNESS = 1e6  # N/mm


def load_at(x: Array) -> Array:
    """A curve that rises in a straight line to 10 kN at .01 mm, and falls."""
    return np.where(x < 0.01, STIFFNESS * x, 1e4 * np.exp(-np.maximum(x - 0.01, 0.0) / 0.05))


TEST = np.r_[np.linspace(0.0, 0.02, 400), np.linspace(0.02, 0.3, 400)[1:]]


def write(folder: Path, x: Array, y: Array, **keys: Any) -> Measured:
    path = folder / "test.csv"
    path.write_text(table("CMOD [mm],Load [N]", x, y), encoding="utf-8")
    return read_measured(path, **keys)


def noise(count: int, size: float, seed: int = 1) -> Array:
    return size * np.random.default_rng(seed).normal(size=count)


def test_no_row_is_dropped_for_running_back_with_noise(tmp_path: Path) -> None:
    x = TEST + noise(len(TEST), 5e-4)
    measured = write(tmp_path, x, load_at(TEST))
    np.testing.assert_allclose(measured.rows[0], x, atol=1e-9)
    assert (np.diff(measured.x) > 0).all() and len(measured.x) > len(x) / 3
    assert "noise lets cmod run back" in measured.notes[0] and len(measured.notes) == 1


def test_means_of_neighbours_are_not_biased_as_the_furthest_rows_are() -> None:
    """The furthest row so far lies 1 to 2 standard deviations too far."""
    x = np.linspace(0.0, 0.01, 2000)
    seen = x + noise(len(x), 5e-4)
    at, load = pooled(seen, STIFFNESS * x)
    middle = (load > 2e3) & (load < 8e3)
    assert abs(np.mean(load / STIFFNESS - at, where=middle)) < 5e-5  # a tenth of the noise
    first = np.diff(np.maximum.accumulate(seen), prepend=-1.0) > 0
    assert np.mean(seen[first] - x[first]) > 5e-4


@pytest.mark.parametrize("size", [0.0, 1e-5, 2e-4])
def test_noise_is_estimated_and_unloading_is_not_taken_for_it(size: float) -> None:
    """One cycle of .01 mm behind the peak; of 2e-4 mm noise it is 50 standard deviations long."""
    turn, back = 500, np.linspace(0.0, 0.01, 30)[1:]
    x = np.r_[TEST[:turn], TEST[turn - 1] - back, TEST[turn - 1] - back[::-1], TEST[turn:]]
    x += noise(len(x), size)
    assert deviation_of(x) == pytest.approx(size, rel=0.15, abs=2e-5)  # 7e-5 mm is the shortest step
    ((first, last),) = unloadings(x)
    assert abs(first - turn) <= 3 and abs(last - (turn + 58)) <= 3


def test_noise_alone_is_no_unloading() -> None:
    for seed in range(50):
        assert not unloadings(TEST + noise(len(TEST), 1e-3, seed))


@pytest.mark.parametrize("size", [0.0, 2e-4])
@pytest.mark.parametrize("count", [1, 3])
def test_pre_loads_and_the_last_unloading_are_cut_and_said(size: float, count: int, tmp_path: Path) -> None:
    cycle = np.r_[np.linspace(0.0, 0.004, 60), np.linspace(0.004, 0.0, 60)[1:]]
    before, after = np.tile(cycle, count), np.linspace(0.3, 0.1, 50)[1:]
    x = np.r_[before, TEST, after]
    y = np.r_[STIFFNESS * before, load_at(TEST), load_at(np.array([0.3])) * (after - 0.1) / 0.2]
    measured = write(tmp_path, x + noise(len(x), size), y)
    rows = measured.rows[0]
    assert len(rows) == pytest.approx(len(TEST), abs=8 if size else 1)
    assert measured.rows[1][0] < 500.0 and rows.max() == rows[-10:].max()
    said = " ".join(measured.notes)
    assert "a pre-load up to" in said and f"{len(after)} of" in said.replace(str(len(after) + 1), str(len(after)))
    assert "the unloading after the test is cut" in said


def test_cycles_in_a_test_are_left_out_and_what_follows_stays(tmp_path: Path) -> None:
    """To no load behind the peak: it is no pre-load."""
    turn, back = 600, np.linspace(0.0, 0.05, 40)[1:]
    x = np.r_[TEST[:turn], TEST[turn - 1] - back, TEST[turn - 1] - back[::-1], TEST[turn:]]
    top = load_at(TEST[turn - 1 : turn])
    y = np.r_[load_at(TEST[:turn]), top * (1 - back / 0.05), top * (1 - back[::-1] / 0.05), load_at(TEST[turn:])]
    measured = write(tmp_path, x, y)
    np.testing.assert_allclose(measured.x, TEST, atol=1e-9)
    assert "in 1 unloading(s)" in measured.notes[0]


def test_a_gauge_is_counted_from_where_all_early_rows_say(tmp_path: Path) -> None:
    """Its first row alone is off by its noise, which is a tenth of the way to 4 kN."""
    x = TEST + 1.234 + noise(len(TEST), 5e-4)
    measured = write(tmp_path, x, load_at(TEST))
    assert measured.x_offset == pytest.approx(1.234, abs=2e-4)
    assert "cmod begins at 1.234 mm" in measured.notes[-1]


def test_a_first_opening_that_may_be_meant_is_said(tmp_path: Path) -> None:
    measured = write(tmp_path, TEST + 0.001, load_at(TEST))
    assert "reference.x_offset = 0.001 counts from there" in measured.notes[0]
    again = write(tmp_path, TEST + 0.001, load_at(TEST), x_offset=0.001)
    np.testing.assert_allclose(again.x, TEST, atol=1e-9)
    assert again.notes == () and again.x_offset == 0.001


def test_rows_offsets_and_means(tmp_path: Path) -> None:
    part = write(tmp_path, TEST, load_at(TEST) + 50.0, rows=[101, 700], y_offset=50.0, x_offset=0.0)
    np.testing.assert_allclose([part.x, part.y], [TEST[100:700], load_at(TEST[100:700])], atol=1e-5)
    loaded = write(tmp_path, TEST, load_at(TEST), from_load=2e3)
    assert loaded.y[0] == pytest.approx(2e3, abs=50.0) and loaded.x[-1] == TEST[-1]
    means = write(tmp_path, TEST, load_at(TEST), smooth=4)
    assert len(means.x) == 200 and means.x[0] == pytest.approx(TEST[:4].mean())
    assert "means of 4 rows are taken" in means.notes


def test_a_toe_is_cut_where_the_straight_line_meets_no_load(tmp_path: Path) -> None:
    """Seating: the first kN takes .002 mm more."""
    seated = TEST + 0.002 * np.minimum(load_at(TEST) / 1e3, 1.0) ** 0.5 * (TEST < 0.01) + 0.002 * (TEST >= 0.01)
    measured = write(tmp_path, seated, load_at(TEST), toe=[0.2, 0.6])
    assert measured.x_offset == pytest.approx(0.002, abs=1e-6)
    np.testing.assert_allclose(measured.y[:50], STIFFNESS * measured.x[:50], rtol=1e-4)
    assert "toe: the straight line meets no load" in " ".join(measured.notes)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"rows": [5, 5000]}, r"it has 799 rows of data, the first is 1; expected reference.rows = \[5, 5000\] among them"),
        ({"from_load": 2e4}, "its largest load is 9995 N; expected more than reference.from_load"),
        ({"toe": [0.99999, 0.999999]}, "0 of its rows lie between"),
    ],
)
def test_corrections_that_leave_nothing_are_refused(keys: dict[str, Any], message: str, tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=message):
        write(tmp_path, TEST, load_at(TEST), **keys)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"x_offset": [0.1, 0.2]}, r"reference.x_offset = \[0.1, 0.2\]: expected a number, or a list of one for each file"),
        ({"rows": [1]}, r"reference.rows = \[1\]: expected \[first, last\]"),
        ({"toe": [0.4, 0.2]}, r"reference.toe = \[0.4, 0.2\]: expected \[low, high\]"),
        ({"toe": [0.1, 0.2], "x_offset": 0.1}, "x_offset = 0.1 says it, too"),
        ({"smooth": 1}, "reference.smooth = 1: expected a number above 1"),
        ({"from_load": -1.0}, "reference.from_load = -1.0: expected a number above 0, in N"),
    ],
)
def test_keys_without_sense_are_refused(keys: dict[str, Any], message: str, tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(table("CMOD [mm],Load [N]", TEST, load_at(TEST)), encoding="utf-8")
    scene = coarse_beam("notched-beam", "stress")
    with pytest.raises(SceneError, match=message):
        Scene({**scene.data, "reference": {"file": "a.csv"} | keys}, tmp_path)


def test_each_file_has_its_own_offset(tmp_path: Path) -> None:
    for name, offset in (("a.csv", 0.001), ("b.csv", -0.002)):
        (tmp_path / name).write_text(table("CMOD [mm],Load [N]", TEST + offset, load_at(TEST)), encoding="utf-8")
    keys = {"file": ["a.csv", "b.csv"], "x_offset": [0.001, -0.002], "rows": [1, 700]}
    reference = load_reference(Scene({**coarse_beam("notched-beam", "stress").data, "reference": keys}, tmp_path))
    assert reference is not None
    for curve in reference.curves:
        np.testing.assert_allclose(curve.x, TEST[:700], atol=1e-9)
