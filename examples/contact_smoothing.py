"""Does smoother contact converge faster? (Jefferson and Mihai 2015, section 6.3: Figure 26 and Table 4.)

The parameter c_zn sets how fast contact grows over the smoothing length: 5 soft, 9 standard, 50 abrupt. The paper re-runs
Example 4 with the three values and lists the unbalanced forces of increments 10 to 15, in which shear contact builds up:
46 iterations in all for c_zn = 50, 23 for 9 and 23 for 5, with a quadratic tail. This module shows

- closing curves at a point (Figure 26: an element of 50 mm, material of Example 4), opened to 0.05 mm and closed;
- iterations and residuals of the built-in scene `push-off` with the package's solver, tolerance 1e-4 as in the paper, in
  both models, in the six successive increments that need most iterations;
- the same loading at one point: opened to 0.2 mm, then sheared in increments while a spring resists the opening (1e5 N/mm
  on 300 x 120 mm, 2.8 MPa per mm), with and without a line search, for w = h, the band's and the interface's width;
- how often the line search shortens a step there.

The paper prints neither the size of its increments nor of its elements. Increments of 0.04, 0.1 and 0.2 mm of sliding are
tried.

Expected: the three values need the same number of iterations within one or two, at the point and in the block, with and
without a line search; the tail is quadratic, r(n+1) at most 1.1 r(n)^2. The paper's order, twice as many for c_zn = 50,
does not show here: with the crack opened to 0.2 mm (Z = Zm) the transition is passed in a few increments with the
consistent tangent, and no step needs to be shortened.

    python -m examples.contact_smoothing [-o DIR]
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from cohesive import Concrete, CrackPlane, Scene, run
from cohesive.figures.drawing import new_figure, save
from cohesive.law.widths import default_width
from cohesive.studies.law_responses import closing
from examples.command import command

Array = NDArray[np.float64]

CLOSING = (50.0, 9.0, 5.0)
ELEMENT = 50.0
OPENED, SHEARED = 0.2, 2.0
SPRING = 1.0e5 / (300.0 * 120.0)
TOLERANCE = 1e-4
WINDOW = 6


@dataclass(frozen=True)
class Iterations:
    """Residuals of the increments that shear, relative to the force on the crack, one list for each increment.

    Attributes
    ----------
    shortened : number of Newton steps that the line search shortened; None where that is not known
    """

    residuals: list[list[float]]
    shortened: int | None = None

    @property
    def counts(self) -> list[int]:
        """Iterations of each increment."""
        return [len(r) - 1 for r in self.residuals]

    @property
    def window(self) -> int:
        """First of the six successive increments with most iterations."""
        sums = np.convolve(self.counts, np.ones(WINDOW, dtype=int), "valid")
        return int(sums.argmax())

    @property
    def in_window(self) -> list[int]:
        """Iterations of these six."""
        return self.counts[self.window : self.window + WINDOW]

    def quadratic(self) -> float:
        """Largest r(n+1) / r(n)^2 where r(n) lies between 1e-6 and 1e-1, after the step to the new target."""
        pairs = [(a, b) for r in self.residuals for a, b in pairwise(r[1:]) if 1e-6 < a < 1e-1]
        return max(b / a**2 for a, b in pairs)


#: the paper's Table 4: unbalanced forces after each iteration of increments 10 to 15, %
_TABLE_4 = {
    50.0: (
        (47.0, 23.5, 10.4, 4.47, 2.92e-3),
        (113.0, 94.7, 137.0, 194.0, 185.0, 131.0, 28.9, 16.0, 0.314, 8.35e-4),
        (113.0, 41.1, 42.3, 48.8, 138.0, 124.0, 128.0, 109.0, 122.0, 73.0, 143.0, 3.27, 143.0, 2.38, 1.26e-2, 3.03e-5),
        (21.0, 3.22, 0.825, 0.489, 1.63e-3),
        (8.17, 1.26, 0.268, 7.55e-2, 1.07e-5),
        (3.57, 0.331, 8.94e-2, 2.46e-2, 4.19e-6),
    ),
    9.0: (
        (9.46, 0.159, 4.79e-3),
        (96.6, 8.61, 0.507, 3.03e-2, 1.42e-4),
        (27.2, 0.674, 3.30e-2, 1.64e-3),
        (67.9, 2.42, 9.84e-2, 4.23e-3),
        (14.0, 0.317, 1.03e-2, 4.16e-4),
        (3.24, 0.103, 3.82e-3),
    ),
    5.0: (
        (9.46, 0.158, 4.78e-3),
        (95.8, 8.61, 0.509, 3.04e-2, 1.58e-4),
        (24.5, 0.949, 4.24e-2, 1.94e-3),
        (41.6, 0.646, 2.02e-2, 7.27e-4),
        (19.2, 0.347, 1.57e-2, 7.01e-4),
        (2.69, 8.71e-2, 2.99e-3),
    ),
}
PAPER = {c: Iterations([[np.nan, *(r / 100 for r in row)] for row in rows]) for c, rows in _TABLE_4.items()}


def block(c_zn: float, model: str, size: float, steps: int, name: str = "push-off") -> Iterations:
    """A push-off scene with the package's solver."""
    scene = Scene.load(name).with_(
        **{"mesh.crack_size": size, "output.frames": 0, "material.c_zn": c_zn, "stage.1.steps": steps, "stage.1.to": SHEARED}
    )
    found: list[tuple[str, list[float]]] = []
    run(scene, model, on_step=lambda step, row: found.append((step.control, step.equilibrium.residuals)))
    return Iterations([residuals for control, residuals in found if control == "driven"])


