"""Cyclic tension with compression in each cycle: Reinhardt's notched plate (Jefferson and Mihai 2015, Example 2, Figure
17).

The built-in scene `reinhardt-cyclic`, discrete and smeared: ten times opened a little further and closed to -3 MPa. The
stress is the reaction over the net area of 50 x 50 mm, the opening that of the gauge of 35 mm, so that both contain what
the paper plots. Its figure is not printed as numbers; the openings at which it unloads are assumed, and the cuts have no
width.

Expected:

- peak below ft = 3.2 MPa and above 3.0, the same in both models within 1 %;
- every reversal at -3 MPa within 0.1 %, the accuracy with which a stage finds its event;
- the area under the envelope, with the exponential tail beyond its end, Gf + ft^2 w/2E within 2 %;
- a reloading stiffness, from no stress to the envelope, that falls from cycle to cycle;
- unloading and reloading run on one curve, and beyond the last turn the stress is that of a plate that was never
  unloaded, within 1 % of the peak: contact causes no damage.

Platens that turn (`specimen.platens = "hinged"`) leave the ligament no moment, and a ligament that softens evenly is not
stable then. On the symmetric plate Newton's method stays on the even solution and the platens seem not to matter; with a
crack path that rises by 1 mm at a quarter of the ligament the crack opens from one side, and peak and area under the
curve fall.

    python -m examples.reinhardt [-o DIR]
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import trapezoid

from cohesive import Result, Scene, run
from cohesive.figures.drawing import new_figure, save
from cohesive.studies.curves import Pair, curve_of
from examples.command import command

Array = NDArray[np.float64]

TURNS = (0.015, 0.022, 0.030, 0.039, 0.048, 0.058, 0.068, 0.079, 0.090, 0.100)
END = 0.12
LOWER = -3.0
#: a path that is not symmetric
KINK = [[-25.0, 0.0], [-12.5, 1.0], [25.0, 0.0]]

CASES: dict[str, dict[str, Any]] = {
    "fixed": {"platens": "fixed"},
    "hinged": {"platens": "hinged"},
    "fixed, kinked": {"platens": "fixed", "kinked": True},
    "hinged, kinked": {"platens": "hinged", "kinked": True},
}
ONCE = [*(("discrete", name) for name in CASES), ("smeared", "fixed"), ("smeared", "hinged, kinked")]
CYCLIC = [("discrete", "fixed"), ("smeared", "fixed"), ("discrete", "hinged"), ("discrete", "hinged, kinked")]


@dataclass(frozen=True)
class Curve:
    """Stress (MPa) over the gauge's opening (mm), from the unloaded state.

    Attributes
    ----------
    stress : reaction over the net area
    normal : mean traction normal to the path, on which unloading ends; the reaction where the path is straight
    ends : (n, 2) jump at the left and the right end of the ligament, mm
    """

    opening: Array
    stress: Array
    normal: Array
    ends: Array

    @property
    def peak(self) -> float:
        """Largest stress, MPa."""
        return float(self.stress.max())

    @property
    def area(self) -> float:
        """Area under stress over opening, N/mm; for a curve without cycles."""
        return float(trapezoid(self.stress, self.opening))

    def reloading(self) -> Array:
        """Secant stiffness of each way back to the envelope, from no stress on, MPa/mm."""
        move = np.sign(np.diff(self.opening))
        turns = np.flatnonzero(move[1:] != move[:-1]) + 1
        found = []
        for low, high in zip(turns[1::2], [*turns[2::2], len(self.opening) - 1], strict=True):
            way = slice(low, high + 1)
            free = float(
                np.interp(
                    0.0, self.stress[way][: self.stress[way].argmax() + 1], self.opening[way][: self.stress[way].argmax() + 1]
                )
            )
            top = int(self.stress[way].argmax())
            found.append(self.stress[way][top] / (self.opening[way][top] - free))
        return np.array(found)

    def reversals(self) -> Array:
        """Normal stresses at which closing ends, MPa."""
        move = np.diff(self.opening)
        return self.normal[1:-1][(move[:-1] < 0) & (move[1:] > 0)]

    def first_time(self) -> tuple[Array, Array]:
        """Opening and stress wherever the opening is larger than ever before."""
        largest = np.maximum.accumulate(self.opening)
        rows = np.flatnonzero(np.r_[True, self.opening[1:] > largest[:-1] + 1e-9])
        return self.opening[rows], self.stress[rows]


def curve(result: Result) -> Curve:
    """The curve of a run: reaction over net area, over the gauge's opening."""
    specimen, history = result.scene.specimen, result.history
    net = (specimen.width - 2 * specimen.notch) * specimen.thickness  # type: ignore[attr-defined]
    ends = []
    for row in range(len(history["step"])):
        where, opening = result.opening_profile(row)
        ends.append([opening[where[:, 0].argmin()], opening[where[:, 0].argmax()]])
    return Curve(history["opening"], history["load"] / net, history["stress_n"], np.array(ends))


