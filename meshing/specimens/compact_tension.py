"""A compact specimen that is pulled apart at two pins: a disk or a rectangle."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..generation.outline import Outline
from ..keys import key
from ..paths import Line, Point
from .base import MAIN_GAUGE, Direction, Drive, Gauge, PlaneSpecimen, Support, expect, without_repeats
from .registry import register_specimen

#: edges of the polygon that stands for a disk, around it: 0.14 % more area, and room for a band at the end of the path
_EDGES = 48


@register_specimen("compact-tension")
@dataclass(frozen=True)
class CompactTension(PlaneSpecimen):
    """A compact specimen: a notch from its front face, two pins above and below it that are pulled apart.

    As a disk that of ASTM D7313, as a rectangle that of ASTM E399. Origin on the line between the pins, at mid-height; x along
    the notch. The pins are points, their holes are left out. Point sets: `pin_above`, `pin_below`, `mouth` (the notch at the
    front face), `tip`, `gauge_plus` and `gauge_minus` (the notch at the line between the pins). The main gauge measures the
    opening at the line between the pins, `cmod` that at the front face, `ctod` that at the tip.
    """

    shape: str = key("shape of the specimen", "disk", one_of=("disk", "rectangle"))
    width: float = key("distance from the line between the pins to the back face", 110.0, unit="mm", above=0)
    thickness: float = key("thickness of the specimen", 50.0, unit="mm", above=0)
    notch: float = key("depth of the notch from the line between the pins", 27.5, unit="mm", above=0)
    front: float = key("distance from the line between the pins to the front face", 35.0, unit="mm", above=0)
    height: float = key("diameter of the disk, or height of the rectangle", 150.0, unit="mm", above=0)
    pins: float = key("distance between the centres of the pins", 50.0, unit="mm", above=0)
    notch_width: float = key("width of the notch; 0: a slit without width", 0.0, unit="mm", at_least=0)
    crack: Any = key("polyline (or list of polylines) of the crack; default: from the notch tip straight on", None, unit="mm")

    def __post_init__(self) -> None:
        super().__post_init__()
        expect(self, "notch", self.notch < self.width, f"less than width = {self.width:g}")
        if self.shape == "disk":
            reach = self.height - self.width
            expect(self, "front", self.front < reach, f"less than height - width = {reach:g}, a flat face cut into the disk")
            height = 2.0 * math.sqrt(self.height**2 / 4 - (self.width - self.height / 2) ** 2)
        else:
            height = self.height
        expect(
            self, "pins", self.notch_width < self.pins < height, f"between notch_width = {self.notch_width:g} and {height:.4g}"
        )

    @property
    def paths(self) -> list[Line]:
        """The crack path."""
        return self.crack or [[(self.notch, 0.0), (self.width, 0.0)]]

    @property
    def tips(self) -> list[Point]:
        """The end of the notch."""
        return [(self.notch, 0.0)]

    @property
    def notch_depth(self) -> float | None:
        """Depth of the notch that the crack goes on from; None if the path does not begin at its tip."""
        is_there = len(self.paths) == 1 and math.dist(self.paths[0][0], self.tips[0]) < 1e-6 * self.width
        return self.notch if is_there else None

    @property
    def _upper(self) -> list[Point]:
        """Corners of the upper half from the back face to the front face, without those on the notch and the path. An edge of
        the disk touches it where the path ends."""
        if self.shape == "rectangle":
            return [(self.width, self.height / 2), (-self.front, self.height / 2)]
        radius, centre = self.height / 2, self.width - self.height / 2
        around = radius / math.cos(math.pi / _EDGES)
        angles = [(2 * k + 1) * math.pi / _EDGES for k in range(_EDGES // 2)]
        arc = [(centre + around * math.cos(t), around * math.sin(t)) for t in angles]
        front = (-self.front, math.sqrt(radius**2 - (self.front + centre) ** 2))
        return [*(p for p in arc if p[0] > -self.front + 0.02 * radius), front]

    def outline(self, half: bool = False) -> Outline:
        """The geometry, of the upper half if so wanted."""
        w, front, tip = self.notch_width / 2, -self.front, self.notch
        lines = {"mouth": [(front, w), (front, -w)], "gauge_plus": [(0.0, w)], "gauge_minus": [(0.0, -w)], "tip": self.tips}
        points: dict[str, Sequence[Point]] = {
            **lines,
            "pin_above": [(0.0, self.pins / 2)],
            "pin_below": [(0.0, -self.pins / 2)],
        }
        if not w:
            points |= {"mouth": [(front, 0.0)]}
        if self.notch_depth is None:
            del points["tip"]
        if half:
            above = {name: [p for p in group if p[1] >= 0] for name, group in points.items()}
            named = {name: group for name, group in above.items() if group and name != "gauge_minus"}
            corners = [(front, w), (tip, w), (tip, 0.0), (self.width, 0.0), *self._upper]
            return Outline(without_repeats(corners), self.paths, (), named, half=True)
        upper = self._upper
        lower = [(x, -y) for x, y in reversed(upper)]
        notch = [(front, w), (tip, w), (tip, -w), (front, -w)] if w else []
        slits: list[Line] = [] if w else [[(front, 0.0), (tip, 0.0)]]
        return Outline([*upper, *notch, *lower], self.paths, slits, points)

    def held(self, *, half: bool = False) -> list[Support]:
        """The lower pin, and the upper one along the notch."""
        across = Support("pin_above", (1.0, 0.0))
        return [across] if half else [Support("pin_below", (0.0, 1.0)), Support("pin_below", (1.0, 0.0)), across]

    def drives(self, *, half: bool = False) -> Mapping[str, Drive]:
        """The upper pin. The plane of symmetry stays where it is, so that of a half moves by half of the drive."""
        return {"pins": Drive("pin_above", (0.0, 1.0), share=0.5 if half else 1.0)}

    def gauges(self, *, half: bool = False) -> Mapping[str, Gauge]:
        """The openings along the pull."""
        up = (0.0, 1.0)
        names = {MAIN_GAUGE: "gauge_plus", "cmod": "mouth", **({"ctod": "tip"} if self.notch_depth is not None else {})}
        gauges = {name: Gauge(at, None if half else at, up) for name, at in names.items()}
        if self.notch_width and not half:
            gauges[MAIN_GAUGE] = Gauge("gauge_plus", "gauge_minus", up)
        return gauges

    def symmetry(self) -> Direction | None:
        """The plane of the notch, if the path lies in it."""
        return None if self.crack else (0.0, 1.0)
