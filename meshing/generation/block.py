"""A rectangular block with one plane crack at any angle, through it or with its crack front inside: tetrahedra by gmsh."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import ModuleType

import meshio
import numpy as np

from ..arrays import Array, Index
from ..cutting.insertion import cut_slits, insert_cracks
from ..errors import MeshError
from ..paths import SLACK
from .polygon import nearest
from .refinement import with_mid_nodes
from .session import add_face, collect, session, size_field
from .sizes import MeshSizes, check_count, check_not_layered

#: more elements on a crack, or in a body, than a machine holds
_MOST_ON_CRACK, _MOST_IN_ALL = 1e5, 5e6


@dataclass(frozen=True)
class PlaneCrack:
    """A plane crack around the origin. Lengths in mm.

    Parameters
    ----------
    along, across : (3,) unit vectors in its plane, at a right angle; the normal towards the plus side is along x across.
    length, width : of a rectangle with sides along and across; infinity: through the body.
    radius : of a disc instead.
    notch_radius : of the disc in its middle that is open from the beginning; 0: none.
    """

    along: Array
    across: Array
    length: float = math.inf
    width: float = math.inf
    radius: float | None = None
    notch_radius: float = 0.0

    @property
    def normal(self) -> Array:
        """Unit normal towards the plus side."""
        return np.asarray(np.cross(self.along, self.across))

    def outline(self, half: Array) -> Array:
        """Corners of the part of the rectangle inside a box with these half sides, (k, 3)."""
        reach = 4.0 * float(np.linalg.norm(half))
        a, b = (min(side, reach) / 2 * axis for side, axis in ((self.length, self.along), (self.width, self.across)))
        polygon = np.array([-a - b, a - b, a + b, -a + b])
        for axis in range(3):
            for sign in (1.0, -1.0):
                polygon = _part_above(polygon, half[axis] - sign * polygon[:, axis])
        apart = np.linalg.norm(polygon - np.roll(polygon, 1, axis=0), axis=1) > SLACK * half.max()
        return np.asarray(polygon[apart])

    def area(self, half: Array) -> float:
        """Area of the part inside a box with these half sides, without the notch, mm^2."""
        notch = math.pi * self.notch_radius**2
        if self.radius is not None:
            return math.pi * self.radius**2 - notch
        polygon = self.outline(half)
        return 0.5 * abs(float(np.cross(polygon, np.roll(polygon, -1, axis=0)).sum(axis=0) @ self.normal)) - notch

    def distance(self) -> str:
        """Distance from the crack, the notch included, as an expression of gmsh."""
        u, v, n = (
            f"(({a!r})*x + ({b!r})*y + ({c!r})*z)" for a, b, c in np.stack([self.along, self.across, self.normal]).tolist()
        )
        parts = [f"Max(Abs({w}) - {side / 2!r}, 0)^2" for w, side in ((u, self.length), (v, self.width)) if side < math.inf]
        if self.radius is not None:
            parts = [f"Max(Sqrt({u}^2 + {v}^2) - {self.radius!r}, 0)^2"]
        return f"Sqrt({' + '.join([*parts, f'{n}^2'])})"


def _part_above(polygon: Array, height: Array) -> Array:
    """Corners of the part of a convex polygon (k, d) on which a linear function, (k,) at the corners, is not negative."""
    kept = []
    for i in range(len(polygon)):
        if (height[i] < 0) != (height[i - 1] < 0):
            share = height[i] / (height[i] - height[i - 1])
            kept.append(polygon[i] + share * (polygon[i - 1] - polygon[i]))
        if height[i] >= 0:
            kept.append(polygon[i])
    return np.array(kept).reshape(-1, polygon.shape[1])


def mesh_block(
    sides: tuple[float, float, float],
    crack: PlaneCrack,
    sizes: MeshSizes,
    nodes: Mapping[str, tuple[float, float, float]] | None = None,
    conforming: bool = True,
) -> meshio.Mesh:
    """Mesh a block around the origin and cut it along its crack, or along the notch only, for cracks that may form anywhere.

    Parameters
    ----------
    sides : in x, y, z, mm.
    crack : PlaneCrack
    sizes : MeshSizes, of shape "triangle"
    nodes : points that must be nodes, by the name of the point set they end up in.
    conforming : whether there are crack cells.

    Returns
    -------
    meshio.Mesh
        Tetrahedra, as `insert_cracks` gives them, or as `cut_slits` does. Point sets besides `nodes`: `base` and `top`, the
        faces at the smallest and the largest y; `back` and `front`, at the smallest and the largest z; `base_corner`, the
        edge of the base at the smallest x; `pin`, its node in the back.

    Raises
    ------
    MeshError
        Naming the key of sizes that does not fit, or the point outside the body.
    """
    if sizes.has_quads:
        raise MeshError.at("mesh.shape", f" = '{sizes.shape}': this specimen is of tetrahedra; expected 'triangle'")
    half = np.array(sides) / 2
    check_not_layered(sizes)
    check_count("crack_size", sizes.crack_size, "on the crack", crack.area(half), 2, _MOST_ON_CRACK)
    check_count("far_size", sizes.far_size, "in the body", math.prod(sides), 3, _MOST_IN_ALL)
    with session() as gmsh:
        occ = gmsh.model.occ
        box = (3, occ.addBox(*(-half), *sides))
        notch = [_add_disc(gmsh, crack, crack.notch_radius)] if crack.notch_radius else []
        surface = []
        if conforming:
            surface = [add_face(gmsh, crack.outline(half)) if crack.radius is None else _add_disc(gmsh, crack, crack.radius)]
        tools = [*notch, *surface, *((0, occ.addPoint(*p)) for p in (nodes or {}).values())]
        image = occ.fragment([box], tools)[1] if tools else [[box]]
        occ.synchronize()
        size_field(gmsh, crack.distance(), sizes.crack_size, sizes.far_size)
        gmsh.model.mesh.generate(3)
        opened = [face for faces in image[1 : 1 + len(notch)] for face in faces]
        faces = [face for faces in image[1 + len(notch) :][: len(surface)] for face in faces if face not in opened]
        mesh = collect(gmsh, [*opened, *faces], dimension=3)
    triangles = [block.data for block in mesh.cells if block.dim == 2]
    slit, cut = (
        facing(mesh.points, np.concatenate([np.empty((0, 3), dtype=np.int64), *some]), crack.normal)
        for some in (triangles[: len(opened)], triangles[len(opened) :])
    )
    mesh.cells = [block for block in mesh.cells if block.dim == 3]
    mesh.point_sets = {name: np.array([nearest(mesh, name, p)]) for name, p in (nodes or {}).items()}
    mesh.point_sets |= _faces_of_block(mesh.points, half)
    if sizes.order == 2:
        mesh = with_mid_nodes(mesh)
    return insert_cracks(mesh, cut, slit) if conforming else cut_slits(mesh, slit)


def _faces_of_block(points: Array, half: Array) -> dict[str, Index]:
    """The point sets on the faces of a block, by name; see `mesh_block`."""
    slack = 2 * SLACK * half.max()
    lowest = abs(points + half) < slack
    return {
        "base": np.flatnonzero(lowest[:, 1]),
        "top": np.flatnonzero(points[:, 1] > half[1] - slack),
        "back": np.flatnonzero(lowest[:, 2]),
        "front": np.flatnonzero(points[:, 2] > half[2] - slack),
        "base_corner": np.flatnonzero(lowest[:, :2].all(axis=1)),
        "pin": np.flatnonzero(lowest.all(axis=1)),
    }


def facing(points: Array, triangles: Index, normal: Array) -> Index:
    """Triangles, flipped if need be so that their normals point along a direction; gmsh promises none."""
    a, b, c = (points[triangles[:, i]] for i in range(3))
    against = np.cross(b - a, c - a) @ normal < 0
    return np.where(against[:, None], triangles[:, ::-1], triangles)


def _add_disc(gmsh: ModuleType, crack: PlaneCrack, radius: float) -> tuple[int, int]:
    """A disc around the origin in the crack's plane in gmsh: (2, tag)."""
    return (2, gmsh.model.occ.addDisk(0, 0, 0, radius, radius, zAxis=crack.normal, xAxis=crack.along))
