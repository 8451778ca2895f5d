"""Polylines and polygons: lengths, areas, points on them, distances from them and along them. Lengths in mm."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np

from .arrays import Array, Mask
from .errors import MeshError

Point = tuple[float, float]
Line = Sequence[Point]

#: points nearer than this part of the size of the body are one
SLACK = 1e-6


def segment_lengths(lines: Iterable[Line]) -> list[float]:
    """Length of each segment of some polylines."""
    return [math.dist(a, b) for line in lines for a, b in pairwise(line)]


def signed_area(corners: Line) -> float:
    """Area inside a polygon, mm^2; negative if its corners run clockwise."""
    x, y = np.asarray(corners, dtype=float).T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def contains(corners: Line, point: Sequence[float] | Array) -> bool:
    """Whether a point lies inside a polygon."""
    inside = False
    for a, b in zip(corners, [*corners[1:], corners[0]], strict=True):
        if (a[1] > point[1]) != (b[1] > point[1]):
            crossing = a[0] + (point[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
            inside ^= bool(crossing > point[0])
    return inside


def path_length(name: str, lines: Sequence[Line]) -> float:
    """Total length of polylines.

    Raises
    ------
    MeshError
        For a polyline with fewer than two points, or a segment without length.
    """
    total = 0.0
    for line in lines:
        if len(line) < 2:
            raise MeshError(f"{name} path {list(line)}: expected at least two points")
        for a, b in pairwise(line):
            length = math.dist(a, b)
            if not 0 < length < math.inf:
                raise MeshError(f"{name} path: segment from {tuple(a)} to {tuple(b)} has length {length:g}; expected > 0")
            total += length
    return total


def nodes_on_segment(points: Array, a: Point, b: Point, slack: float) -> Mask:
    """Which points (m, 2) lie on the segment from a to b, within a distance `slack`."""
    tangent = np.subtract(b, a) / math.dist(a, b)
    along, across = (points - a) @ tangent, (points - a) @ np.array([-tangent[1], tangent[0]])
    on = (abs(across) < slack) & (along > -slack) & (along < math.dist(a, b) + slack)
    return np.asarray(on)


def along_paths(points: Array, lines: Sequence[Line]) -> Array:
    """Distance along a path of its point nearest to each of some points, mm.

    Parameters
    ----------
    points : (m, 2)
    lines : polylines of the path, the distance running on from one to the next. Without one, the distance is along the longer
        side of the points' bounding box.
    """
    if not lines:
        span = np.ptp(points, axis=0)
        return np.asarray(points[:, span.argmax()] - points[:, span.argmax()].min())
    return _nearest(points, lines)[1]


def distance_to(point: Point, lines: Iterable[Line]) -> float:
    """Distance of a point from the nearest of some polylines, mm; infinite without one."""
    return float(_nearest(np.array([point], dtype=float), lines)[0][0])


def _nearest(points: Array, lines: Iterable[Line]) -> tuple[Array, Array]:
    """Distances of points (m, 2) from polylines, and how far along them their nearest points are."""
    nearest, position, start = np.full(len(points), np.inf), np.zeros(len(points)), 0.0
    for line in lines:
        for a, b in pairwise(np.asarray(line, dtype=float)):
            length = float(np.hypot(*(b - a)))
            along = np.clip((points - a) @ (b - a) / length, 0.0, length)
            distance = np.hypot(*(points - a - along[:, None] * (b - a) / length).T)
            closer = distance < nearest
            nearest[closer], position[closer] = distance[closer], start + along[closer]
            start += length
    return nearest, position


def as_text(point: Sequence[float] | Array) -> str:
    """A point as text."""
    return f"({', '.join(f'{c:g}' for c in point)})"
