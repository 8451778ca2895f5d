"""A mesh with its crack or crack band, by the parts that a model asks for."""

from __future__ import annotations

from dataclasses import dataclass

import meshio
import numpy as np

from meshing.cells import CELLS
from meshing.cutting.insertion import crack_front_length
from meshing.specimens import Specimen

from ..arrays import Array, Index
from ..scenes.scene import Scene
from .estimate import check_fits


@dataclass(frozen=True)
class CrackedMesh:
    """The cells of a mesh by what they do.

    Attributes
    ----------
    whole : meshio.Mesh of all of them, in the order of `bulk`, then `crack` or `band`
    bulk : blocks of elastic elements
    crack : block of zero-thickness cells between the two faces of the crack; None in the smeared model
    band : blocks of elements that may crack, in the smeared model
    is_row : whether the band is one block of elements along the path, one element wide, that begin with their minus face
    """

    whole: meshio.Mesh
    bulk: list[meshio.CellBlock]
    crack: meshio.CellBlock | None
    band: list[meshio.CellBlock]
    is_row: bool

    @classmethod
    def from_mesh(cls, mesh: meshio.Mesh) -> CrackedMesh:
        """By the cell sets `crack`, or `band` and `row`, of the mesh; without either all elements may crack."""
        sets = mesh.cell_sets or {}
        if "crack" in sets:
            return cls(mesh, mesh.cells[:-1], mesh.cells[-1], [], False)
        if "band" not in sets:
            return cls(mesh, [], None, mesh.cells, False)
        in_band = [bool(len(at)) for at in sets["band"]]
        bulk, band = ([b for b, at in zip(mesh.cells, in_band, strict=True) if at is wanted] for wanted in (False, True))
        return cls(mesh, bulk, None, band, "row" in sets)

    @property
    def points(self) -> Array:
        """Coordinates of the nodes, (m, d), mm."""
        points: Array = self.whole.points
        return points

    @property
    def closed(self) -> Array:
        """The same before a band was opened along its path: its two faces lie on the path, which has their normals there."""
        points: Array = (self.whole.point_data or {}).get("closed", self.whole.points)
        return points

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return int(self.points.shape[1])

    @property
    def extent(self) -> float:
        """Longest side of the box around the body, mm."""
        return float(np.ptp(self.points, axis=0).max())

    @property
    def sets(self) -> dict[str, Index]:
        """Nodes by name."""
        sets: dict[str, Index] = self.whole.point_sets
        return sets

    @property
    def original(self) -> Index:
        """Number of each node before the crack was inserted, (m,)."""
        original: Index = self.whole.point_data["original"]
        return original

    @property
    def remarks(self) -> list[str]:
        """Sentences on what is odd about a user mesh."""
        return list((self.whole.info or {}).get("remarks", ()))

    @property
    def representative(self) -> Index:
        """For the copies of a node on the crack the one of them that names the group, for every other node itself, (m,); the
        faces of a band are no copies of each other, but for those that mirror the ones of a half."""
        nodes = np.arange(len(self.points))
        if self.crack is not None:
            on_crack = np.isin(self.original, self.original[self.crack.data])
        elif self.is_row:
            on_crack = np.isin(nodes, self.band[0].data)
            for block in self.bulk:
                on_crack[block.data] = False
        else:
            return nodes
        return np.where(on_crack, self.original, nodes)

    @property
    def regions(self) -> list[Index]:
        """For the cells of each block of the bulk 0 or, in a region with elastic constants of its own, 1 + its index."""
        numbers = (self.whole.cell_data or {}).get("region")
        if numbers is None:
            return [np.zeros(len(block.data), dtype=np.int64) for block in self.bulk]
        return list(numbers[: len(self.bulk)])

    @property
    def faces(self) -> meshio.CellBlock | None:
        """Cells with a minus and a plus face along the path: the crack, or a band that is a row; None if there are none."""
        return self.band[0] if self.is_row else self.crack

    @property
    def beside_normals(self) -> Array | None:
        """Unit normals of the crack beside which the cells of the band lie, (n, d); None if there is no crack in a file or the
        band is a row, whose `faces` tell."""
        normals = (self.whole.cell_data or {}).get("normal")
        return None if normals is None else np.concatenate(normals[len(self.bulk) :])

    @property
    def minus_faces(self) -> Index:
        """Corner nodes of the minus faces along the path, (n, k)."""
        assert self.faces is not None
        corners: Index = self.faces.data[:, : CELLS[self.faces.type].facet_corners]
        return corners

    @property
    def crack_front(self) -> float:
        """Length of the edge of a crack surface inside the body, mm; 0 in 2D and in a band."""
        return 0.0 if self.crack is None else crack_front_length(self.whole)


def cracked_mesh(scene: Scene) -> CrackedMesh:
    """Mesh the specimen of a scene for its model.

    Raises
    ------
    SceneError, MeshError
        Naming the key or the entity, its value and what was expected.
    """
    check_fits(scene)
    specimen: Specimen = scene.specimen
    sizes, dimension = scene.sizes, scene.dimension
    if scene.model.kind == "discrete":
        mesh = specimen.mesh(sizes, half=scene.model.half, dimension=dimension)  # type: ignore[arg-type]
    elif scene.band.where == "everywhere":
        mesh = specimen.mesh_body(sizes, dimension=dimension)  # type: ignore[arg-type]
    else:
        width = scene.band_width if sizes is not None else scene.band.width
        mesh = specimen.mesh_band(sizes, width, half=scene.model.half, dimension=dimension)  # type: ignore[arg-type]
    return CrackedMesh.from_mesh(mesh)
