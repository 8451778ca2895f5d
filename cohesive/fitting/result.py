"""The outcome of a fit: numbers, intervals, minima, what it says and what it writes."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import Array
from ..measured.evaluation import Evaluation, without_mass
from ..outcome.result import Result
from ..results.files import make_folder, write_scene, write_table, write_text
from ..results.inputs import copy_inputs
from ..scenes.scene import Scene, dump_toml
from ..simulation import run
from .export import EXPORTS
from .intervals import Statistics, interval_words
from .known_errors import MeshPart
from .noise import sentences
from .parameters import OFFSET
from .problem import FAILURES, FitEvaluation, FitProblem

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: an interval's kind in words
_KINDS = {"profile": "profile likelihood", "covariance": "covariance", "feasible": "all rows in the band",
          "unknown": "not known"}  # fmt: skip

#: part of a band's bound up to which a point counts as near it
_NEAR = 0.03


@dataclass(frozen=True, eq=False)
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


class Fit:
    """The outcome of a fit: numbers with intervals of 95 %, and what the test does not see.

    Attributes
    ----------
    values : {key: number}; of a number that each scene has of its own, KEY@1, KEY@2
    intervals : {key: (low, high)}
    interval_kind : "profile", "covariance", or, if every row of a measured band is met, "feasible": the set of numbers that
        meet it; "unknown", and the intervals NaN, if some rows of a band are not met and no profile was asked for, or they are
        too few for it
    mesh_errors : {key: what the mesh may have moved the number by}, NaN if no finer mesh was run; goes into the intervals
    correlation : (m, m) array, in the order of `values`
    identifiable : sentences on what the test does not see
    rms : root of the mean square of the residuals over the largest measured load
    minima : list of Minimum, all distinct ones, the best first
    effective_rows : how many independent residuals those of the fit are worth
    notes : remarks, those of the runs with the fitted numbers among them
    best : FitEvaluation with the fitted numbers
    runs, condensations, sensitivities : work of the fit
    """

    def __init__(
        self,
        scenes: Sequence[Scene],
        problem: FitProblem,
        minima: list[Minimum],
        best: FitEvaluation,
        statistics: Statistics,
        ends: Array,
        kind: str,
        words: list[str],
        mesh: MeshPart,
    ) -> None:
        self.problem, self.minima, self.best, self.statistics = problem, minima, best, statistics
        self.values = minima[0].values
        self.rms = minima[0].rms
        self.interval_kind, self.identifiable, self.correlation = kind, words, statistics.correlation
        self.intervals = {
            each.name: (each.value(float(low)), each.value(float(high)))
            for each, (low, high) in zip(problem.parameters, ends, strict=True)
        }
        self.effective_rows = statistics.count
        self.runs = sum(repeated.runs for repeated in problem.repeated)
        self.condensations = sum(repeated.condensations for repeated in problem.repeated)
        self.sensitivities = sum(repeated.sensitivities for repeated in problem.repeated)
        self._given = list(scenes)
        self.mesh_errors = {
            each.name: abs(each.value(float(at + error)) - each.value(float(at)))
            for each, at, error in zip(problem.parameters, minima[0].z, mesh.error, strict=True)
        }
        self.notes = self._reading_notes() + sentences(problem.data, problem.noises) + self._fixed_note() + self._run_notes()
        self.notes += self._minima_notes() + list(mesh.notes)

    @cached_property
    def scenes(self) -> list[Scene]:
        """The scenes with the fitted numbers, and with the offsets of their curves if these were varied."""
        values = [self.problem.values(self.best.z, i) | self._offsets(i) for i in range(len(self._given))]
        return [scene.with_(**each) for scene, each in zip(self._given, values, strict=True)]

    def _offsets(self, i: int) -> dict[str, Any]:
        """The offsets of the curves that a scene names, if they were varied."""
        if self._given[i].reference is None or all(each.curve is None for each in self.problem.parameters):
            return {}
        offsets = [float(offset) for offset in self.problem.offsets(self.best.z, i)]
        return {OFFSET: offsets if len(offsets) > 1 else offsets[0]}

    @cached_property
    def evaluations(self) -> list[Evaluation]:
        """What each measured curve of a notched beam says without a model, to stand beside the fitted numbers."""
        evaluations = []
        for scene, data in zip(self._given, self.problem.data, strict=True):
            each = [without_mass(curve, scene.given("specimen")) for curve in data.curves]
            evaluations += [one for one in each if one is not None]
        return evaluations

    @property
    def scene(self) -> str:
        """The fitted scene as TOML; of several, the first one."""
        return dump_toml(self.scenes[0].data)

    @cached_property
    def results(self) -> list[Result]:
        """A run of each scene with the fitted numbers, on the mesh and at the places of the fit, which its scene names."""
        return [run(rows.scene.with_(**self._offsets(i))) for i, rows in enumerate(self.best.rows)]

    def curve_samples(self, scene: int = 0, count: int = 200) -> list[Any]:
        """Softening curves of numbers drawn from the covariance, those that are curves; the fitted one first."""
        z = self.best.z
        draws = np.random.default_rng(0).multivariate_normal(z, self.statistics.covariance, count)
        low, high = np.array([each.bounds for each in self.problem.parameters]).T
        curves = [self.scenes[scene].material.curve]
        for draw in draws:
            try:
                values = self.problem.values(np.clip(draw, low, high), scene)
                curves.append(self._given[scene].with_(**values).material.curve)
            except FAILURES:
                continue
        return curves

    def summary(self) -> str:
        """The printed summary."""
        lines = [f"fit of {len(self.problem.parameters)} numbers to {sum(len(d.x) for d in self.problem.data)} measured rows"]
        for data, load in zip(self.problem.data, self.best.loads, strict=True):
            if any(curve.is_band for curve in data.curves):
                near = f"{data.inside(load, _NEAR)} within {100 * _NEAR:.0f} % of it"
                lines.append(f"{data.inside(load)} of {len(load)} points inside the band, {near}")
        worth = f"the residuals are worth {self.effective_rows:.1f} independent ones"
        lines.append(f"rms {100 * self.rms:.2f} % of the peak; {worth}")
        width = max(len(name) for name in self.values)
        for name, value in self.values.items():
            mesh, part = self.mesh_errors[name], ""
            if not np.isnan(mesh):
                part = f"  mesh {mesh:.2g}" if name.startswith(OFFSET) else f"  mesh {100 * mesh / abs(value):.2g} %"
            lines.append(f"  {name:<{width}}  {value:<10.4g} {interval_words(*self.intervals[name]):<24}{part}".rstrip())
        lines[-len(self.values) - 1] += f"; intervals of 95 % ({_KINDS[self.interval_kind]}):"
        lines += [f"identifiable: {words}" for words in self.identifiable]
        lines += self.notes
        lines += [line for one in self.evaluations for line in one.summary().splitlines()]
        lines.append(f"work: {self.runs} runs, {self.sensitivities} with derivatives, {self.condensations} condensation(s)")
        return "\n".join(lines)

    def _facts(self) -> dict[str, Any]:
        """What fit.json says."""
        return {
            "values": self.values,
            "intervals": {name: [_known(end) for end in ends] for name, ends in self.intervals.items()},
            "mesh_errors": {name: _known(error) for name, error in self.mesh_errors.items()},
            "noise": [None if noise is None else asdict(noise) for noise in self.problem.noises],
            "interval_kind": self.interval_kind,
            "correlation": self.correlation.tolist(),
            "identifiable": self.identifiable,
            "rms": self.rms,
            "effective_rows": self.effective_rows,
            "loss": self.problem.loss,
            "minima": [
                {"values": one.values, "rms": one.rms, "starts": one.starts, "evaluations": one.evaluations}
                for one in self.minima
            ],
            "work": {"runs": self.runs, "sensitivities": self.sensitivities, "condensations": self.condensations},
            "notes": self.notes,
            "evaluations": [{"curve": one.name, "values": one.values} for one in self.evaluations],
            "scenes": [scene.title for scene in self.scenes],
        }

    def plot(self) -> Figure:
        """Curve over data, residuals, and the softening curve with its band of confidence."""
        from .figures import draw  # with matplotlib, which is slow to import

        count = 200 if self.interval_kind not in ("feasible", "unknown") else 0  # a set of numbers has no covariance
        draws = partial(self.curve_samples, count=count)
        return draw(self.problem, self.best, self.scenes, draws, self.values, self.intervals)

    def save(self, folder: str | Path) -> None:
        """Write fit.png, fit.csv, fit.json, the fitted scenes, and the softening curve as input of Abaqus, DIANA and ATENA.

        Raises
        ------
        SceneError
            If the folder cannot be written.
        """
        from ..figures.drawing import save as save_figure  # with matplotlib, which is slow to import
        from ..figures.drawing import write_figure

        folder, figure = Path(folder), self.plot()
        make_folder(folder)
        output = self.scenes[0].output
        write_figure(folder / "fit.png", lambda path: save_figure(figure, path, output, dpi=150), output)
        write_text(folder / "fit.json", json.dumps(self._facts(), indent=2, default=float) + "\n")
        names = ["scene", "curve", "x_mm", "measured_N", "low_N", "high_N", "computed_N"]
        write_table(folder / "fit.csv", names, self._rows())
        material = self.scenes[0].material
        for name, (suffix, text_of) in EXPORTS.items():
            write_text(folder / f"softening-{name}{suffix}", text_of(material))
        for i, scene in enumerate(self.scenes, start=1):
            home = folder if len(self.scenes) == 1 else folder / f"scene-{i}"
            make_folder(home)
            write_scene(scene, copy_inputs(scene, home), home)

    def _rows(self) -> Iterator[list[object]]:
        """Measured and computed loads, row by row."""
        for i, (data, load) in enumerate(zip(self.problem.data, self.best.loads, strict=True), start=1):
            names = np.repeat([curve.name for curve in data.curves], np.bincount(data.curve))
            x = self.problem.rows(self.best.z, i - 1).x
            for row in zip(names, x, data.middle, data.low, data.high, load, strict=True):
                yield [i, row[0], *(f"{value:.8g}" for value in row[1:])]

    def _reading_notes(self) -> list[str]:
        """What the reader says of the measured curves."""
        curves = [curve for data in self.problem.data for curve in data.curves]
        return list(dict.fromkeys(f"{curve.name}: {note}" for curve in curves for note in curve.notes))

    def _fixed_note(self) -> list[str]:
        sentences = []
        for repeated in self.problem.repeated:
            sizes, width = repeated.scene.sizes, repeated.scene.interface.width
            mesh = "" if sizes is None else f"crack_size {sizes.crack_size:.4g}, far_size {sizes.far_size:.4g} mm"
            plane = "" if width is None or isinstance(width, str) else f"width of the crack plane {width:.4g} mm"
            text = ", ".join(part for part in (mesh, plane) if part)
            sentences.append(f"kept for the whole fit: {text}")
        return list(dict.fromkeys(sentences))

    def _run_notes(self) -> list[str]:
        """What the runs with the fitted numbers say."""
        several = len(self.scenes) > 1
        return [
            f"{scene.title}: {note}" if several else note
            for scene, rows in zip(self.scenes, self.best.rows, strict=True)
            for note in rows.notes
        ]

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


def _known(value: float) -> float | None:
    """A number as JSON has it, which knows no NaN."""
    return None if np.isnan(value) else value
