"""Accuracy against cost: one scene with one knob turned at a time, then the promising settings together."""

from __future__ import annotations

import csv
import io
import multiprocessing
import os
import resource
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from meshing import MeshError
from meshing.cracks import path_length

from .curves import Curve, Pair, curve_of
from .linear import NotConverged
from .model import default_width
from .result import make_folder, write_file, write_text
from .scene import Scene, SceneError
from .simulation import run

Changes = dict[str, Any]

#: errors for which the cheapest setting is named
ACCURACIES = (0.05, 0.01, 0.002)
#: what the error of a setting is the largest of
_MEASURES = ("peak", "energy", "curve_distance")
#: a setting joins a combination for an accuracy if turned alone it spends no more than this part of it
_SHARE = 0.4
#: and if it takes less than this part of the CPU time
_WORTH = 0.95
#: short runs are repeated for so many seconds, and the shortest counts
_REPEATED = 0.5
#: the reference is finer by this factor in everything, and its own error is that against one finer still
_FINER = 2.0


@dataclass(frozen=True)
class Cost:
    """What one run took: CPU and wall seconds from the scene to the last step, peak memory (MB), iterations."""

    cpu: float
    wall: float
    memory: float
    iterations: int


@dataclass(frozen=True)
class Trial:
    """One setting: its changes to the scene, relative errors by measure, cost; or why it failed."""

    label: str
    changes: Changes
    errors: dict[str, float] = field(default_factory=dict)
    cost: Cost | None = None
    failure: str = ""

    @property
    def error(self) -> float:
        """The largest of the errors in peak, energy and curve distance; without a run, infinite."""
        return (
            max((self.errors[name] for name in ("peak", "energy", "curve_distance")), default=np.inf)
            if self.errors
            else np.inf
        )


@dataclass(frozen=True)
class Trade:
    """All trials of a scene.

    Attributes
    ----------
    scene : Scene
    reference : peak (N), opening_at_peak (mm), energy (N mm) of the reference
    own_error : of the reference, against one finer still
    trials : list of Trial, the scene as it is first
    """

    scene: Scene
    reference: dict[str, float]
    own_error: float
    trials: list[Trial]

    def front(self) -> list[Trial]:
        """Trials that no other one beats in both error and CPU time, cheapest first."""
        front: list[Trial] = []
        for trial in sorted((t for t in self.trials if t.cost), key=lambda t: (t.cost.cpu, t.error)):  # type: ignore[union-attr]
            if not front or trial.error < front[-1].error:
                front.append(trial)
        return front

    def cheapest(self, accuracy: float) -> Trial | None:
        """The cheapest trial with an error, the reference's own one added, of at most `accuracy`."""
        good = [trial for trial in self.front() if trial.error + self.own_error <= accuracy]
        return good[0] if good else None

    def summary(self) -> str:
        """Table of the front and the recommendations."""
        lines = [
            self.scene.title,
            f"reference: peak {self.reference['peak']:.5g} N, energy {self.reference['energy']:.5g} N mm; its own error "
            f"{100 * self.own_error:.2g} %",
            f"{'setting':44s}{'error':>9s}{'peak':>9s}{'energy':>9s}{'distance':>9s}{'CPU s':>8s}{'MB':>6s}{'iter.':>7s}",
        ]
        for trial in self.trials:
            if trial.cost is None:
                lines.append(f"{trial.label:44s}  failed: {trial.failure}")
                continue
            errors = "".join(
                f"{100 * e:8.2f}%" for e in (trial.error, *(trial.errors[n] for n in ("peak", "energy", "curve_distance")))
            )
            lines.append(f"{trial.label:44s}{errors}{trial.cost.cpu:8.2f}{trial.cost.memory:6.0f}{trial.cost.iterations:7d}")
        for accuracy in ACCURACIES:
            best = self.cheapest(accuracy)
            what = f"none of these; the reference itself is known to {100 * self.own_error:.2g} %"
            if best is not None and best.cost is not None:
                settings = " ".join(f"--set {key}={value}" for key, value in best.changes.items()) or "as it is"
                what = f"{best.label}: {settings}  ({100 * best.error:.2g} %, {best.cost.cpu:.2f} s)"
            lines.append(f"cheapest for {100 * accuracy:g} %: {what}")
        return "\n".join(lines)

    def save(self, folder: str | Path) -> None:
        """Write trade.csv, trade.png and trade.txt; SceneError where the folder cannot be written."""
        from .plots import save, trade_figure

        folder = Path(folder)
        make_folder(folder)
        text = io.StringIO()
        rows = csv.writer(text, lineterminator="\n")
        names = ("peak", "opening_at_peak", "energy", "curve_distance")
        rows.writerow(["setting", "changes", "error", *names, "cpu_s", "wall_s", "memory_mb", "iterations", "failure"])
        for trial in self.trials:
            changes = " ".join(f"{key}={value}" for key, value in trial.changes.items())
            if trial.cost is None:
                rows.writerow([trial.label, changes, *[""] * 9, trial.failure])
                continue
            cost = [f"{trial.cost.cpu:.4g}", f"{trial.cost.wall:.4g}", f"{trial.cost.memory:.4g}", trial.cost.iterations]
            errors = [f"{e:.6g}" for e in (trial.error, *(trial.errors[name] for name in names))]
            rows.writerow([trial.label, changes, *errors, *cost, ""])
        write_file(folder / "trade.csv", lambda path: write_text(path, text.getvalue()))
        write_file(folder / "trade.txt", lambda path: write_text(path, self.summary() + "\n"))
        write_file(folder / "trade.png", lambda path: save(trade_figure(self), path))


