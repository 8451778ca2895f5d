"""Newton's method on the unknowns at cracks: bordered control, line search; converged states only are committed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from .assembly import Points
from .linear import NotConverged, Stiffness
from .pointlaw import PointFailure, PointLaw

Array = NDArray[np.float64]
Index = NDArray[np.int64]

MAX_ITERATIONS = 25
#: damped steps in which a snapping crack must come to rest
SETTLING_STEPS = 60
#: the line search wants the residual to fall by this part of the step length, and gives up below that length
DECREASE, SMALLEST_LENGTH = 1e-4, 1e-3


@dataclass(frozen=True)
class State:
    """A converged state and the energies on the way to it (N mm)."""

    v: Array
    load: float
    points: Any  # of the point law
    driven: float = 0.0  # motion of the drives along their direction, mm
    work: float = 0.0
    elastic: float = 0.0
    stored: float = 0.0
    dissipated: float = 0.0
    contact_work: float = 0.0


@dataclass(frozen=True)
class Trial:
    """A converged step that may still be thrown away."""

    state: State
    iterations: int
    residuals: list[float] = field(repr=False)  # relative to the force scale, one for each iterate


@dataclass(frozen=True)
class _Iterate:
    """A guess within a step: residual (N), its scale, and the control's gap over its reach, with derivatives."""

    v: Array
    load: float
    points: Any
    tangent: Array
    residual: Array
    scale: float
    gap: float
    row: Array
    corner: float

    def merit(self, scale: float) -> float:
        """What the line search lowers."""
        return float(np.hypot(np.linalg.norm(self.residual) / scale, self.gap))


def _search(at: Callable[[Array, float], _Iterate], now: _Iterate, step: Array) -> tuple[_Iterate, float]:
    """Line search along a Newton step: the new iterate and the step length, in (0, 1], by quadratic interpolation.

    The length is 1 where none lowers the residual. At a corner of the law it may have to rise: a point that is
    about to be damaged passes from its stiffest to a falling branch, and only the tangent beyond the corner
    knows the way on. A step that leads a point to where it has no solution is shortened.
    """
    merit, size = now.merit(now.scale), 1.0
    full: _Iterate | None = None
    while True:
        value = np.inf
        try:
            new = at(now.v + size * step[:-1], now.load + size * float(step[-1]))
            value = new.merit(now.scale)
            full = new if size == 1.0 else full
        except PointFailure:
            if size < SMALLEST_LENGTH:
                raise
        if value < (1.0 - DECREASE * size) * merit:
            return new, size
        curvature = (value**2 - merit**2 * (1.0 - 2.0 * size)) / size**2
        size *= float(np.clip(merit**2 / curvature / size, 0.1, 0.5)) if np.isfinite(curvature) else 0.1
        if size < SMALLEST_LENGTH and full is not None:
            return full, 1.0


