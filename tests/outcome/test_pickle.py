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

SMALL = {"mesh.crack_size": 5.0, "mesh.far_size": 12.0, "stage.0.steps": 8}


@pytest.fixture(scope="module")
def comparison() -> Comparison:
    return compare(Scene.load("notched-beam").with_(**SMALL))


def again(thing: object) -> object:
    return pickle.loads(pickle.dumps(thing))


def files(folder: Path) -> dict[str, bytes]:
    """All files by name; of run.json without the time that writing took, which the summary tells, too."""
    contents = {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    for name in [name for name in contents if name.endswith("run.json")]:
        facts = json.loads(contents[name])
        del facts["timings"]["output"], facts["summary"]
        contents[name] = json.dumps(facts).encode()
    return {name: content for name, content in contents.items() if not name.endswith(".npz")}  # they hold the time of writing


@pytest.mark.long
def test_a_pickle_is_small() -> None:
    """Displacements and states of all rows: 0.7 MB in the discrete model, 1.2 MB in the smeared one."""
    for model in ("discrete", "smeared"):
        assert len(pickle.dumps(run(Scene.load("notched-beam"), model))) < 2.5e6


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
