"""Notched specimens with the crack path or surface inserted beforehand, as meshio meshes.

A specimen states a test set-up: geometry, supports, drives, gauges, and given numbers such as the stiffness of a spring, a
pressure or E of a part. Nothing here solves: no stiffness matrix, stress or displacement is computed.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .cutting.insertion import crack_front_length, insert_cracks
    from .errors import MeshError
    from .files.bands import read_band_mesh
    from .files.reading import read_mesh
    from .generation.band import mesh_band
    from .generation.outline import Outline
    from .generation.polygon import mesh_body, mesh_polygon
    from .generation.sizes import MeshSizes
    from .specimens import (
        MixedModePlate,
        NotchedBeam,
        NotchedTension,
        PlaneSpecimen,
        PushOff,
        SandwichPanel,
        SingleCrack,
        SingleCrack3D,
        Specimen,
        UserMesh,
    )  # fmt: skip

__all__ = [
    "MeshError",
    "MeshSizes",
    "MixedModePlate",
    "NotchedBeam",
    "NotchedTension",
    "Outline",
    "PlaneSpecimen",
    "PushOff",
    "SandwichPanel",
    "SingleCrack",
    "SingleCrack3D",
    "Specimen",
    "UserMesh",
    "crack_front_length",
    "insert_cracks",
    "mesh_band",
    "mesh_body",
    "mesh_polygon",
    "read_band_mesh",
    "read_mesh",
]

#: where each name lives; it is loaded when it is first asked for
_HOME = {
    "MeshError": "errors",
    "MeshSizes": "generation.sizes",
    "MixedModePlate": "specimens",
    "NotchedBeam": "specimens",
    "NotchedTension": "specimens",
    "Outline": "generation.outline",
    "PlaneSpecimen": "specimens",
    "PushOff": "specimens",
    "SandwichPanel": "specimens",
    "SingleCrack": "specimens",
    "SingleCrack3D": "specimens",
    "Specimen": "specimens",
    "UserMesh": "specimens",
    "crack_front_length": "cutting.insertion",
    "insert_cracks": "cutting.insertion",
    "mesh_band": "generation.band",
    "mesh_body": "generation.polygon",
    "mesh_polygon": "generation.polygon",
    "read_band_mesh": "files.bands",
    "read_mesh": "files.reading",
}


if not TYPE_CHECKING:  # or any name would pass a type checker

    def __getattr__(name: str) -> Any:
        if name not in _HOME:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        return getattr(import_module(f".{_HOME[name]}", __name__), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
