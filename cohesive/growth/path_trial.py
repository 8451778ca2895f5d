"""One run along trial paths, watched from the tips: the first state in which each is critical."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from meshing.paths import Line, Point, along_paths, path_length

from ..arrays import Array
from ..errors import NotConverged
from ..model.build import build
from ..model.model import Model
from ..scenes.scene import Scene
from ..solver.controls import control_of
from ..solver.stages import Stage
from ..solver.stepper import solve
from .crack import unit
from .stress import NodalStress, Probe, Reading

#: a tip is critical when the averaged hoop stress ahead of it reaches this part of the tensile strength: the cohesive zone
#: that goes on straight ahead keeps it from reaching all of it
CRITICAL = 0.9

#: or where it is largest, if that is more than this part: a path that goes the right way is relieved by its cohesive zone
NEARLY_CRITICAL = 0.6

#: the largest one is passed when the stress has fallen to this part of it
_FALLEN = 0.97

#: tips whose stress has come so near to that of the first one grow with it
_TOGETHER = 0.97

#: steps of a trial up to shortly before a tip will be critical, as the tip before or the elastic stress tells
_RUN_UP, _SHORTLY_BEFORE = 6, 0.6

#: factor from one step to the next from there on: steps that follow the tip, not the stage, whose first one may pass the peak
_FACTOR = 1.12

#: a path whose mean jump falls below this part of the largest one closes
_CLOSES = 0.9

#: of the last target: a first step that is elastic
_ELASTIC = 1e-4


@dataclass(frozen=True)
class TipState:
    """What a tip sees in a state of the body.

    Attributes
    ----------
    reading : Reading ahead of the tip
    stress : largest averaged hoop stress there, MPa
    load, opening : N, mm
    control : what the stage controls
    slide : sliding over opening close behind the tip; nan where nothing is open
    """

    reading: Reading
    stress: float
    load: float
    opening: float
    control: float
    slide: float

    def towards(self, other: TipState, share: float) -> TipState:
        """A state between two."""
        pairs = [(getattr(self, name), getattr(other, name)) for name in ("stress", "load", "opening", "control", "slide")]
        return TipState(self.reading.towards(other.reading, share), *(a + share * (b - a) for a, b in pairs))


@dataclass
class PathTrial:
    """A run along trial paths.

    Attributes
    ----------
    lines : the paths
    probes : one ahead of each tip
    critical : of each tip; None: it was never critical
    at_peak : reading ahead of each tip at the largest load
    peak : the largest load, N
    openings : (states, 1 + paths) opening that is measured, then the mean jump of each path, mm
    timings : seconds of meshing, condensing, and finding the elements ahead of the tips
    is_whole : whether it ran to the end, for all tips
    ended : why the run ended early; empty if it did not
    """

    lines: list[Line]
    probes: list[Probe]
    critical: list[TipState | None]
    at_peak: list[Reading]
    peak: float = 0.0
    is_whole: bool = False
    ended: str = ""
    openings: list[list[float]] = field(default_factory=list)
    timings: dict[str, float] = field(default_factory=dict)

    def closing(self) -> dict[int, float]:
        """Paths that close while another one opens, by their numbers, and the opening from which on, mm."""
        if len(self.lines) < 2 or not self.openings:
            return {}
        measured, *means = np.array(self.openings).T
        widest = [int(mean.argmax()) for mean in means]
        opens = {i for i, mean in enumerate(means) if mean[-1] > _CLOSES * mean.max()}
        return {i: float(measured[at]) for i, at in enumerate(widest) if i not in opens and opens}


def run_trial(
    scene: Scene, lines: list[Line], tips: Sequence[tuple[Point, float]], radius: float, largest_turn: float,
    first_only: bool, before: float | None = None,
) -> PathTrial:  # fmt: skip
    """Run a scene along trial paths until its tips are critical.

    Parameters
    ----------
    lines : paths of all cracks
    tips : points of the paths and the headings (radians) there
    radius, largest_turn : see `Probe`
    first_only : end with the state in which the first tip is critical
    before : what the first stage controls when the tip before was critical
    """
    scene = scene.along(lines)
    model = build(scene)
    clock = time.perf_counter()
    stress = NodalStress.from_blocks(model.bulk)
    probes = [Probe.from_tip(stress, tip, heading, radius) for tip, heading in tips]
    nothing = [probe.nothing for probe in probes]
    trial = PathTrial(lines, probes, [None] * len(tips), nothing, is_whole=not first_only)
    condensing = model.timings["assemble"] + model.timings["condense"]
    trial.timings = {"meshing": model.timings["mesh"], "condensing": condensing, "probing": time.perf_counter() - clock}
    _march(trial, model, scene, before, largest_turn)
    return trial


def _march(trial: PathTrial, model: Model, scene: Scene, before: float | None, largest_turn: float) -> None:
    """Fill a trial step by step."""
    ft = scene.material.ft
    seen: list[list[TipState]] = [[] for _ in trial.probes]
    try:
        stages = _stages(trial, model, scene, before)
        for new in _states(trial, model, stages, scene, largest_turn):
            for states, state in zip(seen, new, strict=True):
                states.append(state)
            pending = [i for i, critical in enumerate(trial.critical) if critical is None]
            due = {i: critical for i in pending if (critical := _due(seen[i], ft))}
            for i, critical in due.items():
                trial.critical[i] = critical
            if due and not trial.is_whole:  # with the first one go those that are nearly as near
                first = min(due, key=lambda i: due[i].control)
                for i, states in enumerate(seen):
                    then = min(states, key=lambda state: abs(state.control - due[first].control))
                    trial.critical[i] = due[i] if i in due else then if then.stress >= _TOGETHER * due[first].stress else None
                return
            if all(trial.critical):
                return
    except NotConverged as error:
        trial.ended = str(error)
    for i, states in enumerate(seen):
        trial.critical[i] = trial.critical[i] or _due([*states, replace(states[-1], stress=0.0)] if states else [], ft)


def _states(
    trial: PathTrial, model: Model, stages: Sequence[Stage], scene: Scene, largest_turn: float
) -> Iterator[list[TipState]]:
    """What the tips of a trial see in one state after the other; it keeps the readings at the peak."""
    control = control_of(scene.stages[0].control)
    stepper = solve(model.problem, stages, model.recorded, scene.solver.step_growth)
    ends = np.cumsum([path_length("crack", [line]) for line in trial.lines])
    owner = np.searchsorted(ends[:-1], along_paths(model.cracks.where, trial.lines))
    for step in stepper:
        record = stepper.record(step.equilibrium.state)
        displacement = model.condensation.recover(step.equilibrium.state.v)
        numbers = record["load"], record["opening"], control.value(stepper.problem, step.equilibrium.state)
        values = model.cracks.point_values(step.equilibrium.state)
        trial.openings.append([record["opening"], *(np.bincount(owner, values["opening"]) / np.bincount(owner))])
        readings = [probe.read(displacement) for probe in trial.probes]
        if abs(record["load"]) > trial.peak:  # of either sign: what is pushed may split
            trial.peak, trial.at_peak = abs(record["load"]), readings
        yield [
            TipState(reading, probe.strongest(reading, largest_turn)[1], *numbers, _slide(probe, model.cracks.where, values))
            for probe, reading in zip(trial.probes, readings, strict=True)
        ]


def _due(states: list[TipState], ft: float) -> TipState | None:
    """The state in which a tip becomes critical: its stress reaches .9 ft, or else is largest, between the states; None if it
    is not yet known to be."""
    if not states:
        return None
    target, new = CRITICAL * ft, states[-1]
    if new.stress >= target:
        if len(states) == 1:
            return new
        old = states[-2]
        return old.towards(new, (target - old.stress) / (new.stress - old.stress))
    top = max(range(len(states)), key=lambda i: states[i].stress)
    most = states[top].stress
    if most < NEARLY_CRITICAL * ft or new.stress > _FALLEN * most or top == 0:
        return None
    low, mid, high = states[top - 1], states[top], states[top + 1]
    return _at_top(low, mid, high)


def _at_top(low: TipState, mid: TipState, high: TipState) -> TipState:
    """The state of the largest stress, by a parabola through three, of which the middle one is the largest."""
    a, b = mid.control - low.control, high.control - mid.control
    rise, fall = mid.stress - low.stress, mid.stress - high.stress
    if min(a, b) <= 0 or a * fall + b * rise <= 0:
        return mid
    shift = 0.5 * (b * b * rise - a * a * fall) / (a * fall + b * rise)
    return mid.towards(high, min(shift / b, 0.5)) if shift > 0 else mid.towards(low, min(-shift / a, 0.5))


def _slide(probe: Probe, where: Array, values: dict[str, Array]) -> float:
    """Sliding over opening of the crack behind a tip, within the radius of its probe."""
    offset = where - np.asarray(probe.tip)
    behind = (np.hypot(*offset.T) < probe.radius) & (offset @ unit(probe.heading) < 0)
    opening = float(values["opening"][behind].sum())
    return float(values["sliding"][behind].sum()) / opening if opening > 0 else math.nan


def _stages(trial: PathTrial, model: Model, scene: Scene, before: float | None) -> Sequence[Stage]:
    """The stages of a trial: a single monotonic one up to the largest target, in steps that follow what its tips see."""
    if len(scene.stages) > 1:
        return scene.stages
    (stage,) = scene.stages
    last = max(stage.targets)
    if last <= 0:
        return scene.stages
    if before is None:
        before = _elastic_estimate(trial, model, scene, stage)
    start = min(_SHORTLY_BEFORE * before, last)
    further = start * _FACTOR ** np.arange(1, math.ceil(math.log(last / start) / math.log(_FACTOR)))
    targets = [*np.linspace(0.0, start, _RUN_UP + 1)[1:].tolist(), *further[further < last].tolist(), last]
    return [replace(stage, to=targets, step=None, steps=1, unload=None)]


def _elastic_estimate(trial: PathTrial, model: Model, scene: Scene, stage: Stage) -> float:
    """What a stage controls when the elastic stress ahead of the first tip is the strength; of a control that is zero as long
    as the body is elastic, a small part of its target."""
    last = max(stage.targets)
    if control_of(stage.control).begins_at_onset:
        return 10 * _ELASTIC * last
    elastic = replace(stage, to=_ELASTIC * last, step=None, steps=1, until=None, unload=None)
    seen = next(_states(replace(trial, openings=[]), model, [elastic], scene, math.pi))
    most = max(state.stress for state in seen)
    return seen[0].control * scene.material.ft / most if most > 0 else last
