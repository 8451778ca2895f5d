"""Rough cracks in concrete, discrete and smeared, driven by the crack-plane law of Jefferson and Mihai (2015)."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from meshing.specimens import register_specimen

    from .errors import NotConverged, SceneError
    from .law.concrete import Concrete
    from .law.crack_plane import CrackPlane
    from .law.softening import register_softening
    from .model.prepared import prepare
    from .results.result import Result
    from .scenes.scene import Scene
    from .simulation import resume, run
    from .solver.controls import register_control
    from .studies.accuracy import settings_for
    from .studies.compare import compare
    from .studies.comparison import Comparison
    from .studies.fit import fit
    from .studies.sensitivities import sensitivities
    from .studies.sweep import sweep
    from .studies.trade import trade

__all__ = [
    "Comparison",
    "Concrete",
    "CrackPlane",
    "NotConverged",
    "Result",
    "Scene",
    "SceneError",
    "compare",
    "fit",
    "prepare",
    "register_control",
    "register_softening",
    "register_specimen",
    "resume",
    "run",
    "sensitivities",
    "settings_for",
    "sweep",
    "trade",
]

#: where each name lives; it is loaded when it is first asked for
_HOME = {
    "Comparison": "studies.comparison",
    "Concrete": "law.concrete",
    "CrackPlane": "law.crack_plane",
    "NotConverged": "errors",
    "Result": "results.result",
    "Scene": "scenes.scene",
    "SceneError": "errors",
    "compare": "studies.compare",
    "fit": "studies.fit",
    "prepare": "model.prepared",
    "register_control": "solver.controls",
    "register_softening": "law.softening",
    "register_specimen": "meshing.specimens",
    "resume": "simulation",
    "run": "simulation",
    "sensitivities": "studies.sensitivities",
    "settings_for": "studies.accuracy",
    "sweep": "studies.sweep",
    "trade": "studies.trade",
}


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version  # slow to import

        return version("cohesive-cracks")
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    home = _HOME[name]
    return getattr(import_module(home if home.startswith("meshing") else f".{home}", __name__), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, "__version__"})
