"""The discrete model: zero-thickness elements along the crack path."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..arrays import Array
from ..cracks.interface_points import InterfaceLaw
from ..elements.interface import Interface
from ..elements.rotations import rotations
from ..errors import SceneError
from ..law.concrete import Concrete
from ..law.crack_plane import CrackPlane
from ..scenes.tables import InterfaceOptions
from ..solver.problem import State
from .checks import check_units
from .cracks import CrackPart, values_by_name
from .mesh import CrackedMesh

#: the default width of the interface: this part of the crack length, and at most this part of E Gf / ft^2
WIDTH_OF_CRACK, WIDTH_OF_MATERIAL = 0.01, 0.004


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


def default_width(crack_length: float, concrete: Concrete) -> float:
    """Width of the crack plane in mm if the scene names none: the smaller of 1 % of the crack length and 0.4 % of
    `Concrete.zone_length`, E Gf / ft^2 with the exponential curve. On the built-in beam it costs less than 1 % of the load at
    small opening and of the peak against a vanishing width."""
    return min(WIDTH_OF_CRACK * crack_length, WIDTH_OF_MATERIAL * concrete.zone_length)


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
    check_units(concrete, crack_length)
    width = _width(concrete, options.width, crack_length)
    point_law = InterfaceLaw(CrackPlane(concrete, width), *interface.points.shape)
    return InterfacePart(
        point_law, interface.jump_operator, interface.weights, interface.points, interface.cell, interface.area, width,
        rotations(interface.normals), interface,
    )  # fmt: skip


def _width(concrete: Concrete, width: float | str | None, crack_length: float) -> float:
    """Width of the crack plane, mm: as given, that of the print or that of the rule."""
    if width is None:
        return default_width(crack_length, concrete)
    if isinstance(width, str):  # "h"
        return concrete.h
    least, most = 1e-6 * crack_length, max(concrete.h, crack_length)
    if not least <= width <= most:
        raise SceneError(f"interface.width = {width:g}: expected between {least:.1e} and {most:g} mm", "interface.width")
    return width
