"""Notched specimens with the crack path or surface inserted beforehand, as meshio meshes. Knows no mechanics."""

from .band import mesh_band
from .band_reader import read_band_mesh
from .base import PlaneSpecimen, Specimen
from .cracks import crack_front_length, insert_cracks
from .errors import MeshError
from .plane import MeshSizes, Outline, mesh_body, mesh_polygon
from .reader import read_mesh
from .solids import NotchedBeam3D, PushOff3D, SingleCrack3D
from .specimens import MixedModePlate, NotchedBeam, NotchedTension, PushOff, SandwichPanel, SingleCrack

__all__ = [
    "MeshError",
    "MeshSizes",
    "MixedModePlate",
    "NotchedBeam",
    "NotchedBeam3D",
    "NotchedTension",
    "Outline",
    "PlaneSpecimen",
    "PushOff",
    "PushOff3D",
    "SandwichPanel",
    "SingleCrack",
    "SingleCrack3D",
    "Specimen",
    "crack_front_length",
    "insert_cracks",
    "mesh_band",
    "mesh_body",
    "mesh_polygon",
    "read_band_mesh",
    "read_mesh",
]
