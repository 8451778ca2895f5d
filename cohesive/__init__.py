"""Rough cracks in concrete, discrete and smeared, driven by the crack-plane law of Jefferson and Mihai (2015)."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .comparison import Comparison, compare
    from .concrete import Concrete
    from .crackplane import CrackPlane
    from .linear import NotConverged
    from .result import Result
    from .scene import Scene, SceneError
    from .simulation import run

__all__ = ["Comparison", "Concrete", "CrackPlane", "NotConverged", "Result", "Scene", "SceneError", "compare", "run"]

#: where each name lives; it is loaded when it is first asked for
_HOME = {
    "Comparison": "comparison",
    "Concrete": "concrete",
    "CrackPlane": "crackplane",
    "NotConverged": "linear",
    "Result": "result",
    "Scene": "scene",
    "SceneError": "scene",
    "compare": "comparison",
    "run": "simulation",
}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_HOME[name]}", __name__), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
