"""A block that a wedge splits."""

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


@register_specimen("wedge-splitting")
@dataclass(frozen=True)
class WedgeSplitting(PlaneSpecimen):
    """A block with a groove in its upper face and a notch below it, which a wedge between two rollers splits.

    Bruehwiler and Wittmann (1990), Eng. Fract. Mech. 35, 117-125. Each roller presses on its side of the groove, outwards with
    the splitting force F_sp and downwards with half of the vertical force F_v of the machine on the wedge,

        F_v = 2 F_sp tan(a + phi),    tan phi = `friction`,

    from the balance of the wedge with the force N normal to each face, which is at an angle a to the vertical, and the
    friction N tan phi along it. `load` is F_sp, or F_v, as the key says, and the other one a column, `vertical_force` or
    `splitting_force`. Two rollers carry the block. `driven` is what the load does its work on: for F_sp the parting of the
    rollers plus tan(a + phi) times what both go down.

    Origin at the middle of the lower face; y upwards. Point sets: `roller_left`, `roller_right`, `support_left`,
    `support_right`, `gauge_plus` and `gauge_minus` (on the sides of the groove), `mouth`, `tip`. The main gauge measures the
    opening between the sides of the groove, `cmod` that of the notch at its mouth, `ctod` that at its tip.
    """

    width: float = key("width of the block", unit="mm", above=0)
    height: float = key("height of the block", unit="mm", above=0)
    thickness: float = key("thickness of the block", unit="mm", above=0)
    groove_width: float = key("width of the groove", unit="mm", above=0)
    groove_depth: float = key("depth of the groove", unit="mm", above=0)
    notch: float = key("depth of the notch below the groove", unit="mm", above=0)
    roller_depth: float = key("depth of the rollers below the upper face", unit="mm", above=0)
    support_span: float = key("distance between the two supports", unit="mm", above=0)
    wedge_angle: float = key("between a face of the wedge and the vertical", 15.0, unit="degrees", at_least=0, below=60)
    friction: float = key("coefficient of friction of the rollers on the wedge", 0.0, at_least=0, below=1)
    load: str = key(
        "what is called load: the horizontal force on a roller, or the vertical one on the wedge",
        "splitting", one_of=("splitting", "vertical"),
    )  # fmt: skip
    gauge_depth: float = key("depth of the gauge below the upper face", 0.0, unit="mm", at_least=0)
    notch_width: float = key("width of the notch; 0: a slit without width", 0.0, unit="mm", at_least=0)
    crack: Any = key("polyline (or list of polylines) of the crack; default: from the notch tip straight down", None)

    def __post_init__(self) -> None:
        super().__post_init__()
        expect(self, "groove_width", self.groove_width < self.width, f"less than width = {self.width:g}")
        expect(self, "notch_width", self.notch_width < self.groove_width, f"less than groove_width = {self.groove_width:g}")
        room = self.height - self.groove_depth
        expect(self, "groove_depth", room > 0, f"less than height = {self.height:g}")
        expect(self, "notch", self.notch < room, f"less than height - groove_depth = {room:g}")
        expect(self, "roller_depth", self.roller_depth < self.groove_depth, f"less than groove_depth = {self.groove_depth:g}")
        expect(self, "gauge_depth", self.gauge_depth < self.groove_depth, f"less than groove_depth = {self.groove_depth:g}")
        steep = self._slope > 0 or self.load == "splitting"
        expect(self, "wedge_angle", steep, "above 0, or friction, if load = 'vertical'")
        expect(self, "wedge_angle", self._slope < math.pi / 2, "less than 90 degrees with the friction")
        expect(self, "support_span", self.support_span < self.width, f"less than width = {self.width:g}")

    @property
    def _slope(self) -> float:
        """Angle of the force on a roller to the horizontal, a + phi."""
        return math.radians(self.wedge_angle) + math.atan(self.friction)

    @property
    def _tip(self) -> Point:
        return (0.0, self.height - self.groove_depth - self.notch)

    @property
    def paths(self) -> list[Line]:
        """The crack path."""
        return self.crack or [[self._tip, (0.0, 0.0)]]

    @property
    def tips(self) -> list[Point]:
        """The end of the notch."""
        return [self._tip]

    @property
    def notch_depth(self) -> float | None:
        """Depth of the notch below the rollers; None if the path does not begin at its tip."""
        is_there = len(self.paths) == 1 and math.dist(self.paths[0][0], self._tip) < 1e-6 * self.height
        return self.groove_depth - self.roller_depth + self.notch if is_there else None

    def outline(self, half: bool = False) -> Outline:
        """The geometry, of the right half if so wanted."""
        a, h, g, w = self.width / 2, self.height, self.groove_width / 2, self.notch_width / 2
        floor, tip, roller, gauge = h - self.groove_depth, self._tip, h - self.roller_depth, h - self.gauge_depth
        points: dict[str, Sequence[Point]] = {
            "roller_right": [(g, roller)], "roller_left": [(-g, roller)],
            "support_right": [(self.support_span / 2, 0.0)], "support_left": [(-self.support_span / 2, 0.0)],
            "gauge_plus": [(g, gauge)], "gauge_minus": [(-g, gauge)],
            "mouth": [(w, floor), (-w, floor)] if w else [(0.0, floor)],
        }  # fmt: skip
        if self.notch_depth is not None:
            points["tip"] = self.tips
        right: list[Point] = [(a, 0.0), (a, h), (g, h), (g, floor)]
        if half:
            named = {name: [p for p in group if p[0] >= 0] for name, group in points.items()}
            corners = [(0.0, 0.0), *right, (w, floor), (w, tip[1]), tip]
            return Outline(without_repeats(corners), self.paths, (), {n: p for n, p in named.items() if p}, half=True)
        left = [(-x, y) for x, y in reversed(right)]
        notch = [(w, floor), (w, tip[1]), (-w, tip[1]), (-w, floor)] if w else []
        slits: list[Line] = [] if w else [[(0.0, floor), tip]]
        return Outline([*right, *notch, *left], self.paths, slits, points)

    def held(self, *, half: bool = False) -> list[Support]:
        """Rollers under the block, one of which is held along it."""
        right = Support("support_right", (0.0, 1.0))
        return [right] if half else [right, Support("support_left", (0.0, 1.0)), Support("support_left", (1.0, 0.0))]

    def drives(self, *, half: bool = False) -> Mapping[str, Drive]:
        """The rollers of the wedge, outwards and downwards."""
        cosine, sine = math.cos(self._slope), math.sin(self._slope)
        share = cosine if self.load == "splitting" else 2.0 * sine
        if half:
            return {"wedge": Drive("roller_right", (cosine, -sine), share=0.5 * share)}
        both = Drive("roller_right", (cosine, -sine), share=share, against="roller_left", against_direction=(cosine, sine))
        return {"wedge": both}

    def forces(self) -> Mapping[str, float]:
        """The force that is not the load, over the load."""
        vertical = 2.0 * math.tan(self._slope)
        return {"vertical_force": vertical} if self.load == "splitting" else {"splitting_force": 1.0 / vertical}

    def gauges(self, *, half: bool = False) -> Mapping[str, Gauge]:
        """The horizontal openings."""
        right = (1.0, 0.0)
        gauges = {MAIN_GAUGE: Gauge("gauge_plus", None if half else "gauge_minus", right)}
        names = {"cmod": "mouth", **({"ctod": "tip"} if self.notch_depth is not None else {})}
        return gauges | {name: Gauge(at, None if half else at, right) for name, at in names.items()}

    def symmetry(self) -> Direction | None:
        """The plane of the notch, if the path lies in it."""
        return None if self.crack else (1.0, 0.0)
