"""Polylines and the element edges, nodes and distances along them. Lengths in mm."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from .arrays import Array, Index, Mask
from .errors import MeshError

if TYPE_CHECKING:
    import meshio

Point = tuple[float, float]
Line = Sequence[Point]

#: points nearer than this part of the size of the body are one
SLACK = 1e-6


def edges_on_path(mesh: meshio.Mesh, name: str, lines: Sequence[Line]) -> Index:
    """Element edges of a 2D mesh that lie on polylines, in the direction of the path: (n, 2) corner nodes.

    Raises
    ------
    MeshError
        If a polyline has no length, or is not covered by element edges from end to end.
    """
    from .cells import BULK_2D  # with meshio and SciPy, which are slow to import
    from .stars import Star, touching

    points = mesh.points
    slack = SLACK * float(np.ptp(points, axis=0).max())
    total, covered = path_length(name, lines), 0.0
    left: Point | None = None
    found = [np.empty((0, 2), dtype=np.int64)]
    segments = [(a, b, nodes_on_segment(points, a, b, slack)) for line in lines for a, b in pairwise(line)]
    if not segments:
        return found[0]
    cells = [(block.type, block.data.astype(np.int64)) for block in mesh.cells if block.type in BULK_2D]
    star = Star.from_cells(touching(cells, np.any([inside for *_, inside in segments], axis=0), least=2)[0])
    _, first = np.unique(star.facet, return_index=True)
    edges = star.nodes[first, :2]
    for a, b, inside in segments:
        on = edges[inside[edges].all(axis=1)]
        along = (points[on[:, 1]] - points[on[:, 0]]) @ (np.subtract(b, a) / math.dist(a, b))
        found.append(np.where((along > 0)[:, None], on, on[:, ::-1]))
        covered += float(abs(along).sum())
        left = left or _first_gap(points[on], a, b)
    if abs(covered - total) > 1e-6 * total:
        raise MeshError(
            f"{name} path of length {total:g} mm: {covered:g} mm of it follow element edges inside the body"
            f"{'' if left is None else f', which it leaves at {as_text(left)}'}; expected all of it"
        )
    return np.concatenate(found)


def _first_gap(edges: Array, a: Point, b: Point) -> Point | None:
    """From where on a segment from a to b is not covered by edges (n, 2, 2) on it; None if it is."""
    length = math.dist(a, b)
    along = np.sort((edges - a) @ (np.subtract(b, a) / length), axis=1)
    end = 0.0
    for start, stop in along[np.argsort(along[:, 0])].tolist():
        if start > end + 1e-6 * length:
            break
        end = max(end, stop)
    if end > (1.0 - 1e-6) * length:
        return None
    x, y = (float(p + end / length * (q - p)) for p, q in zip(a, b, strict=True))
    return round(x, 6), round(y, 6)


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
    nearest, position, start = np.full(len(points), np.inf), np.zeros(len(points)), 0.0
    for line in lines:
        for a, b in pairwise(np.asarray(line, dtype=float)):
            length = float(np.hypot(*(b - a)))
            along = np.clip((points - a) @ (b - a) / length, 0.0, length)
            distance = np.hypot(*(points - a - along[:, None] * (b - a) / length).T)
            closer = distance < nearest
            nearest[closer], position[closer] = distance[closer], start + along[closer]
            start += length
    return position


def as_text(point: Sequence[float] | Array) -> str:
    """A point as text."""
    return f"({', '.join(f'{c:g}' for c in point)})"
