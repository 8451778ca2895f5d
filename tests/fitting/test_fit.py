"""Fits of measured curves."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cohesive import Scene, SceneError, fit, run
from cohesive.arrays import Array
from cohesive.fitting.curve_choice import fit_curves
from cohesive.fitting.data import Data, effective_count
from cohesive.fitting.export import EXPORTS, points
from cohesive.fitting.fit import minima
from cohesive.fitting.parameters import Varied
from cohesive.measured.curve import Measured
from cohesive.scenes.scene import dump_toml

TRUTH = {"material.E": 30e3, "material.ft": 3.0, "material.Gf": 0.1}
VARY = {"material.E": (15e3, 60e3), "material.ft": (1.0, 8.0), "material.Gf": (0.03, 0.4)}


def beam(**changes: Any) -> Scene:
    data = {
        "title": "beam",
        "specimen": {
            "kind": "notched-beam", "length": 175.0, "span": 150.0, "depth": 50.0, "thickness": 50.0, "notch": 15.0,
            "gauge": 20.0,
        },
        "mesh": {"crack_size": 5.0, "far_size": 15.0, "shape": "quad"},
        "interface": {"width": 0.2},
        "material": {"E": 30e3, "nu": 0.2, "ft": 3.0, "Gf": 0.1, "softening": "hordijk"},
        "stage": [{"control": "opening", "to": 0.15, "steps": 12}],
    }  # fmt: skip
    return Scene(data).with_(**changes)


def measured(noise: float = 0.0, rows: int = 24, **changes: Any) -> tuple[Array, Array]:
    """Opening and load of a beam, with noise as a part of the peak."""
    history = run(beam(**{"stage.0.steps": rows} | changes)).history
    x, y = history["opening"][1:], history["load"][1:]
    return x, y + noise * y.max() * np.random.default_rng(3).normal(size=len(y))


OFF = {"material.E": 45e3, "material.ft": 1.5, "material.Gf": 0.15}


def test_the_truth_is_recovered_from_a_start_off_by_half() -> None:
    fitted = fit(beam(**OFF), VARY, reference=measured())
    for key, value in TRUTH.items():  # a thousandth: the steps of a fit end at 1e-4 of the scaled numbers
        assert fitted.values[key] == pytest.approx(value, rel=1e-3)
    assert fitted.rms < 1e-4
    assert fitted.condensations == 1
    # runs' worth of work, derivatives in 3 numbers cost .2 to .3 of a run; 8 steps, 10 with SciPy 1.12
    assert fitted.runs + 0.3 * fitted.sensitivities <= 13
    assert Scene({**beam().data, "material": {**beam().data["material"], "ft": 2.9}}).material.ft == 2.9
    assert "ft = " in fitted.scene


@pytest.mark.parametrize(("rows", "close"), [(12, 1e-4), pytest.param(250, 1e-3, marks=pytest.mark.slow)])
@pytest.mark.parametrize("density", [0.0, 60 * 2400.0])  # kg/m^3: for so small a beam it takes a heavy concrete
def test_own_curves_return_the_truth(rows: int, close: float, density: float) -> None:
    """Of a beam with and without weight, at each of its rows, and between them."""
    two = {key: VARY[key] for key in ("material.ft", "material.Gf")}
    weight = {"material.density": density}
    fitted = fit(beam(**OFF | weight | {"material.E": 30e3}), two, reference=measured(rows=rows, **weight), check=False)
    for key in two:
        assert fitted.values[key] == pytest.approx(TRUTH[key], rel=close)


def test_results_repeat_the_rows_of_the_fit() -> None:
    """Each result's scene names the places at which the fit stood, and its own number of rows comes out again."""
    weight = {"material.density": 60 * 2400.0}
    fitted = fit(beam(**weight), {"material.Gf": VARY["material.Gf"]}, reference=measured(rows=9, **weight), check=False)
    (result,) = fitted.results
    again = run(Scene(tomllib.loads(dump_toml(result.scene.data))))
    assert len(result.history["load"]) == len(fitted.best.rows[0].steps) + 1
    for name, column in fitted.best.rows[0].history.items():
        np.testing.assert_array_equal(column, result.history[name][1:])
        np.testing.assert_array_equal(again.history[name], result.history[name])


