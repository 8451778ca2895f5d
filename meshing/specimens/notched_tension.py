"""A notched plate in tension."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..generation.outline import Outline
from ..keys import key
from ..paths import Line, Point
from .base import Direction, Drive, Gauge, PlaneSpecimen, Support, expect, without_repeats
from .registry import register_specimen


@register_specimen("notched-tension")
@dataclass(frozen=True)
class NotchedTension(PlaneSpecimen):
    """A plate with notches at mid-length, pulled between two rigid platens.

    Origin in the centre; x across the plate, y along the pull. Point sets: `base`, `top` and the gauge
    points on both edges, `gauge_minus` below and `gauge_plus` above.
    """

    length: float = key("length of the plate, along the pull", unit="mm", above=0)
    width: float = key("width of the plate", unit="mm", above=0)
    thickness: float = key("thickness of the plate", unit="mm", above=0)
    notch: float = key("depth of each notch", unit="mm", at_least=0)
    notches: str = key("from both edges, or from the left one", "double", one_of=("double", "single"))
    notch_width: float = key("width of the notches; 0: slits without width", 0.0, unit="mm", at_least=0)
    gauge: float = key(
        "length over which the opening is measured, mean of both edges; 0: mean jump over the crack",
        0.0,
        unit="mm",
        at_least=0,
    )
    platens: str = key(
        "'fixed' (they do not turn) or 'hinged' (each turns about the centre of its face). Between hinged platens "
        "the even opening of a symmetric plate is an unstable equilibrium, from which only a path that is not "
        "symmetric departs",
        "fixed",
        one_of=("fixed", "hinged"),
    )
    crack: Any = key("polyline (or list of polylines) of the crack; default: straight through the ligament", None, unit="mm")

    def __post_init__(self) -> None:
        super().__post_init__()
        depth = self.notch * (2 if self.notches == "double" else 1)
        expect(self, "notch", depth < self.width, f"a ligament to be left of width = {self.width:g}")
        expect(self, "notch_width", self.notch_width < self.length, f"less than length = {self.length:g}")
        if self.gauge:
            inside = self.notch_width < self.gauge < self.length
            expect(self, "gauge", inside, f"between notch_width = {self.notch_width:g} and length = {self.length:g}")

    @property
    def paths(self) -> list[Line]:
        """The crack path."""
        right = self.width / 2 - (self.notch if self.notches == "double" else 0.0)
        return self.crack or [[(-self.width / 2 + self.notch, 0.0), (right, 0.0)]]

    @property
    def tips(self) -> list[Point]:
        """The ends of the notches."""
        x = self.width / 2 - self.notch
        return ([(-x, 0.0), (x, 0.0)] if self.notches == "double" else [(-x, 0.0)]) if self.notch else []

    @property
    def notch_depth(self) -> float | None:
        """Depth of a single notch that the crack goes on from."""
        tip = (-self.width / 2 + self.notch, 0.0)
        is_there = len(self.paths) == 1 and math.dist(self.paths[0][0], tip) < 1e-6 * self.width
        return self.notch if self.notches == "single" and is_there else None

    @property
    def gauge_at(self) -> tuple[float, float]:
        """Where across the plate the opening is measured."""
        return -self.width / 2, self.width / 2

    def outline(self, half: bool = False) -> Outline:
        """The geometry, of the upper half if so wanted."""
        a, b, w = self.width / 2, self.length / 2, self.notch_width / 2
        tip = a - self.notch
        both = self.notches == "double"
        if half:
            right = tip if both else a
            corners = [(-a, w), (-tip, w), (-tip, 0.0), (right, 0.0), (right, w if both else 0.0), (a, w if both else 0.0)]
            corners += [(a, b), (-a, b)]
            points = {"gauge_plus": [(x, self.gauge / 2) for x in self.gauge_at]} if self.gauge else {}
            edge = {"top": ((-a, b), (a, b))}
            return Outline(without_repeats(corners), self.paths, (), points, edge, half=True)
        outline: list[Point] = [(-a, -b), (a, -b)]
        if self.notch and w and both:
            outline += [(a, -w), (tip, -w), (tip, w), (a, w)]
        outline += [(a, b), (-a, b)]
        if self.notch and w:
            outline += [(-a, w), (-tip, w), (-tip, -w), (-a, -w)]
        slits: list[Line] = [[(-a, 0.0), (-tip, 0.0)], [(tip, 0.0), (a, 0.0)]]
        if w or not self.notch:
            slits = []
        elif not both:
            slits = slits[:1]
        g = self.gauge / 2
        nodes: dict[str, Sequence[Point]] = {}
        if g:
            nodes = {"gauge_minus": [(x, -g) for x in self.gauge_at], "gauge_plus": [(x, g) for x in self.gauge_at]}
        return Outline(outline, self.paths, slits, nodes, {"base": ((-a, -b), (a, -b)), "top": ((-a, b), (a, b))})

    def held(self, *, half: bool = False) -> list[Support]:
        """The lower platen, and the upper one across the pull."""
        if half:
            return [Support("top", (1.0, 0.0))]
        return [*self.held_base(), Support("top", (1.0, 0.0))]

    def held_base(self) -> list[Support]:
        """The lower platen; a hinged one rotates about the centre of its face."""
        return [Support("base", (1.0, 0.0)), Support("base", (0.0, 1.0), lever=self.lever)]

    @property
    def lever(self) -> float | None:
        """Half the width of hinged platens, mm."""
        return self.width / 2 if self.platens == "hinged" else None

    def drives(self, *, half: bool = False) -> Mapping[str, Drive]:
        """The upper platen. The plane of symmetry stays where it is, so the top of a half moves by half of the drive."""
        if half:
            return {"platen": Drive("top", (0.0, 1.0), share=0.5)}
        return {"platen": Drive("top", (0.0, 1.0), lever=self.lever)}

    def gauges(self, *, half: bool = False) -> Mapping[str, Gauge]:
        """The opening along the pull, mean of both edges."""
        if not self.gauge:
            return {}
        return {"opening": Gauge("gauge_plus", None if half else "gauge_minus", (0.0, 1.0))}

    def symmetry(self) -> Direction | None:
        """The plane at mid-length, if the path lies in it and the platens do not rotate."""
        return (0.0, 1.0) if not self.crack and self.platens == "fixed" else None
