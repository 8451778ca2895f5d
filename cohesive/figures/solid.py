"""A deformed 3D body and its crack surface, seen from in front of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from mpl_toolkits.mplot3d.proj3d import proj_transform

from meshing.cutting.stars import Star

from ..arrays import Array, Index

if TYPE_CHECKING:
    from ..results.run_data import RunData

#: view in degrees, and the coordinates on matplotlib's axes: the third one, y, stands upright
_ELEVATION, _AZIMUTH, _ON_AXES = 22.0, 32.0, [2, 0, 1]

#: a crack that may be anywhere is shown by the cells that are open by this part of the widest
_SHOWN = 0.05

#: part of its place, and of the square that matplotlib draws into, that a body fills; the rest is for labels
_FILLED, _IN_SQUARE = 0.9, 0.9

#: smallest spread of a scale, over its middle: a smaller one would need labels with too many digits
_LEAST_SPREAD = 1e-3


def solid_axes(figure: Figure, place: tuple[float, float, float, float], points: Array) -> Axes3D:
    """3D axes in which a body with nodes at some points fills a part of a figure: left, bottom, width and height.

    matplotlib draws into a square, and cuts what is beyond it: the square may be larger than the part.
    """
    axes = figure.add_axes(place, projection="3d", proj_type="ortho")
    assert isinstance(axes, Axes3D)
    wide, high = frame_body(axes, points)
    left, bottom, *sides = place
    width, height = sides * figure.get_size_inches()
    side = min(_FILLED * width / wide, _FILLED * height / high) / figure.get_size_inches()
    middle = np.array([left, bottom]) + 0.5 * np.array(sides)
    axes.set_position((*(middle - 0.5 * side), *side))
    axes.patch.set_visible(False)
    return axes


def seen_ratio(points: Array) -> float:
    """Height over width of the box around a body with nodes at some points, as it is seen."""
    e, a = np.radians(_ELEVATION), np.radians(_AZIMUTH)
    sides = np.ptp(on_axes(points), axis=0)
    wide = abs(np.array([np.sin(a), np.cos(a), 0.0])) @ sides
    high = abs(np.array([np.sin(e) * np.cos(a), np.sin(e) * np.sin(a), np.cos(e)])) @ sides
    return float(high / wide)


def draw_body(axes: Axes3D, data: RunData, warped: Array, stress: Array) -> Poly3DCollection:
    """The outer faces that the reader sees, crack faces included, with the stress of their cells."""
    blocks = [(block.kind, block.cells) for block in (*data.fields.bulk, *data.fields.band)]
    corners, cell = seen_faces(blocks, warped)
    return _draw(axes, corners, stress[cell], "viridis")


def draw_crack(axes: Axes3D, data: RunData, warped: Array, opening: Array) -> Poly3DCollection:
    """The crack surface coloured by its opening in each cell, mm; for a crack that may be anywhere, the cells that are
    open."""
    fields = data.fields
    if fields.mesh.faces is not None:
        return _draw(axes, warped[fields.mesh.minus_faces], opening, "plasma")
    shown = opening > _SHOWN * max(opening.max(initial=0.0), 1e-300)
    first, blocks, values = 0, [], []
    for block in fields.band:
        at = np.flatnonzero(shown[first : first + len(block.cells)])
        blocks.append((block.kind, block.cells[at]))
        values.append(opening[first + at])
        first += len(block.cells)
    nodes, cell = outer_faces(blocks)
    return _draw(axes, warped[nodes], np.concatenate(values)[cell], "plasma")


def seen_faces(cells: list[tuple[str, Index]], points: Array) -> tuple[Array, Index]:
    """Corners (n, k, 3) of the outer faces that the reader sees, and their cells (n,)."""
    nodes, cell = outer_faces(cells)
    corners = points[nodes]
    outward = -np.cross(corners[:, 2] - corners[:, 0], corners[:, 3 % nodes.shape[1]] - corners[:, 1])
    seen = outward @ _view() > 0
    return corners[seen], cell[seen]


def outer_faces(cells: list[tuple[str, Index]]) -> tuple[Index, Index]:
    """Corners (n, k) of the faces that belong to one cell only, their normal into it, and that cell (n,). A hexahedron
    that stands for a prism may have faces with equal corners."""
    star = Star.from_cells(cells)
    corners = star.nodes[:, : star.corners]
    _, number, count = np.unique(np.sort(corners, axis=1), axis=0, return_inverse=True, return_counts=True)
    once = count[number.ravel()] == 1
    return corners[once], star.cell[once]


def _draw(axes: Axes3D, corners: Array, values: Array, colours: str) -> Poly3DCollection:
    """Polygons with a value each."""
    faces = Poly3DCollection(
        list(on_axes(corners)), array=values, cmap=colours, edgecolors=(0.0, 0.0, 0.0, 0.3), linewidths=0.15
    )
    axes.add_collection3d(faces)
    if len(values):
        middle, spread = (values.max() + values.min()) / 2, values.max() - values.min()
        reach = max(spread, _LEAST_SPREAD * abs(middle)) / 2
        faces.set_clim(middle - reach, middle + reach)
    return faces


def on_axes(points: Array) -> Array:
    """Coordinates x, y, z in the order of the axes: the third one, y, stands upright."""
    return np.asarray(points[..., _ON_AXES])


def frame_body(axes: Axes3D, points: Array) -> Array:
    """Equal scales, labels, and a zoom with which a body with nodes at some points fills a square; its width and height in
    parts of it."""
    low, high = (on_axes(bound) for bound in (points.min(axis=0), points.max(axis=0)))
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set(xlabel="z (mm)", ylabel="x (mm)", zlabel="y (mm)")
    axes.view_init(_ELEVATION, _AZIMUTH)
    size = (high - low) / (high - low).max()
    axes.set_box_aspect(tuple(size))
    parts = _seen_part(axes, low, high)
    axes.set_box_aspect(tuple(size), zoom=_IN_SQUARE / parts.max())
    for axis, length in zip((axes.xaxis, axes.yaxis, axes.zaxis), size, strict=True):
        axis.set_major_locator(MaxNLocator(max(1, round(5 * length))))
        axis.labelpad = 2 + 8 * length
    filled: Array = parts * _IN_SQUARE / parts.max()
    return filled


def _seen_part(axes: Axes3D, low: Array, high: Array) -> Array:
    """Width and height that a box is seen with, in parts of the square that axes draw into."""
    corners = np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, -1)
    axes.apply_aspect()
    seen = np.array(proj_transform(*corners, axes.get_proj())[:2])
    box = axes.get_window_extent()
    pixels = axes.transData.transform(seen.T)
    parts: Array = np.ptp(pixels, axis=0) / min(box.width, box.height)
    return parts


def _view() -> Array:
    """Direction from the body to the reader."""
    e, a = np.radians(_ELEVATION), np.radians(_AZIMUTH)
    return np.array([np.cos(e) * np.sin(a), np.sin(e), np.cos(e) * np.cos(a)])
