"""What a user asks of the loading: stages, checked when they are made."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .columns import UNLOADED, WATCHED
from .controls import CONTROLS

#: steps to a target, if neither their number nor their size is given
DEFAULT_STEPS = 50


@dataclass(frozen=True)
class Stage:
    """One stage of the loading.

    Parameters
    ----------
    control : "opening" | "sliding" (the scene's gauge, mm), "load" (N), "driven" (mm), "dissipation" (N mm in all), or a
        name that was given to `register_control`.
    to : target, or a list of targets that are visited in turn.
    steps : number of equal steps to each target, 50 by default; a step that fails is cut, the next ones grow back. The
        first step after a reversal is a quarter of the others.
    step : their size, instead of their number.
    until : {quantity = value}: end the stage where a recorded quantity passes a value, located within 0.1 %.
        Quantities: the columns of the history, and "load_ratio", the load over the largest one so far.
    unload : {quantity = value}: after each target go back, until a quantity passes a value, before the next target:
        to = [0.02, 0.04], unload = {stress_n = -3.0} opens, closes to -3 MPa, opens further, closes again. Its steps are
        those of a way back to 0. Quantities: load, opening, sliding, driven, stress_n, stress_s; unloading ends where
        the quantity moves away from its value.

    Where a specimen's platen moves both ways (these three hold until another stage gives one of them):

    angle : of its motion from the normal of its face, degrees: 0 pulls it away, 90 shears it. The load and `driven` are
        those along this direction, `driven` counted from the unloaded place.
    ratio : instead of the angle, the part of normal motion on one part of shear; negative: pushed together while sheared.
    hold : whether the platen is held across this direction (default): the platen, not the opening of the gauge. With
        false it moves freely but for the specimen's springs, which take over the force that holds it where the first such
        stage begins, and act from then on.
    """

    control: str
    to: Any
    steps: int | None = None
    step: float | None = None
    until: Any = None
    unload: Any = None
    angle: float | None = None
    ratio: float | None = None
    hold: bool | None = None

    def __post_init__(self) -> None:
        if self.control not in CONTROLS:
            raise ValueError(f"control = {self.control!r}: expected one of {', '.join(CONTROLS)}")
        if self.steps is not None and self.steps < 1:
            raise ValueError(f"steps = {self.steps!r}: expected a whole number of at least 1")
        if self.step is not None and not self.step > 0:
            raise ValueError(f"step = {self.step!r}: expected a number above 0")
        if not self.targets or not all(_is_number(target) for target in self.targets):
            raise ValueError(f"to = {self.to!r}: expected a finite number or a list of them")
        can_fall = CONTROLS[self.control].can_fall
        if not can_fall and (min(self.targets) <= 0 or np.any(np.diff(self.targets) <= 0)):
            raise ValueError(f"to = {self.to!r}: expected growing numbers above 0, {self.control} cannot fall")
        for one, other in (("steps", "step"), ("angle", "ratio")):
            if getattr(self, one) is not None and getattr(self, other) is not None:
                raise ValueError(f"{one} = {getattr(self, one)}, {other} = {getattr(self, other)}: expected one of the two")
        _check_event("until", self.until, WATCHED)
        _check_event("unload", self.unload, UNLOADED)
        if self.unload is not None and not can_fall:
            raise ValueError(f"unload = {self.unload!r}: {self.control} cannot fall; expected another control")

    @property
    def direction(self) -> float | None:
        """Angle of the platen's motion, degrees; None: as before."""
        return self.angle if self.ratio is None else float(np.degrees(np.arctan2(1.0, self.ratio)))

    def count(self, distance: float) -> float:
        """Number of steps, not always whole, to a distance."""
        return max(distance / self.step, 1.0) if self.step is not None else float(self.steps or DEFAULT_STEPS)

    @property
    def targets(self) -> list[float]:
        """The targets as a list."""
        return list(self.to) if isinstance(self.to, (list, tuple)) else [self.to]


def _check_event(key: str, event: Any, names: tuple[str, ...]) -> None:
    if event is None:
        return
    if not isinstance(event, dict) or len(event) != 1:
        raise ValueError(f"{key} = {event!r}: expected one quantity and its value, like {{load = -3000.0}}")
    ((name, value),) = event.items()
    if name not in names or not _is_number(value):
        raise ValueError(f"{key} = {event!r}: expected a number for one of {', '.join(names)}")


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 1e100


def event_text(event: dict[str, float]) -> str:
    """What `until` or `unload` waits for, for messages."""
    ((name, value),) = event.items()
    return f"{name} = {value:g}"
