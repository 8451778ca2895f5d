"""The figure of a fit: curve over data, residuals, and the softening curve with its band of confidence."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..figures.drawing import draw_measured, new_figure
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
    figure = new_figure(11.0, 6.0)
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
    several = len(problem.data) > 1
    for i, (data, rows) in enumerate(zip(problem.data, best.rows, strict=True)):
        colour = _COLOURS[i % len(_COLOURS)]
        name = f" ({scenes[i].title})" if several else ""
        for k, each in enumerate(data.curves):
            draw_measured(axes, each, "0.6" if not several else colour, None if k else f"measured{name}")
        x, y = np.r_[0.0, rows.history[data.against]], np.r_[0.0, rows.history["load"]]
        axes.plot(x, y, color=colour, label=f"fit{name}")
    axes.set(ylabel="load (N)", ylim=(0.0, None), xlim=(0.0, None))
    axes.legend(fontsize="small")
    axes.set_title(f"rms {100 * problem.rms(best):.2f} % of the peak", fontsize="medium")
    axes.tick_params(labelbottom=False)


def _draw_residuals(axes: Axes, problem: FitProblem, best: FitEvaluation) -> None:
    for i, (data, load) in enumerate(zip(problem.data, best.loads, strict=True)):
        gap = 100.0 * data.gap(load)[0]
        x, size = problem.rows(best.z, i).x, 5 if len(gap) <= 100 else 2
        axes.plot(x, gap, ".", color=_COLOURS[i % len(_COLOURS)], markersize=size)
    axes.axhline(0.0, color="0.5", linewidth=0.8)
    against = {data.against for data in problem.data}
    axes.set(xlabel=f"{' / '.join(sorted(against))} (mm)", ylabel="fit - measured\n(% of the peak)")


def _draw_softening(axes: Axes, scenes: Sequence[Scene], samples: Callable[[int], Sequence[Any]]) -> None:
    materials = [scene.material for scene in scenes]
    distinct = [0] + [i for i in range(1, len(materials)) if materials[i] != materials[0]]
    unit = max(float(materials[i].Gf) / float(materials[i].ft) for i in distinct)
    ends = [float(materials[i].curve.end) for i in distinct]
    last = min(max(ends), 6.0 * unit) if np.isfinite(max(ends)) else 6.0 * unit
    w = np.linspace(0.0, last, 300)
    for i in distinct:
        colour = _COLOURS[i % len(_COLOURS)]
        stresses = np.array([curve.stress(w) for curve in samples(i)])
        if len(stresses) > 20:
            low, high = np.quantile(stresses, (0.025, 0.975), axis=0)
            axes.fill_between(w, low, high, color=colour, alpha=0.2, linewidth=0.0, label="95 % band (covariance)")
        name = f" ({scenes[i].title})" if len(distinct) > 1 else ""
        axes.plot(w, stresses[0], color=colour, label=f"fitted curve{name}")
    top = 1.8 * max(float(materials[i].ft) for i in distinct)
    axes.set(xlabel="crack opening w (mm)", ylabel="stress (MPa)", xlim=(0.0, last), ylim=(0.0, top))
    axes.legend(fontsize="small")
