"""One run along trial paths, watched from the tips: the first state in which each is critical."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from meshing.paths import Line, Point

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

#: or if it has been more than this part and falls again: a path that goes the right way is relieved by its cohesive zone
NEARLY_CRITICAL = 0.6

#: tips whose stress has come so near to that of the first one grow with it
_TOGETHER = 0.97

#: steps of a trial up to shortly before the state in which the tip before was critical
_RUN_UP, _SHORTLY_BEFORE = 6, 0.8


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
    mesh_seconds : of meshing
    is_whole : whether it ran to the end, for all tips
    ended : why the run ended early; empty if it did not
    """

    lines: list[Line]
    probes: list[Probe]
    critical: list[TipState | None]
    at_peak: list[Reading]
    mesh_seconds: float = 0.0
    is_whole: bool = False
    ended: str = ""


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
    stress = NodalStress.from_blocks(model.bulk)
    probes = [Probe.from_tip(stress, tip, heading, radius) for tip, heading in tips]
    nothing = [probe.nothing for probe in probes]
    trial = PathTrial(lines, probes, [None] * len(tips), nothing, model.timings["mesh"], not first_only)
    _march(trial, model, _stages(scene.stages, first_only, before), scene, largest_turn)
    return trial


def _march(trial: PathTrial, model: Model, stages: Sequence[Stage], scene: Scene, largest_turn: float) -> None:
    """Fill a trial step by step."""
    control = control_of(scene.stages[0].control)
    old = [TipState(probe.nothing, 0.0, 0.0, 0.0, 0.0, math.nan) for probe in trial.probes]
    most, last = list(old), list(old)
    peak = 0.0
    target = CRITICAL * scene.material.ft
    try:
        stepper = solve(model.problem, stages, model.recorded, scene.solver.step_growth)
        for step in stepper:
            record = stepper.record(step.equilibrium.state)
            displacement = model.condensation.recover(step.equilibrium.state.v)
            numbers = record["load"], record["opening"], control.value(stepper.problem, step.equilibrium.state)
            values = model.cracks.point_values(step.equilibrium.state)
            readings = [probe.read(displacement) for probe in trial.probes]
            new = [
                TipState(
                    reading, probe.strongest(reading, largest_turn)[1], *numbers, _slide(probe, model.cracks.where, values)
                )
                for probe, reading in zip(trial.probes, readings, strict=True)
            ]
            if abs(record["load"]) > peak:  # of either sign: what is pushed may split
                peak, trial.at_peak = abs(record["load"]), readings
            for i, critical in _reached(old, new, target, not trial.is_whole).items():
                trial.critical[i] = trial.critical[i] or critical
            if all(trial.critical) or (any(trial.critical) and not trial.is_whole):
                return
            most = [max(pair, key=lambda seen: seen.stress) for pair in zip(most, new, strict=True)]
            old = last = new
    except NotConverged as error:
        trial.ended = str(error)
    for i, (top, end) in enumerate(zip(most, last, strict=True)):  # stress that has passed its largest value
        if trial.critical[i] is None and end.stress < top.stress and top.stress > NEARLY_CRITICAL * scene.material.ft:
            trial.critical[i] = top


def _slide(probe: Probe, where: Array, values: dict[str, Array]) -> float:
    """Sliding over opening of the crack behind a tip, within the radius of its probe."""
    offset = where - np.asarray(probe.tip)
    behind = (np.hypot(*offset.T) < probe.radius) & (offset @ unit(probe.heading) < 0)
    opening = float(values["opening"][behind].sum())
    return float(values["sliding"][behind].sum()) / opening if opening > 0 else math.nan


def _reached(old: list[TipState], new: list[TipState], target: float, together: bool) -> dict[int, TipState]:
    """The tips that become critical between two states, each in its own; if `together`, all that are nearly critical in the
    state in which the first one is."""
    share = {
        i: (target - a.stress) / (b.stress - a.stress)
        for i, (a, b) in enumerate(zip(old, new, strict=True))
        if a.stress < target <= b.stress
    }
    if not share or not together:
        return {i: old[i].towards(new[i], part) for i, part in share.items()}
    first = min(share.values())
    between = [a.towards(b, first) for a, b in zip(old, new, strict=True)]
    return {i: seen for i, seen in enumerate(between) if seen.stress >= _TOGETHER * target}


def _stages(stages: Sequence[Stage], first_only: bool, before: float | None) -> Sequence[Stage]:
    """The stages of a trial: a single monotonic one up to the largest target, in long steps where no tip is critical yet."""
    if len(stages) > 1:
        return stages
    (stage,) = stages
    last = max(stage.targets)
    if last <= 0:
        return stages
    step = last / stage.count(last)
    whole = replace(stage, to=last, steps=None, step=step, unload=None)
    if not first_only or before is None or not 0 < _SHORTLY_BEFORE * before < last:
        return [whole]
    return [replace(whole, to=_SHORTLY_BEFORE * before, step=None, steps=_RUN_UP), whole]
