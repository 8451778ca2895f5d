"""Derivatives of converged steps with respect to parameters, by direct differentiation.

At a converged step K v + B'W t(B v, Z0; p) = load * drive, and the control has its value. Differentiated in a parameter,

    (K + B'W T B) v' - load' drive = -K' v - B'W (t' at constant jumps, with the Z0' of the start)
    row v' + corner load' = -(gap' at constant unknowns),

so that one factorization at the consistent tangent T serves all parameters, and each costs one more right-hand side.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from ..arrays import Array
from ..cracks.interface_points import InterfaceState
from ..cracks.interface_variation import InterfaceSteps, InterfaceVariation
from .controls import Dissipation, LinearControl, Load, control_of
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
    is_elastic : whether it changes the elastic bulk or a spring
    """

    below: Problem
    above: Problem
    half: float
    is_elastic: bool

    @cached_property
    def variation(self) -> InterfaceVariation:
        """What it changes at the crack points."""
        return InterfaceVariation(self.below.point_law, self.above.point_law, self.half)  # type: ignore[arg-type]

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
    """Differentiates the steps of a run from the unloaded state, with interface points, one drive, and no dead loads.

    Attributes
    ----------
    problem : Problem
    steps : list of Step, all of them from the first one on
    parameters : list of Parameter
    """

    problem: Problem
    steps: Sequence[Step]
    parameters: Sequence[Parameter]

    @cached_property
    def states(self) -> list[State]:
        """The unloaded state and those of the steps, n + 1."""
        return [self.problem.initial(), *(step.equilibrium.state for step in self.steps)]

    @cached_property
    def points(self) -> InterfaceSteps:
        """The crack points in all steps."""
        return InterfaceSteps.between(self.problem.point_law, [s.cracks for s in self.states])  # type: ignore[arg-type]

    def rates(self, energies: bool = True) -> list[list[State]]:
        """The derivatives of the states of the steps, n states of derivatives for each parameter.

        Parameters
        ----------
        energies : whether those of the energies are there; else they are 0, but for what the control needs.
        """
        if not self.parameters:
            return []
        if not energies:
            return [rates[1:] for rates in self._rates()]
        whole = self._with_onsets()
        divided = Sensitivity(self.problem, whole, self.parameters) if len(whole) > len(self.steps) else self
        given = {id(step) for step in self.steps}
        kept = [0, *(i for i, step in enumerate(whole, start=1) if id(step) in given)]
        found = []
        for parameter, rates in zip(self.parameters, divided._rates(), strict=True):
            work = divided._work(rates)
            found.append(self._with_energies(parameter, [rates[i] for i in kept], [work[i] for i in kept]))
        return found

    def _with_onsets(self) -> list[Step]:
        """The steps, each in which damage begins in two parts, as its work is that of both."""
        law, found = self.problem.point_law, []
        for start, step in zip(self.states[:-1], self.steps, strict=True):
            now = step.equilibrium.state
            begins = now.dissipated > start.dissipated and not law.is_on_surface(start.cracks)
            if begins and not control_of(step.control).begins_at_onset:
                onset = onset_within(self.problem, start, step.control, step.value)
                if onset is not None:
                    state = State(onset.v, onset.load, onset.cracks)
                    found.append(Step(Equilibrium(state, 0, []), 0, "dissipation", start.dissipated, step.stage))
            found.append(step)
        return found

    def _rates(self) -> list[list[State]]:
        """The derivatives of the unloaded state and of all others, but for those of the energies, for each parameter."""
        size = self.problem.operator.size
        count, p = len(self.parameters), len(self.problem.operator.weights)
        explicit = [self.points.at_rest(each.variation) for each in self.parameters]
        stress = np.array([part[0] for part in explicit]).reshape(count, self.points.count, p, -1)
        history = np.array([part[1] for part in explicit]).reshape(count, self.points.count, p)
        last = _Rates(np.zeros((count, size)), np.zeros(count), np.zeros_like(stress[:, 0]), np.zeros_like(stress[:, 0]),
                      np.zeros((count, p)), np.zeros(count))  # fmt: skip
        last.Z += np.array([[each.variation.onset] for each in self.parameters])
        found = [last]
        for i in range(len(self.steps)):
            found.append(self._follow(i, found[-1], stress[:, i], history[:, i]))
        return [self._states(j, found) for j in range(count)]

    def _follow(self, i: int, last: _Rates, stress: Array, history: Array) -> _Rates:
        """The derivatives after a step, from those before it and what the parameters change at rest, (m, p, d) and (m, p)."""
        problem, points, now = self.problem, self.points, self.states[i + 1]
        p = len(problem.operator.weights)
        here = slice(i * p, (i + 1) * p)
        carried = np.where(points.kept[here], last.Z, 0.0)
        stress = stress + points.stress_Z[here] * carried[:, :, None]
        row, corner, gaps = self._control(i, last)
        border = problem.border(points.tangent[here], row, corner)
        solve = problem.stiffness.factored(border)  # type: ignore[attr-defined]
        right = np.empty((problem.operator.size + 1, len(gaps)), order="F")
        for j, parameter in enumerate(self.parameters):
            right[:-1, j] = -parameter.forces(now.v) - problem.operator.force(stress[j])
        right[-1] = -gaps
        x = solve(right)
        v = np.ascontiguousarray(x[:-1].T)
        motion = np.einsum("pik,mpk->mpi", problem.operator.matrix, v[:, problem.operator.index])
        moved = np.where(points.loading[here], np.einsum("pi,mpi->mp", points.slope[here], motion), 0.0)
        stress = stress + np.einsum("pij,mpj->mpi", points.tangent[here], motion)
        # what the control prescribes does not change
        prescribed = isinstance(control_of(self.steps[i].control), Dissipation)
        dissipated = np.zeros_like(last.dissipated) if prescribed else last.dissipated
        return _Rates(v, x[-1], motion, stress, history + carried + moved, dissipated)

    def _control(self, i: int, last: _Rates) -> tuple[Array, float, Array]:
        """Row and corner of the equation that holds while the parameters change, and derivatives of its gap (m,) at constant
        unknowns."""
        problem, step, start, now = self.problem, self.steps[i], self.states[i], self.states[i + 1]
        control = control_of(step.control)
        if control.begins_at_onset and not problem.point_law.is_on_surface(start.cracks):
            return self._onset(i, last)
        asked = control.equation(problem, step.value, start, Guess(now.v, now.load, now.cracks))
        gaps = np.zeros(len(self.parameters))
        if isinstance(control, Dissipation):
            gaps = last.dissipated + self._dissipation(i, last)
        return asked.row, asked.corner, gaps

    def _onset(self, i: int, last: _Rates) -> tuple[Array, float, Array]:
        """A step that ended where the next point begins to be damaged further: Zeq is its history there."""
        problem, points, law = self.problem, self.points, self.problem.point_law
        p = len(problem.operator.weights)
        jump, Z = self.states[i + 1].cracks.deformation, self.states[i].cracks.Z
        at = int(np.argmax(law.plane.equivalent_jump(jump)[0] / Z))  # type: ignore[attr-defined]
        gradient = np.zeros_like(jump)
        gradient[at] = points.slope[i * p + at] / problem.operator.weights[at]

        def equivalent(law, by):  # type: ignore[no-untyped-def]
            return law.plane.equivalent_jump(jump[[at]], gradient=False)[0][0]

        gaps = np.array([float(each.variation.differences(equivalent)) for each in self.parameters]) - last.Z[:, at]
        return problem.operator.force(gradient), 0.0, gaps

    def _dissipation(self, i: int, last: _Rates) -> Array:
        """Derivatives of the dissipation of a step at constant unknowns, (m,)."""
        one, still = self.points.one(i), np.zeros_like(last.jump[0])
        changes = [one.dissipation(each.variation, last.points(j), still) for j, each in enumerate(self.parameters)]
        return np.array(changes) @ self.problem.operator.weights

    def _states(self, j: int, found: Sequence[_Rates]) -> list[State]:
        """The derivatives in one parameter."""
        drive = self.problem.drive
        return [
            State(
                each.v[j], float(each.load[j]), each.points(j), float(drive @ each.v[j]), dissipated=float(each.dissipated[j])
            )
            for each in found
        ]

    def _work(self, rates: Sequence[State]) -> list[float]:
        """Derivatives of the work up to each state."""
        drive, found = self.problem.drive, [0.0]
        for (start, now), (old, new) in zip(pairwise(self.states), pairwise(rates), strict=True):
            change = 0.5 * (old.load + new.load) * float(drive @ (now.v - start.v))
            found.append(found[-1] + change + 0.5 * (start.load + now.load) * float(drive @ (new.v - old.v)))
        return found

    def _with_energies(self, parameter: Parameter, rates: Sequence[State], work: Sequence[float]) -> list[State]:
        """The derivatives with those of the energies, which `newton.next_state` adds up."""
        problem, states, weights = self.problem, self.states, self.problem.operator.weights
        started = InterfaceState(*(np.concatenate([getattr(rate.cracks, name) for rate in rates[:-1]])
                                   for name in ("deformation", "stress", "Z")))  # fmt: skip
        motion = np.concatenate([rate.cracks.deformation for rate in rates[1:]])
        variation, points = parameter.variation, self.points
        stored, dissipated, contact = (
            part(variation, started, motion).reshape(points.count, -1) @ weights
            for part in (points.stored, points.dissipation, points.contact_work)
        )
        dissipated, contact = np.cumsum(dissipated), np.cumsum(contact)
        found = []
        for i, new in enumerate(rates[1:]):
            now = states[i + 1]
            elastic = float(problem.bulk(now.v) @ new.v + 0.5 * parameter.forces(now.v) @ now.v)
            energy = (work[i + 1], elastic, float(stored[i]), float(dissipated[i]), float(contact[i]))
            found.append(State(new.v, new.load, new.cracks, new.driven, *energy))
        return found


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
        points.deformation + by * along.deformation, points.stress + by * along.stress, points.Z + by * along.Z
    )
    numbers = ("driven", "work", "elastic", "stored", "dissipated", "contact_work")
    changed = {name: getattr(state, name) + by * getattr(rate, name) for name in numbers}
    return State(state.v + by * rate.v, state.load + by * rate.load, cracks, **changed)
