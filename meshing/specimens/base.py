"""What every specimen states: geometry and meshes, supports, drives, gauges, symmetry. It solves nothing."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import meshio

from ..cells import CELLS
from ..errors import MeshError
from ..generation.band import mesh_band
from ..generation.extrusion import check_band_order, mesh_prism, mesh_prism_band, mesh_prism_body
from ..generation.outline import Outline
from ..generation.polygon import mesh_body, mesh_polygon
from ..generation.sizes import SHAPES, MeshSizes, expected_cells
from ..keys import check_keys
from ..paths import Line, Point, segment_lengths
from ..paths import path_length as length_of_path

#: name of a point set of the mesh, or a point that is a node
Location = str | tuple[float, ...]
Direction = tuple[float, ...]

#: name of the gauge that measures `opening` and `sliding`
MAIN_GAUGE = "opening"

#: nodes of tetrahedra, and of triangles, of second order over those of first order
_MORE_IN_TETRAHEDRA, _MORE_IN_TRIANGLES = 7.0, 4.0

#: squares more around a hinge, which triangles, or quadrilaterals, fill
_AT_HINGE = {"triangle": 40.0, "quad": 140.0}

#: normal of the plane strain or stress of an extruded specimen
_ACROSS: Direction = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Support:
    """No motion of some nodes along a direction.

    Parameters
    ----------
    at : Location
    direction : unit vector; None: every direction.
    lever : half the length along x of a face that rotates freely about its centre, mm.
    stiffness : of a support that gives way, N/mm; the nodes then move together. None: it does not.
    """

    at: Location
    direction: Direction | None = None
    lever: float | None = None
    stiffness: float | None = None


@dataclass(frozen=True)
class Drive:
    """Nodes that move together along a direction, from outside; the load acts there.

    Parameters
    ----------
    at : Location
    direction : unit vector
    shear : unit vector at a right angle to it, of a platen that moves both ways; a stage gives its angle.
    lever : as that of a `Support`
    holds_jumps : whether the faces of a crack move together here; None: if there is more than one node.
    share : of the motion of the whole, in one half of it.
    spring : stiffness that resists the motion along `direction` where a stage leaves it free, N/mm.
    against : a second location, on which the opposite force acts; the driven motion is that of `at` against it.
    against_direction : unit vector along which the second location is measured and pushed back; None: `direction`.
    """

    at: Location
    direction: Direction
    shear: Direction | None = None
    lever: float | None = None
    holds_jumps: bool | None = None
    share: float = 1.0
    spring: float = 0.0
    against: Location | None = None
    against_direction: Direction | None = None


@dataclass(frozen=True)
class Pressure:
    """A pressure that stays, on faces of elements.

    Parameters
    ----------
    at : name of a point set; faces all of whose nodes it has
    value : MPa, positive where it presses on the body
    """

    at: str
    value: float


@dataclass(frozen=True)
class Region:
    """Elastic elements with constants of their own.

    Parameters
    ----------
    E : MPa
    nu : Poisson's ratio
    density : kg/m^3; None: that of the material
    """

    E: float
    nu: float
    density: float | None = None


@dataclass(frozen=True)
class Gauge:
    """The motion of a location against another one.

    Parameters
    ----------
    plus, minus : Location; minus None: the mirror image of plus; equal: the two sides of the crack or notch there, plus the
        one that lies along the direction.
    direction : unit vector of the motion; None: the crack's mean normal, from minus to plus.
    """

    plus: Location
    minus: Location | None
    direction: Direction | None = None


class Specimen(ABC):
    """A body with a crack. Its fields are the keys of a scene; errors of the geometry are MeshErrors that name the key."""

    #: dimensions in which it can be modelled; none: a mesh of the user's tells
    dimensions: ClassVar[tuple[int, ...]] = (2,)
    #: shapes of elements, see `MeshSizes`
    shapes: ClassVar[tuple[str, ...]] = tuple(SHAPES)
    #: elements along the crack on the mesh that is chosen by rule
    elements_along: ClassVar[int] = 20
    #: whether [mesh] gives its element sizes
    is_sized: ClassVar[bool] = True
    #: whether an outline describes it, in which crack paths can be found
    has_outline: ClassVar[bool] = False

    thickness: float | None

    def expected_nodes(self, sizes: MeshSizes, *, half: bool = False, dimension: int = 2) -> tuple[float, float]:
        """About how many nodes a mesh will have, in all and on each face of the crack; 0 if that is not known."""
        return 0.0, 0.0

    @abstractmethod
    def mesh(self, sizes: MeshSizes, *, half: bool = False, dimension: int = 2) -> meshio.Mesh:
        """Mesh for a discrete crack: crack cells along the path, as `insert_cracks` gives it."""

    @abstractmethod
    def mesh_band(self, sizes: MeshSizes, width: float, *, half: bool = False, dimension: int = 2) -> meshio.Mesh:
        """Mesh for a crack band of `width` (mm), one element wide along the path."""

    @abstractmethod
    def mesh_body(self, sizes: MeshSizes, *, dimension: int = 2) -> meshio.Mesh:
        """Mesh for cracks that may form anywhere, fine near the path."""

    def check_band(self, sizes: MeshSizes, *, dimension: int = 2) -> None:  # noqa: B027  # all sizes give one
        """A MeshError that names the key, if these sizes give no crack band."""

    @abstractmethod
    def held(self, *, half: bool = False) -> Sequence[Support]:
        """Where it is held."""

    @abstractmethod
    def drives(self, *, half: bool = False) -> Mapping[str, Drive]:
        """Where it is driven, by name; the first is moved unless a stage says otherwise."""

    def gauges(self, *, half: bool = False) -> Mapping[str, Gauge]:
        """Where motions are measured, by name: `MAIN_GAUGE` measures opening and sliding, without it they are the mean jump
        over the crack; each other one has a column of its name."""
        return {}

    @property
    def has_main_gauge(self) -> bool:
        """Whether a gauge measures the opening; if not it is the mean jump over the crack."""
        return MAIN_GAUGE in self.gauges()

    def forces(self) -> Mapping[str, float]:
        """Further forces, by name, as multiples of the load: each has a column of its name."""
        return {}

    def pressures(self) -> Sequence[Pressure]:
        """Pressures on its faces."""
        return []

    def regions(self) -> Mapping[str, Region]:
        """Elastic parts with constants of their own; `cell_data["region"]` of its meshes tells their elements."""
        return {}

    def gravity(self) -> Direction | None:
        """Unit vector along which its weight acts; None: along -y."""
        return None

    def symmetry(self) -> Direction | None:
        """Normal of the plane of the crack about which it is symmetric, so that one half may stand for the whole."""
        return None

    @property
    def paths(self) -> Sequence[Line]:
        """The crack path; empty for a crack that no path describes."""
        return []

    @property
    def crack_area(self) -> float | None:
        """Area of the crack, mm^2; None if only the mesh tells."""
        return None

    @property
    def path_length(self) -> float | None:
        """Length of the crack, mm; None if only the mesh tells."""
        return None if self.crack_area is None else self.crack_length_of(self.crack_area)

    @property
    def notch_depth(self) -> float | None:
        """Depth of the notch that the crack path goes on from, mm, 0 without one; None if one length does not say how far
        the crack has come, as between two notches."""
        return None

    def crack_length_of(self, area: float) -> float:
        """Length of a crack of some area (mm^2), mm: that of its path or, of a surface without one, the root of its area."""
        return math.sqrt(area) if self.thickness is None else area / self.thickness

    @property
    def starts(self) -> Sequence[tuple[Point, Point]]:
        """Ends of the notches, from each of which one crack may grow, and the directions of the notches there."""
        return []

    def is_off_the_notch(self) -> bool:
        """Whether there are notches, and no crack path begins or ends in one."""
        return False

    def held_across(self, plane: str) -> Sequence[Support]:
        """What holds a 2D specimen along its thickness when it is extruded, in plane "strain" or "stress"."""
        return []

    @classmethod
    def without_script(cls, table: dict[str, Any], find: Callable[[str], Path], run_scripts: bool) -> dict[str, Any]:
        """The keys of a specimen with what a script says in place of the script, which is never read again.

        Parameters
        ----------
        find : the place of a file that the keys name
        run_scripts : whether a script may do more than describe a shape, see `meshing.files.geo`
        """
        return table

    def located(self, find: Callable[[str], Path]) -> Specimen:
        """The same specimen, the files that it names found."""
        return self


class PlaneSpecimen(Specimen):
    """A specimen that is given by a plane outline and a thickness, over which it can be extruded.

    Extruded, it lies between z = -thickness/2 and thickness/2, and its point sets run through the thickness. Further sets:
    `back` and `front`, the faces at the smallest and the largest z; `pin`, one node of the back. Shape "quad" stands for
    hexahedra, "triangle" for tetrahedra. With a crack band all cells are hexahedra; those over a triangle of the plane mesh
    have two pairs of equal nodes, which makes them prisms.
    """

    dimensions: ClassVar[tuple[int, ...]] = (2, 3)
    has_outline: ClassVar[bool] = True

    thickness: float
    crack: Any = None

    def __post_init__(self) -> None:
        check_keys(self, MeshError)
        if self.crack is not None:
            object.__setattr__(self, "crack", polylines(self.crack))

    @property
    @abstractmethod
    def paths(self) -> Sequence[Line]:
        """The crack path."""

    @property
    def path_length(self) -> float:
        """Length of the crack path, mm."""
        return length_of_path("crack", self.paths)

    @property
    def crack_area(self) -> float:
        """Area of the crack, mm^2."""
        return self.path_length * self.thickness

    @property
    def tips(self) -> Sequence[Point]:
        """Centres of the notches' ends."""
        return []

    @property
    def starts(self) -> Sequence[tuple[Point, Point]]:
        """The ends of the notches at which a path begins or ends, and the directions of these paths there."""
        ends = []
        for line in self.paths:
            for (x, y), (x1, y1) in ((line[0], line[1]), (line[-1], line[-2])):
                length = math.dist((x, y), (x1, y1))
                if any(math.dist((x, y), tip) < 1e-6 for tip in self.tips):
                    ends.append(((x, y), ((x1 - x) / length, (y1 - y) / length)))
        return ends

    @property
    def hinges(self) -> Sequence[Point]:
        """The end of a crack path that goes on from one notch through the ligament: in the end the halves rotate about it."""
        return [] if self.notch_depth is None else [self.paths[0][-1]]

    def is_off_the_notch(self) -> bool:
        """Whether there are notches, and no crack path begins or ends in one."""
        reach = 1e-6 + getattr(self, "notch_width", 0.0) / 2
        ends = [p for line in self.paths for p in (line[0], line[-1])]
        return bool(self.tips) and all(math.dist(p, tip) > reach for p in ends for tip in self.tips)

    @abstractmethod
    def outline(self, half: bool = False) -> Outline:
        """The geometry, or one half of it."""

    def expected_nodes(self, sizes: MeshSizes, *, half: bool = False, dimension: int = 2) -> tuple[float, float]:
        """About how many nodes a mesh will have, in all and on each face of the crack."""
        outline = self.outline(half)
        length = sum(segment_lengths(outline.crack))
        flat = expected_cells(sizes, outline.area, 0.5 * length if half else length, 2)
        along = length / sizes.crack_size
        cell = sizes.cell_type(2) if dimension == 2 else CELLS[sizes.shape]
        flat += _AT_HINGE[sizes.shape] * len(self.hinges) * (0.5 if half else 1.0)
        flat = flat * cell.density + along
        if dimension == 2:
            return flat, sizes.order * along
        through = sizes.layers_through(self.thickness) + 1
        if sizes.order == 2:
            return _MORE_IN_TETRAHEDRA * flat * through, _MORE_IN_TRIANGLES * along * through
        return flat * through, along * through

    def mesh(self, sizes: MeshSizes, *, half: bool = False, dimension: int = 2) -> meshio.Mesh:
        """Mesh for a discrete crack: crack cells along the path, as `insert_cracks` gives it."""
        outline = replace(self.outline(half), hinges=self.hinges)
        return mesh_prism(outline, sizes, self.thickness) if dimension == 3 else mesh_polygon(outline, sizes)

    def mesh_band(self, sizes: MeshSizes, width: float, *, half: bool = False, dimension: int = 2) -> meshio.Mesh:
        """Mesh for a crack band of `width` (mm), one element wide along the path; see `meshing.mesh_band`."""
        outline = replace(self.outline(half), hinges=self.hinges)
        return mesh_prism_band(outline, sizes, width, self.thickness) if dimension == 3 else mesh_band(outline, sizes, width)

    def check_band(self, sizes: MeshSizes, *, dimension: int = 2) -> None:
        """Extruded bands are of first order."""
        if dimension == 3:
            check_band_order(sizes)

    def mesh_body(self, sizes: MeshSizes, *, dimension: int = 2) -> meshio.Mesh:
        """Mesh for cracks that may form anywhere, fine near the path; see `meshing.mesh_body`."""
        if dimension == 3:
            return mesh_prism_body(self.outline(), sizes, self.thickness)
        return mesh_body(self.outline(), sizes)

    def held_across(self, plane: str) -> Sequence[Support]:
        """Both faces in plane "strain", else one node."""
        return [Support(name, _ACROSS) for name in (("back", "front") if plane == "strain" else ("pin",))]


def expect(specimen: object, name: str, holds: bool, expected: str) -> None:
    """A MeshError that names a key, its value and what was expected, if the latter does not hold."""
    if not holds:
        raise MeshError.at(name, f" = {getattr(specimen, name)!r}: expected {expected}")


def polylines(crack: Any) -> list[Line]:
    """A polyline, or a list of them, as a list of polylines.

    Raises
    ------
    MeshError
        For anything else.
    """
    try:
        nested = isinstance(crack[0][0], (list, tuple))
        lines = [[(float(x), float(y)) for x, y in line] for line in (crack if nested else [crack])]
        if all(math.isfinite(c) for line in lines for p in line for c in p):
            return list(lines)
    except (TypeError, ValueError, IndexError, KeyError):
        pass
    raise MeshError.at("crack", f" = {crack!r}: expected a list of points [[x, y], [x, y], ...], or a list of such lists")


def without_repeats(corners: Sequence[Point]) -> list[Point]:
    """Corners of a polygon, equal neighbours taken once."""
    return [p for p, before in zip(corners, [corners[-1], *corners[:-1]], strict=True) if p != before]
