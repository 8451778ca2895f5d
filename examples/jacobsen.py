"""Opened, then opened and sheared: the mixed mode tests of Jacobsen et al. (Jefferson and Mihai 2015, Example 3, Figure
21).

The built-in scene `jacobsen-mixed-mode`, discrete and smeared, for the three openings un0 = 0.015, 0.025 and 0.040 mm at
which shearing begins. Mean shear and normal stress on the ligament of 40 x 75 mm over the relative displacements of the
gauge, 20 mm at the notch tips. The platen moves along d(un)/d(us) = tan(40 degrees); what the crack does is the gauge's
to say. Assumed: slits without width, the gauge, and the platen's motion as the one that keeps the ratio.

Beside it the law at a point on the nominal path: peak shear 1.34, 0.88 and 0.49 MPa with w = h = 20 mm (c_lm = 3).

Expected: shear falls as un0 grows; discrete and smeared within 1 %; the ligament's peak shear below that of the point,
because the crack does not follow the nominal path: what the plate is relieved of as the normal stress falls and turns to
compression goes into the opening. The law at a point on the path that the crack took gives the ligament's stresses within
1 %. Platens hinged at both ends leave no shear at all, by statics: the shear force on the plate's length needs a moment
at its ends.

    python -m examples.jacobsen [-o DIR]
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cohesive import Concrete, CrackPlane, Result, Scene, run
from cohesive.figures.drawing import new_figure, save
from examples.command import command

Array = NDArray[np.float64]

OPENINGS = (0.015, 0.025, 0.040)
RATIO = float(np.tan(np.radians(40.0)))


@dataclass(frozen=True)
class Run:
    """Mixed mode stage of a run; mm, MPa.

    Attributes
    ----------
    sliding, opening : of the gauge
    shear, normal : mean stresses on the ligament
    jump : (n, 2) mean opening and sliding of the crack itself
    path : (m, 2) the same from the unloaded state on
    start : opening of the gauge where the stage begins
    """

    sliding: Array
    opening: Array
    shear: Array
    normal: Array
    jump: Array
    path: Array
    start: float
    width: float

    @property
    def excess(self) -> Array:
        """Opening beyond that of the nominal path at the same sliding, mm."""
        return self.opening - (self.start + RATIO * self.sliding)


def nominal_path(un0: float, sliding: float = 0.5, points: int = 4000) -> Array:
    """Jumps (n, 2) of the nominal path: opened to un0, then opened and sheared."""
    opened = np.stack([np.linspace(0.0, un0, 400), np.zeros(400)], axis=1)
    us = np.linspace(0.0, sliding, points)
    return np.concatenate([opened, np.stack([un0 + RATIO * us, us], axis=1)])


def along(law: CrackPlane, path: Array) -> Array:
    """Tractions (n, 2) along a path of jumps (n, 2), from the intact state; all points at once."""
    reached = law.history(path, np.zeros(len(path)))  # by each jump alone
    return law.traction(path, np.maximum.accumulate(reached))[0]


def point_peak(concrete: Concrete, width: float, un0: float) -> float:
    """Largest shear traction at a point on the nominal path, MPa."""
    return float(along(CrackPlane(concrete, width), nominal_path(un0))[:, 1].max())


def mixed_mode(result: Result) -> Run:
    """The second stage of a run."""
    h = result.history
    start = int(np.flatnonzero(h["opening"] >= result.scene.stages[0].targets[-1] * (1 - 1e-6))[0])
    cracks = [result.fields.cell_values(row) for row in range(len(h["step"]))]
    path = np.array([[c["opening"].mean(), c["sliding"].mean()] for c in cracks])
    now = slice(start, None)
    return Run(
        h["sliding"][now], h["opening"][now], h["stress_s"][now], h["stress_n"][now],
        path[now], path, float(h["opening"][start]), float(result.width),
    )  # fmt: skip


def main(size: float = 3.0, openings: Sequence[float] = OPENINGS, plot: Path | None = None) -> dict[str, float]:
    """Run the plate for all openings, models and platens; print and return the numbers.

    Parameters
    ----------
    size : element size along the crack, mm.
    openings : un0, mm.
    plot : file for the figure.
    """
    scene = Scene.load("jacobsen-mixed-mode").with_(**{"mesh.crack_size": size, "output.frames": 0})
    concrete = scene.material
    numbers: dict[str, float] = {}
    runs: dict[tuple[str, float], Run] = {}
    head = f"{'peak shear':>11s}{'at sliding':>11s}{'opening':>9s}{'least normal':>13s}{'beyond nominal':>15s}"
    print(f"{'un0':>6s}  {'':26s}{head}")
    print(f"{'mm':>6s}  {'':26s}{'MPa':>11s}{'mm':>11s}{'mm':>9s}{'MPa':>13s}{'mm':>15s}")
    for un0 in openings:
        one = scene.with_(**{"stage.0.to": [0.003, un0]})
        for model in ("discrete", "smeared"):
            runs[model, un0] = now = mixed_mode(run(one, model))
            at = int(now.shear.argmax())
            print(
                f"{un0:6.3f}  {model + ', fixed':26s}{now.shear[at]:11.3f}{now.sliding[at]:11.3f}{now.opening[at]:9.4f}"
                f"{now.normal.min():13.3f}{now.excess[at]:15.4f}"
            )
            hinged = run(one.with_(**{"specimen.platens": "hinged"}), model).history
            print(f"{'':6s}  {model + ', hinged':26s}{abs(hinged['stress_s']).max():11.5f}")
            numbers |= {
                f"{model}, {un0:g}: peak shear": float(now.shear[at]),
                f"{model}, {un0:g}: least normal": float(now.normal.min()),
                f"{model}, {un0:g}: beyond nominal": float(now.excess[at]),
                f"{model}, {un0:g}: beyond nominal, largest": float(now.excess.max()),
                f"{model}, {un0:g}: hinged": float(abs(hinged["stress_s"]).max()),
            }
        crack = runs["discrete", un0]
        on_nominal = {w: point_peak(concrete, w, un0) for w in (concrete.h, crack.width)}
        # the law once more, led along what the crack and what the gauge did
        gauged = np.concatenate([nominal_path(un0)[:400], np.stack([crack.opening, crack.sliding], axis=1)])
        taken = {
            "the crack's path": float(along(CrackPlane(concrete, crack.width), crack.path)[:, 1].max()),
            "the gauge's path": float(along(CrackPlane(concrete, crack.width), gauged)[:, 1].max()),
        }
        for w, value in on_nominal.items():
            print(f"{'':6s}  {f'point, nominal, w = {w:g} mm':26s}{value:11.3f}")
            numbers[f"point, {un0:g}: w = {'h' if w == concrete.h else 'interface'}"] = value
        for name, value in taken.items():
            print(f"{'':6s}  {'point, ' + name:26s}{value:11.3f}")
            numbers[f"point, {un0:g}: {name}"] = value
    if plot is not None:
        _draw(concrete, runs, openings, plot)
    return numbers


def _draw(concrete: Concrete, runs: dict[tuple[str, float], Run], openings: Sequence[float], path: Path) -> None:
    figure = new_figure(13.0, 4.3)
    left, middle, right = figure.subplots(1, 3)
    for i, un0 in enumerate(openings):
        discrete, smeared, colour = runs["discrete", un0], runs["smeared", un0], f"C{i}"
        jumps = nominal_path(un0)
        point = along(CrackPlane(concrete, concrete.h), jumps)
        label = f"$u_{{n0}}$ = {un0:g} mm"
        left.plot(discrete.sliding, discrete.shear, color=colour, label=f"{label}, discrete")
        left.plot(smeared.sliding, smeared.shear, ".", color=colour, markersize=3, label="smeared")
        left.plot(jumps[400:, 1], point[400:, 1], ":", color=colour, label="point, nominal path")
        middle.plot(discrete.opening, discrete.normal, color=colour, label=f"{label}, discrete")
        middle.plot(smeared.opening, smeared.normal, ".", color=colour, markersize=3, label="smeared")
        middle.plot(jumps[400:, 0], point[400:, 0], ":", color=colour, label="point, nominal path")
        right.plot(discrete.sliding, 1e3 * discrete.excess, color=colour, label=f"{label}, gauge")
        jump = discrete.jump
        right.plot(
            jump[:, 1],
            1e3 * (jump[:, 0] - jump[0, 0] - RATIO * jump[:, 1]),
            "--",
            color=colour,
            label="mean jump of the crack",
        )
    left.set(
        xlabel="sliding of the gauge (mm)", ylabel="mean shear stress (MPa)", title="fixed platens: shear", xlim=(0.0, 0.4)
    )
    middle.set(xlabel="opening of the gauge (mm)", ylabel="mean normal stress (MPa)", title="normal", xlim=(0.0, 0.4))
    right.set(xlabel="sliding (mm)", ylabel="opening beyond $u_{n0}$ + tan(40°) sliding (µm)", xlim=(0.0, 0.4))
    right.set_title("discrete: path against the nominal one")
    for axes in (left, middle, right):
        axes.axhline(0.0, color="0.5", linewidth=0.6)
        axes.legend(frameon=False, fontsize=8)
    save(figure, path)


if __name__ == "__main__":
    command(main, __doc__, "jacobsen.png")
