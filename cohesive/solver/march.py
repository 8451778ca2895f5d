"""The march of a problem through its stages, one converged step at a time."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np

from .events import Event, Watch
from .leg import Leg
from .problem import Problem, State
from .stages import Stage, event_text
from .steps import Step

__all__ = ["March", "Step"]

#: force across the drive, over the strength of the crack, from which on letting go of it is worth a note
_NOTED_FORCE = 1e-6


@dataclass
class March:
    """Takes a problem through its stages.

    Attributes
    ----------
    problem : Problem, which changes with the direction of the drive
    stages : list of Stage
    record : the recorded quantities of a state, by name
    step_growth : up to which multiple of the nominal step a step may grow
    notes : what the reader of the results should know about how the stages ended
    """

    problem: Problem
    stages: list[Stage]
    record: Callable[[State], dict[str, float]]
    step_growth: float = 1.0
    notes: list[str] = field(default_factory=list)
    _slack: dict[str, float] = field(default_factory=dict, init=False)  # by which each control may have missed its target

    def __iter__(self) -> Iterator[Step]:
        state = self.problem.initial()
        before = state
        watch = Watch(self.record)
        angle, hold = 0.0, True
        for number, stage in enumerate(self.stages, start=1):
            if stage.angle is not None or stage.hold is not None:
                angle = angle if stage.angle is None else stage.angle
                hold = hold if stage.hold is None else stage.hold
                before = state = self._redirect(state, number, angle, hold)
            is_reached = False
            for target, event in _legs(stage):
                leg = Leg(
                    self.problem, stage, number, target, event, before, state, watch, self._slack, self.notes, self.step_growth
                )
                for step in leg:
                    before, state = state, step.equilibrium.state
                    watch.keep(state)
                    yield step
                    if self.problem.is_separated(state) and not self._returns(number, target):
                        self.notes.append("ended early: the crack has run through, no traction is left")
                        return
                is_reached = leg.is_reached
                if event is stage.until and is_reached:
                    break
            if stage.until is not None:
                reached = "ended where" if is_reached else "reached its last target before"
                self.notes.append(f"stage {number} {reached} {event_text(stage.until)}")

    def _redirect(self, state: State, number: int, angle: float, hold: bool) -> State:
        """Drive the body at another angle (degrees) from now on, and hold it across or not."""
        self.problem = self.problem.driven(angle, hold)
        self._slack.clear()  # `driven` and the load are now those along another direction
        if not hold and self.problem.rest is None:
            self._let_go(state, number)
        return self.problem.at_rest(state)

    def _let_go(self, state: State, number: int) -> None:
        """Put the springs in place of the force across the drive, or say that it is dropped."""
        self.problem = self.problem.sprung(state)
        if not self.problem.spring:
            angle_across = self.problem.direction[::-1] * np.array([1.0, -1.0])
            across = float(angle_across @ self.problem.internal_force(state)[self.problem.drives])
            if abs(across) > _NOTED_FORCE * self.problem.strength:
                self.notes.append(
                    f"stage {number}: lets go of {across:.4g} N across its drive in one step; what that sets free shows "
                    "as an error of the energy balance"
                )

    def _returns(self, number: int, target: float) -> bool:
        """Whether a separated crack is closed again, or slid, by what is still to come."""
        if len(self.problem.drives) == 2 and (self.problem.hold or self.problem.spring):
            return True  # both parts are held by a platen
        stage = self.stages[number - 1]
        later = stage.targets[stage.targets.index(target) + 1 :] if target in stage.targets else stage.targets
        if stage.unload is not None or any(value < target for value in later):
            return True
        return any(other.control != stage.control or min(other.targets) < target for other in self.stages[number:])


def _legs(stage: Stage) -> Iterator[tuple[float, Event | None]]:
    """Targets, each with the event that ends the way to it."""
    for target in stage.targets:
        yield float(target), stage.until
        if stage.unload is not None:
            yield -np.inf if target > 0 else np.inf, stage.unload
