"""Distances along polylines."""

from __future__ import annotations

import math

import numpy as np
import pytest

from meshing import MeshError
from meshing.paths import along_paths, distance_to, nodes_on_segment, path_length, segment_lengths, signed_area


def test_the_distance_along_a_path_runs_on_from_polyline_to_polyline() -> None:
    lines = [[(0.0, 0.0), (4.0, 0.0), (4.0, 3.0)], [(10.0, 0.0), (10.0, 2.0)]]
    points = np.array([[-1.0, 0.0], [1.0, 0.5], [5.0, 2.0], [10.5, 1.0], [10.0, 9.0]])
    np.testing.assert_allclose(along_paths(points, lines), [0.0, 1.0, 6.0, 8.0, 9.0])
    assert path_length("crack", lines) == 9.0


def test_distance_to_a_polyline() -> None:
    assert distance_to((1.0, 1.0), [[(0.0, 0.0), (2.0, 0.0), (2.0, 5.0)]]) == pytest.approx(1.0)
    assert distance_to((3.0, 6.0), [[(0.0, 0.0), (2.0, 0.0), (2.0, 5.0)]]) == pytest.approx(math.sqrt(2.0))
    assert distance_to((1.0, 1.0), []) == math.inf


def test_lengths_and_areas() -> None:
    assert segment_lengths([[(0.0, 0.0), (4.0, 0.0), (4.0, 3.0)], [(1.0, 1.0)]]) == [4.0, 3.0]
    triangle = [(0.0, 0.0), (4.0, 0.0), (4.0, 3.0)]
    assert signed_area(triangle) == 6.0
    assert signed_area(triangle[::-1]) == -6.0


def test_without_a_path_the_distance_is_along_the_longer_side() -> None:
    np.testing.assert_allclose(along_paths(np.array([[1.0, 5.0], [2.0, -1.0], [3.0, 2.0]]), []), [6.0, 0.0, 3.0])


def test_nodes_on_a_segment_are_between_its_ends_and_not_beside_it() -> None:
    points = np.array([[0.0, 0.0], [1.0, 1.0], [2.0, 2.0], [3.0, 3.0], [1.0, 1.1]])
    assert nodes_on_segment(points, (0.0, 0.0), (2.0, 2.0), 1e-6).tolist() == [True, True, True, False, False]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ([(0.0, 0.0)], r"^crack path \[\(0\.0, 0\.0\)\]: expected at least two points$"),
        ([(1.0, 2.0), (1.0, 2.0)], r"^crack path: segment from \(1\.0, 2\.0\) to \(1\.0, 2\.0\) has length 0; expected > 0$"),
    ],
)
def test_a_polyline_without_length_is_refused(line: list[tuple[float, float]], message: str) -> None:
    with pytest.raises(MeshError, match=message):
        path_length("crack", [line])
