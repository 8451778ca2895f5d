"""Rough cracks in concrete, discrete and smeared, driven by the crack-plane law of Jefferson and Mihai (2015)."""

from importlib import import_module
from typing import TYPE_CHECKING

#: the public names by the module where they live; one is loaded when it is first asked for
_NAMES = {
    "cohesive.errors": "Interrupted NotConverged SceneError",
    "cohesive.law.concrete": "Concrete",
    "cohesive.law.crack_plane": "CrackPlane",
    "cohesive.law.registry": "Law register_law",
    "cohesive.law.softening": "register_softening",
    "cohesive.measured.curve": "Measured",
    "cohesive.measured.reading": "read_measured",
    "cohesive.model.prepared": "Prepared prepare",
    "cohesive.outcome.result": "Result",
    "cohesive.scenes.scene": "Scene",
    "cohesive.simulation": "resume run",
    "cohesive.solver.controls": "LinearControl register_control",
    "cohesive.solver.stages": "Stage",
    "cohesive.studies.accuracy": "settings_for",
    "cohesive.studies.compare": "compare",
    "cohesive.studies.comparison": "Comparison",
    "cohesive.fitting.fit": "fit",
    "cohesive.fitting.result": "Fit",
    "cohesive.fitting.sensitivities": "sensitivities",
    "cohesive.studies.sweep": "Sweep sweep",
    "cohesive.studies.trade": "Trade trade",
    "meshing.errors": "MeshError",
    "meshing.specimens": "PlaneSpecimen register_specimen",
}
_HOME = {name: home for home, names in _NAMES.items() for name in names.split()}

__all__ = sorted(_HOME)

if TYPE_CHECKING:  # the same names once more, each re-exported by its "as"
    from collections.abc import Sequence

    from meshing.errors import MeshError as MeshError
    from meshing.specimens import PlaneSpecimen as PlaneSpecimen
    from meshing.specimens import register_specimen as register_specimen

    from . import errors as _errors
    from .fitting.fit import fit as fit
    from .fitting.result import Fit as Fit
    from .fitting.sensitivities import sensitivities as sensitivities
    from .law.concrete import Concrete as Concrete
    from .law.crack_plane import CrackPlane as CrackPlane
    from .law.registry import Law as Law
    from .law.registry import register_law as register_law
    from .law.softening import register_softening as register_softening
    from .measured.curve import Measured as Measured
    from .measured.reading import read_measured as read_measured
    from .model.prepared import Prepared as Prepared
    from .model.prepared import prepare as prepare
    from .outcome.result import Result as Result
    from .scenes.scene import Scene as Scene
    from .simulation import resume as resume
    from .simulation import run as run
    from .solver.controls import LinearControl as LinearControl
    from .solver.controls import register_control as register_control
    from .solver.stages import Stage as Stage
    from .studies.accuracy import settings_for as settings_for
    from .studies.compare import compare as compare
    from .studies.comparison import Comparison as Comparison
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
