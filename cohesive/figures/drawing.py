"""Figures: their format, and the curve of a run with what was measured."""

from __future__ import annotations

import textwrap
import threading
import warnings
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from ..arrays import Array
from ..results.files import write_file
from ..results.measures import label_of
from ..scenes.tables import FORMATS, OutputOptions

if TYPE_CHECKING:
    from ..measured.curve import Measured
    from ..results.run_data import RunData

#: measured curves of fewer points are drawn with a mark for each
_FEW = 100

#: order of drawing of what was measured: lines have 2
_TOP = 3.0

#: the filters of warnings are those of the whole process
_ONE_AT_A_TIME = threading.Lock()

#: mm
_INCH = 25.4

#: of PNG files, 0 to 9
_COMPRESSION = 3

#: characters of a title in an inch of its figure, and its lines
_TITLE_WIDTH, _TITLE_LINES = 11, 2


def save_curve(data: RunData, path: Path) -> None:
    """The curve of a run, with what was measured if there is something; for a platen that moves both ways also the mean
    tractions on the crack against sliding and opening."""
    both = data.facts.has_platen and data.scene.output.curve is None
    figure = new_figure(11.0 if both else 6.4, 4.4, data.scene.output)
    axes, *others = figure.subplots(1, 3 if both else 1, squeeze=False)[0]
    draw_curve(axes, data)
    for other, motion, stress, name in zip(
        others, ("sliding", "opening"), ("stress_s", "stress_n"), ("shear", "normal"), strict=False
    ):
        other.plot(data.history[motion], data.history[stress], color="C0")
        other.set(xlabel=_label(data, motion), ylabel=f"mean {name} traction on the crack (MPa)")
        other.axhline(0.0, color="0.5", linewidth=0.6)
    set_title(figure, data.scene.title)
    save(figure, path, data.scene.output)


def draw_curve(axes: Axes, data: RunData) -> None:
    """The curve that the scene asks for; without one the load over the travel of a platen that moves both ways, else over what
    `RunData.controlled` says."""
    history = data.history
    name, over = data.scene.output.curve or (data.controlled, "load")
    if data.facts.has_platen and data.scene.output.curve is None:
        (label, x, y), along = abscissa(data), data.drive_travel
        axes.set_xlabel(f"{label} (mm)")
        set_force_label(axes, "load along its motion", data.scene.output.force_unit)
    else:
        x, y = along, _ = history[name], history[over]
        axes.set(xlabel=_label(data, name), ylabel=_label(data, over))
        if data.unit_of(over) == "N":
            set_force_label(axes, label_of(data, over).replace("$", r"\$"), data.scene.output.force_unit)
        if over == "load":
            draw_reference(axes, data, name, with_distance=True)
    axes.plot(x, y, color="C0", linewidth=2.0, label="crack band" if data.is_smeared else "discrete crack")
    if over == "load":
        top = data.at_peak(along), data.peak_load
    else:
        top = x[np.nanargmax(y)], y[np.nanargmax(y)]
    unit = data.unit_of(over)
    value = force_text(top[1], data.scene.output.force_unit) if unit == "N" else f"{top[1]:.5g} {unit}"
    axes.plot(*top, "o", color="C3", markersize=4, label=f"{'peak' if over == 'load' else 'largest'} {value}")
    axes.axhline(0.0, color="0.5", linewidth=0.6)
    plain_legend(axes, axes)


def _label(data: RunData, name: str) -> str:
    unit, words = data.unit_of(name), label_of(data, name).replace("$", r"\$")
    return f"{words} ({unit})" if unit else words


def force_text(force: float, unit: str) -> str:
    """A force (N) in a unit, "N" or "kN", with it."""
    return f"{force / (1e3 if unit == 'kN' else 1.0):.5g} {unit}"


def set_force_label(axes: Axes, words: str, unit: str) -> None:
    """Name the ordinate of forces, which are drawn in N, and number it in a unit, "N" or "kN"."""
    axes.set_ylabel(f"{words} ({unit})")
    if unit == "kN":
        axes.yaxis.set_major_formatter(lambda value, _: f"{1e-3 * value:g}")


def abscissa(data: RunData, measure: str | None = None) -> tuple[str, Array, Array]:
    """Name and values (mm) of what the load (N) is drawn over, and the load.

    The load is drawn over a column of the history, that in charge unless one is given; for a platen that moves both ways over
    its travel, along which its load acts. That curve is broken (NaN) at each stage that turns the platen.
    """
    load, measure = data.history["load"], measure or data.controlled
    if not data.facts.has_platen:
        return measure, data.history[measure], load
    stage = data.history["stage"].astype(int)
    begins = np.flatnonzero(np.diff(stage)) + 1
    turned = [row for row in begins if data.scene.stages[stage[row] - 1].angle is not None]
    travel = data.drive_travel
    return "travel of the platen, there and back", np.insert(travel, turned, travel[turned]), np.insert(load, turned, np.nan)


