"""What the solver asks of the points with cracks: interface points and points of a crack band answer alike."""

from __future__ import annotations

from typing import Any, Protocol

from ..arrays import Array
from ..law.concrete import Concrete


class PointLaw(Protocol):
    """What happens at the points with cracks, as a function of their deformation (p, c): jump or strain.

    Its states hold at least `deformation` and `stress`, (p, c) each; nothing changes them once they are made.
    """

    @property
    def quantity(self) -> str:
        """Name of the deformation, for messages."""

    @property
    def onset_jump(self) -> float:
        """Smallest motion that damages, mm."""

    @property
    def is_checked(self) -> bool:
        """Whether the balance of energies checks the law: its dissipation is not what the work of a step leaves."""

    def of_material(self, concrete: Concrete) -> PointLaw:
        """The same points with another material."""

    def initial(self) -> Any:
        """The unloaded, undamaged state."""

    def elastic(self) -> Array:
        """Undamaged tangents, (p, c, c)."""

    def update(self, deformation: Array, start: Any, frozen: bool = False) -> tuple[Any, Array]:
        """State and consistent tangents (p, c, c) reached from the committed state `start`; with `frozen` the
        unloading tangent if a point has two. Raises PointFailure if a point has no solution."""

    def nucleate(self, start: Any, state: Any) -> Any | None:
        """`start` with the new crack planes that the equilibrium `state` calls for, or None."""

    def is_damaging(self, deformation: Array, start: Any) -> bool:
        """Whether this deformation damages more than `start`."""

    def is_on_surface(self, state: Any) -> bool:
        """Whether some damaged point stands where more deformation damages it further."""

    def is_separated(self, state: Any) -> bool:
        """Whether no traction is left on any crack, and none can come back by opening."""

    def energies(self, state: Any) -> tuple[Array, Array]:
        """Elastic energy of the points themselves and energy stored on cracks, (p,) each, per weight."""

    def dissipation(self, start: Any, state: Any) -> tuple[Array, Array]:
        """Damage dissipation of a step, (p,), per weight, and its derivative in the deformation, (p, c)."""

    def contact_work(self, start: Any, state: Any) -> Array:
        """Work of the contact tractions in a step, (p,), per weight."""
