"""Geometry of a crack band: a row of four-sided faces along each crack path, and the body that they lie in."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, pairwise

import numpy as np

from ..arrays import Array
from ..errors import MeshError
from ..paths import Line, Point, contains, nodes_on_segment, path_length
from .clipping import part_inside
from .outline import Outline

#: the row may meet an edge of the body, or bend by half of a kink, at up to this angle in degrees from the square cut
_STEEPEST = 75.0
_LEAST = math.cos(math.radians(_STEEPEST))
#: the shorter side of a face is at least this part of its centre line
_SHORTEST = 0.2


@dataclass(frozen=True)
class Strip:
    """One row of faces along a path of n segments; the minus side lies to the right of the path's direction.

    Attributes
    ----------
    path, minus, plus : (n + 1, 2) arrays, mm: vertices of the path and the corners beside each.
    """

    path: Array
    minus: Array
    plus: Array

    @property
    def faces(self) -> Array:
        """Corners [a-, b-, b+, a+] of each face, counter-clockwise: (n, 4, 2)."""
        return np.stack([self.minus[:-1], self.minus[1:], self.plus[1:], self.plus[:-1]], axis=1)

    @property
    def ends(self) -> list[tuple[Point, Point]]:
        """The first and the last edge across the row."""
        return [(_point(self.minus[i]), _point(self.plus[i])) for i in (0, -1)]


def lay_strips(outline: Outline, width: float) -> tuple[Outline, list[Strip]]:
    """The rows of faces along the crack paths of a body, and the body with its slits opened to their ends.

    Raises
    ------
    MeshError
        If a row does not fit: it leaves the body, is wider than the notch, or overlaps itself or another row.
    """
    if not 0 < width < math.inf:
        raise MeshError.at("band.width", f" = {width!r}: expected a finite number above 0, in mm")
    path_length("crack", outline.crack), path_length("notch", outline.slits)
    slack = outline.slack
    strips = [_strip(outline, line, width, slack) for line in outline.crack]
    _check_apart(strips, width, slack)
    opened = outline
    for strip in strips:
        for end in (0, -1):
            for slit in outline.slits:
                if slit in opened.slits and min(math.dist(p, strip.path[end]) for p in (slit[0], slit[-1])) < slack:
                    opened = _opened(opened, slit, strip, end, width, slack)
    _check_inside(opened, strips, width, slack)
    return opened, strips


def _strip(outline: Outline, line: Line, width: float, slack: float) -> Strip:
    """The row of faces along one path.

    Each corner lies where the parallel to a segment meets the cut: a mitre, an edge of the body, or a square end.
    """
    path = np.array(line, dtype=float)
    along = np.diff(path, axis=0)
    length = np.hypot(*along.T)
    along /= length[:, None]
    normal = np.stack([-along[:, 1], along[:, 0]], axis=1)
    cut = np.empty_like(path)
    cut[1:-1] = normal[:-1] + normal[1:]
    for i in (0, -1):
        path[i], cut[i] = _end(outline, path[i], normal[i], width, slack)
    cut /= np.maximum(np.hypot(*cut.T), 1e-12)[:, None]
    lean = (cut * normal[np.minimum(np.arange(len(path)), len(normal) - 1)]).sum(axis=1)
    for x, y in path[abs(lean) < _LEAST]:
        raise MeshError(
            f"the crack path turns too sharply at ({x:g}, {y:g}) for a band; expected a kink of at most "
            f"{2 * _STEEPEST:g} degrees"
        )
    offset = cut * (width / 2 / lean)[:, None]
    strip = Strip(path, path - offset, path + offset)
    sides = [(np.diff(side, axis=0) * along).sum(axis=1) for side in (strip.minus, strip.plus)]
    shorter = np.minimum(*sides)
    for i in np.flatnonzero(shorter < _SHORTEST * length).tolist():
        most = (1 - _SHORTEST) * width * float(length[i] / (length[i] - shorter[i]))
        raise _width_error(
            width,
            f"the crack path from {_at(path[i])} to {_at(path[i + 1])} is too short for its kinks or slanted ends, the band "
            f"overlaps itself; expected at most {_floor(most):g}",
        )
    return strip


def _end(outline: Outline, end: Array, normal: Array, width: float, slack: float) -> tuple[Array, Array]:
    """The end of a path, moved onto the body's edge if it lies there, and the direction of the cut.

    Parameters
    ----------
    end, normal : (2,) the end, and the normal of the path's segment there.
    """
    edges = [
        (abs(float(_unit(a, b) @ normal)), i) for i, (a, b) in enumerate(_edges(outline.corners)) if _on(end, a, b, slack)
    ]
    if edges:
        lean, i = max(edges)
        return _end_on_edge(outline, i, end, lean, width, slack)
    for slit in outline.slits:
        for tip, before in ((slit[-1], slit[-2]), (slit[0], slit[1])):
            if math.dist(end, tip) < slack:
                x, y = _unit(before, tip)
                across = np.array([-y, x])
                if abs(across @ normal) < _LEAST:
                    raise MeshError(
                        f"the crack path leaves the tip of the notch at {_at(end)} sideways or backwards; expected at most "
                        f"{_STEEPEST:g} degrees from the notch's direction for a band"
                    )
                return end, across
    if not contains(outline.corners, end):
        raise MeshError(f"the crack path ends outside the body, at {_at(end)}: expected an end inside it or on its outline")
    return end, normal


def _end_on_edge(outline: Outline, i: int, end: Array, lean: float, width: float, slack: float) -> tuple[Array, Array]:
    """As `_end`, for an end on edge i of the body; `lean` is the cosine of its angle with the square cut."""
    a, b = list(_edges(outline.corners))[i]
    along = _unit(a, b)
    room = min(math.dist(end, a), math.dist(end, b))
    if lean < _LEAST:
        raise MeshError(
            f"the crack path meets the edge of the body at {_at(end)} at {math.degrees(math.asin(lean)):.0f} degrees; "
            f"expected at least {90 - _STEEPEST:g} for a band"
        )
    if room < slack:
        raise MeshError(
            f"the crack path ends in a corner of the body, at {_at(end)}; expected an end more than "
            f"{width / 2 / lean:g} mm from the corners for band.width = {width:g}"
        )
    if width / 2 / lean > room + slack:
        most = f"expected at most {_floor(2 * room * lean):g}"
        if _is_notch(outline.corners, i):
            raise _width_error(width, f"wider than the notch at {_at(end)}, notch_width = {math.dist(a, b):g}; {most}")
        raise _width_error(width, f"the band leaves the body at {_at(end)}; {most}")
    return a + ((end - a) @ along) * along, along


def _opened(outline: Outline, slit: Line, strip: Strip, end: int, width: float, slack: float) -> Outline:
    """The body with a slit opened to the end of a row; a named point on it becomes those on both sides."""
    tip = strip.path[end]
    mouth = np.array(max(slit, key=lambda p: math.dist(p, tip)), dtype=float)
    at = [i for i, (a, b) in enumerate(_edges(outline.corners)) if _on(mouth, a, b, slack)]
    if len(slit) > 2 or not at:
        raise MeshError(
            f"the notch that ends at {_at(tip)}: expected a straight one from the outline, to be opened for a band"
        )
    a, b = list(_edges(outline.corners))[at[0]]
    along, (x, y) = _unit(a, b), _unit(mouth, tip)
    inward = np.array([x, y])
    across = np.array([-y, x]) * (1.0 if np.array([-y, x]) @ along > 0 else -1.0)
    half = abs(float((strip.plus[end] - tip) @ across))
    reach, room = half / float(across @ along), min(math.dist(mouth, a), math.dist(mouth, b))
    if reach > room - slack:
        raise _width_error(
            width,
            f"the notch at {_at(mouth)}, opened to {2 * half:g} mm, leaves the body; expected less than "
            f"{width * room / reach:g}",
        )
    notch = [mouth - reach * along, tip - half * across, tip + half * across, mouth + reach * along]
    nodes: dict[str, list[Point]] = {}
    for name, group in outline.nodes.items():
        nodes[name] = []
        for p in group:
            depth = float((p - mouth) @ inward)
            if abs((p - mouth) @ across) > slack or not -slack < depth < math.dist(tip, mouth) - slack:
                nodes[name].append(p)
            elif depth < slack:
                nodes[name] += [_point(notch[0]), _point(notch[-1])]
            else:
                nodes[name] += [_point(mouth + depth * inward + side * half * across) for side in (-1.0, 1.0)]
        for p in nodes[name]:
            if abs((p - mouth) @ across) < half - slack and (p - mouth) @ inward < math.dist(tip, mouth) - slack:
                raise MeshError.at(
                    name,
                    f" = {_at(p)}: it falls into the notch, which band.width = {width:g} opens to {2 * half:g} mm; "
                    "expected a point beside the notch",
                )
    corners = [*outline.corners[: at[0] + 1], *map(_point, notch), *outline.corners[at[0] + 1 :]]
    return replace(outline, corners=corners, nodes=nodes, slits=[other for other in outline.slits if other is not slit])


def _check_apart(strips: Sequence[Strip], width: float, slack: float) -> None:
    """Refuse rows that overlap or touch themselves or each other; MeshError."""
    faces = [(i, j, face) for i, strip in enumerate(strips) for j, face in enumerate(strip.faces)]
    low = np.array([face.min(axis=0) for _, _, face in faces]) - slack
    high = np.array([face.max(axis=0) for _, _, face in faces]) + slack
    for one, other in combinations(range(len(faces)), 2):
        (i, j, face), (k, m, there) = faces[one], faces[other]
        if (i == k and m - j < 2) or (low[one] > high[other]).any() or (low[other] > high[one]).any():
            continue
        shared = part_inside(face, there, slack)
        if len(shared):
            if i == k:
                what = "the band of the crack path overlaps itself"
            else:
                what = "the bands of two crack paths overlap"
            raise _width_error(
                width,
                f"{what} at {_at(shared.mean(axis=0))}; expected paths that neither touch, branch nor cross and lie further "
                'apart than the width, or band.where = "everywhere"',
            )


def _check_inside(outline: Outline, strips: Sequence[Strip], width: float, slack: float) -> None:
    """Refuse a row that leaves the body or runs into a notch; MeshError."""
    edges = np.array(outline.sides)
    for strip in strips:
        known = np.concatenate([strip.minus, strip.plus])
        # a corner of the body on the side of a row would divide that side
        loose = [p for p in edges[:, 0] if np.hypot(*(known - p).T).min() > slack]
        for face in strip.faces:
            out = [part_inside(edge, face, -slack) for edge in edges]
            out += [part_inside(p[None], face, slack) for p in loose]
            centre = face.mean(axis=0)
            out.append(np.empty((0, 2)) if contains(outline.corners, centre) else centre[None])
            for part in out:
                if len(part):
                    raise _width_error(
                        width,
                        f"the band leaves the body at {_at(part.mean(axis=0))}; expected a crack path more than {width / 2:g} "
                        "mm from every edge and corner that it does not end on",
                    )
            for line in outline.slits:
                for edge in pairwise(line):
                    part = part_inside(np.array(edge), face, slack)
                    if len(part):
                        raise _width_error(
                            width,
                            f"the band runs into the notch at {_at(part.mean(axis=0))}; expected a crack path that starts at "
                            f"the notch's tip or stays {width / 2:g} mm clear of it",
                        )


def _edges(corners: Line) -> Iterator[tuple[Array, Array]]:
    """The ends of each edge of an outline."""
    points = np.array(corners, dtype=float)
    return zip(points, np.roll(points, -1, axis=0), strict=True)


def _is_notch(corners: Line, i: int) -> bool:
    """Whether edge i of the outline is the end face of a notch: both of its corners point into the body."""
    directions = [b - a for a, b in _edges(corners)]
    before, here, after = (directions[j % len(directions)] for j in (i - 1, i, i + 1))
    return all(float(u[0] * v[1] - u[1] * v[0]) < 0 for u, v in ((before, here), (here, after)))


def _on(point: Array, a: Array, b: Array, slack: float) -> bool:
    """Whether a point lies on a segment."""
    return bool(nodes_on_segment(point[None], _point(a), _point(b), slack)[0])


def _unit(a: Point | Array, b: Point | Array) -> Array:
    """Unit vector from a to b."""
    return np.subtract(b, a) / math.dist(a, b)


def _point(p: Array) -> Point:
    return (float(p[0]), float(p[1]))


def _width_error(width: float, why: str) -> MeshError:
    return MeshError.at("band.width", f" = {width:g}: {why}")


def _at(p: Point | Array) -> str:
    """A point as text, to a micrometre."""
    return f"({round(float(p[0]), 3) + 0.0:g}, {round(float(p[1]), 3) + 0.0:g})"


def _floor(value: float) -> float:
    """Rounded down to three digits, so that the width a message allows is allowed."""
    digits = 2 - math.floor(math.log10(value))
    return math.floor(value * 10.0**digits + 1e-6) / 10.0**digits
