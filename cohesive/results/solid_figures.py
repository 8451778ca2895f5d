"""A deformed 3D body and its crack surface, seen from in front of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from meshing.stars import Star

from ..arrays import Array, Index

if TYPE_CHECKING:
    from .frames import Frame
    from .run_data import RunData

#: view in degrees, and the coordinates on matplotlib's axes: the third one, y, stands upright
_ELEVATION, _AZIMUTH, _ON_AXES = 22.0, 32.0, [2, 0, 1]

#: a crack that may be anywhere is shown by the cells that are open by this part of the widest
_SHOWN = 0.05

_OPENING = "crack opening (mm)"

#: smallest spread of a scale, over its middle: a smaller one would need labels with too many digits
_LEAST_SPREAD = 1e-3


def draw_body(figure: Figure, left: float, data: RunData, warped: Array, stress: Array) -> Poly3DCollection:
    """The outer faces that the reader sees, crack faces included, with the stress of their cells."""
    blocks = [(block.kind, block.cells) for block in (*data.model.bulk, *data.model.band)]
    nodes, cell = outer_faces(blocks)
    corners = warped[nodes]
    outward = -np.cross(corners[:, 2] - corners[:, 0], corners[:, 3 % nodes.shape[1]] - corners[:, 1])
    seen = outward @ _view() > 0
    return _draw(figure, left, warped, corners[seen], stress[cell[seen]], "major principal stress (MPa)", "viridis")


def draw_crack(figure: Figure, left: float, data: RunData, frame: Frame, warped: Array) -> Poly3DCollection:
    """The crack surface coloured by its opening, mm; for a crack that may be anywhere, the cells that are open."""
    model, opening = data.model, frame.cracks["opening"]
    if model.cracks.faces is not None:
        return _draw(figure, left, warped, warped[model.mesh.minus_faces], opening, _OPENING, "plasma")
    shown = opening > _SHOWN * max(opening.max(initial=0.0), 1e-300)
    first, blocks, values = 0, [], []
    for block in model.band:
        at = np.flatnonzero(shown[first : first + len(block.cells)])
        blocks.append((block.kind, block.cells[at]))
        values.append(opening[first + at])
        first += len(block.cells)
    nodes, cell = outer_faces(blocks)
    return _draw(figure, left, warped, warped[nodes], np.concatenate(values)[cell], _OPENING, "plasma")


def outer_faces(cells: list[tuple[str, Index]]) -> tuple[Index, Index]:
    """Corners (n, k) of the faces that belong to one cell only, their normal into it, and that cell (n,). A hexahedron
    that stands for a prism may have faces with equal corners."""
    star = Star.from_cells(cells)
    corners = star.nodes[:, : star.corners]
    _, number, count = np.unique(np.sort(corners, axis=1), axis=0, return_inverse=True, return_counts=True)
    once = count[number.ravel()] == 1
    return corners[once], star.cell[once]


def _draw(
    figure: Figure, left: float, warped: Array, corners: Array, values: Array, name: str, colours: str
) -> Poly3DCollection:
    """Polygons in axes that hold the whole body, with equal scales, and their colours beside them."""
    axes = figure.add_axes((left, 0.02, 0.37, 0.92), projection="3d", proj_type="ortho")
    assert isinstance(axes, Axes3D)
    faces = Poly3DCollection(
        list(corners[..., _ON_AXES]), array=values, cmap=colours, edgecolors=(0.0, 0.0, 0.0, 0.3), linewidths=0.15
    )
    axes.add_collection3d(faces)
    if len(values):
        middle, spread = (values.max() + values.min()) / 2, values.max() - values.min()
        reach = max(spread, _LEAST_SPREAD * abs(middle)) / 2
        faces.set_clim(middle - reach, middle + reach)
    low, high = (bound[_ON_AXES] for bound in (warped.min(axis=0), warped.max(axis=0)))
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set(xlabel="z (mm)", ylabel="x (mm)", zlabel="y (mm)")
    axes.set_box_aspect(tuple(high - low), zoom=0.85)
    for axis, length in zip((axes.xaxis, axes.yaxis, axes.zaxis), (high - low) / (high - low).max(), strict=True):
        axis.set_major_locator(MaxNLocator(max(1, round(5 * length))))
        axis.labelpad = 4 + 8 * length
    axes.view_init(_ELEVATION, _AZIMUTH)
    bar = figure.colorbar(faces, cax=figure.add_axes((left + 0.385, 0.2, 0.012, 0.55)), label=name)
    bar.ax.ticklabel_format(useOffset=False)
    return faces


def _view() -> Array:
    """Direction from the body to the reader."""
    e, a = np.radians(_ELEVATION), np.radians(_AZIMUTH)
    return np.array([np.cos(e) * np.sin(a), np.sin(e), np.cos(e) * np.cos(a)])