def test_a_minimum_is_met_again_though_it_is_not_the_first(monkeypatch: pytest.MonkeyPatch) -> None:
    ends = iter([0.0, 1.0, 1.0, 0.0, 2.0, 1.0])
    monkeypatch.setattr("cohesive.fitting.fit.minimize", lambda problem, z, strict: (z * 0.0 + next(ends), 1.0, 1))
    problem = Flat()
    fitted = minima(problem, [np.zeros(2)] * 6)  # type: ignore[arg-type]
    assert sorted((one.z[0], one.starts) for one in fitted) == [(0.0, 2), (1.0, 3), (2.0, 1)]


class Flat:
    """What `minima` asks of a problem."""

    parameters = (Varied("a", "a", (0,), 0.0, 1.0, 0.5), Varied("b", "b", (0,), 0.0, 1.0, 0.5))

    def by_name(self, z: Array) -> dict[str, float]:
        return dict(zip("ab", map(float, z), strict=True))

    def evaluate(self, z: Array) -> Array:
        return z

    def rms(self, evaluation: Array) -> float:
        return 0.0


def test_what_a_run_says_reaches_the_fit() -> None:
    until = {"stage.0.until": {"load_ratio": 0.6}}
    start = beam(**until, **{"material.Gf": 0.08})
    fitted = fit(start, {"material.Gf": VARY["material.Gf"]}, reference=measured(**until), check=False)
    assert "stage 1 ended where load_ratio = 0.6" in fitted.notes
    assert fitted.values["material.Gf"] == pytest.approx(0.1, rel=1e-3)  # as closely as an event is located


@pytest.mark.long
def test_intervals_of_noisy_data_hold_the_truth_and_files_are_written(tmp_path: Path) -> None:
    two = {key: VARY[key] for key in ("material.ft", "material.Gf")}
    fitted = fit(beam(**OFF | {"material.E": 30e3}), two, reference=measured(noise=0.02), profile=True)
    assert fitted.interval_kind == "profile"
    for key in two:
        value = TRUTH[key]
        low, high = fitted.intervals[key]
        assert low < value < high < 2.0 * value
    fitted.save(tmp_path)
    facts = json.loads((tmp_path / "fit.json").read_text())
    assert facts["values"] == pytest.approx(fitted.values)
    names = {path.name for path in tmp_path.iterdir()}
    assert {"fit.png", "fit.csv", "scene.toml", "softening-abaqus.inp", "softening-diana.dat", "softening-atena.txt"} <= names


@pytest.mark.long
def test_two_depths_share_numbers_and_have_their_own() -> None:
    deep = {"specimen.depth": 80.0, "specimen.notch": 24.0, "specimen.length": 265.0, "specimen.span": 240.0}
    data = [measured(), measured(**deep, **{"material.E": 33e3})]
    fitted = fit([beam(**OFF), beam(**OFF | deep)], VARY, reference=data, own=["material.E"])
    assert fitted.values["material.E@1"] == pytest.approx(30e3, rel=5e-3)
    assert fitted.values["material.E@2"] == pytest.approx(33e3, rel=5e-3)
    assert fitted.values["material.Gf"] == pytest.approx(0.1, rel=5e-3)


@pytest.mark.slow
def test_a_band_ends_in_the_feasible_set() -> None:
    x, y = measured(rows=10)
    band = Measured.from_band(x, 0.93 * y, 1.07 * y)
    fitted = fit(
        beam(**{"material.ft": 1.5, "material.Gf": 0.15}), {k: VARY[k] for k in OFF if k != "material.E"}, reference=band
    )
    assert fitted.interval_kind == "feasible"
    assert fitted.problem.data[0].inside(fitted.best.loads[0]) == 10
    low, high = fitted.intervals["material.Gf"]
    assert low < 0.1 < high