def plate(size: float, turns: Sequence[float], platens: str = "fixed", kinked: bool = False) -> Scene:
    """The scene with its mesh size, turns and platens; no turns: pulled apart without unloading."""
    scene = Scene.load("reinhardt-cyclic")
    rise, cycles, end = scene.data["stage"]
    stages = [{**rise, "steps": 60}]
    if turns:
        stages += [{**cycles, "to": list(turns)}, {**end, "to": END}]
    else:
        stages += [{"control": "opening", "to": END, "step": cycles["step"]}]
    scene = scene.with_(**{"mesh.crack_size": size, "output.frames": 0, "specimen.platens": platens}).with_(stage=stages)
    return scene.with_(**{"specimen.crack": KINK}) if kinked else scene


def main(size: float = 4.0, turns: Sequence[float] = TURNS, plot: Path | None = None) -> dict[str, float]:
    """Run the plate; print and return the numbers.

    Parameters
    ----------
    size : element size along the crack, mm.
    turns : openings at which it unloads, mm.
    plot : file for the figure.
    """
    numbers: dict[str, float] = {}
    cyclic: dict[tuple[str, str], Curve] = {}
    results: dict[str, Result] = {}
    once: dict[tuple[str, str], Curve] = {}
    print("pulled apart once:        peak (MPa)  area to 0.12 mm (N/mm)  ends of the ligament at 0.04 mm (mm)")
    for model, name in ONCE:
        once[model, name] = now = curve(run(plate(size, (), **CASES[name]), model))
        ends = [float(np.interp(0.04, now.opening, now.ends[:, i])) for i in (0, 1)]
        numbers |= {f"{model}, {name}: {key}": value for key, value in (("peak", now.peak), ("area", now.area))}
        numbers |= {f"{model}, {name}: {key} end": value for key, value in zip(("left", "right"), ends, strict=True)}
        print(f"{model + ', ' + name:26s}{now.peak:9.4f}{now.area:18.4f}{ends[0]:23.4f} and {ends[1]:.4f}")
    print(f"{len(turns)} cycles:                 peak (MPa)  reversals at (MPa)       from the curve above (% of the peak)")
    for model, name in CYCLIC:
        result = run(plate(size, turns, **CASES[name]), model)
        cyclic[model, name] = c = curve(result)
        if name == "fixed":
            results[model] = result
        opening, stress = c.first_time()
        back, above = c.reversals(), once[model, name]
        away = float(abs(stress - np.interp(opening, above.opening, above.stress)).max()) / above.peak
        numbers |= {
            f"{model}, {name}: reversals": float(len(back)),
            f"{model}, {name}: reversals off": float(abs(back / LOWER - 1.0).max()),
            f"{model}, {name}: from the envelope": away,
        }
        print(f"{model + ', ' + name:26s}{c.peak:9.4f}{back.min():13.4f} to {back.max():.4f}{100 * away:19.3f}")
    for model, result in results.items():
        envelope, m, width = once[model, "fixed"], result.scene.material, result.width
        energy = envelope.area + envelope.stress[-1] * m.Gf / m.ft
        off = energy / (m.Gf + m.ft**2 * width / (2 * m.E)) - 1.0
        stiffness, failed = cyclic[model, "fixed"].reloading(), int(result.history["cuts"].sum())
        numbers |= {
            f"{model}: Gf of the envelope": energy,
            f"{model}: Gf of the envelope off": off,
            f"{model}: cuts": float(failed),
        }
        numbers |= {f"{model}: reloading {i + 1}": float(k) for i, k in enumerate(stiffness)}
        print(
            f"{model}: area under the envelope and its tail {energy:.5f} N/mm, {100 * off:+.2f} % from Gf + ft^2 w/2E; "
            f"{failed} steps were cut; reloading stiffness (MPa/mm) " + ", ".join(f"{k:.0f}" for k in stiffness)
        )
    pair = Pair.from_curves(curve_of(results["discrete"]), curve_of(results["smeared"]))
    apart = pair.between() / pair.under(0)
    numbers["models apart"] = apart
    print(f"cycles: area between the models {100 * apart:.2f} % of the area under the curve")
    for model in ("discrete", "smeared"):
        now, even = once[model, "hinged, kinked"], once[model, "fixed"]
        parts = [100 * (a / b - 1) for a, b in ((now.peak, even.peak), (now.area, even.area))]
        print(f"{model}, hinged and kinked against fixed: peak {parts[0]:+.2f} %, area {parts[1]:+.2f} %")
    if plot is not None:
        _draw(cyclic, once, pair, plot)
    return numbers


