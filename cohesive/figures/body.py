"""Pictures of the deformed body of a run, at the peak and at the end."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import Collection, LineCollection
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D

from meshing.cells import CELLS

from ..arrays import Array, Index
from ..elements.rotations import major_stress
from ..results.fields import Frame, Planes, magnification
from ..results.measures import label_of
from .cells import corners_of, fill_cells
from .drawing import new_figure, save, set_title
from .solid import draw_body, draw_crack, frame_body, seen_ratio, solid_axes

if TYPE_CHECKING:
    from ..results.run_data import RunData

_STRESS = "major principal stress (MPa)"


def save_deformed(data: RunData, path: Path) -> None:
    """The body at the peak and in the last row, coloured by the major principal stress, displacements magnified.

    The stress is averaged at the nodes, and both pictures have one scale, centred at 0 and capped at ft."""
    rows = sorted({data.peak_row, data.steps})
    figure = _solid_figure(data, rows) if data.fields.mesh.dimension == 3 else _plane_figure(data, rows)
    half = ["one half of the body"] if data.scene.model.half else []
    set_title(figure, data.scene.title, *half)
    save(figure, path, data.scene.output)


def draw_deformed(axes: Axes, data: RunData, row: int) -> None:
    """The body in one row of the history; of a solid one into 3D axes.

    Raises
    ------
    ValueError
        If the axes are not 3D though the body is.
    """
    if data.fields.mesh.dimension == 2:
        _draw_plane(axes, data, row, _reach(data, [row]))
        return
    if not isinstance(axes, Axes3D):
        raise ValueError("ax: the body is solid; expected axes with projection='3d'")
    frame = data.frame(row)
    warped, factor = _warped(data, frame)
    frame_body(axes, warped)
    body = draw_body(axes, data, warped, _stress(data, frame))
    _limit(body, _reach(data, [row]))
    axes.set_title(_words(data, row, factor), fontsize="medium")
    figure = axes.figure
    assert isinstance(figure, Figure)
    figure.colorbar(body, ax=axes, label=_STRESS, shrink=0.6)


def _plane_figure(data: RunData, rows: list[int]) -> Figure:
    """States side by side if the body is tall, else one above the other."""
    span = np.ptp(data.fields.mesh.points, axis=0)
    ratio, count = float(span[1] / span[0]), len(rows)
    if ratio > 1.2:
        width = float(np.clip(6.0 / ratio + 1.8, 3.4, 5.0))
        figure = new_figure(count * width, float(np.clip(0.75 * width * ratio + 1.2, 3.0, 8.0)))
        all_axes = figure.subplots(1, count, squeeze=False)[0]
    else:
        width = float(np.clip(5.0 / ratio, 5.5, 8.0))
        figure = new_figure(width, float(np.clip(count * (0.75 * width * ratio + 0.9) + 0.4, 2.6, 10.0)))
        all_axes = figure.subplots(count, 1, squeeze=False)[:, 0]
    reach = _reach(data, rows)
    for axes, row in zip(all_axes, rows, strict=True):
        _draw_plane(axes, data, row, reach)
    return figure


def _draw_plane(axes: Axes, data: RunData, row: int, reach: float) -> None:
    """A 2D body with its crack faces, or with the open crack planes of its band."""
    frame = data.frame(row)
    (warped, factor), stress = _warped(data, frame), _stress(data, frame)
    faces = [warped[block.cells[:, : block.element.cell.n_corners]] for block in (*data.fields.bulk, *data.fields.band)]
    body = fill_cells(axes, corners_of(faces), stress)
    _limit(body, reach)
    if data.is_smeared:
        _draw_planes(axes, data.fields.planes.of(frame.step), data.fields.cell, faces[len(data.fields.bulk) :])
    elif (crack := data.fields.mesh.crack) is not None:
        for side in CELLS[crack.type].sides:
            axes.add_collection(LineCollection(list(warped[crack.data[:, side[:2]]]), colors="C3", linewidths=0.8))
    margin = 0.02 * float(np.ptp(data.fields.mesh.points, axis=0).max())
    axes.set_xlim(warped[:, 0].min() - margin, warped[:, 0].max() + margin)
    axes.set_ylim(warped[:, 1].min() - margin, warped[:, 1].max() + margin)
    axes.set_aspect("equal")
    axes.set(xlabel="x (mm)", ylabel="y (mm)")
    is_wide = np.ptp(warped[:, 0]) > 1.25 * np.ptp(warped[:, 1])
    axes.set_title(_words(data, row, factor, ", " if is_wide else "\n"), fontsize="medium" if is_wide else "small")
    figure = axes.figure
    assert figure is not None
    figure.colorbar(body, ax=axes, label=_STRESS.replace("principal ", "principal\n"), shrink=0.9, extend="both")


def _solid_figure(data: RunData, rows: list[int]) -> Figure:
    """A 3D body beside its crack surface, which it may hide."""
    count = len(rows)
    height = float(np.clip(5.0 * seen_ratio(data.fields.mesh.points) + 1.3, 2.4, 5.0))  # of a row
    figure = new_figure(12.0, 0.6 + count * height)
    figure.set_layout_engine("none")  # 3D axes do not take part in it
    tall = height / (0.6 + count * height)
    reach = _reach(data, rows)
    for i, row in enumerate(rows):
        frame = data.frame(row)
        warped, factor = _warped(data, frame)
        bottom = (count - 1 - i) * tall
        for left, draw, name, values in (
            (0.0, draw_body, _STRESS, _stress(data, frame)),
            (0.5, draw_crack, "crack opening (mm)", frame.cracks["opening"]),
        ):
            axes = solid_axes(figure, (left + 0.01, bottom + 0.1 * tall, 0.385, 0.82 * tall), warped)
            drawn = draw(axes, data, warped, values)
            if name == _STRESS:
                _limit(drawn, reach)
            beside = figure.add_axes((left + 0.435, bottom + 0.2 * tall, 0.012, 0.5 * tall))
            bar = figure.colorbar(drawn, cax=beside, label=name)
            bar.ax.ticklabel_format(useOffset=False)
        figure.text(0.5, bottom + 0.94 * tall, _words(data, row, factor), ha="center")
    return figure


def _warped(data: RunData, frame: Frame) -> tuple[Array, float]:
    """Nodes of the deformed body, and by what its displacements are magnified."""
    points, u = data.fields.mesh.points, frame.displacement
    size = float(np.ptp(points, axis=0).max())
    factor = magnification(size, float(np.linalg.norm(u, axis=1).max()))
    return points + factor * u, factor


def _stress(data: RunData, frame: Frame) -> Array:
    """Major principal stress of each cell, MPa, the mean of what its nodes have: at a node that of the cells around it, on
    its side of the crack."""
    values = np.concatenate([major_stress(stress) for stress in frame.stress])
    blocks = [block.cells for block in (*data.fields.bulk, *data.fields.band)]
    nodes = np.concatenate([cells.ravel() for cells in blocks])
    cell = np.repeat(np.arange(len(values)), np.concatenate([np.full(len(cells), cells.shape[1]) for cells in blocks]))
    count = np.maximum(np.bincount(nodes), 1)
    at_nodes = np.bincount(nodes, values[cell]) / count
    return np.asarray(np.bincount(cell, at_nodes[nodes]) / np.bincount(cell))


def _reach(data: RunData, rows: list[int]) -> float:
    """End of the scale of stresses on either side of 0, MPa: what nearly all cells have in some rows, at most ft."""
    largest = max(float(np.percentile(abs(_stress(data, data.frame(row))), 99)) for row in rows)
    return max(min(largest, float(data.scene.material.ft)), 1e-12)


def _words(data: RunData, row: int, factor: float, between: str = ", ") -> str:
    """What a picture of a row shows."""
    row = row % len(data.history["load"])
    names = [name for name, at in (("peak", data.peak_row), ("last step", data.steps)) if at == row]
    which = ", ".join(names) or f"step {row}"
    x, load = (float(data.history[name][row]) for name in (data.controlled, "load"))
    return f"{which}: {load:.4g} N, {label_of(data, data.controlled)} {x:.3g} mm{between}displacements x {factor:g}"


def _limit(faces: Collection, reach: float) -> None:
    """Colours of both signs, blue for compression."""
    faces.set_cmap("coolwarm")
    faces.set_clim(-reach, reach)


def _draw_planes(axes: Axes, planes: Planes, cells: Index, faces: list[Array]) -> None:
    """The open crack planes of a band, as lines in the deformed cells that they belong to."""
    shown = planes.opening > 0.05 * max(planes.opening.max(initial=0.0), 1e-300)
    cell = cells[planes.point[shown]]
    corners = corners_of(faces)[cell]
    centre, size = corners.mean(axis=1), np.ptp(corners, axis=1).min(axis=1)
    along = 0.5 * size[:, None] * planes.normal[shown][:, ::-1] * [-1.0, 1.0]
    axes.add_collection(LineCollection(list(np.stack([centre - along, centre + along], axis=1)), colors="C3", linewidths=0.8))
