"""Sheared, then pulled: how much does a shear force that stays take from the strength in tension?

The panel of Nooru-Mohamed (1992), load paths 4: 200 x 200 x 50 mm with notches of 25 x 5 mm from both sides, glued into two
stiff frames. The upper frame is pushed sideways to 0, 5 or 10 kN; this force stays while the frame is pulled up. Under shear
two cracks leave the notches at a slant and bend, and a lens of concrete remains between them; their paths are those that the
smeared model takes by itself, with cracks that may form anywhere, and discrete cracks are given them.

Expected: peaks fall with the shear force; on the straight path between the notches the sheared panel is weaker still, as
that path is loaded in shear; work and energies agree within 1e-3, in which the shear force that moves on has its share.

    python -m examples.shear_and_pull [-o DIR]
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.patches import Polygon

from cohesive import Result, Scene, run
from cohesive.figures.drawing import new_figure, save
from examples.command import command

#: shear force, N, and the scene with the paths that belong to it
SCENES = {5e3: "nooru-mohamed-4a", 1e4: "nooru-mohamed-4b"}


@dataclass(frozen=True)
class Pulled:
    """One panel: shear force, peak of the pull (N), opening there (mm); at the end dissipated energy, work of both drives and
    that of the shear force while it stays (N mm); error of the energy balance."""

    shear: float
    peak: float
    opening_at_peak: float
    dissipated: float
    work: float
    work_of_shear: float
    balance: float


def measured(result: Result, shear: float) -> Pulled:
    """What a run shows."""
    h = result.history
    pulled = h["load.shear"][-1] * (h["driven.shear"][-1] - np.interp(1.0, h["stage"], h["driven.shear"])) if shear else 0.0
    return Pulled(
        shear, result.peak_load, result.opening_at_peak, float(h["dissipated"][-1]), float(h["work"][-1]), float(pulled),
        result.energy_error,
    )  # fmt: skip


def main(size: float = 2.5, plot: Path | None = None) -> dict[str, Pulled]:
    """Run the panel on curved and straight paths; print and return what they show.

    Parameters
    ----------
    size : length of the elements on the cracks, mm.
    plot : file for the figure.
    """
    results = {}
    for shear, name in SCENES.items():
        scene = Scene.load(name).with_(**{"mesh.crack_size": size, "output.frames": 0})
        results[f"{shear / 1e3:.0f} kN, curved"] = (run(scene), shear)
        results[f"{shear / 1e3:.0f} kN, straight"] = (run(scene.with_(**{"specimen.crack": None})), shear)
    plain = scene.with_(**{"specimen.crack": None}, stage=[scene.data["stage"][1] | {"others": {"shear": "motion"}}])
    results = {"no shear, straight": (run(plain), 0.0)} | results
    found = {name: measured(*each) for name, each in results.items()}
    for name, p in found.items():
        print(
            f"{name:20s}peak {p.peak / 1e3:.2f} kN at {p.opening_at_peak:.4f} mm; work {p.work:.0f} N mm, "
            f"{p.work_of_shear:.0f} of it by the shear force, {p.dissipated:.0f} dissipated; balance {p.balance:.1e}"
        )
    if plot is not None:
        _draw({name: result for name, (result, _) in results.items()}, plot)
    return found


def _draw(results: dict[str, Result], path: Path) -> None:
    figure = new_figure(12.0, 4.4)
    sketch, loads, energies = figure.subplots(1, 3)
    panel = next(iter(results.values())).scene.specimen.outline()
    sketch.add_patch(Polygon(panel.corners, facecolor="0.92", edgecolor="0.5"))
    for edge in panel.edges.values():
        sketch.plot(*np.array(edge).T, "0.2", linewidth=4.0)
    sketch.annotate("shear", (-100.0, 60.0), (-160.0, 60.0), va="center", arrowprops={"arrowstyle": "->"})
    sketch.annotate("pull", (0.0, 140.0), (0.0, 105.0), ha="center", arrowprops={"arrowstyle": "->"})
    colours = {"no": "0.4", "5": "C0", "10": "C1"}
    for name, result in results.items():
        colour, is_curved = colours[name.split()[0]], name.endswith("curved")
        h = result.history
        label = f"{name}, {result.peak_load / 1e3:.1f} kN"
        at = h["stage"] == h["stage"][-1]
        loads.plot(h["opening"][at], h["load"][at] / 1e3, colour, linestyle="-" if is_curved else "--", label=label)
        if is_curved:
            for i, line in enumerate(result.scene.specimen.paths):
                sketch.plot(*np.array(line).T, colour, label=f"cracks, {name.split(',')[0]}" if not i else None)
            energies.plot(h["opening"], h["work"], colour, label=f"work, {name.split(',')[0]}")
            parts = h["elastic"] + h["stored"] + h["contact_work"]
            energies.plot(h["opening"], h["dissipated"], colour, linestyle=":", label="dissipated")
            energies.plot(h["opening"], parts + h["dissipated"], "k", linewidth=0.7, label="all energies")
    sketch.set(xlim=(-165.0, 150.0), ylim=(-115.0, 165.0), xlabel="x (mm)", ylabel="y (mm)")
    sketch.set_aspect("equal")
    sketch.legend(frameon=False, loc="upper right", fontsize=8)
    loads.set(xlabel="opening of the gauge (mm)", ylabel="pull (kN)", xlim=(0.0, None), ylim=(0.0, None))
    loads.legend(frameon=False, fontsize=8)
    energies.set(xlabel="opening of the gauge (mm)", ylabel="energy (N mm)", xlim=(0.0, None), ylim=(0.0, None))
    handles, labels = energies.get_legend_handles_labels()
    one_each = dict(zip(labels, handles, strict=True))
    energies.legend(one_each.values(), one_each.keys(), frameon=False, fontsize=8)
    save(figure, path)


if __name__ == "__main__":
    command(main, __doc__, "shear_and_pull.png")
