"""The element edges of a mesh along polylines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import meshio
import numpy as np

from ..arrays import Array, Index
from ..cells import BULK_2D
from ..errors import MeshError
from ..paths import SLACK, Line, Point, as_text, nodes_on_segment, path_length
from .stars import Star, touching


def edges_on_path(mesh: meshio.Mesh, name: str, lines: Sequence[Line]) -> Index:
    """Element edges of a 2D mesh that lie on polylines, in the direction of the path: (n, 2) corner nodes; MeshError if a
    polyline has no length, or is not covered by element edges from end to end."""
    points = mesh.points
    slack = SLACK * float(np.ptp(points, axis=0).max())
    total, covered = path_length(name, lines), 0.0
    left: Point | None = None
    directed = [np.empty((0, 2), dtype=np.int64)]
    segments = [(a, b, nodes_on_segment(points, a, b, slack)) for line in lines for a, b in pairwise(line)]
    if not segments:
        return directed[0]
    cells = [(block.type, block.data.astype(np.int64)) for block in mesh.cells if block.type in BULK_2D]
    star = Star.from_cells(touching(cells, np.any([inside for *_, inside in segments], axis=0), least=2)[0])
    _, first = np.unique(star.facet, return_index=True)
    edges = star.nodes[first, :2]
    for a, b, inside in segments:
        on = edges[inside[edges].all(axis=1)]
        along = (points[on[:, 1]] - points[on[:, 0]]) @ (np.subtract(b, a) / math.dist(a, b))
        directed.append(np.where((along > 0)[:, None], on, on[:, ::-1]))
        covered += float(abs(along).sum())
        left = left or _first_gap(points[on], a, b)
    if abs(covered - total) > 1e-6 * total:
        raise MeshError(
            f"{name} path of length {total:g} mm: {covered:g} mm of it follow element edges inside the body"
            f"{'' if left is None else f', which it leaves at {as_text(left)}'}; expected all of it"
        )
    return np.concatenate(directed)


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
