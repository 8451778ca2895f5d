"""A law at the points of zero-thickness elements, whose deformation is the jump."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Array
from ..law.concrete import Concrete
from ..law.registry import Law


@dataclass(frozen=True)
class InterfaceState:
    """Jump (p, d) in mm, traction (p, d) in MPa and history (p,) or (p, h) of all points."""

    deformation: Array
    stress: Array
    history: Array


@dataclass(frozen=True)
class InterfaceLaw:
    """A law at p interface points: a `PointLaw` whose deformation is the jump, its stress the traction."""

    law: Law
    size: int
    components: int = 2
    quantity = "jump in mm"

    @property
    def onset_jump(self) -> float:
        return self.law.onset_jump

    @property
    def is_checked(self) -> bool:
        return self.law.is_checked

    def of_material(self, concrete: Concrete) -> InterfaceLaw:
        return replace(self, law=self.law.built_for(concrete, self.law.width, self.components))

    def initial(self) -> InterfaceState:
        zeros = np.zeros((self.size, self.components))
        return InterfaceState(zeros, zeros, self.law.initial(self.size))

    def elastic(self) -> Array:
        k = np.diag(self.law.stiffness(self.components))
        return np.broadcast_to(k, (self.size, *k.shape))

    def update(self, deformation: Array, start: InterfaceState, frozen: bool = False) -> tuple[InterfaceState, Array]:
        traction, tangent, history = self.law.update(deformation, start.history, frozen)
        return InterfaceState(deformation, traction, history), tangent

    def nucleate(self, start: InterfaceState, state: InterfaceState) -> None:
        """The planes are there from the beginning."""

    def is_damaging(self, deformation: Array, start: InterfaceState) -> bool:
        return bool(self.law.is_damaging(deformation, start.history).any())

    def is_on_surface(self, state: InterfaceState) -> bool:
        return bool(self.law.is_on_surface(state.deformation, state.history).any())

    def is_separated(self, state: InterfaceState) -> bool:
        gone = abs(state.stress).max() < 1e-8 * self.law.strength
        return bool(gone) and bool(self.law.is_fully_softened(state.history).all())

    def energies(self, state: InterfaceState) -> tuple[Array, Array]:
        return np.zeros(self.size), self.law.stored_energy(state.deformation, state.history)

    def dissipation(self, start: InterfaceState, state: InterfaceState) -> tuple[Array, Array]:
        return self.law.dissipation(start.deformation, start.history, state.deformation, state.history)

    def contact_work(self, start: InterfaceState, state: InterfaceState) -> Array:
        before, after = (self.law.contact_traction(s.deformation, s.history, s.stress) for s in (start, state))
        return np.asarray(0.5 * np.einsum("ij,ij->i", before + after, state.deformation - start.deformation))
