"""A block that is sheared along a plane, with bars across it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from ..keys import key
from .base import Drive
from .registry import register_specimen
from .sandwich_panel import SandwichPanel


@register_specimen("push-off")
@dataclass(frozen=True)
class PushOff(SandwichPanel):
    """A block that is sheared along a plane at its mid-height, with bars that restrain its opening.

    Jefferson and Mihai (2015), Example 4, in the plane: `width` is the length of the shear plane.
    """

    restraint: float = key(
        "stiffness of the bars across the plane, N/mm; they act from the first stage with hold = false on",
        0.0,
        unit="N/mm",
        at_least=0,
    )

    def drives(self, *, half: bool = False) -> Mapping[str, Drive]:
        """The upper platen, with the bars as springs across the plane."""
        return {name: replace(drive, spring=self.restraint) for name, drive in super().drives(half=half).items()}
