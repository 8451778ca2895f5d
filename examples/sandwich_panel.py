"""Shear scaling: does the mesh decide how much shear an open crack carries?

The paper's Example 1 (Jefferson and Mihai 2015, Figures 12 to 15): a panel clamped between platens is pulled apart by
0.1 mm and then sheared at that opening, with bands of 100, 50 and 25 mm. The reduction function H of eq. (13) acts on the
stiffness G / l_ch, so without the scaling of eq. (25) a finer mesh transfers more shear. With it the three meshes agree,
and they agree with the discrete crack, which has no mesh width at all.

Expected: spread of the shear stress at the largest sliding below 2 % with scaling, about 86 % without; discrete within 5 %
of the finest band. The paper prints no dimensions, so its curves are compared in shape only.

    python -m examples.sandwich_panel [-o DIR]
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cohesive import Scene, run
from cohesive.figures.drawing import new_figure, save
from examples.command import command

Array = NDArray[np.float64]

#: what a mesh of bands is made of: square elements as wide as the band
SIZES = ("mesh.crack_size", "mesh.far_size", "band.width")


@dataclass(frozen=True)
class Curves:
    """Mean stresses on the panel's section over the platen's motion: first normal, then sheared."""

    opening: Array
    normal: Array
    sliding: Array
    shear: Array


def curves(scene: Scene) -> Curves:
    """Run the panel: normal stress (MPa) over the platen's opening (mm), shear stress over its sliding."""
    history = run(scene).history
    area = scene.specimen.width * scene.specimen.thickness  # type: ignore[attr-defined]
    ends = np.flatnonzero(np.diff(history["driven"]) < 0)  # the second stage starts to count from 0
    first, second = slice(None, ends[0] + 1), slice(ends[0] + 1, None)
    stress = history["load"] / area
    return Curves(
        history["driven"][first], stress[first],
        np.r_[0.0, history["driven"][second]], np.r_[0.0, stress[second]],
    )  # fmt: skip


def spread(runs: list[Curves], finest: Curves) -> float:
    """Largest difference of the shear stress between runs at the same sliding, over its largest value in `finest`."""
    x = np.linspace(0.0, min(c.sliding[-1] for c in runs), 200)
    values = np.array([np.interp(x, c.sliding, c.shear) for c in runs])
    return float(np.ptp(values, axis=0).max() / finest.shear.max())


def main(sizes: tuple[float, ...] = (100.0, 50.0, 25.0), plot: Path | None = None) -> dict[str, float]:
    """Run the panel in all meshes; print and return the spreads.

    Parameters
    ----------
    sizes : element sizes of the bands, mm, the finest last.
    plot : file for the figure.
    """
    scene = Scene.load("sandwich-panel").with_(**{"output.frames": 0})
    smeared = scene.with_(**{"model.kind": "smeared"})
    bands = {
        scaling: [curves(smeared.with_(**dict.fromkeys(SIZES, h), **{"material.shear_scaling": scaling})) for h in sizes]
        for scaling in (True, False)
    }
    discrete = curves(scene)
    finest = bands[True][-1]
    result = {
        "spread with scaling": spread(bands[True], finest),
        "spread without scaling": spread(bands[False], finest),
        "discrete against the finest band": spread([discrete, finest], finest),
    }
    for name, value in result.items():
        print(f"{name:34s}{100 * value:7.2f} % of the largest shear stress in the finest band")
    if plot is not None:
        _draw(sizes, bands, discrete, plot)
    return result


def _draw(sizes: tuple[float, ...], bands: dict[bool, list[Curves]], discrete: Curves, path: Path) -> None:
    figure = new_figure(12.0, 4.0)
    left, middle, right = figure.subplots(1, 3)
    styles = ["C0-", "C1--", "C2-."]
    for h, style, run_ in zip(sizes, styles, bands[True], strict=False):
        left.plot(run_.opening, run_.normal, style, label=f"band, $h_e$ = {h:g} mm")
    left.plot(discrete.opening, discrete.normal, "k:", label="discrete")
    left.set(xlabel="opening of the platen (mm)", ylabel="normal stress (MPa)", title="opened (Figure 14)")
    for axes, scaling, title in (
        (middle, False, "sheared, without scaling (15a)"),
        (right, True, "sheared, with scaling (15b)"),
    ):
        for h, style, run_ in zip(sizes, styles, bands[scaling], strict=False):
            axes.plot(run_.sliding, run_.shear, style, label=f"band, $h_e$ = {h:g} mm")
        axes.plot(discrete.sliding, discrete.shear, "k:", label="discrete")
        axes.set(xlabel="sliding of the platen (mm)", ylabel="shear stress (MPa)", title=title)
    right.sharey(middle)
    for axes in (left, middle, right):
        axes.legend(frameon=False)
    save(figure, path)


if __name__ == "__main__":
    command(main, __doc__, "sandwich_panel.png")
