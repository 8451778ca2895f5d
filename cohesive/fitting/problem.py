"""The residuals of a fit and their Jacobian."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from meshing.errors import MeshError

from ..arrays import Array
from ..errors import NotConverged, ParameterError, SceneError, TooCostly
from ..solver.columns import LOAD_RATIO
from ..solver.controls import control_of
from ..solver.events import Event, tolerance
from ..solver.stages import Stage
from .data import Data
from .noise import Noise, weighed
from .parameters import Varied
from .repeated_run import RepeatedRun, Rows

#: what a run with numbers that make no sense may end in
FAILURES = (NotConverged, TooCostly, SceneError, MeshError, ParameterError, ValueError)

#: iterations that a run may take for each of its steps, and at least
_ITERATIONS, _LEAST = 8, 200

#: openings at which a run stands that could not go by the measured motion, over the furthest one
_OPENINGS = np.geomspace(1e-4, 2.0, 70)

#: relative change of the rows of a run for the derivative of what is interpolated between them
_AT_ROWS = 1e-6

#: relative change for the derivative in a number that is not of the material
_OF_A_MESH = 1e-3


@dataclass
class FitEvaluation:
    """The residuals at some numbers.

    Attributes
    ----------
    z : (m,) array, the numbers as the optimiser sees them
    loads : computed loads at the measured rows of each scene, N
    residuals : (p,) array over the pieces of all scenes, over the largest measured load
    rows : of each scene
    slopes : derivatives of the loads of some scenes in the scaled numbers, by the index of the scene, as far as asked for
    """

    z: Array
    loads: list[Array]
    residuals: Array
    rows: list[Rows]
    slopes: dict[int, Array] = field(default_factory=dict)


@dataclass
class FitProblem:
    """Scenes, data and varied numbers.

    Attributes
    ----------
    repeated : one for each scene
    data : its measured rows
    parameters : what is varied
    stages : of each scene, with the measured places as targets
    noises : of each scene, once `weigh` has told them; else None
    """

    repeated: Sequence[RepeatedRun]
    data: Sequence[Data]
    parameters: Sequence[Varied]
    stages: list[list[Stage]] = field(init=False)
    noises: list[Noise | None] = field(init=False)
    _last: FitEvaluation | None = field(default=None, init=False)

    def __post_init__(self) -> None:
        self.noises = [None] * len(self.data)
        self.stages = [stages_at(repeated.scene.stages, data) for repeated, data in zip(self.repeated, self.data, strict=True)]
        for repeated, stages in zip(self.repeated, self.stages, strict=True):
            repeated.most = max(_LEAST, round(_ITERATIONS * sum(_steps(stage) for stage in stages)))

    @property
    def start(self) -> Array:
        """The first numbers, (m,), scaled."""
        return np.array([each.scaled(each.start) for each in self.parameters])

    def values(self, z: Array, scene: int) -> dict[str, float]:
        """The numbers of a scene by their keys; those of its measured curves are none of its model."""
        both = zip(self.parameters, z, strict=True)
        return {each.key: each.value(float(at)) for each, at in both if scene in each.scenes and each.curve is None}

    def offsets(self, z: Array, scene: int) -> Array:
        """What is taken off x of each curve of a scene, mm."""
        offsets = np.array([curve.x_offset for curve in self.data[scene].curves])
        for each, at in zip(self.parameters, z, strict=True):
            if each.curve is not None and scene in each.scenes:
                offsets[each.curve] = each.value(float(at))
        return offsets

    def rows(self, z: Array, scene: int) -> Data:
        """The measured rows of a scene, their x counted from the offsets."""
        data = self.data[scene]
        further = self.offsets(z, scene) - [curve.x_offset for curve in data.curves]
        return replace(data, x=data.x - further[data.curve]) if further.any() else data

    def by_name(self, z: Array) -> dict[str, float]:
        """All numbers by their names."""
        return {each.name: each.value(float(at)) for each, at in zip(self.parameters, z, strict=True)}

    def evaluate(self, z: Array) -> FitEvaluation:
        """The residuals at some numbers.

        Raises
        ------
        One of FAILURES
        """
        if self._last is not None and np.array_equal(self._last.z, z):
            return self._last
        rows = [self._run(i, z) for i in range(len(self.repeated))]
        loads = [at_rows(each, self.rows(z, i))[0] for i, each in enumerate(rows)]
        residuals = [data.residuals(load) for load, data in zip(loads, self.data, strict=True)]
        self._last = FitEvaluation(z.copy(), loads, np.concatenate(residuals), rows)
        return self._last

    def weigh(self, evaluation: FitEvaluation) -> bool:
        """Weigh the rows of each scene by the noise that its residuals show; whether any shows some."""
        for i, load in enumerate(evaluation.loads):
            slope = at_rows(evaluation.rows[i], self.rows(evaluation.z, i))[1]
            if (found := weighed(self.data[i], load, slope, len(evaluation.z))) is not None:
                self.data = [*self.data[:i], found[0], *self.data[i + 1 :]]
                self.noises[i] = found[1]
        residuals = [data.residuals(load) for load, data in zip(evaluation.loads, self.data, strict=True)]
        self._last = replace(evaluation, residuals=np.concatenate(residuals))
        return any(self.noises)

    def stages_of(self, z: Array, scene: int) -> list[Stage]:
        """The stages of a scene; its targets move with the offsets of its curves."""
        data = self.rows(z, scene)
        return self.stages[scene] if data is self.data[scene] else stages_at(self.repeated[scene].scene.stages, data)

    def _run(self, i: int, z: Array) -> Rows:
        """A run of a scene; if its crack snaps under the measured motion, by its opening, which goes on."""
        repeated, stages, data, values = self.repeated[i], self.stages_of(z, i), self.data[i], self.values(z, i)
        try:
            return repeated.run(values, stages)
        except (NotConverged, TooCostly):
            if stages == list(repeated.scene.stages) or data.against == "opening":
                raise
            furthest = float(data.x.max())
            targets = [float(each) for each in furthest * _OPENINGS]
            until = stages[0].until or {data.against: furthest}
            return repeated.run(values, [replace(stages[0], control="opening", to=targets, steps=1, step=None, until=until)])

    def rms(self, evaluation: FitEvaluation) -> float:
        """Root of the mean square of the residuals of all rows, over the largest measured load of their scene."""
        gaps = [data.gap(load)[0] for load, data in zip(evaluation.loads, self.data, strict=True)]
        return float(np.sqrt(np.mean(np.concatenate(gaps) ** 2)))

    def residuals(self, z: Array) -> Array:
        """The residuals, (p,); NaN if there is no run with these numbers, which the optimiser takes for a step too far."""
        try:
            return self.evaluate(z).residuals
        except FAILURES:
            return np.full(sum(data.count for data in self.data), np.nan)

    @property
    def loss(self) -> str:
        """That of all scenes; of scenes that differ theirs, joined by "and"."""
        return " and ".join(dict.fromkeys(data.loss for data in self.data))

    def jacobian(self, z: Array) -> Array:
        """Derivatives of the residuals in the scaled numbers, (p, m)."""
        evaluation = self.evaluate(z)
        each = enumerate(zip(self.data, evaluation.loads, strict=True))
        return np.concatenate([data.jacobian(load, self.slopes(i, evaluation)) for i, (data, load) in each])

    def slopes(self, i: int, evaluation: FitEvaluation) -> Array:
        """Derivatives of the computed loads of a scene at its measured rows in the scaled numbers, (n, m), N."""
        if i in evaluation.slopes:
            return evaluation.slopes[i]
        z = evaluation.z
        repeated, data, rows, values = self.repeated[i], self.data[i], evaluation.rows[i], self.values(z, i)
        data = self.rows(z, i)
        mine = [j for j, each in enumerate(self.parameters) if i in each.scenes and each.curve is None]
        exact = [j for j in mine if repeated.is_exact([self.parameters[j].key], rows.scene.stages)]
        slopes = np.zeros((len(data.x), len(z)))
        if exact:
            keys = [self.parameters[j].key for j in exact]
            columns = repeated.derivatives(rows, values, keys, energies=data.against not in ("load", "opening", "driven"))
            for j, key in zip(exact, keys, strict=True):
                slopes[:, j] = at_rows(rows, data, columns[key])[1]
        for j in set(mine) - set(exact):
            key = self.parameters[j].key
            half = _OF_A_MESH * (abs(values[key]) or 1.0)
            runs = (repeated.run({**values, key: values[key] + by}, rows.scene.stages) for by in (-half, half))
            low, high = (at_rows(each, data)[0] for each in runs)
            slopes[:, j] = (high - low) / (2.0 * half)
        for j, each in enumerate(self.parameters):
            if each.curve is not None and i in each.scenes:
                slopes[:, j] = np.where(data.curve == each.curve, -at_rows(rows, data)[1], 0.0)
        evaluation.slopes[i] = slopes * np.array([each.slope(float(at)) for each, at in zip(self.parameters, z, strict=True)])
        return evaluation.slopes[i]


def _steps(stage: Stage) -> float:
    """Number of steps of a stage if none is cut."""
    return sum(stage.count(abs(length)) for length in np.diff([0.0, *stage.targets])) * (2.0 if stage.unload else 1.0)


def stages_at(stages: Sequence[Stage], data: Data) -> list[Stage]:
    """The stages of a scene with the measured places as targets, if it is loaded once and they can be prescribed.

    Else they stay, and loads between two rows are interpolated, with derivatives to match.
    """
    first = stages[0]
    monotonic = len(stages) == 1 and first.unload is None and np.all(np.diff([0.0, *first.targets]) > 0)
    if not monotonic or not control_of(data.against).is_motion:
        return list(stages)
    targets = data.targets()
    step = max(targets) / first.count(max(targets)) if first.step is None or first.control != data.against else first.step
    return [replace(first, control=data.against, to=targets, steps=None, step=step)]


def at_rows(rows: Rows, data: Data, rates: Mapping[str, Array] | None = None) -> tuple[Array, Array]:
    """Load at the measured rows, (n,), N, and its slope in x, N/mm, or with the derivatives of a history its own derivative.

    Between the rows of the run by Akima's piecewise cubic, which does not overshoot at a kink; beyond the end the last one,
    and below 0, where noise or seating puts rows, on the initial tangent. If an event has ended the run, the end moves along.

    Raises
    ------
    NotConverged
        If the run has not moved on.
    """
    from scipy.interpolate import Akima1DInterpolator  # slow to import

    until, against = rows.scene.stages[-1].until, data.against
    furthest = np.maximum.accumulate(np.r_[0.0, rows.history[against]])
    first = np.flatnonzero(np.diff(furthest, prepend=-1.0) > 10.0 * _AT_ROWS * furthest[-1])  # none overtakes the next one
    if len(first) < 2:
        raise NotConverged(f"{against} never grows, in which the measured curve is given")

    def at(by: float) -> tuple[Array, Array]:
        moved = rows.history if rates is None else {name: old + by * rates[name] for name, old in rows.history.items()}
        x, y = (np.r_[0.0, moved[name]][first] for name in (against, "load"))
        end = x[-1] if until is None else _end(until, moved, x[-1], against)
        curve, place = Akima1DInterpolator(x, y), np.clip(data.x, x[0], end)
        slope = curve(place, 1, extrapolate=True)
        load = curve(place, extrapolate=True) + slope * np.minimum(data.x - x[0], 0.0)
        return np.asarray(load), np.asarray(np.where(data.x > end, 0.0, slope))

    load, slope = at(0.0)
    if rates is None:
        return load, slope
    sizes = [float(abs(rates[name]).max()) / float(abs(rows.history[name]).max()) for name in (against, "load")]
    half = _AT_ROWS / max(*sizes, 1e-300)
    return load, (at(half)[0] - at(-half)[0]) / (2.0 * half)


def _end(until: Event, history: Mapping[str, Array], last: float, against: str) -> float:
    """Where a run passes the event that ended it; where it ended if it did not come so far."""
    ((name, value),) = until.items()
    q = history["load"] / history["load"].max() if name == LOAD_RATIO else history[name]
    if len(q) < 2 or q[-1] == q[-2] or abs(q[-1] - value) > 2.0 * tolerance(value, q[-2]):
        return last
    return float(last + (value - q[-1]) * (history[against][-1] - history[against][-2]) / (q[-1] - q[-2]))
