"""Geometry of a crack band: a row of four-sided faces along each crack path, and the body they lie in."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, pairwise

import numpy as np
from numpy.typing import NDArray

from .cracks import Line, Point, nodes_on_segment, path_length
from .errors import MeshError
from .plane import SLACK, Outline

Array = NDArray[np.float64]

#: the row may meet an edge of the body, or turn half of a kink, at up to this angle in degrees from the square cut
_STEEPEST = 75.0
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


def lay_strips(body: Outline, width: float) -> tuple[Outline, list[Strip]]:
    """The rows of faces along the crack paths of a body, and the body with its slits opened to their ends.

    Raises
    ------
    MeshError
        If a row does not fit: it leaves the body, is wider than the notch, or overlaps itself or another row.
    """
    if not 0 < width < math.inf:
        raise MeshError(f"band.width = {width!r}: expected a finite number above 0, in mm")
    path_length("crack", body.crack), path_length("notch", body.slits)
    slack = slack_of(body)
    strips = [_strip(body, line, width, slack) for line in body.crack]
    _check_apart(strips, width, slack)
    opened = body
    for strip in strips:
        for end in (0, -1):
            for slit in body.slits:
                if slit in opened.slits and min(math.dist(p, strip.path[end]) for p in (slit[0], slit[-1])) < slack:
                    opened = _opened(opened, slit, strip, end, width, slack)
    _check_inside(opened, strips, width, slack)
    return opened, strips


def slack_of(body: Outline) -> float:
    """Distance in mm below which two points are one."""
    return SLACK * float(np.ptp(np.array(body.corners, dtype=float), axis=0).max())


def part_inside(polygon: Array, face: Array, slack: float) -> Array:
    """Corners of the part of a polygon inside a convex, counter-clockwise face that is `slack` wider on every side.

    The polygon (k, 2) may be a single point or a segment; (0, 2) if no part of it lies inside.
    """
    for a, b in zip(face, np.roll(face, -1, axis=0), strict=True):
        inward = np.array([a[1] - b[1], b[0] - a[0]]) / math.dist(a, b)
        polygon = part_above(polygon, (polygon - a) @ inward + slack)
    return polygon


def part_above(polygon: Array, height: Array) -> Array:
    """Corners of the part of a convex polygon (k, d) on which a linear function, `height` (k,) at its corners, is not
    negative."""
    kept = []
    for i in range(len(polygon)):
        if (height[i] < 0) != (height[i - 1] < 0):
            share = height[i] / (height[i] - height[i - 1])
            kept.append(polygon[i] + share * (polygon[i - 1] - polygon[i]))
        if height[i] >= 0:
            kept.append(polygon[i])
    return np.array(kept).reshape(-1, polygon.shape[1])


def _strip(body: Outline, line: Line, width: float, slack: float) -> Strip:
    """Each corner lies where the parallel to a segment meets the cut: a mitre, an edge of the body, or a square end."""
    path = np.array(line, dtype=float)
    along = np.diff(path, axis=0)
    length = np.hypot(*along.T)
    along /= length[:, None]
    normal = np.stack([-along[:, 1], along[:, 0]], axis=1)
    cut = np.empty_like(path)
    cut[1:-1] = normal[:-1] + normal[1:]
    for i in (0, -1):
        path[i], cut[i] = _end(body, path[i], normal[i], width, slack)
    cut /= np.maximum(np.hypot(*cut.T), 1e-12)[:, None]
    lean = (cut * normal[np.minimum(np.arange(len(path)), len(normal) - 1)]).sum(axis=1)
    for x, y in path[abs(lean) < math.cos(math.radians(_STEEPEST))]:
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
        raise MeshError(
            f"band.width = {width:g}: the crack path from {_at(path[i])} to {_at(path[i + 1])} is too short for its kinks or "
            f"slanted ends, the band overlaps itself; expected at most {_floor(most):g}"
        )
    return strip


def _end(body: Outline, end: Array, normal: Array, width: float, slack: float) -> tuple[Array, Array]:
    """The end of a path, moved onto the body's edge if it lies there, and the direction of the cut."""
    least = math.cos(math.radians(_STEEPEST))
    edges = [(abs(float(_unit(a, b) @ normal)), i) for i, (a, b) in enumerate(_edges(body.corners)) if _on(end, a, b, slack)]
    if edges:
        lean, i = max(edges)
        a, b = list(_edges(body.corners))[i]
        along = _unit(a, b)
        room = min(math.dist(end, a), math.dist(end, b))
        if lean < least:
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
            if _is_notch(body.corners, i):
                raise MeshError(
                    f"band.width = {width:g}: wider than the notch at {_at(end)}, notch_width = {math.dist(a, b):g}; {most}"
                )
            raise MeshError(f"band.width = {width:g}: the band leaves the body at {_at(end)}; {most}")
        return a + ((end - a) @ along) * along, along
    for slit in body.slits:
        for tip, before in ((slit[-1], slit[-2]), (slit[0], slit[1])):
            if math.dist(end, tip) < slack:
                x, y = _unit(before, tip)
                across = np.array([-y, x])
                if abs(across @ normal) < least:
                    raise MeshError(
                        f"the crack path leaves the tip of the notch at {_at(end)} sideways or backwards; expected at most "
                        f"{_STEEPEST:g} degrees from the notch's direction for a band"
                    )
                return end, across
    if not _contains(body.corners, end):
        raise MeshError(f"the crack path ends outside the body, at {_at(end)}: expected an end inside it or on its outline")
    return end, normal


