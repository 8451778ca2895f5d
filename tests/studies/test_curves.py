"""Curves, and how far they lie from measured ones."""

from __future__ import annotations

import numpy as np
import pytest

from cohesive.scenes.reference import Reference
from cohesive.studies.curves import Curve, Pair, residuals


def curve(opening: list[float], load: list[float]) -> Curve:
    return Curve(np.array(opening), np.array(load), np.zeros(len(load)), None)


def test_residuals_are_those_at_the_measured_points() -> None:
    found = curve([0.0, 1.0, 3.0], [0.0, 10.0, 4.0])
    at = np.array([0.5, 2.0, 3.0, 5.0])
    measured = Reference("measured", at, np.array([4.0, 8.0, 4.0, 1.0]), np.array([4.0, 8.0, 4.0, 1.0]))
    np.testing.assert_allclose(residuals(found, measured), [1.0, -1.0, 0.0, 3.0])  # beyond the end the last load counts
    band = Reference("band", at, np.array([4.0, 8.0, 1.0, 5.0]), np.array([4.5, 9.0, 5.0, 6.0]))
    np.testing.assert_allclose(residuals(found, band), [0.5, -1.0, 0.0, -1.0])


def test_a_curve_that_goes_back_counts_where_it_comes_first() -> None:
    cycle = curve([0.0, 1.0, 0.5, 1.0, 2.0], [0.0, 10.0, 1.0, 8.0, 6.0])
    at = np.array([0.5, 1.0, 1.5])
    nothing = Reference("nothing", at, np.zeros(3), np.zeros(3))
    np.testing.assert_allclose(residuals(cycle, nothing), [5.0, 10.0, 8.0])


def test_areas() -> None:
    pair = Pair.from_curves(curve([0.0, 1.0, 3.0], [0.0, 10.0, 4.0]), curve([0.0, 2.0], [0.0, 6.0]))
    assert pair.end == 2.0
    assert [pair.energy(0), pair.energy(1)] == pytest.approx([5.0 + 8.5, 6.0])
    assert pair.between() == pytest.approx(13.5 - 6.0)
