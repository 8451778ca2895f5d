"""Events: where a recorded quantity passes a value, within a step or beside it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from .columns import LOAD_RATIO
from .problem import State
from .steps import Resumable

#: {quantity: value}, one entry
Event = dict[str, float]

#: a value is passed within this part of it
_NEAR = 1e-3


def tolerance(value: float, old: float) -> float:
    """How close to its value a quantity has come if it has reached it, from an old value."""
    return _NEAR * max(abs(value), _NEAR * abs(old - value))


@dataclass
class Watch(Resumable):
    """Looks for events in steps that may still be thrown away.

    Attributes
    ----------
    record : the recorded quantities of a state, by name.
    """

    record: Callable[[State], dict[str, float]]
    moving: ClassVar = ("_peak", "_largest")
    _peak: float = field(default=0.0, init=False)  # largest load so far, N
    _largest: float = field(default=1e-300, init=False)  # and largest of either sign

    def keep(self, state: State) -> None:
        """Take note of a step that is kept."""
        self._peak = max(self._peak, state.load)
        self._largest = max(self._largest, abs(state.load))

    @property
    def pushed(self) -> float:
        """Largest load, N, if all are negative; 0 if not."""
        return 0.0 if self._peak > 0 else self._largest

    def departs(self, event: Event, before: State, after: State) -> bool:
        """Whether the quantity moves away from its value, and not by rounding: on a separated crack it stays what it is."""
        ((name, value),) = event.items()
        old, new = self.record(before)[name], self.record(after)[name]
        return abs(new - value) > (1.0 + 1e-9) * abs(old - value)

    def locate(self, event: Event, before: State, after: State) -> tuple[float, bool]:
        """Fraction of the step at which the quantity passes its value (1: not in it), and whether the step ends there."""
        ((name, value),) = event.items()
        is_ratio = name == LOAD_RATIO
        old, new = self._ratios(before, after) if is_ratio else (self.record(before)[name], self.record(after)[name])
        near = tolerance(value, old)
        if abs(new - value) <= near < abs(old - value) and (not is_ratio or old > value):
            return 1.0, True  # from either side: a step that stops short of it is not to be followed by a tiny one
        if old == value or (old - value) * (new - value) > 0 or (is_ratio and new > value):
            return 1.0, False
        if abs(new - value) <= near:
            return 1.0, True
        return float(np.clip((value - old) / (new - old), 0.05, 0.95)), False

    def _ratios(self, before: State, after: State) -> tuple[float, float]:
        """Loads before and after over the largest one so far."""
        if self._peak > 0:
            return before.load / self._peak, after.load / max(self._peak, after.load)
        # pushed from the beginning
        return abs(before.load) / self._largest, abs(after.load) / max(self._largest, abs(after.load))
