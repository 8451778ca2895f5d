"""Measured curves as arrays, and the residuals that a fit stands on."""

from __future__ import annotations

import numpy as np

from cohesive.measured.curve import Measured, Reference


def test_residuals_are_those_at_the_measured_points() -> None:
    x, y = np.array([0.0, 1.0, 3.0]), np.array([0.0, 10.0, 4.0])
    at, load = np.array([0.5, 2.0, 3.0, 5.0]), np.array([4.0, 8.0, 4.0, 1.0])
    curve = Measured.from_curve(at, load)
    np.testing.assert_allclose(curve.residuals(x, y), [1.0, -1.0, 0.0, 3.0])  # beyond the end the last load counts
    band = Measured.from_band(at, np.array([4.0, 8.0, 1.0, 5.0]), np.array([4.5, 9.0, 5.0, 6.0]))
    np.testing.assert_allclose(band.residuals(x, y), [0.5, -1.0, 0.0, -1.0])
    both = Reference("two", "driven", (curve, band)).residuals({"driven": x[1:], "load": y[1:]})
    np.testing.assert_allclose(both, [1.0, -1.0, 0.0, 3.0, 0.5, -1.0, 0.0, -1.0])


def test_a_curve_that_goes_back_counts_where_it_comes_first() -> None:
    x, y = np.array([0.0, 1.0, 0.5, 1.0, 2.0]), np.array([0.0, 10.0, 1.0, 8.0, 6.0])
    nothing = Measured.from_curve(np.array([0.5, 1.0, 1.5]), np.zeros(3))
    np.testing.assert_allclose(nothing.residuals(x, y), [5.0, 10.0, 8.0])
    back = Measured.from_curve(x, y)
    np.testing.assert_array_equal([back.x, back.y], [[0.0, 1.0, 2.0], [0.0, 10.0, 6.0]])
