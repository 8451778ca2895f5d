"""Rough cracks in concrete, discrete and smeared, driven by the crack-plane law of Jefferson and Mihai (2015)."""

from importlib import import_module
from typing import TYPE_CHECKING

#: where each public name lives; it is loaded when it is first asked for
_HOME = {
    "Comparison": "cohesive.studies.comparison",
    "Concrete": "cohesive.law.concrete",
    "CrackPlane": "cohesive.law.crack_plane",
    "Fit": "cohesive.studies.fit_result",
    "Interrupted": "cohesive.errors",
    "LinearControl": "cohesive.solver.controls",
    "Measured": "cohesive.measured.curve",
    "MeshError": "meshing.errors",
    "NotConverged": "cohesive.errors",
    "PlaneSpecimen": "meshing.specimens",
    "Prepared": "cohesive.model.prepared",
    "Result": "cohesive.results.result",
    "Scene": "cohesive.scenes.scene",
    "SceneError": "cohesive.errors",
    "Stage": "cohesive.solver.stages",
    "Sweep": "cohesive.studies.sweep",
    "Trade": "cohesive.studies.trade",
    "compare": "cohesive.studies.compare",
    "fit": "cohesive.studies.fit",
    "prepare": "cohesive.model.prepared",
    "read_measured": "cohesive.measured.reading",
    "register_control": "cohesive.solver.controls",
    "register_softening": "cohesive.law.softening",
    "register_specimen": "meshing.specimens",
    "resume": "cohesive.simulation",
    "run": "cohesive.simulation",
    "sensitivities": "cohesive.studies.sensitivities",
    "settings_for": "cohesive.studies.accuracy",
    "sweep": "cohesive.studies.sweep",
    "trade": "cohesive.studies.trade",
}

__all__ = list(_HOME)

if TYPE_CHECKING:  # the same names once more, each re-exported by its "as"
    from collections.abc import Sequence

    from meshing.errors import MeshError as MeshError
    from meshing.specimens import PlaneSpecimen as PlaneSpecimen
    from meshing.specimens import register_specimen as register_specimen

    from . import errors as _errors
    from .law.concrete import Concrete as Concrete
    from .law.crack_plane import CrackPlane as CrackPlane
    from .law.softening import register_softening as register_softening
    from .measured.curve import Measured as Measured
    from .measured.reading import read_measured as read_measured
    from .model.prepared import Prepared as Prepared
    from .model.prepared import prepare as prepare
    from .results.result import Result as Result
    from .scenes.scene import Scene as Scene
    from .simulation import resume as resume
    from .simulation import run as run
    from .solver.controls import LinearControl as LinearControl
    from .solver.controls import register_control as register_control
    from .solver.stages import Stage as Stage
    from .studies.accuracy import settings_for as settings_for
    from .studies.compare import compare as compare
    from .studies.comparison import Comparison as Comparison
    from .studies.fit import fit as fit
    from .studies.fit_result import Fit as Fit
    from .studies.sensitivities import sensitivities as sensitivities
    from .studies.sweep import Sweep as Sweep
    from .studies.sweep import sweep as sweep
    from .studies.trade import Trade as Trade
    from .studies.trade import trade as trade

    __version__: str

    # `errors` lies below all rooms and cannot name what these carry
    class SceneError(_errors.SceneError):
        result: Result | None
        finished: Sequence[Result]

    class NotConverged(_errors.NotConverged):
        result: Result | None
        finished: Sequence[Result]

    class Interrupted(_errors.Interrupted):
        result: Result | Sweep | None
        finished: Sequence[Result]

else:  # hidden from type checkers, to which a name that is not above is none

    def __getattr__(name):
        if name == "__version__":
            from importlib.metadata import version  # slow to import

            return version("cohesive-cracks")
        if name not in _HOME:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, "__version__"})
