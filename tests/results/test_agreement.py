"""How far a run lies from measured curves: numbers, sentences, run.json and the figure."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy.integrate import trapezoid

from cohesive import Result, Scene, run
from cohesive.arrays import Array
from cohesive.figures.drawing import abscissa, draw_reference
from cohesive.measured.curve import Measured, Reference
from cohesive.results.agreement import agreement, agreement_lines
from tests.builders import coarse_beam

X, Y = np.array([0.0, 1.0, 3.0]), np.array([0.0, 10.0, 4.0])


def history(x: Array = X, y: Array = Y) -> dict[str, Array]:
    return {"driven": x[1:], "load": y[1:]}


def test_a_curve_is_judged_over_the_common_range() -> None:
    judged = agreement(Measured.from_curve(np.array([-1.0, 0.5, 2.0, 5.0]), np.array([3.0, 6.0, 8.0, 2.0])), X, Y, 10.0)
    assert judged is not None
    assert (judged.start, judged.end, judged.points) == (0.0, 3.0, 0)
    # at 0, .5, 1, 2, 3: measured 5, 6, 6 2/3, 8, 6; computed 0, 5, 10, 7, 4
    gap = np.array([-5.0, -1.0, 10 / 3, -1.0, -2.0])
    at = np.array([0.0, 0.5, 1.0, 2.0, 3.0])
    assert judged.rms == pytest.approx(np.sqrt(trapezoid(gap**2, at) / 3.0) / 8.0, rel=1e-6)
    assert judged.area == pytest.approx(19.0 / (2.75 + 19 / 6 + 22 / 3 + 7.0) - 1.0, rel=1e-6)
    assert judged.peak == pytest.approx(10 / 8 - 1)
    assert agreement(Measured.from_curve(np.array([4.0, 5.0]), np.ones(2)), X, Y, 10.0) is None


def test_a_band_is_judged_by_its_points() -> None:
    band = Measured.from_band(
        np.array([0.5, 1.0, 2.0, 4.0]), np.array([4.0, 11.0, 4.0, 0.0]), np.array([6.0, 12.0, 5.0, 1.0])
    )
    judged = agreement(band, X, Y, 10.0)
    assert judged is not None
    assert (judged.inside, judged.points) == (1, 3)
    assert judged.outside == ((1.0, 10.0, pytest.approx(-1 / 11)), (2.0, 7.0, pytest.approx(2 / 5)))
    lines = agreement_lines(Reference("measured", "driven", (band,)), history(), 10.0)
    assert lines[0] == "measured: 1 of 3 points inside the band"
    assert lines[1:] == ["  outside at 1 mm: 10 N, 9.1 % below the band", "  outside at 2 mm: 7 N, 40.0 % above the band"]


def test_a_doubted_curve_is_not_judged() -> None:
    doubted = replace(Measured.from_curve(X, Y), notes=("is it in kN?",), doubt="is it in kN?")
    assert agreement_lines(Reference("measured", "driven", (doubted,)), history(), 10.0) == ["measured: is it in kN?"]


def test_repeats_are_judged_each_and_as_their_mean() -> None:
    tests = tuple(Measured.from_curve(X, factor * Y, f"{factor}.csv") for factor in (0.9, 1.0, 1.1))
    lines = agreement_lines(Reference("tests", "driven", tests), history(), 10.0)
    assert len(lines) == 5
    assert lines[0].startswith("tests (0.9.csv): rms ") and "peak +11.1 %" in lines[0]
    assert lines[3].startswith("tests, mean of 3: rms 0.0 % of its peak, area 0.0 %")
    # a tenth of the load, 0, 1 and .4 N: the mean of its square over x is (.5 + 1.16) / 3
    assert lines[4] == "  between the tests: 7.4 % of the mean's peak (standard deviation), peaks 10 +- 1 N"


@pytest.fixture(scope="module")
def with_curve(tmp_path_factory: pytest.TempPathFactory) -> Result:
    """A coarse beam with 1.1 times its own load-deflection curve as the measured one."""
    folder = tmp_path_factory.mktemp("measured")
    beam = coarse_beam("notched-beam", "stress")
    plain = run(Scene({key: value for key, value in beam.data.items() if key != "reference"}))
    rows = zip(plain.history["driven"].tolist(), (1.1e-3 * plain.history["load"]).tolist(), strict=True)
    (folder / "test.csv").write_text("Stroke [mm];Load [kN]\n" + "".join(f"{a!r};{b!r}\n" for a, b in rows))
    return run(Scene(plain.scene.data | {"reference": {"file": "test.csv", "label": "test 1"}}, folder))


def test_summary_run_json_and_figure_say_the_same(with_curve: Result, tmp_path: Path) -> None:
    (judged,) = with_curve.agreement
    h = with_curve.history
    away = 0.1 * h["load"]
    at = h["driven"]
    wanted = np.sqrt(trapezoid(away**2, at) / (at[-1] - at[0])) / (1.1 * with_curve.peak_load)
    assert judged.rms == pytest.approx(wanted, rel=1e-9)
    assert judged.area == pytest.approx(1 / 1.1 - 1, rel=1e-9)
    rms = f"rms {100 * judged.rms:.1f} % of its peak"
    assert f"test 1: {rms}, area -9.1 %, peak -9.1 %, over driven from " in with_curve.summary()
    with_curve.save(tmp_path)
    said = json.loads((tmp_path / "run.json").read_text())["reference"]
    assert said["against"] == "driven" and said["curves"][0]["rms"] == judged.rms
    axes = Figure().add_subplot()
    draw_reference(axes, with_curve, "driven", with_distance=True)
    assert axes.get_legend_handles_labels()[1] == [f"test 1, {rms}"]
    name, x, _ = abscissa(with_curve)
    assert name == "driven" and x[-1] == h["driven"][-1]
