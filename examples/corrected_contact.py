"""Contact from a potential: what does the corrected form keep of the printed one, and what does it gain?

The printed contact omega H_w g k n of eq. (21) has no potential, so that closed loops of opening and shear create or destroy
energy, and near closure it is stiffer than the concrete. `material.contact = "potential"` puts asperities that have an
energy in series with the elastic plane (derived in `cohesive.asperities`).

Expected: softening is the same to the last digit. Closing needs about the same stress at the same opening, one micrometre
apart at -3 MPa, but the corrected stiffness never exceeds E/w, whatever the width. Shear stresses of open faces are the
printed ones; their normal stress is lower at first and higher after long sliding. A closed loop of opening and shear leaves no
energy behind, where the printed form leaves a part of Gf at a point and seven Gf on Example 3's plate. Examples 2 and 3 keep
their peaks and their unloading.

    python -m examples.corrected_contact [-o DIR]
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cohesive import Concrete, CrackPlane, Scene, run
from cohesive.figures.drawing import new_figure, save
from examples.command import command

Array = NDArray[np.float64]
FORMS = ("printed", "potential")
LABELS = {"printed": "printed", "potential": "corrected"}
OPENED = 0.1  # mm
WIDTHS = (0.2, 2.0, 60.0)


def plane(form: str, width: float) -> CrackPlane:
    """The plane of Example 2."""
    return CrackPlane(Concrete.preset("reinhardt", contact=form), width)


def closing(form: str, width: float) -> tuple[Array, Array, Array]:
    """A plane opened to 0.1 mm and closed: the opening less what is elastic (mm), stress (MPa), and stiffness over E/w."""
    law = plane(form, width)
    elastic = 30.0 / law.stiffness(2)[0]
    total = np.concatenate([np.linspace(OPENED, 0.02, 400), np.geomspace(0.02, 1e-5, 1200), -np.geomspace(1e-7, elastic, 400)])
    traction, tangent, _ = law.update(np.column_stack([total, 0 * total]), np.full(total.size, OPENED), frozen=True)
    stiff = law.stiffness(2)[0]
    return total - traction[:, 0] / stiff, traction[:, 0], tangent[:, 0, 0] / stiff


def loop(form: str, width: float) -> float:
    """Work of a closed loop at constant damage over Gf: opening .05 to .15, sliding 0 to .2, back to .05, back to 0."""
    law = plane(form, width)
    corners = np.array([(0.05, 0.0), (0.15, 0.0), (0.15, 0.2), (0.05, 0.2), (0.05, 0.0)])
    x, weight = np.polynomial.legendre.leggauss(400)
    work, Z = 0.0, np.full(len(x), 0.3)
    for a, b in pairwise(corners):
        jump = 0.5 * (a + b) + 0.5 * x[:, None] * (b - a)
        # of contact: the undamaged part has a potential
        work += 0.5 * float(weight @ (law.contact_traction(jump, Z) @ (b - a)))
    return work / law.concrete.Gf


def sheared(form: str, opening: float) -> tuple[Array, Array]:
    """Sliding (mm) and tractions (MPa) of a plane that is held open."""
    law = plane(form, 0.2)
    sliding = np.linspace(0.0, 0.5, 251)
    jump = np.column_stack([np.full(sliding.size, opening), sliding])
    return sliding, law.traction(jump, np.maximum.accumulate(law.history(jump, np.zeros(sliding.size))))[0]


def main(size: float = 2.5, plot: Path | None = None) -> dict[str, float]:
    """Print and return the numbers.

    Parameters
    ----------
    size : element size along the crack of Examples 2 and 3, mm.
    plot : file for the figure.
    """
    numbers: dict[str, float] = {}
    print("closing from 0.1 mm: inelastic opening (µm) at -1, -3, -10 MPa; largest stiffness over E/w")
    for form in FORMS:
        for width in WIDTHS:
            left, stress, stiffness = closing(form, width)
            at = [_at(left, stress, -s) for s in (1.0, 3.0, 10.0)]
            numbers[f"{form}, w = {width:g}: µm at -3 MPa"] = at[1]
            numbers[f"{form}, w = {width:g}: stiffness"] = float(stiffness.max())
            print(f"    {LABELS[form]:9s}w = {width:<6g}" + "".join(f"{a:8.3f}" for a in at) + f"{stiffness.max():10.2f}")
    print("work of a closed loop of opening and shear over Gf, at a point")
    for form in FORMS:
        found = [loop(form, width) for width in WIDTHS]
        numbers[f"{form}: loop"] = found[0]
        print(f"    {LABELS[form]:9s}" + "".join(f"{value:+10.5f}" for value in found))
    print("Examples 2 and 3, discrete: peak (N), largest shear, least normal stress (MPa), dissipated, contact work (N mm)")
    for name in ("reinhardt-cyclic", "jacobsen-mixed-mode"):
        for form in FORMS:
            changes = {"material.contact": form, "mesh.crack_size": size, "output.frames": 0}
            h = (result := run(Scene.load(name).with_(**changes))).history
            values = (result.peak_load, h["stress_s"].max(), h["stress_n"].min(), h["dissipated"][-1], h["contact_work"][-1])
            for what, value in zip(("peak", "shear", "normal", "dissipated", "contact work"), values, strict=True):
                numbers[f"{name}, {form}: {what}"] = float(value)
            print(f"    {name:22s}{LABELS[form]:9s}" + "".join(f"{value:12.4g}" for value in values))
    if plot is not None:
        _draw(plot)
    return numbers


def _at(left: Array, stress: Array, wanted: float) -> float:
    """Inelastic opening (µm) where the stress is first reached."""
    i = int(np.argmax(stress < wanted))
    part = (stress[i - 1] - wanted) / (stress[i - 1] - stress[i])
    return 1e3 * float(left[i - 1] + part * (left[i] - left[i - 1]))


def _draw(path: Path) -> None:
    figure = new_figure(13.0, 4.2)
    first, second, third = figure.subplots(1, 3)
    for form, style in zip(FORMS, ("-", "--"), strict=True):
        for i, width in enumerate(WIDTHS):
            left, stress, stiffness = closing(form, width)
            label = f"{LABELS[form]}, w = {width:g} mm"
            first.plot(1e3 * left, stress, style, color=f"C{i}", label=label)
            second.semilogx(np.maximum(-stress, 1e-3), stiffness, style, color=f"C{i}", label=label)
        for i, opening in enumerate((0.05, 0.1, 0.2)):
            sliding, t = sheared(form, opening)
            third.plot(sliding, t[:, 1], style, color=f"C{i}", label=f"{LABELS[form]}, {opening:g} mm")
            third.plot(sliding, t[:, 0], style, color=f"C{i}", linewidth=0.8)
    first.set(xlim=(0, 15), ylim=(-12, 1), xlabel="opening without its elastic part (µm)", ylabel="normal stress (MPa)",
              title="closed from 0.1 mm")  # fmt: skip
    second.set(xlim=(1e-2, 30), xlabel="compression (MPa)", ylabel="stiffness over E/w", title="never stiffer than the plane",
               ylim=(0, 6))  # fmt: skip
    second.axhline(1.0, color="0.5", linewidth=0.8)
    third.set(xlabel="sliding (mm)", ylabel="shear (> 0) and normal stress (MPa)", title="held open and sheared, w = 0.2 mm",
              ylim=(-12, 10))  # fmt: skip
    for axes in (first, second, third):
        axes.legend(frameon=False, fontsize=7)
    save(figure, path)


if __name__ == "__main__":
    command(main, __doc__, "corrected_contact.png")
