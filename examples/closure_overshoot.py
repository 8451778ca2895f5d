"""How far does the first iterate overshoot when an open crack is pressed shut? (Jefferson and Mihai 2015, section 2.)

A crack has been opened to 0.1 mm and is unloaded along the secant to the origin, where the uncracked stiffness returns at
once. A compressive stress of 0.5 MPa is applied in one step. With the tangent of the open crack the first iterate is

    u = uA - uA (0.5 + tA) / tA = -0.05 / tA,    tA = ft exp[-ft (uA - Zt) / Gf],    Zt = he ft / E

The paper gives -0.855 mm, a strain of -0.171 and a stress of -5130 MPa, without ft and Gf in its text: ft = 3 MPa, Gf =
0.0758 N/mm, E = 30 GPa and elements of he = 5 mm give all three, and are assumed here.

The same load step is then put to the smoothed law (`CrackPlane`, width 5 mm) at a point that nothing else holds: find u
with t(u) = -0.5 MPa from the state unloaded at 0.1 mm, by Newton's method, without and with the package's line search
(the residual must fall; quadratic interpolation, at most to a tenth at a time).

Expected: the smoothed law is not in contact at 0.1 mm, so its first iterate is the abrupt one, -0.855 mm, whatever c_zn;
the line search is what prevents it. Without it the smoothed law alternates between closed and open before it converges
(13 to 25 iterations to 1e-10), because the reduction function H has a corner at u = 0; with it 4 to 11. The abrupt law,
which is linear on both sides of its kink, needs two iterations at a single point without a line search (10 with it): what
goes wrong with it in a structure, where many points close at different times, does not show at one.

    python -m examples.closure_overshoot [-o DIR]
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cohesive import Concrete, CrackPlane
from cohesive.figures.drawing import new_figure, save
from examples.command import command

Array = NDArray[np.float64]
#: traction and its slope at an opening; `first`: the slope of unloading, where there are two
PointLaw = Callable[[float, bool], tuple[float, float]]

MATERIAL = Concrete(E=30e3, nu=0.2, ft=3.0, Gf=0.0758)
OPENED, APPLIED, ELEMENT = 0.1, -0.5, 5.0
CLOSING = (5.0, 9.0, 50.0)
TOLERANCE, MOST = 1e-10, 60


@dataclass(frozen=True)
class Iteration:
    """Iterates of one load step: openings (mm), stresses (MPa) and the part of each Newton step that was taken."""

    opening: Array
    stress: Array
    length: Array

    @property
    def count(self) -> int:
        """Number of iterations."""
        return len(self.opening) - 1


def newton(law: PointLaw, start: float, target: float, line_search: bool) -> Iteration:
    """Opening at which a point carries `target`, iterate by iterate."""
    opening, (stress, slope) = start, law(start, True)
    rows = [(opening, stress, 1.0)]
    while abs(stress - target) > TOLERANCE * abs(target) and len(rows) <= MOST:
        residual, size = stress - target, 1.0
        step = -residual / slope
        while True:
            trial = law(opening + size * step, False)
            value = trial[0] - target
            if not line_search or abs(value) < (1.0 - 1e-4 * size) * abs(residual) or size < 1e-3:
                break
            curvature = (value**2 - residual**2 * (1.0 - 2.0 * size)) / size**2
            size *= float(np.clip(residual**2 / curvature / size, 0.1, 0.5))
        opening, (stress, slope) = opening + size * step, trial
        rows.append((opening, stress, size))
    return Iteration(*np.array(rows).T)


def abrupt(concrete: Concrete = MATERIAL, width: float = ELEMENT, opened: float = OPENED) -> PointLaw:
    """Secant unloading to the origin, the uncracked stiffness below it."""
    Zt = width * concrete.ft / concrete.E
    secant = concrete.ft * np.exp(-concrete.ft * (opened - Zt) / concrete.Gf) / opened

    def law(u: float, first: bool) -> tuple[float, float]:
        slope = float(secant if u > 0 else concrete.E / width)
        return slope * u, slope

    return law


def smoothed(c_zn: float, concrete: Concrete = MATERIAL, width: float = ELEMENT, opened: float = OPENED) -> PointLaw:
    """The crack-plane law after opening to `opened`."""
    plane = CrackPlane(replace(concrete, c_zn=c_zn), width)

    def law(u: float, first: bool) -> tuple[float, float]:
        traction, tangent, _ = plane.update(np.array([[u, 0.0]]), np.array([opened]), frozen=first)
        return float(traction[0, 0]), float(tangent[0, 0, 0])

    return law


def main(closing: Sequence[float] = CLOSING, plot: Path | None = None) -> dict[str, float]:
    """Take the load step with each law; print and return the numbers.

    Parameters
    ----------
    closing : values of c_zn for the smoothed law.
    plot : file for the figure.
    """
    laws = {"abrupt": abrupt()} | {f"c_zn = {c:g}": smoothed(c) for c in closing}
    peak = abrupt()(OPENED, True)[0]
    first = newton(laws["abrupt"], OPENED, APPLIED, False).opening[1]
    numbers = {
        "stress at 0.1 mm": peak,
        "first iterate": float(first),
        "strain": float(first) / ELEMENT,
        "stress": MATERIAL.E * float(first) / ELEMENT,
    }
    print(f"abrupt, from the formula: {peak:.4f} MPa at {OPENED:g} mm; first iterate {numbers['first iterate']:.4f} mm, "
          f"strain {numbers['strain']:.4f}, stress {numbers['stress']:.0f} MPa")  # fmt: skip
    runs = {(name, search): newton(law, OPENED, APPLIED, search) for name, law in laws.items() for search in (False, True)}
    for (name, search), run in runs.items():
        key = f"{name}, {'with' if search else 'without'} line search"
        numbers |= {
            f"{key}: iterations": float(run.count),
            f"{key}: lowest opening": float(run.opening.min()),
            f"{key}: lowest stress": float(run.stress.min()),
            f"{key}: solution": float(run.opening[-1]),
        }
        crossings = int((np.diff(np.sign(run.opening)) != 0).sum())
        numbers[f"{key}: crossings"] = float(crossings)
        print(f"{key}: {run.count} iterations, {crossings} times through u = 0, solution {run.opening[-1]:.6f} mm")
        print("    u (mm):  " + " ".join(f"{u:9.2e}" for u in run.opening[:9]) + (" ..." if run.count > 8 else ""))
        print("    t (MPa): " + " ".join(f"{t:9.3g}" for t in run.stress[:9]) + (" ..." if run.count > 8 else ""))
    if plot is not None:
        _draw(laws, runs, plot)
    return numbers


def _draw(laws: dict[str, PointLaw], runs: dict[tuple[str, bool], Iteration], path: Path) -> None:
    figure = new_figure(13.0, 4.3)
    axes = figure.subplots(1, 3)
    for i, (name, law) in enumerate(laws.items()):
        u = np.linspace(-0.0005, 0.03, 1200)
        axes[0].plot(u, [law(x, False)[0] for x in u], color=f"C{i}", label=name)
        for panel, search in ((axes[1], False), (axes[2], True)):
            run = runs[name, search]
            panel.plot(run.opening, "o-", color=f"C{i}", markersize=3, linewidth=1.0, label=f"{name}, {run.count} iterations")
    axes[0].axhline(APPLIED, color="0.5", linestyle=":", linewidth=0.8, label="applied")
    axes[0].set(ylim=(-3.0, 0.5), xlabel="opening (mm)", ylabel="stress (MPa)", title="closing after 0.1 mm")
    for panel, title in ((axes[1], "Newton without line search"), (axes[2], "with line search")):
        panel.set_yscale("symlog", linthresh=1e-4)
        panel.set(ylim=(-2.0, 2.0), xlabel="iteration", ylabel="opening (mm), logarithmic beyond 0.0001", title=title)
        panel.axhline(0.0, color="0.5", linewidth=0.6)
        panel.legend(frameon=False, fontsize=8)
        panel.xaxis.get_major_locator().set_params(integer=True)
    axes[0].legend(frameon=False, fontsize=8)
    save(figure, path)


if __name__ == "__main__":
    command(main, __doc__, "closure_overshoot.png")
