"""A crack while it grows, and where it ends."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from meshing.paths import Line, Point

from ..arrays import Array
from .body import Body

#: a segment is longer by at most this factor, so that the last one is no sliver
_LONGEST = 1.5

#: segments whose mean direction is kept
_KEPT = 3


@dataclass(frozen=True)
class Crack:
    """A crack while it grows.

    Attributes
    ----------
    points : from its start to its tip
    headings : direction of the way to each point, radians; the first is that of the notch
    end : what it has met; empty while it grows
    fixed_from : number of the point from which on its direction is fixed; None: nowhere
    why : it is fixed
    """

    points: tuple[Point, ...]
    headings: tuple[float, ...]
    end: str = ""
    fixed_from: int | None = None
    why: str = ""

    @property
    def tip(self) -> Point:
        """Its last point."""
        return self.points[-1]

    @property
    def heading(self) -> float:
        """Of its last segment, radians."""
        return self.headings[-1]

    def grown(self, heading: float, segment: float, body: Body, others: Sequence[Line]) -> Crack:
        """The crack with one more segment, which ends where it meets a face, a notch or one of the other cracks."""
        hit = body.first_hit(self.tip, unit(heading), others)
        if hit is not None and hit.distance < _LONGEST * segment:
            point, end = hit.point, hit.what
        else:
            x, y = np.asarray(self.tip) + segment * unit(heading)
            point, end = (float(x), float(y)), ""
        return replace(self, points=(*self.points, point), headings=(*self.headings, heading), end=end)

    def with_fixed_direction(self, why: str, segment: float, body: Body, others: Sequence[Line]) -> Crack:
        """The crack that goes on straight to its end, in the mean direction of its last segments."""
        crack = replace(self, fixed_from=len(self.points) - 1, why=why)
        heading = float(np.mean(self.headings[1:][-_KEPT:])) if len(self.points) > 1 else self.heading
        while not crack.end:
            crack = crack.grown(heading, segment, body, others)
        return crack

    def continued(self, body: Body, others: Sequence[Line]) -> Line:
        """Its path as it is tried: straight on from the tip."""
        if self.end or any(body.is_on(self.tip, line) for line in others if len(line) > 1):
            return list(self.points)
        hit = body.first_hit(self.tip, unit(self.heading), others)
        return list(self.points) if hit is None else [*self.points, hit.point]


def unit(angle: float) -> Array:
    """Unit vector at an angle from the x axis, radians."""
    return np.array([math.cos(angle), math.sin(angle)])


def trial_lines(cracks: Sequence[Crack], body: Body) -> list[Line]:
    """The paths of all cracks, each continued straight from its tip: to a face or to the first crack that it meets."""
    lines: list[Line] = []
    for i, crack in enumerate(cracks):
        later = [list(other.points) for other in cracks[i + 1 :] if len(other.points) > 1]
        lines.append(crack.continued(body, [*lines, *later]))
    return [line for line in lines if len(line) > 1]


def other_lines(cracks: Sequence[Crack], i: int) -> list[Line]:
    """What has grown of the other cracks."""
    return [list(other.points) for j, other in enumerate(cracks) if j != i and len(other.points) > 1]
