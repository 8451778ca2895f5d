"""A notched beam in three-point bending."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..keys import key
from ..outline import Outline
from ..paths import Line, Point
from .base import Direction, Drive, Gauge, PlaneSpecimen, Support, expect, without_repeats
from .registry import register_specimen


@register_specimen("notched-beam")
@dataclass(frozen=True)
class NotchedBeam(PlaneSpecimen):
    """A beam on two supports with a notch in its lower face, loaded at mid-span from above.

    Origin at mid-span on the lower face; x along the beam, y upwards. Point sets: `support_left`,
    `support_right`, `load`, `gauge_plus` (left of the notch) and `gauge_minus`.
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
    crack: Any = key("polyline (or list of polylines) of the crack; default: from the notch tip straight up", None)

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

    def outline(self, half: bool = False) -> Outline:
        """The geometry, of the left half if so wanted."""
        a, b, x, w = self.length / 2, self.depth, self.notch_position, self.notch_width / 2
        if half:
            corners: list[Point] = [(-a, 0.0), (-w, 0.0), (-w, self.notch), (0.0, self.notch), (0.0, b), (-a, b)]
            points: dict[str, Sequence[Point]] = {"support_left": [(-self.span / 2, 0.0)], "load": [(0.0, b)]}
            if self.gauge:
                points["gauge_plus"] = [(-self.gauge / 2, 0.0)]
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
            "load": [(0.0, b)],
        }
        if self.gauge:
            nodes |= {"gauge_plus": [(x - self.gauge / 2, 0.0)], "gauge_minus": [(x + self.gauge / 2, 0.0)]}
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
        """The opening along the beam, on its lower face."""
        if not self.gauge:
            return {}
        return {"opening": Gauge("gauge_plus", None if half else "gauge_minus", (-1.0, 0.0))}

    def symmetry(self) -> Direction | None:
        """The mid-span plane, if the notch and the path lie in it."""
        return (1.0, 0.0) if self.notch_position == 0.0 and not self.crack else None
