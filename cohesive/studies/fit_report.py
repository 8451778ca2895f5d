"""What a fit says and writes."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..results.files import make_folder, write_file, write_scene, write_table, write_text
from ..results.inputs import copy_inputs
from .export import EXPORTS, exported

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .fitted import Fitted


def summary(fit: Fitted) -> str:
    """The printed summary."""
    kind = {"profile": "profile likelihood", "covariance": "covariance", "feasible": "all rows in the band"}[fit.interval_kind]
    lines = [f"fit of {len(fit.problem.parameters)} numbers to {sum(len(d.x) for d in fit.problem.data)} measured rows"]
    for data, load in zip(fit.problem.data, fit.trial.loads, strict=True):
        if any(curve.is_band for curve in data.curves):
            lines.append(f"{data.inside(load)} of {len(load)} points inside the band")
    lines.append(f"rms {100 * fit.rms:.2f} % of the peak; the residuals are worth {fit.effective_rows:.1f} independent ones")
    width = max(len(name) for name in fit.values)
    for name, value in fit.values.items():
        low, high = fit.intervals[name]
        lines.append(f"  {name:<{width}}  {value:<10.4g} {low:.4g} to {high:.4g}")
    lines[-len(fit.values) - 1] += f"; intervals of 95 % ({kind}):"
    lines += [f"identifiable: {words}" for words in fit.identifiable]
    lines += fit.notes
    lines += [line for one in fit.evaluations for line in one.summary().splitlines()]
    lines.append(f"work: {fit.runs} runs, {fit.sensitivities} with derivatives, {fit.condensations} condensation(s)")
    return "\n".join(lines)


def facts(fit: Fitted) -> dict[str, Any]:
    """What fit.json says."""
    return {
        "values": fit.values,
        "intervals": {name: list(ends) for name, ends in fit.intervals.items()},
        "interval_kind": fit.interval_kind,
        "correlation": fit.correlation.tolist(),
        "identifiable": fit.identifiable,
        "rms": fit.rms,
        "effective_rows": fit.effective_rows,
        "loss": fit.problem.loss,
        "minima": [
            {"values": one.values, "rms": one.rms, "starts": one.starts, "evaluations": one.evaluations} for one in fit.minima
        ],
        "work": {"runs": fit.runs, "sensitivities": fit.sensitivities, "condensations": fit.condensations},
        "notes": fit.notes,
        "evaluations": [{"curve": one.name, "values": one.values} for one in fit.evaluations],
        "scenes": [scene.title for scene in fit.scenes],
    }


def save(fit: Fitted, figure: Figure, folder: str | Path) -> None:
    """The files of a fit."""
    from ..results.figures import save as save_figure  # with matplotlib, which is slow to import

    folder = Path(folder)
    make_folder(folder)
    write_file(folder / "fit.png", lambda path: save_figure(figure, path, dpi=150))
    write_text(folder / "fit.json", json.dumps(facts(fit), indent=2, default=float) + "\n")
    names = ["scene", "curve", "x_mm", "measured_N", "low_N", "high_N", "computed_N"]
    write_table(folder / "fit.csv", names, _rows(fit))
    material = fit.scenes[0].material
    for name, (suffix, _) in EXPORTS.items():
        write_text(folder / f"softening-{name}{suffix}", exported(name, material))
    for i, scene in enumerate(fit.scenes, start=1):
        home = folder if len(fit.scenes) == 1 else folder / f"scene-{i}"
        make_folder(home)
        write_scene(scene, copy_inputs(scene, home), home)


def _rows(fit: Fitted) -> Iterator[list[object]]:
    """Measured and computed loads, row by row."""
    for i, (data, load) in enumerate(zip(fit.problem.data, fit.trial.loads, strict=True), start=1):
        names = np.repeat([curve.name for curve in data.curves], [len(curve.x) for curve in data.curves])
        for row in zip(names, data.x, data.middle, data.low, data.high, load, strict=True):
            yield [i, row[0], *(f"{value:.8g}" for value in row[1:])]
