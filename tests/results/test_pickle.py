"""Results travel between processes: what is pickled, what comes back, and what stays behind."""

from __future__ import annotations

import json
import multiprocessing
import pickle
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from cohesive import Comparison, NotConverged, Result, Scene, compare, run
from cohesive.results.record import Record

SMALL = {"mesh.crack_size": 5.0, "mesh.far_size": 12.0, "stage.0.steps": 8}


@pytest.fixture(scope="module")
def comparison() -> Comparison:
    return compare(Scene.load("notched-beam").with_(**SMALL))


def again(thing: object) -> object:
    return pickle.loads(pickle.dumps(thing))


def files(folder: Path) -> dict[str, bytes]:
    """All files by name; of run.json without the time that writing took, which the summary tells, too."""
    found = {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    for name in [name for name in found if name.endswith("run.json")]:
        facts = json.loads(found[name])
        del facts["timings"]["output"], facts["summary"]
        found[name] = json.dumps(facts).encode()
    return found


@pytest.mark.parametrize("model", ["discrete", "smeared"])
def test_a_result_comes_back_whole(comparison: Comparison, model: str, tmp_path: Path) -> None:
    result: Result = getattr(comparison, model)
    copy = again(again(result))
    assert isinstance(copy, Result)
    np.testing.assert_equal(copy.history, result.history)
    for row in range(len(result.states)):
        np.testing.assert_array_equal(copy.frame(row).displacement, result.frame(row).displacement)
    for one, other in zip(copy.opening_profile(-1), result.opening_profile(-1), strict=True):
        np.testing.assert_array_equal(one, other)
    assert copy.summary() == result.summary()
    for one, folder in ((result, tmp_path / "result"), (copy, tmp_path / "copy")):
        one.save(folder)
    assert files(tmp_path / "copy") == files(tmp_path / "result")


@pytest.mark.parametrize("condensation", ["always", "never"])
def test_the_factorization_stays_behind(condensation: str) -> None:
    result = run(Scene.load("notched-beam").with_(**SMALL, **{"solver.condensation": condensation}))
    copy = again(result)
    assert isinstance(copy, Result) and copy.model.condensation.kind == result.model.condensation.kind
    np.testing.assert_array_equal(copy.frame(3).displacement, result.frame(3).displacement)
    with pytest.raises(AttributeError, match="does not carry the stiffness of its body; run its scene again"):
        copy.problem.elastic_energy(copy.last.v)


@pytest.mark.long
def test_a_pickle_is_small() -> None:
    """Displacements and states of all rows: 0.7 MB in the discrete model, 1.2 MB in the smeared one."""
    for model in ("discrete", "smeared"):
        assert len(pickle.dumps(run(Scene.load("notched-beam"), model))) < 2e6


@pytest.mark.long
def test_a_comparison_comes_back_whole(comparison: Comparison, tmp_path: Path) -> None:
    copy = again(comparison)
    assert isinstance(copy, Comparison) and copy.table == comparison.table and copy.notes == comparison.notes
    comparison.save(tmp_path / "comparison")
    copy.save(tmp_path / "copy")
    assert files(tmp_path / "copy") == files(tmp_path / "comparison")


def test_a_scene_comes_back_whole() -> None:
    scene = Scene.load("jacobsen-mixed-mode")
    copy = again(scene)
    assert isinstance(copy, Scene) and copy.data == scene.data and copy.stages == scene.stages and copy.folder == scene.folder


@pytest.mark.long
def test_processes_run_scenes(comparison: Comparison) -> None:
    """What a run that stops early has computed comes back with the exception."""
    scene = Scene.load("notched-beam").with_(**SMALL)
    beyond = scene.with_(**{"stage.0.control": "load", "stage.0.to": 1600.0, "stage.0.steps": 3})
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        done, stopped = pool.submit(run, scene), pool.submit(run, beyond)
        np.testing.assert_array_equal(done.result().history["load"], comparison.discrete.history["load"])
        with pytest.raises(NotConverged, match="control = 'opening' or 'driven' goes on past the peak") as caught:
            stopped.result()
    assert isinstance(caught.value.result, Result) and caught.value.result.steps > 0


def test_a_run_without_a_step_comes_back() -> None:
    scene = Scene.load("notched-beam").with_(**SMALL)
    full = run(scene)
    empty = again(Result(full.scene, full.model, Record(full.problem), ["stopped: at once"], None))
    assert isinstance(empty, Result) and empty.notes == ["stopped: at once"] and empty.peak_load == 0.0
