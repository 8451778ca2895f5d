"""A notched beam in three-point bending."""

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


@register_specimen("notched-beam")
@dataclass(frozen=True)
class NotchedBeam(PlaneSpecimen):
    """A beam on two supports with a notch in its lower face, loaded at mid-span from above.

    Origin at mid-span on the lower face; x along the beam, y upwards. Point sets: `support_left`, `support_right`, `load`,
    `gauge_plus` (left of the notch) and `gauge_minus`, `mouth`, `tip`, `mid_span` (if that is not the mouth) and `yoke`.

    Gauges: the main one between the gauge points; `cmod` between the edges of the notch at its mouth; `ctod` between the
    sides of the crack at the tip of the notch; `deflection` at mid-span (of the tip or, with the notch elsewhere, of the lower
    face) against a yoke that rests at mid-depth over the supports, so that it includes no dent under the load or over a
    support.
    """

    length: float = key("length of the beam", unit="mm", above=0)
    span: float = key("distance between the supports", unit="mm", above=0)
    depth: float = key("depth of the beam", unit="mm", above=0)
    thickness: float = key("thickness of the beam", unit="mm", above=0)
    notch: float = key("depth of the notch", unit="mm", at_least=0)
    notch_position: float = key("place of the notch, from mid-span", 0.0, unit="mm")
    notch_width: float = key("width of the notch; 0: a slit without width", 0.0, unit="mm", at_least=0)
    gauge: float = key(
        "distance between the two points on the lower face that measure the opening; 0: mean jump over the crack",
        0.0,
        unit="mm",
        at_least=0,
    )
    crack: Any = key("polyline (or list of polylines) of the crack; default: from the notch tip straight up", None, unit="mm")

    def __post_init__(self) -> None:
        super().__post_init__()
        expect(self, "span", self.span <= self.length, f"at most length = {self.length:g}")
        expect(self, "notch", self.notch < self.depth, f"less than depth = {self.depth:g}")
        expect(self, "gauge", self.gauge < self.length - 2 * abs(self.notch_position), "both gauge points on the beam")
        reach = abs(self.notch_position) + self.notch_width / 2
        expect(self, "notch_position", reach < self.span / 2, f"the notch between the supports, span = {self.span:g}")
        if self.gauge:
            expect(self, "gauge", self.gauge > self.notch_width, f"more than notch_width = {self.notch_width:g}")

    @property
    def paths(self) -> list[Line]:
        """The crack path."""
        x = self.notch_position
        return self.crack or [[(x, self.notch), (x, self.depth)]]

    @property
    def tips(self) -> list[Point]:
        """The end of the notch."""
        return [(self.notch_position, self.notch)] if self.notch else []

    @property
    def notch_depth(self) -> float | None:
        """Depth of the notch that the crack goes on from; None if the path does not begin at its tip."""
        tip = (self.notch_position, self.notch)
        return self.notch if len(self.paths) == 1 and math.dist(self.paths[0][0], tip) < 1e-6 * self.depth else None

    @property
    def _measured(self) -> dict[str, Sequence[Point]]:
        """Points at which its motions are measured, by the name of their set."""
        x, w = self.notch_position, self.notch_width / 2 if self.notch else 0.0
        yoke = [(-self.span / 2, self.depth / 2), (self.span / 2, self.depth / 2)]
        points: dict[str, Sequence[Point]] = {}
        if self.gauge:
            points |= {"gauge_plus": [(x - self.gauge / 2, 0.0)], "gauge_minus": [(x + self.gauge / 2, 0.0)]}
        points |= {"mouth": [(x - w, 0.0), (x + w, 0.0)] if w else [(x, 0.0)], "yoke": yoke}
        if abs(x) > w:
            points["mid_span"] = [(0.0, 0.0)]
        if self.notch and self.notch_depth is not None:
            points["tip"] = self.tips
        return points

    @property
    def loaded(self) -> list[Point]:
        """Points that the load moves."""
        return [(0.0, self.depth)]

    def outline(self, half: bool = False) -> Outline:
        """The geometry, of the left half if so wanted."""
        a, b, x, w = self.length / 2, self.depth, self.notch_position, self.notch_width / 2
        if half:
            corners: list[Point] = [(-a, 0.0), (-w, 0.0), (-w, self.notch), (0.0, self.notch), (0.0, b), (-a, b)]
            named = {"support_left": [(-self.span / 2, 0.0)], "load": self.loaded, **self._measured}
            points = {name: [p for p in group if p[0] <= 0] for name, group in named.items() if name != "gauge_minus"}
            return Outline(without_repeats(corners), self.paths, (), points, half=True)
        outline: list[Point] = [(a, 0), (a, b), (-a, b), (-a, 0)]
        slits: list[Line] = []
        if self.notch and self.notch_width:
            outline += [(x - w, 0), (x - w, self.notch), (x + w, self.notch), (x + w, 0)]
        elif self.notch:
            slits = [[(x, 0.0), (x, self.notch)]]
        nodes: dict[str, Sequence[Point]] = {
            "support_left": [(-self.span / 2, 0.0)],
            "support_right": [(self.span / 2, 0.0)],
            "load": self.loaded,
            **self._measured,
        }
        return Outline(outline, self.paths, slits, nodes)

    def held(self, *, half: bool = False) -> list[Support]:
        """Rollers under both ends, one of which is held along the beam."""
        up = Support("support_left", (0.0, 1.0))
        if half:
            return [up]
        return [up, Support("support_left", (1.0, 0.0)), Support("support_right", (0.0, 1.0))]

    def drives(self, *, half: bool = False) -> Mapping[str, Drive]:
        """The load at mid-span, downwards. Below it both faces of the crack carry it, jumps are free."""
        return {"load": Drive("load", (0.0, -1.0), holds_jumps=False)}

    def gauges(self, *, half: bool = False) -> Mapping[str, Gauge]:
        """The openings along the beam, and the deflection."""
        left = (-1.0, 0.0)
        gauges = {MAIN_GAUGE: Gauge("gauge_plus", None if half else "gauge_minus", left)} if self.gauge else {}
        points = self._measured
        middle = next(name for name in ("mid_span", "tip", "mouth") if name in points)
        gauges["deflection"] = Gauge(middle, "yoke", (0.0, -1.0))
        gauges["cmod"] = Gauge("mouth", None if half else "mouth", left)
        if "tip" in points:
            gauges["ctod"] = Gauge("tip", None if half else "tip", left)
        return gauges

    def symmetry(self) -> Direction | None:
        """The mid-span plane, if the notch and the path lie in it."""
        return (1.0, 0.0) if self.notch_position == 0.0 and all(x == 0.0 for line in self.paths for x, _ in line) else None
