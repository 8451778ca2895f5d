"""Accuracy against cost: one scene with one knob turned at a time, then the promising settings together."""

from __future__ import annotations

import csv
import io
import json
import math
import multiprocessing
import os
import resource
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from meshing import MeshError
from meshing.solids import Extruded

from ..errors import NotConverged, SceneError
from ..results.files import make_folder, write_file, write_text
from ..scenes.scene import Scene
from ..simulation import run
from .curves import Curve, Pair, curve_of
from .parameters import PHYSICS, Settings, changes, label, single

#: errors for which the cheapest setting is named
ACCURACIES = (0.05, 0.01, 0.002)

#: what the error of a setting is the largest of
_MEASURES = ("peak", "energy", "curve_distance")

#: all that is measured
_ERRORS = ("peak", "opening_at_peak", "energy", "curve_distance")

#: a setting joins a combination for an accuracy if turned alone it loses no more than this part of it
_SHARE = 0.25

#: and if it takes less than this part of the CPU time
_WORTH = 0.9

#: CPU times up to this ratio are alike: the machine has other things to do
_ALIKE = 1.2

#: errors on another scene of the same kind are taken for larger by this factor
_ELSEWHERE = 3.0

#: short runs are repeated for so many seconds, and the shortest counts
REPEATED = 0.5

#: the reference is finer by this factor in everything, and its error is that of a run half as fine against it
_FINER = 4.0

#: in space, where that would be 64 times the elements, by at least and at most these; between them so that the crack has about
#: so many elements
_FINER_IN_SPACE, _ON_CRACK = (1.5, 2.5), 350


@dataclass(frozen=True)
class Cost:
    """What one run took: CPU and wall seconds from the scene to the last step, peak memory (MB), iterations."""

    cpu: float
    wall: float
    memory: float
    iterations: int


@dataclass(frozen=True)
class Trial:
    """One setting: the knobs that it turns, relative errors by measure, cost; or why it failed."""

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
        return max(self.errors[name] for name in _MEASURES) if self.errors else np.inf

    @property
    def is_same_problem(self) -> bool:
        """Whether model and material are those of the scene."""
        return not any(knob in self.settings for knob in PHYSICS)


