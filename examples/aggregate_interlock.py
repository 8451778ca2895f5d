"""Aggregate interlock: how much shear does an open crack carry, and is energy kept on the way round?

Two questions at a point, with the material of Jefferson and Mihai's Example 4 (2015; preset "walraven"), width 0.2 mm.

1. The plane is opened to 0.1, 0.2 or 0.4 mm and slid at that opening. Beside it stands Walraven's linear fit to his push-off
   tests, here for a cube strength fcc = 35 MPa, with w the opening and d the sliding in mm, not below zero:

       tau   = -fcc/30 + [1.80 w^-0.80 + (0.234 w^-0.707 - 0.20) fcc] d
       sigma = -fcc/20 + [1.35 w^-0.63 + (0.191 w^-0.552 - 0.15) fcc] d    (compression)

   The law reaches a quarter to under a half of that shear between 0.5 and 1.5 mm of sliding, an eighth to under a quarter
   at 0.2 mm: it begins later, the faces first slide until they touch.

2. A closed loop at constant damage: open from 0.05 to 0.15 mm, slide by 0.2 mm, close, slide back. A law with a potential
   would return the work. Contact has none, since H of eq. (13) and G/E in k multiply the gradient of the distance: one sense
   of rotation takes work in, the other gives the same work out. The amount is part of Gf or many times Gf, by material.

Expected: shear over fit between 0.25 and 0.47 at slidings of 0.5 to 1.5 mm; work of the two senses equal and opposite.

    python -m examples.aggregate_interlock [-o DIR]
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cohesive import Concrete, CrackPlane
from cohesive.figures.drawing import new_figure, save
from cohesive.law.concrete import PRESETS
from cohesive.studies.law_responses import follow
from examples.command import command
from examples.walraven import walraven

Array = NDArray[np.float64]
FCC = 35.0  # MPa, cube strength assumed for the fit
OPENINGS = (0.1, 0.2, 0.4)  # mm
SLIDINGS = (0.2, 0.5, 1.0, 1.5)  # mm, at which the shears are compared
LOOP = np.array([[0.05, 0.0], [0.15, 0.0], [0.15, 0.2], [0.05, 0.2], [0.05, 0.0]])  # mm


@dataclass(frozen=True)
class Interlock:
    """Curves by opening: sliding (mm), compression and shear (MPa) of the law and of the fit; the law's shear over that of
    the fit at `SLIDINGS`; contact work of the loop by preset, in N/mm and over Gf, and in the opposite sense, N/mm."""

    curves: dict[float, tuple[Array, Array, Array]]
    factor: dict[float, list[float]]
    loop: dict[str, tuple[float, float, float]]


def slide(law: CrackPlane, opening: float, points: int) -> tuple[Array, Array, Array]:
    """Open, then slide at that opening: sliding, law and fit, each [compression, shear]."""
    u, s = np.linspace(0.0, opening, points), np.linspace(0.0, max(SLIDINGS), points)
    path = np.concatenate([np.stack([u, 0 * u], axis=1), np.stack([np.full_like(s, opening), s], axis=1)])
    traction = follow(law, path)[0][points:]
    shear, pressure = walraven(opening, s, FCC)
    return s, traction * [-1.0, 1.0], np.stack([pressure, np.maximum(shear, 0.0)], axis=1)


def loop_work(law: CrackPlane, points: int, reverse: bool = False) -> Array:
    """Work of the contact traction along the loop (N/mm), summed up, at a damage that the loop does not change."""
    corners = LOOP[::-1] if reverse else LOOP
    legs = [np.linspace(a, b, points) for a, b in pairwise(corners)]
    path = np.concatenate(legs)
    t = law.contact_traction(path, np.full(len(path), 0.2))  # Zeq is at most 0.186 mm on the loop
    return np.asarray(np.r_[0.0, np.cumsum((0.5 * (t[1:] + t[:-1]) * np.diff(path, axis=0)).sum(axis=1))])


def main(size: int = 400, plot: Path | None = None) -> Interlock:
    """Slide and go round; print the factors and the works, and return them with the curves.

    Parameters
    ----------
    size : points on each leg of a path.
    plot : file for the figure.
    """
    law = CrackPlane(Concrete.preset("walraven"), 0.2)
    curves = {w: slide(law, w, size) for w in OPENINGS}
    factor = {}
    print("shear of the law over that of the fit at a sliding of " + ", ".join(f"{d:g}" for d in SLIDINGS) + " mm")
    for w, (s, ours, fit) in curves.items():
        shears = [(float(np.interp(d, s, ours[:, 1])), float(np.interp(d, s, fit[:, 1]))) for d in SLIDINGS]
        factor[w] = [a / b for a, b in shears]
        print(f"  opening {w:g} mm: " + ", ".join(f"{a / b:.3f} ({a:.2f} of {b:.2f} MPa)" for a, b in shears))
    loop = {}
    print("contact work of one loop, opening 0.05 to 0.15 mm, sliding 0 to 0.2 mm, at constant damage; < 0: energy is created")
    for name in PRESETS:
        plane = CrackPlane(Concrete.preset(name), 0.2)
        there, back = (float(loop_work(plane, size, reverse)[-1]) for reverse in (False, True))
        loop[name] = there, there / plane.concrete.Gf, back
        print(f"  {name:15s}{there:+9.4f} N/mm, {there / plane.concrete.Gf:+7.2f} Gf; the other way round {back:+9.4f} N/mm")
    result = Interlock(curves, factor, loop)
    if plot is not None:
        _draw(law, result, size, plot)
    return result


def _draw(law: CrackPlane, result: Interlock, points: int, path: Path) -> None:
    figure = new_figure(12.0, 4.2)
    left, middle, right = figure.subplots(1, 3)
    for axes, column, name in ((left, 1, "shear"), (middle, 0, "compression")):
        for i, (w, (s, ours, fit)) in enumerate(result.curves.items()):
            axes.plot(s, ours[:, column], f"C{i}-", label=f"law, opening {w:g} mm")
            axes.plot(s, fit[:, column], f"C{i}--", label=f"Walraven's fit, {w:g} mm")
        axes.set(xlabel="sliding (mm)", ylabel=f"{name} (MPa)", ylim=(0.0, 30.0), title=f"{name} at constant opening")
        axes.set_xlim(0.0, 1.5)
    middle.legend(frameon=False, fontsize=8, loc="upper left")
    way = np.linspace(0.0, 4.0, 4 * points + 1)[1:]
    for reverse, style, label in ((False, "C0-", "open, slide, close, slide back"), (True, "C3--", "the other way round")):
        work = loop_work(law, points, reverse)
        right.plot(way, work / law.concrete.Gf, style, label=f"{label}: {work[-1] / law.concrete.Gf:+.2f} Gf")
    right.axhline(0.0, color="0.5", linewidth=0.6)
    right.set(xlabel="corner of the loop", ylabel="contact work / Gf", ylim=(-0.5, 2.1))
    right.set(title="a closed loop at constant damage")
    right.legend(frameon=False, fontsize=8, loc="upper left")
    save(figure, path)


if __name__ == "__main__":
    command(main, __doc__, "aggregate_interlock.png")
