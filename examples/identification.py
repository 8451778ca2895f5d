"""From a measured curve to the material: Olsen's beam with four softening curves, and what a second depth makes visible.

Load over deflection of Olsen's beam of normal strength concrete (800 x 100 x 100 mm, notch 10 mm; 32 points) is fitted with
the exponential curve, Hordijk's, two branches that meet at a free kink, and four free points; E, ft and Gf are free in all.
Then two beams of one concrete, 50 and 200 mm deep, whose curves are computed and given 2 % of noise: first the small one
alone, then both together.

Expected: rms 3.2, 2.1, 1.7 and 1.4 % of the peak. By AIC the last three are alike, as the residuals are worth few independent
ones. E comes out at 26 to 29 GPa (26.1 was published). The second depth narrows the interval of E by a third and that of ft by
a tenth; it does little for the curve.

    python -m examples.identification [-o DIR]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from cohesive import Scene, fit
from cohesive.arrays import Array
from cohesive.fitting.curve_choice import CurveChoice, fit_curves
from cohesive.fitting.repeated_run import RepeatedRun
from cohesive.fitting.result import Fit
from examples.command import command

DATA = Path(__file__).parent / "data" / "olsen-normal-strength-beam.csv"
CURVES = ("exponential", "hordijk", "kink", "points:4")
VARY = {"material.E": (10e3, 60e3), "material.ft": (1.0, 8.0), "material.Gf": (0.03, 0.4)}
KINK = {"material.softening.kink.0": (0.1, 1.7), "material.softening.kink.1": (0.03, 0.7)}


def beam(depth: float, span: float, thickness: float, notch: float, **changes: object) -> Scene:
    """A notched beam, driven at mid-span."""
    data = {
        "title": f"beam, depth {depth:g} mm",
        "specimen": {
            "kind": "notched-beam", "length": 1.05 * span, "span": span, "depth": depth, "thickness": thickness,
            "notch": notch,
        },
        "material": {"E": 26110.0, "nu": 0.2, "ft": 3.0, "Gf": 0.1},
        "stage": [{"control": "driven", "to": 0.012 * depth, "steps": 40}],
    }  # fmt: skip
    return Scene(data).with_(**changes)


def four_curves(curves: tuple[str, ...] = CURVES, **options: object) -> CurveChoice:
    """Olsen's beam with each curve."""
    return fit_curves(beam(100.0, 800.0, 100.0, 10.0), VARY, curves, reference=str(DATA), **options)


def measured(scene: Scene, seed: int, noise: float = 0.02) -> tuple[Array, Array]:
    """The curve of a scene with noise, a part of its peak."""
    history = RepeatedRun(scene).run({}).history
    load = history["load"]
    return history["driven"], load + noise * load.max() * np.random.default_rng(seed).normal(size=len(load))


def depths(*sizes: float) -> Fit:
    """Beams of one concrete and several depths, fitted together."""
    truth = {"material.ft": 3.2, "material.Gf": 0.12, "material.softening": {"kink": [0.9, 0.25]}}
    scenes = [beam(size, 3.0 * size, 50.0, 0.3 * size, **truth) for size in sizes]
    curves = [measured(scene, seed) for seed, scene in enumerate(scenes)]
    start = {"material.ft": 2.5, "material.Gf": 0.09}
    return fit([scene.with_(**start) for scene in scenes], VARY | KINK, reference=curves, check=False)


def main(plot: Path | None = None, curves: tuple[str, ...] = CURVES, sizes: tuple[float, ...] = (50.0, 200.0)) -> CurveChoice:
    """Print both comparisons, and draw the best fit of Olsen's beam."""
    choice = four_curves(curves)
    print(choice.summary())
    alone, together = depths(*sizes[:1]), depths(*sizes)
    print(f"{'':28}{'depth ' + format(sizes[0], 'g'):>26}{'both depths':>26}")
    for key in alone.values:
        cells = [f"{each.intervals[key][0]:.4g} to {each.intervals[key][1]:.4g}" for each in (alone, together)]
        print(f"{key:28}{cells[0]:>26}{cells[1]:>26}")
    for name, each in (("alone", alone), ("together", together)):
        print(f"{name}: {'; '.join(each.identifiable)}")
    if plot is not None:
        choice.fits[choice.best].plot().savefig(plot, dpi=150)
    return choice


if __name__ == "__main__":
    command(main, __doc__, "identification.png")