def trade(scene: Scene, executor: Executor | None = None, on_trial: Callable[[Trial], None] | None = None) -> Trade:
    """Turn the knobs of a scene one at a time, then those that pay together.

    Crack size, far size, order, shape, interface width (or the band's), quadrature, number of steps, Newton tolerance,
    reduction; the smoothing of contact and the other model, which change the physics. Errors are relative to a reference
    that is finer in everything.

    Parameters
    ----------
    scene : Scene of a built-in specimen.
    executor : runs the trials; default: processes of its own, one for each core.
    on_trial : called after each trial.

    Raises
    ------
    SceneError
        For a mesh of the user's, which has no sizes to turn.
    NotConverged
        If the reference fails.
    """
    if scene.sizes is None:
        raise SceneError("specimen.kind = 'mesh': a trade turns the sizes of the mesh; expected a built-in specimen")
    own = executor is None
    pool = executor or ProcessPoolExecutor(os.cpu_count(), multiprocessing.get_context("spawn"), max_tasks_per_child=1)
    try:
        finer, finest = (_finer(scene, _FINER * factor) for factor in (1.0, _FINER))
        futures = [pool.submit(_measured, scene.with_(**changes)) for changes in (finer, finest)]
        (reference, _), (truth, _) = (future.result() for future in futures)
        against_truth = _errors(reference, truth)
        own_error = max(against_truth[name] for name in _MEASURES)
        trials: list[Trial] = []

        def all_of(settings: Sequence[tuple[str, Changes]]) -> None:
            waiting = [(label, changes, pool.submit(_measured, scene.with_(**changes))) for label, changes in settings]
            for label, changes, future in waiting:
                try:
                    curve, cost = future.result()
                    trial = Trial(label, changes, _errors(curve, reference), cost)
                except (NotConverged, SceneError, MeshError) as error:
                    trial = Trial(label, changes, failure=str(error))
                trials.append(trial)
                if on_trial is not None:
                    on_trial(trial)

        all_of(_single(scene))
        all_of(_combined(trials))
    finally:
        if own:
            pool.shutdown(cancel_futures=True)
    energy = Pair.of(reference, reference).energy(0)
    values = {"peak": reference.peak, "opening_at_peak": reference.opening_at_peak, "energy": energy}
    return Trade(scene, values, own_error, trials)


def _measured(scene: Scene) -> tuple[Curve, Cost]:
    """Run a scene in a process of its own."""
    import gmsh  # noqa: F401  # loading it is no cost of the scene

    best_wall = best_cpu = np.inf
    begin = time.perf_counter()
    while time.perf_counter() - begin < _REPEATED or best_cpu == np.inf:  # what else the machine does only adds
        wall, cpu = time.perf_counter(), time.process_time()
        try:
            result = run(scene.with_(**{"output.frames": 0}))
        except NotConverged as error:  # what it holds of the model does not travel between processes
            error.result = None
            raise
        best_wall = min(best_wall, time.perf_counter() - wall)
        best_cpu = min(best_cpu, time.process_time() - cpu)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (2**20 if sys.platform == "darwin" else 2**10)
    return curve_of(result), Cost(best_cpu, best_wall, memory, result.iterations)


def _errors(curve: Curve, reference: Curve) -> dict[str, float]:
    """Relative errors of a curve."""
    pair = Pair.of(curve, reference)
    return {
        "peak": abs(curve.peak / reference.peak - 1.0),
        "opening_at_peak": abs(curve.opening_at_peak / reference.opening_at_peak - 1.0),
        "energy": abs(pair.energy(0) / pair.energy(1) - 1.0),
        "curve_distance": pair.between() / pair.under(1),
    }


