"""Newton's method on the unknowns at cracks: bordered control, line search; converged states only are committed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..arrays import Array
from ..errors import NoContact, NotConverged, PointFailure
from .problem import Problem, State

MAX_ITERATIONS = 25

#: with the secant tangent, which converges linearly
MAX_SECANT_ITERATIONS = 1000

#: residual and correction up to which they may be rounding, over a stiffness that vanishes as a body comes apart
ROUNDING = 1e-6

#: the line search wants the residual to fall by this part of the step length, and gives up below that length
DECREASE, SMALLEST_LENGTH = 1e-4, 1e-3

#: where a point has no solution, which is costly to find out, it gives up sooner
SMALLEST_BEFORE_FAILURE = 0.05


def most_iterations(problem: Problem) -> int:
    """After which a step is given up."""
    return MAX_SECANT_ITERATIONS if problem.secant else MAX_ITERATIONS


@dataclass(frozen=True)
class Equilibrium:
    """A converged step that may still be thrown away."""

    state: State
    iterations: int
    residuals: list[float] = field(repr=False)  # relative to the force scale, one for each iterate


@dataclass(frozen=True)
class Iterate:
    """A guess within a step: residual (N), its scale, and the control's gap over its reach, with derivatives."""

    v: Array
    load: float
    cracks: Any
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

    The length is 1 where none lowers the residual. At a corner of the law it may have to rise: a point that is
    about to be damaged passes from its stiffest to a falling branch, and only the tangent beyond the corner
    knows the way on. A step that leads a point to where it has no solution is shortened.
    """
    merit, size = now.merit(now.scale), 1.0
    full: Iterate | None = None
    while True:
        value = np.inf
        try:
            new = at(now.v + size * step[:-1], now.load + size * float(step[-1]))
            value = new.merit(now.scale)
            full = new if size == 1.0 else full
        except (PointFailure, NoContact):
            if size < SMALLEST_BEFORE_FAILURE:
                raise
        if value < (1.0 - DECREASE * size) * merit:
            return new, size
        curvature = (value**2 - merit**2 * (1.0 - 2.0 * size)) / size**2
        size *= float(np.clip(merit**2 / curvature / size, 0.1, 0.5)) if np.isfinite(curvature) else 0.1
        if size < SMALLEST_LENGTH and full is not None:
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
    control : "opening" | "sliding" | "load" | "driven" | "dissipation"
    target : value that the controlled quantity reaches (dissipation: N mm in all).
    reversal : start from the unloading tangent, where a point has two.
    damping : stress that resists the change of the deformation, see `snap_through`.
    reach : scale of the controlled quantity; default: the distance to the target.

    Raises
    ------
    NotConverged
        With the iteration count, the residual and the worst point.
    """
    reach = max(abs(target - problem.measure(control, start)), 1e-300) if reach is None else reach
    with np.errstate(over="ignore", invalid="ignore"):  # of an iterate that runs away, which the residual tells
        return _advance(problem, start, control, target, reversal, damping, reach)


def _advance(
    problem: Problem, start: State, control: str, target: float, reversal: bool, damping: float, reach: float
) -> Equilibrium:
    trial = _newton(problem, start, start, control, target, reversal, damping, reach)
    while (grown := problem.point_law.nucleate(start.cracks, trial.state.cracks)) is not None:
        start = replace(start, cracks=grown)
        again = _newton(problem, start, trial.state, control, target, False, damping, reach)
        trial = Equilibrium(again.state, trial.iterations + again.iterations, trial.residuals + again.residuals)
    return trial


