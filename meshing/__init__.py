"""Notched specimens with the crack path or surface inserted beforehand, as meshio meshes.

A specimen states a test set-up: geometry, supports, drives, gauges, and given numbers such as the stiffness of a spring, a
pressure or E of a part. Nothing here solves: no stiffness matrix, stress or displacement is computed.
"""

from importlib import import_module
from typing import TYPE_CHECKING

#: the public names by the module where they live; one is loaded when it is first asked for
_NAMES = {
    "meshing.cutting.insertion": "crack_front_length insert_cracks",
    "meshing.errors": "MeshError",
    "meshing.files.bands": "read_band_mesh",
    "meshing.files.reading": "read_mesh",
    "meshing.generation.band": "mesh_band",
    "meshing.generation.outline": "Outline",
    "meshing.generation.polygon": "mesh_body mesh_polygon",
    "meshing.generation.sizes": "MeshSizes",
    "meshing.specimens": "MixedModePlate NotchedBeam NotchedTension PlaneSpecimen PushOff SandwichPanel SingleCrack "
    "SingleCrack3D Specimen UserMesh",
}
_HOME = {name: home for home, names in _NAMES.items() for name in names.split()}

__all__ = sorted(_HOME)

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
