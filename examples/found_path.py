"""A path that is found: which way does a crack go, and who leads it?

Four pictures. The built-in beam with its notch 18 mm off mid-span, as in `crack_that_bends`, but with crack = "grow": the
path is found segment by segment, from the stress ahead of the tip in the state in which the tip is due. Beside it the smeared
model of the same beam, in which a crack may form in every element (band.where = "everywhere"): its open planes are drawn
on the found path. Then a beam with two notches side by side, from each of which a crack grows, and the panel of
Nooru-Mohamed's load path 4a: notched on both sides, sheared to 5 kN, then pulled apart.

Expected: the found path leans towards the load, and its peak is below that of the straight one; the cracks of two notches
lean towards each other. Those of the panel curve round each other, as its specimens cracked. The smeared cracks turn with the
elements that they run through.

    python -m examples.found_path [-o DIR]
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cohesive import Result, Scene, run
from cohesive.figures.drawing import new_figure, save
from cohesive.figures.found_path import draw_path
from examples.command import command

Array = NDArray[np.float64]
NOTCH = 18.0  # mm from mid-span


@dataclass(frozen=True)
class Found:
    """What the example shows.

    Attributes
    ----------
    straight, found, smeared : peaks of the beam, N
    path, pair, panel : the found path, the two that attract each other and the two of the panel, mm
    planes, along : of the open crack planes of the smeared model: places (n, 2), mm, and directions (n, 2)
    seconds : of the search
    """

    straight: float
    found: float
    smeared: float
    path: Array
    pair: list[Array]
    panel: list[Array]
    planes: Array
    along: Array
    seconds: float


def two_notches(size: float, apart: float = 20.0) -> Scene:
    """A beam like the built-in one with two notches, as a user outline."""
    beam = Scene.load("notched-beam")
    specimen = {
        "kind": "outline",
        "thickness": 50.0,
        "corners": [[-87.5, 0.0], [87.5, 0.0], [87.5, 50.0], [-87.5, 50.0]],
        "notches": [[[x, 0.0], [x, 12.5]] for x in (-apart / 2, apart / 2)],
        "supports": [
            {"at": [-62.5, 0.0], "direction": [0.0, 1.0]},
            {"at": [-62.5, 0.0], "direction": [1.0, 0.0]},
            {"at": [62.5, 0.0], "direction": [0.0, 1.0]},
        ],
        "drive": {"at": [0.0, 50.0], "direction": [0.0, -1.0]},
        "gauge_minus": [-20.0, 0.0],
        "gauge_plus": [20.0, 0.0],
        "crack": "grow",
    }
    stage = [{"control": "opening", "to": 0.08, "steps": 40}]
    data = {"specimen": specimen, "material": beam.data["material"], "stage": stage, "output": {"frames": 0}}
    return Scene({**data, "title": "Two notches", "mesh": {"crack_size": size, "far_size": 8.0}})


def open_planes(result: Result) -> tuple[Array, Array]:
    """Places and directions of the crack planes of a smeared model that are open."""
    planes = result.fields.planes.of(result.steps)
    is_open = planes.opening > 0.05 * planes.opening.max()
    return result.fields.where[planes.point[is_open]], planes.normal[is_open][:, ::-1] * [-1.0, 1.0]


def main(size: float = 1.0, plot: Path | None = None) -> Found:
    """Find the paths; print and return what they show.

    Parameters
    ----------
    size : length of the elements on the crack, mm.
    plot : file for the figure.
    """
    beam = Scene.load("notched-beam").with_(
        **{"specimen.notch_position": NOTCH, "mesh.crack_size": size, "output.frames": 0},
        stage=[{"control": "opening", "to": 0.2, "steps": 40}],
    )
    straight = run(beam)
    grown = run(beam.with_(**{"specimen.crack": "grow"}))
    changes = {"model.kind": "smeared", "band.where": "everywhere", "mesh.crack_size": 2.5 * size, "stage.0.steps": 20}
    smeared = run(grown.scene.with_(**changes, **{"mesh.shape": "quad", "stage.0.to": 0.1}))
    pair = run(two_notches(size))
    sizes = {"mesh.crack_size": 2.5 * size, "output.frames": 0}
    panel = run(Scene.load("nooru-mohamed-4a").with_(**{"specimen.crack": "grow"}, **sizes))
    assert grown.found is not None
    where, along = open_planes(smeared)
    found = Found(
        straight.peak_load, grown.peak_load, smeared.peak_load, grown.path, pair.paths, panel.paths, where, along,
        grown.found.seconds,
    )  # fmt: skip
    print("\n".join(note for note in grown.notes if note.startswith("path")))
    print(f"peak: straight {found.straight:.1f} N, found {found.found:.1f} N, smeared everywhere {found.smeared:.1f} N")
    if plot is not None:
        _draw(grown, pair, panel, found, plot)
    return found


def _draw(grown: Result, pair: Result, panel: Result, found: Found, path: Path) -> None:
    figure = new_figure(14.0, 4.2)
    panels = figure.subplots(1, 4)
    beam, square = ((-30.0, 40.0), (-2.0, 52.0)), ((-105.0, 105.0), (-105.0, 105.0))
    for axes, result, title, (xlim, ylim) in zip(
        panels,
        (grown, grown, pair, panel),
        ("found segment by segment", "smeared, cracks everywhere", "two notches", "sheared, then pulled"),
        (beam, beam, beam, square),
        strict=True,
    ):
        assert result.found is not None
        draw_path(axes, result.found)
        axes.set(title=title, xlabel="x (mm)", ylabel="y (mm)", xlim=xlim, ylim=ylim)
        axes.set_aspect("equal")
    ends = np.stack([found.planes - 0.6 * found.along, found.planes + 0.6 * found.along])
    panels[1].plot(*ends.transpose(2, 0, 1), color="C2", linewidth=0.7, label="open crack planes")
    handles, labels = panels[1].get_legend_handles_labels()
    kept = dict(zip(labels, handles, strict=True))
    figure.legend(kept.values(), kept.keys(), loc="outside lower center", ncols=6, frameon=False, fontsize=8)
    save(figure, path)


if __name__ == "__main__":
    command(main, __doc__, "found_path.png")
