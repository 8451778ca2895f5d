"""A block with one crack at any angle."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from ..generation.outline import Outline
from ..keys import key
from ..paths import Line, Point
from .base import Direction, Drive, Gauge, PlaneSpecimen, Support, expect
from .registry import register_specimen


@register_specimen("single-crack")
@dataclass(frozen=True)
class SingleCrack(PlaneSpecimen):
    """A rectangular block with one crack through its centre, moved at its top face.

    Origin in the centre, before `rotation` turns the whole. Point sets: `base`, `top`, one corner of
    the base (`base_corner`) and, with a gauge, `gauge_minus` and `gauge_plus` on the crack's normal.
    """

    width: float = key("width of the block", unit="mm", above=0)
    height: float = key("height of the block", unit="mm", above=0)
    thickness: float = key("thickness of the block", unit="mm", above=0)
    angle: float = key("angle between the crack and the base", 0.0, unit="degrees", above=-90, at_most=90)
    crack_length: float | None = key("None: through the whole block; else a crack with both tips inside", None, unit="mm")
    drive_angle: float = key(
        "between the motion of the top face and its outer normal: 0 pulls, 90 shears, 180 pushes",
        0.0,
        unit="degrees",
    )
    faces: str = key(
        "'free' (base and top move freely across the drive, but for one corner of the base) or 'clamped'",
        "free",
        one_of=("free", "clamped"),
    )
    rotation: float = key("turns the block, its supports and its drive", 0.0, unit="degrees")
    gauge: float = key(
        "length over which the opening is measured across the crack's centre; 0: mean jump over the crack",
        0.0,
        unit="mm",
        at_least=0,
    )
    crack: Any = key("polyline (or list of polylines) in the block's axes, instead of angle and crack_length", None, unit="mm")

    dimensions: ClassVar[tuple[int, ...]] = (2,)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.crack_length is not None:
            through = math.dist(*self._through())
            expect(self, "crack_length", 0 < self.crack_length < through, f"above 0 and below {through:g}")
        expect(self, "gauge", self.gauge < min(self.width, self.height), "less than width and height")

    def _through(self) -> tuple[Point, Point]:
        t = math.radians(self.angle)
        reach = min(
            self.width / 2 / abs(math.cos(t)) if abs(math.cos(t)) > 1e-12 else math.inf,
            self.height / 2 / abs(math.sin(t)) if abs(math.sin(t)) > 1e-12 else math.inf,
        )
        x, y = reach * math.cos(t), reach * math.sin(t)
        return (-x, -y), (x, y)

    def rotated(self, x: float, y: float) -> Point:
        """A point or direction of the block's axes in space."""
        c, s = math.cos(math.radians(self.rotation)), math.sin(math.radians(self.rotation))
        return (c * x - s * y, s * x + c * y)

    @property
    def paths(self) -> list[Line]:
        """The crack path, in space."""
        ends = self._through()
        scale = 1.0 if self.crack_length is None else self.crack_length / math.dist(*ends)
        lines: list[Line] = self.crack or [[(scale * x, scale * y) for x, y in ends]]
        return [[self.rotated(*p) for p in line] for line in lines]

    @property
    def normal(self) -> Point:
        """Unit normal of the straight crack, in space, towards its plus side."""
        t = math.radians(self.angle)
        return self.rotated(-math.sin(t), math.cos(t))

    def outline(self, half: bool = False) -> Outline:
        """The geometry; there is no half of it."""
        a, b, g = self.width / 2, self.height / 2, self.gauge / 2
        corners = [self.rotated(*p) for p in ((-a, -b), (a, -b), (a, b), (-a, b))]
        nodes: dict[str, Sequence[Point]] = {"base_corner": [corners[0]]}
        if g:
            n = self.normal
            nodes |= {"gauge_minus": [(-g * n[0], -g * n[1])], "gauge_plus": [(g * n[0], g * n[1])]}
        edges = {"base": (corners[0], corners[1]), "top": (corners[3], corners[2])}
        return Outline(corners, self.paths, (), nodes, edges)

    @property
    def drive_directions(self) -> tuple[Direction, Direction]:
        """The motion of the top face, and the direction across it."""
        t = math.radians(self.drive_angle)
        along = self.rotated(math.sin(t), math.cos(t))
        return along, (along[1], -along[0])

    def held(self, *, half: bool = False) -> list[Support]:
        """The base along the drive; across it one corner, or both faces if they are clamped."""
        along, across = self.drive_directions
        others = ("base_corner",) if self.faces == "free" else ("base", "top")
        return [Support("base", along), *(Support(name, across) for name in others)]

    def drives(self, *, half: bool = False) -> Mapping[str, Drive]:
        """The top face."""
        return {"top": Drive("top", self.drive_directions[0])}

    def gauges(self, *, half: bool = False) -> Mapping[str, Gauge]:
        """The opening across the crack's centre."""
        return {"opening": Gauge("gauge_plus", "gauge_minus")} if self.gauge else {}
