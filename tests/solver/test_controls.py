"""Every control that is registered: its equation, its targets, its failures; among them one that a user adds."""

from __future__ import annotations

import pickle
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from cohesive import NotConverged, SceneError, run
from cohesive.algebra.bordered import Border
from cohesive.errors import Interrupted, PointFailure
from cohesive.model.build import build
from cohesive.solver.columns import COLUMN_NAMES, COLUMNS, columns_of, unloaded, watched
from cohesive.solver.controls import CONTROLS, Control, Equation, LinearControl, register_control
from cohesive.solver.newton import advance
from cohesive.solver.problem import Guess, Problem, State
from cohesive.solver.stages import Stage
from cohesive.solver.stepper import solve
from tests.builders import block, interfered_march

NAMES = (*CONTROLS, "largest jump", "mean of both")

#: a target that damages the block, in the unit of each control, and one before it
TARGETS = {"load": (300.0, 600.0), "dissipation": (2.0, 4.0)}


class LargestJump(Control):
    """The largest opening at any point of the crack, mm."""

    is_motion = True

    def value(self, problem: Problem, state: State) -> float:
        return float(state.cracks.deformation[:, 0].max())

    def equation(self, problem: Problem, target: float, start: State, now: Guess) -> Equation:
        point = int(np.argmax(now.cracks.deformation[:, 0]))
        row = np.zeros(len(now.v))
        np.add.at(row, problem.operator.index[point], problem.operator.matrix[point, 0])
        return Equation(float(now.cracks.deformation[point, 0]) - target, row)


class MeanOfBoth(LinearControl):
    """Half of the opening of the gauge and half of the driven motion, mm."""

    def row(self, problem: Problem) -> np.ndarray[Any, np.dtype[np.float64]]:
        return 0.5 * (problem.measures["opening"] + problem.drive)


@pytest.fixture(autouse=True)
def added() -> Iterator[None]:
    register_control("largest jump")(LargestJump)
    register_control("mean of both")(MeanOfBoth())
    yield
    del CONTROLS["largest jump"], CONTROLS["mean of both"]


def targets(name: str) -> tuple[float, float]:
    return TARGETS.get(name, (0.005, 0.01))


@dataclass
class Case:
    problem: Problem
    start: State  # on the softening branch, sheared a little
    now: Guess  # beyond it


@pytest.fixture(scope="module")
def case() -> Case:
    problem = build(block(specimen__angle=25.0, specimen__faces="clamped")).problem
    start = advance(problem, advance(problem, problem.initial(), "driven", 0.004).state, "driven", 0.01).state
    v = start.v * 1.02 + 1e-5 * np.random.default_rng(0).normal(size=len(start.v))
    cracks, _ = problem.point_law.update(problem.operator.deformation(v), start.cracks)
    return Case(problem, start, Guess(v, 1.1 * start.load, cracks))


