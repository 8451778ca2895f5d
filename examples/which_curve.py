"""Which softening curve? A measured band judges each one at its best strength and energy.

The built-in beam of Grégoire et al. (2013) was measured as a band of load over opening, 13 points. Each curve takes
the pair of ft and Gf with the most points inside (steps of 0.1 MPa and 0.005 N/mm). The peak sees the first branch, the stress
over the first few hundredths of a millimetre: a steep beginning gives an early peak. The tail sees the area that is left. The
exponential curve ties one to the other, so that a pair which meets the tail comes too late to its peak.

Expected: all 13 points inside with "hordijk" and "wittmann", 12 with "petersson" and "fib-2010", 11 with the exponential
curve; the peaks come at 0.024 to 0.029 mm, the measured ones at 0.018 to 0.023.

    python -m examples.which_curve [-o DIR]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from cohesive import Concrete, Result, Scene, run
from cohesive.figures.drawing import draw_reference, new_figure, save
from cohesive.studies.law_responses import softening_curves
from examples.command import command

#: ft (MPa) and Gf (N/mm) with the most points inside the band
BEST: dict[str, tuple[float, float]] = {
    "exponential": (3.4, 0.07),
    "hordijk": (3.9, 0.07),
    "wittmann": (3.8, 0.065),
    "petersson": (3.4, 0.07),
    "fib-2010": (3.4, 0.07),
}


def main(size: float = 1.0, plot: Path | None = None) -> dict[str, dict[str, float]]:
    """Run the beam with each curve; print and return what meets the band.

    Parameters
    ----------
    size : length of the elements on the crack, mm.
    plot : file for the figure.
    """
    results = {name: _beam(name, ft, Gf, size) for name, (ft, Gf) in BEST.items()}
    found = {}
    print(f"{'curve':14s}{'ft':>6s}{'Gf':>8s}{'inside':>8s}{'peak (N)':>10s}{'at (mm)':>9s}{'load at 0.18 mm (N)':>21s}")
    for name, result in results.items():
        h, (ft, Gf) = result.history, BEST[name]
        inside = result.agreement[0].inside
        tail = float(np.interp(0.18, h["opening"], h["load"]))
        found[name] = {"inside": inside, "peak": result.peak_load, "at": result.opening_at_peak, "tail": tail}
        print(f"{name:14s}{ft:6.1f}{Gf:8.3f}{inside:8d}{result.peak_load:10.0f}{result.opening_at_peak:9.3f}{tail:21.0f}")
    if plot is not None:
        _draw(results, plot)
    return found


def _beam(softening: str, ft: float, Gf: float, size: float) -> Result:
    material = {"material.softening": softening, "material.ft": ft, "material.Gf": Gf}
    return run(Scene.load("notched-beam").with_(**material, **{"mesh.crack_size": size, "output.frames": 0}))


def _draw(results: dict[str, Result], plot: Path) -> None:
    """Loads over the band, and the curves that made them."""
    figure = new_figure(11.0, 4.4)
    left, right = figure.subplots(1, 2)
    first = next(iter(results.values()))
    draw_reference(left, first, first.controlled)
    for i, (name, result) in enumerate(results.items()):
        (ft, Gf), style = BEST[name], {"color": f"C{i}", "linestyle": "-" if i % 2 == 0 else "--"}
        left.plot(
            result.history["opening"],
            result.history["load"],
            label=f"{name}, {ft:g} MPa, {Gf:g} N/mm",
            **style,
        )
        ((_, curve),) = softening_curves(Concrete(37e3, 0.2, ft, Gf), [name]).items()
        right.plot(curve[:, 0], curve[:, 1], label=name, **style)
    left.set(xlabel="opening (mm)", ylabel="load (N)", title="half-notched beam, depth 50 mm")
    right.set(xlabel="opening beyond the onset (mm)", ylabel="stress (MPa)", title="softening")
    for axes in (left, right):
        axes.axhline(0.0, color="0.5", linewidth=0.6)
        axes.legend(frameon=False, fontsize=8)
    save(figure, plot)


if __name__ == "__main__":
    command(main, __doc__, "which_curve.png")
