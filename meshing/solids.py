"""Parametric solid specimens, meshed with their crack surface inserted. Lengths in mm, angles in degrees."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NoReturn

import meshio
import numpy as np
from numpy.typing import NDArray

from .base import PlaneSpecimen, Specimen, at_least_zero, expect, positive
from .block import PlaneCrack, mesh_block
from .errors import MeshError
from .extrusion import check_band_order, mesh_prism, mesh_prism_band, mesh_prism_body
from .sizes import MeshSizes
from .specimens import NotchedBeam, PushOff

Array = NDArray[np.float64]


class Extruded(PlaneSpecimen):
    """A plane specimen extruded over its thickness, z from -thickness/2 to thickness/2.

    The point sets of the plane specimen run through the thickness. Further sets: `back` and `front`, the faces at the
    smallest and the largest z; `pin`, one node of the back. The sizes give the shape, "quad" for hexahedra and "triangle" for
    tetrahedra, and the number of layers. With a crack band all cells are hexahedra; those over a triangle of the plane mesh
    have two pairs of equal nodes, which makes them prisms.
    """

    thickness: float

    def mesh(self, sizes: MeshSizes, half: bool = False) -> meshio.Mesh:
        """Mesh for a discrete crack: crack cells along the path; see `meshing.extrusion.mesh_prism`."""
        return mesh_prism(self.outline(half), sizes, self.thickness)

    def mesh_band(self, sizes: MeshSizes, width: float) -> meshio.Mesh:
        """Mesh for a crack band of `width` (mm), one element wide; see `meshing.extrusion.mesh_prism_band`."""
        return mesh_prism_band(self.outline(), sizes, width, self.thickness)

    def check_band(self, sizes: MeshSizes) -> None:
        """Refuse second order; MeshError."""
        check_band_order(sizes)

    def mesh_body(self, sizes: MeshSizes) -> meshio.Mesh:
        """Mesh for cracks that may form anywhere, fine near the path; see `meshing.extrusion.mesh_prism_body`."""
        return mesh_prism_body(self.outline(), sizes, self.thickness)


@dataclass(frozen=True)
class NotchedBeam3D(Extruded, NotchedBeam):
    """The notched beam in three dimensions: `NotchedBeam`, with the same keys, extruded over its thickness.

    Supports, load and gauge points are lines through the thickness. See `Extruded` for the mesh and further sets.
    """


@dataclass(frozen=True)
class PushOff3D(Extruded, PushOff):
    """The push-off test in three dimensions: `PushOff`, with the same keys, extruded over its thickness.

    Jefferson and Mihai (2015), Example 4: a shear plane of width x thickness = 300 x 120 mm. `base` and `top` are the whole
    faces. See `Extruded` for the mesh and further sets.
    """


@dataclass(frozen=True)
class SingleCrack3D(Specimen):
    """A rectangular block with one plane crack through its centre, moved at its top face.

    Origin in the centre, x along the width, y along the height, z along the thickness. Point sets: the faces `base` and
    `top` (y), `back` and `front` (z); `base_corner`, the edge of the base at the smallest x; `pin`, its node in the back; and
    with a gauge, `gauge_minus` and `gauge_plus` on the crack's normal. Meshes have tetrahedra; there is no crack band.

    Parameters
    ----------
    width, height, thickness : of the block.
    angle : between the crack's trace in the x-y plane and the base, above -90 and at most 90.
    tilt : turns the crack about that trace, above -90 and at most 90; 0: at a right angle to the x-y plane.
    crack_radius : of a disc inside the block (a penny-shaped crack).
    crack_length, crack_width : of a rectangle, along the trace and across it. Both None and no radius: through the whole
        block; one of them: a strip with two straight fronts.
    notch_radius : of a disc in the crack's middle that is open from the beginning, a penny-shaped notch; its front lies
        inside the crack. 0: none.
    drive_angle : between the motion of the top face and its outer normal, in the x-y plane: 0 pulls, 90 shears, 180 pushes.
    faces : "free" (base and top move freely across the drive, but for one corner of the base) or "clamped".
    gauge : length over which the opening is measured across the crack's centre; 0: mean jump over the crack.
    """

    width: float
    height: float
    thickness: float
    angle: float = 0.0
    tilt: float = 0.0
    crack_radius: float | None = None
    crack_length: float | None = None
    crack_width: float | None = None
    notch_radius: float = 0.0
    drive_angle: float = 0.0
    faces: str = "free"
    gauge: float = 0.0

    is_symmetric = False

    def __post_init__(self) -> None:
        positive(self, "width", "height", "thickness")
        at_least_zero(self, "gauge", "notch_radius")
        for name in ("angle", "tilt"):
            expect(self, name, -90 < getattr(self, name) <= 90, "above -90 and at most 90 degrees")
        expect(self, "faces", self.faces in ("free", "clamped"), "'free' or 'clamped'")
        expect(self, "gauge", self.gauge < min(self.sides), "less than width, height and thickness")
        if self.crack_radius is not None:
            for name in ("crack_length", "crack_width"):
                expect(self, name, getattr(self, name) is None, f"none beside crack_radius = {self.crack_radius:g}")
            self._below("crack_radius", self._reach)
        for name, axis, other in (
            ("crack_length", self.crack.along, self.crack.across * (self.crack_width or 0.0) / 2),
            ("crack_width", self.crack.across, 0.0 * self.crack.across),
        ):
            room = (self._half - abs(other)) / np.maximum(abs(axis), 1e-12)
            self._below(name, 2 * float(room.min()))
        reach = min(
            self._reach if self.crack_radius is None else self.crack_radius,
            (self.crack_length or math.inf) / 2,
            (self.crack_width or math.inf) / 2,
        )
        expect(self, "notch_radius", self.notch_radius < reach, f"at least 0 and below {reach:g}, to end inside the crack")

    @property
    def _reach(self) -> float:
        """Radius of the largest disc in the crack's plane that is inside the block."""
        return float((self._half / np.sqrt(np.maximum(1 - self.crack.normal**2, 1e-12))).min())

    def _below(self, name: str, limit: float) -> None:
        if getattr(self, name) is not None:
            inside = f"above 0 and below {limit:g}" if limit > 0 else "a smaller crack_width beside it"
            expect(self, name, 0 < getattr(self, name) < limit, f"{inside}, to end inside the block")

    @property
    def sides(self) -> tuple[float, float, float]:
        """Of the block."""
        return self.width, self.height, self.thickness

    @property
    def _half(self) -> Array:
        return np.array(self.sides) / 2

    @property
    def crack(self) -> PlaneCrack:
        """The crack's plane and shape."""
        a, t = math.radians(self.angle), math.radians(self.tilt)
        along = np.array([math.cos(a), math.sin(a), 0.0])
        across = np.array([-math.sin(a) * math.sin(t), math.cos(a) * math.sin(t), -math.cos(t)])
        length, width = (math.inf if side is None else side for side in (self.crack_length, self.crack_width))
        return PlaneCrack(along, across, length, width, self.crack_radius, self.notch_radius)

    @property
    def normal(self) -> Array:
        """Unit normal of the crack towards its plus side."""
        return self.crack.normal

    @property
    def crack_area(self) -> float:
        """Of the crack without its notch, mm^2."""
        return self.crack.area(self._half)

    def _mesh(self, sizes: MeshSizes, conforming: bool) -> meshio.Mesh:
        nodes = {}
        if self.gauge:
            x, y, z = (self.gauge / 2 * self.normal).tolist()
            nodes = {"gauge_minus": (-x, -y, -z), "gauge_plus": (x, y, z)}
        return mesh_block(self.sides, self.crack, sizes, nodes, conforming)

    def mesh(self, sizes: MeshSizes, half: bool = False) -> meshio.Mesh:
        """Mesh for a discrete crack: crack cells on its plane, as `insert_cracks` gives it. There is no half of it."""
        return self._mesh(sizes, conforming=True)

    def mesh_band(self, sizes: MeshSizes, width: float) -> NoReturn:
        """There is none: a MeshError."""
        self.check_band(sizes)

    def check_band(self, sizes: MeshSizes) -> NoReturn:
        """There is none: a MeshError."""
        raise MeshError(
            "band.where = 'path': there is no crack band for a crack at any angle in space; expected 'everywhere', or an "
            "extruded specimen"
        )

    def mesh_body(self, sizes: MeshSizes) -> meshio.Mesh:
        """Mesh for cracks that may form anywhere, fine near the crack's plane."""
        return self._mesh(sizes, conforming=False)
