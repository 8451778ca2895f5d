"""The discrete model: zero-thickness elements along the crack path."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..arrays import Array
from ..cracks.interface_points import InterfaceLaw
from ..elements.interface import Interface
from ..elements.rotations import rotations
from ..law.concrete import Concrete
from ..law.registry import LawKeys
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
        damage = self.point_law.law.damage(points.history)
        values = values_by_name(points.deformation, points.stress, damage, np.ones(len(damage)))
        return values | self.law_values(state)

    def law_values(self, state: State) -> dict[str, Array]:
        points = state.cracks
        return {f"law.{name}": value for name, value in self.point_law.law.fields(points.deformation, points.history).items()}

    def strength_left(self, state: State) -> Array:
        return self.point_law.law.strength_left(state.cracks.history)


def interface_part(
    keys: LawKeys,
    concrete: Concrete,
    options: InterfaceOptions,
    mesh: CrackedMesh,
    thickness: float,
    length_of: Callable[[float], float],
) -> InterfacePart:
    """Zero-thickness elements along the path.

    Parameters
    ----------
    keys : of the law.
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
    width = plane_width(keys.zone_length(concrete), concrete.h, options.width, crack_length)
    law = keys.built_for(concrete, width, interface.points.shape[1])
    law.check(crack_length)
    point_law = InterfaceLaw(law, *interface.points.shape)
    return InterfacePart(
        point_law, interface.jump_operator, interface.weights, interface.points, interface.cell, interface.area, width,
        rotations(interface.normals), interface,
    )  # fmt: skip
