"""The march of a problem through its stages, one converged step at a time."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from ..errors import NotConverged
from .events import Event, Watch
from .leg import Leg
from .loading import DEAD
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
        before = state = self.problem.initial()
        watch = Watch(self.record)
        for number, stage in enumerate(self.stages, start=1):
            if stage.redirects:
                before = state = self._redirect(state, number, stage)
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

    def _redirect(self, state: State, number: int, stage: Stage) -> State:
        """Do to the drives what a stage says."""
        before, forces = self.problem.loading, self.problem.driven_forces(state)
        loading = before.after(stage.drive, stage.others or {}, forces).turned(stage.angle, stage.hold)
        self.problem = replace(self.problem, loading=loading)
        self._slack.clear()  # `driven` and the load are now those of another motion
        for name in loading.names:
            if loading.drives[name].way == "free" != before.drives[name].way:
                self._note_drop(number, before.force(name, forces), f"of drive '{name}'")
        if loading.moved.is_free_across and not np.isfinite(self.problem.springs.rest[loading.moved.motions[0]]):
            self._let_go(state, number)
        return self.problem.at_rest(state)

    def _let_go(self, state: State, number: int) -> None:
        """Put the springs in place of the force across the drive, or say that it is dropped."""
        self.problem = self.problem.sprung(state)
        moved = self.problem.loading.moved
        if not self.problem.springs.stiffness[moved.motions[0]]:
            across = moved.signs[::-1] * np.array([1.0, -1.0])
            self._note_drop(number, float(across @ self.problem.driven_forces(state)[list(moved.motions)]), "across its drive")

    def _note_drop(self, number: int, force: float, where: str) -> None:
        if abs(force) > _NOTED_FORCE * self.problem.strength:
            self.notes.append(
                f"stage {number}: lets go of {force:.4g} N {where} in one step; what that sets free shows "
                "as an error of the energy balance"
            )

    def _returns(self, number: int, target: float) -> bool:
        """Whether a separated crack is closed again, or slid, by what is still to come."""
        moved = self.problem.loading.moved
        if moved.is_platen and (moved.hold or self.problem.springs.stiffness[moved.motions[0]]):
            return True  # both parts are held by a platen
        stage = self.stages[number - 1]
        later = stage.targets[stage.targets.index(target) + 1 :] if target in stage.targets else stage.targets
        if stage.unload is not None or any(value < target for value in later):
            return True
        return any(other.control != stage.control or min(other.targets) < target for other in self.stages[number:])


def under_dead_loads(problem: Problem) -> Problem:
    """The body under its dead loads, from which its motions count; itself if it has none.

    Raises
    ------
    NotConverged
        If it does not bear them.
    """
    if not problem.dead_factor:
        return problem
    weighed = replace(problem, loading=problem.loading.moving(DEAD), dead_factor=0.0)
    march = March(weighed, [Stage("driven", problem.dead_factor, steps=1)], lambda state: {})
    try:
        *_, step = march
    except NotConverged as error:
        raise NotConverged(f"the body does not bear its dead loads: {error}") from error
    state = step.equilibrium.state
    if problem.is_separated(state) or state.unaccounted > problem.energy:  # it snapped, and fell
        raise NotConverged("the body does not bear its dead loads: they break it; expected less")
    return replace(problem, start=replace(state, load=0.0, driven=0.0))


def _legs(stage: Stage) -> Iterator[tuple[float, Event | None]]:
    """Targets, each with the event that ends the way to it."""
    for target in stage.targets:
        yield float(target), stage.until
        if stage.unload is not None:
            yield -np.inf if target > 0 else np.inf, stage.unload
