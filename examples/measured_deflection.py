"""Against what was the deflection measured? One measured curve, two readings, and the moduli that follow.

Olsen's beam of normal strength concrete (800 x 100 x 100 mm, notch 10 mm) was published as load over the deflection of the
load point, 32 points. The motion of that point includes the dents under the load and over the supports; a yoke that rests at
mid-depth over the supports leaves them out. One run has both columns, `driven` and `deflection`: the measured curve is laid
over each. ft = 2.6 MPa and Gf = 0.11 N/mm with Hordijk's curve meet peak and tail; E is what is asked, of the slope between
the second and third measured point, and of the whole curve by the smallest rms.

Expected: read as a yoke's, the slope asks for 24.6 GPa on any mesh. Read as the load point's it asks for 25.3 GPa, and for
more with a finer mesh (25.1, 25.3, 25.4 GPa with elements of 6, 2 and 1 mm), as the dent under a force on one node has no
limit. The whole curve asks for 29.0 and 29.5 GPa; after the peak the halves press on each other at the top of the crack, which
bulges upwards, so that the load point lags behind the beam by up to 0.005 mm. The beam is slender, so that the readings differ
less than slope and curve do: the first measured point lies on a slope of 27 kN/mm, the next two on one of 16 kN/mm.

    python -m examples.measured_deflection [-o DIR]
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cohesive import Result, Scene, run
from cohesive.arrays import Array
from cohesive.figures.drawing import draw_reference, new_figure, save
from cohesive.results.agreement import Agreement, agreements
from examples.command import command

DATA = Path(__file__).parent / "data"
#: columns of the history that the measured deflection may be, and what they are
READINGS = {"driven": "of the load point", "deflection": "against a yoke"}
MODULI = (20e3, 24e3, 28e3, 32e3)  # MPa
PUBLISHED = 26110.0


@dataclass(frozen=True)
class Reading:
    """One reading of the measured curve: rms over its peak at each modulus, the modulus with the smallest and the one that the
    measured slope asks for (MPa), the run with the former and its agreement."""

    rms: list[float]
    E: float
    E_of_slope: float
    result: Result
    agreement: Agreement


def beam(E: float, size: float) -> Scene:
    """Olsen's beam with its measured curve."""
    return Scene(
        {
            "title": "Olsen's beam of normal strength concrete",
            "specimen": {"kind": "notched-beam", "length": 840.0, "span": 800.0, "depth": 100.0, "thickness": 100.0,
                         "notch": 10.0, "gauge": 10.0},
            "mesh": {"crack_size": size, "far_size": 8 * size, "order": 2},
            "material": {"E": E, "nu": 0.2, "ft": 2.6, "Gf": 0.11, "softening": "hordijk"},
            "stage": [{"control": "opening", "to": 0.01, "steps": 10}, {"control": "opening", "to": 0.55, "steps": 60}],
            "reference": {"file": "olsen-normal-strength-beam.csv", "label": "Olsen"},
            "output": {"frames": 0},
        },
        DATA,
    )  # fmt: skip


def judged(result: Result, against: str) -> Agreement:
    """How far a run lies from the measured curve in one reading."""
    assert result.reference is not None
    return agreements(replace(result.reference, against=against), result.history, result.peak_load)[0]


def slope(x: Array, load: Array, between: Array) -> float:
    """Slope of a rising curve between two loads, N/mm."""
    rising = slice(0, int(load.argmax()) + 1)
    return float(np.diff(between)[0] / np.diff(np.interp(between, load[rising], x[rising]))[0])


def modulus_of_slope(results: list[Result], against: str) -> float:
    """The modulus at which the slope between the second and third measured point is the measured one, MPa."""
    assert results[0].reference is not None
    (measured,) = results[0].reference.curves
    between = measured.y[1:3]
    curves = [[np.r_[0.0, result.history[name]] for name in (against, "load")] for result in results]
    slopes = [slope(x, load, between) for x, load in curves]
    return float(np.interp(slope(measured.x, measured.y, between), slopes, MODULI))


def main(size: float = 2.0, plot: Path | None = None) -> dict[str, Reading]:
    """Run the beam with all moduli; print and return what meets the measured curve in both readings.

    Parameters
    ----------
    size : length of the elements on the crack, mm.
    plot : file for the figure.
    """
    results = [run(beam(E, size)) for E in MODULI]
    print(f"{'E (GPa)':>8s}" + "".join(f"{'rms, ' + what:>24s}" for what in READINGS.values()))
    for E, result in zip(MODULI, results, strict=True):
        print(f"{E / 1e3:8.1f}" + "".join(f"{100 * judged(result, against).rms:22.2f} %" for against in READINGS))
    found = {}
    for against, what in READINGS.items():
        rms = [judged(result, against).rms for result in results]
        a, b, _ = np.polyfit(np.array(MODULI) / PUBLISHED, rms, 2)
        E = float(-b / (2 * a)) * PUBLISHED
        best = run(beam(E, size))
        found[against] = Reading(rms, E, modulus_of_slope(results, against), best, judged(best, against))
        print(
            f"deflection {what}: the slope asks for E = {found[against].E_of_slope / 1e3:.2f} GPa, the whole curve for "
            f"{E / 1e3:.2f} GPa with an rms of {100 * found[against].agreement.rms:.1f} % of the peak"
        )
    if plot is not None:
        _draw(found, plot)
    return found


def _draw(found: dict[str, Reading], plot: Path) -> None:
    """The best run of each reading over the measured curve, and the rms over the modulus."""
    figure = new_figure(11.0, 4.4)
    curves, moduli = figure.subplots(1, 2, width_ratios=[1.4, 1.0])
    against, first = next(iter(found.items()))
    draw_reference(curves, first.result, against)
    for i, (against, each) in enumerate(found.items()):
        h, style = each.result.history, f"C{i}{'-' if i == 0 else '--'}"
        label = f"{READINGS[against]}, E = {each.E / 1e3:.1f} GPa, rms {100 * each.agreement.rms:.1f} %"
        curves.plot(np.r_[0.0, h[against]], np.r_[0.0, h["load"]], style, label=label)
        moduli.axvline(each.E_of_slope / 1e3, color=f"C{i}", linestyle="-" if i == 0 else "--", linewidth=0.8)
        moduli.plot(np.array(MODULI) / 1e3, 100 * np.array(each.rms), f"{style}o", markersize=4, label=READINGS[against])
    moduli.axvline(PUBLISHED / 1e3, color="0.6", linestyle=":", label="published, 26.11 GPa")
    curves.set(xlabel="deflection (mm)", ylabel="load (N)", title="Olsen's beam, two readings of its deflection")
    moduli.set(
        xlabel="E (GPa)",
        ylabel="rms of the load (% of the measured peak)",
        ylim=(0.0, None),
        title="which E? (thin lines: that of the slope)",
    )
    curves.axhline(0.0, color="0.5", linewidth=0.6)
    for axes in (curves, moduli):
        axes.legend(frameon=False, fontsize=8)
    save(figure, plot)


if __name__ == "__main__":
    command(main, __doc__, "measured_deflection.png")
