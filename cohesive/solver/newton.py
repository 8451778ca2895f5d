"""Newton's method for one step: a bordered system, a line search; converged states only are committed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from ..algebra.bordered import INEXACT
from ..arrays import Array
from ..errors import NoContact, NotConverged, PointFailure
from .controls import Control, control_of
from .problem import Guess, Problem, State

#: iterations after which a step is given up
MAX_ITERATIONS = 25

#: the same with the secant tangent, which converges linearly
MAX_SECANT_ITERATIONS = 1000

#: residual and correction up to which they may be rounding, over a stiffness that vanishes as a body comes apart
ROUNDING = 1e-6

#: correction of a motion that no force resists, if the residual has been rounding twice running
_FREE = 1e-3

#: residual that a step may leave, relative to its forces: this part of the error before it, and at most; what Newton's method
#: leaves by itself is a larger part
_FORCING, _MOST_FORCING = 1e-2, 1e-4

#: the line search wants the residual to fall by this part of the step length, and gives up below that length
DECREASE, SMALLEST_LENGTH = 1e-4, 1e-3

#: it gives up sooner if a point has no solution, which is costly to find out
SMALLEST_BEFORE_FAILURE = 0.05


def most_iterations(problem: Problem) -> int:
    """Iterations after which a step is given up."""
    return MAX_SECANT_ITERATIONS if problem.secant else MAX_ITERATIONS


@dataclass(frozen=True)
class Equilibrium:
    """A converged step that may still be thrown away.

    Attributes
    ----------
    residuals : of every iterate, relative to its scale of forces
    """

    state: State
    iterations: int
    residuals: list[float] = field(repr=False)


@dataclass(frozen=True)
class Iterate(Guess):
    """A guess within a step and what it leaves unbalanced.

    Attributes
    ----------
    tangent : (p, c, c) array, of the points
    residual : (n,) array, N
    scale : of the residual, N
    gap : of the control, over its reach
    row, corner : derivatives of the control's gap in the unknowns and in the load
    """

    tangent: Array
    residual: Array
    scale: float
    gap: float
    row: Array
    corner: float

    def merit(self, scale: float) -> float:
        """What the line search lowers."""
        return float(np.hypot(np.linalg.norm(self.residual) / scale, self.gap))


def _search(at: Callable[[Array, float], Iterate], now: Iterate, step: Array) -> tuple[Iterate, float]:
    """Line search along a Newton step: the new iterate and the step length, in (0, 1], by quadratic interpolation.

    The length is 1 if none lowers the residual. At a corner of the law it may have to rise: a point that is
    about to be damaged passes from its stiffest to a falling branch, and only the tangent beyond the corner
    knows the way on. A step in which a point has no solution is shortened; if no shorter one lowers the residual either, it
    fails for that point.
    """
    merit, size = now.merit(now.scale), 1.0
    full: Iterate | None = None
    failure: PointFailure | NoContact | None = None
    while True:
        value = np.inf
        try:
            new = at(now.v + size * step[:-1], now.load + size * float(step[-1]))
            value = new.merit(now.scale)
            full = new if size == 1.0 else full
        except (PointFailure, NoContact) as error:
            if size < SMALLEST_BEFORE_FAILURE:
                raise
            failure = error
        if value < (1.0 - DECREASE * size) * merit:
            return new, size
        curvature = (value**2 - merit**2 * (1.0 - 2.0 * size)) / size**2
        size *= float(np.clip(merit**2 / curvature / size, 0.1, 0.5)) if curvature > 0 else 0.1  # else no number
        if size < SMALLEST_LENGTH:
            if full is None:
                assert failure is not None
                raise failure
            return full, 1.0


def advance(
    problem: Problem,
    start: State,
    control: str,
    target: float,
    reversal: bool = False,
    damping: float = 0.0,
    reach: float | None = None,
) -> Equilibrium:
    """From a committed state to the next one.

    New crack planes are looked for in equilibrium only: Newton's method converges, planes that are due are
    added, undamaged, to the committed state, and the same step is brought to equilibrium again.

    Parameters
    ----------
    start : State, not changed.
    control : name of a control, as a stage gives it.
    target : value that the controlled quantity reaches.
    reversal : start from the unloading tangent if a point has two.
    damping : stress that resists the change of the deformation, see `snap_through`.
    reach : scale of the controlled quantity; default: the distance to the target.

    Raises
    ------
    NotConverged
        With the iteration count, the residual and the worst point.
    """
    asked = control_of(control)
    reach = max(abs(target - asked.value(problem, start)), 1e-300) if reach is None else reach
    with np.errstate(over="ignore", invalid="ignore"):  # of an iterate that runs away, which the residual tells
        trial = _newton(_Equations(problem, start, asked, target, damping, reach), start, reversal)
        while (nucleated := problem.point_law.nucleate(start.cracks, trial.state.cracks)) is not None:
            start = replace(start, cracks=nucleated)
            again = _newton(_Equations(problem, start, asked, target, damping, reach), trial.state, False)
            trial = Equilibrium(again.state, trial.iterations + again.iterations, trial.residuals + again.residuals)
    return trial


@dataclass(frozen=True)
class _Equations:
    """The equations of one step, with the crack planes that there are."""

    problem: Problem
    start: State
    control: Control
    target: float
    damping: float
    reach: float

    def at(self, v: Array, load: float, frozen: bool = False) -> Iterate:
        """The iterate with these unknowns and this load; with `frozen` by the unloading tangent."""
        problem, start = self.problem, self.start
        deformation = problem.operator.deformation(v)
        cracks, tangent = problem.point_law.update(deformation, start.cracks, frozen or problem.secant)
        stress = cracks.stress
        if self.damping:
            tangent = tangent + self.damping * np.eye(tangent.shape[1])
            stress = stress + self.damping * (deformation - start.cracks.deformation)
        crack = problem.operator.force(stress)
        residual = problem.residual(v, crack, load)
        scale = max(float(np.linalg.norm(crack)), abs(load), 1e-4 * problem.strength)
        asked = self.control.equation(problem, self.target, start, Guess(v, load, cracks))
        return Iterate(v, load, cracks, tangent, residual, scale, asked.gap / self.reach, asked.row, asked.corner)

    def correction(self, now: Iterate) -> Array:
        """Newton's step from an iterate: changes of the unknowns and of the load, (n + 1,)."""
        problem = self.problem
        border, missed = problem.border(now.tangent, now.row, now.corner), -now.gap * self.reach
        forcing = min(max(_FORCING * now.merit(now.scale), INEXACT), _MOST_FORCING)
        step = problem.stiffness.solve(border, -now.residual, missed, forcing)
        if not np.isfinite(step).all():
            raise NotConverged("the tangent stiffness is singular")
        return step

    def is_rounding(self, now: Iterate, error: float) -> bool:
        """Whether the residual may be rounding. That excuses little: a part that flies off has a large one."""
        rounding = 4 * np.finfo(float).eps * self.problem.rounding * float(abs(now.v).max())
        return error <= min(rounding, ROUNDING * now.scale)

    def is_converged(self, now: Iterate, error: float, correction: float, excused: float) -> bool:
        """Whether residual, gap and the last correction are all within the tolerance, or the residual is rounding and the
        correction below what that excuses."""
        tol = self.problem.tol
        balanced = error <= tol * now.scale or excused > 0
        return balanced and abs(now.gap) <= tol and correction <= max(tol, excused)


