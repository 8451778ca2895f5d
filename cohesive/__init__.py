"""Rough cracks in concrete, discrete and smeared, driven by the crack-plane law of Jefferson and Mihai (2015)."""

from .comparison import Comparison, compare
from .concrete import Concrete
from .crackplane import CrackPlane
from .linear import NotConverged
from .result import Result
from .scene import Scene, SceneError
from .simulation import run

__all__ = ["Comparison", "Concrete", "CrackPlane", "NotConverged", "Result", "Scene", "SceneError", "compare", "run"]
