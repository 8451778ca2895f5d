"""Figures of a run: its load over its opening, and the deformed body."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import Collection, LineCollection, PolyCollection
from matplotlib.figure import Figure

from ..arrays import Array
from ..elements.rotations import major_stress
from .agreement import agreements
from .files import write_file
from .frames import Frame
from .solid_figures import draw_body, draw_crack

if TYPE_CHECKING:
    from ..scenes.measured import Reference
    from .run_data import RunData

#: measured curves of fewer points are drawn with a mark for each
_FEW = 100

#: corners of the bulk cells
_CORNERS = {"triangle": 3, "triangle6": 3, "quad": 4, "quad8": 4, "quad6": 4}


def write_figures(data: RunData, folder: Path) -> None:
    """curve.png and deformed.png; without a converged step none, and those of an earlier run are removed."""
    for name, draw in (("curve.png", save_curve), ("deformed.png", save_deformed)):
        if data.steps:
            write_file(folder / name, partial(draw, data))
        else:
            (folder / name).unlink(missing_ok=True)


def save_curve(data: RunData, path: Path) -> None:
    """Load against opening, with the measured curve or band if there is one; for a platen that moves both ways also the
    mean tractions on the crack against sliding and opening."""
    both = data.drives_both_ways
    figure = new_figure(11.0 if both else 6.4, 4.4)
    axes, *others = figure.subplots(1, 3 if both else 1, squeeze=False)[0]
    label, x, load = abscissa(data)
    if not both:
        draw_reference(axes, data.reference, data.history)
    axes.plot(x, load, color="C0", label="crack band" if data.model.is_smeared else "discrete crack")
    peak = int(np.nanargmax(load))
    axes.plot(x[peak], load[peak], "o", color="C3", markersize=4, label=f"peak {load[peak]:.5g} N")
    axes.set(xlabel=f"{label} (mm)", ylabel="load along its motion (N)" if both else "load (N)")
    axes.legend(frameon=False)
    for other, motion, stress, name in zip(
        others, ("sliding", "opening"), ("stress_s", "stress_n"), ("shear", "normal"), strict=False
    ):
        other.plot(data.history[motion], data.history[stress], color="C0")
        other.set(xlabel=f"{motion} (mm)", ylabel=f"mean {name} traction on the crack (MPa)")
    for each in (axes, *others):
        each.axhline(0.0, color="0.5", linewidth=0.6)
    figure.suptitle(data.scene.title)
    save(figure, path)


def abscissa(data: RunData) -> tuple[str, Array, Array]:
    """Name and values (mm) of what the load (N) is drawn over, and the load.

    The load is drawn over the opening, or over what the measured curve is drawn over; for a platen that moves both ways over
    its way, along which its load acts. That curve is broken (NaN) at each stage that turns the platen.
    """
    load = data.history["load"]
    if not data.drives_both_ways:
        name = "opening" if data.reference is None else data.reference.against
        return name, data.history[name], load
    stage = data.history["stage"].astype(int)
    begins = np.flatnonzero(np.diff(stage)) + 1
    turned = [row for row in begins if data.scene.stages[stage[row] - 1].direction is not None]
    way = data.way
    return "way of the platen, there and back", np.insert(way, turned, way[turned]), np.insert(load, turned, np.nan)


def draw_reference(axes: Axes, reference: Reference | None, history: Mapping[str, Array] | None = None) -> None:
    """The measured curves or bands that the scene names; with a history how far it lies from them."""
    if reference is None:
        return
    several, mean = len(reference.curves) > 1, reference.mean()
    found = {} if history is None else {each.name: each for each in agreements(reference, history)}
    for i, each in enumerate(reference.curves):
        label = reference.label + (f", {len(reference.curves)} tests" if several else "") if i == 0 else None
        if each.is_band:
            band = axes.fill_between(each.x, each.low, each.high, color="0.85")
            band.set_label(f"{label}, band" if label else "")
            for bound in (each.low, each.high):
                axes.plot(each.x, bound, ".", color="0.6", markersize=4)
        else:
            if not several and each.name in found:
                label = f"{label}, rms {100 * found[each.name].rms:.1f} % of its peak"
            axes.plot(
                each.x, each.y, "o-" if len(each.x) < _FEW else "-", color="0.6", markersize=3, linewidth=0.8, label=label
            )
    if mean is not None:
        curve = mean[0]
        rms = f", rms {100 * found[curve.name].rms:.1f} % of its peak" if curve.name in found else ""
        axes.plot(curve.x, curve.y, "--", color="0.3", linewidth=1.0, label=f"{curve.name}{rms}")


def save_deformed(data: RunData, path: Path) -> None:
    """The body at the last row, coloured by the major principal stress, displacements magnified."""
    frame = data.frame(len(data.states) - 1)
    points, u = data.model.mesh.points, frame.displacement
    size = float(np.ptp(points, axis=0).max())
    factor = _magnification(0.06 * size / max(float(np.linalg.norm(u, axis=1).max()), 1e-300))
    warped = points + factor * u
    stress = np.concatenate([major_stress(s) for s in frame.stress])
    whole = "one half of the body, " if data.scene.model.half else ""
    title = f"{whole}opening {data.history['opening'][-1]:.3g} mm, displacements magnified {factor:g} times"
    if points.shape[1] == 3:
        save(_solid_figure(data, frame, warped, stress, title), path)
    else:
        save(_plane_figure(data, warped, stress, title, 0.02 * size), path)


def _plane_figure(data: RunData, warped: Array, stress: Array, title: str, margin: float) -> Figure:
    """A 2D body with its crack faces, or with the open crack planes of its band."""
    faces = [warped[block.cells[:, : _CORNERS[block.kind]]] for block in (*data.model.bulk, *data.model.band)]
    span = warped.max(axis=0) - warped.min(axis=0)
    ratio = span[1] / span[0]
    width = float(np.clip(7.5 / ratio + 3.0, 5.0, 8.0))  # narrower for a tall body
    figure = new_figure(width, float(np.clip(0.8 * width * ratio + 1.0, 2.6, 8.5)))
    axes = figure.add_subplot()
    body = PolyCollection(
        _corners(faces),  # type: ignore[arg-type]  # an array is drawn much faster than a list
        array=stress, cmap="viridis", edgecolors="face", linewidths=0.3,
    )  # fmt: skip
    _limit(body, stress)
    axes.add_collection(body)
    if data.model.is_smeared:
        _draw_planes(axes, data, faces[len(data.model.bulk) :])
    elif (crack := data.model.mesh.crack) is not None:
        for a, b in ((0, 1), (3, 2)):
            segments = warped[crack.data[:, [a, b]]]
            axes.plot(*segments.transpose(2, 1, 0), color="C3", linewidth=0.8)
    axes.set_xlim(warped[:, 0].min() - margin, warped[:, 0].max() + margin)
    axes.set_ylim(warped[:, 1].min() - margin, warped[:, 1].max() + margin)
    axes.set_aspect("equal")
    axes.set(xlabel="x (mm)", ylabel="y (mm)")
    figure.suptitle(title, fontsize="medium")  # over the whole figure: a tall body is narrow
    figure.colorbar(body, ax=axes, label="major principal stress (MPa)", shrink=0.9, extend="both")
    return figure


def _solid_figure(data: RunData, frame: Frame, warped: Array, stress: Array, title: str) -> Figure:
    """A 3D body beside its crack surface, which it may hide."""
    figure = new_figure(12.0, 5.2)
    figure.set_layout_engine("none")  # 3D axes do not take part in it
    body = draw_body(figure, 0.02, data, warped, stress)
    _limit(body, np.asarray(body.get_array()))
    draw_crack(figure, 0.53, data, frame, warped)
    figure.suptitle(title)
    return figure


def _limit(faces: Collection, stress: Array) -> None:
    """Colours that a few very large stresses do not flatten."""
    low, high = np.percentile(stress, [1, 99])
    faces.set_clim(low, max(high, low + 1e-12))


def _draw_planes(axes: Axes, data: RunData, faces: list[Array]) -> None:
    """The open crack planes of a band, as lines in the deformed cells that they belong to."""
    state, cracks = data.last, data.model.cracks
    planes = state.cracks.planes
    opening = planes.length * planes.strain[:, 0]
    shown = opening > 0.05 * max(opening.max(initial=0.0), 1e-300)
    cell = cracks.cell[planes.point[shown]]
    corners = _corners(faces)[cell]
    centre, size = corners.mean(axis=1), np.ptp(corners, axis=1).min(axis=1)
    along = 0.5 * size[:, None] * planes.rotation[shown, 1]
    axes.add_collection(LineCollection(list(np.stack([centre - along, centre + along], axis=1)), colors="C3", linewidths=0.8))


def _corners(faces: list[Array]) -> Array:
    """Corners of all cells, (n, 4, 2), a triangle's last corner repeated; (n, 3, 2) if all are triangles."""
    most = max(f.shape[1] for f in faces)
    return np.concatenate([np.pad(f, ((0, 0), (0, most - f.shape[1]), (0, 0)), mode="edge") for f in faces])


def _magnification(factor: float) -> float:
    """Rounded down to 1, 2 or 5 times a power of ten."""
    power = 10.0 ** np.floor(np.log10(factor))
    return float(power * max(step for step in (1.0, 2.0, 5.0) if step * power <= factor * (1 + 1e-9)))


def new_figure(width: float, height: float) -> Figure:
    """A figure of a size in inches, drawn without a window."""
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def save(figure: Figure, path: Path) -> None:
    """Write a figure as PNG."""
    figure.savefig(path, dpi=130, format="png")
