"""Both models on one scene: how far apart are the discrete crack and the crack band?"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from meshing import MeshError
from meshing.cracks import Line

from ..arrays import Array
from ..errors import NotConverged, SceneError
from ..results.files import make_folder, write_file, write_text
from ..results.report import warnings
from ..results.result import Result
from ..scenes.scene import Scene
from ..simulation import run
from ..solver.march import Step
from .curves import Pair, curve_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MODELS = ("discrete", "smeared")

_UNITS = {"peak": "N", "opening_at_peak": "mm", "energy": "N mm", "curve_distance": "", "iterations": "", "seconds": "s"}


class Comparison:
    """A discrete and a smeared run of one scene.

    Attributes
    ----------
    discrete, smeared : Result
    table : {quantity: {"discrete": , "smeared": , "relative_difference": }}, the difference that of the smeared value
        over the discrete one. peak (N), opening_at_peak (mm); energy (N mm), the area under load over opening to the
        common end; curve_distance, the area between the curves over the area under each, and over the mean of both;
        iterations; seconds, without files. Where a platen moves both ways, the curves are those of its load over its
        motion, and the energy is its work.
    notes : what stopped a run early, and what the runs say of themselves
    """

    def __init__(self, discrete: Result, smeared: Result, notes: list[str]) -> None:
        self.discrete, self.smeared, self.notes = discrete, smeared, notes
        results = {"discrete": discrete, "smeared": smeared}
        pair = self._pair = Pair.from_curves(curve_of(discrete), curve_of(smeared))
        energy = {name: pair.energy(i) for i, name in enumerate(MODELS)}
        under = {name: pair.under(i) for i, name in enumerate(MODELS)}
        between = pair.between()
        self.table: dict[str, dict[str, float]] = {
            "peak": _row({name: result.peak_load for name, result in results.items()}),
            "opening_at_peak": _row({name: result.opening_at_peak for name, result in results.items()}),
            "energy": _row(energy),
            "curve_distance": {name: _ratio(between, area) for name, area in under.items()}
            | {"relative_difference": _ratio(2 * between, sum(under.values()))},
            "iterations": _row({name: float(result.iterations) for name, result in results.items()}),
            "seconds": _row({name: result.solution_time for name, result in results.items()}),
        }

    def difference(self) -> tuple[Array, Array]:
        """Load of the smeared run less that of the discrete one (N) over what both have travelled (mm), see `travelled`."""
        return self._pair.difference()

    @property
    def by_platen(self) -> bool:
        """Whether the curves are drawn over the way of a platen that moves in two directions."""
        return self._pair.curves[0].platen is not None

    @property
    def travelled(self) -> str:
        """What the curves are drawn over."""
        if self.by_platen:
            return "way of the platen, there and back"
        there_and_back = bool((np.diff(self.discrete.history["opening"]) < 0).any())
        return "opening travelled, forth and back" if there_and_back else "opening"

    def profiles(self) -> list[tuple[str, dict[str, tuple[Array, Array]]]]:
        """Opening (mm) over the position along the crack path (mm) at three stages: the peak, half the peak load
        after it (or halfway to the end), and the end; fewer, where they coincide. A pair (title, {model: (position,
        opening)}) for each. In space the opening is the mean over the thickness; none for a crack without a path."""
        if self.discrete.model.mesh.points.shape[1] == 3 and not getattr(self.discrete.scene.specimen, "paths", None):
            return []
        s, opening, load = self._pair.upto_end(0)
        peak = int(load.argmax())
        fallen = np.flatnonzero(load[peak:] <= 0.5 * load[peak])
        middle = (
            s[peak + fallen[0]]
            if fallen.size and s[peak + fallen[0]] < 0.9 * self._pair.end
            else 0.5 * (s[peak] + self._pair.end)
        )
        found = []
        stages = [float(s[peak]), float(middle), self._pair.end]
        for at in (a for i, a in enumerate(stages) if all(abs(a - b) > 0.01 * self._pair.end for b in stages[:i])):
            title = f"opening {np.interp(at, s, opening):.3g} mm"
            found.append(
                (
                    title,
                    {
                        name: _profile(getattr(self, name), s[1:], at)
                        for name, s in zip(MODELS, self._pair.travelled, strict=True)
                    },
                )
            )
        return found

    def summary(self) -> str:
        """The printed table."""
        lines = [self.discrete.scene.title, f"{'':24s}{'discrete':>12s}{'smeared':>12s}{'difference':>12s}"]
        for name, row in self.table.items():
            unit = f" ({_UNITS[name]})" if _UNITS[name] else ""
            label = name.replace("_", " ") + unit
            values = "".join(f"{row[model]:12.5g}" for model in MODELS)
            lines.append(f"{label:24s}{values}{100 * row['relative_difference']:+11.2f}%")
        lines[5] = lines[5].replace("+", " ")  # a distance has no sign
        lines.append(
            f"up to the end that both runs reach, {self._pair.end:.4g} mm of {self.travelled}: energy and curve distance"
        )
        return "\n".join(lines + self.notes)

    def plot(self) -> Figure:
        """Both curves, their difference below, and opening profiles; a matplotlib figure."""
        from ..results.figures import comparison_figure

        return comparison_figure(self)

    def save(self, folder: str | Path) -> None:
        """Write comparison.csv and comparison.png; with each run's own files in the folders discrete and smeared.

        Raises
        ------
        SceneError
            If the folder cannot be written.
        """
        from ..results.figures import save

        folder = Path(folder)
        make_folder(folder)
        for name in MODELS:
            getattr(self, name).save(folder / name)
        head = "quantity,unit,discrete,smeared,relative_difference\n"
        rows = (
            f"{name},{_UNITS[name]},{row['discrete']:.9g},{row['smeared']:.9g},{row['relative_difference']:.9g}\n"
            for name, row in self.table.items()
        )
        text = head + "".join(rows)
        write_file(folder / "comparison.csv", lambda path: write_text(path, text))
        write_file(folder / "comparison.png", lambda path: save(self.plot(), path))


def compare(
    scene: Scene,
    output: str | Path | None = None,
    on_step: Callable[[Step, dict[str, float]], None] | None = None,
) -> Comparison:
    """Run a scene with zero-thickness interface elements and with the crack band.

    A run that stops early is compared as far as it came, and the notes say why it stopped. The band needs the whole
    body: `model.half` holds for the discrete run only.

    Parameters
    ----------
    scene : Scene; its model.kind does not matter.
    output : folder in whose subfolders discrete and smeared the histories grow during the runs.
    on_step : as in `run`.

    Raises
    ------
    SceneError, MeshError
        For bad input.
    NotConverged, KeyboardInterrupt
        Where not even one step of a run converged, and for an interruption, with the exception's `result` if there is
        one, and what was finished before it in `finished`. The same for SceneError and MeshError.
    """
    results: list[Result] = []
    notes: list[str] = []
    scenes = [scene.with_(**{"model.kind": "discrete"}), scene.with_(**{"model.kind": "smeared", "model.half": False})]
    if output is not None:
        make_folder(Path(output))
        for old in Path(output).glob("comparison.*"):  # of an earlier run into the same folder
            old.unlink()
    for name, one in zip(MODELS, scenes, strict=True):
        try:
            result = run(one, output=None if output is None else Path(output) / name, on_step=on_step)
        except (NotConverged, KeyboardInterrupt, SceneError, MeshError) as error:
            stopped = getattr(error, "result", None)
            error.finished = results  # type: ignore[union-attr]
            if not isinstance(error, NotConverged) or stopped is None or not len(stopped.history["step"]):
                raise
            result = stopped
        notes += [f"{name}: {note}" for note in (*result.notes, *warnings(result))]
        results.append(result)
    if scene.model.half:
        notes.append("smeared: the whole body; model.half holds for the discrete run only")
    return Comparison(results[0], results[1], notes)


def _row(values: dict[str, float]) -> dict[str, float]:
    return values | {"relative_difference": _ratio(values["smeared"] - values["discrete"], values["discrete"])}


def _ratio(value: float, over: float) -> float:
    return value / over if over else 0.0


def _profile(result: Result, s: Array, travelled: float) -> tuple[Array, Array]:
    """Positions along the path and openings, between the two rows around an opening travelled, s being that of the rows."""
    after = int(np.clip(np.searchsorted(s, travelled), 0, len(s) - 1))
    before = max(after - 1, 0)
    share = (travelled - s[before]) / (s[after] - s[before]) if s[after] > s[before] else 1.0
    where, late = result.opening_profile(after)
    early = result.opening_profile(before)[1]
    position = positions_along(where[:, :2], getattr(result.scene.specimen, "paths", []))
    opening = (1.0 - share) * early + share * late
    order = np.argsort(position, kind="stable")
    if where.shape[1] == 3 and result.model.cracks.rotations is not None:
        return _mean_over_thickness(position, opening)
    if result.model.is_smeared and result.model.cracks.rotations is None:  # off the path nearly every point is closed
        order = order[opening[order] > 0.01 * opening.max(initial=0.0)]
    return position[order], opening[order]


def _mean_over_thickness(position: Array, opening: Array) -> tuple[Array, Array]:
    """One opening for each position, in ascending order; positions that differ by rounding are one."""
    order = np.argsort(position, kind="stable")
    position, opening = position[order], opening[order]
    begin = np.flatnonzero(np.diff(position, prepend=-np.inf) > 1e-6 * np.ptp(position))
    return position[begin], np.add.reduceat(opening, begin) / np.diff(begin, append=len(opening))


def positions_along(points: Array, lines: list[Line]) -> Array:
    """Distance along the crack path of the nearest point of it; without a path, along the longer side of the points."""
    if not lines:
        span = np.ptp(points, axis=0)
        return np.asarray(points[:, span.argmax()] - points[:, span.argmax()].min())
    nearest, position, start = np.full(len(points), np.inf), np.zeros(len(points)), 0.0
    for line in lines:
        for a, b in pairwise(np.asarray(line, dtype=float)):
            length = float(np.hypot(*(b - a)))
            along = np.clip((points - a) @ (b - a) / length, 0.0, length)
            distance = np.hypot(*(points - a - along[:, None] * (b - a) / length).T)
            closer = distance < nearest
            nearest[closer], position[closer] = distance[closer], start + along[closer]
            start += length
    return position
