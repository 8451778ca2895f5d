"""Notched plane specimens with the crack path inserted beforehand, as meshio meshes. Knows no mechanics."""

from .band import mesh_band
from .base import PlaneSpecimen, Specimen
from .cracks import insert_cracks
from .errors import MeshError
from .plane import Body, MeshSizes, mesh_body, mesh_polygon
from .reader import read_band_mesh, read_mesh
from .specimens import MixedModePlate, NotchedBeam, NotchedTension, PushOff, SandwichPanel, SingleCrack

__all__ = [
    "Body",
    "MeshError",
    "MeshSizes",
    "MixedModePlate",
    "NotchedBeam",
    "NotchedTension",
    "PlaneSpecimen",
    "PushOff",
    "SandwichPanel",
    "SingleCrack",
    "Specimen",
    "insert_cracks",
    "mesh_band",
    "mesh_body",
    "mesh_polygon",
    "read_band_mesh",
    "read_mesh",
]
