"""Discrete and smeared close in on each other, from two sides.

One law serves both models, with the width w of the interface or with the width l_ch of the band, on one mesh. A wide
interface adds elastic compliance to the body, so its peak is too low; a wide band is too stiff, and dissipates more than
Gf. As both widths shrink the curves meet. The beam is that of Gregoire et al. (2013), ft = 3.6 MPa, Gf = 0.07 N/mm.

Three measures over the width: the peak; the energy, the area under load over opening up to 0.18 mm; and the force that the
band carries along the crack at the peak, by its lateral stress. An interface has no such stress (Poisson coupling). The
stress does not vanish with the width, the force does.

Expected: peaks and energies of the finest pair within 1 %, differences and a force that fall with the width.

    python -m examples.discrete_and_smeared [-o DIR]
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from scipy.integrate import trapezoid

from cohesive import Result, Scene, run
from cohesive.figures.drawing import new_figure, save
from examples.command import command


@dataclass(frozen=True)
class Row:
    """One run: width (mm), peak (N), energy (N mm), lateral force of the band at the peak (N), seconds, iterations."""

    width: float
    peak: float
    energy: float
    lateral: float
    seconds: float
    iterations: int


def measured(result: Result) -> Row:
    """The row of a run."""
    h = result.history
    lateral = 0.0
    if result.is_smeared:
        stress = result.frame(int(h["load"].argmax())).stress[-1]  # of the band, which runs along y
        lateral = float(abs(stress[:, 1]).mean() * result.width * result.scene.specimen.thickness)
    energy = float(trapezoid(h["load"], h["opening"]))
    return Row(result.width, result.peak_load, energy, lateral, result.solution_time, result.iterations)


def main(
    interfaces: tuple[float, ...] = (10.0, 5.0, 2.5, 1.0, 0.5, 0.2, 0.1),
    bands: tuple[float, ...] = (10.0, 5.0, 2.5, 1.0, 0.5),
    steps: int = 60,
    plot: Path | None = None,
) -> dict[str, list[Row]]:
    """Run the beam at all widths; print the table and return its rows by model, the finest last.

    Parameters
    ----------
    interfaces : widths w, mm.
    bands : widths l_ch, mm.
    steps : to an opening of 0.18 mm.
    plot : file for the figure.
    """
    beam = Scene.load("notched-beam").with_(**{"material.ft": 3.6, "output.frames": 0, "stage.0.steps": steps})
    scenes = {
        "discrete": [beam.with_(**{"interface.width": w}) for w in interfaces],
        "smeared": [beam.with_(**{"model.kind": "smeared", "band.width": b}) for b in bands],
    }
    rows: dict[str, list[Row]] = {}
    print(f"{'':10s}{'width mm':>10s}{'peak N':>10s}{'energy N mm':>13s}{'lateral N':>11s}{'seconds':>9s}{'iterations':>12s}")
    for model, models_scenes in scenes.items():
        rows[model] = []
        for scene in models_scenes:
            row = measured(run(scene))
            rows[model].append(row)
            print(
                f"{model:10s}{row.width:10g}{row.peak:10.1f}{row.energy:13.2f}{row.lateral:11.2f}{row.seconds:9.2f}"
                f"{row.iterations:12d}",
                flush=True,
            )
    last = {model: rows[model][-1] for model in rows}
    for name in ("peak", "energy"):
        discrete, smeared = (getattr(last[model], name) for model in ("discrete", "smeared"))
        print(f"finest pair, {name}: smeared {100 * (smeared / discrete - 1.0):+.2f} % from discrete")
    if plot is not None:
        _draw(rows, plot)
    return rows


def _draw(rows: dict[str, list[Row]], path: Path) -> None:
    figure = new_figure(12.0, 4.0)
    all_axes = figure.subplots(1, 3)
    for axes, name, label in zip(
        all_axes,
        ("peak", "energy", "lateral"),
        ("peak load (N)", "energy to 0.18 mm (N mm)", "lateral force of the band at the peak (N)"),
        strict=True,
    ):
        for model, marker, colour in (("discrete", "o-", "C0"), ("smeared", "s--", "C1")):
            if name == "lateral" and model == "discrete":
                continue
            what = "w of the interface" if model == "discrete" else "$l_{ch}$ of the band"
            widths, values = ([getattr(row, key) for row in rows[model]] for key in ("width", name))
            axes.semilogx(widths, values, marker, color=colour, label=f"{model}, {what}")
        axes.set(xlabel="width (mm)", ylabel=label)
        axes.legend(frameon=False)
    all_axes[2].set_ylim(bottom=0.0)
    save(figure, path)


if __name__ == "__main__":
    command(main, __doc__, "discrete_and_smeared.png")
