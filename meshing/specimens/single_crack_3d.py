"""A block with one plane crack at any angle in 3D, through it or inside it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, NoReturn

import meshio
import numpy as np

from ..arrays import Array
from ..cells import CELLS
from ..errors import MeshError
from ..generation.block import PlaneCrack, mesh_block
from ..generation.sizes import SHAPES, MeshSizes, expected_cells
from ..keys import check_keys, key
from .base import Direction, Drive, Gauge, Specimen, Support, expect
from .registry import register_specimen


@register_specimen("single-crack-3d")
@dataclass(frozen=True)
class SingleCrack3D(Specimen):
    """A rectangular block with one plane crack through its centre, moved at its top face.

    Origin in the centre, x along the width, y along the height, z along the thickness. Point sets: the faces `base` and
    `top` (y), `back` and `front` (z); `base_corner`, the edge of the base at the smallest x; `pin`, its node in the back; and
    with a gauge, `gauge_minus` and `gauge_plus` on the crack's normal. Meshes have tetrahedra; there is no crack band.
    """

    width: float = key("width of the block", unit="mm", above=0)
    height: float = key("height of the block", unit="mm", above=0)
    thickness: float = key("thickness of the block", unit="mm", above=0)
    angle: float = key(
        "between the crack's trace in the x-y plane and the base, above -90 and at most 90",
        0.0,
        unit="degrees",
        above=-90,
        at_most=90,
    )
    tilt: float = key(
        "turns the crack about that trace, above -90 and at most 90; 0: at a right angle to the x-y plane",
        0.0,
        unit="degrees",
        above=-90,
        at_most=90,
    )
    crack_radius: float | None = key("of a disc inside the block (a penny-shaped crack)", None, unit="mm")
    crack_length: float | None = key(
        "length of a rectangular crack along the trace; without it and crack_radius: through the block",
        None,
        unit="mm",
    )
    crack_width: float | None = key("width of a rectangular crack across the trace", None, unit="mm")
    notch_radius: float = key(
        "of a disc in the crack's middle that is open from the beginning, a penny-shaped notch; its front lies "
        "inside the crack. 0: none",
        0.0,
        unit="mm",
        at_least=0,
    )
    drive_angle: float = key(
        "between the motion of the top face and its outer normal, in the x-y plane: 0 pulls, 90 shears, 180 pushes",
        0.0,
        unit="degrees",
    )
    faces: str = key(
        "'free' (base and top move freely across the drive, but for one corner of the base) or 'clamped'",
        "free",
        one_of=("free", "clamped"),
    )
    gauge: float = key(
        "length over which the opening is measured across the crack's centre; 0: mean jump over the crack",
        0.0,
        unit="mm",
        at_least=0,
    )

    dimensions: ClassVar[tuple[int, ...]] = (3,)
    shapes: ClassVar[tuple[str, ...]] = tuple(SHAPES)[:1]
    #: twice as many would make an iteration 64 times dearer
    elements_along: ClassVar[int] = 12

    def __post_init__(self) -> None:
        check_keys(self, MeshError)
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

    def expected_nodes(self, sizes: MeshSizes, *, half: bool = False, dimension: int = 3) -> tuple[float, float]:
        """About how many nodes a mesh will have, in all and on each face of the crack."""
        cell = sizes.cell_type(3)
        on_crack = CELLS[cell.facet].density * self.crack_area / sizes.crack_size**2
        return cell.density * expected_cells(sizes, math.prod(self.sides), self.crack_area, 3), on_crack

    def mesh(self, sizes: MeshSizes, *, half: bool = False, dimension: int = 3) -> meshio.Mesh:
        """Mesh for a discrete crack: crack cells on its plane, as `insert_cracks` gives it. There is no half of it."""
        return self._mesh(sizes, conforming=True)

    def mesh_band(self, sizes: MeshSizes, width: float, *, half: bool = False, dimension: int = 3) -> NoReturn:
        """There is none: a MeshError."""
        self.check_band(sizes)

    def check_band(self, sizes: MeshSizes, *, dimension: int = 3) -> NoReturn:
        """There is none: a MeshError."""
        raise MeshError.at(
            "band.where",
            " = 'path': there is no crack band for a crack at any angle in space; expected 'everywhere', or an "
            "extruded specimen",
        )

    def mesh_body(self, sizes: MeshSizes, *, dimension: int = 3) -> meshio.Mesh:
        """Mesh for cracks that may form anywhere, fine near the crack's plane."""
        return self._mesh(sizes, conforming=False)

    def crack_length_of(self, area: float) -> float:
        """Root of the area: no path gives a length, mm."""
        return math.sqrt(area)

    @property
    def drive_directions(self) -> tuple[Direction, Direction, Direction]:
        """The motion of the top face, and the two directions across it."""
        t = math.radians(self.drive_angle)
        x, y = math.sin(t), math.cos(t)
        return (x, y, 0.0), (y, -x, 0.0), (0.0, 0.0, 1.0)

    def held(self, *, half: bool = False) -> list[Support]:
        """The base along the drive; across it an edge and a node of the base, or both faces if they are clamped."""
        along, across, normal = self.drive_directions
        if self.faces == "free":
            return [Support("base", along), Support("base_corner", across), Support("pin", normal)]
        return [Support("base", along), *(Support(name, d) for d in (across, normal) for name in ("base", "top"))]

    def drives(self, *, half: bool = False) -> Mapping[str, Drive]:
        """The top face."""
        return {"top": Drive("top", self.drive_directions[0])}

    def gauges(self, *, half: bool = False) -> Mapping[str, Gauge]:
        """The opening across the crack's centre."""
        return {"opening": Gauge("gauge_plus", "gauge_minus")} if self.gauge else {}
