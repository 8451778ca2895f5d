"""Figures of a comparison and of a trade."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..arrays import Array
from ..figures.drawing import abscissa, draw_reference, force_text, new_figure, plain_legend, set_force_label, set_title

if TYPE_CHECKING:
    from ..results.run_data import RunData
    from .trials import SweepSetting

#: for each stage its title and, by model, positions along the crack path and openings, mm
Profiles = list[tuple[str, dict[str, tuple[Array, Array]]]]


def comparison_figure(
    runs: Mapping[str, RunData], measure: str, difference: tuple[Array, Array], travelled: str, profiles: Profiles
) -> Figure:
    """Load over the measure in charge in both models, their difference, and openings along the crack at three stages.

    Parameters
    ----------
    runs : by model
    measure : the one in charge, a column of both histories
    difference : load of the smeared run less that of the discrete one (N) over what both have travelled (mm)
    travelled : what that is
    """
    discrete = runs["discrete"]
    output = discrete.scene.output
    figure = new_figure(11.0 if profiles else 6.4, 5.6, output)
    widths = [1.15, 1.0] if profiles else [1.0]
    grid = figure.add_gridspec(2, len(widths), height_ratios=[2.4, 1.0], width_ratios=widths)
    top, below = figure.add_subplot(grid[0, 0]), figure.add_subplot(grid[1, 0])
    draw_reference(top, discrete, measure)
    for (label, result), style in zip(runs.items(), ("C0-", "C1--"), strict=True):
        what, x, load = abscissa(result, measure)
        top.plot(x, load, style, label=f"{label}, peak {force_text(result.peak_load, output.force_unit)}")
    top.axhline(0.0, color="0.5", linewidth=0.6)
    top.set_xlabel(f"{what} (mm)")
    set_force_label(top, "load", output.force_unit)
    plain_legend(top, top)
    below.plot(*difference, color="C3", linewidth=1.0)
    below.axhline(0.0, color="0.5", linewidth=0.6)
    below.set_xlabel(f"{travelled} (mm)")
    set_force_label(below, "smeared - discrete", output.force_unit)
    if profiles:
        _draw_profiles(figure.add_subplot(grid[:, 1]), profiles)
    set_title(figure, discrete.scene.title)
    return figure


def _draw_profiles(axes: Axes, profiles: Profiles) -> None:
    """Openings along the crack of both models at some stages."""
    for i, (title, by_model) in enumerate(profiles):
        axes.plot(*by_model["discrete"], color=f"C{i + 4}", label=f"{title}, discrete")
        axes.plot(*by_model["smeared"], "o", color=f"C{i + 4}", markersize=3, markerfacecolor="none", label="smeared")
    axes.axhline(0.0, color="0.5", linewidth=0.6)
    axes.set(xlabel="position along the crack path (mm)", ylabel="crack opening: jump, or $l_{ch}$ x fracture strain (mm)")
    axes.legend(frameon=False)


def trade_figure(
    title: str, runs: Sequence[tuple[SweepSetting, float, float]], front: Sequence[SweepSetting], own_error: float
) -> Figure:
    """Error over CPU time of every setting, both logarithmic, numbered as in the list beside it; the line joins those
    that no other beats in both.

    Parameters
    ----------
    runs : trials with their CPU time (s) and the error that they promise
    front : those that no other beats
    own_error : of the reference
    """
    figure = new_figure(12.5, 7.0)
    axes, side = figure.subplots(1, 2, width_ratios=[1.9, 1.0])
    trials = sorted(runs, key=lambda entry: -entry[2])
    colours = ["C3" if trial in front else "0.35" if trial.is_same_problem else "C0" for trial, _, _ in trials]
    _list(side, [textwrap.fill(trial.label, 66) for trial, _, _ in trials], colours)
    for (trial, x, y), colour in zip(trials, colours, strict=True):
        axes.loglog(x, y, "o" if trial.is_same_problem else "s", color=colour, markersize=4)
    steps = [(x, y) for trial, x, y in trials if trial in front]
    axes.loglog(*zip(*steps, strict=True), color="C3", linewidth=0.8, label="none is better in both")
    axes.loglog([], [], "s", color="C0", markersize=4, label="another problem: other model or material")
    axes.axhline(own_error, color="0.6", linestyle=":", label="error of the reference itself")
    error = "largest relative error in peak, energy and curve, with that of the reference added"
    axes.set(xlabel="CPU time (s)", ylabel=error)
    set_title(figure, title)
    axes.legend(frameon=False, loc="upper right")
    figure.draw_without_rendering()  # the layout moves the axes, and with them the points
    _number(axes, np.array([(x, y) for _, x, y in trials]), colours)
    return figure


def _list(axes: Axes, words: Sequence[str], colours: Sequence[str]) -> None:
    """A numbered list in place of axes."""
    axes.axis("off")
    lines = np.array([1 + each.count("\n") for each in words])
    heights = 1.0 - (np.cumsum(lines) - 0.5 * lines) / max(lines.sum(), 26)
    for i, (text, height, colour) in enumerate(zip(words, heights, colours, strict=True)):
        axes.text(0.0, height, f"{i + 1:2d}", fontsize=7.5, color=colour, va="center", transform=axes.transAxes)
        axes.text(0.07, height, text, fontsize=7.5, color=colour, va="center", transform=axes.transAxes)


def _number(axes: Axes, points: Array, colours: Sequence[str]) -> None:
    """The numbers of points, each at the nearest location at which it covers no point and no other number, with a line
    to its point if it is not beside it."""
    at = axes.transData.transform(points) * 72.0 / axes.figure.dpi  # printer's points, whatever the resolution
    box = np.array([9.5, 7.5])  # half of a number and the gap around it
    taken = [*at]
    around = np.radians(45.0 * np.arange(1, 9))
    ways = np.stack([np.cos(around), np.sin(around)], axis=1) * box
    shifts = np.concatenate([r * ways for r in np.arange(1.0, 12.0, 0.5)])
    for i, (point, origin, colour) in enumerate(zip(points, at, colours, strict=True)):
        apart = np.where(np.arange(len(taken))[:, None] < len(at), 0.6, 1.2) * box  # to points, and to numbers
        free = [shift for shift in shifts if (abs(taken - origin - shift) >= apart).any(axis=1).all()]
        shift = free[0] if free else ways[0]
        taken.append(origin + shift)
        far = bool(abs(shift / box).max() > 1.2)
        line = {"arrowstyle": "-", "color": colour, "linewidth": 0.4, "shrinkA": 0.0, "shrinkB": 1.0} if far else None
        axes.annotate(
            str(i + 1), point, shift, textcoords="offset points", fontsize=7, color=colour, ha="center", va="center",
            arrowprops=line,
        )  # fmt: skip
