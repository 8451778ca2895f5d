"""A mesh file of the user's with its crack, supports and drive."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import meshio
import numpy as np

from ..band_files import read_band_mesh
from ..errors import MeshError
from ..files import read_mesh
from ..keys import check_keys, key
from ..paths import Line
from ..sizes import MeshSizes
from .base import Direction, Drive, Gauge, Location, Specimen, Support, polylines
from .registry import register_specimen


@register_specimen("mesh")
@dataclass(frozen=True)
class UserMesh(Specimen):
    """A mesh file of the user's, 2D or 3D, with its crack, supports and drive.

    A location is the name of a set of the file, or a point [x, y] that is a node; in 3D points and directions have three
    numbers.
    """

    file: str = key("mesh in any format that meshio reads, lengths in mm; relative to the scene file")
    crack: Any = key(
        "name of a set of line cells or nodes on the path, or a polyline (or a list of them) along element edges; in 3D, name "
        "of a set of triangles or quadrilaterals on the crack surface, or of its nodes"
    )
    supports: Any = key("list of {at = location, direction = [x, y]}: no motion of these nodes along the direction")
    drive: Any = key("{at = location, direction = [x, y]}: these nodes move together along the direction")
    thickness: float | None = key("thickness of a 2D mesh; a 3D one has none", None, unit="mm", above=0)
    gauge_minus: Any = key(
        "location from which the opening is measured, positive where gauge_plus parts from it; default: the mean jump over "
        "the crack, or over a band that is a row of quadrilaterals",
        None,
    )
    gauge_plus: Any = key("location to which the opening is measured", None)
    band: str | None = key(
        "name of the set of elements that form the crack band of the smeared model with band.where = 'path'. A row of "
        "quadrilaterals, one element wide, is treated as that of a built-in specimen; in any other set of elements the crack "
        "may form as with 'everywhere'",
        None,
    )

    dimensions: ClassVar[tuple[int, ...]] = ()
    is_sized: ClassVar[bool] = False

    def __post_init__(self) -> None:
        check_keys(self, MeshError)
        if not isinstance(self.crack, str):
            object.__setattr__(self, "crack", polylines(self.crack))
        if not isinstance(self.supports, list) or not self.supports:
            raise MeshError(f"supports = {self.supports!r}: expected a list of {{at = ..., direction = [x, y]}}", "supports")
        object.__setattr__(self, "supports", [_motion("supports", entry) for entry in self.supports])
        object.__setattr__(self, "drive", _motion("drive", self.drive))
        if (self.gauge_minus is None) != (self.gauge_plus is None):
            raise MeshError("gauge_minus, gauge_plus: expected both or none", "gauge_minus")
        for name in ("gauge_minus", "gauge_plus"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, _location(name, getattr(self, name)))

    def located(self, find: Callable[[str], Path]) -> UserMesh:
        """The same specimen, its file found."""
        found = copy.copy(self)
        object.__setattr__(found, "file", str(find(self.file)))
        return found

    @property
    def paths(self) -> list[Line]:
        """The crack path; empty for a named set."""
        return [] if isinstance(self.crack, str) else self.crack

    def mesh(self, sizes: MeshSizes | None = None, *, half: bool = False, dimension: int = 2) -> meshio.Mesh:
        """The file with its crack inserted, see `meshing.files.read_mesh`."""
        return self._checked(read_mesh(self.file, self.crack))

    def mesh_band(self, sizes: MeshSizes | None = None, width: float | None = None, *, dimension: int = 2) -> meshio.Mesh:
        """The file with its band, see `meshing.band_files.read_band_mesh`."""
        if self.band is None:
            raise MeshError(
                "band is missing: expected the name of the set of elements that form the band, or band.where = 'everywhere'",
                "band",
            )
        return self._checked(read_band_mesh(self.file, self.band, self._along))

    def mesh_body(self, sizes: MeshSizes | None = None, *, dimension: int = 2) -> meshio.Mesh:
        """The file as it is: cracks may form in all of its elements."""
        return self._checked(read_band_mesh(self.file, None, self._along))

    @property
    def _along(self) -> Any:
        """Direction of the path, from end to end."""
        return None if isinstance(self.crack, str) else np.subtract(self.crack[0][-1], self.crack[0][0])

    def _checked(self, mesh: meshio.Mesh) -> meshio.Mesh:
        is_solid = mesh.points.shape[1] == 3
        if not is_solid and self.thickness is None:
            raise MeshError("thickness is missing: the mesh is plane", "thickness")
        if is_solid and self.thickness is not None:
            raise MeshError(f"thickness = {self.thickness:g}: the mesh is solid; expected no thickness", "thickness")
        return mesh

    def held(self, *, half: bool = False) -> list[Support]:
        """As the key `supports` says."""
        return [Support(at, direction) for at, direction in self.supports]

    def drives(self, *, half: bool = False) -> Mapping[str, Drive]:
        """As the key `drive` says."""
        return {"drive": Drive(*self.drive)}

    def gauges(self, *, half: bool = False) -> Mapping[str, Gauge]:
        """As the keys `gauge_minus` and `gauge_plus` say."""
        return {} if self.gauge_plus is None else {"opening": Gauge(self.gauge_plus, self.gauge_minus)}


def _location(name: str, value: Any) -> Location:
    if isinstance(value, str):
        return value
    return _vector(name, value, "the name of a set or a point [x, y], in space [x, y, z]")


def _vector(name: str, value: Any, expected: str) -> Direction:
    try:
        components = tuple(float(c) for c in value)
    except (TypeError, ValueError):
        raise MeshError(f"{name} = {value!r}: expected {expected}", name) from None
    if len(components) not in (2, 3) or not all(math.isfinite(c) for c in components):
        raise MeshError(f"{name} = {value!r}: expected {expected}", name)
    return components


def _motion(name: str, entry: Any) -> tuple[Location, Direction]:
    """{at, direction} as a location and a unit vector."""
    if not isinstance(entry, dict) or set(entry) != {"at", "direction"}:
        raise MeshError(f"{name} = {entry!r}: expected {{at = ..., direction = [x, y]}}", name)
    direction = _vector(f"{name}.direction", entry["direction"], "two numbers [x, y], in space three")
    length = math.hypot(*direction)
    if not length > 0:
        raise MeshError(f"{name}.direction = {entry['direction']!r}: expected a vector that is not zero", name)
    return _location(f"{name}.at", entry["at"]), tuple(c / length for c in direction)