@dataclass(frozen=True)
class Trade:
    """All trials of a scene.

    Attributes
    ----------
    scene : Scene
    reference : peak (N), opening_at_peak (mm), energy (N mm) of the reference
    own_error : of the reference: how far a run lies from it that is half as fine in everything
    trials : list of Trial, the scene as it is first, the reference last
    """

    scene: Scene
    reference: dict[str, float]
    own_error: float
    trials: list[Trial]

    def pareto_front(self) -> list[Trial]:
        """Trials that no other one beats in both error and CPU time, cheapest first; those of another problem do not count."""
        front: list[Trial] = []
        runs = [(trial.cost.cpu, trial.error, trial) for trial in self.trials if trial.cost and trial.is_same_problem]
        for _, error, trial in sorted(runs, key=lambda entry: entry[:2]):
            if not front or error < front[-1].error:
                front.append(trial)
        return front

    def promise(self, trial: Trial, elsewhere: bool = False) -> float:
        """Error of a trial with that of the reference added.

        With `elsewhere`, what its settings promise on another scene of the kind. There errors that cancel here may add up, so
        that a combination counts with what each of its settings loses alone; and they are taken for larger.
        """
        if not elsewhere:
            return trial.error + self.own_error
        error = trial.error
        if len(trial.settings) > 1:
            alone = {label(each.settings): each.error for each in self.trials}
            parts = [label({knob: value}) for knob, value in trial.settings.items()]
            base = alone["as it is"]
            start = next((alone[part] for part in parts if part.startswith("finer")), base)
            lost = sum(max(0.0, alone[part] - base) for part in parts if part in alone and not part.startswith("finer"))
            error = max(error, start + lost)
        return _ELSEWHERE * error + self.own_error

    def cheapest(self, accuracy: float, elsewhere: bool = False) -> Trial | None:
        """The cheapest trial that promises at most this error; of those that are as cheap, the most accurate."""
        runs = [(trial, trial.cost.cpu) for trial in self.trials if trial.cost and trial.is_same_problem]
        good = [(trial, cpu) for trial, cpu in runs if self.promise(trial, elsewhere) <= accuracy]
        fastest = min((cpu for _, cpu in good), default=0.0)
        alike = [trial for trial, cpu in good if cpu <= _ALIKE * fastest]
        return min(alike, key=lambda trial: self.promise(trial, elsewhere), default=None)

    def summary(self) -> str:
        """Table of all trials and the recommendations."""
        width = max(len(trial.label) for trial in self.trials) + 2
        lines = [
            self.scene.title,
            f"reference: peak {self.reference['peak']:.5g} N, energy {self.reference['energy']:.5g} N mm; its own error "
            f"{100 * self.own_error:.2g} %",
            f"{'setting':{width}s}{'error':>9s}{'peak':>9s}{'energy':>9s}{'distance':>9s}{'CPU s':>8s}{'MB':>6s}{'iter.':>7s}",
        ]
        for trial in self.trials:
            if trial.cost is None:
                lines.append(f"{trial.label:{width}s}  failed: {trial.failure}")
                continue
            errors = "".join(f"{100 * e:8.2f}%" for e in (trial.error, *(trial.errors[name] for name in _MEASURES)))
            lines.append(
                f"{trial.label:{width}s}{errors}{trial.cost.cpu:8.2f}{trial.cost.memory:6.0f}{trial.cost.iterations:7d}"
            )
        for accuracy in ACCURACIES:
            best = self.cheapest(accuracy)
            what = f"none of these; the reference is known to {100 * self.own_error:.2g} %"
            if best is not None and best.cost is not None:
                keys = " ".join(f"--set {key}={value}" for key, value in changes(self.scene, best.settings).items())
                what = f"{best.label}{': ' if keys else ''}{keys}  ({100 * best.error:.2g} %, {best.cost.cpu:.2f} s)"
            lines.append(f"cheapest for {100 * accuracy:g} %: {what}")
        return "\n".join(lines)

    def save(self, folder: str | Path) -> None:
        """Write trade.csv, trade.png and trade.txt; SceneError where the folder cannot be written."""
        from ..results.figures import save, trade_figure

        folder = Path(folder)
        make_folder(folder)
        write_file(folder / "trade.csv", lambda path: write_text(path, self._csv()))
        write_file(folder / "trade.txt", lambda path: write_text(path, self.summary() + "\n"))
        write_file(folder / "trade.png", lambda path: save(trade_figure(self), path))

    def _csv(self) -> str:
        """A comment with the scene and the reference, then one row for each trial."""
        text = io.StringIO()
        facts = {"scene": self.scene.data, "reference": self.reference, "own_error": self.own_error}
        text.write(f"# {json.dumps(facts)}\n")
        rows = csv.writer(text, lineterminator="\n")
        rows.writerow(["setting", "error", *_ERRORS, "cpu_s", "wall_s", "memory_mb", "iterations", "failure", "knobs"])
        for trial in self.trials:
            found: list[object] = [""] * 9
            if trial.cost is not None:
                found = [f"{e:.6g}" for e in (trial.error, *(trial.errors[name] for name in _ERRORS))]
                found += [f"{trial.cost.cpu:.4g}", f"{trial.cost.wall:.4g}", f"{trial.cost.memory:.4g}", trial.cost.iterations]
            rows.writerow([trial.label, *found, trial.failure, json.dumps(trial.settings)])
        return text.getvalue()

    @classmethod
    def load(cls, path: str | Path) -> Trade:
        """The trade of a trade.csv; SceneError where it is none."""
        try:
            with open(path, newline="", encoding="utf-8") as file:
                facts = json.loads(file.readline().removeprefix("#"))
                trials = []
                for row in csv.DictReader(file):
                    found, cost = {}, None
                    if not row["failure"]:
                        found = {name: float(row[name]) for name in _ERRORS}
                        cpu, wall, memory = (float(row[name]) for name in ("cpu_s", "wall_s", "memory_mb"))
                        cost = Cost(cpu, wall, memory, int(row["iterations"]))
                    trials.append(Trial(json.loads(row["knobs"]), found, cost, row["failure"]))
            return cls(Scene(facts["scene"]), facts["reference"], float(facts["own_error"]), trials)
        except OSError as error:
            raise SceneError(f"'{path}': cannot be read: {error.strerror}") from None
        except (ValueError, KeyError, TypeError) as error:
            raise SceneError(f"'{path}': not a table of this version of `cohesive trade`: {error}") from None


