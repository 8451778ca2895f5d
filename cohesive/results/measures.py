"""Numbers of a run's curve and its energies, for its summary, run.json and notebooks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import Array

if TYPE_CHECKING:
    from .run_data import RunData

#: what the columns `opening` and `sliding` are called beside a gauge in charge, if no gauge measures them
_JUMPS = {"opening": "mean jump", "sliding": "mean sliding"}


def label_of(data: RunData, column: str) -> str:
    """What a column is called in words: its name, but for the mean jump if another measure of the opening is in charge."""
    gauges = data.scene.specimen.gauges()
    measures = (data.controlled, *(stage.control for stage in data.scene.stages))
    is_beside = not data.scene.specimen.has_main_gauge and any(name in gauges for name in measures)
    return (_JUMPS.get(column, column) if is_beside else column).replace("_", " ")


def peak_text(data: RunData, measure: str | None = None) -> str:
    """The peak in words, its place on a column of the history, mm; default: the measure in charge."""
    measure = measure or data.controlled
    label = "a driven motion of" if measure == "driven" else label_of(data, measure)
    return f"{data.peak_load:.5g} N at {label} {data.at_peak(data.history[measure]):.4g} mm"


def curve_measures(data: RunData) -> dict[str, Any]:
    """Measures of the load over a motion x, both columns of the history.

    Returns
    -------
    measures : over (the name of x), initial_stiffness (N/mm, of the undamaged body; None if x is no motion), peak (N), at_peak
        (mm), fallen_to_half_at (mm; None if the load does not fall to half the peak), area (N mm,
        under the load over x to the end), last (N)
    """
    if not data.steps:
        return {}
    name, peak = data.controlled, data.peak
    x, load = data.history[name], data.history["load"]
    return {
        "over": name,
        "initial_stiffness": data.facts.initial_stiffness.get(name),
        "peak": peak.load,
        "at_peak": peak.at,
        "fallen_to_half_at": _fallen(x[data.peak_row :], load[data.peak_row :], 0.5 * peak.load),
        "area": float(0.5 * (load[1:] + load[:-1]) @ np.diff(x)),
        "last": float(load[-1]),
    }


def _fallen(x: Array, load: Array, half: float) -> float | None:
    """Where a branch that begins at the peak falls to half of it (N), mm."""
    below = np.flatnonzero(load <= half)
    if not len(below) or half <= 0:
        return None
    after = int(below[0])
    share = (load[after - 1] - half) / (load[after - 1] - load[after])
    return float(x[after - 1] + share * (x[after] - x[after - 1]))