def _newton(step: _Equations, guess: State, reversal: bool) -> Equilibrium:
    """Newton's method from a guess."""
    problem, limit = step.problem, most_iterations(step.problem)
    residuals: list[float] = []
    correction, rounded = np.inf, 0
    try:
        now = step.at(guess.v, guess.load, frozen=reversal)
        for iteration in range(limit + 1):
            error = float(np.linalg.norm(now.residual))
            residuals.append(error / now.scale)
            if not np.isfinite(error):
                raise NotConverged(f"the residual is not finite after {iteration} iterations")
            rounded = rounded + 1 if step.is_rounding(now, error) else 0
            if step.is_converged(now, error, correction, (0.0, ROUNDING, _FREE)[min(rounded, 2)]):
                return Equilibrium(next_state(problem, step.start, now), iteration, residuals)
            if iteration == limit:
                break
            change = step.correction(now)
            if iteration or abs(now.gap) <= problem.tol:
                now, size = _search(step.at, now, change)
            else:  # the first step moves to the target, whatever the residual says
                now, size = step.at(now.v + change[:-1], now.load + float(change[-1])), 1.0
            largest = max(float(abs(now.v).max()), problem.point_law.onset_jump * 1e-3)
            correction = size * float(abs(change[:-1]).max()) / largest
    except PointFailure as error:
        raise NotConverged(f"{error} at {problem.describe(error.point)}") from error
    raise NotConverged(_failure(problem, step.start, now, residuals[-1], correction))


def _failure(problem: Problem, start: State, now: Iterate, residual: float, correction: float) -> str:
    """What to say of an iteration that takes too long."""
    change = np.linalg.norm(now.cracks.stress - start.cracks.stress, axis=1)
    worst = int(np.argmax(problem.operator.weights * change))
    values = ", ".join(f"{value:.3g}" for value in now.cracks.deformation[worst])
    return (
        f"no convergence in {most_iterations(problem)} iterations: relative residual {residual:.1e}, correction "
        f"{correction:.1e}, tolerance {problem.tol:.0e}; the point that changed most is at {problem.describe(worst)}, "
        f"{problem.point_law.quantity} ({values})"
    )


def next_state(problem: Problem, start: State, now: Guess) -> State:
    """The new state; every energy is integrated on its own."""
    weights, law = problem.operator.weights, problem.point_law
    elastic, stored = law.energies(now.cracks)
    dissipated, _ = law.dissipation(start.cracks, now.cracks)
    return State(
        now.v, now.load, now.cracks,
        driven=problem.motion(problem.drive, now),
        work=start.work + problem.work(start, now),
        elastic=problem.elastic_energy(now.v) + float(weights @ elastic),
        stored=float(weights @ stored),
        dissipated=start.dissipated + float(weights @ dissipated),
        contact_work=start.contact_work + float(weights @ law.contact_work(start.cracks, now.cracks)),
        released=start.released,
    )  # fmt: skip
