"""A plane body in which cracks grow: where a straight line from a tip meets a face, a notch or another crack."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from meshing.paths import Line, Point, contains, distance_to

from ..arrays import Array

#: what lies nearer to a tip than this part of the size of the body is the tip itself
_SLACK = 1e-7

#: name of what a crack meets at the outer face
FACE = "the face"


@dataclass(frozen=True)
class Hit:
    """Where a straight line ends.

    Attributes
    ----------
    distance : from its start, mm
    point : there
    what : the name of what it meets
    """

    distance: float
    point: Point
    what: str


@dataclass(frozen=True)
class Body:
    """A plane body.

    Attributes
    ----------
    faces : closed polygons: the outer face, then those of holes
    slits : notches without width
    """

    faces: Sequence[Line]
    slits: Sequence[Line]

    @classmethod
    def from_outline(cls, outline: Any) -> Body:
        """By the outline of a specimen."""
        return cls([list(outline.corners), *map(list, outline.holes)], list(outline.slits))

    @property
    def size(self) -> float:
        """The longest side of the box around the body, mm."""
        return float(np.ptp(np.asarray(self.faces[0], dtype=float), axis=0).max())

    def first_hit(self, start: Point, heading: Array, cracks: Iterable[Line] = ()) -> Hit | None:
        """What a straight line meets first; None if it starts outside and leads nowhere.

        Parameters
        ----------
        heading : (2,) array, unit vector
        cracks : polylines of other cracks
        """
        obstacles: list[tuple[str, Line]] = [("a hole" if i else FACE, [*face, face[0]]) for i, face in enumerate(self.faces)]
        obstacles += [("a notch", slit) for slit in self.slits]
        obstacles += [("another crack", line) for line in cracks]
        best: tuple[float, str] | None = None
        for what, line in obstacles:
            distance = _distance_along(np.asarray(start), heading, np.asarray(line, dtype=float), _SLACK * self.size)
            if distance is not None and (best is None or distance < best[0]):
                best = distance, what
        if best is None:
            return None
        end = np.asarray(start) + best[0] * heading
        return Hit(best[0], (float(end[0]), float(end[1])), best[1])

    def contains(self, point: Point) -> bool:
        """Whether a point lies inside."""
        outer, *holes = self.faces
        return contains(outer, point) and not any(contains(hole, point) for hole in holes)

    def is_on(self, point: Point, line: Line) -> bool:
        """Whether a point lies on a polyline."""
        return distance_to(point, [line]) < _SLACK * self.size


def _distance_along(start: Array, heading: Array, line: Array, slack: float) -> float | None:
    """Distance from a start to a polyline (k, 2) along a heading, mm; None if the line does not meet it."""
    across = np.array([-heading[1], heading[0]])
    along, off = (line - start) @ heading, (line - start) @ across
    distances = [float(t) for t, o in zip(along, off, strict=True) if abs(o) < slack and t > slack]  # its corners
    for (t0, o0), (t1, o1) in pairwise(zip(along, off, strict=True)):
        if (o0 < 0) != (o1 < 0) and abs(o1 - o0) > slack:
            t = float(t0 + (t1 - t0) * o0 / (o0 - o1))
            if t > slack:
                distances.append(t)
    return min(distances, default=None)
