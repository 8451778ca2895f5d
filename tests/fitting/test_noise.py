"""Noise of gauge and load cell does not move a fit, and its intervals say what it leaves."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cohesive import Scene, fit, run
from cohesive.arrays import Array
from cohesive.fitting.data import Data
from cohesive.fitting.noise import weighed
from cohesive.fitting.problem import at_rows
from cohesive.measured.curve import Measured, Reference
from examples.coverage import TRUTH as COVERED
from examples.coverage import LinearRun, beam, cover, linear_fit, noisy
from tests.fitting.test_fit import TRUTH, VARY, measured
from tests.fitting.test_fit import beam as small_beam

#: rows of a logger along a curve that rises in a straight line and falls
X = np.r_[np.linspace(0.0, 0.02, 600), np.linspace(0.02, 0.3, 600)[1:]]


def load_at(x: Array) -> Array:
    return np.where(x < 0.01, 1e6 * x, 1e4 * np.exp(-np.maximum(x - 0.01, 0.0) / 0.05))


def slope_at(x: Array) -> Array:
    return np.where(x < 0.01, 1e6, -1e4 / 0.05 * np.exp(-np.maximum(x - 0.01, 0.0) / 0.05))


@cache
def model() -> LinearRun:
    """Few places, between which it is smooth: the targets of a fit follow it."""
    openings = np.r_[np.linspace(0.0, 0.15, 26)[1:], np.geomspace(0.15, 2.05, 16)[1:]]
    return LinearRun.about(beam(size=12.5), [float(x) for x in openings])


@pytest.mark.parametrize(("opening", "of_load"), [(5e-4, 25.0), (5e-4, 0.1), (0.0, 25.0)])
def test_both_noises_are_told_from_the_residuals(opening: float, of_load: float) -> None:
    random = np.random.default_rng(2)
    x = X + opening * random.normal(size=len(X))
    curve = Measured.from_curve(x, load_at(X) + of_load * random.normal(size=len(X)))
    data = Data.from_reference(Reference("r", "opening", (curve,)), "arc")
    found = weighed(data, load_at(data.x), slope_at(data.x), 3)
    assert found is not None
    changed, noise = found
    assert noise.opening == pytest.approx(opening, rel=0.1)
    assert noise.load == pytest.approx(of_load, rel=0.1) or of_load == 0.1  # which the opening's hides
    assert noise.misfit < 25.0
    weights = np.asarray(changed.gather.sum(axis=1)).ravel()
    assert np.mean(weights**2) == pytest.approx(1.0)
    ratio = weights[-1] / weights[0]
    assert ratio > 3.0 if opening else 0.3 < ratio < 1.0 / 0.3  # but for the number of rows in a piece


def test_what_a_model_does_not_follow_is_no_noise() -> None:
    """A wave of 1 % over many rows: pieces count alike, and the loads are as exact as they are."""
    random = np.random.default_rng(2)
    wave = 100.0 * np.sin(np.arange(len(X)) / 40.0)
    curve = Measured.from_curve(X, load_at(X) + random.normal(size=len(X)))
    data = Data.from_reference(Reference("r", "opening", (curve,)), "arc")
    found = weighed(data, load_at(X) + wave, slope_at(X), 3)
    assert found is not None
    changed, noise = found
    assert noise.load == pytest.approx(1.0, rel=0.1) and noise.misfit == pytest.approx(70.0, rel=0.2)
    weights = np.asarray(changed.gather.sum(axis=1)).ravel()
    assert np.ptp(weights) < 0.01


def test_few_rows_and_bands_count_as_they_did() -> None:
    x = np.linspace(0.001, 0.3, 20)
    for curve in (Measured.from_curve(x, load_at(x)), Measured.from_band(X[1:], 0.9 * load_at(X[1:]), load_at(X[1:]))):
        data = Data.from_reference(Reference("r", "opening", (curve,)), "arc")
        assert weighed(data, load_at(data.x), slope_at(data.x), 3) is None


def test_intervals_of_noisy_files_hold_the_truth() -> None:
    """23 of 24 are expected; fewer than 20 come by chance once in 200 times. Equal weights hold E in half of the files."""
    found = cover(model(), 200, files=24, whole=0)
    for key in COVERED:
        assert found.held[key] >= 0.83, key
        assert abs(found.bias[key]) < 0.5, key
    assert found.deviation["material.E"] < 0.01


def test_thousands_of_rows_narrow_the_intervals_by_their_root() -> None:
    """5000 rows for 200: a fifth."""
    ends = [linear_fit(model(), noisy(model(), rows, 1))[1] for rows in (200, 5000)]
    wide, narrow = (np.log(each[:, 1] / each[:, 0]) for each in ends)
    np.testing.assert_array_less(3.0, wide / narrow)
    np.testing.assert_array_less(wide / narrow, 8.0)


def test_an_offset_is_found_for_each_curve() -> None:
    x, y = measured()
    curves = tuple(Measured.from_curve(x + by, y, f"test {by:g}", "opening") for by in (0.001, -0.002))
    vary = {"material.ft": VARY["material.ft"], "reference.x_offset": (-0.01, 0.01)}
    fitted = fit(small_beam(**{"material.ft": 2.5}), vary, reference=Reference("two", "opening", curves), check=False)
    assert fitted.values["material.ft"] == pytest.approx(TRUTH["material.ft"], rel=2e-3)
    assert fitted.values["reference.x_offset@1"] == pytest.approx(0.001, abs=2e-5)
    assert fitted.values["reference.x_offset@2"] == pytest.approx(-0.002, abs=2e-5)
    assert "reference" not in fitted.scenes[0].data


def test_a_fitted_scene_names_the_offset(tmp_path: Path) -> None:
    x, y = measured()
    np.savetxt(tmp_path / "a.csv", np.stack([x + 0.001, y], axis=1), delimiter=",", header="opening_mm,load_N", comments="")
    scene = Scene({**small_beam().data, "reference": {"file": "a.csv", "against": "opening"}}, tmp_path)
    fitted = fit(scene, {"reference.x_offset": (-0.01, 0.01)}, check=False)
    assert fitted.scenes[0].given("reference.x_offset") == pytest.approx(0.001, abs=2e-5)
    assert fitted.results[0].agreement[0].rms < 1e-3 < run(scene).agreement[0].rms


def test_an_offset_outside_its_bounds_is_refused(tmp_path: Path) -> None:
    with pytest.raises(Exception, match=r"a curve is counted from 0 mm; expected bounds around that"):
        fit(small_beam(), {"reference.x_offset": (0.1, 0.2)}, reference=measured())


def finer() -> tuple[Array, Array]:
    """The curve of a beam with elements of a third of the size."""
    return measured(**{"mesh.crack_size": 5.0 / 3.0, "mesh.far_size": 5.0})


def test_the_mesh_is_told_apart_from_noise_and_goes_into_the_intervals(tmp_path: Path) -> None:
    checked, unchecked = (fit(small_beam(), VARY, reference=finer(), check=each) for each in (True, False))
    for key, value in TRUTH.items():
        low, high = checked.intervals[key]
        assert low < value < high, key
        assert checked.mesh_errors[key] > 0.0 and np.isnan(unchecked.mesh_errors[key])
        assert high - low > np.diff(unchecked.intervals[key])[0]
    assert "  mesh " in checked.summary() and "  mesh " not in unchecked.summary()
    checked.save(tmp_path)
    assert json.loads((tmp_path / "fit.json").read_text())["mesh_errors"] == pytest.approx(checked.mesh_errors)


def test_waves_of_a_coarse_mesh_are_named() -> None:
    coarse: dict[str, Any] = {"mesh.order": 1, "mesh.crack_size": 12.0, "mesh.far_size": 25.0}
    fitted = fit(small_beam(**coarse), VARY, reference=finer())
    assert any("of the peak in the residuals are of the mesh or its steps" in note for note in fitted.notes)


def test_a_band_that_is_not_met_bears_no_interval(tmp_path: Path) -> None:
    x, y = measured(rows=10)
    low, high = 0.95 * y, 1.05 * y
    low[4] += 0.2 * y.max()
    high[4] += 0.2 * y.max()
    vary = {key: VARY[key] for key in ("material.ft", "material.Gf")}
    fitted = fit(small_beam(), vary, reference=Measured.from_band(x, low, high), check=False)
    assert fitted.interval_kind == "unknown" and np.isnan(fitted.intervals["material.ft"]).all()
    assert "intervals are not known: rows inside a band have no weight" in " ".join(fitted.identifiable)
    fitted.save(tmp_path)
    assert json.loads((tmp_path / "fit.json").read_text())["intervals"]["material.ft"] == [None, None]


def test_rows_before_zero_lie_on_the_initial_tangent() -> None:
    """Noise puts them there; a load of 0 would make the curve too soft."""
    scene = model().scene
    rows = model().run(COVERED, [scene.stages[0]])
    curve = Measured.from_curve(np.array([-0.002, -0.001, 0.0, 0.001]), np.arange(4.0), against="cmod")
    data = Data.from_reference(Reference("r", "cmod", (curve,)), "arc")
    load, slope = at_rows(rows, data)
    np.testing.assert_allclose(load[:3], slope[2] * data.x[:3], rtol=1e-9, atol=1e-9)
    assert slope[2] > 0
