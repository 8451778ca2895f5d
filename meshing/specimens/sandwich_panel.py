"""A panel with a layer that cracks, between platens that move both ways."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ..generation.outline import Outline
from ..keys import key
from ..paths import Line, Point
from .base import Drive, PlaneSpecimen, Support
from .registry import register_specimen


@register_specimen("sandwich-panel")
@dataclass(frozen=True)
class SandwichPanel(PlaneSpecimen):
    """A rectangular panel with a layer that cracks across its mid-height, clamped between two rigid platens.

    The layer of cracking material between two elastic blocks of Jefferson and Mihai (2015), Example 1; the paper prints
    no dimensions. Origin in the centre, x along the layer. Point sets: `base` and `top`. There is no gauge.
    """

    width: float = key("width of the panel", unit="mm", above=0)
    height: float = key("height of the panel", unit="mm", above=0)
    thickness: float = key("thickness of the panel", unit="mm", above=0)

    @property
    def paths(self) -> list[Line]:
        """The crack path."""
        return [[(-self.width / 2, 0.0), (self.width / 2, 0.0)]]

    def outline(self, half: bool = False) -> Outline:
        """The geometry; there is no half of it."""
        a, b = self.width / 2, self.height / 2
        corners: list[Point] = [(-a, -b), (a, -b), (a, b), (-a, b)]
        edges = {"base": (corners[0], corners[1]), "top": (corners[3], corners[2])}
        return Outline(corners, self.paths, edges=edges)

    def held(self, *, half: bool = False) -> list[Support]:
        """The lower platen."""
        return [Support("base")]

    def drives(self, *, half: bool = False) -> Mapping[str, Drive]:
        """The upper platen, across the layer and along it."""
        return {"platen": Drive("top", (0.0, 1.0), shear=(1.0, 0.0))}
