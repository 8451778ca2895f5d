"""Steps that are no plain Newton steps: to the onset of damage, through a snap, and back over a snap-back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from ..arrays import Array
from ..errors import NotConverged
from .controls import Control, control_of
from .newton import Equilibrium, advance, next_state
from .problem import Guess, Problem, State
from .stages import DEFAULT_STEPS
from .steps import SMALLEST_STEP, next_size

#: damped steps in which a snapping crack must come to rest
SNAPPING_STEPS = 60

#: residual, relative to the load, up to which the way to the onset of damage counts as linear for the work
_NEARLY_ELASTIC = 1e-4

#: residual up to which that way leads dissipation control to the onset, from where Newton's method corrects it
_ALMOST_ELASTIC = 1e-2

#: parts of the load by which the onset is passed if rounding hides that a point is damaged there
_BEYOND = (1e-13, 1e-12, 1e-11, 1e-10)


def snap_through(problem: Problem, start: State, control: str, target: float, reach: float) -> Equilibrium:
    """The next equilibrium where there is none close by: the crack snaps, held back by damping until it rests.

    Damped steps at the same target, each from the state of the last one, with a damping that falls as they converge; at last
    a step without any. The work against the damping, by the trapezoidal rule over these steps, is what the snap releases.

    Raises
    ------
    NotConverged
        If the crack does not come to rest.
    """
    stiffest = float(problem.point_law.elastic().max())
    damping, iterations = stiffest, 0
    resistance = np.zeros_like(start.cracks.deformation)
    for _ in range(SNAPPING_STEPS):
        try:
            trial = advance(problem, start, control, target, damping=damping, reach=reach)
        except NotConverged:
            damping *= 10.0
            if damping > 1e4 * stiffest:
                raise
            continue
        before, resistance = resistance, damping * (trial.state.cracks.deformation - start.cracks.deformation)
        start, iterations = _released(problem, start, trial.state, before + resistance), iterations + trial.iterations
        damping /= 4.0
        if damping < 1e-2 * stiffest:
            try:
                trial = advance(problem, start, control, target, reach=reach)
            except NotConverged:
                continue
            state = _released(problem, start, trial.state, resistance)
            return Equilibrium(state, iterations + trial.iterations, trial.residuals)
    raise NotConverged("the crack snaps and does not come to rest")


def _released(problem: Problem, start: State, state: State, twice_mean: Array) -> State:
    """The state with what damping took on the way from `start`, from the sum of the damping stresses at both ends, (p, c)."""
    change = state.cracks.deformation - start.cracks.deformation
    taken = 0.5 * float(problem.operator.weights @ np.einsum("pi,pi->p", twice_mean, change))
    return replace(state, released=state.released + taken)


def advance_past_onset(problem: Problem, start: State, control: str, target: float, reversal: bool) -> Equilibrium:
    """A step of a stage: to its target, or to the onset of damage if the control begins there and nothing is damaged yet.

    If damage begins in the step, or begins again, its work is that of two parts, of which the first one ends there: the
    trapezoidal rule would run over a kink. Dissipation that is what the work leaves needs the work of the whole step.
    """
    if problem.point_law.is_on_surface(start.cracks):
        return advance(problem, start, control, target, reversal)
    if control_of(control).begins_at_onset:
        return advance_to_onset(problem, start)
    trial = advance(problem, start, control, target, reversal)
    if not problem.point_law.is_checked or trial.state.dissipated <= start.dissipated:
        return trial
    onset = onset_within(problem, start, control, target)
    if onset is None:
        return trial
    work = start.work + problem.work(start, onset) + problem.work(onset, trial.state)
    return replace(trial, state=replace(trial.state, work=work))


def onset_within(problem: Problem, start: State, control: str, target: float) -> Guess | None:
    """Where damage begins, or begins again, in a step from a state in which no point stands where it is damaged further; None
    if the way there is not elastic, or leads beyond the target."""
    try:
        onset, error = _onset(problem, start, _load_direction(problem, start, control, target))
    except NotConverged:  # damage begins on no elastic way
        return None
    at, before = (control_of(control).equation(problem, target, start, guess).gap for guess in (onset, start))
    return None if error > _NEARLY_ELASTIC or not 0.0 < at / before < 1.0 else onset


def _load_direction(problem: Problem, start: State, control: str, target: float) -> float:
    """1 if the load grows on the elastic way to a target, -1 if it falls."""
    asked = control_of(control).equation(problem, target, start, start)
    change = float(asked.row @ _elastic_rate(problem, start)) + asked.corner
    return -1.0 if asked.gap * change > 0 else 1.0


def _elastic_rate(problem: Problem, start: State) -> Array:
    """Change of the unknowns under one more newton of load while nothing is damaged further, (n,), mm/N."""
    return problem.response(problem.point_law.update(start.cracks.deformation, start.cracks, frozen=True)[1])


def _onset(problem: Problem, start: State, direction: float = 1.0, beyond: float = 0.0) -> tuple[Guess, float]:
    """Where the next point begins to be damaged as the load grows or falls (direction 1 or -1) on a linear path from `start`,
    or a part of the load beyond, and the residual there, relative to the load: zero if the path is linear."""
    rate = direction * _elastic_rate(problem, start)
    change = _load_to_onset(problem, start, problem.operator.deformation(rate))
    change += beyond * max(change, abs(start.load))
    v, load = start.v + change * rate, start.load + direction * change
    cracks, _ = problem.point_law.update(problem.operator.deformation(v), start.cracks)
    residual = problem.residual(v, problem.operator.force(cracks.stress), load)
    return Guess(v, load, cracks), float(np.linalg.norm(residual)) / max(abs(load), 1e-4 * problem.strength)


def advance_to_onset(problem: Problem, start: State) -> Equilibrium:
    """The state in which, on the elastic path from `start`, the next point begins to be damaged.

    Dissipation control starts there: before it nothing dissipates, and a load beyond it may not exist.

    Raises
    ------
    NotConverged
        If the path is not linear, as in contact.
    """
    begun, onset, error = _damaged_onset(problem, start)
    if abs(onset.load - start.load) <= 10 * _BEYOND[-1] * abs(onset.load):  # it is there, and rounding hid the damage
        for beyond in _BEYOND:
            if problem.point_law.is_on_surface(onset.cracks):
                break
            begun, onset, error = _damaged_onset(problem, start, beyond)
    if error > _ALMOST_ELASTIC:
        raise NotConverged(f"the way to the onset of damage is not elastic: relative residual {error:.1e}")
    if error > problem.tol:  # to equilibrium, so far beyond the onset that it is not missed
        driven = float(problem.motion(problem.drive, onset))
        trial = advance(problem, begun, "driven", driven * (1.0 + 2.0 * error))
        if problem.point_law.is_on_surface(trial.state.cracks):
            return trial
        raise NotConverged(f"no damage begins where it should, at the load {onset.load:.6g}")
    return Equilibrium(next_state(problem, begun, onset), 1, [error])


def _damaged_onset(problem: Problem, start: State, beyond: float = 0.0) -> tuple[State, Guess, float]:
    """The onset and its residual as of `_onset`, with the crack planes that form there; and the start with these planes."""
    onset, error = _onset(problem, start, beyond=beyond)
    nucleated = problem.point_law.nucleate(start.cracks, onset.cracks)
    if nucleated is None:
        return start, onset, error
    cracks, _ = problem.point_law.update(problem.operator.deformation(onset.v), nucleated)
    residual = problem.residual(onset.v, problem.operator.force(cracks.stress), onset.load)
    error = float(np.linalg.norm(residual)) / abs(onset.load)
    return replace(start, cracks=nucleated), replace(onset, cracks=cracks), error


def _load_to_onset(problem: Problem, start: State, rate: Array) -> float:
    """Smallest load on top of that of `start` which damages, N, by bisection; `rate` are the deformations of 1 N, (p, c)."""

    def is_damaged(load: float) -> bool:
        return problem.point_law.is_damaging(start.cracks.deformation + load * rate, start.cracks)

    low, high = 0.0, problem.strength
    for _ in range(60):
        if is_damaged(high):
            break
        high *= 2.0
    else:
        raise NotConverged("the drive does not damage the crack, so that no dissipation can be prescribed")
    for _ in range(200):
        middle = 0.5 * (low + high)
        if not low < middle < high:
            break
        low, high = (low, middle) if is_damaged(middle) else (middle, high)
    return high


@dataclass
class WayBack:
    """Steps by dissipation from where the controlled motion must go back, until it advances again.

    A crack that sets more energy free than it takes has its next equilibrium behind it. None of these steps moves
    further than a nominal one, and none behind the unloaded state.

    Attributes
    ----------
    problem : Problem
    control : of the stage, a motion
    direction : 1 if the motion grows, -1 if it falls
    target : of the stage, mm
    nominal : its nominal step, mm
    locate : what `Watch.locate` says of a step from one state to another
    start, furthest : the motion in this direction, mm: where the way began, and where it came back to
    is_reached : whether the event of the stage has come on the way
    """

    problem: Problem
    control: Control
    direction: float
    target: float
    nominal: float
    locate: Callable[[State, State], tuple[float, bool]]
    start: float = field(default=0.0, init=False)
    furthest: float = field(default=0.0, init=False)
    is_reached: bool = field(default=False, init=False)

    def follow(self, state: State) -> list[tuple[Equilibrium, int]]:
        """The steps from a committed state, each with the number of its cuts; none if they fail."""
        problem = self.problem
        size = largest = problem.energy / DEFAULT_STEPS
        self.start = self.furthest = last = self._motion(state)
        steps: list[tuple[Equilibrium, int]] = []
        cuts = 0
        if self.start <= 0 or not (state.load > 0 or problem.point_law.is_on_surface(state.cracks)):
            return steps  # unloading, or pushed: what dissipates next lies the other way
        while size > SMALLEST_STEP**2 * largest:
            fraction, self.is_reached = 1.0, False
            try:
                trial = advance_past_onset(problem, state, "dissipation", state.dissipated + size, False)
                motion = self._motion(trial.state)
                fraction, self.is_reached = self.locate(state, trial.state)
            except NotConverged:
                motion = np.inf
            strays = not 0 <= motion <= self.direction * self.target or abs(motion - last) > self.nominal
            if strays or (fraction < 1.0 and size * fraction > SMALLEST_STEP**2 * largest):
                size *= 0.5 if strays else fraction
                cuts += 1
                continue
            self.is_reached |= fraction < 1.0  # in a step that small there is no equilibrium at which to stop
            steps.append((trial, cuts))
            state, cuts = trial.state, 0
            self.furthest = min(self.furthest, motion)
            if self.is_reached or problem.is_separated(state) or self._advances(motion, last):
                return steps
            last = motion
            size = min(next_size(problem, size, trial.iterations, largest), largest)
        self.is_reached = False
        return []

    def _motion(self, state: State) -> float:
        return self.direction * self.control.value(self.problem, state)

    def _advances(self, motion: float, last: float) -> bool:
        """Whether the motion grows again, after it has gone back or beyond where it began."""
        return motion > last and (motion > self.start or self.furthest < self.start)
