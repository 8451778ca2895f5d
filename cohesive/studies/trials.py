"""The settings that are tried on one scene: what each costs, and how far it errs."""

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

#: short runs are repeated for these seconds, and the shortest counts
REPEATED = 0.5


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
