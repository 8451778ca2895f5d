"""The figure of a fit: curve over data, residuals, and the softening curve with its band of confidence."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure

from ..figures.drawing import draw_measured, new_figure, set_force_label
from ..scenes.scene import Scene
from .intervals import interval_words
from .problem import FitEvaluation, FitProblem

#: one colour for each scene
_COLOURS = ("C0", "C3", "C2", "C4", "C1", "C5")


def draw(
    problem: FitProblem,
    best: FitEvaluation,
    scenes: Sequence[Scene],
    samples: Callable[[int], Sequence[Any]],
    values: Mapping[str, float],
    intervals: Mapping[str, tuple[float, float]],
) -> Figure:
    """The figure.

    Parameters
    ----------
    scenes : with the fitted numbers
    samples : softening curves of a scene, by its index: the fitted one, then those drawn from its covariance
    values, intervals : of the numbers, by name
    """
    figure = new_figure(11.0, 6.0, scenes[0].output)
    parts = figure.add_gridspec(2, 2, width_ratios=(1.25, 1.0), height_ratios=(2.2, 1.0))
    over, left, curve = (
        figure.add_subplot(parts[0, 0]), figure.add_subplot(parts[1, 0]), figure.add_subplot(parts[:, 1])
    )  # fmt: skip
    _draw_loads(over, problem, best, scenes)
    _draw_residuals(left, problem, best)
    _draw_softening(curve, scenes, samples)
    text = "\n".join(
        f"{name.removeprefix('material.').replace('softening.', '')} = {value:.4g}  [{interval_words(*intervals[name])}]"
        for name, value in values.items()
    )
    curve.text(0.97, 0.72, text, transform=curve.transAxes, ha="right", va="top", fontsize="small")
    left.sharex(over)
    return figure


def _draw_loads(axes: Axes, problem: FitProblem, best: FitEvaluation, scenes: Sequence[Scene]) -> None:
    several, names = len(problem.data) > 1, _names(scenes)
    for i, (data, rows) in enumerate(zip(problem.data, best.rows, strict=True)):
        colour = _COLOURS[i % len(_COLOURS)]
        name = f" ({names[i]})" if several else ""
        for k, each in enumerate(data.curves):
            draw_measured(axes, each, _dark(colour) if several else "0.25", None if k else f"measured{name}")
        x, y = np.r_[0.0, rows.history[data.against]], np.r_[0.0, rows.history["load"]]
        axes.plot(x, y, color=colour, linewidth=2.0, label=f"fit{name}")
    set_force_label(axes, "load", scenes[0].output.force_unit)
    axes.set(ylim=(0.0, None), xlim=(0.0, None))
    axes.legend(fontsize="small")
    axes.set_title(f"rms {100 * problem.rms(best):.2f} % of the peak", fontsize="medium")
    axes.tick_params(labelbottom=False)


def _names(scenes: Sequence[Scene]) -> list[str]:
    """Titles of scenes, numbered if some are the same."""
    titles = [scene.title for scene in scenes]
    return titles if len(set(titles)) == len(titles) else [f"{title}, {i}" for i, title in enumerate(titles, start=1)]


def _dark(colour: str) -> str:
    """The colour of what was measured, beside that of its fit."""
    red, green, blue = to_rgb(colour)
    return to_hex((0.55 * red, 0.55 * green, 0.55 * blue))


def draw_choice(fits: Mapping[str, tuple[FitProblem, FitEvaluation, Scene]]) -> Figure:
    """Loads over what was measured in the first scene, and softening curves, of several curves that were fitted to it."""
    output = next(iter(fits.values()))[2].output
    figure = new_figure(11.0, 4.6, output)
    over, curve = figure.subplots(1, 2)
    end = 0.0
    for i, (name, (problem, best, scene)) in enumerate(fits.items()):
        data, history, colour = problem.data[0], best.rows[0].history, f"C{i % 10}"
        if i == 0:
            for k, each in enumerate(data.curves):
                draw_measured(over, each, "0.25", None if k else "measured")
            over.set_xlabel(f"{data.against} (mm)")
        label = f"{name}, rms {100 * problem.rms(best):.2f} % of the peak"
        over.plot(np.r_[0.0, history[data.against]], np.r_[0.0, history["load"]], color=colour, label=label)
        last = float(scene.material.curve.end)
        last = last if np.isfinite(last) else 6.0 * float(scene.material.Gf) / float(scene.material.ft)
        w, end = np.linspace(0.0, last, 300), max(end, last)
        curve.plot(w, scene.material.curve.stress(w), color=colour, label=name)
    set_force_label(over, "load", output.force_unit)
    over.set(xlim=(0.0, None), ylim=(0.0, None))
    curve.set(xlabel="crack opening w (mm)", ylabel="stress (MPa)", xlim=(0.0, end), ylim=(0.0, None))
    for axes in (over, curve):
        axes.legend(fontsize="small")
    return figure


def _draw_residuals(axes: Axes, problem: FitProblem, best: FitEvaluation) -> None:
    for i, (data, load) in enumerate(zip(problem.data, best.loads, strict=True)):
        gap = 100.0 * data.gap(load)[0]
        x, size = problem.rows(best.z, i).x, 5 if len(gap) <= 100 else 2
        axes.plot(x, gap, ".", color=_COLOURS[i % len(_COLOURS)], markersize=size)
    axes.axhline(0.0, color="0.5", linewidth=0.8)
    against = {data.against for data in problem.data}
    axes.set(xlabel=f"{' / '.join(sorted(against))} (mm)", ylabel="fit - measured\n(% of the peak)")


def _draw_softening(axes: Axes, scenes: Sequence[Scene], samples: Callable[[int], Sequence[Any]]) -> None:
    materials, names = [scene.material for scene in scenes], _names(scenes)
    distinct = [0] + [i for i in range(1, len(materials)) if materials[i] != materials[0]]
    unit = max(float(materials[i].Gf) / float(materials[i].ft) for i in distinct)
    ends = [float(materials[i].curve.end) for i in distinct]
    last = max(ends) if np.isfinite(max(ends)) else 6.0 * unit
    w = np.linspace(0.0, last, 300)
    for i in distinct:
        colour = _COLOURS[i % len(_COLOURS)]
        stresses = np.array([curve.stress(w) for curve in samples(i)])
        if len(stresses) > 20:
            low, high = np.quantile(stresses, (0.025, 0.975), axis=0)
            axes.fill_between(w, low, high, color=colour, alpha=0.2, linewidth=0.0, label="95 % band (covariance)")
        name = f" ({names[i]})" if len(distinct) > 1 else ""
        axes.plot(w, stresses[0], color=colour, label=f"fitted curve{name}")
    top = 1.8 * max(float(materials[i].ft) for i in distinct)
    axes.set(xlabel="crack opening w (mm)", ylabel="stress (MPa)", xlim=(0.0, last), ylim=(0.0, top))
    axes.legend(fontsize="small")
