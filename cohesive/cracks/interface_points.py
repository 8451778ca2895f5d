"""Zero-thickness interface elements: jump, rotation to the crack frame, quadrature, and the law at their points.

In the plane a crack cell lists the nodes of its minus side, then of its plus side, as the perimeter of the quadrilateral
into which it opens: `quad` = [a-, b-, b+, a+], `quad8` = [a-, b-, b+, a+, mid-, b-, mid+, a+]. With the tangent from
a to b the normal is the tangent turned by +90 degrees; it points from minus to plus.

In space it lists the facet of the minus side, then that of the plus side: `wedge` = [a-, b-, c-, a+, b+, c+],
`hexahedron` with four corners each, and `wedge15` = [a-, b-, c-, a+, b+, c+, ab-, bc-, ca-, ab+, bc+, ca+, a-, b-, c-].
The normal is (b - a) x (c - a). On a facet that is curved or warped it is taken at each point.
"""

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
