"""Many runs at once."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from cohesive import run
from cohesive.studies.pool import run_all
from tests.builders import block

SCENES = [block(material__Gf=Gf, stage__0__steps=4) for Gf in (0.08, 0.1, 0.12)]


def test_results_come_in_the_order_of_the_scenes() -> None:
    with ThreadPoolExecutor(1) as pool:
        results = list(run_all(SCENES, pool))
    assert [result.scene.material.Gf for result in results] == [0.08, 0.1, 0.12]
    here, there = run(SCENES[1]), results[1]
    np.testing.assert_array_equal(here.history["load"], there.history["load"])


@pytest.mark.long
def test_without_an_executor_they_run_in_processes() -> None:
    (results,) = run_all(SCENES[:1])
    np.testing.assert_array_equal(results.history["load"], run(SCENES[0]).history["load"])


def test_a_run_that_stops_early_is_there_as_far_as_it_came() -> None:
    beyond = block(stage__0__control="load", stage__0__to=1600.0, stage__0__steps=3)
    with ThreadPoolExecutor(1) as pool:
        results = list(run_all([beyond, SCENES[0]], pool))
        assert results[0].notes[-1].startswith("stopped: ") and results[1].steps == 4