@dataclass(frozen=True)
class Problem:
    """A body with cracks in equilibrium: K v + cracks(v) = load * direction, on the drives.

    Attributes
    ----------
    law : PointLaw
    points : Points
    stiffness : Stiffness of the elastic bulk
    drives : (k,) array, numbers of the unknowns that are moved from outside
    direction : (k,) array, unit vector: they move along it, the load acts along it; across it they are held.
    area : of the crack, mm^2
    measures : linear measures of the unknowns by name ("opening", "sliding"), (n,) each
    tol : relative tolerance on residual and correction
    """

    law: PointLaw
    points: Points
    stiffness: Stiffness
    drives: Index
    direction: Array
    area: float
    measures: dict[str, Array]
    tol: float

    @property
    def full_strength(self) -> float:
        """ft times the crack area, N."""
        return self.law.concrete.ft * self.area

    def along(self, angle: float) -> Problem:
        """The same body driven at an angle (degrees) between its two drives: 0 the first, 90 the second."""
        t = np.radians(angle)
        direction = np.array([np.cos(t), np.sin(t)])
        direction[abs(direction) < 1e-15] = 0.0
        return replace(self, direction=direction)

    @cached_property
    def drive(self) -> Array:
        """Forces of a unit load, (n,); also the row that measures the driven motion."""
        unit = np.zeros(self.points.size)
        unit[self.drives] = self.direction
        return unit

    @cached_property
    def _free(self) -> sp.csr_array | None:
        """Motions that the direction of the drives allows: v = free @ y; None: all."""
        if len(self.drives) == 1:
            return None
        n = self.points.size
        others = np.setdiff1d(np.arange(n), self.drives)
        rows, columns = np.r_[others, self.drives], np.r_[np.arange(n - 2), n - 2, n - 2]
        return sp.csr_array((np.r_[np.ones(n - 2), self.direction], (rows, columns)), shape=(n, n - 1))

    def _unbalanced(self, residual: Array) -> Array:
        """The residual without the reaction that holds the drives across their direction."""
        if self._free is not None:
            residual[self.drives] = self.direction * (self.direction @ residual[self.drives])
        return residual

    @cached_property
    def _rounding(self) -> float:
        """Forces on the unknowns per unit of the largest of them, N/mm."""
        size = abs(self.points.matrix)
        force = np.einsum("pik,pij,pjl->pk", size, abs(self.law.elastic()), size) * self.points.weights[:, None]
        return self.stiffness.scale + float(np.bincount(self.points.index.ravel(), force.ravel()).max())

    def initial(self) -> State:
        """The unloaded, undamaged state."""
        return State(np.zeros(self.points.size), 0.0, self.law.initial())

    def measure(self, control: str, state: State) -> float:
        """Value of a controlled quantity."""
        if control == "load":
            return state.load
        if control == "driven":
            return float(self.drive @ state.v)
        if control == "dissipation":
            return state.dissipated
        return float(self.measures[control] @ state.v)

    def advance(
        self,
        start: State,
        control: str,
        target: float,
        reversal: bool = False,
        damping: float = 0.0,
        reach: float | None = None,
    ) -> Trial:
        """From a committed state to the next one.

        New crack planes are looked for in equilibrium only: Newton's method converges, planes that are due are
        added, undamaged, to the committed state, and the same step is brought to equilibrium again.

        Parameters
        ----------
        start : State, not changed.
        control : "opening" | "sliding" | "load" | "driven" | "dissipation"
        target : value that the controlled quantity reaches (dissipation: N mm in all).
        reversal : start from the unloading tangent, where a point has two.
        damping : stress that resists the change of the deformation, see `settle`.
        reach : scale of the controlled quantity; default: the distance to the target.

        Raises
        ------
        NotConverged
            With the iteration count, the residual and the worst point.
        """
        reach = max(abs(target - self.measure(control, start)), 1e-300) if reach is None else reach
        with np.errstate(over="ignore", invalid="ignore"):  # of an iterate that runs away, which the residual tells
            return self._advance(start, control, target, reversal, damping, reach)

    def _advance(
        self, start: State, control: str, target: float, reversal: bool, damping: float, reach: float
    ) -> Trial:
        trial = self._newton(start, start, control, target, reversal, damping, reach)
        while (grown := self.law.grow(start.points, trial.state.points)) is not None:
            start = replace(start, points=grown)
            again = self._newton(start, trial.state, control, target, False, damping, reach)
            trial = Trial(again.state, trial.iterations + again.iterations, trial.residuals + again.residuals)
        return trial

    def _newton(
        self, start: State, guess: State, control: str, target: float, reversal: bool, damping: float, reach: float
    ) -> Trial:
        """Newton's method with the crack planes that there are."""

        def at(v: Array, load: float, frozen: bool = False) -> _Iterate:
            deformation = self.points.deformation(v)
            points, tangent = self.law.update(deformation, start.points, frozen)
            stress = points.stress
            if damping:
                tangent = tangent + damping * np.eye(tangent.shape[1])
                stress = stress + damping * (deformation - start.points.deformation)
            crack = self.points.force(stress)
            residual = self._unbalanced(self.stiffness.apply(v) + crack - load * self.drive)
            scale = max(float(np.linalg.norm(crack)), abs(load), 1e-4 * self.full_strength)
            gap, row, corner = self._control(control, target, start, v, load, points)
            return _Iterate(v, load, points, tangent, residual, scale, gap / reach, row, corner)

        try:
            now = at(guess.v, guess.load, frozen=reversal)
            residuals: list[float] = []
            correction = np.inf
            for iteration in range(MAX_ITERATIONS + 1):
                error = float(np.linalg.norm(now.residual))
                residuals.append(error / now.scale)
                if not np.isfinite(error):
                    raise NotConverged(f"the residual is not finite after {iteration} iterations")
                rounding = 4 * np.finfo(float).eps * self._rounding * float(abs(now.v).max())
                # rounding excuses little: a part that flies off has a large one
                balanced = error <= max(self.tol * now.scale, min(rounding, 1e-6 * now.scale))
                if balanced and abs(now.gap) <= self.tol and correction <= self.tol:
                    return Trial(self._state(start, now), iteration, residuals)
                if iteration == MAX_ITERATIONS:
                    break
                entries = self.points.stiffness(now.tangent)
                step = self.stiffness.solve(
                    entries, self.drive, now.row, now.corner, -now.residual, -now.gap * reach, self._free
                )
                if not np.isfinite(step).all():
                    raise NotConverged("the tangent stiffness is singular")
                if iteration or abs(now.gap) <= self.tol:
                    now, size = _search(at, now, step)
                else:  # the first step moves to the target, whatever the residual says
                    now, size = at(now.v + step[:-1], now.load + float(step[-1])), 1.0
                correction = size * float(abs(step[:-1]).max()) / max(float(abs(now.v).max()), self.law.onset * 1e-3)
        except PointFailure as error:
            raise NotConverged(f"{error} at {self._place(error.point)}") from error
        change = np.linalg.norm(now.points.stress - start.points.stress, axis=1)
        worst = int(np.argmax(self.points.weights * change))
        values = ", ".join(f"{value:.3g}" for value in now.points.deformation[worst])
        raise NotConverged(
            f"no convergence in {MAX_ITERATIONS} iterations: relative residual {residuals[-1]:.1e}, "
            f"tolerance {self.tol:.0e}; the point that changed most is at {self._place(worst)}, {self.law.quantity} ({values})"
        )

    def _place(self, point: int) -> str:
        x, y = np.round(self.points.where[point], 9) + 0.0  # no -0
        return f"({x:.4g}, {y:.4g})"

    def _control(
        self, control: str, target: float, start: State, v: Array, load: float, points: Any
    ) -> tuple[float, Array, float]:
        """Gap to the target, its derivative with respect to v, and to the load."""
        if control == "load":
            return load - target, np.zeros_like(v), 1.0
        if control == "dissipation":
            increment, gradient = self.law.dissipation(start.points, points)
            total = start.dissipated + float(self.points.weights @ increment)
            return total - target, self.points.force(gradient), 0.0
        row = self.drive if control == "driven" else self.measures[control]
        return float(row @ v) - target, row, 0.0

    def _state(self, start: State, now: _Iterate) -> State:
        """The new state; every energy is integrated on its own."""
        weights, law = self.points.weights, self.law
        elastic, stored = law.energies(now.points)
        dissipated, _ = law.dissipation(start.points, now.points)
        return State(
            now.v, now.load, now.points,
            driven=float(self.drive @ now.v),
            work=start.work + 0.5 * (start.load + now.load) * float(self.drive @ (now.v - start.v)),
            elastic=0.5 * float(now.v @ self.stiffness.apply(now.v)) + float(weights @ elastic),
            stored=float(weights @ stored),
            dissipated=start.dissipated + float(weights @ dissipated),
            contact_work=start.contact_work + float(weights @ law.contact_work(start.points, now.points)),
        )  # fmt: skip

    def settle(self, start: State, control: str, target: float, reach: float) -> Trial:
        """The next equilibrium where there is none close by: the crack snaps, held back by damping until it rests.

        Damped steps at the same target, each from the state of the last one, with a damping that falls as they
        converge; at last a step without any. What the snap releases is not dissipated by the law and shows in
        the energy balance.

        Raises
        ------
        NotConverged
            If the crack does not come to rest.
        """
        stiffest = float(self.law.elastic().max())
        damping, iterations = stiffest, 0
        for _ in range(SETTLING_STEPS):
            try:
                trial = self.advance(start, control, target, damping=damping, reach=reach)
            except NotConverged:
                damping *= 10.0
                if damping > 1e4 * stiffest:
                    raise
                continue
            start, iterations = trial.state, iterations + trial.iterations
            damping /= 4.0
            if damping < 1e-2 * stiffest:
                try:
                    trial = self.advance(start, control, target, reach=reach)
                except NotConverged:
                    continue
                return Trial(trial.state, iterations + trial.iterations, trial.residuals)
        raise NotConverged("the crack snaps and does not come to rest")

    def advance_to_onset(self, start: State) -> Trial:
        """The state in which, on the elastic path from `start`, the next point begins to be damaged.

        Dissipation control starts there: before it nothing dissipates, and a load beyond it may not exist.

        Raises
        ------
        NotConverged
            If the path is not linear, as in contact.
        """
        rate = self.response(self.law.update(start.points.deformation, start.points, frozen=True)[1])
        deformation_rate = self.points.deformation(rate)

        def is_damaged(load: float) -> bool:
            return self.law.is_damaging(start.points.deformation + load * deformation_rate, start.points)

        low, high = 0.0, self.full_strength
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
        points, tangent = self.law.update(self.points.deformation(v), start.points)
        grown = self.law.grow(start.points, points)
        if grown is not None:
            start = replace(start, points=grown)
            points, tangent = self.law.update(self.points.deformation(v), grown)
        residual = self._unbalanced(self.stiffness.apply(v) + self.points.force(points.stress) - load * self.drive)
        error = float(np.linalg.norm(residual)) / abs(load)
        if error > self.tol:
            raise NotConverged(f"the way to the onset of damage is not elastic: relative residual {error:.1e}")
        now = _Iterate(v, load, points, tangent, residual, abs(load), 0.0, np.zeros_like(v), 0.0)
        return Trial(self._state(start, now), 1, [error])

    def at_rest(self, state: State) -> State:
        """The same state with the load and the motion along this direction of the drives."""
        force = self.stiffness.apply(state.v) + self.points.force(state.points.stress)
        return replace(state, load=float(self.drive @ force), driven=float(self.drive @ state.v))

    def response(self, tangent: Array) -> Array:
        """Change of the unknowns under one more newton, with tangents (p, c, c) at the points."""
        nothing = np.zeros(self.points.size)
        entries = self.points.stiffness(tangent)
        return self.stiffness.solve(entries, self.drive, nothing, 1.0, nothing, 1.0, self._free)[:-1]

    def is_held(self) -> bool:
        """Whether the elastic body has a stiffness against every motion: a known motion is found from its forces."""
        motion = np.random.default_rng(0).normal(size=self.points.size)
        if self._free is not None:
            motion = self._free @ (self._free.T @ motion)
        tangent = self.law.elastic()
        stress = np.einsum("pij,pj->pi", tangent, self.points.deformation(motion))
        force = self.stiffness.apply(motion) + self.points.force(stress)
        nothing = np.zeros_like(motion)
        try:
            entries = self.points.stiffness(tangent)
            found = self.stiffness.solve(entries, nothing, nothing, 1.0, force, 0.0, self._free)[:-1]
        except NotConverged:
            return False
        return bool(np.linalg.norm(found - motion) < 1e-3 * np.linalg.norm(motion))

    def is_separated(self, state: State) -> bool:
        """Whether nothing is left of the cracks' tractions: the body is in pieces."""
        return self.law.is_gone(state.points)
