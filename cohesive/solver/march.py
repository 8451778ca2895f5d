"""Stages: what is controlled, how far, in which steps, until when; and the march through them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..errors import NotConverged, PointFailure
from .newton import Equilibrium, advance, most_iterations
from .problem import Problem, State
from .snap import advance_to_onset, snap_through
from .stages import DEFAULT_STEPS, MOTIONS, Stage, event_text

#: a step is cut down to this part of the nominal one before the crack is taken to snap
SMALLEST_STEP = 2.0**-10

#: step, as a part of the nominal one, in which a crack that has no equilibrium close by may snap to the next one
SNAP_STEP = 1.0 / 16.0

#: a step that needed no more than this part of the iterations that it may take lets the next one grow back to the nominal
#: step, and one that needed no more than the second part lets it grow beyond
EASY, VERY_EASY = 0.25, 0.1

#: the first step after a reversal, as a part of the nominal one (unless there are fewer steps than that)
REVERSAL_STEP = 0.25

_SNAP = "Where part of the crack snaps through, another control or mesh.crack_size helps; smaller steps do not"

_ADVICE = {"load": "No larger load may be in equilibrium; control = 'opening' or 'driven' goes on past the peak"}


@dataclass(frozen=True)
class Step:
    """One converged step."""

    equilibrium: Equilibrium
    cuts: int
    control: str
    value: float
    stage: int  # the first is 1


@dataclass
class March:
    """Takes a problem through its stages, one converged step at a time.

    Attributes
    ----------
    notes : what the reader of the results should know about how the stages ended.
    """

    problem: Problem
    stages: list[Stage]
    record: Callable[[State], dict[str, float]]
    largest_step: float = 1.0  # up to which multiple of the nominal step a step may grow
    notes: list[str] = field(default_factory=list)
    _peak: float = field(default=0.0, init=False)  # largest load so far
    _largest: float = field(default=1e-300, init=False)  # and largest of either sign
    _slack: dict[str, float] = field(default_factory=dict, init=False)  # by which each control may have missed its target
    _reached: bool = field(default=False, init=False)  # whether the stage's `until` has been reached

    def __iter__(self) -> Iterator[Step]:
        state = self.problem.initial()
        before = state
        angle, hold = 0.0, True
        for number, stage in enumerate(self.stages):
            if stage.direction is not None or stage.hold is not None:
                angle = angle if stage.direction is None else stage.direction
                hold = hold if stage.hold is None else stage.hold
                self.problem = self.problem.driven(angle, hold)
                self._slack.clear()  # `driven` and the load are now those along another direction
                if not hold and self.problem.rest is None:
                    self._let_go(state, number)
                before = state = self.problem.at_rest(state)
            for target, event in self._legs(stage):
                self._reached = False
                for step in self._leg(before, state, stage, number, target, event):
                    before, state = state, step.equilibrium.state
                    self._peak = max(self._peak, state.load)
                    self._largest = max(self._largest, abs(state.load))
                    yield step
                    if self.problem.is_separated(state) and not self._returns(number, target):
                        self.notes.append("ended early: the crack has run through, no traction is left")
                        return
                if event is stage.until and self._reached:
                    break
            if stage.until is not None:
                reached = "ended where" if self._reached else "reached its last target before"
                self.notes.append(f"stage {number + 1} {reached} {event_text(stage.until)}")

    def _let_go(self, state: State, number: int) -> None:
        """Put the springs in place of the force across the drive, or say that it is dropped."""
        self.problem = self.problem.sprung(state)
        if not self.problem.spring:
            angle_across = self.problem.direction[::-1] * np.array([1.0, -1.0])
            across = float(angle_across @ self.problem.internal_force(state)[self.problem.drives])
            if abs(across) > 1e-6 * self.problem.full_strength:
                self.notes.append(
                    f"stage {number + 1}: lets go of {across:.4g} N across its drive in one step; what that sets free shows "
                    "as an error of the energy balance"
                )

    def _returns(self, number: int, target: float) -> bool:
        """Whether a separated crack is closed again, or slid, by what is still to come."""
        if len(self.problem.drives) == 2 and (self.problem.hold or self.problem.spring):
            return True  # both parts are held by a platen
        stage = self.stages[number]
        later = stage.targets[stage.targets.index(target) + 1 :] if target in stage.targets else stage.targets
        if stage.unload is not None or any(value < target for value in later):
            return True
        return any(other.control != stage.control or min(other.targets) < target for other in self.stages[number + 1 :])

    @staticmethod
    def _legs(stage: Stage) -> Iterator[tuple[float, Any]]:
        """Targets, each with the event that ends the way to it."""
        for target in stage.targets:
            yield float(target), stage.until
            if stage.unload is not None:
                yield -np.inf if target > 0 else np.inf, stage.unload

    def _leg(self, before: State, state: State, stage: Stage, number: int, target: float, event: Any) -> Iterator[Step]:
        """Steps of a stage towards one target; `before` is the state before the last step."""
        problem, control = self.problem, stage.control
        start = problem.measure(control, state)
        unloading = event is stage.unload and event is not None
        # unloading ends at its event, and its steps are those of a way back to 0
        distance = abs(start) if unloading else abs(target - start)
        if distance <= self._slack.get(control, 0.0) + 1e-12 * abs(start):
            return
        count = stage.count(distance)
        nominal = distance / count
        slack = self._slack[control] = 2.0 * max(1e-9, problem.tol) * nominal
        direction = float(np.sign(target - start))
        reversal = direction * (start - problem.measure(control, before)) < 0
        reversal |= control == "load" and state.load * direction < 0
        size = nominal * (REVERSAL_STEP if reversal and count * REVERSAL_STEP >= 1.0 else 1.0)
        value, cuts = start, 0
        # a converged step may miss its target by the tolerance, and dissipation must not be driven back
        while direction * (target - value) > slack:
            left, snapped = abs(target - value), False
            size = left if left < 1.001 * size else size
            try:
                trial = self._advance(state, control, value + direction * size, reversal)
                if control in MOTIONS and direction * value >= 0 and self._jumps(state, trial.state):
                    raise NotConverged("the step jumps over states in which the motion goes back")
            except NotConverged as error:
                cuts += 1
                size *= 0.25 if isinstance(error.__cause__, PointFailure) else 0.5
                if size >= SMALLEST_STEP * nominal:
                    continue
                if control in MOTIONS and (back := self._trace_back(state, stage, number, nominal, target, event)):
                    yield from back
                    state, reversal, cuts, size = back[-1].equilibrium.state, False, 0, SNAP_STEP * nominal
                    value = problem.measure(control, state)
                    if self._reached:
                        return
                    continue
                snap = min(SNAP_STEP * nominal, abs(target - value))
                try:
                    if isinstance(error.__cause__, PointFailure):  # not a lack of equilibrium, which damping overcomes
                        raise error
                    trial = snap_through(problem, state, control, value + direction * snap, nominal)
                except NotConverged:
                    towards = f"towards {target:.6g}" if np.isfinite(target) else "back"
                    raise NotConverged(
                        f"stage {number + 1}: the step from {control} = {value:.6g} {towards} failed down to "
                        f"{size:.1e}: {error}. {_ADVICE.get(control, _SNAP)}"
                    ) from error
                size, snapped = snap, True
            reached = False
            if event is not None:
                fraction, reached = self._watch(event, state, trial.state)
                if not reached and fraction < 1.0:
                    if not snapped and size * fraction > SMALLEST_STEP**2 * nominal:
                        size *= fraction
                        continue
                    reached = True  # within a snap, or a step that small, there is no equilibrium at which to stop
                if unloading and not reached and self._departs(event, state, trial.state):
                    self.notes.append(
                        f"stage {number + 1}: unloading from {control} = {start:.4g} leads away from {event_text(event)}"
                    )
                    return
            if snapped:
                free = self._balance(trial.state) - self._balance(state)
                self.notes.append(
                    f"stage {number + 1}: the crack snaps at {control} = {value:.5g}, which sets {free:.3g} N mm free"
                )
            yield Step(trial, cuts, control, problem.measure(control, trial.state), number + 1)
            state, reversal, cuts = trial.state, False, 0
            value = problem.measure(control, state)
            if reached:
                self._reached = True
                return
            size = self.next_size(size, trial.iterations, nominal)

    def next_size(self, size: float, iterations: int, nominal: float) -> float:
        """Size of the step after one that took so many iterations."""
        effort = iterations / most_iterations(self.problem)
        if effort > EASY:
            return max(0.5 * size, nominal) if size > nominal else size
        most = nominal * (self.largest_step if effort <= VERY_EASY else 1.0)
        return min(2.0 * size, most) if size < most else size

    def _trace_back(self, state: State, stage: Stage, number: int, nominal: float, target: float, event: Any) -> list[Step]:
        """Steps by dissipation from where the controlled motion must go back, until it advances again; none if they fail.

        A crack that sets more energy free than it takes has its next equilibrium behind it. None of these steps moves
        further than a nominal one, and none behind the unloaded place.
        """
        problem, control = self.problem, stage.control
        direction = float(np.sign(target - problem.measure(control, state)))
        size = largest = problem.point_law.concrete.Gf * problem.area / DEFAULT_STEPS
        start = last = furthest = direction * problem.measure(control, state)
        steps: list[Step] = []
        cuts = 0
        if start <= 0 or not (state.load > 0 or problem.point_law.is_on_surface(state.cracks)):
            return steps  # unloading, or pushed: what dissipates next lies the other way
        while size > SMALLEST_STEP**2 * largest:
            fraction, reached = 1.0, False
            try:
                trial = self._advance(state, "dissipation", state.dissipated + size, False)
                place = direction * problem.measure(control, trial.state)
                if event is not None:
                    fraction, reached = self._watch(event, state, trial.state)
            except NotConverged:
                place = np.inf
            strays = not 0 <= place <= direction * target or abs(place - last) > nominal
            if strays or (fraction < 1.0 and size * fraction > SMALLEST_STEP**2 * largest):
                size *= 0.5 if strays else fraction
                cuts += 1
                continue
            reached |= fraction < 1.0  # in a step that small there is no equilibrium at which to stop
            steps.append(Step(trial, cuts, "dissipation", trial.state.dissipated, number + 1))
            state, cuts = trial.state, 0
            furthest = min(furthest, place)
            self._reached = reached
            if reached or problem.is_separated(state) or (place > last and (place > start or furthest < start)):
                if furthest < start:
                    self.notes.append(
                        f"stage {number + 1}: {control} goes back from {direction * start:.5g} to {direction * furthest:.5g}, "
                        f"followed by {len(steps)} steps of dissipation"
                    )
                return steps
            last = place
            size = min(self.next_size(size, trial.iterations, largest), largest)
        return []

    def _advance(self, state: State, control: str, value: float, reversal: bool) -> Equilibrium:
        if control == "dissipation" and not self.problem.point_law.is_on_surface(state.cracks):
            return advance_to_onset(self.problem, state)
        return advance(self.problem, state, control, value, reversal)

    def _jumps(self, before: State, after: State) -> bool:
        """Whether a loading step has lost so much load and energy that it must have passed over a snap-back."""
        lost = self._balance(after) - self._balance(before)
        whole = self.problem.point_law.concrete.Gf * self.problem.area
        return after.load < 0.7 * before.load and lost > 0.05 * whole

    @staticmethod
    def _balance(state: State) -> float:
        """Work that no energy accounts for, N mm."""
        return state.work - state.elastic - state.stored - state.dissipated - state.contact_work

    def _departs(self, event: dict[str, float], before: State, after: State) -> bool:
        """Whether a quantity moves away from its value."""
        ((name, value),) = event.items()
        old, new = self.record(before)[name], self.record(after)[name]
        return abs(new - value) > abs(old - value)

    def _watch(self, until: dict[str, float], before: State, after: State) -> tuple[float, bool]:
        """Fraction of the step at which the quantity passes its value (1: not in it), and whether that is located."""
        ((name, value),) = until.items()
        if name == "load_ratio" and self._peak > 0:
            old, new = before.load / self._peak, after.load / max(self._peak, after.load)
        elif name == "load_ratio":  # pushed from the beginning
            old, new = abs(before.load) / self._largest, abs(after.load) / max(self._largest, abs(after.load))
        else:
            old, new = self.record(before)[name], self.record(after)[name]
        near = 1e-3 * max(abs(value), 1e-3 * abs(old - value))
        if abs(new - value) <= near < abs(old - value) and (name != "load_ratio" or old > value):
            return 1.0, True  # from either side: a step that stops short of it is not to be followed by a tiny one
        if old == value or (old - value) * (new - value) > 0 or (name == "load_ratio" and new > value):
            return 1.0, False
        if abs(new - value) <= near:
            return 1.0, True
        return float(np.clip((value - old) / (new - old), 0.05, 0.95)), False
