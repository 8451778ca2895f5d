"""Dead loads: own weight and pressures on faces, as forces on the nodes."""

from __future__ import annotations

from collections.abc import Sequence

import meshio
import numpy as np
from scipy.constants import g

from meshing.cells import CELLS
from meshing.cutting.stars import Star
from meshing.specimens import Specimen
from meshing.specimens.base import Pressure

from ..arrays import Array
from ..elements.registry import facet_of
from ..errors import SceneError
from .boundary import nodes_at
from .elements import Elements
from .mesh import CrackedMesh

#: stress, MPa, whose strain over the size of the body is the motion that stands for the dead loads
_STRESS = 0.03

#: kg/m^3 times m/s^2 in N/mm^3
_PER_VOLUME = 1e-9


def dead_motion(mesh: CrackedMesh, E: float) -> float:
    """Motion at which the dead loads act whole, mm, with some modulus: of the size of the others, so that the force on it is
    of theirs."""
    return _STRESS * mesh.extent / E


def dead_loads(specimen: Specimen, mesh: CrackedMesh, elements: Elements, E: float) -> Array | None:
    """Forces on the nodes of a mesh for each mm of `dead_motion` with a modulus, (d m,), N/mm; None if there are none.

    Raises
    ------
    SceneError
        For a direction of the weight in another dimension, or a set with no face of the body.
    """
    d, motion = mesh.dimension, dead_motion(mesh, E)
    down = specimen.gravity() or (0.0, -1.0, 0.0)[:d]
    if len(down) != d:
        raise SceneError.at("specimen.down", f" = {list(down)}: expected {d} numbers")
    force = np.zeros(mesh.points.shape)
    for block, density in zip([*elements.elastic, *elements.cracking], elements.densities, strict=True):
        if density.any():
            force += block.body_force(_PER_VOLUME * g * density[:, None] * np.asarray(down))
    for pressure in specimen.pressures():
        force += elements.thickness * _pressed(mesh, pressure)
    return force.ravel() / motion if force.any() else None


def _pressed(mesh: CrackedMesh, pressure: Pressure) -> Array:
    """Forces of a pressure, (m, d), N for each mm of thickness in the plane."""
    inside = np.zeros(len(mesh.points), dtype=bool)
    inside[nodes_at(mesh, "pressures.at", pressure.at)] = True
    force = np.zeros(mesh.points.shape)
    has_faces = False
    for cells in _alike([*mesh.bulk, *mesh.band]):
        star = Star.from_cells([(cell.type, np.asarray(cell.data)) for cell in cells])
        at = (np.bincount(star.facet)[star.facet] == 1) & inside[star.nodes].all(axis=1)
        has_faces |= bool(at.any())
        nodes, outward = star.nodes[at], star.outward(mesh.points)[at]
        shares = facet_of(cells[0].type).shares
        np.add.at(force, nodes, -pressure.value * shares[None, :, None] * outward[:, None, :])
    if not has_faces:
        raise SceneError.at(
            "specimen.pressures.at",
            f" = {pressure.at!r}: no face of the body has all of its nodes in this set; expected the nodes of some faces",
        )
    return force


def _alike(blocks: Sequence[meshio.CellBlock]) -> list[list[meshio.CellBlock]]:
    """Blocks in groups whose facets have the same number of nodes."""
    groups: dict[int, list[meshio.CellBlock]] = {}
    for block in blocks:
        groups.setdefault(len(CELLS[block.type].facets[0]), []).append(block)
    return list(groups.values())
