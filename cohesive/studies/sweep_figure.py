"""The curves of a sweep in one figure: the first varied key is the colour, the second the line's style."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from numbers import Real
from typing import Any, Literal

import numpy as np
from matplotlib import colormaps
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..figures.drawing import abscissa, draw_reference, new_figure, set_force_label, set_title
from ..results.run_data import RunData
from ..scenes.keys import key_units
from ..scenes.scene import Scene

#: more values than these have a bar of colours in place of a legend
_MOST_IN_LEGEND = 8

_STYLES: tuple[Literal["-", "--", ":", "-."], ...] = ("-", "--", ":", "-.")


def sweep_figure(
    scene: Scene, vary: Mapping[str, Sequence[Any]], measure: str, drawn: Sequence[tuple[dict[str, Any], RunData, bool]]
) -> Figure:
    """Load over the measure in charge of all runs; a cross ends one that stopped.

    Parameters
    ----------
    scene : whose keys vary
    vary : values by key
    measure : a column of all histories, mm
    drawn : for each run its own values by key, its data, and whether it came to its end
    """
    figure = new_figure(8.0, 5.2, scene.output)
    axes = figure.add_subplot()
    draw_reference(axes, drawn[0][1], measure)
    keys = list(vary)
    place = {key: {repr(value): i for i, value in enumerate(vary[key])} for key in keys}
    colour = _Colours(vary[keys[0]])
    for own, data, is_done in drawn:
        what, x, load = abscissa(data, measure)
        style = "-" if len(keys) == 1 else _STYLES[place[keys[1]][repr(own[keys[1]])] % len(_STYLES)]
        shade = colour.of(place[keys[0]][repr(own[keys[0]])])
        axes.plot(x, load, style, color=shade, linewidth=1.2)
        if not is_done:
            axes.plot(x[-1:], load[-1:], "x", color=shade)
    axes.axhline(0.0, color="0.5", linewidth=0.6)
    axes.set_xlabel(f"{what} (mm)")
    set_force_label(axes, "load", scene.output.force_unit)
    set_title(figure, scene.title)
    units = key_units(scene)
    entries = [*axes.get_legend_handles_labels()[0]]
    if colour.has_bar:
        figure.colorbar(colour.bar(), ax=axes, label=f"{keys[0]} ({units[keys[0]]})" if units.get(keys[0]) else keys[0])
    else:
        entries += [Line2D([], [], color=colour.of(i), label=_label(keys[0], v, units)) for i, v in enumerate(vary[keys[0]])]
    for key in keys[1:2]:
        styled = enumerate(vary[key][: len(_STYLES)])
        entries += [Line2D([], [], color="0.3", linestyle=_STYLES[i], label=_label(key, value, units)) for i, value in styled]
    if not all(is_done for _, _, is_done in drawn):
        entries.append(Line2D([], [], color="0.3", linestyle="", marker="x", label="stopped"))
    if entries:
        axes.legend(handles=entries, frameon=False, fontsize=8)
    return figure


class _Colours:
    """One colour for each value of a key: by its size if there are many numbers, else by its place."""

    def __init__(self, values: Sequence[Any]) -> None:
        self.has_bar = len(values) > _MOST_IN_LEGEND and all(isinstance(value, Real) for value in values)
        self._values = np.array(values, dtype=float) if self.has_bar else np.arange(len(values), dtype=float)
        self._scale = Normalize(float(self._values.min()), float(self._values.max()) or 1.0)
        self._map = colormaps["viridis"].resampled(256)

    def of(self, place: int) -> Any:
        """The colour of the value at a place."""
        return self._map(0.92 * float(self._scale(self._values[place])))  # its last part is too pale for a line

    def bar(self) -> ScalarMappable:
        """What the bar of colours shows."""
        from matplotlib.colors import ListedColormap

        return ScalarMappable(self._scale, ListedColormap(self._map(np.linspace(0.0, 0.92, 256))))


def _label(key: str, value: Any, units: Mapping[str, str]) -> str:
    text = f"{value:.5g}" if isinstance(value, float) else str(value)
    return f"{key} = {text} {units.get(key, '')}".rstrip()