def _newton(
    problem: Problem, start: State, guess: State, control: str, target: float, reversal: bool, damping: float, reach: float
) -> Equilibrium:
    """Newton's method with the crack planes that there are."""

    limit = most_iterations(problem)

    def at(v: Array, load: float, frozen: bool = False) -> Iterate:
        deformation = problem.operator.deformation(v)
        cracks, tangent = problem.point_law.update(deformation, start.cracks, frozen or problem.secant)
        stress = cracks.stress
        if damping:
            tangent = tangent + damping * np.eye(tangent.shape[1])
            stress = stress + damping * (deformation - start.cracks.deformation)
        crack = problem.operator.force(stress)
        residual = problem.unbalanced(problem.bulk(v) + crack - load * problem.drive)
        scale = max(float(np.linalg.norm(crack)), abs(load), 1e-4 * problem.full_strength)
        gap, row, corner = _control(problem, control, target, start, v, load, cracks)
        return Iterate(v, load, cracks, tangent, residual, scale, gap / reach, row, corner)

    try:
        now = at(guess.v, guess.load, frozen=reversal)
        residuals: list[float] = []
        correction = np.inf
        for iteration in range(limit + 1):
            error = float(np.linalg.norm(now.residual))
            residuals.append(error / now.scale)
            if not np.isfinite(error):
                raise NotConverged(f"the residual is not finite after {iteration} iterations")
            rounding = 4 * np.finfo(float).eps * problem.rounding * float(abs(now.v).max())
            # rounding excuses little: a part that flies off has a large one
            is_rounding = error <= min(rounding, ROUNDING * now.scale)
            balanced = error <= problem.tol * now.scale or is_rounding
            settled = correction <= (max(problem.tol, ROUNDING) if is_rounding else problem.tol)
            if balanced and abs(now.gap) <= problem.tol and settled:
                return Equilibrium(next_state(problem, start, now), iteration, residuals)
            if iteration == limit:
                break
            entries = problem.entries(now.tangent)
            step = problem.stiffness.solve(
                entries, problem.drive, now.row, now.corner, -now.residual, -now.gap * reach, problem.free
            )
            if not np.isfinite(step).all():
                raise NotConverged("the tangent stiffness is singular")
            if iteration or abs(now.gap) <= problem.tol:
                now, size = _search(at, now, step)
            else:  # the first step moves to the target, whatever the residual says
                now, size = at(now.v + step[:-1], now.load + float(step[-1])), 1.0
            correction = size * float(abs(step[:-1]).max()) / max(float(abs(now.v).max()), problem.point_law.onset_jump * 1e-3)
    except PointFailure as error:
        raise NotConverged(f"{error} at {problem.describe(error.point)}") from error
    change = np.linalg.norm(now.cracks.stress - start.cracks.stress, axis=1)
    worst = int(np.argmax(problem.operator.weights * change))
    values = ", ".join(f"{value:.3g}" for value in now.cracks.deformation[worst])
    raise NotConverged(
        f"no convergence in {limit} iterations: relative residual {residuals[-1]:.1e}, correction "
        f"{correction:.1e}, tolerance {problem.tol:.0e}; the point that changed most is at {problem.describe(worst)}, "
        f"{problem.point_law.quantity} ({values})"
    )


def _control(
    problem: Problem, control: str, target: float, start: State, v: Array, load: float, cracks: Any
) -> tuple[float, Array, float]:
    """Gap to the target, its derivative with respect to v, and to the load."""
    if control == "load":
        return load - target, np.zeros_like(v), 1.0
    if control == "dissipation":
        increment, gradient = problem.point_law.dissipation(start.cracks, cracks)
        total = start.dissipated + float(problem.operator.weights @ increment)
        return total - target, problem.operator.force(gradient), 0.0
    row = problem.drive if control == "driven" else problem.measures[control]
    return float(row @ v) - target, row, 0.0


def next_state(problem: Problem, start: State, now: Iterate) -> State:
    """The new state; every energy is integrated on its own."""
    weights, law = problem.operator.weights, problem.point_law
    elastic, stored = law.energies(now.cracks)
    dissipated, _ = law.dissipation(start.cracks, now.cracks)
    return State(
        now.v, now.load, now.cracks,
        driven=float(problem.drive @ now.v),
        work=start.work + 0.5 * (start.load + now.load) * float(problem.drive @ (now.v - start.v)),
        elastic=problem.elastic_energy(now.v) + float(weights @ elastic),
        stored=float(weights @ stored),
        dissipated=start.dissipated + float(weights @ dissipated),
        contact_work=start.contact_work + float(weights @ law.contact_work(start.cracks, now.cracks)),
    )  # fmt: skip
