"""Size effect: is a beam four times as deep four times as strong?

The built-in notched beam at one, two and four times its size, in the plane: the thickness stays. With a strength criterion
alone the nominal strength sigma_N = 1.5 P span / (thickness depth^2) would not depend on the depth D, with linear elastic
fracture mechanics (LEFM) it would fall as 1/sqrt(D). A cohesive crack lies between, and Bazant's size effect law (1984) joins
the two:

    sigma_N = B ft / sqrt(1 + D/D0),    1/sigma_N^2 = (1 + D/D0) / (B ft)^2,   a straight line over D

Elements and far mesh scale with the beam; the width of the interface follows its rule. The LEFM strength with the whole Gf
comes from two elastic runs of second order with notches 4 % shorter and longer: Gf = P^2/2b dC/da, with C the compliance
under the load.

Expected: runs within 2 % of the fitted law, D0 of the order of the depths. The law's own LEFM asymptote lies lower than that
with Gf: at these sizes the peak knows only the start of the softening curve, and the triangle under its first tangent has
the area Gf/2. The fit joins these sizes; it does not extrapolate far.

    python -m examples.size_effect [-o DIR]
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cohesive import Scene, run
from cohesive.figures.drawing import new_figure, save
from examples.command import command

Array = NDArray[np.float64]
SCALES = (1.0, 2.0, 4.0)


@dataclass(frozen=True)
class Fit:
    """Depths (mm) and nominal strengths (MPa); B ft (MPa) and D0 (mm) of the law, its largest relative distance from a run;
    Gf (N/mm) that belongs to its LEFM asymptote; sigma_N sqrt(D) of LEFM with the whole Gf (MPa sqrt(mm))."""

    depth: Array
    strength: Array
    Bft: float
    D0: float
    distance: float
    Gf: float
    toughness: float

    def law(self, depth: Array) -> Array:
        """Nominal strength at a depth."""
        return np.asarray(self.Bft / np.sqrt(1.0 + depth / self.D0))


def scaled(scale: float, size: float) -> Scene:
    """The beam at a scale, with `size` mm of elements at scale 1. The opening at the peak grows about as sqrt(D)."""
    beam = Scene.load("notched-beam")
    lengths = {name: scale * getattr(beam.specimen, name) for name in ("length", "span", "depth", "notch", "gauge")}
    return beam.with_(
        **{f"specimen.{name}": value for name, value in lengths.items()},
        **{"mesh.crack_size": size * scale, "mesh.far_size": 8.0 * scale, "output.frames": 0},
        stage=[{"control": "opening", "to": 0.06 * float(np.sqrt(scale)), "steps": 60}],
    )


def nominal(scene: Scene, load: float) -> float:
    """Elastic bending stress of the beam without notch, MPa."""
    beam: Any = scene.specimen
    return float(1.5 * load * beam.span / (beam.thickness * beam.depth**2))


def lefm(beam: Scene) -> float:
    """sigma_N sqrt(D) at which the energy release rate of a beam is Gf, MPa sqrt(mm)."""
    elastic = {"interface.width": 0.01, "mesh.order": 2}  # linear triangles are too stiff at a crack tip
    beam = beam.with_(**elastic, stage=[{"control": "driven", "to": 1e-5, "steps": 1}])
    body: Any = beam.specimen
    step = 0.04 * body.notch
    compliance = []
    for notch in (body.notch - step, body.notch + step):
        h = run(beam.with_(**{"specimen.notch": notch})).history
        compliance.append(h["driven"][-1] / h["load"][-1])
    slope = (compliance[1] - compliance[0]) / (2.0 * step)
    load = np.sqrt(2.0 * body.thickness * beam.material.Gf / slope)
    return float(nominal(beam, load) * np.sqrt(body.depth))


def main(size: float = 1.0, plot: Path | None = None) -> Fit:
    """Run the sizes and fit the law; print and return them.

    Parameters
    ----------
    size : length of the elements on the crack of the smallest beam, mm.
    plot : file for the figure.
    """
    scenes = [scaled(scale, size) for scale in SCALES]
    results = [run(scene) for scene in scenes]
    depth = np.array([scene.specimen.depth for scene in scenes])  # type: ignore[attr-defined]
    strength = np.array([nominal(scene, result.peak_load) for scene, result in zip(scenes, results, strict=True)])
    slope, start = np.polyfit(depth, 1.0 / strength**2, 1)
    Bft, D0 = float(start**-0.5), float(start / slope)
    toughness = lefm(scenes[0])
    material = scenes[0].material
    distance = float(abs(Bft / np.sqrt(1.0 + depth / D0) / strength - 1.0).max())
    fit = Fit(depth, strength, Bft, D0, distance, material.Gf * (Bft * np.sqrt(D0) / toughness) ** 2, toughness)
    for D, s, result in zip(depth, strength, results, strict=True):
        print(f"D = {D:g} mm: peak {result.peak_load:.0f} N at {result.opening_at_peak:.4f} mm, sigma_N = {s:.4f} MPa")
    print(f"law: B ft = {Bft:.3f} MPa, B = {Bft / material.ft:.3f}, D0 = {D0:.1f} mm; runs within {100 * distance:.2f} %")
    print(
        f"LEFM with Gf = {material.Gf:g} N/mm: sigma_N sqrt(D) = {toughness:.2f} MPa sqrt(mm); the law's asymptote "
        f"{Bft * np.sqrt(D0):.2f}, that of {fit.Gf:.4f} N/mm"
    )
    if plot is not None:
        _draw(fit, material.Gf, plot)
    return fit


def _draw(fit: Fit, Gf: float, path: Path) -> None:
    figure = new_figure(6.8, 5.0)
    axes = figure.add_subplot()
    D = np.geomspace(0.1 * fit.D0, 20.0 * fit.D0, 200)
    axes.loglog(fit.depth, fit.strength, "o", color="C3", label="notched beams")
    axes.loglog(D, fit.law(D), "C0-", label=f"B ft / sqrt(1 + D/D0), D0 = {fit.D0:.0f} mm")
    axes.axhline(fit.Bft, color="0.4", linestyle="--", linewidth=1.0, label=f"strength, B ft = {fit.Bft:.2f} MPa")
    axes.loglog(
        D, fit.Bft * np.sqrt(fit.D0 / D), "-.", color="0.4", linewidth=1.0, label=f"LEFM of the law, Gf = {fit.Gf:.3f} N/mm"
    )
    axes.loglog(D, fit.toughness / np.sqrt(D), "C2:", label=f"LEFM with Gf = {Gf:g} N/mm")
    axes.set(xlabel="depth D (mm)", ylabel="nominal strength (MPa)", ylim=(0.3, 4.0), xlim=(D[0], D[-1]))
    axes.set_yticks([0.3, 0.5, 1.0, 2.0, 4.0], labels=["0.3", "0.5", "1", "2", "4"])
    axes.set_xticks([20, 50, 100, 200, 500, 1000, 2000], labels=["20", "50", "100", "200", "500", "1000", "2000"])
    axes.minorticks_off()
    axes.legend(frameon=False, loc="lower left")
    save(figure, path)


if __name__ == "__main__":
    command(main, __doc__, "size_effect.png")
