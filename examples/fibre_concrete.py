"""A fibre concrete beam: the stress rises again as the fibres take over, and so does the load.

The curve is given by points: 4 MPa at the onset, 1.2 MPa at 0.04 mm where the matrix has cracked, 2.4 MPa at 0.5 mm where
the fibres carry most, nothing from 3 mm on. ft and Gf follow. The secant falls from point to point, so that damage never
heals. The beam is that of EN 14651: 150 x 150 mm, span 500 mm, notch 25 mm, opening over the notch.

Expected: a first peak at an opening below 0.1 mm, then a drop, then a second, larger peak beyond 0.5 mm; the discrete crack
and the crack band within 1 % in both peaks. The asperities keep the size that the first branch gives them (Zm), a twentieth
of what c1 Gf/ft would be.

    python -m examples.fibre_concrete [-o DIR]
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from cohesive import Result, Scene, run
from cohesive.figures.drawing import new_figure, save
from examples.command import command

#: opening beyond the onset (mm) and stress (MPa)
POINTS = [[0.0, 4.0], [0.04, 1.2], [0.5, 2.4], [3.0, 0.0]]

BEAM = {
    "title": "Fibre concrete beam (EN 14651)",
    "specimen": {
        "kind": "notched-beam", "length": 550.0, "span": 500.0, "depth": 150.0, "thickness": 150.0, "notch": 25.0,
        "gauge": 40.0,
    },
    "mesh": {"crack_size": 2.5, "far_size": 20.0},
    "material": {"E": 32e3, "nu": 0.2, "softening": {"points": POINTS}},
    "stage": [{"control": "opening", "to": [0.1, 3.5], "steps": 60}],
}  # fmt: skip


def main(size: float = 2.5, plot: Path | None = None) -> dict[str, float]:
    """Run it in both models; print and return the two peaks of each.

    Parameters
    ----------
    size : length of the elements on the crack, mm.
    plot : file for the figure.
    """
    scene = Scene(BEAM).with_(**{"mesh.crack_size": size, "output.frames": 0})
    results = {model: run(scene, model) for model in ("discrete", "smeared")}
    m = scene.material
    found = {"ft": m.ft, "Gf": m.Gf, "Zm": m.Zm, "c1 Gf/ft": m.c1 * m.Gf / m.ft}
    print(
        f"ft = {m.ft:g} MPa, Gf = {m.Gf:.4g} N/mm from the points; Zm = {m.Zm:.3g} mm where c1 Gf/ft = {found['c1 Gf/ft']:.3g}"
    )
    for model, result in results.items():
        found |= {f"{model}, {name}": value for name, value in _peaks(result).items()}
        print(f"{model}: " + ", ".join(f"{name} {found[f'{model}, {name}']:.5g}" for name in _peaks(result)))
    if plot is not None:
        _draw(results, plot)
    return found


def _peaks(result: Result) -> dict[str, float]:
    """First peak, the valley behind it, and the second peak (N, mm)."""
    opening, load = result.history["opening"], result.history["load"]
    valley = int(np.argmax(np.diff(load) > 0) if (np.diff(load)[0] < 0) else _first_valley(load))
    first, second = int(load[: valley + 1].argmax()), valley + int(load[valley:].argmax())
    rows = {"first peak (N)": first, "valley (N)": valley, "second peak (N)": second}
    return {name: float(load[row]) for name, row in rows.items()} | {"second peak at (mm)": float(opening[second])}


def _first_valley(load: np.ndarray) -> int:
    """Row from which the load rises again after it has fallen."""
    falls = np.flatnonzero(np.diff(load) < 0)[0]
    return int(falls + np.flatnonzero(np.diff(load)[falls:] > 0)[0])


def _draw(results: dict[str, Result], plot: Path) -> None:
    """Load over opening in both models, and the curve of the material."""
    figure = new_figure(11.0, 4.2)
    left, right = figure.subplots(1, 2)
    for (model, result), style in zip(results.items(), ("C0-", "C1--"), strict=True):
        left.plot(result.history["opening"], result.history["load"] / 1e3, style, label=model)
    left.set(xlabel="opening over the notch (mm)", ylabel="load (kN)", title=str(BEAM["title"]))
    left.legend(frameon=False)
    right.plot(*np.array(POINTS).T, "o-", markersize=4)
    right.set(xlabel="opening beyond the onset (mm)", ylabel="stress (MPa)", title="softening by points")
    for axes in (left, right):
        axes.axhline(0.0, color="0.5", linewidth=0.6)
    save(figure, plot)


if __name__ == "__main__":
    command(main, __doc__, "fibre_concrete.png")
