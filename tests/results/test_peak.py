"""The peak between the rows: its place and height, and the curves that tell no more than their largest row."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from cohesive import Result, Scene, compare, run, sweep
from cohesive.arrays import Array
from cohesive.figures.drawing import draw_curve, new_figure
from cohesive.results.peak import peak_weights

#: a curve whose peak of 100 N is at 1 mm, steeper before it than after it
PLACE, HEIGHT = 1.0, 100.0


def smooth(x: Array) -> Array:
    return HEIGHT * x * np.exp(1.0 - x)


def peak_of(x: Array, load: Array, quantity: Array | None = None) -> tuple[float, float]:
    rows, weights = peak_weights(np.atleast_2d(x), load)
    assert weights.sum() == pytest.approx(1.0, abs=1e-12)
    return float(weights @ (np.atleast_2d(x)[0] if quantity is None else quantity)[rows]), float(weights @ load[rows])


@pytest.mark.parametrize("first", [0.01, 0.03, 0.05, 0.07])
def test_it_does_not_depend_on_where_the_rows_are(first: float) -> None:
    """Rows of .08 mm: the largest one is off by up to .04 mm, and by .0008 of the height."""
    x = np.arange(first, 3.0, 0.08)
    at, load = peak_of(x, smooth(x))
    assert at == pytest.approx(PLACE, rel=5e-4) and load == pytest.approx(HEIGHT, rel=1e-5)
    assert peak_of(x, smooth(x), x**2)[0] == pytest.approx(PLACE**2, rel=1e-3)  # any other quantity there
    assert peak_of(1e-5 * x, 1e7 * smooth(x)) == pytest.approx((1e-5 * at, 1e7 * load), rel=1e-9)  # in any unit


@pytest.mark.parametrize("turns", [0.4, 1.0, 1.6])
def test_the_measure_may_run_back(turns: float) -> None:
    """A motion that turns before, at or behind the peak, as in a snap-back, beside an opening that grows."""
    opening = np.arange(0.013, 3.0, 0.03)
    x = 1.0 - 0.5 * (opening - turns) ** 2
    at, load = peak_of(np.array([x, opening]), smooth(opening))
    assert load == pytest.approx(HEIGHT, rel=1e-4)
    assert at == pytest.approx(1.0 - 0.5 * (PLACE - turns) ** 2, abs=1e-3)


ROWS = np.arange(1.0, 10.0)
LIKE_ITS_LARGEST_ROW = {
    "one row": ([1.0], [5.0]),
    "three rows that are high": (ROWS[:7], [10.0, 50.0, 99.0, 100.0, 99.5, 80.0, 40.0]),
    "the first row": (ROWS[:6], [100.0, 99.9, 99.7, 99.5, 99.3, 99.0]),
    "the last row": (ROWS[:6], [80.0, 99.0, 99.3, 99.6, 99.8, 100.0]),
    "a brittle drop": (ROWS[:8], [80.0, 98.9, 99.2, 99.5, 99.8, 100.0, 20.0, 10.0]),
    "all equal": (ROWS, np.full(9, 7.0)),
    "negative loads": (ROWS, -np.array([9.0, 8.0, 7.0, 6.1, 6.0, 6.1, 7.0, 8.0, 9.0])),
    "rows that coincide": ([1.0, 1.0, 1.0, 2.0, 2.0, 3.0], [99.0, 99.0, 99.0, 100.0, 100.0, 99.0]),
    "a gap through which the cubic swings": ([1.0, 1.01, 1.02, 4.0, 4.01], [98.6, 99.9, 100.0, 99.9, 98.6]),
    "no numbers": (np.full(6, np.nan), [99.0, 99.5, 100.0, 99.9, 99.5, 99.0]),
}  # fmt: skip


@pytest.mark.parametrize("name", LIKE_ITS_LARGEST_ROW)
def test_where_rows_tell_too_little_the_largest_one_counts(name: str) -> None:
    x, load = (np.asarray(each, dtype=float) for each in LIKE_ITS_LARGEST_ROW[name])
    rows, weights = peak_weights(x[None], load)
    assert (rows.tolist(), weights.tolist()) == ([load.argmax()], [1.0])


def test_equal_peaks_and_plateaus() -> None:
    x = np.arange(0.0, 8.0, 0.05)
    at, load = peak_of(x, 100.0 - 20.0 * np.minimum(abs(x - 2.0), abs(x - 6.0)) ** 2)
    assert (at, load) == (pytest.approx(2.0, abs=1e-3), pytest.approx(100.0, rel=1e-4))  # the first of them
    at, load = peak_of(x, np.minimum.reduce([np.full(len(x), 100.0), 40.0 * x, 100.0 - 60.0 * (x - 5.5)]))
    assert 2.5 <= at <= 5.5 and load == pytest.approx(100.0, rel=2e-3)


def test_it_is_never_lower_than_the_largest_row_by_more_than_the_residual() -> None:
    rng = np.random.default_rng(5)
    used = 0
    for _ in range(300):
        x = np.cumsum(rng.uniform(0.01, 0.2, 40))
        load = smooth(x) * (1.0 + rng.uniform(0.0, 0.004) * rng.standard_normal(len(x)))
        rows, weights = peak_weights(x[None], load)
        peak = float(weights @ load[rows])
        used += len(rows) > 1
        if len(rows) > 1:
            cubic = np.polynomial.Polynomial.fit(x[rows], load[rows], 3)
            residual = abs(cubic(x[rows]) - load[rows]).max()
            assert load.max() - residual - 1e-4 * HEIGHT <= peak <= 1.015 * load.max()  # this one over x, not the length
        else:
            assert peak == load.max()
    assert used > 60


@pytest.fixture(scope="module")
def beam() -> Scene:
    return Scene.load("en-14651").with_(**{"mesh.crack_size": 10.0, "mesh.far_size": 40.0, "stage.0.to": 0.1})


def test_one_number_everywhere(beam: Scene, tmp_path: Path) -> None:
    """Summary, notebook, run.json, figure, tables of compare and sweep, and the ratio to a measured peak."""
    rows = run(beam).history
    with open(tmp_path / "test.csv", "w") as file:
        csv.writer(file).writerows([("CMOD [mm]", "load [N]"), *zip(rows["cmod"], 1.1 * rows["load"], strict=True)])
    scene = Scene(beam.data | {"reference": {"file": "test.csv", "against": "cmod"}}, tmp_path)
    result = run(scene)
    peak, largest = result.peak, result.history["load"].max()
    assert 0.0 < abs(peak.load / largest - 1.0) < 2e-3 and peak.at not in result.history["cmod"]
    assert (peak.load, result.opening_at_peak) == (result.peak_load, result.at_peak(result.history["opening"]))
    text = f"{peak.load:.5g} N at cmod {peak.at:.4g} mm"
    assert f"peak load: {text}" in result.summary() and text in result._repr_html_()
    assert "peak -9.1 %" in result.summary()
    assert result.agreement[0].peak == pytest.approx(1.0 / 1.1 - 1.0, rel=1e-3)  # both lie between the rows, over cmod alone
    result.save(tmp_path / "out", pictures=False)
    facts = json.loads((tmp_path / "out" / "run.json").read_text())
    assert (facts["peak_load"], facts["curve"]["peak"], facts["curve"]["at_peak"]) == (peak.load, peak.load, peak.at)
    axes = new_figure(6.0, 4.0).add_subplot()
    draw_curve(axes, result)
    mark = next(line for line in axes.lines if line.get_label().startswith("peak"))
    assert (mark.get_xdata()[0], mark.get_ydata()[0]) == (peak.at, peak.load)
    swept = sweep(scene, {"material.Gf": [scene.material.Gf]}, workers=1).table
    assert (swept["peak"], swept["cmod_at_peak"]) == (pytest.approx([peak.load]), pytest.approx([peak.at]))
    both = compare(beam.with_(**{"band.width": 5.0})).table
    assert both["peak"]["discrete"] == pytest.approx(peak.load) and both["cmod_at_peak"]["discrete"] == pytest.approx(peak.at)


def test_twice_the_steps_move_it_less_than_its_row(beam: Scene) -> None:
    """Place by the cubic within a percent, by the row several percent."""
    results = [run(beam.with_(**{"stage.0.steps": steps})) for steps in (35, 41, 160)]
    places = [each.peak.at for each in results]
    assert places[:2] == pytest.approx([places[2]] * 2, rel=1e-2)
    by_rows = [float(each.history["cmod"][each.peak_row]) for each in results]
    assert max(abs(np.array(by_rows[:2]) / by_rows[2] - 1.0)) > 1e-2


def test_rows_under_another_direction_do_not_count() -> None:
    """A plate that is turned by 5 degrees shortly after its peak, where the load becomes that along another motion."""
    sizes = {"mesh.crack_size": 10.0, "mesh.far_size": 30.0, "output.frames": 0}
    stages = [
        {"control": "opening", "to": 0.0028, "steps": 60}, {"control": "driven", "angle": 5.0, "to": 0.006, "step": 0.0001},
    ]  # fmt: skip
    result = run(Scene.load("jacobsen-mixed-mode").with_(**sizes, stage=stages))
    stage, load = result.history["stage"], result.history["load"]
    assert stage[result.peak_row] == 1 and (load[stage == 2] > 0.985 * load.max()).any()
    assert result.at_peak(stage) == pytest.approx(1.0, abs=1e-9)


def test_a_run_without_a_step_has_none(beam: Scene) -> None:
    result = run(beam)
    empty = Result(**{**vars(result), "history": {name: values[:1] for name, values in result.history.items()}})
    assert (empty.peak.load, empty.peak.at, empty.opening_at_peak) == (0.0, 0.0, 0.0)
