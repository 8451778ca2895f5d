"""Do intervals of 95 % hold the truth 95 times of 100? Fits of synthetic noisy data with fixed seeds; minutes.

A beam with E 30 GPa, ft 3 MPa, Gf 0.1 N/mm and Hordijk's curve; 24 points with 2 % of the peak as noise; E, ft and Gf are
fitted from a start that is off.

Expected: each interval holds the truth in 90 to 98 of 100 fits.

    python -m examples.coverage [-o DIR]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from cohesive import Scene, fit
from cohesive.fitting.repeated_run import RepeatedRun
from examples.command import command
from examples.identification import VARY, beam

TRUTH = {"material.E": 30e3, "material.ft": 3.0, "material.Gf": 0.1}
START = {"material.E": 26e3, "material.ft": 3.6, "material.Gf": 0.13}


def main(plot: Path | None = None, count: int = 200, noise: float = 0.02) -> dict[str, float]:
    """Print and return the part of the fits whose interval holds the truth, by key."""
    mesh = {"mesh.crack_size": 3.5, "mesh.far_size": 14.0, "interface.width": 0.2, "material.softening": "hordijk"}
    steps = {"stage.0.control": "driven", "stage.0.to": 0.35, "stage.0.steps": 24}
    scene: Scene = beam(50.0, 200.0, 50.0, 15.0, **mesh, **steps)
    history = RepeatedRun(scene.with_(**TRUTH)).run({}).history
    x, y = history["driven"], history["load"]
    held = dict.fromkeys(TRUTH, 0)
    for seed in range(count):
        load = y + noise * y.max() * np.random.default_rng(seed).normal(size=len(y))
        found = fit(scene.with_(**START), VARY, reference=(x, load), check=False)
        for key, value in TRUTH.items():
            low, high = found.intervals[key]
            held[key] += low <= value <= high
    parts = {key: number / count for key, number in held.items()}
    for key, part in parts.items():
        print(f"{key}: {100 * part:.1f} % of {count} intervals hold {TRUTH[key]:g}")
    if plot is not None:
        from matplotlib.figure import Figure

        figure = Figure(figsize=(5.0, 3.0), layout="constrained")
        axes = figure.add_subplot()
        axes.bar([key.removeprefix("material.") for key in parts], [100 * part for part in parts.values()])
        axes.axhline(95.0, color="0.3", linewidth=0.8)
        axes.set_ylabel("intervals that hold the truth (%)")
        axes.set_ylim(80.0, 100.0)
        figure.savefig(plot, dpi=150)
    return parts


if __name__ == "__main__":
    command(main, __doc__, "coverage.png")
