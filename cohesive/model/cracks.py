"""model/cracks"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import meshio
import numpy as np
import scipy.sparse as sp

from meshing import SingleCrack3D

from ..arrays import Array, Index
from ..cracks.band_points import BandState, CrackBand
from ..cracks.interface_points import InterfaceLaw
from ..cracks.point_law import PointLaw
from ..elements.bulk import ElasticBlock
from ..elements.interface import Interface
from ..elements.rotations import major_strain, stress_transformation
from ..elements.rotations import rotations as rotations_of
from ..elements.shapes import Rule, gauss_cube
from ..errors import SceneError
from ..law.concrete import Concrete
from ..law.crack_plane import CrackPlane
from ..scenes.scene import Scene
from ..scenes.tables import UserMesh
from ..solver.problem import State

#: the default width of the interface: this part of the crack length, and at most this part of E Gf / ft^2
WIDTH_OF_CRACK, WIDTH_OF_MATERIAL = 0.01, 0.004

#: points along each side of an element of a band, on its centre line or mid plane: there a crack that opens linearly causes
#: no shear. With points off it that shear locks the band: on the built-in beam with elements of 5 and 1 mm the peak is 6 and
#: 3 % too high. Two points along see every deformation of a quad; what three do not see of a quad6, bending about the
#: centre line, and what two by two do not see of a hexahedron, twisting about the mid plane, the bulk resists.
_POINTS_ALONG = {"quad": 2, "quad6": 3, "hexahedron": 2}

#: energy that a band dissipates beyond Gf, as a part of Gf: ft^2 l_ch / (2 E Gf)
_WARN_EXCESS, _REFUSE_EXCESS = 0.05, 1.0


@dataclass(frozen=True)
class CrackPart:
    """The points with cracks.

    Attributes
    ----------
    point_law : PointLaw
    operator : (c p, d m) sparse matrix, displacements of the mesh nodes to jumps or strains
    weights, where, cell : (p,), (p, d), (p,): weight, position and cell of each point, the cells counted over all
        blocks of the part
    area : of the crack, mm^2; None where there is neither a path nor a row of elements that tells
    width : of the crack plane: w, or the l_ch of a crack along the path
    rotations : (p, d, d) normal and tangents of the path at each point; None where there is no path
    faces : Interface between the two sides of the path, which gives the mean jump; None where there is none
    """

    point_law: PointLaw
    operator: sp.csr_array
    weights: Array
    where: Array
    cell: Index
    area: float | None
    width: float
    rotations: Array | None
    faces: Interface | None

    def mean_traction(self, state: State) -> Array:
        """Mean [normal, shear] traction on the crack, MPa; with no path to refer to, on all crack planes. In space the shear
        along the first tangent of `elements.rotations.rotations`."""
        points, share = state.cracks, self.weights / self.weights.sum()
        if isinstance(points, BandState):
            if self.rotations is not None:
                N = stress_transformation(self.rotations)
                return np.asarray(np.einsum("p,pdk,pk->d", share, N[:, :2], points.stress))
            cracks = points.planes
            if not len(cracks.point):
                return np.zeros(2)
            share = self.weights[cracks.point] / cracks.length
            return np.asarray(share @ cracks.traction[:, :2] / share.sum())
        return np.asarray(share @ points.stress[:, :2])

    def point_values(self, state: State) -> dict[str, Array]:
        """The crack at each point, see `Frame`: (p,) each."""
        points, further = state.cracks, {}
        if isinstance(self.point_law, InterfaceLaw):
            jump, traction = points.deformation, points.stress
            planes = np.ones(len(jump))
            damage = self.point_law.plane.damage(points.Z)
        else:
            assert isinstance(self.point_law, CrackBand)
            size, cracks = len(self.weights), points.planes
            fracture = cracks.length[:, None] * (cracks.strain - self.point_law.compliance * cracks.traction)
            widest = np.lexsort((fracture[:, 0], cracks.point))  # the last plane of a point wins
            found = self.point_law.plane.with_width(cracks.length).damage(cracks.Z) if len(cracks.point) else cracks.Z
            values = []
            for one in (fracture, cracks.traction, found):
                value = np.zeros((size, *one.shape[1:]))
                value[cracks.point[widest]] = one[widest]
                values.append(value)
            jump, traction, damage = values
            planes = np.bincount(cracks.point, minlength=size).astype(float)
            further = {"strain_max": major_strain(points.deformation)}
        names = ("opening", "sliding", "traction_n", "traction_s", "damage", "planes")
        values = [jump[:, 0], _shear(jump), traction[:, 0], _shear(traction), damage, planes]
        return dict(zip(names, values, strict=True)) | further

    def cell_values(self, state: State) -> dict[str, Array]:
        """Means of `point_values` over the cells."""
        count = np.bincount(self.cell)
        return {name: np.bincount(self.cell, values) / count for name, values in self.point_values(state).items()}

    def cell_stresses(self, state: State, sizes: Sequence[int]) -> list[Array]:
        """Mean stress in the cells of the blocks of a band that have `sizes` cells, (n, k) each."""
        if not sizes:
            return []
        count = np.bincount(self.cell)
        mean = np.stack([np.bincount(self.cell, component) / count for component in state.cracks.stress.T], axis=1)
        return np.split(mean, np.cumsum(sizes)[:-1])


def default_width(crack_length: float, concrete: Concrete) -> float:
    """Width of the crack plane in mm where the scene names none: the smaller of 1 % of the crack length and
    0.4 % of E Gf / ft^2. On the built-in beam it costs less than 1 % of the load at small opening and of the
    peak against a vanishing width."""
    return min(WIDTH_OF_CRACK * crack_length, WIDTH_OF_MATERIAL * concrete.characteristic_length)


def interface_part(scene: Scene, mesh: meshio.Mesh) -> CrackPart:
    """Zero-thickness elements along the path."""
    crack, points = mesh.cells[-1], mesh.points
    interface = Interface.from_cells(crack.type, points, crack.data, depth(scene, mesh), scene.interface.quadrature)
    crack_length = _length(scene, interface.area)
    width = scene.interface.width
    if width is None:
        width = default_width(crack_length, scene.material)
    _check_units(scene, crack_length)
    if isinstance(width, str):  # "h"
        width = scene.material.h
    elif not 1e-6 * crack_length <= width <= max(scene.material.h, crack_length):
        raise SceneError(
            f"interface.width = {width:g}: expected between {1e-6 * crack_length:.1e} and "
            f"{max(scene.material.h, crack_length):g} mm"
        )
    law = InterfaceLaw(CrackPlane(scene.material, width), *interface.points.shape)
    n = interface.normals
    return CrackPart(
        law, interface.jump_operator, interface.weights, interface.points, interface.cell, interface.area, width,
        rotations_of(n), interface,
    )  # fmt: skip


def band_part(scene: Scene, mesh: meshio.Mesh, band: Sequence[ElasticBlock]) -> CrackPart:
    """A crack band: quadrilaterals or hexahedra along the path, or all elements."""
    options, d = scene.band, mesh.points.shape[1]
    parts = [block.strain_points(centre_line(_POINTS_ALONG[block.kind], d) if is_row(mesh) else None) for block in band]
    offsets = np.cumsum([0, *(len(block.cells) for block in band)])[:-1]
    cell = np.concatenate([part[3] + offset for part, offset in zip(parts, offsets, strict=True)])
    corners = np.concatenate([block.corners() for block in band])
    weights = np.concatenate([part[1] for part in parts])
    faces = rotations = area = None
    if is_row(mesh):
        block = mesh.cells[-1]
        faces = Interface.from_cells(block.type, mesh.points, block.data, depth(scene, mesh))
        area = faces.area
        width = float(weights.sum()) / area
        first = np.searchsorted(faces.cell, np.arange(len(block.data)))
        n = faces.normals[first][cell]
        rotations = rotations_of(n)
    else:  # each crack will have a length of its own
        volumes = np.concatenate([np.bincount(part[3], part[1]) for part in parts]) / depth(scene, mesh)
        width = float(np.median(np.sqrt(volumes) if d == 2 else np.cbrt(volumes)))
    if not isinstance(scene.specimen, UserMesh):
        area, width = scene.crack_area, scene.band_width
    _check_units(scene, float(np.ptp(mesh.points, axis=0).max()) if area is None else _length(scene, area))
    excess = width / (2.0 * scene.material.characteristic_length)
    if excess > _REFUSE_EXCESS:
        key = "specimen.band: width" if isinstance(scene.specimen, UserMesh) else "band.width"
        raise SceneError(
            f"{key} = {width:g}: a band so wide dissipates {100 * (1 + excess):.0f} % of Gf "
            f"(ft^2 l_ch / 2E is {excess:.2g} Gf); expected less than {2 * scene.material.characteristic_length:.4g} mm"
        )
    law = CrackBand(
        CrackPlane(scene.material, width, shear_scaling=options.shear_scaling), band[0].D, corners[cell],
        options.max_cracks, options.threshold_angle, options.tol,
        None if rotations is None else rotations[:, 0],
    )  # fmt: skip
    where = np.concatenate([part[2] for part in parts])
    return CrackPart(law, sp.vstack([p[0] for p in parts]).tocsr(), weights, where, cell, area, width, rotations, faces)


def depth(scene: Scene, mesh: meshio.Mesh) -> float:
    """What a plane mesh is to be multiplied with, mm: the thickness; 1 in space."""
    if mesh.points.shape[1] == 3:
        return 1.0
    assert scene.specimen.thickness is not None
    return scene.specimen.thickness


def _length(scene: Scene, area: float) -> float:
    """Length of a crack of some area, mm: that of its path or, of a surface in space, the root of its area."""
    thickness = None if isinstance(scene.specimen, SingleCrack3D) else scene.specimen.thickness
    return math.sqrt(area) if thickness is None else area / thickness


def is_row(mesh: meshio.Mesh) -> bool:
    """Whether the mesh ends with a row of elements along a path, quadrilaterals [a-, b-, b+, a+] or hexahedra that begin with
    their minus face."""
    return "row" in (mesh.cell_sets or {})


def centre_line(n: int, d: int = 2) -> Rule:
    """Gauss rule with n points along each axis but the last one, and one across."""
    at, weights = gauss_cube(n, d - 1)
    return np.column_stack([at, np.zeros(len(at))]), 2.0 * weights


def _shear(components: Array) -> Array:
    """The shear component of [normal, shear], (n, 2); in space, where its axes mean nothing, the size of both of them."""
    return np.asarray(components[:, 1] if components.shape[1] == 2 else np.linalg.norm(components[:, 1:], axis=1))


def band_note(scene: Scene, width: float) -> str | None:
    """A warning where the band's width is felt in the energy."""
    excess = width / (2.0 * scene.material.characteristic_length)
    if excess <= _WARN_EXCESS:
        return None
    return (
        f"warning: a band of {width:g} mm dissipates {100 * excess:.1f} % more than Gf (ft^2 l_ch / 2E); "
        f"up to {2 * _WARN_EXCESS * scene.material.characteristic_length:.3g} mm it is below {100 * _WARN_EXCESS:g} %"
    )


def _check_units(scene: Scene, crack_length: float) -> None:
    """Refuse numbers that belong to other units: their ratios are far from any concrete's."""
    m = scene.material
    if not 1e-6 < m.ft / m.E < 1e-2:
        raise SceneError(
            f"material.E = {m.E:g}, material.ft = {m.ft:g}: ft / E = {m.ft / m.E:.1e}; expected about 1e-4, both in MPa"
        )
    if m.Zm > crack_length:
        raise SceneError(
            f"material.Gf = {m.Gf:g}: softening would end at an opening of {m.Zm:.3g} mm, more than the crack's length of "
            f"{crack_length:.3g} mm; expected Gf in N/mm (MPa mm) and lengths in mm"
        )
