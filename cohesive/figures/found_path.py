"""The files of a search for crack paths: path.csv and path.png."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import astuple
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes

from ..growth.found import VERTEX_COLUMNS, FoundPath
from ..results.files import remove, write_file, write_table
from .drawing import new_figure, save, set_title

if TYPE_CHECKING:
    from ..results.run_data import RunData


def write_found(data: RunData, folder: Path) -> None:
    """path.csv and path.png; without a search none, and those of an earlier run are removed."""
    if data.found is None:
        remove(folder, ("path.csv", "path.png"))
        return
    write_table(folder / "path.csv", VERTEX_COLUMNS, _rows(data.found))
    write_file(folder / "path.png", partial(save_path, data.found, data.scene.title))


def _rows(found: FoundPath) -> Iterator[list[str]]:
    """Every point of the paths, the last one of each without a direction."""
    for number, line in enumerate(found.lines, start=1):
        rows = [astuple(v) for v in found.vertices if v.crack == number] or [(number, *p) for p in line[:-1]]
        for row in [*rows, (number, *line[-1])]:
            values = [int(value) if isinstance(value, bool) else value for value in row]
            cells = ["" if math.isnan(value) else f"{value:.9g}" for value in values]
            yield cells + [""] * (len(VERTEX_COLUMNS) - len(cells))


def save_path(found: FoundPath, title: str, path: Path) -> None:
    """The body with the found paths and the trial paths."""
    face = np.asarray(found.faces[0], dtype=float)
    span = np.ptp(face, axis=0)
    ratio = span[1] / span[0]
    width = float(np.clip(8.0 / ratio, 4.5, 9.0))
    figure = new_figure(width, float(np.clip(width * ratio + 1.4, 2.8, 8.5)))
    axes = figure.add_subplot()
    draw_path(axes, found)
    axes.set_aspect("equal")
    axes.set(xlabel="x (mm)", ylabel="y (mm)")
    set_title(figure, title)
    figure.legend(frameon=False, loc="outside lower center", ncols=4, fontsize="small")
    save(figure, path)


def draw_path(axes: Axes, found: FoundPath) -> None:
    """Outline, trial paths and found paths."""
    for i, face in enumerate(found.faces):  # the outer one, then those of holes
        axes.fill(*np.asarray(face, dtype=float).T, facecolor="white" if i else "0.93", edgecolor="0.5", linewidth=0.8)
    for i, slit in enumerate(found.slits):
        axes.plot(*np.asarray(slit).T, "k-", linewidth=1.6, label="notch" if i == 0 else None)
    label: str | None = "trial paths"
    for trial in found.trials:
        for line in trial:
            axes.plot(*np.asarray(line).T, color="C0", linewidth=0.5, alpha=0.6, label=label)
            label = None
    for i, line in enumerate(found.lines):
        axes.plot(*np.asarray(line).T, color="C3", linewidth=1.6, label="found path" if i == 0 else None)
    fixed = np.array([(v.x, v.y) for v in found.vertices if v.fixed_direction]).reshape(-1, 2)
    clear = np.array([(v.x, v.y) for v in found.vertices if not v.fixed_direction]).reshape(-1, 2)
    if len(clear):
        axes.plot(*clear.T, "o", color="C3", markersize=2.5, label="direction from the stress ahead")
    if len(fixed):
        axes.plot(*fixed.T, "o", markerfacecolor="white", color="C3", markersize=2.5, label="fixed direction")
