"""The elements of a body: elastic ones, those that may crack, and what they weigh."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Array
from ..elements.bulk import ElasticBlock, elasticity
from ..elements.registry import element_in_band
from ..errors import SceneError
from ..scenes.scene import Scene
from .mesh import CrackedMesh


@dataclass(frozen=True)
class Elements:
    """The elements of a body.

    Attributes
    ----------
    elastic : blocks of elements that never crack
    cracking : blocks of elements that may crack, in the smeared model
    thickness : what a 2D mesh is to be multiplied with, mm; 1 in 3D
    densities : of the cells of each block, `elastic` first, kg/m^3
    unit : modulus by which the stiffness of the bulk is divided before it is condensed, MPa, so that another modulus gives
        the same numbers whether it came before or after; 1 if regions have moduli of their own
    of_unit : the elastic blocks with their moduli over `unit`
    """

    elastic: list[ElasticBlock]
    cracking: list[ElasticBlock]
    thickness: float
    densities: list[Array]
    unit: float
    of_unit: list[ElasticBlock]

    @classmethod
    def from_mesh(cls, scene: Scene, mesh: CrackedMesh) -> Elements:
        """The elements of a mesh, each with the elasticity of its region.

        Raises
        ------
        SceneError
            For plane strain of a mesh that is solid.
        """
        thickness, plane = 1.0, None
        if mesh.dimension == 2:
            assert scene.specimen.thickness is not None
            thickness, plane = scene.specimen.thickness, scene.model.plane
        elif scene.model.plane == "strain" and 2 not in scene.specimen.dimensions:
            raise SceneError.at(
                "model.plane", " = 'strain': the mesh is solid; expected no such key, and supports that hold its faces"
            )
        own, regions = scene.material, list(scene.specimen.regions().values())
        densities = np.array([own.density, *(own.density if each.density is None else each.density for each in regions)])
        constants = [(own.E, own.nu), *((each.E, each.nu) for each in regions)]
        moduli = np.stack([elasticity(E, nu, plane) for E, nu in constants])
        points = np.asarray(mesh.points, dtype=float)
        elastic = [
            ElasticBlock(block.type, points, block.data, moduli[region] if region.any() else moduli[0], thickness)
            for block, region in zip(mesh.bulk, mesh.regions, strict=True)
        ]
        cracking = []
        for block in mesh.band:
            kind, columns = element_in_band(block.type) if mesh.is_row else (block.type, list(range(block.data.shape[1])))
            cracking.append(ElasticBlock(kind, points, block.data[:, columns], moduli[0], thickness))
        weights = [densities[region] for region in mesh.regions]
        weights += [np.full(len(block.cells), own.density) for block in cracking]
        if regions:
            return cls(elastic, cracking, thickness, weights, 1.0, elastic)
        of_unit = [replace(block, D=elasticity(1.0, own.nu, plane)) for block in elastic]
        return cls(elastic, cracking, thickness, weights, own.E, of_unit)
