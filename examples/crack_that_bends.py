"""A crack that bends: what does its path decide?

The built-in beam with its notch 18 mm off mid-span. A discrete crack follows the path that it is given: straight up, or a
polyline that leaves the notch upright and leans towards the load, x = 18 [1 - 0.8 ((y - 25)/25)^1.5].

The two parts of the beam turn about a hinge, the end of the crack under the load. A point of one face moves against the
other at right angles to its ray from the hinge, so that the crack slides by tan(b) times its opening, where b is the angle
between path and ray. A straight path is its own ray and does not slide, wherever it leads; a bent one does, most at the
notch, by one amount on each straight piece of it.

Of several paths the real crack will not take one that needs a higher load: the higher peak is that of the wrong path.

Expected: peak of the bent path 4 % below that of the straight one; sliding over opening at the last step within 0.05 of
tan(b) on both paths where the crack is wider than half its largest opening.

    python -m examples.crack_that_bends [-o DIR]
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.patches import Rectangle
from numpy.typing import NDArray
from scipy.integrate import trapezoid

from cohesive import Result, Scene, run
from cohesive.figures.drawing import new_figure, save
from examples.command import command

Array = NDArray[np.float64]
NOTCH = 18.0  # mm from mid-span
LEAN = 0.8


@dataclass(frozen=True)
class Crack:
    """One path: peak (N), opening there (mm), area under load over opening (N mm), contact work (N mm); at the last step
    position along the path (mm), opening, sliding (mm) and tan(b) of the crack's points; error of the energy balance."""

    peak: float
    opening_at_peak: float
    energy: float
    contact_work: float
    position: Array
    opening: Array
    sliding: Array
    kinematic: Array
    balance: float


def path(lean: float) -> list[list[float]]:
    """Notch tip to upper face in six points."""
    t = np.linspace(0.0, 1.0, 6)
    return [[float(x), float(y)] for x, y in zip(NOTCH * (1.0 - lean * t**1.5), 25.0 + 25.0 * t, strict=True)]


def measured(result: Result, line: Array) -> Crack:
    """The crack of a run along the polyline `line`."""
    h = result.history
    sliding = result.crack(-1)["sliding"]
    point, opening = result.opening_profile(-1)
    # the line rises all the way, and the height of a cell's middle tells its segment
    cell = result.fields.cell
    middle = (np.bincount(cell, point[:, 1]) / np.bincount(cell))[cell]
    segment = np.searchsorted(line[:, 1], middle) - 1
    along = np.diff(line, axis=0)
    position = np.r_[0.0, np.cumsum(np.hypot(*along.T))][segment] + np.hypot(*(point - line[segment]).T)
    ray, tangent = line[-1] - point, along[segment]
    across = tangent[:, 1] * ray[:, 0] - tangent[:, 0] * ray[:, 1]
    kinematic = across / np.maximum((tangent * ray).sum(axis=1), 1e-9)
    load, gauge = (h[name] for name in ("load", "opening"))
    order = np.lexsort((position, middle))  # up the crack, cell by cell
    return Crack(
        result.peak_load, result.opening_at_peak, float(trapezoid(load, gauge)), float(h["contact_work"][-1]),
        position[order], opening[order], sliding[order], kinematic[order], result.energy_error,
    )  # fmt: skip


def main(size: float = 1.0, plot: Path | None = None) -> dict[str, Crack]:
    """Run the beam with both paths; print and return what they show.

    Parameters
    ----------
    size : length of the elements on the crack, mm.
    plot : file for the figure.
    """
    beam = Scene.load("notched-beam").with_(
        **{"specimen.notch_position": NOTCH, "mesh.crack_size": size, "output.frames": 0},
        stage=[{"control": "opening", "to": 0.3, "steps": 100}],
    )
    lines = {"straight": path(0.0), "bent": path(LEAN)}
    results = {name: run(beam.with_(**{"specimen.crack": line})) for name, line in lines.items()}
    cracks = {name: measured(result, np.array(lines[name])) for name, result in results.items()}
    for name, c in cracks.items():
        ratio = c.sliding / np.maximum(c.opening, 1e-9)
        print(
            f"{name:9s}peak {c.peak:.1f} N at {c.opening_at_peak:.4f} mm, area under the curve {c.energy:.2f} N mm, sliding "
            f"up to {abs(c.sliding).max():.4f} mm; at the notch sliding/opening {ratio[0]:+.3f}, tan b {c.kinematic[0]:+.3f}"
        )
    print(f"bent against straight, peak: {100 * (cracks['bent'].peak / cracks['straight'].peak - 1):+.2f} %")
    if plot is not None:
        _draw(results, cracks, plot)
    return cracks


def _draw(results: dict[str, Result], cracks: dict[str, Crack], path_: Path) -> None:
    figure = new_figure(12.0, 4.2)
    sketch, loads, slides = figure.subplots(1, 3, width_ratios=[1.25, 1.0, 1.0])
    sketch.add_patch(Rectangle((-87.5, 0.0), 175.0, 50.0, facecolor="0.92", edgecolor="0.5"))
    sketch.plot([NOTCH, NOTCH], [0.0, 25.0], "k-", linewidth=3.0, label="notch")
    for (name, result), colour in zip(results.items(), ("C0", "C1"), strict=True):
        line = np.array(result.scene.specimen.paths[0])
        sketch.plot(*line.T, colour, label=f"{name} path")
        h, c = result.history, cracks[name]
        loads.plot(h["opening"], h["load"], colour, label=f"{name}, peak {c.peak:.0f} N")
        slides.plot(c.position, c.sliding, colour, label=f"{name}, computed")
        near = c.opening > 0.1 * c.opening.max()
        slides.plot(
            c.position[near], (c.kinematic * c.opening)[near], "k:", label="opening x tan b" if name == "bent" else None
        )
    hinge = np.array(path(LEAN)[-1])
    sketch.plot([NOTCH, hinge[0]], [25.0, hinge[1]], "k:", label="ray of the notch tip")
    sketch.plot(*hinge, "ko", label="hinge of the bent path")
    sketch.annotate("b", (16.8, 28.2), (7.0, 25.0), ha="center", arrowprops={"arrowstyle": "-", "linewidth": 0.6})
    sketch.annotate("load", (0.0, 50.0), (0.0, 58.0), ha="center", arrowprops={"arrowstyle": "->"})
    sketch.set(xlim=(-12.0, 60.0), ylim=(-3.0, 62.0), xlabel="x (mm)", ylabel="y (mm)")
    sketch.set_aspect("equal")
    sketch.legend(frameon=False, loc="center right", fontsize=8)
    loads.set(xlabel="opening of the gauge (mm)", ylabel="load (N)", xlim=(0.0, None), ylim=(0.0, None))
    loads.legend(frameon=False)
    slides.set(xlabel="position along the crack (mm)", ylabel="sliding at the last step (mm)")
    slides.legend(frameon=False)
    save(figure, path_)


if __name__ == "__main__":
    command(main, __doc__, "crack_that_bends.png")
