"""A double-edge-notched panel between two stiff frames that pull and shear it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from ..generation.outline import Outline
from .base import Drive, Support, expect
from .mixed_mode_plate import MixedModePlate
from .registry import register_specimen


@register_specimen("tension-shear-panel")
@dataclass(frozen=True)
class TensionShearPanel(MixedModePlate):
    """A panel glued into two stiff frames: one holds the upper end and the left side above the notch, the other one the lower
    end and the right side below the notch.

    The upper frame does not turn. Two drives move it: `pull` upwards and `shear` to the right. The gauge points lie at the
    notch tips. The tests of Nooru-Mohamed (1992), Mixed-mode fracture of concrete, TU Delft.
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        expect(self, "notch", self.notch > 0, "a number above 0")
        expect(self, "platens", self.platens == "fixed", "'fixed'")

    def outline(self, half: bool = False) -> Outline:
        """The geometry."""
        a, b, w = self.width / 2, self.length / 2, self.notch_width / 2
        edges = {"lower": [(-a, -b), (a, -b), (a, -w)], "upper": [(a, b), (-a, b), (-a, w)]}
        return replace(super().outline(), edges=edges)

    def held(self, *, half: bool = False) -> list[Support]:
        """The lower frame."""
        return [Support("lower")]

    def drives(self, *, half: bool = False) -> Mapping[str, Drive]:
        """The upper frame, upwards and to the right."""
        return {"pull": Drive("upper", (0.0, 1.0)), "shear": Drive("upper", (1.0, 0.0))}
