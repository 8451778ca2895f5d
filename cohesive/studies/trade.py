"""Accuracy against cost: one scene with one setting changed at a time, then the promising ones together."""

from __future__ import annotations

import csv
import json
import math
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from pathlib import Path

from meshing.errors import MeshError

from ..errors import NotConverged, SceneError
from ..results.files import make_folder, write_file, write_table, write_text
from ..scenes.scene import Scene
from .curves import Curve, Pair
from .parameters import Settings, changes, label, single
from .pool import processes
from .trials import ERRORS, MEASURES, Cost, SweepSetting, errors, measured

#: errors for which the cheapest setting is named
ACCURACIES = (0.05, 0.01, 0.002)

#: a setting joins a combination for an accuracy if changed alone it loses no more than this part of it
_SHARE = 0.25

#: and if it takes less than this part of the CPU time
_WORTH = 0.9

#: the reference is finer by this factor in everything, and its error is that of a run half as fine against it
_FINER = 4.0

#: in 3D, by at least and at most these, because 4 would be 64 times the elements; between them so that the crack has about
#: this number of elements
_FINER_IN_3D, _ON_CRACK = (1.5, 2.5), 350

#: CPU times up to this ratio are alike: the machine has other things to do
_ALIKE = 1.2

#: errors on another scene of the same kind are taken for larger by this factor
_ELSEWHERE = 3.0

#: between rows the place of a peak is found to this part of it: on sixteen built-in scenes, with four rows or more, to .9 %
_PLACE = 0.01


