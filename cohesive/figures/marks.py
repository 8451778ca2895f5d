"""Marks on the picture of a mesh: supports as triangles, loads as arrows, gauges as lines between their points."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon
from matplotlib.path import Path
from mpl_toolkits.mplot3d import Axes3D

from ..arrays import Array
from ..model.marks import DRIVE, GAUGE, PRESSURE, SUPPORT, Mark
from .solid import on_axes

#: sizes of a triangle and of an arrow, as parts of the body's larger side
_TRIANGLE, _ARROW = 0.028, 0.1

#: a location longer than this part of the body's larger side is a face, along which marks are repeated
_FACE = 0.05
_REPEATED = 5

#: an arrow in the legend
_ARROW_MARK = Path(
    [(-1.0, 0.1), (0.2, 0.1), (0.2, 0.4), (1.0, 0.0), (0.2, -0.4), (0.2, -0.1), (-1.0, -0.1), (-1.0, 0.1)], closed=True
)

_HELD, _MOVED, _PRESSED = "C0", "C2", "C5"
_MEASURED = ("C4", "C8", "C9", "C6", "C1", "0.3")


def draw_marks(axes: Axes, given: Sequence[Mark], points: Array) -> None:
    """Marks of a plane body with nodes at some points, (m, 2), mm, and what they mean in the legend."""
    size = float(np.ptp(points, axis=0).max())
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    labels: set[str] = set()
    for mark in given:
        if mark.kind == SUPPORT and len(mark.points):
            _draw_support(axes, mark, size, middle, labels)
        elif mark.kind == DRIVE:
            _draw_drive(axes, mark, size, points, labels)
        elif mark.kind == PRESSURE:
            axes.plot(*mark.points.T, "s", color=_PRESSED, markersize=3, label=f"pressure on {mark.name}")
    gauges = [mark for mark in given if mark.kind == GAUGE]
    for i, mark in enumerate(gauges):
        _draw_gauge(axes, mark, _MEASURED[i % len(_MEASURED)], size)


def _label(text: str, labels: set[str]) -> str | None:
    """A text that is not in the legend yet."""
    if text in labels:
        return None
    labels.add(text)
    return text


def spread(points: Array, size: float) -> Array:
    """A few of the points of a location, along its longer side: one of a location that is no face."""
    reach = np.ptp(points, axis=0)
    if reach.max() < _FACE * size:
        return points[:1] if len(points) == 1 else points.mean(axis=0)[None]
    order = np.argsort(points[:, int(reach.argmax())])
    some: Array = points[order[np.linspace(0, len(points) - 1, _REPEATED).round().astype(int)]]
    return some


def _draw_support(axes: Axes, mark: Mark, size: float, middle: Array, labels: set[str]) -> None:
    """Triangles with their tips on the body; a line below those that roll along the others' direction."""
    rank = np.linalg.matrix_rank(mark.directions)
    upright = mark.directions[int(abs(mark.directions[:, -1]).argmax())]  # if there is one
    outward = np.sign(upright @ (mark.points.mean(axis=0) - middle) or -1.0) * upright
    across = np.array([-outward[1], outward[0]])
    side = _TRIANGLE * size
    meaning = _label("held" if rank == 2 else "held along the triangle, free across", labels)
    for tip in spread(mark.points, size):
        base = tip + side * outward
        shape = [tip, base + 0.55 * side * across, base - 0.55 * side * across]
        axes.add_patch(
            Polygon(shape, closed=True, facecolor=_HELD if rank == 2 else "white", edgecolor=_HELD, zorder=4, label=meaning)
        )
        meaning = None
        if rank < 2:
            ends = base + 0.3 * side * outward + np.outer([-0.8, 0.8], side * across)
            axes.plot(*ends.T, color=_HELD, linewidth=1.2, zorder=4)


def _draw_drive(axes: Axes, mark: Mark, size: float, points: Array, labels: set[str]) -> None:
    """Arrows along which the load acts: with their heads on the body if they point into it, else with their tails."""
    for at, direction in _pushed(mark):
        for place in spread(at, size):
            begins = -1.0 if _goes_in(place, direction, points) else 0.0
            ends = place + np.outer([begins, begins + 1.0], _ARROW * size * direction)
            _arrow(axes, *ends)
    axes.plot([], [], marker=_ARROW_MARK, color=_MOVED, linestyle="", markersize=12, label=f"driven: {mark.name}")


