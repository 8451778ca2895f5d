"""Figures: the load-opening curve and the deformed body."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import Collection, LineCollection, PolyCollection
from matplotlib.figure import Figure

from ..arrays import Array
from ..elements.rotations import major_stress
from .frames import Frame
from .solid_figures import draw_body, draw_crack

if TYPE_CHECKING:
    from ..scenes.reference import Reference
    from ..studies.compare import Comparison
    from ..studies.trade import Trade
    from .result import Result

#: corners of the bulk cells
_CORNERS = {"triangle": 3, "triangle6": 3, "quad": 4, "quad8": 4, "quad6": 4}


def save_curve(result: Result, path: Path) -> None:
    """Load against opening, over the measured band where there is one; for a platen that moves both ways also the mean
    tractions on the crack against sliding and opening."""
    both = result.drives_both_ways
    figure = new_figure(11.0 if both else 6.4, 4.4)
    axes, *others = figure.subplots(1, 3 if both else 1, squeeze=False)[0]
    label, x, load = _abscissa(result)
    if not both:
        _draw_reference(axes, result.reference)
    axes.plot(x, load, color="C0", label="crack band" if result.model.is_smeared else "discrete crack")
    peak = int(np.nanargmax(load))
    axes.plot(x[peak], load[peak], "o", color="C3", markersize=4, label=f"peak {load[peak]:.5g} N")
    axes.set(xlabel=f"{label} (mm)", ylabel="load along its motion (N)" if both else "load (N)")
    axes.legend(frameon=False)
    for other, motion, stress, name in zip(
        others, ("sliding", "opening"), ("stress_s", "stress_n"), ("shear", "normal"), strict=False
    ):
        other.plot(*(np.r_[0.0, result.history[key]] for key in (motion, stress)), color="C0")
        other.set(xlabel=f"{motion} (mm)", ylabel=f"mean {name} traction on the crack (MPa)")
    for each in (axes, *others):
        each.axhline(0.0, color="0.5", linewidth=0.6)
    figure.suptitle(result.scene.title)
    save(figure, path)


def _abscissa(result: Result) -> tuple[str, Array, Array]:
    """What the load is drawn over, and both from the unloaded state: the opening; for a platen that moves both ways its
    way, along which its load acts, broken where a stage turns it."""
    load = np.r_[0.0, result.history["load"]]
    if not result.drives_both_ways:
        return "opening", np.r_[0.0, result.history["opening"]], load
    stage = result.history["stage"].astype(int)
    begins = np.flatnonzero(np.diff(stage)) + 2  # in the arrays with the unloaded state
    turned = [row for row in begins if result.scene.stages[stage[row - 1] - 1].direction is not None]
    way = np.r_[0.0, result.platen_path]
    return "way of the platen, there and back", np.insert(way, turned, way[turned]), np.insert(load, turned, np.nan)


def _draw_reference(axes: Axes, reference: Reference | None) -> None:
    """The measured curve or band that the scene names."""
    if reference is not None:
        if np.array_equal(reference.load_min, reference.load_max):
            axes.plot(reference.opening, reference.load_min, "o", color="0.6", label=reference.label)
        else:
            band = axes.fill_between(reference.opening, reference.load_min, reference.load_max, color="0.85")
            band.set_label(f"{reference.label}, band")
            for bound in (reference.load_min, reference.load_max):
                axes.plot(reference.opening, bound, ".", color="0.6", markersize=4)


def comparison_figure(comparison: Comparison) -> Figure:
    """Load over opening in both models, their difference, and openings along the crack at three stages."""
    profiles = comparison.profiles()
    figure = new_figure(11.0 if profiles else 6.4, 5.6)
    widths = [1.15, 1.0] if profiles else [1.0]
    grid = figure.add_gridspec(2, len(widths), height_ratios=[2.4, 1.0], width_ratios=widths)
    top, below = figure.add_subplot(grid[0, 0]), figure.add_subplot(grid[1, 0])
    if not comparison.by_platen:
        _draw_reference(top, comparison.discrete.reference)
    for result, label, style in ((comparison.discrete, "discrete", "C0-"), (comparison.smeared, "smeared", "C1--")):
        what, x, load = _abscissa(result)
        top.plot(x, load, style, label=f"{label}, peak {result.peak_load:.5g} N")
    top.axhline(0.0, color="0.5", linewidth=0.6)
    top.set(xlabel=f"{what} (mm)", ylabel="load (N)")
    top.legend(frameon=False)
    travelled, gap = comparison.difference()
    below.plot(travelled, gap, color="C3", linewidth=1.0)
    below.axhline(0.0, color="0.5", linewidth=0.6)
    below.set(xlabel=f"{comparison.travelled} (mm)")
    below.set(ylabel="smeared - discrete (N)")
    if profiles:
        _draw_profiles(figure.add_subplot(grid[:, 1]), profiles)
    figure.suptitle(comparison.discrete.scene.title)
    return figure


def _draw_profiles(axes: Axes, profiles: Sequence[tuple[str, dict[str, tuple[Array, Array]]]]) -> None:
    """Openings along the crack of both models at some stages."""
    for i, (title, by_model) in enumerate(profiles):
        axes.plot(*by_model["discrete"], color=f"C{i + 4}", label=f"{title}, discrete")
        axes.plot(*by_model["smeared"], "o", color=f"C{i + 4}", markersize=3, markerfacecolor="none", label="smeared")
    axes.axhline(0.0, color="0.5", linewidth=0.6)
    axes.set(xlabel="position along the crack path (mm)", ylabel="crack opening: jump, or $l_{ch}$ x fracture strain (mm)")
    axes.legend(frameon=False)


def trade_figure(trade: Trade) -> Figure:
    """Error over CPU time of every setting, both logarithmic, numbered as in the list beside it; the line joins those
    that none beats in both."""
    figure = new_figure(12.5, 7.0)
    axes, side = figure.subplots(1, 2, width_ratios=[1.9, 1.0])
    front = trade.pareto_front()
    trials = [(trial, trial.cost.cpu, trade.promise(trial)) for trial in trade.trials if trial.cost is not None]
    trials.sort(key=lambda entry: -entry[2])
    side.axis("off")
    colours = ["C3" if trial in front else "0.35" if trial.is_same_problem else "C0" for trial, _, _ in trials]
    words = [textwrap.fill(trial.label, 66) for trial, _, _ in trials]
    lines = np.array([1 + each.count("\n") for each in words])
    places = 1.0 - (np.cumsum(lines) - 0.5 * lines) / max(lines.sum(), 26)
    for i, ((trial, x, y), colour, place) in enumerate(zip(trials, colours, places, strict=True)):
        axes.loglog(x, y, "o" if trial.is_same_problem else "s", color=colour, markersize=4)
        side.text(0.0, place, f"{i + 1:2d}", fontsize=7.5, color=colour, va="center", transform=side.transAxes)
        side.text(0.07, place, words[i], fontsize=7.5, color=colour, va="center", transform=side.transAxes)
    steps = [(x, y) for trial, x, y in trials if trial in front]
    axes.loglog(*zip(*steps, strict=True), color="C3", linewidth=0.8, label="none is better in both")
    axes.loglog([], [], "s", color="C0", markersize=4, label="another problem: other model or material")
    axes.axhline(trade.own_error, color="0.6", linestyle=":", label="error of the reference itself")
    error = "largest relative error in peak, energy and curve, with that of the reference added"
    axes.set(xlabel="CPU time (s)", ylabel=error, title=trade.scene.title)
    axes.legend(frameon=False, loc="upper right")
    figure.draw_without_rendering()  # places the axes, and with them the points
    _number(axes, np.array([(x, y) for _, x, y in trials]), colours)
    return figure


def _number(axes: Axes, points: Array, colours: Sequence[str]) -> None:
    """The numbers of points, each in the nearest place where it covers no point and no other number, with a line to its
    point where that is not beside it."""
    at = axes.transData.transform(points) * 72.0 / axes.figure.dpi  # printer's points, whatever the resolution
    box = np.array([9.5, 7.5])  # half of a number and the gap around it
    taken = [*at]
    around = np.radians(45.0 * np.arange(1, 9))
    ways = np.stack([np.cos(around), np.sin(around)], axis=1) * box
    shifts = np.concatenate([r * ways for r in np.arange(1.0, 12.0, 0.5)])
    for i, (point, place, colour) in enumerate(zip(points, at, colours, strict=True)):
        room = np.where(np.arange(len(taken))[:, None] < len(at), 0.6, 1.2) * box  # to points, and to numbers
        free = [shift for shift in shifts if (abs(taken - place - shift) >= room).any(axis=1).all()]
        shift = free[0] if free else ways[0]
        taken.append(place + shift)
        far = bool(abs(shift / box).max() > 1.2)
        line = {"arrowstyle": "-", "color": colour, "linewidth": 0.4, "shrinkA": 0.0, "shrinkB": 1.0} if far else None
        axes.annotate(
            str(i + 1), point, shift, textcoords="offset points", fontsize=7, color=colour, ha="center", va="center",
            arrowprops=line,
        )  # fmt: skip


def save_deformed(result: Result, path: Path) -> None:
    """The body at the last row, coloured by the larger principal stress, displacements magnified."""
    rows = len(result.history["step"])
    frame = result.frame(rows - 1)
    mesh = result.model.mesh
    points, u = mesh.points, frame.displacement
    size = float(np.ptp(points, axis=0).max())
    factor = _magnification(0.06 * size / max(float(np.linalg.norm(u, axis=1).max()), 1e-300))
    warped = points + factor * u
    stress = np.concatenate([major_stress(s) for s in frame.stress])
    whole = "one half of the body, " if result.scene.model.half else ""
    title = f"{whole}opening {result.history['opening'][-1]:.3g} mm, displacements magnified {factor:g} times"
    if points.shape[1] == 3:
        save(_solid_figure(result, frame, warped, stress, title), path)
        return
    faces = [warped[block.cells[:, : _CORNERS[block.kind]]] for block in (*result.model.blocks, *result.model.band)]
    span = warped.max(axis=0) - warped.min(axis=0)
    ratio = span[1] / span[0]
    width = float(np.clip(7.5 / ratio + 3.0, 5.0, 8.0))  # narrower for a tall body
    figure = new_figure(width, float(np.clip(0.8 * width * ratio + 1.0, 2.6, 8.5)))
    axes = figure.add_subplot()
    body = PolyCollection(
        _corners(faces),  # type: ignore[arg-type]  # an array is drawn much faster than a list
        array=stress, cmap="viridis", edgecolors="face", linewidths=0.3,
    )  # fmt: skip
    _limit(body, stress)
    axes.add_collection(body)
    if result.model.is_smeared:
        _draw_planes(axes, result, faces[len(result.model.blocks) :])
    else:
        for a, b in ((0, 1), (3, 2)):
            segments = warped[mesh.cells[-1].data[:, [a, b]]]
            axes.plot(*segments.transpose(2, 1, 0), color="C3", linewidth=0.8)
    axes.set_xlim(warped[:, 0].min() - 0.02 * size, warped[:, 0].max() + 0.02 * size)
    axes.set_ylim(warped[:, 1].min() - 0.02 * size, warped[:, 1].max() + 0.02 * size)
    axes.set_aspect("equal")
    axes.set(xlabel="x (mm)", ylabel="y (mm)")
    figure.suptitle(title, fontsize="medium")  # over the whole figure: a tall body is narrow
    figure.colorbar(body, ax=axes, label="major principal stress (MPa)", shrink=0.9, extend="both")
    save(figure, path)


def _solid_figure(result: Result, frame: Frame, warped: Array, stress: Array, title: str) -> Figure:
    """A body in space beside its crack surface, which it may hide."""
    figure = new_figure(12.0, 5.2)
    figure.set_layout_engine("none")  # which axes in space do not take part in
    body = draw_body(figure, 0.02, result, warped, stress)
    _limit(body, np.asarray(body.get_array()))
    draw_crack(figure, 0.53, result, frame, warped)
    figure.suptitle(title)
    return figure


def _limit(faces: Collection, stress: Array) -> None:
    """Colours that a few very large stresses do not flatten."""
    low, high = np.percentile(stress, [1, 99])
    faces.set_clim(low, max(high, low + 1e-12))


def _draw_planes(axes: Axes, result: Result, faces: list[Array]) -> None:
    """The open crack planes of a band, as lines in the deformed cells that they belong to."""
    state, cracks = result.last, result.model.cracks
    planes = state.cracks.planes
    opening = planes.length * planes.strain[:, 0]
    shown = opening > 0.05 * max(opening.max(initial=0.0), 1e-300)
    cell = cracks.cell[planes.point[shown]]
    corners = _corners(faces)[cell]
    centre, size = corners.mean(axis=1), np.ptp(corners, axis=1).min(axis=1)
    along = 0.5 * size[:, None] * planes.rotation[shown, 1]
    axes.add_collection(LineCollection(list(np.stack([centre - along, centre + along], axis=1)), colors="C3", linewidths=0.8))


def _corners(faces: list[Array]) -> Array:
    """Corners of all cells, (n, 4, 2) or, where all are triangles, (n, 3, 2): the last corner of others is repeated."""
    most = max(f.shape[1] for f in faces)
    return np.concatenate([np.pad(f, ((0, 0), (0, most - f.shape[1]), (0, 0)), mode="edge") for f in faces])


def _magnification(factor: float) -> float:
    """Rounded down to 1, 2 or 5 times a power of ten."""
    power = 10.0 ** np.floor(np.log10(factor))
    return float(power * max(step for step in (1.0, 2.0, 5.0) if step * power <= factor * (1 + 1e-9)))


def new_figure(width: float, height: float) -> Figure:
    """A figure of a size in inches, drawn without a window."""
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def save(figure: Figure, path: Path) -> None:
    """Write a figure as PNG."""
    figure.savefig(path, dpi=130, format="png")