def _width(scene: Scene) -> tuple[str, float]:
    """Key and value of the crack plane's width."""
    if scene.model.kind == "smeared":
        return "band.width", scene.band_width
    width = scene.interface.width
    if isinstance(width, str):
        return "interface.width", scene.material.h
    return "interface.width", width or default_width(_crack_length(scene), scene.material)


def _crack_length(scene: Scene) -> float:
    return path_length("crack", scene.specimen.paths)  # type: ignore[union-attr]


def _sized(scene: Scene, factor: float) -> Changes:
    """Crack size times a factor; a band keeps square elements, and the far size stays above."""
    assert scene.sizes is not None
    size = scene.sizes.crack_size * factor
    changes: Changes = {"mesh.crack_size": size, "mesh.far_size": max(size, scene.sizes.far_size)}
    if scene.model.kind == "smeared" and scene.band.width is not None:
        changes["band.width"] = scene.band.width * factor
    return changes


def _stepped(scene: Scene, factor: float) -> Changes:
    changes: Changes = {}
    for i, stage in enumerate(scene.stages):
        if stage.step is not None:
            changes[f"stage.{i}.step"] = stage.step / factor
        else:
            changes[f"stage.{i}.steps"] = max(1, round(stage.count(0.0) * factor))
    return changes


def _finer(scene: Scene, factor: float) -> Changes:
    """Finer in everything."""
    assert scene.sizes is not None
    key, width = _width(scene)
    far = max(scene.sizes.far_size / factor, scene.sizes.crack_size / factor)
    changes = {"mesh.crack_size": scene.sizes.crack_size / factor, "mesh.far_size": far, "solver.tol": 1e-7}
    return changes | {key: width / factor} | _stepped(scene, factor)


def _single(scene: Scene) -> list[tuple[str, Changes]]:
    """The scene as it is, and each knob alone."""
    assert scene.sizes is not None
    sizes = scene.sizes
    key, width = _width(scene)
    found: list[tuple[str, Changes]] = [("as it is", {})]
    found += [(f"crack size x {f:g}", _sized(scene, f)) for f in (4.0, 2.0, 0.5)]
    found += [(f"far size x {f:g}", {"mesh.far_size": max(sizes.far_size * f, sizes.crack_size)}) for f in (2.0, 0.5)]
    found.append((f"order {3 - sizes.order}", {"mesh.order": 3 - sizes.order}))
    shape = "quad" if sizes.shape == "triangle" else "triangle"
    found.append((f"shape {shape}", {"mesh.shape": shape}))
    found += [(f"width x {f:g}", {key: width * f}) for f in (4.0, 2.0, 0.5, 0.25)]
    if scene.model.kind == "discrete":
        quadrature = "gauss" if scene.interface.quadrature == "nodal" else "nodal"
        found.append((f"quadrature {quadrature}", {"interface.quadrature": quadrature}))
    found += [(f"steps x {f:g}", _stepped(scene, f)) for f in (0.125, 0.25, 0.5, 2.0)]
    found += [(f"tolerance {tol:g}", {"solver.tol": tol}) for tol in (1e-2, 1e-3, 1e-6)]
    if scene.solver.reduction != "none":
        found.append(("reduction none", {"solver.reduction": "none"}))
    found += [(f"smoothing c_zn {c:g}", {"material.c_zn": c}) for c in (5.0, 9.0, 50.0) if c != scene.material.c_zn]
    other = "smeared" if scene.model.kind == "discrete" else "discrete"
    found.append((f"model {other}", {"model.kind": other, "model.half": False}))
    if getattr(scene.specimen, "is_symmetric", False) and scene.model.kind == "discrete" and not scene.model.half:
        found.append(("half", {"model.half": True}))
    return found


def _combined(trials: Sequence[Trial]) -> list[tuple[str, Changes]]:
    """For each accuracy the cheapest value of each knob whose own error leaves room for the others."""
    base = trials[0]
    found: list[tuple[str, Changes]] = []
    for accuracy in ACCURACIES:
        by_knob: dict[str, Trial] = {}
        for trial in trials[1:]:
            knob = trial.label.rsplit(" ", 1)[0].removesuffix(" x")
            if (
                knob in ("model", "smoothing c_zn")
                or trial.cost is None
                or base.cost is None
                or trial.error > max(_SHARE * accuracy, base.error)
            ):
                continue
            if trial.cost.cpu < min(_WORTH * base.cost.cpu, getattr(by_knob.get(knob), "cost", base.cost).cpu):
                by_knob[knob] = trial
        changes: Changes = {}
        for trial in by_knob.values():
            changes |= trial.changes
        if len(by_knob) > 1 and all(changes != old for _, old in found):
            found.append((f"for {100 * accuracy:g} %: " + ", ".join(t.label for t in by_knob.values()), changes))
    return found
