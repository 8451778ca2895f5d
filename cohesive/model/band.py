"""The smeared model: a crack band of elements along the path, or all elements."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields

import numpy as np
import scipy.sparse as sp

from ..arrays import Array
from ..cracks.band_points import CrackBand
from ..elements.bulk import ElasticBlock
from ..elements.interface import Interface
from ..elements.registry import centre_rule
from ..elements.rotations import major_strain, rotations, stress_transformation
from ..errors import SceneError
from ..law.concrete import Concrete
from ..law.registry import LawKeys
from ..law.widths import check_band_width
from ..scenes.tables import BandOptions
from ..solver.problem import State
from .cracks import CrackPart, values_by_name
from .mesh import CrackedMesh


class BandPart(CrackPart):
    """The points of a crack band; their state has strains, stresses and crack planes."""

    point_law: CrackBand

    def mean_traction(self, state: State) -> Array:
        points, share = state.cracks, self.weights / self.weights.sum()
        if self.rotations is not None:
            N = stress_transformation(self.rotations)
            return np.asarray(np.einsum("p,pdk,pk->d", share, N[:, :2], points.stress))
        planes = points.planes
        if not len(planes.point):
            return np.zeros(2)
        share = self.weights[planes.point] / planes.length
        return np.asarray(share @ planes.traction[:, :2] / share.sum())

    def point_values(self, state: State) -> dict[str, Array]:
        points, law, size = state.cracks, self.point_law, len(self.weights)
        planes = points.planes
        fracture = planes.length[:, None] * (planes.strain - law.compliance * planes.traction)
        widest = np.lexsort((fracture[:, 0], planes.point))  # the last plane of a point wins
        plane_damage = law.law_of(planes).damage(planes.history) if len(planes.point) else np.zeros(0)
        values = []
        for one in (fracture, planes.traction, plane_damage):
            value = np.zeros((size, *one.shape[1:]))
            value[planes.point[widest]] = one[widest]
            values.append(value)
        count = np.bincount(planes.point, minlength=size).astype(float)
        jump, traction, damage = values
        shown = values_by_name(jump, traction, damage, count) | {"strain_max": major_strain(points.deformation)}
        return shown | self.law_values(state)

    def law_values(self, state: State) -> dict[str, Array]:
        """In a band the sum over the planes of a point."""
        planes, size = state.cracks.planes, len(self.weights)
        own = self.point_law.law_of(planes).fields(planes.jump, planes.history)
        return {f"law.{name}": np.bincount(planes.point, value, size).astype(float) for name, value in own.items()}

    def strength_left(self, state: State) -> Array:
        planes, left = state.cracks.planes, np.full(len(self.weights), np.inf)
        if len(planes.point):
            np.minimum.at(left, planes.point, self.point_law.strength_left(planes))
        return left


def band_part(
    keys: LawKeys,
    concrete: Concrete,
    options: BandOptions,
    mesh: CrackedMesh,
    elements: Sequence[ElasticBlock],
    thickness: float,
    length_of: Callable[[float], float],
    known: tuple[float, float] | None,
) -> BandPart:
    """A crack band: quadrilaterals or hexahedra along the path, or all elements.

    Parameters
    ----------
    keys : of the law.
    elements : those that may crack.
    thickness : of a 2D mesh, mm; 1 in 3D.
    length_of : length of a crack of some area
    known : area of the crack (mm^2) and width of the band (mm) of a built-in specimen; None: the mesh tells.

    Raises
    ------
    SceneError
        For a band so wide that it dissipates twice Gf, numbers in other units, or planes that cannot lie on the path.
    """
    parts = [block.strain_points(centre_rule(block.kind) if mesh.is_row else None) for block in elements]
    offsets = np.cumsum([0, *(len(block.cells) for block in elements)])[:-1]
    cell = np.concatenate([part[3] + offset for part, offset in zip(parts, offsets, strict=True)])
    weights = np.concatenate([part[1] for part in parts])
    faces = area = None
    if mesh.faces is not None:
        faces = Interface.from_cells(mesh.faces.type, mesh.closed, mesh.faces.data, thickness)
        area = faces.area
        width = float(weights.sum()) / area
    else:  # each crack will have a length of its own
        volumes = np.concatenate([np.bincount(part[3], part[1]) for part in parts]) / thickness
        width = float(np.median(np.sqrt(volumes) if mesh.dimension == 2 else np.cbrt(volumes)))
    if known is not None:
        area, width = known
    plane = keys.built_for(concrete, width, mesh.dimension)
    plane.check(mesh.extent if area is None else length_of(area))
    check_band_width(concrete, width, "specimen.band: width" if known is None else "band.width")
    normals = path_normals(mesh, faces)
    on_path = _of_planes(options, normals)
    law = CrackBand(
        plane,
        elements[0].D,
        np.concatenate([block.corners() for block in elements])[cell],
        options.max_cracks,
        options.threshold_angle,
        path_normal=None if on_path is None else on_path[cell],
    )
    operator = sp.vstack([part[0] for part in parts]).tocsr()
    where = np.concatenate([part[2] for part in parts])
    along = None if normals is None else rotations(normals[cell])
    return BandPart(law, operator, weights, where, cell, area, width, along, faces)


def path_normals(mesh: CrackedMesh, faces: Interface | None) -> Array | None:
    """Unit normal of the path at each cell of a band, (n, d), towards the plus side; None if its cells follow no path.

    A cell of a row belongs to the piece of the path that is its middle line or surface, also at a kink, which parts two cells.
    """
    if faces is None:
        return mesh.beside_normals
    total = np.zeros((int(faces.cell[-1]) + 1, mesh.dimension))
    np.add.at(total, faces.cell, faces.weights[:, None] * faces.normals)
    return np.asarray(total / np.linalg.norm(total, axis=1, keepdims=True))


def _of_planes(options: BandOptions, normals: Array | None) -> Array | None:
    """Normals of the path if the planes lie on it, else None; SceneError if they cannot, or for keys of other planes."""
    if options.planes == "path" and normals is None:
        raise SceneError.at(
            "band.planes", " = 'path': the elements of specimen.band follow no path; expected 'principal', or one row of them"
        )
    if options.planes == "principal" or normals is None:
        return None
    for each in fields(options):
        if each.name in ("max_cracks", "threshold_angle") and (value := getattr(options, each.name)) != each.default:
            raise SceneError.at(
                f"band.{each.name}", f" = {value:g}: a plane on the path is the only one; expected band.planes = 'principal'"
            )
    return normals
