"""Runs in several threads: the same numbers and pictures as in one, and the process as it was."""

from __future__ import annotations

import asyncio
import sys
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from cohesive import Result, Scene, run
from meshing.files.reading import load
from tests.builders import grid

SMALL = {"mesh.crack_size": 5.0, "mesh.far_size": 20.0, "stage.0.steps": 3, "output.frames": 0}
BEAM = Scene.load("notched-beam").with_(**SMALL)
SCENES = [BEAM, BEAM.with_(**{"mesh.shape": "quad"}), BEAM.with_(**{"specimen.notch": 25.0, "model.kind": "smeared"})] * 2


def assert_same(found: Result, expected: Result) -> None:
    for name in expected.history.keys() - {"wall_time"}:
        np.testing.assert_array_equal(found.history[name], expected.history[name], err_msg=name)


def test_threads_give_what_one_gives(tmp_path: Path) -> None:
    expected = [run(scene) for scene in SCENES]

    def saved(number: int, result: Result) -> bytes:
        result.save(tmp_path / str(number))
        return (tmp_path / str(number) / "curve.png").read_bytes()

    filters = list(warnings.filters)
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(run, SCENES))
        pictures = list(pool.map(saved, range(3), found))
    for ours, theirs in zip(found, expected, strict=True):
        assert_same(ours, theirs)
    assert pictures == [saved(100 + i, expected[i]) for i in range(3)]
    assert list(warnings.filters) == filters


def test_tasks_give_what_one_gives() -> None:
    async def both() -> list[Result]:
        return await asyncio.gather(*(asyncio.to_thread(run, scene) for scene in SCENES[:3]))

    for found, scene in zip(asyncio.run(both()), SCENES, strict=False):
        assert_same(found, run(scene))


def test_threads_that_read_leave_the_streams_in_place(tmp_path: Path) -> None:
    streams, path = (sys.stdout, sys.stderr), tmp_path / "squares.vtu"
    grid(12, 12).write(path)
    with ThreadPoolExecutor(8) as pool:
        meshes = list(pool.map(load, [path] * 200))
    assert len({mesh.points.tobytes() for mesh in meshes}) == 1
    assert (sys.stdout, sys.stderr) == streams
