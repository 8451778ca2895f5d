"""Cells of a plane body in a picture: many are drawn as few are."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from cohesive.arrays import Array
from cohesive.figures import cells
from cohesive.figures.cells import corners_of, fill_cells, outline_cells

SQUARE = np.array([[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]])
TRIANGLE = SQUARE[:, :3]


def drawn(faces: list[Array], values: Array | None) -> Array:
    """What is drawn of cells on a square of 3 x 3 mm, (n, n, 4)."""
    figure = Figure(figsize=(1.2, 1.2), dpi=100)
    axes = figure.add_axes((0, 0, 1, 1))
    axes.axis("off")
    axes.set(xlim=(-1, 2), ylim=(-1, 2))
    if values is None:
        outline_cells(axes, corners_of(faces), "#ff0000", 0.5, "label")
    else:
        fill_cells(axes, corners_of(faces), values).set_clim(0.0, 1.0)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba(), dtype=float) / 255


@pytest.mark.parametrize(
    "values, edges",
    [(np.array([1.0, 0.3]), 0.025), (None, 0.045)],  # half a missing square is 5.5 %
    ids=["filled", "outlined"],
)
@pytest.mark.parametrize(
    "faces",
    [[SQUARE, TRIANGLE - 1.0], pytest.param([TRIANGLE, TRIANGLE - 1.0], marks=pytest.mark.long)],
    ids=["mixed", "triangles"],
)
def test_many_cells_look_like_few(faces: list[Array], values: Array | None, edges: float) -> None:
    """But for pixels on the edges, which are not smoothed."""
    few = drawn(faces, values)
    times = cells.MANY // len(faces) + 1  # one upon the other
    many = drawn(faces * times, None if values is None else np.tile(values, times))
    differ = abs(few - many).max(axis=2) > 0.1
    assert differ.mean() < edges
    assert (many[..., :3] < 0.99).any(axis=2).mean() > 0.05  # something is drawn
