"""The crack-plane law at the points of zero-thickness elements, whose deformation is the jump."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..law.concrete import Concrete
from ..law.crack_plane import CrackPlane


@dataclass(frozen=True)
class InterfaceState:
    """Jump (p, d) in mm, traction (p, d) in MPa and history Z (p,) in mm of all points."""

    deformation: Array
    stress: Array
    Z: Array


@dataclass(frozen=True)
class InterfaceLaw:
    """The crack-plane law at p interface points: a `PointLaw` whose deformation is the jump, its stress the traction."""

    plane: CrackPlane
    size: int
    components: int = 2
    quantity = "jump in mm"

    @property
    def concrete(self) -> Concrete:
        return self.plane.concrete

    @property
    def onset_jump(self) -> float:
        return float(self.plane.Zt)

    def initial(self) -> InterfaceState:
        zeros = np.zeros((self.size, self.components))
        return InterfaceState(zeros, zeros, np.full(self.size, self.plane.Zt))

    def elastic(self) -> Array:
        k = np.diag(self.plane.stiffness(self.components))
        return np.broadcast_to(k, (self.size, *k.shape))

    def update(self, deformation: Array, start: InterfaceState, frozen: bool = False) -> tuple[InterfaceState, Array]:
        traction, tangent, Z = self.plane.update(deformation, start.Z, frozen)
        return InterfaceState(deformation, traction, Z), tangent

    def nucleate(self, start: InterfaceState, state: InterfaceState) -> None:
        """The planes are there from the beginning."""

    def is_damaging(self, deformation: Array, start: InterfaceState) -> bool:
        return bool(((self.plane.history(deformation, start.Z) > start.Z) & ~self.plane.has_ended(start.Z)).any())

    def is_on_surface(self, state: InterfaceState) -> bool:
        on_surface = self.plane.history(state.deformation, np.zeros_like(state.Z)) >= state.Z
        return bool((on_surface & (state.Z > self.plane.Zt) & ~self.plane.has_ended(state.Z)).any())

    def is_separated(self, state: InterfaceState) -> bool:
        gone = abs(state.stress).max() < 1e-8 * self.concrete.ft
        return bool(gone) and bool(self.plane.is_fully_softened(state.Z).all())

    def energies(self, state: InterfaceState) -> tuple[Array, Array]:
        return np.zeros(self.size), self.plane.stored_energy(state.deformation, state.Z)

    def dissipation(self, start: InterfaceState, state: InterfaceState) -> tuple[Array, Array]:
        return self.plane.dissipation(start.deformation, start.Z, state.deformation, state.Z)

    def contact_work(self, start: InterfaceState, state: InterfaceState) -> Array:
        # what the traction has besides its first term is exactly zero without contact
        before, after = (s.stress - self.plane.undamaged_traction(s.deformation, s.Z) for s in (start, state))
        return np.asarray(0.5 * np.einsum("ij,ij->i", before + after, state.deformation - start.deformation))
