"""The movie of a run: the opening body beside its curve with a travelling point, and the traction along the crack path."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.animation import FFMpegWriter, PillowWriter
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ..arrays import Array
from ..errors import SceneError
from ..figures.drawing import draw_measured, new_figure
from ..results.files import write_file
from .views import Views

#: frames a second, and seconds that the last one stays
FPS, _STAYS = 10, 0.5

#: longest name of a file, bytes: systems allow 255, and the temporary name is longer
_LONGEST = 240


def check_movie(path: Path) -> None:
    """Refuse a file that no movie can be written to; SceneError."""
    if path.suffix not in (".gif", ".mp4"):
        raise SceneError(f"movie '{path}': expected a name that ends with .gif or .mp4")
    if path.suffix == ".mp4" and not FFMpegWriter.isAvailable():
        raise SceneError(f"movie '{path}': MP4 needs ffmpeg, which is not installed; expected .gif")
    if os.path.isdir(path) or not os.path.isdir(path.parent) or len(os.fsencode(path.name)) > _LONGEST:
        raise SceneError(
            f"movie '{path}': expected the name of a file of at most {_LONGEST} bytes, which is no folder and stands in one"
        )


def write_movie(views: Views, path: Path, on_frame: Callable[[], object] = lambda: None) -> None:
    """Write a GIF, or an MP4 if `path` ends so, which takes ffmpeg.

    Parameters
    ----------
    on_frame : called after each frame.

    Raises
    ------
    SceneError
        For another ending (see `check_movie`), without ffmpeg, or if the file cannot be written.
    """
    check_movie(path)

    def draw(temporary: Path) -> None:
        figure, update = _figure(views)
        writer = PillowWriter(FPS) if path.suffix == ".gif" else FFMpegWriter(FPS)
        with writer.saving(figure, str(temporary), dpi=90):
            for k in range(len(views.rows)):
                update(k)
                writer.grab_frame()
                on_frame()
            for _ in range(round(_STAYS * FPS)):
                writer.grab_frame()

    write_file(path, draw)


def _figure(views: Views) -> tuple[Figure, Callable[[int], None]]:
    """The figure, and what moves it to a frame: artists are kept, only their data change."""
    figure = new_figure(10.0, 5.6)
    grid = figure.add_gridspec(2, 2, width_ratios=(1.5, 1.0))
    body, curve, traction = (figure.add_subplot(place) for place in (grid[:, 0], grid[0, 1], grid[1, 1]))
    figure.suptitle(f"{views.result.scene.title}, {views.result.scene.model.kind} crack")
    curve.xaxis.set_major_locator(MaxNLocator(5))
    movers = [_body(body, views), _curve(curve, views), _traction(traction, views)]

    def update(k: int) -> None:
        for move in movers:
            move(k)

    update(0)
    figure.draw_without_rendering()
    figure.set_layout_engine("none")  # places stay, which saves most of the time of a frame
    return figure, update


def _body(axes: Axes, views: Views) -> Callable[[int], None]:
    top = 1.2 * float(views.softening[1][0])
    bulk = np.arange(len(views.polygons)) if views.result.is_smeared else np.flatnonzero(~views.is_crack)
    faces = PolyCollection([], cmap="coolwarm", edgecolors="0.5", linewidths=0.15)
    faces.set_clim(-top, top)
    axes.add_collection(faces)
    every = views.points + views.factor * views.displacement
    low, high = every.min(axis=(0, 1)), every.max(axis=(0, 1))
    room = 0.03 * (high - low).max()
    axes.set(xlim=(low[0] - room, high[0] + room), ylim=(low[1] - room, high[1] + room), aspect="equal")
    axes.set(xlabel="x (mm)", ylabel="y (mm)")
    axes.figure.colorbar(faces, ax=axes, orientation="horizontal", label="major stress (MPa)", shrink=0.8)
    axes.set_title(f"displacements x {views.factor:g}", fontsize="medium")

    def move(k: int) -> None:
        at = views.points + views.factor * views.displacement[k]
        faces.set_verts([at[views.polygons[i]] for i in bulk])
        faces.set_array(views.stress[k][bulk])

    return move


def _curve(axes: Axes, views: Views) -> Callable[[int], None]:
    measure = views.result.controlled
    x, y = views.result.history[measure], views.result.history["load"]
    for each in views.result.measured:
        draw_measured(axes, each, "0.6", "measured")
    axes.plot(x, y, color="0.7", linewidth=1.0)
    (line,) = axes.plot([], [], color="C0", label="computed")
    (point,) = axes.plot([], [], "o", color="C3")
    axes.set(xlabel=f"{measure} (mm)", ylabel="load (N)")
    axes.legend(fontsize="small")

    def move(k: int) -> None:
        row = int(views.rows[k])
        line.set_data(x[: row + 1], y[: row + 1])
        point.set_data([x[row]], [y[row]])

    return move


def _traction(axes: Axes, views: Views) -> Callable[[int], None]:
    values: Array = views.profiles["traction_n"]
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    ft = float(views.softening[1][0])
    low, high = max(low, -2.0 * ft), min(high, 2.0 * ft)  # the process zone is to be seen beside contact
    room = 0.08 * max(high - low, 1e-12)
    (line,) = axes.plot([], [], color="C0")
    axes.axhline(0.0, color="0.8", linewidth=0.8)
    axes.set(
        xlim=(views.distance[0], views.distance[-1]), ylim=(low - room, high + room), xlabel="along the crack path (mm)",
        ylabel="normal traction (MPa)",
    )  # fmt: skip

    def move(k: int) -> None:
        line.set_data(views.distance, values[k])

    return move
