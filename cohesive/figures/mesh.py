"""The picture of a mesh before anything happens to it: crack, sets, and what is held, driven and measured."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

from meshing.cells import CELLS

from ..arrays import Array
from ..model.marks import marks
from .cells import corners_of, outline_cells
from .drawing import new_figure, plain_legend, save, set_title
from .marks import draw_marks, draw_solid_marks
from .solid import on_axes, seen_faces, seen_ratio, solid_axes

if TYPE_CHECKING:
    from ..model.mesh import CrackedMesh
    from ..results.run_data import OffPath
    from ..scenes.scene import Scene

_BODY, _BAND, _CRACK = "#eef1f4", "#f6c9a8", "C3"

#: where the bulk is pulled beyond its strength
_PULLED: dict[str, Any] = {"linestyle": "none", "marker": "*", "color": "C1", "markersize": 13, "markeredgecolor": "k"}

#: margin around the body for its marks, as a part of its larger side
_MARGIN = 0.14


def save_mesh(scene: Scene, mesh: CrackedMesh, path: Path, off_path: OffPath | None = None) -> None:
    """Draw the mesh of a scene with its crack or band, its marks, and the place off the path that is pulled too much."""
    figure = _solid_figure(scene, mesh, off_path) if mesh.dimension == 3 else _plane_figure(scene, mesh, off_path)
    half = ["one half of the body"] if scene.model.half else []
    set_title(figure, scene.title, *half)
    save(figure, path, scene.output)


def _plane_figure(scene: Scene, mesh: CrackedMesh, off_path: OffPath | None) -> Figure:
    points = mesh.points
    span = np.ptp(points, axis=0) + 2 * _MARGIN * float(np.ptp(points, axis=0).max())
    ratio = float(span[1] / span[0])
    if ratio > 1.2:  # the legend beside a tall body, below a long one
        height = 7.0
        figure = new_figure(float(np.clip(height / ratio, 2.5, 7.0)) + 3.6, height)
    else:
        width = float(np.clip(6.0 / ratio, 6.5, 9.0))
        figure = new_figure(width, float(np.clip(0.92 * width * ratio + 1.3, 3.4, 9.5)))
    axes = figure.add_subplot()
    linewidth = float(np.clip(12.0 / np.sqrt(sum(len(block.data) for block in (*mesh.bulk, *mesh.band))), 0.05, 0.5))
    for blocks, colour, label in ((mesh.bulk, _BODY, None), (mesh.band, _BAND, "elements that may crack")):
        if blocks:
            faces = corners_of([points[block.data[:, : CELLS[block.type].n_corners]] for block in blocks])
            outline_cells(axes, faces, colour, linewidth, label)
    if mesh.crack is not None:
        axes.add_collection(
            LineCollection(list(points[mesh.crack.data[:, :2]]), colors=_CRACK, linewidths=2.0, label="crack path")
        )
    elif scene.specimen.paths:
        lines = [np.array(line) for line in scene.specimen.paths]
        axes.add_collection(LineCollection(lines, colors=_CRACK, linewidths=0.8, label="crack path"))
    draw_marks(axes, marks(scene.specimen, mesh, scene.model.plane, scene.model.half), points)
    if off_path is not None:
        axes.plot(*off_path.place, label=_passes(off_path), zorder=5, **_PULLED)
    _finish(axes, ratio)
    return figure


def _passes(off_path: OffPath) -> str:
    return f"{off_path.times:.2g} ft off the path"


def _finish(axes: Axes, ratio: float) -> None:
    """Limits around the marks, labels and legend."""
    axes.autoscale_view()
    axes.margins(0.03)
    axes.set_aspect("equal")
    axes.set(xlabel="x (mm)", ylabel="y (mm)")
    figure = axes.figure
    assert isinstance(figure, Figure)
    if ratio > 1.2:
        plain_legend(figure, axes, loc="outside right center", fontsize="small")
    else:
        columns = 3 if figure.get_figwidth() > 8.0 else 2
        plain_legend(figure, axes, loc="outside lower center", ncols=columns, fontsize="small", borderaxespad=0.0)


def _solid_figure(scene: Scene, mesh: CrackedMesh, off_path: OffPath | None) -> Figure:
    points = mesh.points
    height = float(np.clip(7.0 * seen_ratio(points) + 2.2, 4.0, 7.6))
    figure = new_figure(8.5, height)
    figure.set_layout_engine("none")
    axes = solid_axes(figure, (0.06, 1.3 / height, 0.88, 1.0 - 2.0 / height), points)
    corners, cell = seen_faces([(block.type, block.data) for block in (*mesh.bulk, *mesh.band)], points)
    count = sum(len(block.data) for block in mesh.bulk)
    colours = np.where((cell < count)[:, None], [[0.93, 0.945, 0.957, 0.35]], [[0.965, 0.79, 0.66, 0.6]])
    axes.add_collection3d(Poly3DCollection(list(on_axes(corners)), facecolors=colours, edgecolors="0.6", linewidths=0.2))
    if mesh.faces is not None:
        _draw_crack(axes, points[mesh.minus_faces])
    draw_solid_marks(axes, marks(scene.specimen, mesh, scene.model.plane, scene.model.half), points)
    if off_path is not None:
        axes.plot(*on_axes(off_path.place[None]).T, label=_passes(off_path), zorder=5, **_PULLED)
    plain_legend(figure, axes, loc="lower center", ncols=4, fontsize="small")
    return figure


def _draw_crack(axes: Axes, corners: Array) -> None:
    """The crack surface."""
    faces = on_axes(corners)
    edges = np.concatenate([faces, faces[:, :1]], axis=1)
    surface = Line3DCollection(list(edges), colors=_CRACK, linewidths=0.8, label="crack surface")
    axes.add_collection3d(surface)  # type: ignore[attr-defined]
