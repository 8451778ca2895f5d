"""solver/snap"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..errors import NotConverged
from .newton import Equilibrium, Iterate, advance, next_state
from .problem import Problem, State

#: damped steps in which a snapping crack must come to rest
SETTLING_STEPS = 60


def snap_through(problem: Problem, start: State, control: str, target: float, reach: float) -> Equilibrium:
    """The next equilibrium where there is none close by: the crack snaps, held back by damping until it rests.

    Damped steps at the same target, each from the state of the last one, with a damping that falls as they
    converge; at last a step without any. What the snap releases is not dissipated by the law and shows in
    the energy balance.

    Raises
    ------
    NotConverged
        If the crack does not come to rest.
    """
    stiffest = float(problem.point_law.elastic().max())
    damping, iterations = stiffest, 0
    for _ in range(SETTLING_STEPS):
        try:
            trial = advance(problem, start, control, target, damping=damping, reach=reach)
        except NotConverged:
            damping *= 10.0
            if damping > 1e4 * stiffest:
                raise
            continue
        start, iterations = trial.state, iterations + trial.iterations
        damping /= 4.0
        if damping < 1e-2 * stiffest:
            try:
                trial = advance(problem, start, control, target, reach=reach)
            except NotConverged:
                continue
            return Equilibrium(trial.state, iterations + trial.iterations, trial.residuals)
    raise NotConverged("the crack snaps and does not come to rest")


def advance_to_onset(problem: Problem, start: State) -> Equilibrium:
    """The state in which, on the elastic path from `start`, the next point begins to be damaged.

    Dissipation control starts there: before it nothing dissipates, and a load beyond it may not exist.

    Raises
    ------
    NotConverged
        If the path is not linear, as in contact.
    """
    rate = problem.response(problem.point_law.update(start.cracks.deformation, start.cracks, frozen=True)[1])
    deformation_rate = problem.operator.deformation(rate)

    def is_damaged(load: float) -> bool:
        return problem.point_law.is_damaging(start.cracks.deformation + load * deformation_rate, start.cracks)

    low, high = 0.0, problem.full_strength
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
    v, load = start.v + high * rate, start.load + high
    cracks, tangent = problem.point_law.update(problem.operator.deformation(v), start.cracks)
    grown = problem.point_law.nucleate(start.cracks, cracks)
    if grown is not None:
        start = replace(start, cracks=grown)
        cracks, tangent = problem.point_law.update(problem.operator.deformation(v), grown)
    residual = problem.unbalanced(problem.bulk(v) + problem.operator.force(cracks.stress) - load * problem.drive)
    error = float(np.linalg.norm(residual)) / abs(load)
    if error > problem.tol:
        raise NotConverged(f"the way to the onset of damage is not elastic: relative residual {error:.1e}")
    now = Iterate(v, load, cracks, tangent, residual, abs(load), 0.0, np.zeros_like(v), 0.0)
    return Equilibrium(next_state(problem, start, now), 1, [error])
