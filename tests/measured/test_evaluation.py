"""Standards for notched beams: formulae by hand, and the curve of a model whose numbers are known."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cohesive import SceneError
from cohesive.measured.curve import Measured
from cohesive.measured.evaluation import evaluate

BEAM: dict[str, Any] = {
    "specimen.span": 500.0, "specimen.depth": 150.0, "specimen.thickness": 150.0, "specimen.notch": 25.0,
    "specimen.length": 550.0, "mass": 30.0,
}  # fmt: skip


def test_work_of_fracture() -> None:
    triangle = Measured.from_curve(np.array([0.1, 2.0]), np.array([10e3, 0.0]), against="deflection")
    values = evaluate(triangle, "rilem-tc-50", BEAM).values
    assert values["W0"] == pytest.approx(10e3)
    assert values["GF"] == pytest.approx((10e3 + 30.0 * 500 / 550 * 9.80665 * 2.0) / (150 * 125))
    values = evaluate(replace(triangle, against="opening"), "jci-s-001", BEAM | {"mass_loading": 1.0}).values
    assert values["GF"] == pytest.approx((7500.0 + 0.75 * (30.0 * 500 / 550 + 2.0) * 9.80665 * 2.0) / (150 * 125))


def test_residual_strengths() -> None:
    x, y = np.array([0.02, 0.04, 0.5, 1.5, 2.5, 3.0]), np.array([9e3, 12e3, 10e3, 8e3, 6e3, 5e3])
    values = evaluate(Measured.from_curve(x, y, against="opening"), "en-14651", BEAM).values
    factor = 3 * 500.0 / (2 * 150.0 * 125.0**2)
    assert values["fct,L"] == pytest.approx(factor * 12e3)
    assert [values[f"fR{j}"] for j in (1, 2, 3)] == pytest.approx([factor * load for load in (10e3, 8e3, 6e3)])
    assert values["fR4"] is None


def test_a_curve_that_ends_while_it_rises_and_a_beam_without_a_notch_are_told() -> None:
    rising = Measured.from_curve(np.array([0.02, 0.04, 0.05]), np.array([9e3, 12e3, 13e3]), against="opening")
    assert "the load rises up to the last row" in " ".join(evaluate(rising, "en-14651", BEAM).notes)
    assert evaluate(rising, "en-14651", BEAM | {"specimen.notch": 0.0}).values["E"] is None


def test_the_tail_needs_no_mass_and_counts_what_was_not_measured() -> None:
    u = np.linspace(0.01, 1.0, 400)
    whole = np.where(u < 0.05, 200e3 * u, 25.0 / u**2)
    cut = Measured.from_curve(u, whole - 15.0, against="driven")  # 15 N of weight, and the end of the tail missing
    values = evaluate(cut, "rilem-tc-50", BEAM).values
    work = 0.5 * 10e3 * 0.05 + 25.0 / 0.05  # the triangle and the whole tail; 2 % for the rows and the weight before the peak
    assert values["GF, tail"] == pytest.approx(work / (150 * 125), rel=0.02)


def test_modulus_from_the_opening() -> None:
    a, d, b, S, E = 50.0, 100.0, 100.0, 400.0, 30e3
    V1 = 0.76 - 2.28 / 2 + 3.87 / 4 - 2.04 / 8 + 0.66 * 4
    compliance = 6 * S * a * V1 / (E * b * d**2)
    y = np.linspace(100.0, 1000.0, 10)
    beam = {"specimen.span": S, "specimen.depth": d, "specimen.thickness": b, "specimen.notch": a}
    values = evaluate(Measured.from_curve(compliance * y, y, against="cmod"), "en-14651", beam).values
    assert values["E"] == pytest.approx(E)


@pytest.mark.parametrize(
    ("values", "standard", "against", "message"),
    [
        ({**BEAM, "specimen.notch": None}, "en-14651", "opening", r"specimen\.notch is missing"),
        ({**BEAM, "mass": None}, "rilem-tc-50", "driven", "mass is missing"),
        (BEAM, "rilem-tc-50", "opening", "wants load over deflection"),
        (BEAM, "astm", "opening", "expected one of rilem-tc-50"),
        ({**BEAM, "mass": -1.0}, "rilem-tc-50", "driven", "mass = -1.0"),
    ],
)
def test_what_is_missing_is_asked_for(values: dict[str, Any], standard: str, against: str, message: str) -> None:
    curve = Measured.from_curve(np.array([0.1, 2.0]), np.array([10e3, 0.0]), against=against)
    with pytest.raises(SceneError, match=message):
        evaluate(curve, standard, values)
