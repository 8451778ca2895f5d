"""The files of a series of specimens: table, statistics as JSON, and the measured curves in one figure."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from ..measured.curve import Measured
from ..measured.series import CHARACTERISTIC, Series
from ..results.files import write_table, write_text
from ..scenes.tables import OutputOptions
from .drawing import draw_measured, new_figure, plain_legend, save, set_force_label, write_figure

#: the files
FILES = ("series.csv", "series.json", "series.png")


def write_series(
    folder: Path, series: Series, curves: Sequence[Measured], facts: Mapping[str, Any], output: OutputOptions
) -> None:
    """Write series.csv, series.json, which begins with some facts, and series.png, with what a scene says of figures;
    SceneError if a file cannot be written."""
    head, *rows = series.rows()
    write_table(folder / FILES[0], map(str, head), (["" if cell is None else cell for cell in row] for row in rows))
    numbers = {
        "values": {name: dict(zip(series.names, each, strict=True)) for name, each in series.values.items()},
        "intervals": {name: dict(zip(series.names, each, strict=True)) for name, each in series.intervals.items()},
        "units": dict(series.units),
        "statistics": {
            name: {key: value if value == value else None for key, value in asdict(each).items()}
            for name, each in series.statistics.items()
        },
        "characteristic": CHARACTERISTIC,
    }
    write_text(folder / FILES[1], json.dumps({**facts, **numbers}, indent=2) + "\n")
    write_figure(folder / FILES[2], lambda path: save_series(curves, series.names, path, output), output)


def save_series(curves: Sequence[Measured], names: Sequence[str], path: Path, output: OutputOptions) -> None:
    """Draw the curves of some specimens, load over what was measured (mm)."""
    figure = new_figure(6.4, 4.4, output)
    axes = figure.subplots()
    for i, (curve, name) in enumerate(zip(curves, names, strict=True)):
        draw_measured(axes, curve, f"C{i % 10}", name)
    motions = dict.fromkeys(curve.against for curve in curves)
    axes.set_xlabel(f"{', '.join(motions)} (mm)")
    set_force_label(axes, "load", output.force_unit)
    axes.axhline(0.0, color="0.5", linewidth=0.6)
    plain_legend(axes, axes)
    save(figure, path, output)