def _opened(body: Outline, slit: Line, strip: Strip, end: int, width: float, slack: float) -> Outline:
    """The body with a slit opened to the end of a row."""
    tip = strip.path[end]
    mouth = np.array(max(slit, key=lambda p: math.dist(p, tip)), dtype=float)
    at = [i for i, (a, b) in enumerate(_edges(body.corners)) if _on(mouth, a, b, slack)]
    if len(slit) > 2 or not at:
        raise MeshError(
            f"the notch that ends at {_at(tip)}: expected a straight one from the outline, to be opened for a band"
        )
    a, b = list(_edges(body.corners))[at[0]]
    along, (x, y) = _unit(a, b), _unit(mouth, tip)
    inward = np.array([x, y])
    across = np.array([-y, x]) * (1.0 if np.array([-y, x]) @ along > 0 else -1.0)
    half = abs(float((strip.plus[end] - tip) @ across))
    reach, room = half / float(across @ along), min(math.dist(mouth, a), math.dist(mouth, b))
    if reach > room - slack:
        raise MeshError(
            f"band.width = {width:g}: the notch at {_at(mouth)}, opened to {2 * half:g} mm, leaves the body; "
            f"expected less than {width * room / reach:g}"
        )
    for name, group in body.nodes.items():
        for p in group:
            if abs((p - mouth) @ across) < half - slack and (p - mouth) @ inward < math.dist(tip, mouth) - slack:
                raise MeshError(
                    f"{name} = {_at(p)}: it falls into the notch, which band.width = {width:g} opens to {2 * half:g} mm; "
                    "expected a point beside the notch"
                )
    corners = [mouth - reach * along, tip - half * across, tip + half * across, mouth + reach * along]
    outline = [*body.corners[: at[0] + 1], *map(_point, corners), *body.corners[at[0] + 1 :]]
    return replace(body, corners=outline, slits=[other for other in body.slits if other is not slit])


def _check_apart(strips: Sequence[Strip], width: float, slack: float) -> None:
    """A MeshError where a row overlaps or touches itself or another one."""
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
            raise MeshError(
                f"band.width = {width:g}: {what} at {_at(shared.mean(axis=0))}; expected paths that neither touch, branch nor "
                'cross and lie further apart than the width, or band.where = "everywhere"'
            )


def _check_inside(body: Outline, strips: Sequence[Strip], width: float, slack: float) -> None:
    """A MeshError where a row leaves the body or runs into a notch."""
    edges = np.array(list(_edges(body.corners)))
    for strip in strips:
        known = np.concatenate([strip.minus, strip.plus])
        # a corner of the body on the side of a row would divide that side
        loose = [p for p in edges[:, 0] if np.hypot(*(known - p).T).min() > slack]
        for face in strip.faces:
            out = [part_inside(edge, face, -slack) for edge in edges]
            out += [part_inside(p[None], face, slack) for p in loose]
            centre = face.mean(axis=0)
            out.append(np.empty((0, 2)) if _contains(body.corners, centre) else centre[None])
            for part in out:
                if len(part):
                    raise MeshError(
                        f"band.width = {width:g}: the band leaves the body at {_at(part.mean(axis=0))}; expected a crack path "
                        f"more than {width / 2:g} mm from every edge and corner that it does not end on"
                    )
            for line in body.slits:
                for edge in pairwise(line):
                    part = part_inside(np.array(edge), face, slack)
                    if len(part):
                        raise MeshError(
                            f"band.width = {width:g}: the band runs into the notch at {_at(part.mean(axis=0))}; expected a "
                            f"crack path that starts at the notch's tip or stays {width / 2:g} mm clear of it"
                        )


def _edges(outline: Line) -> Iterator[tuple[Array, Array]]:
    corners = np.array(outline, dtype=float)
    return zip(corners, np.roll(corners, -1, axis=0), strict=True)


def _is_notch(outline: Line, i: int) -> bool:
    """Whether edge i of the outline is the end face of a notch: both of its corners point into the body."""
    directions = [b - a for a, b in _edges(outline)]
    before, here, after = (directions[j % len(directions)] for j in (i - 1, i, i + 1))
    return all(float(u[0] * v[1] - u[1] * v[0]) < 0 for u, v in ((before, here), (here, after)))


def _contains(outline: Line, point: Array) -> bool:
    inside = False
    for a, b in _edges(outline):
        if (a[1] > point[1]) != (b[1] > point[1]):
            crossing = a[0] + (point[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
            inside ^= bool(crossing > point[0])
    return inside


def _on(point: Array, a: Array, b: Array, slack: float) -> bool:
    return bool(nodes_on_segment(point[None], _point(a), _point(b), slack)[0])


def _unit(a: Point | Array, b: Point | Array) -> Array:
    return np.subtract(b, a) / math.dist(a, b)


def _point(p: Array) -> Point:
    return (float(p[0]), float(p[1]))


def _at(p: Point | Array) -> str:
    """A point as text, to a micrometre."""
    return f"({round(float(p[0]), 3) + 0.0:g}, {round(float(p[1]), 3) + 0.0:g})"


def _floor(value: float) -> float:
    """Rounded down to three digits, so that the width a message allows is allowed."""
    digits = 2 - math.floor(math.log10(value))
    return math.floor(value * 10.0**digits + 1e-6) / 10.0**digits
