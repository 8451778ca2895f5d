"""Notched plane specimens with the crack path inserted beforehand, as meshio meshes. Knows no mechanics."""

from .cracks import insert_cracks
from .errors import MeshError
from .plane import MeshSizes, mesh_polygon
from .reader import read_mesh
from .specimens import NotchedBeam, NotchedTension, SingleCrack

__all__ = [
    "MeshError",
    "MeshSizes",
    "NotchedBeam",
    "NotchedTension",
    "SingleCrack",
    "insert_cracks",
    "mesh_polygon",
    "read_mesh",
]
