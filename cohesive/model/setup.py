"""What a specimen says of its supports, drives and gauges, for a mesh of it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, TypeVar

from meshing.specimens import Drive, Gauge, Specimen, Support
from meshing.specimens.base import Direction

from .mesh import CrackedMesh

S = TypeVar("S", Support, Drive, Gauge)


@dataclass(frozen=True)
class Setup:
    """Supports, drives and gauges, those of an extruded specimen with directions in space.

    Attributes
    ----------
    supports : list of Support
    drives, gauges : Drive and Gauge by name
    normal : of the plane of symmetry of a half; None for a whole body
    """

    supports: list[Support]
    drives: dict[str, Drive]
    gauges: dict[str, Gauge]
    normal: Direction | None

    @classmethod
    def from_specimen(cls, specimen: Specimen, mesh: CrackedMesh, plane: str, half: bool) -> Setup:
        """The set-up of a test, of one half of it if so wanted."""
        is_extruded = mesh.dimension == 3 and 2 in specimen.dimensions

        def extended(vector: Direction | None) -> Direction | None:
            return (*vector, 0.0) if is_extruded and vector is not None and len(vector) == 2 else vector

        def placed(each: S, *names: str) -> S:
            directions: dict[str, Any] = {name: extended(getattr(each, name)) for name in ("direction", *names)}
            return replace(each, **directions)

        supports = [*specimen.held(half=half), *(specimen.held_across(plane) if mesh.dimension == 3 else [])]
        return cls(
            [placed(each) for each in supports],
            {name: placed(each, "shear", "against_direction") for name, each in specimen.drives(half=half).items()},
            {name: placed(each) for name, each in specimen.gauges(half=half).items()},
            extended(specimen.symmetry()) if half else None,
        )