def trade(
    scene: Scene,
    executor: Executor | None = None,
    on_trial: Callable[[Trial], None] | None = None,
    knobs: Iterable[str] | None = None,
) -> Trade:
    """Turn the knobs of a scene one at a time, then those that pay together.

    Crack size, far size, layers, order, shape, interface width (or the band's), quadrature, number of steps and how far they
    may grow, Newton tolerance and tangent, reduction; the smoothing of contact and the other model, which change the physics.
    Errors are relative to a reference that is finer in everything: four times in the plane, 1.5 to 2.5 times in space.

    Parameters
    ----------
    scene : Scene of a built-in specimen.
    executor : runs the trials, as that of a Dask client does; default: processes of its own, one for each core. In workers
        that live on the memory of a trial is the largest so far.
    on_trial : called after each trial.
    knobs : those that are turned, of `knobs.KNOBS`; default: all.

    Raises
    ------
    SceneError
        For a mesh of the user's, which has no sizes to turn, or an unknown knob.
    NotConverged
        If the reference fails.
    """
    if scene.sizes is None:
        raise SceneError("specimen.kind = 'mesh': a trade turns the sizes of the mesh; expected a built-in specimen")
    bare = Scene({key: value for key, value in scene.data.items() if key not in ("reference", "output")}, scene.folder)
    alone = single(bare, knobs)
    pool = executor or ProcessPoolExecutor(os.cpu_count(), multiprocessing.get_context("spawn"), max_tasks_per_child=1)
    waiting: list[tuple[Settings, Future[tuple[Curve, Cost]]]] = []

    def submit(settings: Iterable[Settings]) -> None:
        waiting.extend((each, pool.submit(_measured, bare, each)) for each in settings)

    def done(begin: int) -> list[Trial]:
        found = []
        for settings, future in waiting[begin:]:
            try:
                curve, cost = future.result()
                trial = Trial(settings, errors(curve, reference), cost)
            except (NotConverged, SceneError, MeshError) as error:
                trial = Trial(settings, failure=str(error))
            found.append(trial)
            if on_trial is not None:
                on_trial(trial)
        return found

    try:
        most = finest_factor(bare)
        submit({"finer": factor} for factor in (most, most / 2))  # the longest first
        submit([{}, *alone])
        (reference, _), (half_as_fine, _) = (future.result() for _, future in waiting[:2])
        own_error = max(errors(half_as_fine, reference)[name] for name in _MEASURES)
        finest, finer, *trials = done(0)
        begin = len(waiting)
        submit(combined(trials, own_error, (finer, finest)))
        trials += [*done(begin), finer, finest]
    finally:
        for _, future in waiting:
            future.cancel()
        if executor is None:
            pool.shutdown(cancel_futures=True)
    energy = Pair.from_curves(reference, reference).energy(0)
    values = {"peak": reference.peak, "opening_at_peak": reference.opening_at_peak, "energy": energy}
    return Trade(bare, values, own_error, trials)


def finest_factor(scene: Scene) -> float:
    """By what factor the reference is finer than the scene."""
    if not scene.is_solid:
        return _FINER
    sizes = scene.sizes
    assert sizes is not None
    across = sizes.crack_size
    if isinstance(scene.specimen, Extruded):
        across = scene.specimen.thickness / sizes.layers_through(scene.specimen.thickness)
    elements = scene.crack_area / (sizes.crack_size * across)
    least, most = _FINER_IN_SPACE
    return round(min(most, max(least, math.sqrt(_ON_CRACK / elements))), 1)


def _measured(scene: Scene, settings: Settings) -> tuple[Curve, Cost]:
    """Run a setting, in a process of its own."""
    import gmsh  # noqa: F401  # loading it is no cost of the scene

    scene = scene.with_(**changes(scene, settings))
    best_wall = best_cpu = np.inf
    begin = time.perf_counter()
    while time.perf_counter() - begin < REPEATED or best_cpu == np.inf:  # what else the machine does only adds
        wall, cpu = time.perf_counter(), time.process_time()
        try:
            result = run(scene)
        except NotConverged as error:  # what it holds of the model does not travel between processes
            error.result = None
            raise
        best_wall = min(best_wall, time.perf_counter() - wall)
        best_cpu = min(best_cpu, time.process_time() - cpu)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (2**20 if sys.platform == "darwin" else 2**10)
    return curve_of(result), Cost(best_cpu, best_wall, memory, result.iterations)


def errors(curve: Curve, reference: Curve) -> dict[str, float]:
    """Relative errors of a curve: in peak, opening at the peak, energy, and the curve distance."""
    pair = Pair.from_curves(curve, reference)
    return {
        "peak": abs(curve.peak / reference.peak - 1.0),
        "opening_at_peak": abs(curve.opening_at_peak / reference.opening_at_peak - 1.0),
        "energy": abs(pair.energy(0) / pair.energy(1) - 1.0),
        "curve_distance": pair.between() / pair.under(1),
    }


def combined(trials: Sequence[Trial], own_error: float, finer: Sequence[Trial]) -> list[Settings]:
    """For each accuracy the cheapest value of each knob whose own loss leaves room for the others, on the scene as it is,
    or on a finer one where that does not reach the accuracy."""
    base = trials[0]
    found: list[Settings] = []
    for accuracy in ACCURACIES:
        start = next((each for each in (base, *finer) if each.error + own_error <= accuracy), None)
        if start is None or base.cost is None:
            continue
        by_knob: dict[str, Trial] = {}
        for trial in trials[1:]:
            if not trial.is_same_problem or trial.cost is None or trial.error > base.error + _SHARE * accuracy:
                continue
            (knob,) = trial.settings
            if trial.cost.cpu < min(_WORTH * base.cost.cpu, getattr(by_knob.get(knob), "cost", base.cost).cpu):
                by_knob[knob] = trial
        settings = dict(start.settings)
        for trial in by_knob.values():
            settings |= trial.settings
        if len(settings) > 1 and settings not in found:
            found.append(settings)
    return found
