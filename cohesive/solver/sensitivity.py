"""Derivatives of converged steps with respect to parameters, by direct differentiation.

At a converged step K v + B'W t(B v, Z0; p) = load * drive, and the control has its value. Differentiated in a parameter,

    (K + B'W T B) v' - load' drive = -K' v - B'W (t' at constant jumps, with the Z0' of the start)
    row v' + corner load' = -(gap' at constant unknowns),

so that one factorization at the consistent tangent T serves all parameters, and each costs one more right-hand side.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from ..arrays import Array
from ..cracks.interface_points import InterfaceState
from ..cracks.interface_variation import InterfaceSteps, InterfaceVariation
from .controls import Dissipation, LinearControl, Load, control_of
from .loading import DEAD
from .newton import Equilibrium
from .problem import Guess, Problem, State
from .snap import onset_within
from .steps import Step


@dataclass(frozen=True)
class Parameter:
    """What a parameter changes.

    Attributes
    ----------
    below, above : Problem on the same unknowns, with the parameter changed both ways
    half : half the difference of the parameter between them, in its unit
    is_elastic : whether it changes the elastic bulk, a spring or the dead loads
    """

    below: Problem
    above: Problem
    half: float
    is_elastic: bool

    @property
    def dead_factor(self) -> float:
        """Derivative of the motion at which the dead loads act whole."""
        return (self.above.dead_factor - self.below.dead_factor) / (2.0 * self.half)

    @cached_property
    def variation(self) -> InterfaceVariation:
        """What it changes at the crack points."""
        return InterfaceVariation.from_laws(self.below.point_law, self.above.point_law, self.half)

    def forces(self, v: Array) -> Array:
        """Derivative of the forces of bulk and springs at constant unknowns, (n,)."""
        if not self.is_elastic:
            return np.zeros_like(v)
        return (self.above.bulk(v) - self.below.bulk(v)) / (2.0 * self.half)


def is_differentiated(control: str) -> bool:
    """Whether steps of a control, by its name, can be differentiated: a motion, the load, the dissipation."""
    return isinstance(control_of(control), (LinearControl, Load, Dissipation))


@dataclass(frozen=True)
class Sensitivity:
    """Differentiates the steps of a run from the unloaded state, with interface points and one drive.

    Attributes
    ----------
    problem : Problem under its dead loads
    steps : list of Step, all of them from the first one on
    parameters : list of Parameter
    dead : list of Step that brought the body under its dead loads: where they leave it moves with the parameters
    """

    problem: Problem
    steps: Sequence[Step]
    parameters: Sequence[Parameter]
    dead: Sequence[Step] = ()

    @cached_property
    def every(self) -> list[tuple[Problem, Step]]:
        """All steps, those of the dead loads first, each with its problem; n."""
        growing = self.problem.growing() if self.dead else self.problem
        return [*((growing, step) for step in self.dead), *((self.problem, step) for step in self.steps)]

    @cached_property
    def states(self) -> list[State]:
        """The unloaded state and those of all steps, n + 1."""
        nothing = State(np.zeros(self.problem.operator.size), 0.0, self.problem.point_law.initial())
        states = [nothing, *(step.equilibrium.state for _, step in self.every)]
        states[len(self.dead)] = self.problem.initial()
        return states

    @cached_property
    def points(self) -> InterfaceSteps:
        """The crack points in all steps."""
        return InterfaceSteps.from_states(self.problem.point_law, [s.cracks for s in self.states])

    def rates(self, energies: bool = True) -> list[list[State]]:
        """The derivatives of the state under dead loads and of those of the steps, for each parameter.

        Parameters
        ----------
        energies : whether those of the energies are there; else they are 0, but for what the control needs.
        """
        if not self.parameters:
            return []
        first = len(self.dead)
        if not energies:
            return [rates[first:] for rates in self._rates()]
        divided = self._with_onsets()
        given = {id(step) for _, step in self.every}
        kept = [0, *(i for i, (_, step) in enumerate(divided.every, start=1) if id(step) in given)]
        parts = divided._rates()
        # a dissipation that is prescribed is the sum over steps that are not divided
        whole = [[rates[i] for i in kept] for rates in parts] if self._last_prescribed < 0 else self._rates()
        complete = []
        for parameter, rates, part in zip(self.parameters, whole, parts, strict=True):
            for i, rate in zip(kept, rates, strict=True):
                part[i] = rate
            work = divided._work(parameter, part)
            complete.append(self._with_energies(parameter, rates, [work[i] for i in kept])[first:])
        return complete

    def _with_onsets(self) -> Sensitivity:
        """The steps, each in which damage begins in two parts, as its work is that of both."""
        law = self.problem.point_law
        parts: tuple[list[Step], list[Step]] = ([], [])
        for i, (start, (problem, step)) in enumerate(zip(self.states[:-1], self.every, strict=True)):
            steps, now = parts[i >= len(self.dead)], step.equilibrium.state
            begins = now.dissipated > start.dissipated and not law.is_on_surface(start.cracks)
            if begins and not control_of(step.control).begins_at_onset:
                onset = onset_within(problem, start, step.control, step.value)
                if onset is not None:
                    state = State(onset.v, onset.load, onset.cracks)
                    steps.append(Step(Equilibrium(state, 0, []), 0, "dissipation", start.dissipated, step.stage))
            steps.append(step)
        return replace(self, dead=parts[0], steps=parts[1])

    def _rates(self) -> list[list[State]]:
        """The derivatives of the unloaded state and of all others, but for those of the energies, for each parameter."""
        size = self.problem.operator.size
        count, p = len(self.parameters), len(self.problem.operator.weights)
        explicit = [self.points.at_fixed_jumps(each.variation) for each in self.parameters]
        stress = np.array([part[0] for part in explicit]).reshape(count, self.points.count, p, -1)
        history = np.array([part[1] for part in explicit]).reshape(count, self.points.count, p)
        last = _Rates(np.zeros((count, size)), np.zeros(count), np.zeros_like(stress[:, 0]), np.zeros_like(stress[:, 0]),
                      np.zeros((count, p)), np.zeros(count))  # fmt: skip
        last.Z += np.array([[each.variation.onset_jump] for each in self.parameters])
        rates, start = [last], last
        for i in range(len(self.every)):
            rates.append(self._follow(i, rates[-1], start, stress[:, i], history[:, i]))
            if i + 1 == len(self.dead):
                rates[-1] = start = replace(rates[-1], load=np.zeros(count))  # of the drives there is none yet
        return [self._states(j, rates, start) for j in range(count)]

    @cached_property
    def _last_prescribed(self) -> int:
        """Index of the last step whose dissipation is prescribed, which needs that before it; -1: there is none."""
        prescribed = [i for i, (_, step) in enumerate(self.every) if isinstance(control_of(step.control), Dissipation)]
        return max(prescribed, default=-1)

    def _follow(self, i: int, last: _Rates, start: _Rates, stress: Array, history: Array) -> _Rates:
        """The derivatives after a step, from those before it, from those of the state under dead loads, and from what the
        parameters change at fixed jumps, (m, p, d) and (m, p)."""
        (problem, step), points, now = self.every[i], self.points, self.states[i + 1]
        p = len(problem.operator.weights)
        here = slice(i * p, (i + 1) * p)
        carried = np.where(points.kept[here], last.Z, 0.0)
        stress = stress + points.stress_Z[here] * carried[:, :, None]
        row, corner, gaps = self._control(i, last, start)
        border = problem.border(points.tangent[here], row, corner)
        solve = problem.stiffness.factored(border)  # type: ignore[attr-defined]
        fixed = problem.fixed_part(last.v)
        right = np.empty((problem.operator.size + 1, len(gaps)), order="F")
        for j, parameter in enumerate(self.parameters):
            right[:-1, j] = -parameter.forces(now.v) - problem.operator.force(stress[j])
        right[-1] = -gaps
        if fixed.any():
            right[:-1] -= np.stack([problem.stiffness.apply(each) for each in fixed], axis=1)
            right[-1] -= fixed @ row
        x = solve(right)
        v = np.ascontiguousarray(x[:-1].T) + fixed
        motion = np.einsum("pik,mpk->mpi", problem.operator.matrix, v[:, problem.operator.index])
        moved = np.where(points.loading[here], np.einsum("pi,mpi->mp", points.slope[here], motion), 0.0)
        stress = stress + np.einsum("pij,mpj->mpi", points.tangent[here], motion)
        dissipated = last.dissipated
        if isinstance(control_of(step.control), Dissipation):
            dissipated = np.zeros_like(dissipated)  # what the control prescribes does not change
        elif i < self._last_prescribed:
            dissipated = dissipated + self._dissipation(i, last, motion)
        return _Rates(v, x[-1], motion, stress, history + carried + moved, dissipated)

    def _control(self, i: int, last: _Rates, origin: _Rates) -> tuple[Array, float, Array]:
        """Row and corner of the equation that holds while the parameters change, and derivatives of its gap (m,) at constant
        unknowns."""
        (problem, step), start, now = self.every[i], self.states[i], self.states[i + 1]
        control = control_of(step.control)
        if control.begins_at_onset and not problem.point_law.is_on_surface(start.cracks):
            return self._onset(i, last)
        asked = control.equation(problem, step.value, start, Guess(now.v, now.load, now.cracks))
        gaps = np.zeros(len(self.parameters))
        if isinstance(control, Dissipation):
            gaps = last.dissipated + self._dissipation(i, last, np.zeros_like(last.jump))
        elif i < len(self.dead):
            gaps = np.array([-step.value / self.problem.dead_factor * each.dead_factor for each in self.parameters])
        elif self.dead and isinstance(control, LinearControl):  # motions count from the body under its dead loads
            gaps = -origin.v @ asked.row
        return asked.row, asked.corner, gaps

    def _onset(self, i: int, last: _Rates) -> tuple[Array, float, Array]:
        """A step that ended where the next point begins to be damaged further: Zeq is its history there."""
        operator, variations = self.every[i][0].operator, [each.variation for each in self.parameters]
        gradient, gaps = self.points.onset(i, variations, last.Z, operator.weights)
        return operator.force(gradient), 0.0, gaps

    def _dissipation(self, i: int, last: _Rates, motion: Array) -> Array:
        """Derivatives of the dissipation of a step, (m,), whose jumps have the derivatives `motion`, (m, p, d)."""
        one = self.points.one(i)
        changes = [one.dissipation(each.variation, last.points(j), motion[j]) for j, each in enumerate(self.parameters)]
        return np.array(changes) @ self.problem.operator.weights

    def _states(self, j: int, rates: Sequence[_Rates], start: _Rates) -> list[State]:
        """The derivatives in one parameter."""
        drive = self.problem.drive
        return [
            State(
                each.v[j], float(each.load[j]), each.points(j), float(drive @ (each.v[j] - start.v[j])),
                dissipated=float(each.dissipated[j]),
            )
            for each in rates
        ]  # fmt: skip

    def _work(self, parameter: Parameter, rates: Sequence[State]) -> list[float]:
        """Derivatives of the work up to each state, see `Problem.work`."""
        total = [0.0]
        for (problem, _), (start, now), (old, new) in zip(self.every, pairwise(self.states), pairwise(rates), strict=True):
            change = 0.0
            if problem.loading.active != DEAD:
                change = 0.5 * (old.load + new.load) * float(problem.drive @ (now.v - start.v))
                change += 0.5 * (start.load + now.load) * float(problem.drive @ (new.v - old.v))
            if (at := problem.dead_motion) is not None:
                force = [float(problem.stiffness.apply(state.v)[at]) for state in (start, now)]
                rate = [self._dead_force(parameter, *each) for each in ((start, old), (now, new))]
                change -= 0.5 * float(old.v[at] + new.v[at]) * (force[1] - force[0])
                change -= 0.5 * float(start.v[at] + now.v[at]) * (rate[1] - rate[0])
            total.append(total[-1] + change)
        return total

    def _dead_force(self, parameter: Parameter, now: State, rate: State) -> float:
        """Derivative of the force on the motion that stands for the dead loads."""
        at = self.problem.dead_motion
        return float(self.problem.stiffness.apply(rate.v)[at] + parameter.forces(now.v)[at])

    def _with_energies(self, parameter: Parameter, rates: Sequence[State], work: Sequence[float]) -> list[State]:
        """The derivatives with those of the energies, which `newton.next_state` adds up."""
        problem, states, weights = self.problem, self.states, self.problem.operator.weights
        started = InterfaceState(*(np.concatenate([getattr(rate.cracks, name) for rate in rates[:-1]])
                                   for name in ("deformation", "stress", "history")))  # fmt: skip
        motion = np.concatenate([rate.cracks.deformation for rate in rates[1:]])
        variation, points = parameter.variation, self.points
        stored, dissipated, contact = (
            part(variation, started, motion).reshape(points.count, -1) @ weights
            for part in (points.stored, points.dissipation, points.contact_work)
        )
        dissipated, contact = np.cumsum(dissipated), np.cumsum(contact)
        complete = [rates[0]]
        for i, new in enumerate(rates[1:]):
            now = states[i + 1]
            elastic = float(problem.bulk(now.v) @ new.v + 0.5 * parameter.forces(now.v) @ now.v)
            if (at := problem.dead_motion) is not None:  # without the potential of the dead loads
                force = float(problem.stiffness.apply(now.v)[at])
                elastic -= float(new.v[at] * force + now.v[at] * self._dead_force(parameter, now, new))
            energy = (work[i + 1], elastic, float(stored[i]), float(dissipated[i]), float(contact[i]))
            complete.append(State(new.v, new.load, new.cracks, new.driven, *energy))
        return complete


@dataclass
class _Rates:
    """Derivatives of one state in m parameters: unknowns (m, n), load (m,), jumps and tractions (m, p, d), histories (m, p),
    dissipation (m,)."""

    v: Array
    load: Array
    jump: Array
    stress: Array
    Z: Array
    dissipated: Array

    def points(self, j: int) -> InterfaceState:
        """Those of the crack points in one parameter."""
        return InterfaceState(self.jump[j], self.stress[j], self.Z[j])


def moved(state: State, rate: State, by: float) -> State:
    """A state moved along its derivative, for what is recorded of it."""
    points, along = state.cracks, rate.cracks
    cracks = InterfaceState(
        points.deformation + by * along.deformation, points.stress + by * along.stress, points.history + by * along.history
    )
    numbers = ("driven", "work", "elastic", "stored", "dissipated", "contact_work")
    changed = {name: getattr(state, name) + by * getattr(rate, name) for name in numbers}
    return State(state.v + by * rate.v, state.load + by * rate.load, cracks, **changed)