@pytest.mark.parametrize("name", NAMES)
def test_row_and_corner_are_the_derivatives_of_the_gap(case: Case, name: str) -> None:
    problem, start, now, control = case.problem, case.start, case.now, CONTROLS[name]

    def gap(v: Any, load: float) -> float:
        cracks, _ = problem.point_law.update(problem.operator.deformation(v), start.cracks)
        return control.equation(problem, 0.3, start, Guess(v, load, cracks)).gap

    found = control.equation(problem, 0.3, start, now)
    step = 1e-7
    for seed in range(3):
        along = np.random.default_rng(seed).normal(size=len(now.v))
        change = (gap(now.v + step * along, now.load) - gap(now.v - step * along, now.load)) / (2.0 * step)
        assert change == pytest.approx(found.row @ along, rel=1e-6, abs=1e-9 * np.abs(found.row).max())
    change = (gap(now.v, now.load + 1.0) - gap(now.v, now.load - 1.0)) / 2.0
    assert change == pytest.approx(found.corner, abs=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_the_gap_is_value_less_target(case: Case, name: str) -> None:
    control, start = CONTROLS[name], case.start
    value = control.value(case.problem, start)
    gap = control.equation(case.problem, 0.3, start, start).gap
    assert gap == pytest.approx(value - 0.3, rel=1e-12)


@pytest.mark.parametrize("name", NAMES)
def test_converged_steps_meet_the_targets(name: str) -> None:
    """On the way up, and on the way down if there is one."""
    control, (first, second) = CONTROLS[name], targets(name)
    problem = build(block(specimen__angle=25.0, specimen__faces="clamped")).problem
    to = [first, second, *([0.9 * second] if control.can_fall else [])]
    stepper = solve(problem, [Stage(name, to, steps=4)], lambda problem, state: {})
    steps = list(stepper)
    assert not stepper.notes and all(step.control == name for step in steps)
    values = np.array([control.value(problem, step.equilibrium.state) for step in steps])
    np.testing.assert_array_equal(values, [step.value for step in steps])
    # a step may miss its target by the tolerance of its size
    for target in to:
        assert abs(values - target).min() < 1e-8 * second
    assert control.can_fall or (np.diff(values) >= 0).all()  # the onset itself dissipates nothing


@pytest.mark.parametrize("name", NAMES)
def test_what_cannot_fall_is_not_asked_to(name: str) -> None:
    first, second = targets(name)
    if CONTROLS[name].can_fall:
        Stage(name, [second, first, -first], unload={"load": 0.0})
        assert CONTROLS[name].most(10.0) == np.inf
        return
    for to in ([second, first], [first, first], [-first], [0.0]):
        with pytest.raises(ValueError, match=rf"expected growing numbers above 0, {name} cannot fall"):
            Stage(name, to)
    with pytest.raises(ValueError, match=f"unload = .*: {name} cannot fall; expected another control"):
        Stage(name, [first], unload={"load": 0.0})
    assert CONTROLS[name].most(10.0) == 10.0


@pytest.mark.parametrize("name", NAMES)
def test_a_failed_step_gives_the_advice(name: str) -> None:
    advice = CONTROLS[name].advice
    assert advice and not advice.endswith(".")

    def fail(border: Border) -> None:
        raise NotConverged("simulated")

    march = interfered_march(block(), fail, [Stage(name, targets(name)[0])])
    with pytest.raises(NotConverged, match=f"stage 1: the step from {name} = 0 towards .*simulated") as stopped:
        list(march)
    assert str(stopped.value).endswith(advice)


def test_a_control_of_the_user_runs_a_scene() -> None:
    jumps = []
    by_jump = run(
        block(stage=[{"control": "largest jump", "to": 0.02, "steps": 10}]),
        on_step=lambda step, row: jumps.append(step.equilibrium.state.cracks.deformation[:, 0].max()),
    )
    np.testing.assert_allclose(jumps, np.linspace(0.002, 0.02, 10), rtol=1e-9)
    by_opening = run(block(stage=[{"control": "opening", "to": by_jump.history["opening"][-1], "steps": 10}]))
    assert by_jump.history["load"][-1] == pytest.approx(by_opening.history["load"][-1], rel=1e-6)


def test_a_control_that_the_drive_does_not_change_is_refused() -> None:
    @register_control("nothing")
    class Nothing(LinearControl):
        def row(self, problem: Problem) -> np.ndarray[Any, np.dtype[np.float64]]:
            return problem.measures["sliding"]

    try:
        with pytest.raises(SceneError, match=r"stage.0.control = 'nothing': the drive does not change it"):
            run(block(stage=[{"control": "nothing", "to": 0.02}]))
    finally:
        del CONTROLS["nothing"]


def test_names_are_not_given_twice_and_only_to_controls() -> None:
    with pytest.raises(ValueError, match=r"register_control\('opening'\): there is a control of this name; expected another"):
        register_control("opening")(LargestJump)
    with pytest.raises(TypeError, match=r"register_control\('other'\) got 3: expected a subclass of Control"):
        register_control("other")(3)  # type: ignore[type-var]
    assert "other" not in CONTROLS
    with pytest.raises(SceneError, match=r"control = 'other': expected one of opening, sliding, load, driven, dissipation"):
        block(stage=[{"control": "other", "to": 1.0}])


def test_the_columns() -> None:
    assert len(set(COLUMN_NAMES)) == len(COLUMNS) == 20
    assert set(unloaded(COLUMNS)) < set(watched(COLUMNS)) and set(watched(COLUMNS)) - set(COLUMN_NAMES) == {"load_ratio"}
    assert [column.name for column in columns_of(["opening", "cmod"])] == [*COLUMN_NAMES, "cmod"]
    assert all(column.meaning and not column.meaning.endswith(".") for column in COLUMNS)
    recorded = build(block()).record(build(block()).problem.initial())
    assert tuple(recorded) == tuple(column.name for column in COLUMNS if column.watched or column.name == "released")


def test_exceptions_travel_between_processes() -> None:
    made = [SceneError("a.b = 1: expected 2", key="a.b"), NotConverged("no", key="solver.tol"), PointFailure("none", 7)]
    made.append(Interrupted())  # type: ignore[arg-type]
    for error in made:
        error.result, error.finished = 1.0, [2]
        copy = pickle.loads(pickle.dumps(error))
        assert type(copy) is type(error) and str(copy) == str(error) and vars(copy) == vars(error)
    assert SceneError("x").key == "" and SceneError("x").result is None and Interrupted().finished == ()


@pytest.mark.parametrize("size", [8.0, 4.0])
def test_dissipation_control_finds_the_onset_where_the_way_to_it_is_not_quite_linear(size: float) -> None:
    """The planes of a slanted band are in contact before they are damaged: the residual there is 1e-4."""
    stages = [{"control": "dissipation", "to": 20.0, "steps": 12}]
    scene = block(specimen__angle=10.0, solver__tol=1e-9, mesh__crack_size=size, model__kind="smeared", stage=stages)
    history = run(scene).history
    assert history["dissipated"][-1] == pytest.approx(20.0, rel=1e-6)
    assert history["residual"].max() <= 1e-9
