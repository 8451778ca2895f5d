"""Width matters: how much elastic concrete is hidden in an interface?

Eq. (21) of Jefferson and Mihai (2015) gives the crack plane the stiffness E/h of a process zone of h = 60 mm. In an interface
element that zone has no thickness, and the bulk beside it is still there: its elastic compliance counts twice. The beam of
Gregoire et al. (2013) shows it, on the rising branch first: half its depth is notch, and 60 mm is nearly half its span.

With a small width w the bulk carries the elastic deformation, once, and the jump is what the crack has opened. The rule of
the package takes the smaller of 0.25 % of the crack length and 0.1 % of E Gf/ft^2: 0.0625 mm here.

Expected: about 120 N at an opening of 0.005 mm with w = h, where 366 to 427 N were measured, a lower peak at a larger
opening, and loads that grow towards the measured band as w falls.

    python -m examples.width_matters [-o DIR]
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cohesive import Result, Scene, run
from cohesive.figures.drawing import draw_reference, new_figure, save
from examples.command import command

WIDTHS = ("h", 10.0, 2.0, 0.0625)
EARLY = 0.005  # mm, the first measured point


@dataclass(frozen=True)
class Row:
    """One run: width (mm), load at 0.005 mm and at the peak (N), opening at the peak (mm), measured points inside the band,
    and what the width adds to the elastic compliance of the gauge, as a part of it."""

    width: float
    early: float
    peak: float
    opening: float
    inside: int
    added: float


def measured(result: Result) -> Row:
    """The row of a run."""
    opening, load = (result.history[name] for name in ("opening", "load"))
    early = float(np.interp(EARLY, opening, load))
    return Row(
        result.width,
        early,
        result.peak_load,
        result.opening_at_peak,
        result.agreement[0].inside,
        result.added_compliance(),
    )


def main(size: float = 1.0, plot: Path | None = None) -> list[Row]:
    """Run the beam at all widths; print the table and return its rows, the widest first.

    Parameters
    ----------
    size : length of the elements on the crack, mm.
    plot : file for the figure.
    """
    beam = Scene.load("notched-beam").with_(**{"mesh.crack_size": size, "output.frames": 0})
    results = [run(beam.with_(**{"interface.width": width})) for width in WIDTHS]
    rows = [measured(result) for result in results]
    print("width mm   load at 0.005 mm   peak N   at mm   of 13 points inside   added to the compliance")
    for row in rows:
        print(
            f"{row.width:8g}{row.early:17.1f} N{row.peak:9.1f}{row.opening:8.4f}{row.inside:14d}{100 * row.added:25.1f} %",
            flush=True,
        )
    if plot is not None:
        _draw(results, rows, plot)
    return rows


def _draw(results: list[Result], rows: list[Row], path: Path) -> None:
    figure = new_figure(10.0, 4.4)
    whole, start = figure.subplots(1, 2, width_ratios=[1.3, 1.0])
    for axes in (whole, start):
        draw_reference(axes, results[0], "opening")
        for i, (result, row) in enumerate(zip(results, rows, strict=True)):
            opening, load = (result.history[name] for name in ("opening", "load"))
            label = f"w = {row.width:g} mm{' = h' if i == 0 else ''}, peak {row.peak:.0f} N"
            axes.plot(opening, load, color=f"C{i}", label=label)
        axes.set(xlabel="opening (mm)", ylabel="load (N)", ylim=(0.0, None))
    whole.set(xlim=(0.0, None), title="Gregoire et al. (2013), depth 50 mm")
    whole.legend(frameon=False)
    start.set(xlim=(0.0, 0.035), title="the rising branch")
    save(figure, path)


if __name__ == "__main__":
    command(main, __doc__, "width_matters.png")
