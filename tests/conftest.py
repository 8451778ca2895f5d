"""Fixtures that several rooms use."""

from __future__ import annotations

import os

import pytest

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the command line does: threads of parallel tests wait for each other

from cohesive import Scene


@pytest.fixture
def beam() -> Scene:
    """The built-in notched beam on a coarse mesh, 20 steps."""
    return Scene.load("notched-beam").with_(**{"mesh.crack_size": 2.5, "mesh.far_size": 12.0, "stage.0.steps": 20})
