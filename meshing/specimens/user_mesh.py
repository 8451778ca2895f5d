"""A mesh file of the user's with its crack, supports and drive."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import meshio
import numpy as np

from ..cutting.opening import open_cracks
from ..errors import MeshError
from ..files.bands import read_band_mesh
from ..files.boundary import boundary_outline
from ..files.reading import read_mesh
from ..generation.sizes import MeshSizes
from ..keys import check_keys, key
from ..paths import Line
from .base import MAIN_GAUGE, Direction, Gauge, Pressure, Region, polylines
from .own_outline import stated
from .registry import register_specimen
from .user_entries import StatedSetup, are_names, pressures_of, regions_of, unit_vector


@register_specimen("mesh")
@dataclass(frozen=True)
class UserMesh(StatedSetup):
    """A mesh file of the user's, 2D or 3D, with its crack, supports and drive.

    A location is the name of a set of the file, or a point [x, y] that is a node; in 3D points and directions have three
    numbers.
    """

    file: str = key("mesh in any format that meshio reads, lengths in mm; relative to the scene file")
    crack: Any = key(
        "name of a set of line cells or nodes on the path, or a polyline (or a list of them) along element edges; in 3D, name "
        "of a set of triangles or quadrilaterals on the crack surface, or of its nodes; or a list of such names; or 'grow' "
        "with a plane mesh, whose boundary and sets become those of a body of kind 'outline', which is meshed again"
    )
    supports: Any = key(
        "list of {at = location, direction = [x, y]}: no motion of these nodes along the direction; with stiffness = N/mm "
        "they move together and the support gives way"
    )
    drive: Any = key(
        "{at = location, direction = [x, y]}: these nodes move together along the direction; with against = location the "
        "opposite force acts there, and the driven motion is that of the one against the other",
        None,
    )
    drives_: Any = key(
        "instead of drive, several: list of {name = ..., at = location, direction = [x, y]}, each also with against; a stage "
        "moves one of them, at first the first one",
        None,
    )
    thickness: float | None = key("thickness of a 2D mesh; a 3D one has none", None, unit="mm", above=0)
    gauge_minus: Any = key(
        "location from which the opening is measured, positive where gauge_plus parts from it; default: the mean jump over "
        "the crack, or over a band that is a row of quadrilaterals",
        None,
    )
    gauge_plus: Any = key("location to which the opening is measured", None)
    gauges_: Any = key(
        "further gauges, {name = {plus = location, minus = location, direction = [x, y]}}: the motion of plus against minus, "
        "along the crack's mean normal if there is no direction; one location for both: its two sides across the crack. Each "
        "is a column, a control and a quantity of until and unload",
        None,
    )
    band: str | None = key(
        "name of the set of elements that form the crack band of the smeared model with band.where = 'path'. A row of "
        "quadrilaterals, one element wide, is treated as that of a built-in specimen; in any other set of elements the crack "
        "may form as with 'everywhere'. Default: the crack, opened by the width of the band; in 3D the elements that touch it "
        "from its plus side",
        None,
    )

    regions_: Any = key(
        "{name = {E = MPa, nu = number, density = kg/m^3}} for sets of elements that have elastic constants of their own and "
        "never crack; density if it is not that of the material",
        None,
    )
    pressures_: Any = key(
        "list of {at = set of nodes, value = MPa}: a pressure on the faces between these nodes, before the first stage and on",
        None,
    )
    down: Any = key("direction in which the weight acts, with material.density; default: along -y", None)

    dimensions: ClassVar[tuple[int, ...]] = ()
    is_sized: ClassVar[bool] = False

    def __post_init__(self) -> None:
        check_keys(self, MeshError)
        if not isinstance(self.crack, str) and not are_names(self.crack):
            object.__setattr__(self, "crack", polylines(self.crack))
        self.read_setup()
        for name, value in (
            ("regions_", regions_of(self.regions_)),
            ("pressures_", pressures_of(self.pressures_)),
            ("down", None if self.down is None else unit_vector("down", self.down)),
        ):
            object.__setattr__(self, name, value)

    @classmethod
    def without_script(cls, table: dict[str, Any], find: Callable[[str], Path], run_scripts: bool) -> dict[str, Any]:
        """The keys of an outline in place of a mesh in which a crack grows."""
        if table.get("crack") != "grow" or not isinstance(table.get("file"), str):
            return table
        keys = [name for name in ("band", "regions", "pressures", "down") if name in table]
        if keys:
            raise MeshError.at(keys[0], ": a body in which a crack grows is meshed again; expected no such key")
        shape = boundary_outline(find(table["file"]), _named(list(table.values())))
        kept = {key: value for key, value in table.items() if key not in ("kind", "file")}
        return {"kind": "outline"} | kept | stated(shape, {})

    def located(self, find: Callable[[str], Path]) -> UserMesh:
        """The same specimen, its file found."""
        specimen = copy.copy(self)
        object.__setattr__(specimen, "file", str(find(self.file)))
        return specimen

    @property
    def paths(self) -> list[Line]:
        """The crack path; empty for a named set."""
        return [] if self._is_named else self.crack

    @property
    def _is_named(self) -> bool:
        return isinstance(self.crack, str) or are_names(self.crack)

    def mesh(self, sizes: MeshSizes | None = None, *, half: bool = False, dimension: int = 2) -> meshio.Mesh:
        """The file with its crack inserted, see `meshing.read_mesh`."""
        return self._checked(read_mesh(self.file, self.crack, list(self.regions_)))

    def mesh_band(
        self, sizes: MeshSizes | None = None, width: float | None = None, *, half: bool = False, dimension: int = 2
    ) -> meshio.Mesh:
        """The file with its crack opened by `width` (mm), by default the median length of the elements along it; or with the
        band it names, see `meshing.read_band_mesh`."""
        mesh = None if self.band is not None else self.mesh()
        if mesh is None or mesh.points.shape[1] == 3:
            if width is not None:
                raise MeshError.at("band.width", f" = {width:g}: the elements of the band give it; expected no width")
            crack = None if mesh is None else self.crack
            return self._checked(read_band_mesh(self.file, self.band, self._along, list(self.regions_), crack))
        if width is None:
            width = float(np.median(np.hypot(*np.diff(mesh.points[mesh.cells[-1].data[:, :2]], axis=1)[:, 0].T)))
            mesh.info["remarks"].append(
                f"the crack band is {width:.4g} mm wide, the median length of the elements along the crack; band.width names "
                "another width, specimen.band elements"
            )
        return open_cracks(mesh, width)

    def mesh_body(self, sizes: MeshSizes | None = None, *, dimension: int = 2) -> meshio.Mesh:
        """The file as it is: cracks may form in all of its elements."""
        return self._checked(read_band_mesh(self.file, None, self._along, list(self.regions_)))

    @property
    def _along(self) -> Any:
        """Direction of the path, from end to end."""
        return None if self._is_named else np.subtract(self.crack[0][-1], self.crack[0][0])

    def _checked(self, mesh: meshio.Mesh) -> meshio.Mesh:
        is_solid = mesh.points.shape[1] == 3
        if not is_solid and self.thickness is None:
            raise MeshError.at("thickness", " is missing: the mesh is plane")
        if is_solid and self.thickness is not None:
            raise MeshError.at("thickness", f" = {self.thickness:g}: the mesh is solid; expected no thickness")
        return mesh

    def gauges(self, *, half: bool = False) -> Mapping[str, Gauge]:
        """As the keys `gauge_minus` and `gauge_plus`, and `gauges` say."""
        main = {} if self.gauge_plus is None else {MAIN_GAUGE: Gauge(self.gauge_plus, self.gauge_minus)}
        return main | dict(self.gauges_)

    def pressures(self) -> list[Pressure]:
        """As the key `pressures` says."""
        return list(self.pressures_)

    def regions(self) -> Mapping[str, Region]:
        """As the key `regions` says."""
        return dict(self.regions_)

    def gravity(self) -> Direction | None:
        """As the key `down` says."""
        return None if self.down is None else tuple(self.down)


def _named(value: Any) -> list[str]:
    """The sets that entries of supports, drives and gauges name."""
    if isinstance(value, list):
        return [name for each in value for name in _named(each)]
    if not isinstance(value, Mapping):
        return []
    own = [value[end] for end in ("at", "against", "plus", "minus") if isinstance(value.get(end), str)]
    return [*own, *_named(list(value.values()))]