def point(c_zn: float, width: float, steps: int, line_search: bool) -> Iterations:
    """The same at a point: its opening is the unknown, a spring resists it from 0.2 mm on, the sliding is given."""
    plane = CrackPlane(replace(Concrete.preset("walraven"), c_zn=c_zn), width)
    Z = plane.history(np.array([[OPENED, 0.0]]), np.zeros(1))
    jump, start = np.array([OPENED, 0.0]), Z
    lists, shortened = [], 0

    def at(jump: Array) -> tuple[float, float, float, float, Array]:
        """Residual and its scale, slopes in opening and sliding, history."""
        t, K, new = plane.update(jump[None], start)
        force = SPRING * (jump[0] - OPENED)
        return float(t[0, 0] + force), max(abs(float(t[0, 0])), abs(force)), float(K[0, 0, 0]) + SPRING, float(K[0, 0, 1]), new

    for target in np.linspace(0.0, SHEARED, steps + 1)[1:]:
        residual, scale, slope, across, Z = at(jump)
        residuals, correction = [abs(residual) / scale], np.inf
        for iteration in range(60):
            slide = target - jump[1]
            step = np.array([-(residual + across * slide) / slope, slide])
            size = 1.0
            while True:
                new = at(jump + size * step)
                # the first step moves to the target, whatever the residual says
                if not line_search or not iteration or abs(new[0]) < (1 - 1e-4 * size) * abs(residual) or size < 1e-3:
                    break
                curvature = (new[0] ** 2 - residual**2 * (1 - 2 * size)) / size**2
                size *= float(np.clip(residual**2 / curvature / size, 0.1, 0.5))
            shortened += size < 1.0
            jump = jump + size * step
            residual, scale, slope, across, Z = new
            residuals.append(abs(residual) / scale)
            correction = abs(size * step[0]) / abs(jump[0])
            if residuals[-1] <= TOLERANCE and correction <= TOLERANCE:
                break
        else:
            raise RuntimeError(f"no convergence at a sliding of {target:g} mm")
        start = Z
        lists.append(residuals)
    return Iterations(lists, shortened)


def closing_curves(values: Sequence[float]) -> dict[float, Array]:
    """Opening (mm) and stress (MPa) of an element of 50 mm, opened to 0.05 mm and closed, for each c_zn."""
    plane = CrackPlane(Concrete.preset("walraven"), ELEMENT)
    return {c: closing(plane, c) for c in values}