@pytest.mark.parametrize("key", ["material.c_zn", "material.c1", "material.r_sigma", "material.m_g"])
def test_what_the_test_does_not_see_is_refused(key: str) -> None:
    start = {"c_zn": 9.0, "c1": 5.0, "r_sigma": 1.25, "m_g": 0.425}[key.split(".")[1]]
    with pytest.raises(SceneError, match=f"{key}: the test does not see it"):
        fit(beam(), {"material.Gf": (0.03, 0.4), key: (0.9 * start, 1.5 * start)}, reference=measured())


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda x, y: (x, 1e-3 * y), "expected loads in N"),
        (lambda x, y: (x, 0.0 * y + 5.0), "does not change"),
        (lambda x, y: (x[:2], y[:2]), "expected a curve of at least 3"),
        (lambda x, y: (0.0 * x + 0.1, y), "expected a curve of at least 3"),
        (lambda x, y: (1e3 * x, y), "expected mm"),  # µm
        (lambda x, y: (1e-3 * x, y), "expected mm"),  # m
        (lambda x, y: (x, np.where(x > 0.05, np.nan, y)), "row 8: .*expected finite numbers"),
        (lambda x, y: (x, y[1:]), "expected two sequences of the same length"),
    ],
)
def test_bad_curves_are_refused(change: Any, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        fit(beam(), VARY, reference=change(*measured()))


def test_a_curve_that_stops_before_the_peak_gives_wide_intervals() -> None:
    x, y = measured(noise=0.01)
    before = slice(0, int(y.argmax()))
    x, y = np.linspace(0.0005, x[before][-1], 8), np.interp(np.linspace(0.0005, x[before][-1], 8), np.r_[0, x], np.r_[0, y])
    fitted = fit(beam(), VARY, reference=(x, y))
    low, high = fitted.intervals["material.Gf"]
    assert high / low > 2.0


@pytest.mark.long
def test_noise_of_a_fifth_gives_wide_intervals() -> None:
    fitted = fit(beam(**OFF), VARY, reference=measured(noise=0.2))
    for key, (low, high) in fitted.intervals.items():
        assert low < TRUTH[key] < high and high / low > 2.0
    assert "E is hardly seen" in " ".join(fitted.identifiable)


def test_a_curve_that_begins_behind_the_peak_gives_a_wide_interval_of_E() -> None:
    x, y = measured(noise=0.005)
    fitted = fit(beam(**OFF), VARY, reference=(x[x >= 0.02], y[x >= 0.02]))
    wide = {key: high / low for key, (low, high) in fitted.intervals.items()}
    assert wide["material.E"] > 2.0 > wide["material.Gf"]
    low, high = fitted.intervals["material.Gf"]
    assert low < TRUTH["material.Gf"] < high


def test_bounds_that_exclude_the_data_are_named() -> None:
    fitted = fit(beam(**{"material.ft": 1.2}), VARY | {"material.ft": (1.0, 1.5)}, reference=measured(), check=False)
    assert "ft stands at its bound, which decides it and not the data" in fitted.identifiable
    assert np.isnan(fitted.intervals["material.ft"]).all()  # it would be wider than a factor of 1000


@pytest.mark.long
def test_known_scatter_widens_the_intervals_by_what_it_does_to_the_fit() -> None:
    """Thickness and E scale all loads: 1 % of thickness is 1 % of E, ft and Gf at constant E Gf/ft^2."""
    data = measured(noise=0.001)
    known, scattered = (fit(beam(), VARY, reference=data, scatter=by, check=False) for by in ({}, {"specimen.thickness": 2.5}))
    for i, key in enumerate(VARY):
        before, after = (each.statistics.covariance[i, i] for each in (known, scattered))
        assert np.sqrt(after - before) == pytest.approx(0.05, rel=0.03), key  # of logarithms
    for by, message in (
        ({"material.E": 1e3}, "it is varied"),
        ({"specimen.notch": -1.0}, "a standard deviation above 0"),
        ({"specimen.notsch": 1.0}, "specimen.notsch"),
    ):
        with pytest.raises(SceneError, match=message):
            fit(beam(), VARY, reference=data, scatter=by, check=False)


def test_a_beam_is_evaluated_without_a_model_beside_its_fit(tmp_path: Path) -> None:
    to = {"stage.0.to": [0.02, 0.5]}
    fitted = fit(beam(**to), {"material.Gf": VARY["material.Gf"]}, reference=measured(rows=30, **to))
    values = fitted.evaluations[0].values
    assert values["E"] == pytest.approx(30e3, rel=0.2)  # by a formula, from rows that the crack bends already
    assert values["GF, tail"] == pytest.approx(0.1, rel=0.1)
    assert "without a model" in fitted.summary()
    fitted.save(tmp_path)
    assert json.loads((tmp_path / "fit.json").read_text())["evaluations"][0]["values"] == values


def test_a_fit_without_a_minimum_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cohesive.fitting.fit.is_stuck", lambda *_: True)
    fitted = fit(beam(), {"material.Gf": VARY["material.Gf"]}, reference=measured(), check=False)
    assert any(note.startswith("warning: no start ends in a minimum") for note in fitted.notes)


@pytest.mark.slow
def test_rows_of_a_logger_do_not_narrow_intervals() -> None:
    """Correlated residuals: every tenth of 3,000 rows gives intervals within a fifth."""
    x, y = measured(rows=40)
    dense = np.linspace(0.002, x[-1], 3000)
    wave = 0.01 * y.max() * np.sin(40.0 * dense / x[-1])
    load = np.interp(dense, np.r_[0.0, x], np.r_[0.0, y]) + wave
    whole, tenth = (fit(beam(**OFF), VARY, reference=(dense[::n], load[::n]), check=False) for n in (1, 10))
    for key in VARY:
        wide, narrow = (float(np.diff(each.intervals[key])[0]) for each in (whole, tenth))
        assert 1 / 1.2 < wide / narrow < 1.2


@pytest.mark.long
def test_the_right_curve_is_chosen() -> None:
    choice = fit_curves(beam(), VARY, ["exponential", "hordijk"], reference=measured(noise=0.003), check=False)
    assert choice.best == "hordijk"
    with pytest.raises(SceneError, match="points:N"):
        fit_curves(beam(), VARY, ["bezier"], reference=measured())


def test_effective_count() -> None:
    white = np.random.default_rng(0).normal(size=1000)
    assert effective_count([white]) > 700
    assert effective_count([np.repeat(white[:100], 10)]) == pytest.approx(100, rel=0.5)  # each ten times


def test_pieces_are_equally_long() -> None:
    x = np.linspace(0.001, 1.0, 1000)
    from cohesive.measured.curve import Reference

    data = Data.from_reference(Reference("m", "opening", (Measured.from_curve(x, x),)), "arc")
    assert data.gather.shape == (100, 1000)
    assert np.allclose(data.gather @ np.ones(1000), 1.0)


@pytest.mark.parametrize("softening", ["exponential", "hordijk", {"kink": [0.8, 0.3]}])
def test_exported_points_keep_the_energy(softening: Any) -> None:
    material = beam(**{"material.softening": softening}).material
    w, stress = points(material)
    assert 0.5 * (stress[1:] + stress[:-1]) @ np.diff(w) == pytest.approx(0.1, rel=0.01)
    for name in EXPORTS:
        assert EXPORTS[name][1](material).count("\n") > 5


@pytest.mark.long
def test_free_points_find_a_curve_and_name_the_direction_that_is_not_seen() -> None:
    """More points than the curve of a kink needs: along some direction they are not seen, and no interval is invented."""
    truth = {"material.softening": {"kink": [0.7, 0.25]}}
    x, y = measured(noise=0.01, **truth)
    fitted = fit_curves(beam(**OFF), VARY, ["points:6"], reference=(x, y), check=False).fits["points:6"]
    assert fitted.rms < 0.02
    (said,) = (words for words in fitted.identifiable if words.startswith("the data do not see"))
    assert "points." in said and "% of the peak" in said
    ends = np.array(list(fitted.intervals.values()))
    known = ends[~np.isnan(ends[:, 0])]
    assert (known[:, 1] / known[:, 0] <= 1e6).all()
    plain = fit(beam(**OFF), VARY, reference=(x, y), check=False)
    assert not any("do not see" in words for words in plain.identifiable)


@pytest.mark.parametrize("curve", ["points:51", "points:2", "points:" + "9" * 5000, "points:\u00b3", "points:", "points:-4"])
def test_a_number_of_points_without_sense_is_refused(curve: str) -> None:
    with pytest.raises(SceneError, match="points:N with N from 3 to 50"):
        fit_curves(Scene.load("notched-beam"), {"material.ft": (2.0, 5.0)}, [curve])


@pytest.mark.parametrize("starts", [0, -1, 1001, 10**9])
def test_a_number_of_starts_without_sense_is_refused(starts: int) -> None:
    with pytest.raises(SceneError, match=rf"^starts = {starts}: expected at least 1 and at most 1000"):
        fit(Scene.load("notched-beam"), {"material.ft": (2.0, 5.0)}, starts=starts)
