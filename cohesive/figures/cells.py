"""Cells of a plane body in a picture: few as polygons, many by what draws fast."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import Collection, PolyCollection, TriMesh
from matplotlib.colors import ListedColormap
from matplotlib.tri import Triangulation

from ..arrays import Array

#: cells above which they are drawn as triangles of one list, or as one line: a polygon each takes four times as long, and
#: their edges are finer than a pixel
MANY = 20_000

#: cells lie within the axes: a layout need not look for the box around all of them, which takes a while
_WITHIN: dict[str, Any] = {"in_layout": False}


def corners_of(faces: list[Array]) -> Array:
    """Corners of all cells, (n, 4, 2), a triangle's last corner repeated; (n, 3, 2) if all are triangles."""
    most = max(f.shape[1] for f in faces)
    return np.concatenate([np.pad(f, ((0, 0), (0, most - f.shape[1]), (0, 0)), mode="edge") for f in faces])


def fill_cells(axes: Axes, corners: Array, values: Array) -> Collection:
    """Cells coloured by a value each.

    Parameters
    ----------
    corners : (n, 3 or 4, 2), mm
    values : (n,)
    """
    if len(corners) <= MANY:
        polygons = PolyCollection(
            corners,  # type: ignore[arg-type]  # an array is drawn much faster than a list
            array=values, cmap="viridis", edgecolors="face", linewidths=0.3, **_WITHIN,
        )  # fmt: skip
        axes.add_collection(polygons)
        return polygons
    halves = [corners[:, :3], *([corners[:, [0, 2, 3]]] if corners.shape[1] == 4 else [])]
    x, y = np.concatenate(halves).reshape(-1, 2).T
    mesh = Triangulation(x, y, np.arange(len(x)).reshape(-1, 3))
    triangles = TriMesh(mesh, array=np.repeat(np.tile(values, len(halves)), 3), cmap="viridis", **_WITHIN)
    axes.add_collection(triangles, autolim=False)
    return triangles


def outline_cells(axes: Axes, corners: Array, colour: str, linewidth: float, label: str | None = None) -> None:
    """Cells of one colour with their edges.

    Parameters
    ----------
    corners : (n, 3 or 4, 2), mm
    linewidth : of the edges, points
    """
    if len(corners) <= MANY:
        polygons = PolyCollection(
            corners,  # type: ignore[arg-type]
            facecolors=colour, edgecolors="0.55", linewidths=linewidth, label=label, **_WITHIN,
        )  # fmt: skip
        axes.add_collection(polygons)
        return
    fill_cells(axes, corners, np.zeros(len(corners))).set_cmap(ListedColormap([colour]))
    outlines = np.full((len(corners), corners.shape[1] + 2, 2), np.nan)  # a line ends at nan
    outlines[:, :-2], outlines[:, -2] = corners, corners[:, 0]
    axes.plot(*outlines.reshape(-1, 2).T, color="0.55", linewidth=linewidth, **_WITHIN)
    axes.fill([], [], facecolor=colour, edgecolor="0.55", label=label)