def _draw(cyclic: dict[tuple[str, str], Curve], once: dict[tuple[str, str], Curve], pair: Pair, path: Path) -> None:
    figure = new_figure(13.0, 5.4)
    grid = figure.add_gridspec(2, 3, height_ratios=[2.4, 1.0])
    left, below = figure.add_subplot(grid[0, 0]), figure.add_subplot(grid[1, 0])
    middle, right = figure.add_subplot(grid[:, 1]), figure.add_subplot(grid[:, 2])
    travelled, gap = pair.difference()
    below.plot(travelled, gap / 2500.0, "C3", linewidth=0.8)
    below.axhline(0.0, color="0.5", linewidth=0.6)
    below.set(xlabel="opening travelled, forth and back (mm)", ylabel="smeared - discrete\n(MPa)")
    envelope, discrete, smeared = once["discrete", "fixed"], cyclic["discrete", "fixed"], cyclic["smeared", "fixed"]
    left.plot(envelope.opening, envelope.stress, color="0.8", linewidth=5.0, label="discrete, not unloaded")
    left.plot(discrete.opening, discrete.stress, "C0-", linewidth=2.0, label="discrete")
    left.plot(smeared.opening, smeared.stress, "C1--", linewidth=1.0, label="smeared")
    left.axhline(LOWER, color="0.5", linewidth=0.6, linestyle=":")
    left.set(title="ten cycles to -3 MPa, fixed platens")
    for model, style in (("discrete", "-"), ("smeared", "--")):
        for name, colour in (("fixed", "C0"), ("hinged, kinked", "C3")):
            now = once[model, name]
            label = "fixed" if name == "fixed" else "hinged, path kinked by 1 mm"
            middle.plot(now.opening, now.stress, style, color=colour, label=f"{label}, {model}")
    even = once["discrete", "hinged"]
    middle.plot(even.opening[::6], even.stress[::6], "k.", markersize=4, label="hinged, symmetric, discrete")
    middle.set(title="platens, not unloaded")
    for axes in (left, middle):
        axes.set(xlabel="opening of the gauge (mm)", ylabel="stress on the net section (MPa)")
    for name, colour in (("fixed", "C0"), ("hinged, kinked", "C3")):
        now = once["discrete", name]
        label = "fixed" if name == "fixed" else "hinged, kinked"
        right.plot(now.opening, now.ends[:, 1], color=colour, label=f"{label}: right end")
        right.plot(now.opening, now.ends[:, 0], "--", color=colour, label=f"{label}: left end")
    right.set(
        xlabel="opening of the gauge (mm)", ylabel="jump at the end of the ligament (mm)", title="discrete: does it turn?"
    )
    for axes in (left, middle, right):
        axes.axhline(0.0, color="0.5", linewidth=0.6)
        axes.legend(frameon=False, fontsize=8)
    save(figure, path)


if __name__ == "__main__":
    command(main, __doc__, "reinhardt.png")
