"""A double-edge-notched plate whose platen moves both ways."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from .base import Drive, Support, expect
from .notched_tension import NotchedTension
from .registry import register_specimen


@register_specimen("mixed-mode-plate")
@dataclass(frozen=True)
class MixedModePlate(NotchedTension):
    """A plate with deep notches from both edges whose top platen moves along and across it.

    As `NotchedTension`, but the gauge points lie at the notch tips, and stages may give the direction of the platen:
    Jefferson and Mihai (2015), Example 3. Between hinged platens no shear force is in equilibrium.
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        expect(self, "notches", self.notches == "double", "'double'")

    @property
    def gauge_at(self) -> tuple[float, float]:
        return -self.width / 2 + self.notch, self.width / 2 - self.notch

    def held(self, *, half: bool = False) -> list[Support]:
        """The lower platen."""
        return self.held_base()

    def drives(self, *, half: bool = False) -> Mapping[str, Drive]:
        """The upper platen, along the pull and across it."""
        return {"platen": Drive("top", (0.0, 1.0), shear=(1.0, 0.0), lever=self.lever)}

    def symmetry(self) -> None:
        """None: it is sheared."""
