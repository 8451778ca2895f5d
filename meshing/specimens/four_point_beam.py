"""A notched beam in four-point bending."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ..keys import key
from ..paths import Point
from .base import Drive, expect
from .notched_beam import NotchedBeam
from .registry import register_specimen


@register_specimen("four-point-beam")
@dataclass(frozen=True, kw_only=True)
class FourPointBeam(NotchedBeam):
    """A beam on two supports with a notch in its lower face, loaded from above at two points.

    As `NotchedBeam`, but that two rollers under a beam that rotates about its middle bring the load: each carries one half of
    it. `driven` is their mean motion.
    """

    inner_span: float = key("distance between the two loads", unit="mm", above=0)

    def __post_init__(self) -> None:
        super().__post_init__()
        expect(self, "inner_span", self.inner_span < self.span, f"less than span = {self.span:g}")

    @property
    def loaded(self) -> list[Point]:
        return [(-self.inner_span / 2, self.depth), (self.inner_span / 2, self.depth)]

    def drives(self, *, half: bool = False) -> Mapping[str, Drive]:
        """The two rollers, downwards; one in one half, whose own rotation is that of its mirror image."""
        return {"load": Drive("load", (0.0, -1.0), lever=None if half else self.inner_span / 2)}
