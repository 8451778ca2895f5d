"""The steps of a stage towards one target, cut if they fail, grown back if they are easy."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np

from ..errors import NotConverged, PointFailure
from .controls import Control, control_of
from .events import Event, Watch
from .newton import Equilibrium, advance
from .problem import Problem, State
from .snap import WayBack, advance_past_onset, snap_through
from .stages import Stage, event_text
from .steps import SMALLEST_STEP, Resumable, Step, next_size

#: step, as a part of the nominal one, in which a crack that has no equilibrium close by may snap to the next one
SNAP_STEP = 1.0 / 16.0

#: the first step after a reversal, as a part of the nominal one (unless there are fewer steps than that)
REVERSAL_STEP = 0.25

#: a loading step has jumped over a snap-back if it leaves less than this part of the load, and has lost more than the second
#: part of the fracture energy
_KEPT_LOAD, _LOST_ENERGY = 0.7, 0.05

#: a step by dissipation from the onset on bends too far, from the elastic line towards the peak, if more than this part of the
#: work is unaccounted for in it, and is then cut, down to the second part of the nominal step
_BENT, _SMALLEST_BENT = 5e-3, 2.0**-6

#: up to this part of the first nominal step a body counts as intact; no sum of halved steps ends there, so that rounding does
#: not tell
_INTACT = 0.9


@dataclass
class TargetPath(Resumable):
    """The way to one target; iterate over its steps once. With each step it stands where the next one begins.

    Attributes
    ----------
    problem : Problem
    stage : Stage
    number : of the stage, the first is 1
    target : value of the stage's control; infinite on a way back that an event ends
    event : what ends the way before the target, or None
    before, state : the last two committed states; `state` moves along
    watch : Watch
    slack : by which each control may have missed its last target; it sets its own
    notes : of the run, to which it adds
    step_growth : up to which multiple of the nominal step a step may grow
    is_reached : whether the event has come
    """

    problem: Problem
    stage: Stage
    number: int
    target: float
    event: Event | None
    before: State
    state: State
    watch: Watch
    slack: dict[str, float]
    notes: list[str]
    step_growth: float = 1.0
    is_reached: bool = field(default=False, init=False)
    moving: ClassVar = (
        "state", "is_reached", "_value", "_start", "_distance", "_direction", "_nominal", "_size", "_reversal", "_cuts",
        "_leads_away", "_has_begun", "_traced",
    )  # fmt: skip
    _control: Control = field(init=False)
    _value: float = field(init=False)  # of the control in `state`
    _start: float = field(init=False)
    _distance: float = field(init=False)
    _direction: float = field(init=False)
    _nominal: float = field(init=False)
    _size: float = field(init=False)  # of the next step
    _reversal: bool = field(init=False)  # whether the next step is the first one after a reversal
    _cuts: int = field(default=0, init=False)  # of the next step
    _leads_away: bool = field(default=False, init=False)
    _has_begun: bool = field(default=False, init=False)
    _traced: list[Step] = field(default_factory=list, init=False)  # which are still to be handed out

    def __post_init__(self) -> None:
        self._control = control_of(self.stage.control)
        self._start = self._value = self._control.value(self.problem, self.state)
        self._direction = float(np.sign(self.target - self._start))
        # unloading ends at its event, and its steps are those of a way back to 0
        self._distance = abs(self._start) if self._is_unloading() else abs(self.target - self._start)

    def __iter__(self) -> Iterator[Step]:
        name = self.stage.control
        if not self._has_begun:
            if self._distance <= self.slack.get(name, 0.0) + 1e-12 * abs(self._start):
                return
            self._prepare()
        yield from self._handed_out()
        # a converged step may miss its target by the tolerance, and dissipation must not be driven back
        while not self.is_reached and self._direction * (self.target - self._value) > self.slack[name]:
            left, snapped = abs(self.target - self._value), False
            self._size = left if left < 1.001 * self._size else self._size
            try:
                trial = self._try()
            except NotConverged as error:
                self._cut(error)
                if self._size >= SMALLEST_STEP * self._nominal:
                    continue
                if self._control.is_motion and (back := self._trace_back()):
                    self._traced = back
                    self._move(back[-1].equilibrium.state)
                    self._size = SNAP_STEP * self._nominal
                    yield from self._handed_out()
                    continue
                calm = self._without_alternation(error)
                trial, snapped = (self._snap(error), True) if calm is None else (calm, False)
            if self._passes(trial.state, snapped):
                continue
            if self._leads_away:
                self.notes.append(
                    f"stage {self.number}: unloading from {name} = {self._start:.4g} leads away from {self._event_text()}"
                )
                return
            if snapped:
                free = trial.state.released - self.state.released
                self.notes.append(
                    f"stage {self.number}: the crack snaps at {name} = {self._value:.5g}, which sets {free:.3g} N mm free"
                )
            step = Step(trial, self._cuts, name, self._control.value(self.problem, trial.state), self.number)
            self._move(trial.state)
            self._size = next_size(self.problem, self._size, trial.iterations, self._nominal, self.step_growth)
            yield step

    def _handed_out(self) -> Iterator[Step]:
        while self._traced:
            yield self._traced.pop(0)

    def _is_unloading(self) -> bool:
        return self.event is not None and self.event is self.stage.unload

    def _event_text(self) -> str:
        assert self.event is not None
        return event_text(self.event)

    def _prepare(self) -> None:
        """Nominal step, first step, and by how much the target may be missed."""
        self._has_begun = True
        count = self.stage.count(self._distance)
        self._nominal = self._distance / count
        self.slack[self.stage.control] = 2.0 * max(1e-9, self.problem.tol) * self._nominal
        self._reversal = self._direction * (self._start - self._control.value(self.problem, self.before)) < 0
        self._reversal |= self._control.is_unloading(self.state, self._direction)
        self._size = self._nominal * (REVERSAL_STEP if self._reversal and count * REVERSAL_STEP >= 1.0 else 1.0)

    def _move(self, state: State) -> None:
        """Go on from a committed state."""
        self.state, self._reversal, self._cuts = state, False, 0
        self._value = self._control.value(self.problem, state)

    def _try(self) -> Equilibrium:
        """The next step, if it neither fails nor jumps over a snap-back."""
        to = self._value + self._direction * self._size
        trial = advance_past_onset(self.problem, self.state, self.stage.control, to, self._reversal)
        if self._control.is_motion and self._direction * self._value >= 0 and self._jumps(trial.state):
            raise NotConverged("the step jumps over states in which the motion goes back")
        if self._control.begins_at_onset and self._bends(trial.state):
            raise NotConverged("the step bends from the elastic line towards the peak")
        return trial

    def _jumps(self, after: State) -> bool:
        """Whether a loading step has lost so much load and energy that it must have passed over a snap-back."""
        lost = after.unaccounted - self.state.unaccounted
        return after.load < _KEPT_LOAD * self.state.load and lost > _LOST_ENERGY * self.problem.energy

    def _bends(self, after: State) -> bool:
        """Whether a step of a body that is still all but intact is too large for the trapezoidal rule of its work. Where
        dissipation has begun before, the targets of cut steps would move with whatever moves that."""
        is_intact = self._start == 0.0 and self.state.dissipated < _INTACT * self._nominal
        lost = abs(after.unaccounted - self.state.unaccounted)
        return is_intact and self._size > _SMALLEST_BENT * self._nominal and lost > _BENT * abs(after.work)

    def _cut(self, error: NotConverged) -> None:
        self._cuts += 1
        self._size *= 0.25 if isinstance(error.__cause__, PointFailure) else 0.5

    def _without_alternation(self, error: NotConverged) -> Equilibrium | None:
        """A whole step with the tangents of unloading, if the stage is led by dissipation. There is an equilibrium close by
        then, and what keeps Newton's method from it are points that load and unload by turns; None if that fails too."""
        if not self._control.begins_at_onset or isinstance(error.__cause__, PointFailure):
            return None
        name, size = self.stage.control, min(self._nominal, abs(self.target - self._value))
        try:
            trial = advance(replace(self.problem, secant=True), self.state, name, self._value + self._direction * size)
        except NotConverged:
            return None
        note = f"stage {self.number}: Newton's method alternates from {name} = "
        if not any(each.startswith(note) for each in self.notes):
            self.notes.append(f"{note}{self._value:.5g} on; the tangents of unloading lead on, in more iterations")
        self._size = size
        return trial

    def _snap(self, error: NotConverged) -> Equilibrium:
        """The next equilibrium after a snap, for a step that failed with this error."""
        name, size = self.stage.control, self._size
        snap = min(SNAP_STEP * self._nominal, abs(self.target - self._value))
        try:
            if isinstance(error.__cause__, PointFailure):  # not a lack of equilibrium, which damping overcomes
                raise error
            trial = snap_through(self.problem, self.state, name, self._value + self._direction * snap, self._nominal)
        except NotConverged:
            towards = f"towards {self.target:.6g}" if np.isfinite(self.target) else "back"
            raise NotConverged(
                f"stage {self.number}: the step from {name} = {self._value:.6g} {towards} failed down to "
                f"{size:.1e}: {error}. {self._control.advice}"
            ) from error
        self._size = snap
        return trial

    def _passes(self, after: State, snapped: bool) -> bool:
        """Whether the step passes the event and is to be taken again with another size; else whether the event has come, or
        unloading leads away from it, is known."""
        if self.event is None:
            return False
        fraction, reached = self.watch.locate(self.event, self.state, after)
        if not reached and fraction < 1.0:
            if not snapped and self._size * fraction > SMALLEST_STEP**2 * self._nominal:
                self._size *= fraction
                return True
            reached = True  # within a snap, or a step that small, there is no equilibrium at which to stop
        self.is_reached = reached
        self._leads_away = self._is_unloading() and not reached and self.watch.departs(self.event, self.state, after)
        return False

    def _trace_back(self) -> list[Step]:
        """Steps by dissipation over a snap-back, none if they fail."""
        back = WayBack(self.problem, self._control, self._direction, self.target, self._nominal, self._locate)
        steps = back.follow(self.state)
        if steps and back.furthest < back.start:
            here, there = (self._direction * value for value in (back.start, back.furthest))
            self.notes.append(
                f"stage {self.number}: {self.stage.control} goes back from {here:.5g} to {there:.5g}, "
                f"followed by {len(steps)} steps of dissipation"
            )
        self.is_reached = back.is_reached
        return [Step(trial, cuts, "dissipation", trial.state.dissipated, self.number) for trial, cuts in steps]

    def _locate(self, before: State, after: State) -> tuple[float, bool]:
        return (1.0, False) if self.event is None else self.watch.locate(self.event, before, after)
