"""How accurate is a scene as it is, and how cheap may a model be?

First nine built-in scenes as they are, in both models, against the discrete model with elements of second order of a third
of the size and four times the steps.

Then settings for an accuracy, checked on a beam that was not used to choose them. `cohesive trade notched-beam` has
measured which settings of the built-in beam reach which accuracy at which cost. Here its table chooses for a beam of twice
the size in every in-plane dimension, meshed as it comes when the small one is doubled: errors of 5, 1 and 0.2 % are asked
for, and what they turn out to be is measured against a run that is finer than all of them.

The error is the largest of those in peak, energy (area under load over opening) and curve (area between the curves over the
area under them), each relative.

Expected: peaks and dissipated energies of the nine scenes within 0.3 %, loads on the way within 1 % of the peak; no promise
broken, and costs that grow with the accuracy.

    python -m examples.accuracy [-o DIR]
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cohesive import Scene, run
from cohesive.figures.drawing import new_figure, save
from cohesive.studies.accuracy import settings_for
from cohesive.studies.curves import Curve, Pair, curve_of
from cohesive.studies.parameters import changes
from cohesive.studies.trials import errors
from examples.command import command

SCENES = (
    "en-14651", "wedge-splitting", "compact-tension", "four-point-beam", "l-panel", "petersson", "rilem-tc-50",
    "jacobsen-mixed-mode", "notched-tension",
)  # fmt: skip


@dataclass(frozen=True)
class Off:
    """How far a scene as it is lies from its reference, as parts of one: its secant at 30 % of the peak, the load on the way
    (largest difference over the peak), the peak, its place and the dissipated energy; and its CPU seconds."""

    secant: float
    curve: float
    peak: float
    at_peak: float
    dissipated: float
    cpu: float


def reference_of(scene: Scene) -> Scene:
    """The scene with elements of second order of a third of the size and four times the steps."""
    finer = {"mesh.order": 2, "mesh.crack_size": scene.sizes.crack_size / 3, "mesh.far_size": scene.sizes.far_size / 3}
    for i, stage in enumerate(scene.data["stage"]):
        finer |= {f"stage.{i}.steps": 4 * stage["steps"]} if "steps" in stage else {f"stage.{i}.step": stage["step"] / 4}
    return scene.with_(**finer)


def secant(curve: Curve, load: float) -> float:
    """Load over x where the load is first reached, N/mm."""
    i = int(np.argmax(curve.load >= load))
    return load / float(np.interp(load, curve.load[i - 1 : i + 1], curve.x[i - 1 : i + 1]))


def as_they_are(names: tuple[str, ...] = SCENES) -> dict[tuple[str, str], Off]:
    """Scenes as they are, by name and model, against their discrete references; print and return how far they are off."""
    found = {}
    head = ("secant", "curve", "peak", "its place", "dissipated")
    print(f"{'off by (%)':32s}" + "".join(f"{word:>12s}" for word in head) + f"{'CPU s':>9s}")
    for name in names:
        scene = Scene.load(name).with_(**{"output.frames": 0})
        truth = run(reference_of(scene))
        fine = curve_of(truth)
        for model in ("discrete", "smeared"):
            clock = time.process_time()
            result = run(scene, model)
            cpu = time.process_time() - clock
            curve, low = curve_of(result), 0.3 * fine.peak
            (s, _, load), (t, _, loads) = (Pair.from_curves(curve, fine).upto_end(i) for i in (0, 1))
            found[name, model] = off = Off(
                secant(curve, low) / secant(fine, low) - 1.0,
                float(abs(load - np.interp(s, t, loads)).max()) / fine.peak,
                curve.peak / fine.peak - 1.0,
                curve.at_peak / fine.at_peak - 1.0,
                result.dissipated_energy / truth.dissipated_energy - 1.0,
                cpu,
            )
            values = (off.secant, off.curve, off.peak, off.at_peak, off.dissipated)
            print(f"{name + ', ' + model:32s}" + "".join(f"{100 * v:>12.2f}" for v in values) + f"{cpu:>9.2f}", flush=True)
    return found


@dataclass(frozen=True)
class Row:
    """One run: what was asked for and promised (0: as it is), the error that it has, CPU seconds, its curve."""

    asked: float
    promised: float
    error: float
    cpu: float
    curve: Curve


def twice() -> Scene:
    """The built-in beam at twice its size, thickness and material as they are."""
    beam = Scene.load("notched-beam")
    data = {key: value for key, value in beam.data.items() if key != "reference"}
    sizes = ("length", "span", "depth", "notch", "gauge")
    data["specimen"] = data["specimen"] | {name: 2.0 * data["specimen"][name] for name in sizes}
    return Scene(data | {"title": "Half-notched beam of twice the size"})


def timed(scene: Scene, keys: dict[str, Any]) -> tuple[Curve, float]:
    """Curve of a scene with some keys changed, and the CPU seconds that it takes from the mesh to the last step."""
    clock = time.process_time()
    result = run(scene.with_(**keys))
    return curve_of(result), time.process_time() - clock


def main(
    accuracies: tuple[float, ...] = (0.05, 0.01, 0.002),
    finest: float = 4.0,
    names: tuple[str, ...] = SCENES,
    plot: Path | None = None,
) -> tuple[list[Row], dict[tuple[str, str], Off]]:
    """Run the scenes as they are, then the doubled beam as it is and for each accuracy; print the tables and return their
    rows, of the beam the one as it is first.

    Parameters
    ----------
    accuracies : that are asked for, relative errors.
    finest : by how much the run that stands for the truth is finer, in everything, than the settings of the small beam.
    names : of the scenes as they are.
    plot : file for the figure.
    """
    off = as_they_are(names)
    scene = twice()
    truth, seconds = timed(scene, changes(scene, {"finer": finest}, Scene.load("notched-beam")))
    print(f"\n{scene.title}: peak {truth.peak:.1f} N, {seconds:.1f} s of CPU time with everything {finest:g} times finer")
    rows: list[Row] = []
    for asked in (0.0, *accuracies):
        choice = settings_for(scene, asked) if asked else None
        if choice is not None:
            print(f"\n{choice.text}")
        curve, cpu = timed(scene, choice.changes if choice else {})
        found = errors(curve, truth)
        error = max(found[name] for name in ("peak", "energy", "curve_distance"))
        rows.append(Row(asked, choice.promised if choice else 0.0, error, cpu, curve))
    print(f"\n{'asked for':>12s}{'promised':>12s}{'error':>12s}{'CPU s':>10s}{'as it is':>12s}")
    for row in rows:
        words = (f"{100 * row.asked:g} %", f"{100 * row.promised:.2g} %") if row.asked else ("as it is", "")
        kept = "" if not row.asked else "kept" if row.error <= row.promised else "broken"
        print(f"{words[0]:>12s}{words[1]:>12s}{100 * row.error:>10.2f} %{row.cpu:>10.2f}{rows[0].cpu:>12.2f}  {kept}")
    if plot is not None:
        _draw(rows, truth, plot)
    return rows, off


def _draw(rows: list[Row], truth: Curve, path: Path) -> None:
    figure = new_figure(11.0, 4.4)
    curves, costs = figure.subplots(1, 2)
    curves.plot(truth.x, truth.load, color="0.75", linewidth=4.0, label="everything finer")
    for i, row in enumerate(rows):
        name = f"asked for {100 * row.asked:g} %" if row.asked else "as it is"
        curves.plot(row.curve.x, row.curve.load, ".-", color=f"C{i}", linewidth=0.8, markersize=3, label=name)
        costs.loglog(row.cpu, 100 * row.error, "o", color=f"C{i}", label=f"{name}: its error")
        if row.asked:
            costs.loglog(row.cpu, 100 * row.promised, "_", color=f"C{i}", markersize=14, label=f"{name}: the promise")
    curves.set(xlabel="opening (mm)", ylabel="load (N)", xlim=(0.0, None), ylim=(0.0, None), title="twice the built-in beam")
    costs.set(xlabel="CPU time (s)", ylabel="largest relative error (%)", title="promised and found")
    curves.legend(frameon=False)
    costs.legend(frameon=False, fontsize=8)
    save(figure, path)


if __name__ == "__main__":
    command(main, __doc__, "accuracy.png")
