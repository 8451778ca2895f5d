"""Newton's method on the crack's unknowns: bordered control, line search; converged states only are committed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from .assembly import CrackPoints
from .crackplane import CrackPlane
from .linear import NotConverged, Stiffness

Array = NDArray[np.float64]

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
    jump: Array
    traction: Array
    contact: Array  # the part of the traction that contact carries
    Z: Array
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
    jump: Array
    traction: Array
    tangent: Array
    Z: Array
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
    knows the way on.
    """
    merit, size = now.merit(now.scale), 1.0
    full = at(now.v + step[:-1], now.load + float(step[-1]))
    new = full
    while True:
        value = new.merit(now.scale)
        if value < (1.0 - DECREASE * size) * merit:
            return new, size
        curvature = (value**2 - merit**2 * (1.0 - 2.0 * size)) / size**2
        size *= float(np.clip(merit**2 / curvature / size, 0.1, 0.5)) if np.isfinite(curvature) else 0.1
        if size < SMALLEST_LENGTH:
            return full, 1.0
        new = at(now.v + size * step[:-1], now.load + size * float(step[-1]))


@dataclass(frozen=True)
class Problem:
    """A body with cracks in equilibrium: K v + crack(v) = load * drive.

    Attributes
    ----------
    law : CrackPlane
    points : CrackPoints
    stiffness : Stiffness of the elastic bulk
    drive : number of the unknown that the load acts on
    measures : linear measures of the unknowns by name ("opening", "sliding"), (n,) each
    tol : relative tolerance on residual and correction
    """

    law: CrackPlane
    points: CrackPoints
    stiffness: Stiffness
    drive: int
    measures: dict[str, Array]
    tol: float

    @property
    def full_strength(self) -> float:
        """ft times the crack area, N."""
        return self.law.concrete.ft * float(self.points.weights.sum())

    def initial(self) -> State:
        """The unloaded, undamaged state."""
        p = len(self.points.weights)
        zeros = np.zeros((p, 2))
        return State(np.zeros(self.points.size), 0.0, zeros, zeros, zeros, np.full(p, self.law.Zt))

    def measure(self, control: str, state: State) -> float:
        """Value of a controlled quantity."""
        if control == "load":
            return state.load
        if control == "driven":
            return float(state.v[self.drive])
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
        """Newton's method from a committed state to the next one.

        Parameters
        ----------
        start : State, not changed.
        control : "opening" | "sliding" | "load" | "driven" | "dissipation"
        target : value that the controlled quantity reaches (dissipation: N mm in all).
        reversal : start from the unloading tangent, where a point has two.
        damping : traction that resists the change of the jumps, MPa/mm, see `settle`.
        reach : scale of the controlled quantity; default: the distance to the target.

        Raises
        ------
        NotConverged
            With the iteration count, the residual and the worst point.
        """
        drive = np.zeros_like(start.v)
        drive[self.drive] = 1.0
        reach = max(abs(target - self.measure(control, start)), 1e-300) if reach is None else reach

        def at(v: Array, load: float, frozen: bool = False) -> _Iterate:
            jump = self.points.jump(v)
            traction, tangent, Z = self.law.update(jump, start.Z, frozen)
            if damping:
                tangent = tangent + damping * np.eye(2)
            crack = self.points.force(traction + damping * (jump - start.jump))
            residual = self.stiffness.apply(v) + crack - load * drive
            scale = max(float(np.linalg.norm(crack)), abs(load), 1e-4 * self.full_strength)
            gap, row, corner = self._control(control, target, start, v, load, jump, Z)
            return _Iterate(v, load, jump, traction, tangent, Z, residual, scale, gap / reach, row, corner)

        now = at(start.v, start.load, frozen=reversal)
        residuals: list[float] = []
        correction = np.inf
        for iteration in range(MAX_ITERATIONS + 1):
            error = float(np.linalg.norm(now.residual))
            residuals.append(error / now.scale)
            if not np.isfinite(error):
                raise NotConverged(f"the residual is not finite after {iteration} iterations")
            rounding = 4 * np.finfo(float).eps * self.stiffness.scale * float(abs(now.v).max())
            balanced = error <= max(self.tol * now.scale, rounding)
            if balanced and abs(now.gap) <= self.tol and correction <= self.tol:
                return Trial(self._state(start, now), iteration, residuals)
            if iteration == MAX_ITERATIONS:
                break
            entries = self.points.stiffness(now.tangent)
            step = self.stiffness.solve(entries, drive, now.row, now.corner, -now.residual, -now.gap * reach)
            if not np.isfinite(step).all():
                raise NotConverged("the tangent stiffness is singular")
            # the first step moves to the target, whatever the residual says
            now, size = _search(at, now, step) if iteration else (at(now.v + step[:-1], now.load + step[-1]), 1.0)
            correction = size * float(abs(step[:-1]).max()) / max(float(abs(now.v).max()), self.law.Zt * 1e-3)
        worst = int(np.argmax(abs(self.points.weights * np.linalg.norm(now.traction - start.traction, axis=1))))
        x, y = self.points.where[worst]
        raise NotConverged(
            f"no convergence in {MAX_ITERATIONS} iterations: relative residual {residuals[-1]:.1e}, "
            f"tolerance {self.tol:.0e}; the point that changed most is "
            f"at ({x:.4g}, {y:.4g}), jump ({now.jump[worst, 0]:.3g}, {now.jump[worst, 1]:.3g}) mm"
        )

    def _control(
        self, control: str, target: float, start: State, v: Array, load: float, jump: Array, Z: Array
    ) -> tuple[float, Array, float]:
        """Gap to the target, its derivative with respect to v, and to the load."""
        if control == "load":
            return load - target, np.zeros_like(v), 1.0
        if control == "driven":
            row = np.zeros_like(v)
            row[self.drive] = 1.0
            return float(v[self.drive]) - target, row, 0.0
        if control == "dissipation":
            increment, gradient = self.law.dissipation(start.jump, start.Z, jump, Z)
            total = start.dissipated + float(self.points.weights @ increment)
            return total - target, self.points.force(gradient), 0.0
        row = self.measures[control]
        return float(row @ v) - target, row, 0.0

    def _state(self, start: State, now: _Iterate) -> State:
        """The new state; every energy is integrated on its own."""
        weights, law = self.points.weights, self.law
        dissipated, _ = law.dissipation(start.jump, start.Z, now.jump, now.Z)
        contact = law.contact_traction(now.jump, now.Z)
        contact_work = np.einsum("ij,ij->i", start.contact + contact, now.jump - start.jump)
        return State(
            now.v, now.load, now.jump, now.traction, contact, now.Z,
            work=start.work + 0.5 * (start.load + now.load) * float(now.v[self.drive] - start.v[self.drive]),
            elastic=0.5 * float(now.v @ self.stiffness.apply(now.v)),
            stored=float(weights @ law.stored_energy(now.jump, now.Z)),
            dissipated=start.dissipated + float(weights @ dissipated),
            contact_work=start.contact_work + 0.5 * float(weights @ contact_work),
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
        stiffest = float(self.law.stiffness(2)[0])
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
        rate = self.response(self.law.update(start.jump, start.Z, frozen=True)[1])
        jump_rate = self.points.jump(rate)

        def is_damaged(load: float) -> bool:
            _, Z = self.law.traction(start.jump + load * jump_rate, start.Z)
            return bool((Z > start.Z).any())

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
        jump = self.points.jump(v)
        traction, tangent, Z = self.law.update(jump, start.Z)
        residual = self.stiffness.apply(v) + self.points.force(traction)
        residual[self.drive] -= load
        error = float(np.linalg.norm(residual)) / abs(load)
        if error > self.tol:
            raise NotConverged(f"the way to the onset of damage is not elastic: relative residual {error:.1e}")
        now = _Iterate(v, load, jump, traction, tangent, Z, residual, abs(load), 0.0, np.zeros_like(v), 0.0)
        return Trial(self._state(start, now), 1, [error])

    def elastic_tangent(self) -> Array:
        """Tangents of the undamaged crack points, (p, 2, 2), MPa/mm."""
        return np.broadcast_to(np.diag(self.law.stiffness(2)), (len(self.points.weights), 2, 2))

    def response(self, tangent: Array) -> Array:
        """Change of the unknowns under one more newton, with tangents (p, 2, 2) at the crack points."""
        nothing = np.zeros(self.points.size)
        unit = nothing.copy()
        unit[self.drive] = 1.0
        return self.stiffness.solve(self.points.stiffness(tangent), unit, nothing, 1.0, nothing, 1.0)[:-1]

    def is_held(self) -> bool:
        """Whether the elastic body has a stiffness against every motion: a known motion is found from its forces."""
        motion = np.random.default_rng(0).normal(size=self.points.size)
        tangent = self.elastic_tangent()
        force = self.stiffness.apply(motion) + self.points.force(np.einsum("pij,pj->pi", tangent, self.points.jump(motion)))
        nothing = np.zeros_like(motion)
        try:
            found = self.stiffness.solve(self.points.stiffness(tangent), nothing, nothing, 1.0, force, 0.0)[:-1]
        except NotConverged:
            return False
        return bool(np.linalg.norm(found - motion) < 1e-3 * np.linalg.norm(motion))

    def is_separated(self, state: State) -> bool:
        """Whether nothing is left of the crack's traction: the body is in pieces."""
        # beyond 3.5 Zm the softening branch is below 1e-7 ft: the traction cannot come back by opening
        gone = abs(state.traction).max() < 1e-8 * self.law.concrete.ft
        return bool(gone) and bool(state.Z.min() > 3.5 * self.law.concrete.Zm)
