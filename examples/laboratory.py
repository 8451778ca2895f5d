"""Specimens of laboratories: what do they measure, and does the computed work add up to Gf times the ligament?

Beams of Petersson and of three standards, the L-shaped panel of Winkler, wedge splitting and the disk-shaped compact tension
test. All of them bend their ligament, and differ in what is measured: deflection against a yoke, CMOD, the force on the wedge.

Expected: the work to separate Petersson's beam is Gf B (D - a) within 1 %. In the end both halves rotate about the top of the
ligament, where one point of the crack never opens; on elements of 4 mm its share is 2 %, so that by default the last of them
is divided. On a stiff foundation the L panel rises with 61 kN/mm where 40 were measured, so that its support must give way.
The effective crack is shorter than where the cohesive zone ends: tractions hold its faces together.

    python -m examples.laboratory [-o DIR]
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from cohesive import Result, Scene, run
from cohesive.figures.drawing import new_figure, save
from examples.command import command

BEAMS = ("en-14651", "rilem-tc-50", "jci-s-001", "four-point-beam")
SKETCHED = ("petersson", "four-point-beam", "wedge-splitting", "compact-tension", "l-panel")

#: measured by Winkler: slope (N/mm), peak (N) and where it was (mm), work up to 1 mm (N mm)
SLOPE, PEAK, PEAK_AT, WORK = 40e3, 7219.0, 0.208, 2931.0


@dataclass(frozen=True)
class Measured:
    """What the runs show.

    Attributes
    ----------
    work : to separate Petersson's beam over Gf B (D - a)
    stiff_slope : of the L panel on a stiff foundation, N/mm
    support : stiffness of its support along the load that the measured slope asks for, N/mm
    panel_peak, panel_at, panel_work : of the L panel on such a support, N, mm, N mm
    peaks : of all specimens, N
    """

    work: float
    stiff_slope: float
    support: float
    panel_peak: float
    panel_at: float
    panel_work: float
    peaks: dict[str, float]


def main(steps: int = 40, plot: Path | None = None) -> Measured:
    """Run the specimens; print and return what they show.

    Parameters
    ----------
    steps : to each target.
    plot : file for the figure.
    """
    names = ("petersson", "l-panel", "wedge-splitting", "compact-tension", *BEAMS)
    results = {name: run(Scene.load(name).with_(**{"stage.0.steps": steps, "output.frames": 0})) for name in names}
    results["stiff"] = run(results["l-panel"].scene.with_(**{"specimen.stiffness": None}))
    beam, panel = results["petersson"], results["l-panel"]
    b, m = beam.scene.specimen, beam.scene.material
    assert b.crack_area is not None
    slope = float(results["stiff"].history["load"][1] / results["stiff"].history["driven"][1])
    found = Measured(
        float(beam.history["work"][-1]) / (m.Gf * b.crack_area),
        slope,
        1.0 / (1.0 / SLOPE - 1.0 / slope),
        panel.peak_load,
        panel.at_peak(panel.history["driven"]),
        float(np.interp(1.0, panel.history["driven"], panel.history["work"])),
        {name: result.peak_load for name, result in results.items()},
    )
    print(f"Petersson's beam: peak {beam.peak_load:.0f} N, work {100 * found.work:.2f} % of Gf B (D - a)")
    print(
        f"L panel: {slope / 1e3:.1f} kN/mm on a stiff foundation, measured {SLOPE / 1e3:.0f}, which asks for a support of "
        f"{found.support / 1e3:.0f} kN/mm; with it the peak is {found.panel_peak:.0f} N at {found.panel_at:.3f} mm (measured "
        f"{PEAK:.0f} at {PEAK_AT}), the work up to 1 mm {found.panel_work:.0f} N mm (measured {WORK:.0f})"
    )
    for name in (*BEAMS, "wedge-splitting", "compact-tension"):
        h, p = results[name].history, results[name].peak_row
        at_peak = {key: values[p] for key, values in h.items()}
        print(
            f"{name:16s}peak {at_peak['load']:8.0f} N at a CMOD of {at_peak['cmod']:.3f} mm, effective crack "
            f"{at_peak['effective_length']:.1f} mm"
        )
    if plot is not None:
        _draw(results, plot)
    return found


def _draw(results: dict[str, Result], path: Path) -> None:
    figure = new_figure(12.0, 7.4)
    (sketch, beam, panel), (beams, others, lengths) = figure.subplots(2, 3)
    _sketches(sketch)
    h = results["petersson"].history
    beam.plot(h["deflection"], h["load"], label="deflection against the yoke")
    beam.plot(h["cmod"], h["load"], "C1--", label="CMOD")
    beam.set(title="petersson", xlabel="motion (mm)", ylabel="load (N)", xlim=(0.0, 2.0))
    support = results["l-panel"].scene.specimen.stiffness / 1e3  # type: ignore[attr-defined]
    for name, style in (("stiff", "C0--"), ("l-panel", "C0")):
        h = results[name].history
        label = "stiff foundation" if name == "stiff" else f"support of {support:.0f} kN/mm"
        panel.plot(h["driven"], h["load"] / 1e3, style, label=label)
    panel.plot([0.0, PEAK / SLOPE], [0.0, PEAK / 1e3], "0.5", linewidth=0.8, label="measured slope, 40 kN/mm")
    panel.plot([PEAK_AT], [PEAK / 1e3], "ko", markersize=4, label="measured peak")
    panel.set(title="l-panel", xlabel="displacement of the load (mm)", ylabel="load (kN)", xlim=(0.0, 1.0))
    for name in BEAMS:
        h, s = results[name].history, vars(results[name].scene.specimen)
        arm = (s["span"] - s.get("inner_span", 0.0)) / 4.0
        stress = 6.0 * h["load"] * arm / (s["thickness"] * (s["depth"] - s["notch"]) ** 2)
        beams.plot(h["cmod"], stress, label=name)
    beams.set(title="beams", xlabel="CMOD (mm)", ylabel="nominal stress on the ligament (MPa)", xlim=(0.0, 0.4))
    h = results["wedge-splitting"].history
    others.plot(h["opening"], h["load"] / 1e3, label="wedge-splitting: splitting force")
    others.plot(h["opening"], h["vertical_force"] / 1e3, "C0--", label="wedge-splitting: vertical force")
    h = results["compact-tension"].history
    others.plot(h["cmod"], h["load"] / 1e3, "C1", label="compact-tension")
    others.set(title="pulled and split", xlabel="opening (mm)", ylabel="force (kN)", xlim=(0.0, 0.6))
    h = results["petersson"].history
    notch = results["petersson"].scene.specimen.notch_depth or 0.0
    lengths.plot(h["cmod"], h["effective_length"] - notch, label="effective crack beyond the notch")
    lengths.plot(h["cmod"], h["cohesive_length"], "C1", label="cohesive zone")
    lengths.set(title="lengths in petersson", xlabel="CMOD (mm)", ylabel="length (mm)", xlim=(0.0, 1.0))
    for axes in (beam, panel, beams, others, lengths):
        axes.set_ylim(0.0, None)
        axes.legend(frameon=False, fontsize=8)
    save(figure, path)


def _sketches(axes: Axes) -> None:
    """The outlines, each in a row of its own, with crack paths, supports (triangles) and loads (dots)."""
    for row, name in enumerate(SKETCHED):
        specimen: Any = Scene.load(name).specimen
        outline = specimen.outline()
        corners = np.array([*outline.corners, outline.corners[0]], dtype=float)
        low, size = corners.min(axis=0), np.ptp(corners, axis=0)
        scale = min(1.9 / size[0], 0.75 / size[1])

        def placed(points: Any, low: Any = low, scale: float = scale, row: int = row) -> Any:
            return ((np.array(points, dtype=float) - low) * scale + [0.0, -row]).T

        axes.fill(*placed(corners), facecolor="0.92", edgecolor="0.5", linewidth=0.8)
        for line in outline.slits:
            axes.plot(*placed(line), "0.3", linewidth=1.0)
        for line in outline.crack:
            axes.plot(*placed(line), "C3--", linewidth=1.0)
        places = {**outline.nodes, **outline.edges}
        for support in specimen.held():
            axes.plot(*placed(places[support.at]), "k^", markersize=4)
        for drive in specimen.drives().values():
            for at in filter(None, (drive.at, drive.against)):
                axes.plot(*placed(places[at]), "C0o", markersize=4)
        axes.text(2.0, -row + 0.3, name, fontsize=8, va="center")
    axes.set(xlim=(-0.1, 4.4), ylim=(1.0 - len(SKETCHED) - 0.2, 1.0))
    axes.set_title("supports (triangles), loads (dots), crack paths")
    axes.set_aspect("equal")
    axes.axis("off")


if __name__ == "__main__":
    command(main, __doc__, "laboratory.png")
