"""A discrete and a smeared run of one scene, and the numbers that compare them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..arrays import Array
from ..outcome.result import Result
from ..results.files import make_folder, write_table
from ..results.report import DEPARTURE
from .curves import Pair, curve_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .figures import Profiles

MODELS = ("discrete", "smeared")

#: units of the table's quantities, but for the place of the peak
UNITS = {"peak": "N", "energy": "N mm", "dissipated": "N mm", "curve_distance": "", "iterations": "", "seconds": "s"}

#: models that lie further apart in peak or dissipated energy do not check each other; a part as large of an energy, a
#: compliance or the way is a cause
_VOID = 0.05


class Comparison:
    """A discrete and a smeared run of one scene, what compares them, a summary in words, the figure and the files.

    Attributes
    ----------
    discrete, smeared : Result
    measure : the measure in charge, a column of both histories, as "opening" or "cmod"
    table : {quantity: {"discrete": , "smeared": , "relative_difference": }}, the difference that of the smeared value
        over the discrete one. peak (N) and where it comes on the measure in charge, opening_at_peak, cmod_at_peak or
        driven_at_peak (mm); energy (N mm), the area under load over that measure to the common end; dissipated (N mm) up to
        there; curve_distance, the area between the curves over the area under each, and over the mean of both; iterations;
        seconds, without files. If a platen moves both ways, the curves are those of its load over its motion, and the energy
        is its work.
    notes : whether and why the comparison is void, what stopped a run early, and what the runs say of themselves
    """

    def __init__(self, discrete: Result, smeared: Result, notes: list[str]) -> None:
        self.discrete, self.smeared = discrete, smeared
        own = discrete.controlled  # a gauge that the band's mesh cannot place is none of its columns
        self.measure = own if own in smeared.history else smeared.controlled
        curves = {name: curve_of(run, self.measure) for name, run in self.runs.items()}
        pair = self._pair = Pair.from_curves(*curves.values())
        under = {name: pair.under(i) for i, name in enumerate(MODELS)}
        between = pair.between()
        self.table: dict[str, dict[str, float]] = {
            "peak": _row({name: run.peak_load for name, run in self.runs.items()}),
            f"{self.measure}_at_peak": _row({name: curve.at_peak for name, curve in curves.items()}),
            "energy": _row({name: pair.energy(i) for i, name in enumerate(MODELS)}),
            "dissipated": _row({name: self._dissipated(i) for i, name in enumerate(MODELS)}),
            "curve_distance": {name: _ratio(between, area) for name, area in under.items()}
            | {"relative_difference": _ratio(2 * between, sum(under.values()))},
            "iterations": _row({name: float(run.iterations) for name, run in self.runs.items()}),
            "seconds": _row({name: run.solution_time for name, run in self.runs.items()}),
        }
        self.notes = [*self._void(), *notes]

    @property
    def runs(self) -> dict[str, Result]:
        """Both runs by model."""
        return dict(zip(MODELS, (self.discrete, self.smeared), strict=True))

    @property
    def end(self) -> float:
        """What both runs have travelled (mm), see `travelled`; energy and curve distance are taken up to there."""
        return self._pair.end

    def _dissipated(self, i: int) -> float:
        """Energy that one of the runs has dissipated at the common end, N mm."""
        dissipated = (self.discrete, self.smeared)[i].history["dissipated"]
        return float(np.interp(self.end, self._pair.travelled[i], dissipated))

    def _void(self) -> list[str]:
        """A sentence if the models lie too far apart to check each other, with the causes that show."""
        far = []
        for name, least in (("peak", 0.0), ("dissipated", _VOID * (self.discrete.full_energy or 0.0))):
            row = self.table[name]
            if abs(row["smeared"] - row["discrete"]) > _VOID * max(row["discrete"], least):  # the first damage is no measure
                far.append(f"{name} {100 * row['relative_difference']:+.1f} %")
        if not far:
            return []
        discrete, smeared = self.discrete, self.smeared
        causes = []
        if smeared.fields.mesh.faces is None:
            causes.append("the band is no row of elements along the path")
        if (departure := smeared.facts.departure) > DEPARTURE:
            causes.append(f"the planes of the band depart from the path by {departure:.0f} degrees in the mean")
        if locking := smeared.fields.locking:
            causes.append(f"{' and '.join(locking)} elements lock in a band")
        if discrete.full_energy and smeared.full_energy and (by := smeared.full_energy / discrete.full_energy - 1.0) > _VOID:
            causes.append(f"the width of the band adds {100 * by:.1f} % to the energy of separation")
        if (by := discrete.facts.added_compliance) > _VOID:
            causes.append(f"the width of the interface adds {100 * by:.1f} % to the elastic compliance")
        if np.ptp([s[-1] for s in self._pair.travelled]) > _VOID * self.end:
            causes.append("one run ends before the other")
        if any(run.peak_row == run.steps for run in (discrete, smeared)):
            causes.append("a load still rises at the end")
        why = ", and ".join(causes) or "nothing of the models shows why, so that smaller elements and steps are to be tried"
        return [f"the comparison is void, smeared over discrete {', '.join(far)}: {why}"]

    def difference(self) -> tuple[Array, Array]:
        """Load of the smeared run less that of the discrete one (N) over what both have travelled (mm), see `travelled`.

        The result is (travelled, difference), (n,) each."""
        return self._pair.difference()

    @property
    def travelled(self) -> str:
        """What the curves are drawn over."""
        if self.discrete.facts.has_platen:
            return "travel of the platen, there and back"
        there_and_back = bool((np.diff(self.discrete.history[self.measure]) < 0).any())
        return f"{self.measure} travelled, forth and back" if there_and_back else self.measure

    def profiles(self) -> Profiles:
        """Openings (mm) over the position along the crack path (mm) in both models at three stages.

        The stages are the peak, half the peak load after it (or halfway to the end), and the end; fewer if they coincide.
        In 3D the opening is the mean over the thickness; a crack without a path has no profiles.
        """
        if self.discrete.fields.mesh.dimension == 3 and not self.discrete.scene.specimen.paths:
            return []
        s, x, _ = self._pair.upto_end(0)
        profiles = []
        for at in self._stages():
            by_model = {
                name: _profile(run, s, at) for (name, run), s in zip(self.runs.items(), self._pair.travelled, strict=True)
            }
            profiles.append((f"{self.measure} {np.interp(at, s, x):.3g} mm", by_model))
        return profiles

    def _stages(self) -> list[float]:
        """What is travelled to the stages of `profiles`, mm."""
        (s, _, load), end = self._pair.upto_end(0), self.end
        peak = int(load.argmax())
        fallen = np.flatnonzero(load[peak:] <= 0.5 * load[peak])
        has_fallen = fallen.size and s[peak + fallen[0]] < 0.9 * end
        middle = s[peak + fallen[0]] if has_fallen else 0.5 * (s[peak] + end)
        stages = [float(s[peak]), float(middle), end]
        return [a for i, a in enumerate(stages) if all(abs(a - b) > 0.01 * end for b in stages[:i])]

    def summary(self) -> str:
        """The printed table."""
        lines = [self.discrete.scene.title, f"{'':24s}{'discrete':>12s}{'smeared':>12s}{'difference':>12s}"]
        for name, row in self.table.items():
            unit = f" ({unit})" if (unit := UNITS.get(name, "mm")) else ""
            values = "".join(f"{row[model]:12.5g}" for model in MODELS)
            sign = "" if name == "curve_distance" else "+"  # a distance has none
            lines.append(f"{name.replace('_', ' ') + unit:24s}{values}{100 * row['relative_difference']:{sign}11.2f}%")
        lines.append(f"up to the end that both runs reach, {self.end:.4g} mm of {self.travelled}: energy and curve distance")
        return "\n".join(lines + self.notes)

    def plot(self) -> Figure:
        """Both curves, their difference below, and opening profiles; a matplotlib figure."""
        from .figures import comparison_figure  # with matplotlib, which is slow to import

        return comparison_figure(self.runs, self.measure, self.difference(), self.travelled, self.profiles())

    def save(self, folder: str | Path) -> None:
        """Write comparison.csv and comparison.png; with each run's own files in the folders discrete and smeared.

        Raises
        ------
        SceneError
            If the folder cannot be written.
        """
        from ..figures.drawing import save, write_figure  # with matplotlib

        folder = Path(folder)
        make_folder(folder)
        for name, result in self.runs.items():
            result.save(folder / name)
        names = (*MODELS, "relative_difference")
        rows = ([name, UNITS.get(name, "mm"), *(f"{row[each]:.9g}" for each in names)] for name, row in self.table.items())
        write_table(folder / "comparison.csv", ["quantity", "unit", *names], rows)
        output = next(iter(self.runs.values())).scene.output
        write_figure(folder / "comparison.png", lambda path: save(self.plot(), path, output), output)


def _row(values: dict[str, float]) -> dict[str, float]:
    return values | {"relative_difference": _ratio(values["smeared"] - values["discrete"], values["discrete"])}


def _ratio(value: float, over: float) -> float:
    return value / over if over else 0.0


def _profile(data: Result, travelled: Array, at: float) -> tuple[Array, Array]:
    """Positions along the path and openings when `at` is travelled, between the two rows around it; `travelled` (rows,)."""
    fields = data.fields
    kept = fields.point_rows
    place = int(np.clip(np.searchsorted(travelled[kept], at), 0, len(kept) - 1))
    before, after = kept[max(place - 1, 0)], kept[place]
    step = travelled[after] - travelled[before]
    share = (at - travelled[before]) / step if step > 0 else 1.0
    position = data.profile_distance()
    where, late = data.opening_profile(after)
    opening = (1.0 - share) * data.opening_profile(before)[1] + share * late
    if where.shape[1] == 3 and fields.mesh.faces is not None:
        return _mean_over_thickness(position, opening)
    if fields.mesh.faces is None:  # off the path nearly every point is closed
        shown = opening > 0.01 * opening.max(initial=0.0)
        return position[shown], opening[shown]
    return position, opening


def _mean_over_thickness(position: Array, opening: Array) -> tuple[Array, Array]:
    """One opening for each position of those in ascending order; positions that differ by rounding are one."""
    begin = np.flatnonzero(np.diff(position, prepend=-np.inf) > 1e-6 * np.ptp(position))
    return position[begin], np.add.reduceat(opening, begin) / np.diff(begin, append=len(opening))
