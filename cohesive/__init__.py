"""Rough cracks in concrete: zero-thickness interface elements driven by the law of Jefferson and Mihai (2015)."""

from .concrete import Concrete
from .crackplane import CrackPlane
from .linear import NotConverged
from .result import Result
from .scene import Scene, SceneError
from .simulation import run

__all__ = ["Concrete", "CrackPlane", "NotConverged", "Result", "Scene", "SceneError", "run"]
