"""One material for three beams: two are fitted together, the third is predicted.

Beams of one concrete of Grégoire, Rojas-Solano and Pijaudier-Cabot (2013): half-notched and unnotched ones of depth 50 mm
were measured as bands of load over opening, 13 and 20 points. Their softening curve is fitted to both at once, E = 37 GPa as
published; it then predicts a beam of depth 100 mm with a notch of a fifth, whose trace no fit has seen. Hordijk's curve, a
free kink, and five free points from three starts.

The length over which the opening of the unnotched beam was measured is not known. Its first three rows are elastic and choose
it: 75 mm, as one public code has it, is 17 to 18 % too stiff; 100 and 124 mm meet them within 1 %. 124 mm would end over the
supports, so that 100 mm is taken; the fit is the same with both.

Expected: five points leave .7 % of the peak, with 17 to 23 of the 33 points in the bands and 29 to 33 within 3 % of them; a
kink leaves 1.4 %, Hordijk's curve 1.7 %. The measured peak of the third beam is 4496 N: the points predict it 2.7 to 2.8 % too
low, Hordijk's curve 3.2 %, the kink 1.8 %. So the closest fit is not the best prediction. The three starts end in one branch
up to .025 mm and in different tails; the fit says that it does not see them. Only the peak is predicted: the third beam as
measured opens more, its load is a fifth lower on the way up and half as high again at .08 mm; over what length its opening was
measured is not known either.

    python -m examples.one_material [-o DIR]
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from cohesive import Scene, read_measured, run
from cohesive.arrays import Array
from cohesive.figures.drawing import new_figure, save
from cohesive.fitting.curve_choice import fit_curves
from cohesive.fitting.result import Fit
from examples.command import command

FOLDER = Path(__file__).parent / "data"
UNNOTCHED, FIFTH = FOLDER / "gregoire-2013-unnotched-d50.csv", FOLDER / "gregoire-2013-fifth-notched-d100.csv"
VARY = {"material.ft": (1.0, 9.0), "material.Gf": (0.02, 0.3)}

#: ft (MPa) and Gf (N/mm) from which a fit starts
STARTS = ((3.4, 0.07), (4.6, 0.05), (2.8, 0.1))

#: lengths (mm) over which the opening of the unnotched beam may have been measured, and the one that is taken
GAUGES, GAUGE = (75.0, 100.0, 124.0), 100.0

#: openings of the third beam on the way up and far behind the peak, mm
RISE, TAIL = 0.01, 0.08

#: rows of the unnotched beam that are elastic, and a share of the bands beyond which a point counts as far
ELASTIC, NEAR = 3, 0.03


@dataclass(frozen=True)
class OneMaterial:
    """What a fit of both beams says.

    Attributes
    ----------
    curve : softening curve
    rms : distance from the bands, part of the peak of each beam
    inside, near : of the 33 points, in the bands, and within 3 % of them
    blind : predicted peak of the third beam over the measured one, less 1
    rise, tail : predicted loads over the measured ones at RISE and TAIL, less 1
    seconds : CPU time of the fit
    """

    curve: str
    rms: float
    inside: int
    near: int
    blind: float
    rise: float
    tail: float
    seconds: float


def half_notched(**changes: Any) -> Scene:
    """The built-in beam."""
    return Scene.load("notched-beam").with_(**changes)


def unnotched(gauge: float = GAUGE, **changes: Any) -> Scene:
    """The same beam without a notch, its opening measured over some length (mm)."""
    data: dict[str, Any] = {
        "title": "Unnotched beam in three-point bending",
        "specimen.notch": 0.0, "specimen.gauge": gauge, "stage.0.to": 0.3,
        "reference": {"file": str(UNNOTCHED), "label": "Grégoire et al. (2013)"},
    }  # fmt: skip
    return half_notched(**data).with_(**changes)


def fifth_notched(**changes: Any) -> Scene:
    """The beam that is predicted."""
    data: dict[str, Any] = {
        "title": "Beam of depth 100 mm with a notch of a fifth",
        "specimen.length": 350.0, "specimen.span": 250.0, "specimen.depth": 100.0, "specimen.notch": 20.0,
        "stage.0.to": 0.1, "reference": {"file": str(FIFTH), "label": "Grégoire et al. (2013)"},
    }  # fmt: skip
    return half_notched(**data).with_(**changes)


def stiffness_by_gauge() -> dict[float, Array]:
    """How much too stiff the elastic rows of the unnotched beam are for each gauge length, parts of the measured loads."""
    measured = read_measured(UNNOTCHED, y="load_mean")
    x, y = measured.x[:ELASTIC], measured.y[:ELASTIC]
    strong = {"material.ft": 20.0, "material.Gf": 1.0, "stage.0.to": [float(each) for each in x], "stage.0.steps": 1}
    loads = {gauge: run(unnotched(gauge).with_(**strong)).history for gauge in GAUGES}
    return {gauge: np.interp(x, each["opening"], each["load"]) / y - 1.0 for gauge, each in loads.items()}


def fit_both(curve: str, ft: float, Gf: float) -> tuple[Fit, OneMaterial]:
    """Both beams fitted with one curve, and what that says."""
    clock = time.process_time()
    start = {"material.ft": ft, "material.Gf": Gf}
    choice = fit_curves([half_notched(**start), unnotched(**start)], VARY, [curve], check=False)
    seconds, found = time.process_time() - clock, choice.fits[curve]
    both = list(zip(found.problem.data, found.best.loads, strict=True))
    inside, near = (sum(data.inside(load, margin) for data, load in both) for margin in (0.0, NEAR))
    measured, predicted = read_measured(FIFTH), run(predicting(found))
    h, places = predicted.history, [RISE, TAIL]
    off = np.interp(places, h["opening"], h["load"]) / np.interp(places, measured.x, measured.y) - 1.0
    blind = predicted.peak_load / float(measured.y.max()) - 1.0
    return found, OneMaterial(curve, found.rms, inside, near, blind, *map(float, off), seconds)


def predicting(found: Fit) -> Scene:
    """The third beam with a fitted material."""
    return Scene({**fifth_notched().data, "material": found.scenes[0].given("material")})


def main(
    plot: Path | None = None,
    curves: Sequence[tuple[str, int]] = (("hordijk", 0), ("kink", 0), ("points:5", 0), ("points:5", 1), ("points:5", 2)),
) -> list[OneMaterial]:
    """Fit both beams with some curves, each from one of the starts; print and return what each says."""
    for gauge, off in stiffness_by_gauge().items():
        print(f"gauge of {gauge:g} mm: the elastic rows of the unnotched beam are off by {_percent(off)}")
    fits = [fit_both(curve, *STARTS[start]) for curve, start in curves]
    for (curve, start), (found, said) in zip(curves, fits, strict=True):
        print(
            f"{curve} from ft {STARTS[start][0]} MPa, Gf {STARTS[start][1]} N/mm: rms {100 * said.rms:.2f} %, {said.inside} "
            f"of 33 points inside, {said.near} within 3 %; peak of the third beam {100 * said.blind:+.1f} %, its loads at "
            f"{RISE} and {TAIL} mm {100 * said.rise:+.0f} and {100 * said.tail:+.0f} %; {said.seconds:.0f} s of CPU"
        )
        material, softening = found.scenes[0].material, found.scenes[0].given("material.softening")
        print(f"  ft {material.ft:.2f} MPa, Gf {material.Gf:.4f} N/mm, softening {softening}")
        print("".join(f"  {each}\n" for each in found.identifiable if "do not see" in each), end="")
    if plot is not None:
        _draw([found for found, _ in fits], [said for _, said in fits], plot)
    return [said for _, said in fits]


def _percent(values: Array) -> str:
    return ", ".join(f"{100.0 * value:+.1f}" for value in values) + " %"


def _draw(fits: Sequence[Fit], said: Sequence[OneMaterial], path: Path) -> None:
    """Both beams that are fitted, the one that is predicted, and the curves."""
    figure = new_figure(12.0, 7.0)
    axes = figure.subplots(2, 2)
    ends = 0.18, 0.3, 0.1
    titles = ("half-notched, fitted", "unnotched, fitted", "depth 100 mm, predicted")
    for one, end, title in zip(axes.flat, ends, titles, strict=False):
        one.set(title=title, xlabel="opening (mm)", ylabel="load (N)", xlim=(0.0, end))
    for i, one in enumerate(axes[0]):
        measured = fits[0].problem.data[i].curves[0]
        one.fill_between(measured.x, *measured.bounds, color="0.85", label="measured band")
    blind = read_measured(FIFTH)
    axes[1, 0].plot(blind.x, blind.y, "ko", markersize=4, label="measured")
    starts: dict[str, int] = {}
    for found, one in zip(fits, said, strict=True):
        starts[one.curve] = starts.get(one.curve, 0) + 1
        style = {"color": f"C{list(starts).index(one.curve)}", "linestyle": ("-", "--", ":")[starts[one.curve] - 1]}
        label = one.curve + (f", start {starts[one.curve]}" if starts[one.curve] > 1 else "")
        for i, panel in enumerate(axes[0]):
            history = found.best.rows[i].history
            _line(panel, history, f"{label}: rms {100 * one.rms:.1f} %", style)
        _line(axes[1, 0], run(predicting(found)).history, f"{label}: peak {100 * one.blind:+.1f} %", style)
        w = np.linspace(0.0, 0.2, 401)
        axes[1, 1].plot(w, found.scenes[0].material.curve.stress(w), label=label, **style)
    axes[1, 1].set(title="softening", xlabel="crack opening (mm)", ylabel="stress (MPa)", xlim=(0.0, 0.2))
    for one in axes.flat:
        one.set_ylim(0.0, None)
        one.legend(frameon=False, fontsize=8)
    save(figure, path)


def _line(axes: Axes, history: dict[str, Array], label: str, style: dict[str, str]) -> None:
    axes.plot(np.r_[0.0, history["opening"]], np.r_[0.0, history["load"]], label=label, **style)


if __name__ == "__main__":
    command(main, __doc__, "one_material.png")
