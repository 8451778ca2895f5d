"""Sheared to and fro under constant compression: the printed law slides reversibly, a law with Coulomb friction does not."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.integrate import trapezoid

from cohesive import Concrete, CrackPlane, Law
from cohesive.figures.drawing import new_figure, save
from examples.command import command
from examples.coulomb import Coulomb

#: compression, MPa, and amplitude of the sliding, mm
PRESSURE, AMPLITUDE = 1.5, 0.3


def loop(law: Law, points: int = 300) -> tuple[np.ndarray, np.ndarray]:
    """Sliding (mm) and shear traction (MPa) of a plane that was broken by opening 1 mm: out, back, and out again."""
    turns = [0.0, AMPLITUDE, -AMPLITUDE, AMPLITUDE]
    sliding = np.concatenate([np.linspace(a, b, points) for a, b in pairwise(turns)])
    history = law.update(np.array([[1.0, 0.0]]), law.initial(1))[2]
    low, high = np.full(len(sliding), -0.1), np.full(len(sliding), 0.9)
    for _ in range(60):  # the opening at which the plane bears the pressure, which no sliding before changes
        middle = 0.5 * (low + high)
        traction = law.update(np.stack([middle, sliding], axis=1), np.repeat(history, len(sliding), axis=0))[0]
        low, high = np.where(traction[:, 0] < -PRESSURE, middle, low), np.where(traction[:, 0] < -PRESSURE, high, middle)
    shear = np.zeros_like(sliding)
    for i, jump in enumerate(np.stack([high, sliding], axis=1)):
        traction, _, history = law.update(jump[None], history)
        shear[i] = traction[0, 1]
    return sliding, shear


def main(plot: Path | None = None, points: int = 300) -> dict[str, float]:
    """Work of the last loop, N/mm, of both laws: 4 mu |s| (D - mu |s|/k) with friction, and none as printed."""
    concrete = Concrete(E=30e3, nu=0.2, ft=3.0, Gf=0.1)
    laws: dict[str, Law] = {
        "printed contact": CrackPlane(concrete, 0.2),
        "Coulomb friction": Coulomb().built_for(concrete, 1.0),
    }
    work, curves = {}, {}
    for name, law in laws.items():
        sliding, shear = curves[name] = loop(law, points)
        work[name] = float(trapezoid(shear[points:], sliding[points:]))
    for name, value in work.items():
        print(f"{name}: {value:.3f} N/mm in a loop of sliding")
    if plot is not None:
        figure = new_figure(9.0, 3.8)
        for axes, (name, (sliding, shear)) in zip(figure.subplots(1, 2), curves.items(), strict=True):
            axes.plot(sliding, shear, color="C0")
            axes.set(title=f"{name}: {work[name]:.2f} N/mm lost in a loop", xlabel="sliding (mm)", ylabel="shear (MPa)")
            axes.axhline(0.0, color="0.5", linewidth=0.6)
        save(figure, plot)
    return work


if __name__ == "__main__":
    command(main, __doc__, "rubbing.png")
