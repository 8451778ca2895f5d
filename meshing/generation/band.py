"""Meshes for the smeared crack: the mesh of the discrete crack, opened by the width of the band."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import meshio
import numpy as np

from ..arrays import Array
from ..cutting.opening import open_cracks
from ..errors import MeshError
from ..paths import SLACK, Line, Point, as_text, nodes_on_segment
from .outline import Outline
from .polygon import mesh_polygon
from .sizes import MeshSizes

#: a short edge is meshed narrower if the band takes more than this part of it beside the path, and is all taken from there on
_MOST_TAKEN, _ALL_TAKEN = 0.4, 0.9

#: an edge of the body before and after, and the motion of its two ends from the one to the other
_Edge = tuple[tuple[Array, Array], tuple[Array, Array], Array]


def mesh_band(outline: Outline, sizes: MeshSizes, width: float) -> meshio.Mesh:
    """Mesh a body with a crack band along its crack: what `mesh_polygon` gives, opened.

    A notch, or another short edge, that is hardly wider than the band ending there is meshed narrower by the width and gets
    its own width as the band opens.

    Parameters
    ----------
    width : of the band, mm.

    Returns
    -------
    meshio.Mesh
        As `open_cracks` gives it. Named points keep their places, but for one on the crack or a notch without width, which
        stands for the nodes on its two sides.

    Raises
    ------
    MeshError
        As `mesh_polygon` and `open_cracks`, and for a band wider than the notch.
    """
    edges = list(_narrowed(outline, width))
    narrow = _with_edges(outline, edges)
    mesh = mesh_polygon(narrow, sizes)
    points = np.array([p for group in narrow.nodes.values() for p in group], dtype=float).reshape(-1, 2)
    places, shifts = [points], [np.zeros_like(points)]
    for _, (a, b), shift in edges:
        on = mesh.points[nodes_on_segment(mesh.points, _point(a), _point(b), outline.slack)]
        part = (np.hypot(*(on - a).T) / math.dist(a, b))[:, None]
        places.append(on)
        shifts.append((1 - part) * shift[0] + part * shift[1])
    return open_cracks(mesh, width, np.concatenate(places), np.concatenate(shifts))


def _narrowed(outline: Outline, width: float) -> Iterator[_Edge]:
    """The edges that move as a band of some width opens: short ones that it ends on, which are narrowed before, and in half a
    body those of a notch without width. MeshError for a band wider than the edge that it ends on."""
    corners = np.array(outline.corners, dtype=float)
    shift, ends = np.zeros_like(corners), dict[int, Array]()
    following = np.roll(np.arange(len(corners)), -1).tolist()
    for line in outline.crack:
        for end, inner in ((line[0], line[1]), (line[-1], line[-2])):
            for i, j in enumerate(following):
                a, b = corners[[i, j]]
                if not _is_on(end, a, b, outline.slack):
                    continue
                sides = {k: side for k in (i, j) if (side := math.dist(corners[k], end)) > outline.slack}
                (x, y), (u, v) = (b - a) / math.dist(a, b), np.subtract(inner, end) / math.dist(inner, end)
                reach = 0.5 * width / max(abs(x * v - y * u), SLACK)
                if outline.half and abs(x * v - y * u) < SLACK:
                    if not _is_on(_point(np.add(end, inner) / 2), a, b, outline.slack):  # a notch without width
                        yield (a, b), (a, b), np.tile([-y, x], (2, 1)) * width / 2
                elif len(sides) == 2 or outline.half:  # a corner of the whole body is cut off
                    for k, side in sides.items():
                        if reach > side + outline.slack:
                            raise MeshError.at(
                                "band.width",
                                f" = {width:g}: wider than the notch, or the edge, that the crack path ends on at "
                                f"{as_text(end)}; expected at most {width * side / reach:.4g}",
                            )
                        if reach > _MOST_TAKEN * side:
                            part = reach / side if reach < _ALL_TAKEN * side else 1.0
                            ends[i], shift[k] = np.array(end), (corners[k] - end) * part
    narrow = corners - shift
    for i, j in enumerate(following):
        if i in ends:  # each part moves as a whole
            for k in (k for k in (i, j) if math.dist(narrow[k], ends[i]) > outline.slack):
                yield (corners[k], ends[i] + shift[k]), (narrow[k], ends[i]), shift[[k, k]]
        elif shift[[i, j]].any():
            yield (corners[i], corners[j]), (narrow[i], narrow[j]), shift[[i, j]]


def _with_edges(outline: Outline, edges: list[_Edge]) -> Outline:
    """The outline with what lies on edges that change."""

    def placed(p: Point) -> Point:
        for (a, b), (c, d), _ in edges:
            if _is_on(p, a, b, outline.slack):
                return _point(c + math.dist(a, p) / math.dist(a, b) * (d - c))
        return p

    def line(points: Line) -> list[Point]:
        return [placed(p) for p in points]

    corners = line(outline.corners)
    apart = [p for p, before in zip(corners, [corners[-1], *corners], strict=False) if math.dist(p, before) > outline.slack]
    nodes, named = ({name: line(group) for name, group in sets.items()} for sets in (outline.nodes, outline.edges))
    return replace(outline, corners=apart, nodes=nodes, edges=named)


def _is_on(point: Point, a: Array, b: Array, slack: float) -> bool:
    return bool(nodes_on_segment(np.array([point]), _point(a), _point(b), slack)[0])


def _point(p: Array) -> Point:
    x, y = p.tolist()
    return x, y
