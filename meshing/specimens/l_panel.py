"""An L-shaped panel that cracks from its corner."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..generation.outline import Outline
from ..keys import key
from ..paths import Line, Point
from .base import Drive, Gauge, PlaneSpecimen, Support, expect
from .registry import register_specimen

#: segments of the path, a parabola
_SEGMENTS = 10


@register_specimen("l-panel")
@dataclass(frozen=True)
class LPanel(PlaneSpecimen):
    """An L-shaped panel that stands on one leg and is lifted at the end of the other.

    Winkler (2001), Traglastuntersuchungen von unbewehrten und bewehrten Betonstrukturen. Origin at the lower left; the leg is
    held at its foot, y = 0, and the arm is loaded from below. Point sets: `base`, `load`, `corner`. There is no main gauge:
    the opening is the mean jump over the crack. `cmod` is the vertical opening at the corner. In the smeared model the
    corner gives way to the band that begins in it, and `cmod` is measured over its end.
    """

    size: float = key("height and width of the panel", unit="mm", above=0)
    arm: float = key("width of both legs", unit="mm", above=0)
    thickness: float = key("thickness of the panel", unit="mm", above=0)
    load_from_end: float = key("distance of the load from the end of the arm", unit="mm", above=0)
    angle: float = key(
        "of the crack path at the corner, above the horizontal; from there it bends, and ends level at the other side",
        20.0,
        unit="degrees",
        above=-45,
        below=45,
    )
    stiffness: float | None = key("of the support against the lifting; None: it does not give way", None, unit="N/mm", above=0)
    crack: Any = key("polyline (or list of polylines) of the crack, instead of angle", None, unit="mm")

    def __post_init__(self) -> None:
        super().__post_init__()
        expect(self, "arm", self.arm < self.size, f"less than size = {self.size:g}")
        reach = self.size - self.arm
        expect(self, "load_from_end", self.load_from_end < reach, f"a load on the arm, less than {reach:g}")

    @property
    def corner(self) -> Point:
        """The corner between the legs."""
        return (self.arm, self.size - self.arm)

    @property
    def paths(self) -> list[Line]:
        """The crack path."""
        x, y = self.corner
        slope = math.tan(math.radians(self.angle))
        along = [x * i / _SEGMENTS for i in range(_SEGMENTS + 1)]
        return self.crack or [[(x - s, y + slope * (s - s * s / (2.0 * x))) for s in along]]

    @property
    def notch_depth(self) -> float | None:
        """0: the path begins at the corner; None if it does not."""
        return 0.0 if len(self.paths) == 1 and math.dist(self.paths[0][0], self.corner) < 1e-6 * self.size else None

    def outline(self, half: bool = False) -> Outline:
        """The geometry; there is no half of it."""
        a, (x, y) = self.size, self.corner
        corners: list[Point] = [(0.0, 0.0), (x, 0.0), (x, y), (a, y), (a, a), (0.0, a)]
        nodes: dict[str, Sequence[Point]] = {"load": [(a - self.load_from_end, y)], "corner": [(x, y)]}
        return Outline(corners, self.paths, (), nodes, {"base": (corners[0], corners[1])})

    def held(self, *, half: bool = False) -> list[Support]:
        """The foot of the leg."""
        return [Support("base", (1.0, 0.0)), Support("base", (0.0, 1.0), stiffness=self.stiffness)]

    def drives(self, *, half: bool = False) -> Mapping[str, Drive]:
        """The load, upwards."""
        return {"load": Drive("load", (0.0, 1.0))}

    def gauges(self, *, half: bool = False) -> Mapping[str, Gauge]:
        """The vertical opening at the corner."""
        return {} if self.notch_depth is None else {"cmod": Gauge("corner", "corner", (0.0, 1.0))}
