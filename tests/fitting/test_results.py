"""What a fit leaves behind can be run again."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from cohesive import Scene, fit, run
from tests.builders import coarse_beam


def test_a_saved_scene_of_a_fit_repeats_its_rows(tmp_path: Path) -> None:
    """Its targets are the measured places, of which the scene that was given knows nothing."""
    scene = coarse_beam("notched-beam", "stress", solver__tol=1e-8)
    truth = run(scene)
    x, y = truth.history["opening"], truth.history["load"]
    places = np.linspace(0.0, x[-1], 12)
    start = scene.with_(**{"material.Gf": 0.09, "stage.0.steps": 5})
    fitted = fit(start, {"material.Gf": (0.05, 0.2)}, reference=(places, np.interp(places, x, y)), check=False)
    (result,) = fitted.results
    result.save(tmp_path, pictures=False)
    again = run(Scene.load(tmp_path / "scene.toml"))
    assert len(again.history["load"]) == len(result.history["load"]) > 6
    for name in ("load", "opening", "dissipated"):
        np.testing.assert_array_equal(again.history[name], result.history[name], err_msg=name)
