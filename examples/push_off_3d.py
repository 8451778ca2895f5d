"""The push-off test in three dimensions, and how many iterations it takes: Example 4 of the paper.

Jefferson and Mihai (2015), Figure 24 and Table 4.

The paper models this example with solid elements. The built-in scene `push-off-3d` is its block with front and back free, in
both models: a plane of 300 x 120 mm is opened by 0.2 mm, then sheared by 2 mm while bars resist its opening; for the
assumptions and for Walraven's fit see `examples.push_off`, the same block in the plane. Then the iterations of increments
of 0.1 mm for c_zn = 5, 9, 50 in the six successive ones that need most, beside the paper's Table 4, which lists the unbalanced
forces of its increments 10 to 15.

Expected: discrete, smeared and plane curves lie on one another: the plane shears almost as one, the stress is within 2 % of
its mean along it and even over the thickness. Each c_zn needs the same number of iterations within two, where the paper
needs twice as many for 50 as for 9 and 5. The tail is quadratic, r(n+1) at most 1.6 r(n)^2; in the paper's table the last
residuals for 9 and 5 fall about twentyfold in each iteration.

    python -m examples.push_off_3d [-o DIR]
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from cohesive import Result, Scene, run
from cohesive.figures.drawing import new_figure, save
from examples.command import command
from examples.contact_smoothing import CLOSING, PAPER, WINDOW, Iterations, block, draw_counts, draw_residuals
from examples.push_off import SHOWN, Sheared, sheared

#: curves by name: scene and model
CURVES = {
    "discrete": ("push-off-3d", "discrete"),
    "smeared": ("push-off-3d", "smeared"),
    "discrete, plane": ("push-off", "discrete"),
    "smeared, plane": ("push-off", "smeared"),
}


def unevenness(result: Result) -> tuple[float, float]:
    """Largest difference of the cells' shear from its mean at the end, over the mean: of means over the thickness, and of
    means along the plane."""
    fields = result.fields
    cracks = fields.cell_values(result.steps)
    count = np.bincount(fields.cell)
    x, z = (np.bincount(fields.cell, fields.where[:, axis]) / count for axis in (0, 2))
    shear, found = cracks["traction_s"], []
    for place in (x, z):
        _, row = np.unique(place.round(6), return_inverse=True)
        means = np.bincount(row, shear) / np.bincount(row)
        found.append(float(abs(means / shear.mean() - 1.0).max()))
    return found[0], found[1]


def main(size: float = 20.0, steps: int = 50, increments: int = 20, plot: Path | None = None) -> dict[str, float]:
    """Run the block in both models; print and return the numbers.

    Parameters
    ----------
    size : element size along the crack, mm; in the band of the block its width.
    steps : increments of the shearing, for the curves.
    increments : of the shearing, for the iterations.
    plot : file for the figure.
    """
    numbers: dict[str, float] = {}
    curves: dict[str, Sheared] = {}
    print(f"{'':18s}{'':14s}" + "".join(f"  d = {d:3.1f} mm" for d in SHOWN))
    for name, (scene, model) in CURVES.items():
        keys = {"mesh.crack_size": size, "output.frames": 0, "stage.1.steps": steps}
        result = run(Scene.load(scene).with_(**keys), model)
        curves[name] = now = sheared(result)
        for label, column in (("shear, MPa", now.shear), ("normal, MPa", now.normal), ("opening, mm", now.opening)):
            head = name if column is now.shear else ""
            print(f"{head:18s}{label:14s}" + "".join(f"{np.interp(d, now.sliding, column):10.3f}" for d in SHOWN))
        numbers |= {f"{name}: shear": float(now.shear[-1]), f"{name}: normal": float(now.normal[-1])}
        if scene == "push-off-3d":
            along, across = unevenness(result)
            numbers |= {f"{name}: uneven along": along, f"{name}: uneven across": across}
            print(f"{'':18s}shear at the end: up to {100 * along:.1f} % from its mean along the plane, "
                  f"{100 * across:.1g} % over the thickness")  # fmt: skip
    for name in ("smeared", "discrete, plane", "smeared, plane"):
        numbers[f"{name}: apart"] = apart(curves[name], curves["discrete"])
        print(f"largest difference in shear stress from the discrete block, {name}: {100 * numbers[f'{name}: apart']:.2f} %")

    cases: dict[str, Mapping[float, Iterations]] = {"paper": PAPER}
    cases |= {m: {c: block(c, m, size, increments, "push-off-3d") for c in CLOSING} for m in ("discrete", "smeared")}
    print(f"iterations in six increments, for c_zn = {' / '.join(f'{c:g}' for c in CLOSING)}")
    for name, found in cases.items():
        totals, tails = [sum(found[c].in_window) for c in CLOSING], [found[c].quadratic() for c in CLOSING]
        numbers |= {f"{name}, c_zn = {c:g}: iterations": float(total) for c, total in zip(CLOSING, totals, strict=True)}
        numbers |= {f"{name}, c_zn = {c:g}: tail": tail for c, tail in zip(CLOSING, tails, strict=True)}
        print(f"    {name:12s}{' / '.join(map(str, totals)):16s}r(n+1)/r(n)^2 up to {' / '.join(f'{t:.3g}' for t in tails)}")
    print("relative residuals after each iteration of the six increments, in the paper 10 to 15")
    for name, found in cases.items():
        for c, one in found.items():
            first = 9 if name == "paper" else one.window
            for i, residuals in enumerate(one.residuals[one.window : one.window + WINDOW], first + 1):
                print(f"    {name:10s}c_zn = {c:<4g}increment {i:2d}:  " + "  ".join(f"{r:.1e}" for r in residuals[1:]))
    if plot is not None:
        _draw(curves, cases, plot)
    return numbers


def apart(one: Sheared, other: Sheared) -> float:
    """Largest difference between two shear stresses over the largest one."""
    sliding = other.sliding[other.sliding <= one.sliding.max()]
    first, second = (np.interp(sliding, each.sliding, each.shear) for each in (one, other))
    return float(abs(first - second).max() / second.max())


def _draw(curves: dict[str, Sheared], cases: Mapping[str, Mapping[float, Iterations]], path: Path) -> None:
    figure = new_figure(13.0, 7.6)
    axes = figure.subplots(2, 3)
    styles = {
        "discrete": {"color": "C0", "linewidth": 3.5, "alpha": 0.5},
        "smeared": {"color": "C1", "marker": "o", "markersize": 3, "linestyle": "none"},
        "discrete, plane": {"color": "k", "linestyle": "--", "linewidth": 0.9},
        "smeared, plane": {"color": "0.6", "linestyle": ":", "linewidth": 1.2},
    }
    for row, (y, low, high) in enumerate((("shear", 0.0, 6.0), ("normal", -5.0, 0.1))):
        for column, (x, right) in enumerate((("sliding", 2.5), ("opening", 1.4))):
            for name, curve in curves.items():
                axes[row, column].plot(getattr(curve, x), getattr(curve, y), label=name, **styles[name])
            axes[row, column].set(xlabel=f"{x} (mm)", ylabel=f"mean {y} stress (MPa)", xlim=(0.0, right), ylim=(low, high))
    axes[0, 0].set(title="axes of the paper's Figure 24")
    axes[0, 0].legend(frameon=False, fontsize=8, loc="upper left")
    draw_counts(axes[0, 2], cases)
    draw_residuals(axes[1, 2], cases["discrete"])
    axes[1, 2].set(title="discrete: the six increments")
    for panel in axes[:, 2]:
        panel.legend(frameon=False, fontsize=8)
    save(figure, path)


if __name__ == "__main__":
    command(main, __doc__, "push_off_3d.png")
