"""Notched specimens with the crack path or surface inserted beforehand, as meshio meshes.

A specimen states a test set-up: geometry, supports, drives, gauges, and given numbers such as the stiffness of a spring, a
pressure or E of a part. Nothing here solves: no stiffness matrix, stress or displacement is computed.
"""

from importlib import import_module
from typing import TYPE_CHECKING

#: where each public name lives; it is loaded when it is first asked for
_HOME = {
    "MeshError": "meshing.errors",
    "MeshSizes": "meshing.generation.sizes",
    "MixedModePlate": "meshing.specimens",
    "NotchedBeam": "meshing.specimens",
    "NotchedTension": "meshing.specimens",
    "Outline": "meshing.generation.outline",
    "PlaneSpecimen": "meshing.specimens",
    "PushOff": "meshing.specimens",
    "SandwichPanel": "meshing.specimens",
    "SingleCrack": "meshing.specimens",
    "SingleCrack3D": "meshing.specimens",
    "Specimen": "meshing.specimens",
    "UserMesh": "meshing.specimens",
    "crack_front_length": "meshing.cutting.insertion",
    "insert_cracks": "meshing.cutting.insertion",
    "mesh_band": "meshing.generation.band",
    "mesh_body": "meshing.generation.polygon",
    "mesh_polygon": "meshing.generation.polygon",
    "read_band_mesh": "meshing.files.bands",
    "read_mesh": "meshing.files.reading",
}

__all__ = list(_HOME)

if TYPE_CHECKING:  # the same names once more, each re-exported by its "as"
    from .cutting.insertion import crack_front_length as crack_front_length
    from .cutting.insertion import insert_cracks as insert_cracks
    from .errors import MeshError as MeshError
    from .files.bands import read_band_mesh as read_band_mesh
    from .files.reading import read_mesh as read_mesh
    from .generation.band import mesh_band as mesh_band
    from .generation.outline import Outline as Outline
    from .generation.polygon import mesh_body as mesh_body
    from .generation.polygon import mesh_polygon as mesh_polygon
    from .generation.sizes import MeshSizes as MeshSizes
    from .specimens import MixedModePlate as MixedModePlate
    from .specimens import NotchedBeam as NotchedBeam
    from .specimens import NotchedTension as NotchedTension
    from .specimens import PlaneSpecimen as PlaneSpecimen
    from .specimens import PushOff as PushOff
    from .specimens import SandwichPanel as SandwichPanel
    from .specimens import SingleCrack as SingleCrack
    from .specimens import SingleCrack3D as SingleCrack3D
    from .specimens import Specimen as Specimen
    from .specimens import UserMesh as UserMesh

else:  # hidden from type checkers, to which a name that is not above is none

    def __getattr__(name):
        if name not in _HOME:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