def main(size: float = 15.0, steps: Sequence[int] = (50, 20, 10), plot: Path | None = None) -> dict[str, float]:
    """Count the iterations; print and return the numbers.

    Parameters
    ----------
    size : element size along the crack, mm.
    steps : numbers of increments for the sliding of 2 mm.
    plot : file for the figure.
    """
    numbers: dict[str, float] = {}
    curves = closing_curves(CLOSING)
    print("closing from 0.05 mm (Figure 26): opening without stress, opening at -1 MPa (mm)")
    for c, curve in curves.items():
        back = curve[int(curve[:, 0].argmax()) :]
        at = [float(np.interp(-t, -back[:, 1], back[:, 0])) for t in (0.0, -1.0)]
        print(f"    c_zn = {c:<4g}{at[0]:9.5f}{at[1]:9.5f}")
        numbers |= {f"c_zn = {c:g}: no stress at": at[0], f"c_zn = {c:g}: -1 MPa at": at[1]}

    scene = Scene.load("push-off")
    by_rule = scene.band_width, default_width(scene.crack_length, scene.zone_length)
    cases: dict[str, dict[tuple[int, float], Iterations]] = {}
    for model in ("discrete", "smeared"):
        cases[f"block, {model}"] = {(n, c): block(c, model, size, n) for n in steps for c in CLOSING}
    for width in (60.0, *by_rule):
        for search in (False, True):
            name = f"point, w = {width:g} mm, {'with' if search else 'no'} line search"
            cases[name] = {(n, c): point(c, width, n, search) for n in steps for c in CLOSING}
    print("iterations in the six increments that need most, for c_zn = 50 / 9 / 5; the paper: "
          + " / ".join(str(sum(PAPER[c].counts)) for c in CLOSING))  # fmt: skip
    for name, found in cases.items():
        for n in steps:
            totals = [sum(found[n, c].in_window) for c in CLOSING]
            whole = [sum(found[n, c].counts) for c in CLOSING]
            tail = max(found[n, c].quadratic() for c in CLOSING)
            shortened = [found[n, c].shortened for c in CLOSING]
            numbers |= {f"{name}, {n}, c_zn = {c:g}": float(total) for c, total in zip(CLOSING, totals, strict=True)}
            numbers[f"{name}, {n}: r(n+1) / r(n)^2"] = tail
            print(
                f"    {name:38s}{SHEARED / n:5.2f} mm: {' / '.join(map(str, totals)):14s} "
                f"all: {' / '.join(map(str, whole)):16s}r(n+1)/r(n)^2 up to {tail:5.2f}"
                + ("" if shortened[0] is None else f", shortened: {' / '.join(map(str, shortened))}")
            )
            if shortened[0] is not None:
                numbers[f"{name}, {n}: shortened"] = float(sum(s or 0 for s in shortened))
    n = steps[len(steps) // 2]
    print(f"residuals of the block, discrete, increments of {SHEARED / n:g} mm: at the start, then after each iteration")
    for c in CLOSING:
        one = cases["block, discrete"][n, c]
        for i in range(one.window, one.window + WINDOW):
            print(f"    c_zn = {c:<4g}increment {i + 1:2d}:  " + "  ".join(f"{r:.1e}" for r in one.residuals[i]))
    if plot is not None:
        _draw(curves, cases, n, plot)
    return numbers


def draw_counts(axes: Axes, groups: Mapping[str, Mapping[float, Iterations]]) -> None:
    """Iterations in the six increments, a bar for each group and c_zn."""
    for i, c in enumerate(CLOSING):
        totals = [sum(found[c].in_window) for found in groups.values()]
        axes.barh(np.arange(len(groups)) + 0.27 * (i - 1), totals, 0.25, color=f"C{i}", label=f"$c_{{zn}}$ = {c:g}")
    axes.set_yticks(range(len(groups)), [name.replace(" line search", "\nline search") for name in groups], fontsize=8)
    axes.invert_yaxis()
    axes.set(xlabel="iterations in six increments")


def draw_residuals(axes: Axes, found: Mapping[float, Iterations]) -> None:
    """Residuals of the six increments against the one before, and hollow those of the paper."""
    for name, cases in (("", found), (", paper", PAPER)):
        for i, c in enumerate(CLOSING):
            one = cases[c]
            lists = one.residuals[one.window : one.window + WINDOW]
            pairs = np.array([(a, b) for residuals in lists for a, b in pairwise(residuals[1:]) if b > 1e-13])
            face = "none" if name else f"C{i}"
            axes.loglog(*pairs.T, "os^"[i], color=f"C{i}", mfc=face, markersize=4, label=f"$c_{{zn}}$ = {c:g}{name}")
    r = np.array([1e-6, 1.0])
    axes.loglog(r, r**2, "k:", linewidth=0.8, label="$r_{n+1} = r_n^2$")
    axes.set(xlabel="relative residual $r_n$", ylabel="$r_{n+1}$")


def _draw(curves: dict[float, Array], cases: dict[str, dict[tuple[int, float], Iterations]], n: int, path: Path) -> None:
    figure = new_figure(13.0, 4.3)
    left, middle, right = figure.subplots(1, 3)
    for i, (c, curve) in enumerate(curves.items()):
        left.plot(curve[:, 0], curve[:, 1], color=f"C{i}", label=f"$c_{{zn}}$ = {c:g}")
    left.set(
        ylim=(-3.0, 3.0),
        xlim=(-0.01, 0.05),
        xlabel="opening (mm)",
        ylabel="stress (MPa)",
        title="opened and closed (Figure 26)",
    )
    left.axhline(0.0, color="0.5", linewidth=0.6)
    shown = [name for name in cases if name.startswith("block") or "w = 60" in name or "w = 1.6" in name]
    groups = {"paper": PAPER} | {name: {c: cases[name][n, c] for c in CLOSING} for name in shown}
    draw_counts(middle, groups)
    middle.set(title=f"increments of {SHEARED / n:g} mm (paper: unknown)")
    draw_residuals(right, groups["block, discrete"])
    right.set(title="block, discrete: the six increments")
    for axes in (left, middle, right):
        axes.legend(frameon=False, fontsize=8)
    save(figure, path)


if __name__ == "__main__":
    command(main, __doc__, "contact_smoothing.png")
