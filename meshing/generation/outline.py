"""A 2D body before it is meshed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..paths import SLACK, Line, Point, nodes_on_segment, signed_area


@dataclass(frozen=True)
class Outline:
    """A 2D body before it is meshed. Lengths in mm.

    Parameters
    ----------
    corners : of the body, counter-clockwise.
    crack, slits : polylines of the crack and of notches without width, inside the body.
    nodes : points that must be nodes, by the name of the point set they end up in.
    edges : polylines along the outline, by the name of the point set of their nodes.
    half : the crack runs along the outline, and a mirror image stands on its other side.
    holes : polygons inside the body, counter-clockwise too.
    hinges : ends of the crack at which it is meshed finer, since its faces rotate about them.
    least_size : of the elements there, mm.
    """

    corners: Line
    crack: Sequence[Line]
    slits: Sequence[Line] = ()
    nodes: Mapping[str, Sequence[Point]] = field(default_factory=dict)
    edges: Mapping[str, Sequence[Point]] = field(default_factory=dict)
    half: bool = False
    holes: Sequence[Line] = ()
    hinges: Sequence[Point] = ()
    least_size: float = 0.0

    @property
    def area(self) -> float:
        """Area inside the corners without that of the holes, mm^2."""
        return abs(signed_area(self.corners)) - sum(abs(signed_area(hole)) for hole in self.holes)

    @property
    def sides(self) -> list[tuple[Point, Point]]:
        """The straight sides of the outer face and of the holes."""
        return [side for face in (self.corners, *self.holes) for side in zip(face, [*face[1:], face[0]], strict=True)]

    @property
    def slack(self) -> float:
        """Distance below which two points are one, mm."""
        return SLACK * float(np.ptp(np.array(self.corners, dtype=float), axis=0).max())

    def has_on_face(self, point: Point) -> bool:
        """Whether a point lies on the outer face or on that of a hole."""
        at = np.array([point], dtype=float)
        return any(bool(nodes_on_segment(at, a, b, self.slack)[0]) for a, b in self.sides)
