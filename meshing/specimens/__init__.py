"""Specimens, one kind in one file: geometry, where they are held, driven and measured. Lengths in mm, angles in degrees."""

from .base import Drive, Gauge, PlaneSpecimen, Specimen, Support
from .compact_tension import CompactTension
from .four_point_beam import FourPointBeam
from .l_panel import LPanel
from .mixed_mode_plate import MixedModePlate
from .notched_beam import NotchedBeam
from .notched_tension import NotchedTension
from .own_outline import OwnOutline
from .push_off import PushOff
from .registry import SPECIMENS, register_specimen
from .sandwich_panel import SandwichPanel
from .single_crack import SingleCrack
from .single_crack_3d import SingleCrack3D
from .tension_shear_panel import TensionShearPanel
from .user_mesh import UserMesh
from .wedge_splitting import WedgeSplitting

__all__ = [
    "SPECIMENS",
    "CompactTension",
    "Drive",
    "FourPointBeam",
    "Gauge",
    "LPanel",
    "MixedModePlate",
    "NotchedBeam",
    "NotchedTension",
    "OwnOutline",
    "PlaneSpecimen",
    "PushOff",
    "SandwichPanel",
    "SingleCrack",
    "SingleCrack3D",
    "Specimen",
    "Support",
    "TensionShearPanel",
    "UserMesh",
    "WedgeSplitting",
    "register_specimen",
]