@dataclass(frozen=True)
class Trade:
    """All trials of a scene, a summary in words, and the files.

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
        front: list[SweepSetting] = []
        runs = [(trial.cost.cpu, trial.error, trial) for trial in self.trials if trial.cost and trial.is_same_problem]
        for _, error, trial in sorted(runs, key=lambda entry: entry[:2]):
            if not front or error < front[-1].error:
                front.append(trial)
        return front

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

    def promised_place(self, trial: SweepSetting, elsewhere: bool = False) -> float:
        """Error of the place of the peak that a trial promises, with that of the reference added: what lies between it and the
        run that is half as fine."""
        finer = [each.errors["at_peak"] for each in self.trials if each.errors and [*each.settings] == ["finer"]]
        return max(_PLACE, (_ELSEWHERE if elsewhere else 1.0) * trial.errors["at_peak"] + max(finer, default=0.0))

    def cheapest(
        self, accuracy: float, elsewhere: bool = False, among: Sequence[SweepSetting] | None = None
    ) -> SweepSetting | None:
        """The cheapest trial (of some; default: of all) that promises at most this error; among those that are as cheap, the
        most accurate."""
        trials = self.trials if among is None else among
        runs = [(trial, trial.cost.cpu) for trial in trials if trial.cost and trial.is_same_problem]
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
            numbers = "".join(f"{100 * e:8.2f}%" for e in (trial.error, *(trial.errors[name] for name in MEASURES)))
            lines.append(
                f"{trial.label:{width}s}{numbers}{trial.cost.cpu:8.2f}{trial.cost.memory:6.0f}{trial.cost.iterations:7d}"
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
        """Write trade.csv, trade.png and trade.txt; SceneError if the folder cannot be written."""
        from ..figures.drawing import save  # with matplotlib, which is slow to import
        from .figures import trade_figure

        runs = [(trial, trial.cost.cpu, self.promise(trial)) for trial in self.trials if trial.cost is not None]
        figure = trade_figure(self.scene.title, runs, self.pareto_front(), self.own_error)
        folder = Path(folder)
        make_folder(folder)
        names = ["setting", "error", *ERRORS, "cpu_s", "wall_s", "memory_mb", "iterations", "failure", "settings"]
        facts = {"scene": self.scene.data, "reference": self.reference, "own_error": self.own_error}
        write_table(folder / "trade.csv", names, self._rows(), comment=json.dumps(facts))
        write_text(folder / "trade.txt", self.summary() + "\n")
        write_file(folder / "trade.png", lambda path: save(figure, path))

    def _rows(self) -> Iterator[list[object]]:
        """One row for each trial."""
        for trial in self.trials:
            numbers: list[object] = [""] * 9
            if trial.cost is not None:
                cost = trial.cost
                numbers = [f"{e:.6g}" for e in (trial.error, *(trial.errors[name] for name in ERRORS))]
                numbers += [f"{cost.cpu:.4g}", f"{cost.wall:.4g}", f"{cost.memory:.4g}", cost.iterations]
            yield [trial.label, *numbers, trial.failure, json.dumps(trial.settings)]

    @classmethod
    def load(cls, path: str | Path) -> Trade:
        """The trade of a trade.csv; SceneError if it is none."""
        try:
            with open(path, newline="", encoding="utf-8") as file:
                facts = json.loads(file.readline().removeprefix("#"))
                trials = []
                for row in csv.DictReader(file):
                    measured_errors, cost = {}, None
                    if not row["failure"]:
                        measured_errors = {name: float(row[name]) for name in ERRORS}
                        cpu, wall, memory = (float(row[name]) for name in ("cpu_s", "wall_s", "memory_mb"))
                        cost = Cost(cpu, wall, memory, int(row["iterations"]))
                    trials.append(SweepSetting(json.loads(row["settings"]), measured_errors, cost, row["failure"]))
            return cls(Scene(facts["scene"]), facts["reference"], float(facts["own_error"]), trials)
        except OSError as error:
            raise SceneError(f"'{path}': cannot be read: {error.strerror}") from None
        except (ValueError, KeyError, TypeError) as error:
            raise SceneError(f"'{path}': not a table of this version of `cohesive trade`: {error}") from None


def trade(
    scene: Scene,
    executor: Executor | None = None,
    on_trial: Callable[[SweepSetting], None] | None = None,
    settings: Iterable[str] | None = None,
    knobs: Iterable[str] | None = None,
) -> Trade:
    """Change the settings of a scene one at a time, then those that pay together.

    Crack size, far size, layers, order, shape, interface width (or the band's), quadrature, number of steps and how far they
    may grow, Newton tolerance, condensation; the smoothing of contact and the other model, which change the physics. Errors
    are relative to a reference that is finer in everything: four times in 2D, 1.5 to 2.5 times in 3D.

    Parameters
    ----------
    scene : Scene of a built-in specimen.
    executor : runs the trials, as that of a Dask client does; default: one process for each core. If its workers run more
        than one trial, the memory of a trial is the largest so far.
    on_trial : called after each trial.
    settings : those that are changed, of `parameters.SETTINGS`; default: all.
    knobs : the old name of `settings`, for one release.

    Raises
    ------
    SceneError
        For a user mesh, which has no sizes to change, or an unknown setting.
    NotConverged
        If the reference fails.
    """
    if knobs is not None:
        warnings.warn("trade(knobs=...) is now trade(settings=...)", DeprecationWarning, stacklevel=2)
        settings = knobs if settings is None else settings
    if scene.sizes is None:
        raise SceneError(
            "specimen.kind = 'mesh': a trade measures against a finer mesh, which a file does not give; expected a built-in "
            "specimen, or `cohesive run` with files of two sizes, whose difference tells the error of the mesh",
            "specimen.kind",
        )
    bare = Scene({key: value for key, value in scene.data.items() if key not in ("reference", "output")}, scene.folder)
    alone = single(bare, settings)
    most = finest(bare)
    waiting: list[tuple[Settings, Future[tuple[Curve, Cost]]]] = []
    with processes(executor) as pool:

        def submit(several: Iterable[Settings]) -> None:
            waiting.extend((each, pool.submit(measured, bare, each)) for each in several)

        def done(begin: int) -> list[SweepSetting]:
            trials_done = []
            for each, future in waiting[begin:]:
                trials_done.append(_trial(each, future, reference))
                if on_trial is not None:
                    on_trial(trials_done[-1])
            return trials_done

        try:
            submit({"finer": factor} for factor in (most, most / 2))  # the longest first
            submit([{}, *alone])
            (reference, _), (half_as_fine, _) = (future.result() for _, future in waiting[:2])
            own_error = max(errors(half_as_fine, reference)[name] for name in MEASURES)
            finest_trial, finer_trial, *trials = done(0)
            begin = len(waiting)
            submit(combined(trials, own_error, (finer_trial, finest_trial)))
            trials += [*done(begin), finer_trial, finest_trial]
        finally:
            for _, future in waiting:
                future.cancel()
    return Trade(bare, _values(reference), own_error, trials)


def _values(reference: Curve) -> dict[str, float]:
    """Peak (N), its place on the measure in charge (mm) and energy (N mm) of the reference."""
    energy = Pair.from_curves(reference, reference).energy(0)
    return {"peak": reference.peak, "at_peak": reference.at_peak, "energy": energy}


def _trial(settings: Settings, future: Future[tuple[Curve, Cost]], reference: Curve) -> SweepSetting:
    """The trial of settings that were submitted, when it is done."""
    try:
        curve, cost = future.result()
    except (NotConverged, SceneError, MeshError) as error:
        return SweepSetting(settings, failure=str(error))
    return SweepSetting(settings, errors(curve, reference), cost)


def finest(scene: Scene) -> float:
    """By what factor the reference is finer than the scene."""
    if not scene.is_solid:
        return _FINER
    sizes = scene.sizes
    assert sizes is not None
    across = sizes.crack_size
    if scene.is_extruded:
        thickness = scene.crack_area / scene.crack_length
        across = thickness / sizes.layers_through(thickness)
    elements = scene.crack_area / (sizes.crack_size * across)
    least, most = _FINER_IN_3D
    return round(min(most, max(least, math.sqrt(_ON_CRACK / elements))), 1)


def combined(trials: Sequence[SweepSetting], own_error: float, finer: Sequence[SweepSetting]) -> list[Settings]:
    """Settings that are promising together, for each accuracy.

    Each setting takes its cheapest value whose own loss leaves room for the others. They are changed on the scene as it is, or
    on a finer one if that does not reach the accuracy.
    """
    base = trials[0]
    combinations: list[Settings] = []
    for accuracy in ACCURACIES:
        start = next((each for each in (base, *finer) if each.error + own_error <= accuracy), None)
        if start is None or base.cost is None:
            continue
        by_name: dict[str, SweepSetting] = {}
        for trial in trials[1:]:
            if not trial.is_same_problem or trial.cost is None or trial.error > base.error + _SHARE * accuracy:
                continue
            (name,) = trial.settings
            if trial.cost.cpu < min(_WORTH * base.cost.cpu, getattr(by_name.get(name), "cost", base.cost).cpu):
                by_name[name] = trial
        settings = dict(start.settings)
        for trial in by_name.values():
            settings |= trial.settings
        if len(settings) > 1 and settings not in combinations:
            combinations.append(settings)
    return combinations
