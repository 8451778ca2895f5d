"""Twenty beams, twenty paths: how do place and depth of the notch lead a crack?

The beam of `eccentric_beam` (span 200 mm, depth 80 mm) with its notch at five places and four depths. Each path is found; all
are drawn, and the table says from where on a direction is held, since the stresses near the load favour none.

Expected: each crack leans towards the load, the more the farther from mid-span it starts; at mid-span it is straight. None
leaves the body, and all end at the upper face. The peak of a shallow notch near a support is not that of the beam, which would
crack at mid-span first, where no path is.

    python -m examples.many_paths [-o DIR]
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cohesive import SceneError, run
from cohesive.figures.drawing import new_figure, save
from examples.command import command
from examples.eccentric_beam import beam

PLACES = (-80.0, -60.0, -40.0, -20.0, 0.0)
DEPTHS = (8.0, 16.0, 28.0, 40.0)


@dataclass(frozen=True)
class Beam:
    """A beam and its path: place and depth of the notch (mm), the path (n, 2) or None with the reason, and the peak (N)."""

    place: float
    depth: float
    path: NDArray[np.float64] | None
    peak: float = 0.0
    why: str = ""


def main(
    size: float = 1.0, places: tuple[float, ...] = PLACES, depths: tuple[float, ...] = DEPTHS, plot: Path | None = None
) -> list[Beam]:
    """Find all paths; print and return them.

    Parameters
    ----------
    size : length of the elements on the crack, mm.
    places, depths : of the notch, from mid-span and from the lower face, mm.
    plot : file for the figure.
    """
    found = []
    print(f"{'notch at':>9}{'depth':>7}{'peak (N)':>10}  path")
    for depth in depths:
        for place in places:
            scene = beam(size).with_(**{"specimen.notch_position": place, "specimen.notch": depth})
            try:
                result = run(scene)
            except SceneError as error:
                found.append(Beam(place, depth, None, why=str(error)))
                print(f"{place:9g}{depth:7g}{'':10}  {error}")
                continue
            found.append(Beam(place, depth, result.path, result.peak_load))
            note = next(note for note in result.notes if note.startswith("path"))
            print(f"{place:9g}{depth:7g}{result.peak_load:10.0f} {note.removeprefix('path:')}")
    if plot is not None:
        _draw(found, plot)
    return found


def _draw(found: list[Beam], path: Path) -> None:
    figure = new_figure(9.0, 4.0)
    axes = figure.add_subplot()
    axes.fill([-125, 125, 125, -125], [0, 0, 80, 80], color="0.93")
    depths = sorted({each.depth for each in found})
    for each in found:
        colour = f"C{depths.index(each.depth)}"
        axes.plot([each.place, each.place], [0.0, each.depth], color="black", linewidth=1.0)
        if each.path is not None:
            axes.plot(*each.path.T, color=colour)
    for number, depth in enumerate(depths):
        axes.plot([], [], color=f"C{number}", label=f"{depth:g} mm")
    axes.plot([-100, 100], [0, 0], "^", color="0.4", markersize=9, clip_on=False)
    axes.plot(0, 80, "v", color="0.4", markersize=9, clip_on=False)
    axes.set(xlabel="x (mm)", ylabel="y (mm)", xlim=(-126, 126), ylim=(-3, 83), aspect="equal")
    axes.legend(title="notch", loc="center right", frameon=False)
    save(figure, path)


if __name__ == "__main__":
    command(main, __doc__, "many_paths.png")
