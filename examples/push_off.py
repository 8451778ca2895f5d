"""A cracked plane sheared against bars that restrain its opening (Jefferson and Mihai 2015, Example 4, Figure 24).

The built-in scene `push-off`, in the plane, discrete and smeared: a plane of 300 x 120 mm is opened by 0.2 mm, then
sheared by 2 mm while bars resist its opening, with three stiffnesses of the bars. The tests are Walraven and Reinhardt's
with an initial opening of 0.2 mm; the paper prints neither the stiffness of the bars nor numbers of its curves, whose
axes end at 6 and -5 MPa. Assumed: the height of the block, bars of 0.5, 1 and 2 x 1e5 N/mm (1.4, 2.8 and 5.6 MPa per mm
of opening).

Beside each curve stands Walraven's linear fit of his tests at the run's own opening w and sliding d (mm, MPa):

    tau   = -fcc/30 + [1.8 w^-0.80 + (0.234 w^-0.707 - 0.20) fcc] d
    sigma =  fcc/20 - [1.35 w^-0.63 + (0.191 w^-0.552 - 0.15) fcc] d, compression negative, not above 0

with fcc = 23 MPa, the strength of the paper's Table 3, taken as that of a cube. The fit is for order and trend.

Expected: discrete and smeared within 2 %; stiffer bars give more stress; the shear stress is far below the fit: 4 % of it
at a sliding of 0.1 mm, where contact has hardly begun, a fifth to a quarter at 0.2 mm, half of it (0.49 to 0.56) from 1
mm on. The paper's shear softening before the coarse aggregate is in contact does not show: the shear stress never falls.

    python -m examples.push_off [-o DIR]
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cohesive import Result, Scene, run
from cohesive.figures.drawing import new_figure, save
from examples.command import command
from examples.walraven import walraven

Array = NDArray[np.float64]

RESTRAINTS = (0.5e5, 1.0e5, 2.0e5)
#: strength in Walraven's fit, MPa: the paper's Table 3 gives no other
CUBE_STRENGTH = 23.0
#: slidings of the printed table, mm
SHOWN = (0.1, 0.2, 0.5, 1.0, 1.8)


@dataclass(frozen=True)
class Sheared:
    """The stage that shears: mm, MPa, tension positive."""

    sliding: Array
    opening: Array
    shear: Array
    normal: Array

    def ratio(self, sliding: float) -> float:
        """Shear stress over that of Walraven's fit at the same opening and sliding."""
        shear, opening = (float(np.interp(sliding, self.sliding, y)) for y in (self.shear, self.opening))
        return shear / float(walraven(opening, sliding, CUBE_STRENGTH)[0])


def sheared(result: Result) -> Sheared:
    """The second stage of a run."""
    h = result.history
    start = int(np.flatnonzero(np.diff(h["driven"]) < 0)[0]) + 1  # the motion along the plane counts from 0
    return Sheared(*(h[name][start:] for name in ("sliding", "opening", "stress_s", "stress_n")))


