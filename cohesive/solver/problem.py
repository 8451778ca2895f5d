"""A cracked body in equilibrium: what is driven, held and measured, and the forces in a state."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp

from ..algebra.bordered import Entries, Stiffness
from ..algebra.crack_operator import CrackOperator
from ..arrays import Array, Index
from ..cracks.point_law import PointLaw
from ..errors import NotConverged

#: the body is held if a known motion is found from its forces within this part of it; a body that can move without a force
#: has been found to 3e-4 by chance
_FOUND = 1e-5


@dataclass(frozen=True)
class Guess:
    """Where the equations of a step are evaluated.

    Attributes
    ----------
    v : (n,) array, the unknowns, mm
    load : N
    cracks : state of the point law, reached from that of the step's start
    """

    v: Array
    load: float
    cracks: Any


@dataclass(frozen=True)
class State(Guess):
    """A converged state and the energies on the way to it, N mm.

    Attributes
    ----------
    driven : motion of the drives along their direction, mm
    work : of the load
    elastic : energy of the bulk, of the springs, and of the points themselves
    stored : energy on the cracks that unloading gives back
    dissipated : by damage
    contact_work : of the contact tractions
    """

    driven: float = 0.0
    work: float = 0.0
    elastic: float = 0.0
    stored: float = 0.0
    dissipated: float = 0.0
    contact_work: float = 0.0


@dataclass(frozen=True)
class Problem:
    """A body with cracks in equilibrium: K v + cracks(v) = load * direction, on the drives.

    With two drives, `direction` is a unit vector between them. Across it they are held, or with `hold` false free but for
    the spring.

    Attributes
    ----------
    point_law : PointLaw
    operator : CrackOperator
    stiffness : Stiffness of the elastic bulk
    drives : (k,) array, indices of the unknowns that are moved from outside
    direction : (k,) array, unit vector along which they move and the load acts
    strength : tensile strength times the crack's area, N: the scale of forces
    energy : fracture energy times the crack's area, N mm: the scale of energies
    measures : linear measures of the unknowns by name ("opening", "sliding"), (n,) each
    tol : relative tolerance on residual and correction
    hold : whether the drives are held across the direction
    spring : stiffness that resists the first drive, N/mm
    rest : motion of the first drive at which the spring is unstressed, mm; None: it does not act yet
    taken : motion of the first drive at which the spring took over the force there was, mm
    secant : whether the points give the tangents of their unloading branches in every iteration
    """

    point_law: PointLaw
    operator: CrackOperator
    stiffness: Stiffness
    drives: Index
    direction: Array
    strength: float
    energy: float
    measures: dict[str, Array]
    tol: float
    hold: bool = True
    spring: float = 0.0
    rest: float | None = None
    taken: float = 0.0
    secant: bool = False

    def driven(self, angle: float, hold: bool = True) -> Problem:
        """The same body driven at an angle between its two drives, degrees: 0 the first, 90 the second."""
        t = np.radians(angle)
        direction = np.array([np.cos(t), np.sin(t)])
        direction[abs(direction) < 1e-15] = 0.0
        return replace(self, direction=direction, hold=hold)

    def sprung(self, state: State) -> Problem:
        """The same body with its spring in place of the force that holds the first drive in this state."""
        first = self.drives[0]
        force = float(self.internal_force(state)[first])
        motion = float(state.v[first])
        return replace(self, rest=motion + force / self.spring if self.spring else motion, taken=motion)

    @cached_property
    def drive(self) -> Array:
        """Forces of a unit load, (n,); also the row that measures the driven motion."""
        unit = np.zeros(self.operator.size)
        unit[self.drives] = self.direction
        return unit

    @cached_property
    def free(self) -> sp.csr_array | None:
        """Motions that the direction of the drives allows: v = free @ y; None: all."""
        if len(self.drives) == 1 or not self.hold:
            return None
        n = self.operator.size
        others = np.setdiff1d(np.arange(n), self.drives)
        rows, columns = np.r_[others, self.drives], np.r_[np.arange(n - 2), n - 2, n - 2]
        return sp.csr_array((np.r_[np.ones(n - 2), self.direction], (rows, columns)), shape=(n, n - 1))

    def bulk(self, v: Array) -> Array:
        """Forces of the elastic bulk and of the spring, (n,), N."""
        force = self.stiffness.apply(v)
        if self.rest is not None:
            force[self.drives[0]] += self.spring * (v[self.drives[0]] - self.rest)
        return force

    def internal_force(self, state: State) -> Array:
        """Forces of bulk, spring and cracks on the unknowns, (n,), N: on the drives, the load and the reactions."""
        return self.bulk(state.v) + self.operator.force(state.cracks.stress)

    def elastic_energy(self, v: Array) -> float:
        """Energy of the bulk and the spring, N mm."""
        energy = 0.5 * float(v @ self.stiffness.apply(v))
        if self.rest is not None:  # what it holds beyond the energy it was put in with
            energy += 0.5 * self.spring * ((float(v[self.drives[0]]) - self.rest) ** 2 - (self.taken - self.rest) ** 2)
        return energy

    def entries(self, tangent: Array) -> Entries:
        """Tangent stiffness of the points, with tangents (p, c, c), and of the spring."""
        rows, columns, values = self.operator.stiffness(tangent)
        if self.rest is None:
            return rows, columns, values
        at = self.drives[:1]
        return np.append(rows, at), np.append(columns, at), np.append(values, self.spring)

    def unbalanced(self, residual: Array) -> Array:
        """The residual without the reaction that holds the drives across their direction."""
        if self.free is not None:
            residual[self.drives] = self.direction * (self.direction @ residual[self.drives])
        return residual

    @cached_property
    def rounding(self) -> float:
        """Forces on the unknowns per unit of the largest of them, N/mm."""
        size = abs(self.operator.matrix)
        force = np.einsum("pik,pij,pjl->pk", size, abs(self.point_law.elastic()), size) * self.operator.weights[:, None]
        return self.stiffness.scale + float(np.bincount(self.operator.index.ravel(), force.ravel()).max())

    def initial(self) -> State:
        """The unloaded, undamaged state."""
        return State(np.zeros(self.operator.size), 0.0, self.point_law.initial())

    def measure(self, name: str, state: State) -> float:
        """Value of a linear measure."""
        return float(self.measures[name] @ state.v)

    def describe(self, point: int) -> str:
        """Coordinates of a point, for messages."""
        coordinates = np.round(self.operator.where[point], 9) + 0.0  # no -0
        return f"({', '.join(f'{x:.4g}' for x in coordinates)})"

    def at_rest(self, state: State) -> State:
        """The same state with the load and the motion along this direction of the drives."""
        force = self.internal_force(state)
        return replace(state, load=float(self.drive @ force), driven=float(self.drive @ state.v))

    def response(self, tangent: Array) -> Array:
        """Change of the unknowns under one more newton of load, (n,), with tangents (p, c, c) at the points."""
        nothing = np.zeros(self.operator.size)
        entries = self.entries(tangent)
        return self.stiffness.solve(entries, self.drive, nothing, 1.0, nothing, 1.0, self.free)[:-1]

    def is_held(self) -> bool:
        """Whether the elastic body has a stiffness against every motion: a known motion is found from its forces."""
        motion = np.random.default_rng(0).normal(size=self.operator.size)
        if self.free is not None:
            motion = self.free @ (self.free.T @ motion)
        tangent = self.point_law.elastic()
        stress = np.einsum("pij,pj->pi", tangent, self.operator.deformation(motion))
        force = self.stiffness.apply(motion) + self.operator.force(stress)
        if self.rest is not None:
            force[self.drives[0]] += self.spring * motion[self.drives[0]]
        nothing = np.zeros_like(motion)
        try:
            entries = self.entries(tangent)
            found = self.stiffness.solve(entries, nothing, nothing, 1.0, force, 0.0, self.free)[:-1]
        except NotConverged:
            return False
        return bool(np.linalg.norm(found - motion) < _FOUND * np.linalg.norm(motion))

    def is_separated(self, state: State) -> bool:
        """Whether nothing is left of the cracks' tractions: the body is in pieces."""
        return self.point_law.is_separated(state.cracks)
