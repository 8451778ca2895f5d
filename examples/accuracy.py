"""How cheap may a model be? Settings for an accuracy, checked on a beam that was not used to choose them.

`cohesive trade notched-beam` has measured which settings of the built-in beam reach which accuracy at which cost. Here its
table chooses for a beam of twice the size in every in-plane dimension, meshed as it comes when the small one is doubled:
errors of 5, 1 and 0.2 % are asked for, and what they turn out to be is measured against a run that is finer than all of them.

The error is the largest of those in peak, energy (area under load over opening) and curve (area between the curves over the
area under them), each relative.

Expected: no promise broken, and costs that grow with the accuracy.

    python -m examples.accuracy [-o DIR]
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cohesive import Scene, run
from cohesive.figures.drawing import new_figure, save
from cohesive.studies.accuracy import settings_for
from cohesive.studies.curves import Curve, curve_of
from cohesive.studies.parameters import changes
from cohesive.studies.trials import errors
from examples.command import command


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
    for table, names in (("specimen", ("length", "span", "depth", "notch", "gauge")), ("mesh", ("crack_size", "far_size"))):
        data[table] = data[table] | {name: 2.0 * data[table][name] for name in names}
    return Scene(data | {"title": "Half-notched beam of twice the size"})


def timed(scene: Scene, keys: dict[str, Any]) -> tuple[Curve, float]:
    """Curve of a scene with some keys changed, and the CPU seconds that it takes from the mesh to the last step."""
    clock = time.process_time()
    result = run(scene.with_(**keys))
    return curve_of(result), time.process_time() - clock


def main(accuracies: tuple[float, ...] = (0.05, 0.01, 0.002), finest: float = 8.0, plot: Path | None = None) -> list[Row]:
    """Run the doubled beam as it is and for each accuracy; print the table and return its rows, the beam as it is first.

    Parameters
    ----------
    accuracies : that are asked for, relative errors.
    finest : by how much the run that stands for the truth is finer, in everything, than the settings of the small beam.
    plot : file for the figure.
    """
    scene = twice()
    truth, seconds = timed(scene, changes(scene, {"finer": finest}, Scene.load("notched-beam")))
    print(f"{scene.title}: peak {truth.peak:.1f} N, {seconds:.1f} s of CPU time with everything {finest:g} times finer")
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
    return rows


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