def _pushed(mark: Mark) -> Iterator[tuple[Array, Array]]:
    """The locations that a drive moves, each with the directions that it does so; its counterpart goes against them."""
    for direction in mark.directions:
        for at, towards in ((mark.points, direction), (mark.others, -direction)):
            if len(at):
                yield at, towards


def _goes_in(place: Array, direction: Array, points: Array) -> bool:
    """Whether a direction leads from a place into the box around a body."""
    along = abs(direction) > 1e-9
    ahead = (place + 1e-3 * np.ptp(points) * direction)[along]
    return bool(((points.min(axis=0)[along] < ahead) & (ahead < points.max(axis=0)[along])).all())


def _arrow(axes: Axes, tail: Array, head: Array) -> None:
    style = {"arrowstyle": "-|>", "color": _MOVED, "linewidth": 1.6, "shrinkA": 0.0, "shrinkB": 0.0}
    axes.annotate("", tuple(head), tuple(tail), arrowprops=style, zorder=5)
    axes.plot(*np.array([tail, head]).T, alpha=0.0)  # the limits of the axes take it in


def _draw_gauge(axes: Axes, mark: Mark, colour: str, size: float) -> None:
    """A line from the points to those against which they are measured, with its ends marked."""
    name = f"measured: {mark.name}"
    if not len(mark.points):
        axes.plot([], [], color="C3", linestyle=":", label=f"{name}, {mark.text}")
        return
    plus = mark.points.mean(axis=0)
    if len(mark.others) and np.ptp(mark.others, axis=0).max() > _FACE * size:  # a yoke
        ends = mark.others[np.argsort(mark.others[:, 0])][[0, -1]]
        axes.plot(*ends.T, color=colour, linestyle="--", linewidth=0.8, zorder=6)
    minus = mark.others.mean(axis=0) if len(mark.others) else plus
    both = np.array([plus, minus])
    axes.plot(*both.T, marker="x" if np.allclose(plus, minus) else "o", color=colour, markersize=5, linewidth=1.4,
              markerfacecolor="none", zorder=6, label=name)  # fmt: skip


def draw_solid_marks(axes: Axes3D, given: Sequence[Mark], points: Array) -> None:
    """Marks of a solid body with nodes at some points, (m, 3), mm, and what they mean in the legend."""
    size = float(np.ptp(points, axis=0).max())
    held = [place for mark in given if mark.kind == SUPPORT for place in _few(mark.points)]
    if held:
        axes.plot(*on_axes(np.array(held)).T, "^", color=_HELD, markersize=6, label="held")
    gauges = [mark for mark in given if mark.kind == GAUGE and len(mark.points)]
    for i, mark in enumerate(gauges):
        ends = [mark.points.mean(axis=0), *([mark.others.mean(axis=0)] if len(mark.others) else [])]
        axes.plot(
            *on_axes(np.array(ends)).T, "o-", color=_MEASURED[i % len(_MEASURED)], markerfacecolor="none",
            label=f"measured: {mark.name}",
        )  # fmt: skip
    for mark in given:
        if mark.kind != DRIVE:
            continue
        for at, direction in _pushed(mark):
            middle, length = at.mean(axis=0), 2.0 * _ARROW * size
            start = on_axes(middle - length * direction if _goes_in(middle, direction, points) else middle)
            axes.quiver(*start, *on_axes(direction), length=length, color=_MOVED, linewidth=2.0)
        axes.plot([], [], [], marker=_ARROW_MARK, color=_MOVED, linestyle="", markersize=12, label=f"driven: {mark.name}")


def _few(points: Array) -> Array:
    """The corners of a location and its middle: the points nearest to those of the box around it."""
    if len(points) < 5:
        return points
    low, high = points.min(axis=0), points.max(axis=0)
    wanted = np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(len(low), -1).T
    nearest = [int(np.linalg.norm(points - place, axis=1).argmin()) for place in wanted]
    return points[np.unique(nearest)]
