"""A problem is taken through its stages, one converged step at a time."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, ClassVar

import numpy as np

from ..errors import NotConverged
from .controls import control_of
from .events import Event, Watch
from .problem import Problem, State
from .stages import Stage, event_text
from .steps import Resumable, Step
from .target_path import TargetPath

__all__ = ["LoadStepper", "Step", "solve"]

#: steps after which the factorization is dropped: a run that is resumed there has none either, and comes out the same
EVERY = 10

#: force across the drive, over the strength of the crack, from which on letting go of it is worth a note
_NOTED_FORCE = 1e-6


@dataclass
class LoadStepper(Resumable):
    """Takes a problem through its stages; see `solve`, which makes one.

    Attributes
    ----------
    problem : Problem under its dead loads, which changes with the direction of the drive
    stages : list of Stage
    record : the recorded quantities of a state, by name
    step_growth : up to which multiple of the nominal step a step may grow
    notes : what the reader of the results should know about how the stages ended
    dead : list of Step that brought the body under its dead loads, see `Problem.growing`
    """

    problem: Problem
    stages: list[Stage]
    record: Callable[[State], dict[str, float]]
    step_growth: float = 1.0
    notes: list[str] = field(default_factory=list)
    dead: Sequence[Step] = ()
    moving: ClassVar = ("notes", "_slack", "_before", "_state", "_count", "_number", "_is_apart")
    _slack: dict[str, float] = field(default_factory=dict, init=False)  # by which each control may have missed its target
    _before: State = field(init=False)
    _state: State = field(init=False)
    _watch: Watch = field(init=False)
    _count: int = field(default=0, init=False)  # of steps
    _number: int = field(default=0, init=False)  # of the stage, 0 before the first one
    _to_come: list[tuple[float, Event | None]] = field(default_factory=list, init=False)  # targets of the stage
    _path: TargetPath | None = field(default=None, init=False)
    _is_apart: bool = field(default=False, init=False)  # the body, for good

    def __post_init__(self) -> None:
        self._before = self._state = self.problem.initial()
        self._watch = Watch(self.record)

    def __iter__(self) -> Iterator[Step]:
        """The steps from where it stands."""
        while not self._is_apart and self._finds_path():
            assert self._path is not None
            for step in self._path:
                self._before, self._state = self._state, step.equilibrium.state
                self._watch.keep(self._state)
                separated = self.problem.is_separated(self._state)
                self._is_apart = separated and not self._returns(self._number, self._path.target)
                self._count += 1
                if self._count % EVERY == 0:
                    self.problem.stiffness.drop_factorization()
                yield step
                if self._is_apart:
                    break
            else:
                self._end_path(self._path)
        if self._watch.pushed > _NOTED_FORCE * self.problem.strength:
            self.notes.append(
                f"warning: no load is positive, they go down to {-self._watch.pushed:.5g} N; check the direction of the drive "
                "and the sign of the targets"
            )
        if self._is_apart:
            self.notes.append("ended early: the crack has run through, no traction is left")

    def as_data(self) -> dict[str, Any]:
        """Where it stands after a step, with what it makes."""
        path = None if self._path is None else self._path.as_data()
        problem = {"loading": self.problem.loading, "springs": self.problem.springs}
        return super().as_data() | {
            "problem": problem,
            "watch": self._watch.as_data(),
            "left": len(self._to_come),
            "path": path,
        }

    def go_on_from(self, data: Mapping[str, Any]) -> None:
        """As every `Resumable`, with the same problem and stages."""
        super().go_on_from(data)
        self.problem = replace(self.problem, **data["problem"])
        self._watch.go_on_from(data["watch"])
        targets = list(_targets(self.stages[self._number - 1]))
        self._to_come = targets[len(targets) - data["left"] :]
        if data["path"] is not None:
            self._path = self._path_to(*targets[len(targets) - data["left"] - 1])
            self._path.go_on_from(data["path"])

    def _finds_path(self) -> bool:
        """Whether there is a target to go to, begun or to begin."""
        while self._path is None and not self._to_come and self._number < len(self.stages):
            stage = self.stages[self._number]
            self._number += 1
            self._to_come = list(_targets(stage))
            if stage.redirects:
                self._before = self._state = self._redirect(self._state, self._number, stage)
        if self._path is None and self._to_come:
            self._path = self._path_to(*self._to_come.pop(0))
        return self._path is not None

    def _path_to(self, target: float, event: Event | None) -> TargetPath:
        return TargetPath(
            self.problem, self.stages[self._number - 1], self._number, target, event, self._before, self._state, self._watch,
            self._slack, self.notes, self.step_growth,
        )  # fmt: skip

    def _end_path(self, path: TargetPath) -> None:
        """After the last step towards a target, and of a stage."""
        self._path, until = None, path.stage.until
        if path.event is until and path.is_reached:
            self._to_come.clear()
        if until is not None and not self._to_come:
            reached = "ended where" if path.is_reached else "reached its last target before"
            self.notes.append(f"stage {self._number} {reached} {event_text(until)}")

    def _redirect(self, state: State, number: int, stage: Stage) -> State:
        """Do to the drives what a stage says."""
        before, forces = self.problem.loading, self.problem.driven_forces(state)
        loading = before.after(stage.drive, stage.others or {}, forces).turned(stage.angle, stage.hold)
        self.problem = replace(self.problem, loading=loading)
        self._slack.clear()  # `driven` and the load are now those of another motion
        for name in loading.names:
            if loading.drives[name].mode == "free" != before.drives[name].mode:
                self._note_drop(number, before.force(name, forces), f"of drive '{name}'")
        if loading.moved.is_free_across and not np.isfinite(self.problem.springs.rest[loading.moved.motions[0]]):
            self._let_go(state, number)
        return self.problem.with_driven_load(state)

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
        """Whether a separated crack is closed again, or slid, by what is still to come, the rest of the path included."""
        moved = self.problem.loading.moved
        if moved.is_platen and (moved.hold or self.problem.springs.stiffness[moved.motions[0]]):
            return True  # both parts are held by a platen
        stage = self.stages[number - 1]
        if control_of(stage.control).value(self.problem, self._state) > target + self._slack.get(stage.control, 0.0):
            return True
        later = stage.targets[stage.targets.index(target) + 1 :] if target in stage.targets else stage.targets
        if stage.unload is not None or any(value < target for value in later):
            return True
        return any(other.control != stage.control or min(other.targets) < target for other in self.stages[number:])


def solve(
    problem: Problem,
    stages: Sequence[Stage],
    record: Callable[[Problem, State], dict[str, float]],
    step_growth: float = 1.0,
    notes: list[str] | None = None,
) -> LoadStepper:
    """Bring a body under its dead loads, then through its stages; iterate over the steps.

    Parameters
    ----------
    problem : Problem as it is built, without loads
    record : the recorded quantities of a state, by name, counted from the body under its dead loads, which it is given
    step_growth : up to which multiple of the nominal step a step may grow
    notes : list to which the notes are added

    Returns
    -------
    LoadStepper
        Its `problem` is the one under dead loads, its `record` takes a state.

    Raises
    ------
    NotConverged
        If the body does not bear its dead loads; then, by the iteration, if a step fails.
    """
    notes = [] if notes is None else notes
    dead = _dead_steps(problem)
    if dead:
        problem = _under_dead_loads(problem, dead[-1].equilibrium.state, notes)
    problem.stiffness.drop_factorization()  # a run that is resumed does not have that of the dead loads
    return LoadStepper(problem, list(stages), partial(record, problem), step_growth, notes, dead)


def _dead_steps(problem: Problem) -> list[Step]:
    """The steps in which the dead loads grow, none without any."""
    if not problem.dead_factor:
        return []
    try:
        return list(LoadStepper(problem.growing(), [Stage("driven", problem.dead_factor, steps=1)], lambda state: {}))
    except NotConverged as error:
        raise NotConverged(f"the body does not bear its dead loads: {error}") from error


def _under_dead_loads(problem: Problem, state: State, notes: list[str]) -> Problem:
    """The body under its dead loads, from which its motions count."""
    fell = max(abs(state.unaccounted), state.released) > problem.energy  # more set free than the whole crack can take
    if fell or problem.is_separated(state):
        raise NotConverged("the body does not bear its dead loads: they break it; expected less")
    if state.released:
        notes.append(f"the crack snaps under the dead loads, which sets {state.released:.3g} N mm free")
    return replace(problem, start=replace(state, load=0.0, driven=0.0))


def _targets(stage: Stage) -> Iterator[tuple[float, Event | None]]:
    """Targets, each with the event that ends the way to it."""
    for target in stage.targets:
        yield float(target), stage.until
        if stage.unload is not None:
            yield -np.inf if target > 0 else np.inf, stage.unload