def main(
    size: float = 15.0, restraints: Sequence[float] = RESTRAINTS, steps: int = 50, plot: Path | None = None
) -> dict[str, float]:
    """Run the block with all restraints in both models; print and return the numbers.

    Parameters
    ----------
    size : element size along the crack, mm.
    restraints : stiffnesses of the bars, N/mm.
    steps : increments of the shearing.
    plot : file for the figure.
    """
    scene = Scene.load("push-off").with_(**{"mesh.crack_size": size, "output.frames": 0, "stage.1.steps": steps})
    runs: dict[tuple[str, float], Sheared] = {}
    numbers: dict[str, float] = {}
    print("restraint N/mm                 " + "".join(f"  d = {d:3.1f} mm" for d in SHOWN))
    for k in restraints:
        for model in ("discrete", "smeared"):
            runs[model, k] = now = sheared(run(scene.with_(**{"specimen.restraint": k}), model))
            numbers |= {
                f"{model}, {k:g}: shear": float(np.interp(SHOWN[-1], now.sliding, now.shear)),
                f"{model}, {k:g}: normal": float(np.interp(SHOWN[-1], now.sliding, now.normal)),
                f"{model}, {k:g}: opening": float(np.interp(SHOWN[-1], now.sliding, now.opening)),
                f"{model}, {k:g}: falls": float(-np.diff(now.shear).min()),
            }
            numbers |= {f"{model}, {k:g}: ratio at {d:g}": now.ratio(d) for d in SHOWN}
            for i, (label, column) in enumerate(
                (("shear stress (MPa)", now.shear), ("normal stress (MPa)", now.normal), ("opening (mm)", now.opening))
            ):
                head = f"{k:g} {model}" if i == 0 else ""
                print(f"{head:17s}{label:20s}" + "".join(f"{np.interp(d, now.sliding, column):8.3f}    " for d in SHOWN))
            fit = [walraven(np.interp(d, now.sliding, now.opening), d, CUBE_STRENGTH) for d in SHOWN]
            for j, sign, label in ((0, 1.0, "Walraven, shear"), (1, -1.0, "Walraven, normal")):
                print(f"{'':17s}{label:20s}" + "".join(f"{sign * float(f[j]):8.3f}    " for f in fit))
            print(f"{'':17s}largest fall of the shear stress in a step: {max(-np.diff(now.shear).min(), 0.0):.4f} MPa")
            print(f"{'':17s}{'shear over fit':20s}" + "".join(f"{now.ratio(d):8.3f}    " for d in SHOWN))
    if plot is not None:
        _draw(runs, restraints, plot)
    return numbers


def _draw(runs: dict[tuple[str, float], Sheared], restraints: Sequence[float], path: Path) -> None:
    figure = new_figure(13.0, 4.3)
    left, middle, right = figure.subplots(1, 3)
    for i, k in enumerate(restraints):
        discrete, smeared, colour = runs["discrete", k], runs["smeared", k], f"C{i}"
        shear, pressure = walraven(discrete.opening, discrete.sliding, CUBE_STRENGTH)
        for axes, x, y, fit in ((left, "sliding", "shear", np.maximum(shear, 0.0)), (middle, "opening", "normal", -pressure)):
            axes.plot(getattr(discrete, x), getattr(discrete, y), color=colour)
            axes.plot(getattr(smeared, x), getattr(smeared, y), ".", color=colour, markersize=3)
            axes.plot(getattr(discrete, x), fit, ":", color=colour)
        beyond = discrete.sliding >= SHOWN[0]
        label = f"bars of {k / 1e5:g} x 10$^5$ N/mm"
        right.plot(discrete.sliding[beyond], discrete.shear[beyond] / shear[beyond], color=colour, label=label)
    for style, label in (
        ("k-", "discrete"),
        ("k.", "smeared"),
        ("k:", "Walraven's fit at the discrete run's opening and sliding"),
    ):
        right.plot([], [], style, label=label)
    # the limits of the paper's Figure 24
    left.set(
        xlabel="sliding (mm)", ylabel="mean shear stress (MPa)", title="shear (colours: see right)", xlim=(0, 2.5), ylim=(0, 6)
    )
    middle.set(xlabel="opening (mm)", ylabel="mean normal stress (MPa)", title="normal", xlim=(0, 1.4), ylim=(-5, 0.1))
    right.set(
        xlabel="sliding (mm)", ylabel="shear stress over Walraven's fit", title="discrete against the fit", ylim=(0.0, 1.0)
    )
    left.axhline(0.0, color="0.5", linewidth=0.6)
    middle.axhline(0.0, color="0.5", linewidth=0.6)
    right.legend(frameon=False, fontsize=8, loc="upper right")
    save(figure, path)


if __name__ == "__main__":
    command(main, __doc__, "push_off.png")
