"""A cracked body in equilibrium: what is driven, held and measured, and the forces in a state."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp

from ..algebra.bordered import Border, Stiffness
from ..algebra.crack_operator import CrackOperator
from ..arrays import Array, Index
from ..cracks.point_law import PointLaw
from .loading import DEAD, Loading


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
    released : by snaps
    """

    driven: float = 0.0
    work: float = 0.0
    elastic: float = 0.0
    stored: float = 0.0
    dissipated: float = 0.0
    contact_work: float = 0.0
    released: float = 0.0

    @property
    def unaccounted(self) -> float:
        """Work that no energy accounts for."""
        return self.work - self.elastic - self.stored - self.dissipated - self.contact_work - self.released


@dataclass(frozen=True)
class Springs:
    """Springs on driven motions.

    Attributes
    ----------
    stiffness : (k,) array, N/mm
    rest : (k,) array, motions at which they are unstressed, mm; NaN for one that does not act yet
    taken : (k,) array, motions at which they took over the forces there were, mm
    """

    stiffness: Array
    rest: Array
    taken: Array

    @classmethod
    def from_stiffness(cls, acting: Array, later: Array) -> Springs:
        """Springs that act from the beginning, and springs that do not act yet, (k,) each, N/mm, 0 without."""
        rest = np.where((later > 0) | (acting == 0), np.nan, 0.0)
        return cls(acting + later, rest, np.zeros(len(acting)))

    @cached_property
    def acting(self) -> Index:
        """Which act."""
        return np.flatnonzero(np.isfinite(self.rest))

    def force(self, motion: Array) -> Array:
        """Of those that act, N, from all motions (k,)."""
        at = self.acting
        return np.asarray(self.stiffness[at] * (motion[at] - self.rest[at]))

    def energy(self, motion: Array) -> float:
        """What they hold beyond the energy that they were put in with, N mm."""
        at = self.acting
        stretched = (motion[at] - self.rest[at]) ** 2 - (self.taken[at] - self.rest[at]) ** 2
        return 0.5 * float(self.stiffness[at] @ stretched)

    def put_in(self, at: int, motion: float, force: float) -> Springs:
        """With the spring of one motion in place of a force."""
        rest, taken = self.rest.copy(), self.taken.copy()
        rest[at] = motion + (force / self.stiffness[at] if self.stiffness[at] else 0.0)
        taken[at] = motion
        return Springs(self.stiffness, rest, taken)


