"""What a fit leaves behind: numbers, intervals, minima, and what follows from them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..arrays import Array
from ..measured.evaluation import Evaluation, without_mass
from ..results.result import Result
from ..scenes.scene import Scene, dump_toml
from ..simulation import run
from .fit_intervals import Statistics
from .fit_problem import FAILURES, FitProblem, Trial, at_rows
from .repeated_run import RepeatedRun


@dataclass(frozen=True)
class Minimum:
    """A place where the fit cannot get better nearby.

    Attributes
    ----------
    z : (m,) array, the numbers as the optimiser sees them
    cost : sum of squares of the residuals
    values : {name: number}
    rms : over the largest measured load
    evaluations : runs from its start
    starts : from how many starts it was found; 0: from none, it is only the lowest place that was met
    """

    z: Array
    cost: float
    values: dict[str, float]
    rms: float
    evaluations: int
    starts: int

    def met_again(self) -> Minimum:
        """The same, found from one more start."""
        return replace(self, starts=self.starts + 1)


class Fitted:
    """Fitted numbers, with intervals of 95 % and what the test does not see.

    Attributes
    ----------
    values : {key: number}; of a number that each scene has of its own, KEY@1, KEY@2
    intervals : {key: (low, high)}
    interval_kind : "profile", "covariance", or, if every row of a measured band is met, "feasible": the set of numbers that
        meet it
    correlation : (m, m) array, in the order of `values`
    identifiable : sentences on what the test does not see
    rms : root of the mean square of the residuals over the largest measured load
    minima : list of Minimum, all distinct ones, the best first
    effective_rows : how many independent residuals those of the fit are worth
    notes : remarks
    runs, condensations, sensitivities : work of the fit
    """

    def __init__(
        self,
        scenes: Sequence[Scene],
        problem: FitProblem,
        minima: list[Minimum],
        trial: Trial,
        found: Statistics,
        ends: Array,
        kind: str,
        words: list[str],
        check: bool,
    ) -> None:
        self.problem, self.minima, self.trial, self.statistics = problem, minima, trial, found
        self.values = minima[0].values
        self.rms = minima[0].rms
        self.interval_kind, self.identifiable, self.correlation = kind, words, found.correlation
        self.intervals = {
            each.name: (each.value(float(low)), each.value(float(high)))
            for each, (low, high) in zip(problem.parameters, ends, strict=True)
        }
        self.effective_rows = found.count
        self.runs = sum(repeated.runs for repeated in problem.repeated)
        self.condensations = sum(repeated.condensations for repeated in problem.repeated)
        self.sensitivities = sum(repeated.sensitivities for repeated in problem.repeated)
        self._given = list(scenes)
        self.notes = self._reading_notes() + self._fixed_note() + self._minima_notes() + (self._checked() if check else [])

    @cached_property
    def scenes(self) -> list[Scene]:
        """The scenes with the fitted numbers."""
        return [scene.with_(**self.problem.values(self.trial.z, i)) for i, scene in enumerate(self._given)]

    @cached_property
    def evaluations(self) -> list[Evaluation]:
        """What each measured curve of a notched beam says without a model, to stand beside the fitted numbers."""
        found = []
        for scene, data in zip(self._given, self.problem.data, strict=True):
            each = [without_mass(curve, scene.given("specimen")) for curve in data.curves]
            found += [one for one in each if one is not None]
        return found

    @property
    def scene(self) -> str:
        """The fitted scene as TOML; of several, the first one."""
        return dump_toml(self.scenes[0].data)

    @cached_property
    def results(self) -> list[Result]:
        """A run of each scene with the fitted numbers, on the mesh of the fit."""
        found = []
        for i, repeated in enumerate(self.problem.repeated):
            stages = [asdict(stage) for stage in self.problem.stages[i]]
            found.append(run(repeated.scene.with_(**self.problem.values(self.trial.z, i), stage=stages)))
        return found

    def curve_samples(self, scene: int = 0, count: int = 200) -> list[Any]:
        """Softening curves of numbers drawn from the covariance, those that are curves; the fitted one first."""
        z = self.trial.z
        draws = np.random.default_rng(0).multivariate_normal(z, self.statistics.covariance, count)
        low, high = np.array([each.bounds for each in self.problem.parameters]).T
        found = [self.scenes[scene].material.curve]
        for draw in draws:
            try:
                values = self.problem.values(np.clip(draw, low, high), scene)
                found.append(self._given[scene].with_(**values).material.curve)
            except FAILURES:
                continue
        return found

    def _reading_notes(self) -> list[str]:
        curves = [curve for data in self.problem.data for curve in data.curves]
        return list(dict.fromkeys(f"{curve.name}: {note}" for curve in curves for note in curve.notes))

    def _fixed_note(self) -> list[str]:
        found = []
        for repeated in self.problem.repeated:
            sizes, width = repeated.scene.sizes, repeated.scene.interface.width
            mesh = "" if sizes is None else f"crack_size {sizes.crack_size:.4g}, far_size {sizes.far_size:.4g} mm"
            plane = "" if width is None or isinstance(width, str) else f"width of the crack plane {width:.4g} mm"
            text = ", ".join(part for part in (mesh, plane) if part)
            found.append(f"kept for the whole fit: {text}")
        return list(dict.fromkeys(found))

    def _minima_notes(self) -> list[str]:
        if not self.minima[0].starts:
            return [
                "warning: no start ends in a minimum, each is stopped by numbers with which the scene does not run, or by "
                "a snap; expected other bounds, or more starts"
            ]
        if len(self.minima) == 1:
            return []
        others = "; ".join(
            f"rms {100 * one.rms:.2f} % with " + ", ".join(f"{name} {value:.4g}" for name, value in one.values.items())
            for one in self.minima[1:]
        )
        return [f"{len(self.minima)} distinct minima; the others: {others}"]

    def _checked(self) -> list[str]:
        """How far the loads are off with the mesh and the width that the rule gives with the fitted numbers."""
        largest = 0.0
        for i, (scene, data) in enumerate(zip(self.scenes, self.problem.data, strict=True)):
            repeated = RepeatedRun(scene)
            if repeated.scene.data == self.problem.repeated[i].scene.with_(**self.problem.values(self.trial.z, i)).data:
                continue
            try:
                load, _ = at_rows(repeated.run({}, self.problem.stages[i]), data)
            except FAILURES as error:
                return [f"warning: the fit does not run with the mesh of the rule: {error}"]
            largest = max(largest, float(abs(load - self.trial.loads[i]).max()) / data.peak)
        if not largest:
            return []
        off = 100.0 * largest
        return [f"with mesh and width by the rule for the fitted numbers, loads differ by at most {off:.2f} % of the peak"]
