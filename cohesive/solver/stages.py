"""What a user asks of the loading: stages, checked when they are made."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from meshing.keys import key

from ..errors import ParameterError
from .controls import control_of
from .loading import MODES

#: steps to a target that a run may ask for
MOST_STEPS = 1_000_000

#: steps to a target, if neither their number nor their size is given
DEFAULT_STEPS = 50


@dataclass(frozen=True)
class Stage:
    """One stage of the loading.

    Angle and hold are for a platen that moves both ways, and stay until another stage gives them. The load and `driven` are
    those along the angle, `driven` counted from the unloaded place.

    Raises
    ------
    ParameterError
        Naming the key, its value and what was expected.
    """

    control: str = key(
        "'opening' or 'sliding' (of the main gauge, mm), 'load' (N), 'driven' (mm), 'dissipation' (N mm in all), the name of "
        "a further gauge of the specimen (mm), or a name that was given to register_control"
    )
    to: Any = key("target, or a list of targets that are visited in turn", unit="mm, N or N mm")
    steps: int | None = key(
        f"number of equal steps to each target, {DEFAULT_STEPS} if neither it nor step is given; the first one after a "
        "reversal is a quarter of the others",
        None,
    )
    step: float | None = key("size of the steps, instead of their number", None, unit="mm, N or N mm")
    until: Any = key(
        "{quantity = value}: end the stage if a column of the history, or load_ratio (the load over the largest one so far), "
        "passes a value, located within 0.1 %",
        None,
    )
    unload: Any = key(
        "{quantity = value}: after each target go back until a quantity passes a value, in steps of a way back to 0: to = "
        "[0.02, 0.04], unload = {stress_n = -3.0} opens, closes to -3 MPa, opens further, closes again; it ends if the "
        "quantity moves away from its value",
        None,
    )
    angle: float | None = key(
        "angle of the platen's motion from the normal of its face: 0 pulls it away, 90 shears it", None, unit="degrees"
    )
    hold: bool | None = key(
        "whether the platen is held across its motion, as at first; if not it is free but for the specimen's springs, which "
        "take over the force that holds it where the first such stage begins",
        None,
    )

    drive: str | None = key(
        "name of the drive that is moved, if the specimen has several; load and driven are its own; default: the one of the "
        "stage before, at first the first one",
        None,
    )
    others: Any = key(
        "what is done to the other drives, {name = 'force'} (held at the force reached), 'motion' (held where it is) or "
        "'free' (no force); it stays until another stage says otherwise. The one that was moved before, and those that no "
        "stage has named, are held at their force",
        None,
    )

    def __post_init__(self) -> None:
        if self.steps is not None and not 1 <= self.steps <= MOST_STEPS:
            raise _refused("steps", self.steps, f"a whole number from 1 to {MOST_STEPS}")
        if self.step is not None and not self.step > 0:
            raise _refused("step", self.step, "a number above 0")
        if not self.targets or not all(_is_number(target) for target in self.targets):
            raise _refused("to", self.to, "a finite number or a list of them")
        if self.step is not None and max(map(abs, self.targets)) > MOST_STEPS * self.step:
            raise _refused("step", self.step, f"at most {MOST_STEPS} steps to {max(map(abs, self.targets)):g}")
        can_fall = control_of(self.control).can_fall
        if not can_fall and (min(self.targets) <= 0 or np.any(np.diff(self.targets) <= 0)):
            raise _refused("to", self.to, f"growing numbers above 0, {self.control} cannot fall")
        if self.steps is not None and self.step is not None:
            raise ParameterError.at("steps", f" = {self.steps}, step = {self.step}: expected one of the two")
        if self.others is not None and not (
            isinstance(self.others, dict) and all(isinstance(mode, str) and mode in MODES for mode in self.others.values())
        ):
            raise _refused("others", self.others, "{name of a drive = 'force' or 'motion' or 'free'}")
        if self.others and self.drive in self.others:
            raise _refused("others", self.others, f"other drives than drive = {self.drive!r}, which the stage moves")
        _check_event("until", self.until)
        _check_event("unload", self.unload)
        if self.unload is not None and not can_fall:
            raise ParameterError.at("unload", f" = {self.unload!r}: {self.control} cannot fall; expected another control")

    @property
    def data(self) -> dict[str, Any]:
        """Its keys, as a scene gives them."""
        return {each.name: value for each in fields(self) if (value := getattr(self, each.name)) is not None}

    @property
    def redirects(self) -> bool:
        """Whether it says anything of the drives."""
        return any(value is not None for value in (self.angle, self.hold, self.drive, self.others))

    def count(self, distance: float) -> float:
        """Number of steps, not always whole, to a distance."""
        return max(distance / self.step, 1.0) if self.step is not None else float(self.steps or DEFAULT_STEPS)

    @property
    def targets(self) -> list[float]:
        """The targets as a list."""
        return list(self.to) if isinstance(self.to, (list, tuple)) else [self.to]


def _check_event(key: str, event: Any) -> None:
    if event is None:
        return
    if not isinstance(event, dict) or len(event) != 1:
        raise _refused(key, event, "one quantity and its value, like {load = -3000.0}")
    ((name, value),) = event.items()
    if not isinstance(name, str) or not _is_number(value):
        raise _refused(key, event, "a quantity and a number")


def _refused(key: str, value: object, expected: str) -> ParameterError:
    return ParameterError.at(key, f" = {value!r}: expected {expected}")


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 1e100


def event_text(event: dict[str, float]) -> str:
    """What `until` or `unload` waits for, for messages."""
    ((name, value),) = event.items()
    return f"{name} = {value:g}"


def expected_steps(stages: Sequence[Stage]) -> int:
    """Number of steps if none is cut."""
    total, value = 0.0, 0.0
    for stage in stages:
        for target in stage.targets:
            total += stage.count(abs(target - value)) + (stage.count(abs(target)) if stage.unload else 0.0)
            value = 0.0 if stage.unload else target
        value = 0.0
    return round(total)