@dataclass(frozen=True)
class Problem:
    """A body with cracks in equilibrium: K v + springs + cracks(v) = load * direction + dead forces, on the driven motions.

    Attributes
    ----------
    point_law : PointLaw
    operator : CrackOperator
    stiffness : Stiffness of the elastic bulk
    drives : (k,) array, indices of the unknowns that are driven motions
    loading : Loading, what is done to them
    springs : Springs on them
    strength : tensile strength times the crack's area, N: the scale of forces
    energy : fracture energy times the crack's area, N mm: the scale of energies
    measures : linear measures of the unknowns by name ("opening", "sliding"), (n,) each
    tol : relative tolerance on residual and correction
    secant : whether the points give the tangents of their unloading branches in every iteration
    dead_factor : motion of the dead loads at which they act whole, mm; 0: there are none
    start : State under dead loads alone, from which motions count; None: there are none
    """

    point_law: PointLaw
    operator: CrackOperator
    stiffness: Stiffness
    drives: Index
    loading: Loading
    springs: Springs
    strength: float
    energy: float
    measures: dict[str, Array]
    tol: float
    secant: bool = False
    dead_factor: float = 0.0
    start: State | None = None

    def driven(self, angle: float, hold: bool = True) -> Problem:
        """The same body with its platen moved at an angle between its two motions, degrees: 0 the first, 90 the second."""
        return replace(self, loading=self.loading.turned(angle, hold))

    def growing(self) -> Problem:
        """The same body while its dead loads grow: `driven` is the motion that stands for them, up to `dead_factor`."""
        return replace(self, loading=self.loading.moving(DEAD), dead_factor=0.0, start=None)

    def sprung(self, state: State) -> Problem:
        """The same body with the spring of the platen in place of the force that holds its first motion in this state."""
        first = self.loading.moved.motions[0]
        force = float(self.driven_forces(state)[first])
        return replace(self, springs=self.springs.put_in(first, float(state.v[self.drives[first]]), force))

    @cached_property
    def drive(self) -> Array:
        """Forces of a unit load, (n,); also the row that measures the driven motion."""
        return self._on_motions(self.loading.direction)

    @cached_property
    def _constant_forces(self) -> Array | None:
        """Forces of the drives that are held at theirs, (n,), N; None: there are none."""
        return self._on_motions(self.loading.dead) if self.loading.dead.any() else None

    def _on_motions(self, values: Array) -> Array:
        unit = np.zeros(self.operator.size)
        unit[self.drives] = values
        return unit

    @cached_property
    def free(self) -> sp.csr_array | None:
        """Motions that the drives allow: v = free @ y; None: all."""
        allowed = self.loading.allowed
        if allowed is None:
            return None
        n, k = self.operator.size, len(self.drives)
        others = np.setdiff1d(np.arange(n), self.drives)
        at, column = np.nonzero(allowed)
        rows, columns = np.r_[others, self.drives[at]], np.r_[np.arange(n - k), n - k + column]
        values = np.r_[np.ones(n - k), allowed[at, column]]
        return sp.csr_array((values, (rows, columns)), shape=(n, n - k + allowed.shape[1]))

    def fixed_part(self, v: Array) -> Array:
        """What the drives do not allow to change of some unknowns, (m, n)."""
        fixed = np.zeros_like(v)
        if (allowed := self.loading.allowed) is not None:
            driven = v[:, self.drives]
            fixed[:, self.drives] = driven - driven @ allowed @ allowed.T
        return fixed

    def bulk(self, v: Array) -> Array:
        """Forces of the elastic bulk and of the springs, (n,), N."""
        force = self.stiffness.apply(v)
        if len(self.springs.acting):
            force[self.drives[self.springs.acting]] += self.springs.force(v[self.drives])
        return force

    def internal_force(self, state: State) -> Array:
        """Forces of bulk, springs and cracks on the unknowns, (n,), N: on the driven motions, loads and reactions."""
        return self.bulk(state.v) + self.operator.force(state.cracks.stress)

    def driven_forces(self, state: State) -> Array:
        """Forces on the driven motions, (k,), N."""
        return np.asarray(self.internal_force(state)[self.drives])

    def residual(self, v: Array, crack: Array, load: float) -> Array:
        """Forces out of balance, (n,), N, with those of the cracks, less the reactions of what the drives hold."""
        residual = self.bulk(v) + crack - load * self.drive
        if self._constant_forces is not None:
            residual -= self._constant_forces
        if (allowed := self.loading.allowed) is not None:
            residual[self.drives] = allowed @ (allowed.T @ residual[self.drives])
        return residual

    def elastic_energy(self, v: Array) -> float:
        """Energy of the bulk and the springs, N mm."""
        force = self.stiffness.apply(v)
        energy = 0.5 * float(v @ force)
        if len(self.springs.acting):
            energy += self.springs.energy(v[self.drives])
        if self.dead_motion is not None:  # without the potential of the dead loads
            energy -= float(v[self.dead_motion] * force[self.dead_motion])
        return energy

    @cached_property
    def dead_motion(self) -> int | None:
        """Unknown that is the factor of the dead loads; the force on it is minus the work that they, whole, do by all
        displacements, over `dead_factor`."""
        dead = self.loading.drives.get(DEAD)
        return None if dead is None else int(self.drives[dead.motions[0]])

    def work(self, start: Guess, now: Guess) -> float:
        """Work of all loads from one state to another, by the trapezoidal rule, N mm."""
        change = now.v - start.v
        work = 0.0 if self.loading.active == DEAD else 0.5 * (start.load + now.load) * float(self.drive @ change)
        if self._constant_forces is not None:
            work += float(self._constant_forces @ change)
        if (at := self.dead_motion) is not None:
            force = [float(self.stiffness.apply(v)[at]) for v in (start.v, now.v)]
            work -= 0.5 * float(start.v[at] + now.v[at]) * (force[1] - force[0])
        return work

    def border(self, tangent: Array, row: Array, corner: float) -> Border:
        """What the points, with tangents (p, c, c), the springs and a control add to the stiffness of the bulk; `row` (n,) and
        `corner` as `Border` has them."""
        rows, columns, values = self.operator.stiffness(tangent)
        acting = self.springs.acting
        if len(acting):
            at = self.drives[acting]
            rows, columns = np.append(rows, at), np.append(columns, at)
            values = np.append(values, self.springs.stiffness[acting])
        return Border((rows, columns, values), self.drive, row, corner, self.free)

    @cached_property
    def rounding(self) -> float:
        """Forces on the unknowns per unit of the largest of them, N/mm."""
        size = abs(self.operator.matrix)
        force = np.einsum("pik,pij,pjl->pk", size, abs(self.point_law.elastic()), size) * self.operator.weights[:, None]
        return self.stiffness.scale + float(np.bincount(self.operator.index.ravel(), force.ravel()).max())

    def initial(self) -> State:
        """The undamaged state without loads, or that under dead loads alone."""
        if self.start is not None:
            return self.start
        return State(np.zeros(self.operator.size), 0.0, self.point_law.initial())

    def motion(self, row: Array, state: Guess) -> float:
        """A linear measure of the unknowns, (n,), counted from the body under its dead loads, mm."""
        return float(row @ (state.v if self.start is None else state.v - self.start.v))

    def measure(self, name: str, state: State) -> float:
        """Value of a linear measure, mm."""
        return self.motion(self.measures[name], state)

    def driven_motion(self, name: str, state: State) -> float:
        """Motion of one of the drives, mm."""
        return self.motion(self._on_motions(self.loading.row(name)), state)

    def describe(self, point: int) -> str:
        """Coordinates of a point, for messages."""
        coordinates = np.round(self.operator.where[point], 9) + 0.0  # no -0
        return f"({', '.join(f'{x:.4g}' for x in coordinates)})"

    def with_driven_load(self, state: State) -> State:
        """The same state with the load and the motion of the drive that is moved."""
        load = self.loading.force(self.loading.active, self.driven_forces(state))
        return replace(state, load=load, driven=self.motion(self.drive, state))

    def response(self, tangent: Array) -> Array:
        """Change of the unknowns under one more newton of load, (n,), with tangents (p, c, c) at the points."""
        nothing = np.zeros(self.operator.size)
        return self.stiffness.solve(self.border(tangent, nothing, 1.0), nothing, 1.0)[:-1]

    def is_separated(self, state: State) -> bool:
        """Whether nothing is left of the cracks' tractions: the body is in pieces."""
        return self.point_law.is_separated(state.cracks)