def draw_reference(axes: Axes, data: RunData, measure: str, with_distance: bool = False) -> None:
    """The measured curves or bands that the scene names, if they go over this measure, and how far the run lies from them."""
    reference = data.reference
    if reference is None or reference.against != measure or data.facts.has_platen:
        return
    several, mean = len(reference.curves) > 1, reference.mean()
    judged = {each.name: each for each in data.agreement} if with_distance else {}
    for i, each in enumerate(reference.curves):
        label = reference.label + (f", {len(reference.curves)} tests" if several else "") if i == 0 else None
        if label and each.is_band:
            label = f"{label}, band"
        elif not several and each.name in judged:
            label = f"{label}, rms {100 * judged[each.name].rms:.1f} % of its peak"
        draw_measured(axes, each, "0.35", label)
    if mean is not None:
        curve = mean[0]
        rms = f", rms {100 * judged[curve.name].rms:.1f} % of its peak" if curve.name in judged else ""
        axes.plot(curve.x, curve.y, "--", color="0.2", linewidth=1.0, label=f"{curve.name}{rms}", zorder=_TOP)


def draw_measured(axes: Axes, measured: Measured, colour: str, label: str | None = None) -> None:
    """A measured curve, or a band with its bounds, on top of what is computed."""
    if measured.is_band:
        axes.fill_between(measured.x, *measured.bounds, color=colour, alpha=0.3, linewidth=0.0, label=label)
        axes.plot(measured.x, np.stack(measured.bounds, axis=1), ".", color=colour, markersize=4, zorder=_TOP)
        return
    style = "o-" if len(measured.x) < _FEW else "-"
    axes.plot(measured.x, measured.y, style, color=colour, markersize=3, linewidth=0.8, label=label, zorder=_TOP)


def new_figure(width: float, height: float, output: OutputOptions | None = None) -> Figure:
    """A figure of a size in inches, or of that which a scene gives in mm, drawn without a window."""
    if output is not None and output.figure_size is not None:
        width, height = (side / _INCH for side in output.figure_size)
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def set_title(figure: Figure, *lines: str) -> None:
    """A title over the whole figure, each of its lines broken and cut as it needs, and taken as it is: no mathtext."""
    width = int(_TITLE_WIDTH * figure.get_figwidth())
    text = "\n".join(broken for line in lines if (broken := "\n".join(fitted(line, width, _TITLE_LINES))))
    figure.suptitle(text, parse_math=False, fontsize="medium" if "\n" in text else "large")


def fitted(text: str, width: int, lines: int) -> list[str]:
    """A text in a number of lines of a number of characters; it ends in "..." if it is too long. No controls."""
    clean = "".join(each if each.isprintable() else " " for each in text)
    return textwrap.wrap(clean, width, max_lines=lines, placeholder=" ...")


def plain_legend(place: Axes | Figure, axes: Axes, **options: Any) -> None:
    """A legend of axes, in them or in their figure, that takes the names in it as they are: no mathtext."""
    legend = place.legend(*axes.get_legend_handles_labels(), frameon=False, **options)
    for text in legend.get_texts():
        text.set_text("\n".join(fitted(text.get_text(), 60, _TITLE_LINES)))
        text.set_parse_math(False)


def write_figure(path: Path, draw: Callable[[Path], object], output: OutputOptions) -> None:
    """Let `draw` write a figure as PNG, and beside it in the further formats that a scene asks for; others of an earlier run
    go.

    Raises
    ------
    SceneError
        If a file cannot be written.
    """
    write_file(path, draw)
    for name in FORMATS:
        other = path.with_suffix(f".{name}")
        if name in output.formats:
            write_file(other, draw)
        else:
            other.unlink(missing_ok=True)


def save(figure: Figure, path: Path | BytesIO, output: OutputOptions | None = None, dpi: int = 130) -> None:
    """Write a figure in the format of its name, with the resolution that a scene gives, if it gives one.

    PNG is written as `savefig` does, but drawn once and not twice, and compressed less, which takes half the time for files of
    about the same size."""
    figure.set_dpi(dpi if output is None or output.dpi is None else output.dpi)
    with _ONE_AT_A_TIME, warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from")  # a title may have any character
        if isinstance(path, Path) and path.suffix.removeprefix(".") in FORMATS:
            figure.savefig(path, metadata={"Date": None} if path.suffix == ".svg" else {"CreationDate": None})
            return
        canvas = FigureCanvasAgg(figure)
        canvas.print_png(path, pil_kwargs={"compress_level": _COMPRESSION})  # type: ignore[no-untyped-call]
