"""The settings that were tried on one scene: what each costs, how far it errs, and which of them is worth it."""

from __future__ import annotations

import math
import sys
import time
from dataclasses import dataclass, field

import numpy as np

from ..errors import NotConverged
from ..scenes.scene import Scene
from ..simulation import run
from .curves import Curve, Pair, curve_of
from .parameters import PHYSICS, Settings, changes, label

#: the error of a setting is the largest of these
MEASURES = ("peak", "energy", "curve_distance")

#: all that is measured
ERRORS = ("peak", "at_peak", "energy", "curve_distance")

#: short runs are repeated for so many seconds, and the shortest counts
REPEATED = 0.5

#: CPU times up to this ratio are alike: the machine has other things to do
_ALIKE = 1.2

#: errors on another scene of the same kind are taken for larger by this factor
_ELSEWHERE = 3.0


@dataclass(frozen=True)
class Cost:
    """What one run took: CPU and wall seconds from the scene to the last step, peak memory (MB), iterations.

    The memory is NaN on a system that does not tell it.
    """

    cpu: float
    wall: float
    memory: float
    iterations: int


@dataclass(frozen=True)
class SweepSetting:
    """One run of a trade: the settings that it changes, relative errors by measure, cost; or why it failed."""

    settings: Settings
    errors: dict[str, float] = field(default_factory=dict)
    cost: Cost | None = None
    failure: str = ""

    @property
    def label(self) -> str:
        """The settings as words."""
        return label(self.settings)

    @property
    def error(self) -> float:
        """The largest of the errors in peak, energy and curve distance; without a run, infinite."""
        return max(self.errors[name] for name in MEASURES) if self.errors else np.inf

    @property
    def is_same_problem(self) -> bool:
        """Whether model and material are those of the scene."""
        return not any(name in self.settings for name in PHYSICS)


@dataclass(frozen=True)
class SweepSettings:
    """All settings that were tried on a scene.

    Attributes
    ----------
    scene : Scene
    reference : peak (N), at_peak (mm, of the measure in charge), energy (N mm) of the reference
    own_error : of the reference: how far a run lies from it that is half as fine in everything
    trials : list of SweepSetting, the scene as it is first, the reference last
    """

    scene: Scene
    reference: dict[str, float]
    own_error: float
    trials: list[SweepSetting]

    def pareto_front(self) -> list[SweepSetting]:
        """Trials that no other one beats in both error and CPU time, cheapest first; those of another problem do not count."""
        found: list[SweepSetting] = []
        runs = [(trial.cost.cpu, trial.error, trial) for trial in self.trials if trial.cost and trial.is_same_problem]
        for _, error, trial in sorted(runs, key=lambda entry: entry[:2]):
            if not found or error < found[-1].error:
                found.append(trial)
        return found

    def promise(self, trial: SweepSetting, elsewhere: bool = False) -> float:
        """Error of a trial with that of the reference added.

        With `elsewhere`, the error that its settings promise on another scene of the kind. Errors that cancel here may add
        up there: a combination counts with what each of its settings loses alone, and all errors are taken for larger.
        """
        if not elsewhere:
            return trial.error + self.own_error
        error = trial.error
        if len(trial.settings) > 1:
            alone = {label(each.settings): each.error for each in self.trials}
            parts = [label({name: value}) for name, value in trial.settings.items()]
            base = alone["as it is"]
            start = next((alone[part] for part in parts if part.startswith("finer")), base)
            lost = sum(max(0.0, alone[part] - base) for part in parts if part in alone and not part.startswith("finer"))
            error = max(error, start + lost)
        return _ELSEWHERE * error + self.own_error

    def cheapest(self, accuracy: float, elsewhere: bool = False) -> SweepSetting | None:
        """The cheapest trial that promises at most this error; among those that are as cheap, the most accurate."""
        runs = [(trial, trial.cost.cpu) for trial in self.trials if trial.cost and trial.is_same_problem]
        good = [(trial, cpu) for trial, cpu in runs if self.promise(trial, elsewhere) <= accuracy]
        fastest = min((cpu for _, cpu in good), default=0.0)
        alike = [trial for trial, cpu in good if cpu <= _ALIKE * fastest]
        return min(alike, key=lambda trial: self.promise(trial, elsewhere), default=None)


def measured(scene: Scene, settings: Settings) -> tuple[Curve, Cost]:
    """Run a scene with some settings: its curve and what it took. The memory is that of the whole process so far.

    Raises
    ------
    SceneError, MeshError, NotConverged
    """
    import gmsh  # noqa: F401  # loading it is no cost of the scene

    scene = scene.with_(**changes(scene, settings))
    best_wall = best_cpu = np.inf
    begin = time.perf_counter()
    while time.perf_counter() - begin < REPEATED or best_cpu == np.inf:  # what else the machine does only adds
        wall, cpu = time.perf_counter(), time.process_time()
        try:
            result = run(scene)
        except NotConverged as error:  # its message is enough, and fields need not travel between processes
            error.result = None
            raise
        best_wall = min(best_wall, time.perf_counter() - wall)
        best_cpu = min(best_cpu, time.process_time() - cpu)
    return curve_of(result), Cost(best_cpu, best_wall, _peak_memory(), result.iterations)


def _peak_memory() -> float:
    """The largest memory of this process so far, MB; NaN on a system without POSIX's resource, as Windows."""
    try:
        import resource
    except ImportError:
        return math.nan
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (2**20 if sys.platform == "darwin" else 2**10)


def errors(curve: Curve, reference: Curve) -> dict[str, float]:
    """Relative errors of a curve: in peak, place of the peak, energy, and the curve distance."""
    pair = Pair.from_curves(curve, reference)
    return {
        "peak": abs(curve.peak / reference.peak - 1.0),
        "at_peak": abs(curve.at_peak / reference.at_peak - 1.0),
        "energy": abs(pair.energy(0) / pair.energy(1) - 1.0),
        "curve_distance": pair.between() / pair.under(1),
    }
