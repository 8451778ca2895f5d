"""Do intervals of 95 % hold the truth 95 times of 100? Synthetic noisy files, fitted on the mesh that they come from.

A beam after EN 14651 with E 36 GPa, ft 3.9 MPa, Gf 0.16 N/mm and Hordijk's curve, driven by its crack mouth opening: files of
24 rows with 2 % of the peak as noise of the load, and of 200 and 5000 rows with .5 um of noise in the opening and 25 N in the
load. E, ft and Gf are fitted from a start that is off. The history is taken as linear in the logarithms of the three about the
truth, in 300 files of each length, which leaves all of the fit but its runs; whole fits of 3 files check that.

Expected: each interval holds the truth in 90 to 98 % of the files, and the mean is off by less than half a standard deviation.

    python -m examples.coverage [-o DIR]
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import Akima1DInterpolator

from cohesive import Measured, Scene, fit
from cohesive.arrays import Array
from cohesive.figures.drawing import new_figure, save
from cohesive.fitting.data import Data
from cohesive.fitting.fit import weighed_minima
from cohesive.fitting.intervals import covariance_ends, statistics
from cohesive.fitting.parameters import varied
from cohesive.fitting.problem import FitProblem
from cohesive.fitting.repeated_run import RepeatedRun, Rows
from cohesive.measured.curve import Reference
from cohesive.solver.stages import Stage
from examples.command import command

TRUTH = {"material.E": 36e3, "material.ft": 3.9, "material.Gf": 0.16}
START = {"material.E": 33e3, "material.ft": 3.3, "material.Gf": 0.14}
VARY = {"material.E": (15e3, 60e3), "material.ft": (1.0, 8.0), "material.Gf": (0.03, 0.4)}

#: noise of the opening (mm) and of the load (part of the peak) by the number of rows
NOISES = {24: (0.0, 0.02), 200: (0.5e-3, 1.5e-3), 5000: (0.5e-3, 1.5e-3)}


@dataclass(frozen=True)
class Coverage:
    """What some files of one length show, by key.

    Attributes
    ----------
    held : part of the intervals that hold the truth
    bias : mean of the fitted number less the truth, over its standard deviation
    deviation : standard deviation over the truth
    seconds : CPU time of one whole fit; nan if there is none
    apart : largest distance of a whole fit from the linear one, over the standard deviation
    """

    held: dict[str, float]
    bias: dict[str, float]
    deviation: dict[str, float]
    seconds: float
    apart: float


def beam(order: int = 2, size: float = 5.0) -> Scene:
    """The beam with elements of some size along its crack (mm)."""
    return Scene(
        {
            "title": "beam after EN 14651",
            "specimen": {
                "kind": "notched-beam", "length": 550.0, "span": 500.0, "depth": 150.0, "thickness": 150.0, "notch": 25.0,
            },
            "mesh": {"crack_size": size, "far_size": 25.0, "order": order},
            "interface": {"width": 0.5},
            "material": {"E": 36e3, "nu": 0.2, "ft": 3.9, "Gf": 0.16, "softening": "hordijk"},
            "stage": [{"control": "cmod", "to": [0.1, 2.0], "steps": 40}],
        }
    )  # fmt: skip


@dataclass
class LinearRun:
    """In place of a `RepeatedRun`: loads over the opening that are linear in the logarithms of the numbers.

    Attributes
    ----------
    scene : as it was run
    load, slopes : of the openings; slopes by key, N
    """

    scene: Scene
    load: Akima1DInterpolator
    slopes: Mapping[str, Akima1DInterpolator]
    most: int | None = None

    @classmethod
    def about(cls, scene: Scene, openings: Sequence[float]) -> LinearRun:
        """About the numbers of a scene, from a run that stands at many openings."""
        repeated = RepeatedRun(scene)
        stage = replace(scene.stages[0], to=list(openings), steps=1)
        rows = repeated.run({}, [stage])
        x = np.r_[0.0, rows.history["cmod"]]
        rates = repeated.derivatives(rows, {}, list(TRUTH))
        slopes = {key: Akima1DInterpolator(x, np.r_[0.0, rates[key]["load"] * TRUTH[key]]) for key in TRUTH}
        return cls(repeated.scene, Akima1DInterpolator(x, np.r_[0.0, rows.history["load"]]), slopes)

    def run(self, values: Mapping[str, float], stages: Sequence[Stage]) -> Any:
        """The rows at the targets of the stages."""
        x = np.concatenate([stage.targets for stage in stages])
        load = self.load(x) + sum(np.log(values[key] / TRUTH[key]) * slope(x) for key, slope in self.slopes.items())
        scene = self.scene.with_(stage=[stage.data for stage in stages])
        return Rows(scene, None, [], [], [], {"cmod": x, "load": load})  # type: ignore[arg-type]

    def is_exact(self, keys: Sequence[str], stages: Sequence[Stage]) -> bool:
        """Whether the rows are differentiated: they always are."""
        return True

    def derivatives(self, rows: Rows, values: Mapping[str, float], keys: Sequence[str], energies: bool) -> dict[str, Any]:
        """Derivatives of the rows in some keys."""
        x = rows.history["cmod"]
        return {key: {"cmod": 0.0 * x, "load": self.slopes[key](x) / values[key]} for key in keys}


def noisy(model: LinearRun, rows: int, seed: int) -> Measured:
    """A file of so many rows, half of them up to .15 mm."""
    random, half = np.random.default_rng(seed), rows // 2
    x = np.r_[np.linspace(0.0, 0.15, half + 1)[1:], np.linspace(0.15, 2.0, rows - half + 1)[1:]]
    of_opening, of_load = NOISES[rows]
    y = model.load(x)
    load = y + of_load * y.max() * random.normal(size=rows)
    return Measured.from_curve(x + of_opening * random.normal(size=rows), load, f"file {seed}", "cmod")


def linear_fit(model: LinearRun, measured: Measured) -> tuple[Array, Array]:
    """Numbers and ends of their intervals, (3,) and (3, 2), with the linear history."""
    scene = model.scene.with_(**START)
    data = Data.from_reference(Reference("file", "cmod", (measured,)), "arc")
    problem = FitProblem([replace(model, scene=scene)], [data], varied([scene], VARY))  # type: ignore[list-item]
    best = weighed_minima(problem, [problem.start])[0]
    ends = covariance_ends(problem, best.z, statistics(problem, problem.evaluate(best.z)))
    return np.exp(best.z), np.exp(ends)


def cover(model: LinearRun, rows: int, files: int, whole: int) -> Coverage:
    """What some files of one length show."""
    truth = np.array(list(TRUTH.values()))
    fits = [linear_fit(model, noisy(model, rows, seed)) for seed in range(files)]
    values, ends = (np.array(each) for each in zip(*fits, strict=True))
    deviation = values.std(axis=0, ddof=1)
    clock, apart = time.process_time(), 0.0
    for seed in range(whole):
        found = fit(model.scene.with_(**START), VARY, reference=noisy(model, rows, seed), check=False)
        apart = max(apart, float(abs((np.array(list(found.values.values())) - values[seed]) / deviation).max()))
    seconds = (time.process_time() - clock) / whole if whole else float("nan")
    held = ((ends[:, :, 0] <= truth) & (truth <= ends[:, :, 1])).mean(axis=0)
    by_key = [dict(zip(TRUTH, map(float, each), strict=True)) for each in (held, (values.mean(axis=0) - truth) / deviation,
                                                                           deviation / truth)]  # fmt: skip
    return Coverage(*by_key, seconds, apart)


def main(
    plot: Path | None = None, rows: Sequence[int] = tuple(NOISES), files: int = 300, whole: int = 3, order: int = 2
) -> dict[int, Coverage]:
    """Print and return what files of each length show."""
    openings = np.r_[np.linspace(0.0, 0.15, 251)[1:], np.geomspace(0.15, 2.05, 151)[1:]]
    model = LinearRun.about(beam(order), [float(x) for x in openings])
    found = {count: cover(model, count, files, whole) for count in rows}
    for count, each in found.items():
        for key in TRUTH:
            print(
                f"{count:5d} rows, {key.removeprefix('material.'):3s}{100 * each.held[key]:6.1f} % of {files} intervals hold "
                f"it, mean off by {each.bias[key]:+.2f} of a standard deviation of {100 * each.deviation[key]:.2f} %"
            )
        if whole:
            print(f"{count:5d} rows: a whole fit takes {each.seconds:.1f} s of CPU and ends {each.apart:.2f} deviations off")
    if plot is not None:
        figure = new_figure(5.0, 3.0)
        axes = figure.subplots()
        for i, (count, each) in enumerate(found.items()):
            axes.bar(np.arange(3) + 0.25 * (i - 1), [100 * each.held[key] for key in TRUTH], 0.2, label=f"{count} rows")
        axes.axhline(95.0, color="0.3", linewidth=0.8)
        axes.set(ylabel="intervals that hold the truth (%)", ylim=(80.0, 104.0))
        axes.set_xticks(range(3), [key.removeprefix("material.") for key in TRUTH])
        axes.legend(frameon=False, fontsize=8, ncol=3)
        save(figure, plot)
    return found


if __name__ == "__main__":
    command(main, __doc__, "coverage.png")
