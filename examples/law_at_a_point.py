"""The law at a point: what a crack plane does before there is a mesh.

Jefferson and Mihai (2015), eqs (1) to (21), their Example 2 material (preset "reinhardt"), at two widths w of the band that
the plane stands for: w = h = 60 mm, as eq. (21) is printed, and the 0.2 mm of a stiff interface. Three paths:

opening    the traction rises along E/w to ft and falls as ft exp[-ft (u - Zt)/Gf], Zt = w ft/E. Area: Gf + ft^2 w/2E.
sliding    without opening and with contact subtracted, it peaks at r_sigma ft, and the area is r_sigma^2 (E/G) times the
           other. With contact a plane that slides without opening is wedged shut: there is no softening to see.
closing    after 0.1 mm: unloading with the damaged stiffness, then contact, whose stiffness grows smoothly. The faces touch
           at u = 0, where the smoothing gives half of E/w; two smoothing lengths further in it is all of it.

Expected: areas within 0.01 % of the formulas with 1000 points, no contact at all while the crack opens.

    python -m examples.law_at_a_point [-o DIR]
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import trapezoid

from cohesive import Concrete, CrackPlane
from cohesive.figures.drawing import new_figure, save
from cohesive.studies.law_responses import follow
from examples.command import command

Array = NDArray[np.float64]
WIDTHS = (60.0, 0.2)


@dataclass(frozen=True)
class Point:
    """The three paths at one width: jumps (mm), tractions (MPa), areas under the first two (N/mm) and their formulas.

    `contact` is the largest contact traction while the crack opens, MPa; `held_open` the opening at which the traction
    passes zero on the way back, mm; `stiffness` the slope where the faces touch and two smoothing lengths beyond, over E/w.
    """

    opening: tuple[Array, Array]
    sliding: tuple[Array, Array]
    closing: tuple[Array, Array]
    area_opening: float
    area_sliding: float
    formula_opening: float
    formula_sliding: float
    contact: float
    held_open: float
    stiffness: tuple[float, float]


def follow_paths(law: CrackPlane, points: int) -> Point:
    """Open, slide and close the plane, each from the intact state."""
    m = law.concrete
    elastic = np.linspace(0.0, law.Zt, 20)
    u = np.r_[elastic, law.Zt + 4.0 * m.Zm * np.linspace(0.0, 1.0, points)[1:] ** 2]  # dense near the peak
    opening = np.stack([u, np.zeros_like(u)], axis=1)
    sliding = np.stack([np.zeros_like(u), u * m.r_sigma * m.E / m.G], axis=1)  # Zeq = u here too
    t_opening, Z_opening = follow(law, opening)
    t_sliding, Z_sliding = follow(law, sliding)
    contact = law.contact_traction(opening, Z_opening)[:, 0]
    free = (t_sliding - law.contact_traction(sliding, Z_sliding))[:, 1]
    back = np.r_[np.linspace(0.0, 0.1, points), np.linspace(0.1, -0.002, points)]
    t_back, Z = follow(law, np.stack([back, np.zeros_like(back)], axis=1))
    way = slice(points, None)  # of closing
    smoothing = float(law.contact_reach(Z[-1:])[0]) / m.c_lm
    shut = np.array([[-1e-9, 0.0], [-2.0 * smoothing, 0.0]])
    slope = law.update(shut, Z[-2:])[1][:, 0, 0] * law.width / m.E
    full = m.Gf + m.ft**2 * law.width / (2.0 * m.E)
    return Point(
        opening=(u, t_opening[:, 0]),
        sliding=(sliding[:, 1], free),
        closing=(back, t_back[:, 0]),
        area_opening=float(trapezoid(t_opening[:, 0], u)),
        area_sliding=float(trapezoid(free, sliding[:, 1])),
        formula_opening=full,
        formula_sliding=m.r_sigma**2 * (m.E / m.G) * full,
        contact=float(abs(contact).max()),
        held_open=float(np.interp(0.0, -t_back[way, 0], back[way])),
        stiffness=(float(slope[0]), float(slope[1])),
    )


def main(size: int = 1000, plot: Path | None = None) -> dict[float, Point]:
    """Follow the paths at both widths; print the areas and return the points by width.

    Parameters
    ----------
    size : points on each path.
    plot : file for the figure.
    """
    material = Concrete.preset("reinhardt")
    result = {w: follow_paths(CrackPlane(material, w), size) for w in WIDTHS}
    for w, point in result.items():
        print(f"w = {w:g} mm")
        for name in ("opening", "sliding"):
            area, formula = getattr(point, f"area_{name}"), getattr(point, f"formula_{name}")
            peak = getattr(point, name)[1].max()
            print(f"  {name}: peak {peak:.4f} MPa, area {area:.6f} N/mm, formula {formula:.6f}, {area / formula - 1:+.1e}")
        print(f"  largest contact traction while it opens: {point.contact:.1e} MPa")
        touching, pressed = point.stiffness
        print(
            f"  closing from 0.1 mm: no traction at {point.held_open:.4f} mm; stiffness {touching:.3f} E/w where the faces "
            f"touch, {pressed:.3f} E/w when pressed"
        )
    if plot is not None:
        _draw(material, result, plot)
    return result


def _draw(m: Concrete, result: dict[float, Point], path: Path) -> None:
    figure = new_figure(12.0, 4.0)
    left, middle, right = figure.subplots(1, 3)
    for (w, point), style in zip(result.items(), ("C0-", "C1--"), strict=True):
        left.plot(*point.opening, style, label=f"w = {w:g} mm, area {point.area_opening:.4f} N/mm")
        middle.plot(*point.sliding, style, label=f"w = {w:g} mm, area {point.area_sliding:.4f} N/mm")
        right.plot(*point.closing, style, label=f"w = {w:g} mm")
    left.set(xlim=(0.0, m.Zm), xlabel="opening (mm)", ylabel="normal traction (MPa)", title="opened")
    middle.set(xlim=(0.0, 3.0 * m.Zm), xlabel="sliding (mm)", ylabel="shear traction (MPa)", title="slid, contact subtracted")
    right.set(ylim=(-1.5 * m.ft, 1.1 * m.ft), xlabel="opening (mm)", ylabel="normal traction (MPa)", title="closed again")
    right.axhline(0.0, color="0.5", linewidth=0.6)
    for axes in (left, middle, right):
        axes.locator_params(axis="x", nbins=6)
        axes.legend(frameon=False)
    save(figure, path)


if __name__ == "__main__":
    command(main, __doc__, "law_at_a_point.png")
