"""Curves with kinks have two tangents there: Newton's method must not cycle between them."""

from __future__ import annotations

import numpy as np
import pytest

from cohesive import Scene, run


@pytest.mark.parametrize("curves", [12, pytest.param(200, marks=pytest.mark.slow)])
def test_random_piecewise_linear_curves_through_the_beam(curves: int) -> None:
    """None stops, and none dissipates more than its own energy."""
    random = np.random.default_rng(14)
    beam = Scene.load("notched-beam")
    data = {key: value for key, value in beam.data.items() if key != "reference"}
    for _ in range(curves):
        w = np.r_[0.0, np.cumsum(random.uniform(0.004, 0.04, random.integers(2, 6)))]
        stress = np.r_[np.sort(random.uniform(0.1, 4.0, len(w) - 1))[::-1], 0.0]
        material = {"E": 37e3, "nu": 0.2, "softening": {"points": np.column_stack([w, stress]).tolist()}}
        scene = Scene(data | {"material": material}).with_(
            **{"mesh.crack_size": 2.5, "mesh.far_size": 12.0, "stage.0.steps": 25, "output.frames": 0}
        )
        result = run(scene)
        assert result.history["opening"][-1] > 0.1799 or "no traction is left" in result.notes[-1]
        assert 0 < result.dissipated_energy <= 1.0001 * (result.full_energy or 0.0)
