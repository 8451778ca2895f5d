"""The readings of what the paper's print leaves open, side by side, on the data of Examples 2 and 3.

Jefferson and Mihai (2015) print c_lm = 7 (B7), a smoothing length of 0.018 without a unit (eq. 17, 18), and no limit to
it while a crack is young. `Concrete` takes c_lm = 3, 0.018 relative to Zm, and `onset_cap`. Each is changed here alone,
the unit also without the cap, and all three together ("as printed": c_lm = 7, 0.018 mm, no cap).

At a point, for a plane as wide as h, the band's element and the specimen's interface:

- Example 2 (material "reinhardt"): peak in mode I; area under the curve to 5 Zm over Gf + ft^2 w / 2E, which is 1 without
  contact; least stress on the way (contact in an opening crack pushes it below zero); closing from 0.048 mm: opening at
  -3 MPa;
- Example 3 (material "jacobsen"): the same area, and the largest shear on the nominal path from un0 = 0.015, 0.025 and
  0.040 mm.

In the specimens, `reinhardt-cyclic` with two cycles and `jacobsen-mixed-mode` with un0 = 0.025 mm: peak stresses, and
where a run stops, why. The interface of the specimens is also given the width h of eq. (21). Most of the two to three
minutes go into runs that stop or snap.

Expected: with the cap the smoothing leaves mode I as it is, whatever the reading. Without it millimetres take more than
half of the energy of Example 3 at w = h (44 % is kept), and a plane as narrow as the interface falls far into compression
after the onset of damage with either unit. Plates with such an interface then stop before their peak, for want of an
equilibrium close by; wider planes come further, some through snaps and with a lower peak. c_lm = 7 takes three quarters
to four fifths of the shear of Example 3 (0.25, 0.18, 0.12 instead of 1.34, 0.88, 0.49 MPa at w = h), millimetres about
two thirds (0.41, 0.30, 0.19).

    python -m examples.as_printed [-o DIR]
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import trapezoid

from cohesive import Concrete, CrackPlane, NotConverged, Result, Scene, run
from cohesive.figures.drawing import new_figure, save
from examples.command import command
from examples.jacobsen import OPENINGS, along, nominal_path, point_peak
from examples.reinhardt import plate

Array = NDArray[np.float64]

#: changes to Concrete; "mm" reads 0.018 as millimetres
READINGS: dict[str, dict[str, Any]] = {
    "defaults": {},
    "c_lm = 7": {"c_lm": 7.0},
    "0.018 mm": {"mm": True},
    "no cap": {"onset_cap": False},
    "0.018 mm, no cap": {"mm": True, "onset_cap": False},
    "as printed": {"c_lm": 7.0, "mm": True, "onset_cap": False},
}
#: "0.018 mm, no cap" differs little from "as printed" and takes as long
IN_SPECIMENS = [name for name in READINGS if name != "0.018 mm, no cap"]
SMOOTHING = 0.018
CLOSED_FROM = 0.048
#: openings at which the cyclic run unloads, mm
TURNS = (0.022, CLOSED_FROM)
UN0 = 0.025


def changes(reading: str, concrete: Concrete) -> dict[str, Any]:
    """The parameters of a reading."""
    found = dict(READINGS[reading])
    if found.pop("mm", False):
        found["r_z"] = SMOOTHING / concrete.Zm
    return found


def opened(law: CrackPlane) -> tuple[Array, Array]:
    """Opening to 5 Zm and its traction, mode I."""
    m = law.concrete
    u = np.unique(np.r_[0.0, np.geomspace(0.01 * law.Zt, 5.0 * m.Zm, 6000), law.Zt])
    return u, along(law, np.stack([u, np.zeros_like(u)], axis=1))[:, 0]


def closed(law: CrackPlane, start: float) -> tuple[Array, Array]:
    """Opening and traction on the way back from `start`."""
    u = np.r_[np.linspace(start, 0.1 * start, 400), np.linspace(0.1 * start, -0.004, 3000)[1:]]
    return u, law.traction(np.stack([u, np.zeros_like(u)], axis=1), np.full(len(u), start))[0][:, 0]


def mode_one(law: CrackPlane) -> dict[str, float]:
    """Peak and least stress (MPa), area under the curve over the fracture energy, opening (mm) that closes to -3 MPa."""
    m = law.concrete
    u, t = opened(law)
    full = m.Gf + m.ft**2 * float(law.width) / (2 * m.E)
    back, stress = closed(law, CLOSED_FROM)
    return {
        "peak": float(t.max()),
        "least": float(t.min()),
        "area": float(trapezoid(t, u)) / full,
        "-3 MPa at": float(np.interp(3.0, -stress, back)),
    }


def attempt(scene: Scene, model: str) -> tuple[Result, str]:
    """A run as far as it comes, and what stopped it, or "" where nothing did."""
    try:
        return run(scene, model), ""
    except NotConverged as error:
        if not isinstance(error.result, Result):
            raise
        return error.result, str(error)


def main(
    size: float = 2.5,
    models: Sequence[tuple[str, str]] = (("discrete", "default width"), ("discrete", "w = h"), ("smeared", "")),
    readings: Sequence[str] = tuple(IN_SPECIMENS),
    plot: Path | None = None,
) -> dict[str, float]:
    """Try all readings at a point and in the specimens; print and return the numbers.

    Parameters
    ----------
    size : element size along the crack, mm; in the band its width.
    models : kind of model and width of the interface; none: at the point only.
    readings : those that are tried in the specimens.
    plot : file for the figure.
    """
    numbers: dict[str, float] = {}
    example2, example3 = Concrete.preset("reinhardt"), Concrete.preset("jacobsen")
    print("at a point                      Example 2: peak   least   area  -3 MPa at      Example 3: area   peak shear for")
    print("                                   w mm     MPa     MPa      %         mm      w mm          %   un0 = "
          + ", ".join(f"{u:g}" for u in OPENINGS) + " mm (MPa)")  # fmt: skip
    for reading in READINGS:
        two, three = (replace(m, **changes(reading, m)) for m in (example2, example3))
        for label, w2, w3 in (("h", two.h, three.h), ("band", size, size), ("interface", 0.125, 0.1)):
            first, second = mode_one(CrackPlane(two, w2)), mode_one(CrackPlane(three, w3))
            shear = [point_peak(three, w3, u) for u in OPENINGS]
            numbers |= {f"{reading}, {label}, Example 2: {key}": value for key, value in first.items()}
            numbers |= {f"{reading}, {label}, Example 3: {key}": second[key] for key in ("peak", "least", "area")}
            numbers |= {f"{reading}, {label}, Example 3: shear {u:g}": t for u, t in zip(OPENINGS, shear, strict=True)}
            print(
                f"{reading if label == 'h' else '':18s}{label:12s}{w2:9.3g}{first['peak']:8.3f}{first['least']:8.2f}"
                f"{100 * first['area']:7.1f}{first['-3 MPa at']:11.5f}{w3:10.3g}{100 * second['area']:11.1f}"
                f"   {', '.join(f'{t:.3f}' for t in shear)}"
            )
    results: dict[tuple[str, str, str], tuple[Result, str]] = {}
    for model, width in models:
        scenes = {
            "Example 2": plate(size, TURNS),
            "Example 3": Scene.load("jacobsen-mixed-mode").with_(
                **{"mesh.crack_size": size, "stage.0.to": [0.003, UN0], "output.frames": 0}
            ),
        }
        for example, scene in scenes.items():
            if width == "w = h":
                scene = scene.with_(**{"interface.width": "h"})
            if model == "smeared":
                scene = scene.with_(**{"band.width": size})
            name = f"{example}, {model}{', ' if width else ''}{width}"
            print(name)
            for reading in readings:
                found = changes(reading, scene.material)
                result, stopped = attempt(scene.with_(**{f"material.{k}": v for k, v in found.items()}), model)
                results[name, reading, model] = result, stopped
                numbers |= specimen_numbers(name, reading, result, stopped)
    if plot is not None:
        _draw(results, plot)
    return numbers


def specimen_numbers(name: str, reading: str, result: Result, stopped: str) -> dict[str, float]:
    """Print and return what a run came to."""
    h = result.history
    if not result.steps:
        print(f"    {reading:18s}no step converged: {stopped}")
        return {f"{name}, {reading}: opening reached": 0.0}
    snaps = [note for note in result.notes if "snaps" in note]
    values = {
        "peak": float(h["stress_n"].max()),
        "least": float(h["stress_n"].min()),
        "shear": float(h["stress_s"].max()),
        "opening reached": float(h["opening"].max()),
        "dissipated": result.dissipated_energy / float(result.full_energy or np.inf),
        "snaps": float(len(snaps)),
        "stopped": float(bool(stopped)),
    }
    print(
        f"    {reading:18s}peak {values['peak']:6.3f}, least {values['least']:6.3f}, shear {values['shear']:6.3f} MPa; "
        f"opening {values['opening reached']:.4f} mm, dissipated {100 * values['dissipated']:5.1f} %"
        + (f"; {len(snaps)} snaps" if snaps else "")
    )
    if stopped:
        print(f"        stopped: {stopped.split('. Where')[0]}")
    return {f"{name}, {reading}: {key}": value for key, value in values.items()}


def _draw(results: Mapping[tuple[str, str, str], tuple[Result, str]], path: Path) -> None:
    figure = new_figure(11.0, 8.0)
    (one, two), (three, four) = figure.subplots(2, 2)
    example2, example3 = Concrete.preset("reinhardt"), Concrete.preset("jacobsen")
    styles = {
        name: (f"C{i}", ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 1)))[i]) for i, name in enumerate(READINGS)
    }
    for reading, (colour, style) in styles.items():
        law = CrackPlane(replace(example2, **changes(reading, example2)), 2.5)
        one.plot(*opened(law), color=colour, linestyle=style, label=reading)
        two.plot(*closed(law, CLOSED_FROM), color=colour, linestyle=style, label=reading)
        law = CrackPlane(replace(example3, **changes(reading, example3)))
        jumps = nominal_path(UN0)
        three.plot(jumps[400:, 1], along(law, jumps)[400:, 1], color=colour, linestyle=style, label=reading)
        for (name, what, _), (result, stopped) in results.items():
            if what == reading and name.startswith("Example 3, discrete, default"):
                opening, stress = (result.history[k] for k in ("opening", "stress_n"))
                label = f"{reading}, stops at {opening[-1]:.4f} mm" if stopped else reading
                four.plot(opening, stress, color=colour, linestyle=style, label=label)
                if stopped:
                    four.plot(opening[-1], stress[-1], "x", color=colour)
    one.set(xlim=(0.0, 0.03), xlabel="opening (mm)", ylabel="stress (MPa)", title="Example 2, point, w = 2.5 mm: mode I")
    two.set(xlim=(-0.002, 0.03), ylim=(-3.0, 1.0), xlabel="opening (mm)", ylabel="stress (MPa)",
            title=f"Example 2, point, w = 2.5 mm: closing from {CLOSED_FROM:g} mm")  # fmt: skip
    three.set(xlim=(0.0, 0.4), xlabel="sliding (mm)", ylabel="shear stress (MPa)",
              title=f"Example 3, point, w = h, nominal path from {UN0:g} mm")  # fmt: skip
    four.set(xlim=(0.0, 0.03), xlabel="opening of the gauge (mm)", ylabel="mean normal stress (MPa)",
             title="Example 3, plate, discrete: mode I stage")  # fmt: skip
    for axes in (one, two, three, four):
        axes.axhline(0.0, color="0.5", linewidth=0.6)
        if axes.get_legend_handles_labels()[0]:
            axes.legend(frameon=False, fontsize=8)
    save(figure, path)


if __name__ == "__main__":
    command(main, __doc__, "as_printed.png")
