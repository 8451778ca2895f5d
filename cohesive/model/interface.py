"""The discrete model: zero-thickness elements along the crack path."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..arrays import Array
from ..cracks.interface_points import InterfaceLaw
from ..elements.interface import Interface
from ..elements.rotations import rotations
from ..law.concrete import Concrete
from ..law.crack_plane import CrackPlane
from ..law.widths import plane_width
from ..scenes.tables import InterfaceOptions
from ..solver.problem import State
from .cracks import CrackPart, values_by_name
from .mesh import CrackedMesh


class InterfacePart(CrackPart):
    """The points of zero-thickness elements; their state has jumps and tractions."""

    point_law: InterfaceLaw

    def mean_traction(self, state: State) -> Array:
        share = self.weights / self.weights.sum()
        return np.asarray(share @ state.cracks.stress[:, :2])

    def point_values(self, state: State) -> dict[str, Array]:
        points = state.cracks
        damage = self.point_law.plane.damage(points.Z)
        return values_by_name(points.deformation, points.stress, damage, np.ones(len(points.Z)))

    def strength_left(self, state: State) -> Array:
        return self.point_law.plane.strength_left(state.cracks.Z)


def interface_part(
    concrete: Concrete, options: InterfaceOptions, mesh: CrackedMesh, thickness: float, length_of: Callable[[float], float]
) -> InterfacePart:
    """Zero-thickness elements along the path.

    Parameters
    ----------
    thickness : of a 2D mesh, mm; 1 in 3D.
    length_of : length of a crack of some area

    Raises
    ------
    SceneError
        For a width that is far from that of any crack plane, or numbers in other units.
    """
    assert mesh.crack is not None
    interface = Interface.from_cells(mesh.crack.type, mesh.points, mesh.crack.data, thickness, options.quadrature)
    crack_length = length_of(interface.area)
    concrete.check_units(crack_length)
    width = plane_width(concrete, options.width, crack_length)
    point_law = InterfaceLaw(CrackPlane(concrete, width), *interface.points.shape)
    return InterfacePart(
        point_law, interface.jump_operator, interface.weights, interface.points, interface.cell, interface.area, width,
        rotations(interface.normals), interface,
    )  # fmt: skip
