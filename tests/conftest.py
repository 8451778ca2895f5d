"""Shared pieces of the tests."""

from __future__ import annotations

import os
from typing import Any

import pytest

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the command line does: threads of parallel tests wait for each other

from cohesive import Scene


@pytest.fixture
def beam() -> Scene:
    """The built-in notched beam on a coarse mesh, 20 steps."""
    return Scene.load("notched-beam").with_(**{"mesh.crack_size": 2.5, "mesh.far_size": 12.0, "stage.0.steps": 20})


def block(**changes: Any) -> Scene:
    """A block of 40 x 40 x 10 mm with one crack, 8 steps; `changes` with __ for the dots of the keys."""
    data: dict[str, Any] = {
        "title": "block",
        "specimen": {"kind": "single-crack", "width": 40.0, "height": 40.0, "thickness": 10.0},
        "mesh": {"crack_size": 8.0, "far_size": 8.0},
        "material": {"preset": "reinhardt"},
        "interface": {"width": 0.3},
        "solver": {"tol": 1e-11},
        "stage": [{"control": "opening", "to": 0.05, "steps": 8}],
    }
    return Scene(data).with_(**{key.replace("__", "."): value for key, value in changes.items()})


#: a scene on a mesh of the user's; the file is not there
OF_A_FILE: dict[str, Any] = {
    "specimen": {
        "kind": "mesh", "file": "a.msh", "thickness": 1.0, "crack": "c",
        "supports": [{"at": "b", "direction": [0, 1]}], "drive": {"at": "t", "direction": [0, 1]},
    },
    "material": {"preset": "reinhardt"},
    "stage": [{"control": "driven", "to": 0.1}],
}  # fmt: skip
