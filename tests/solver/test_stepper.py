"""Marching through stages: targets, events, steps that are cut, failures, the end of a run."""

from __future__ import annotations

import re
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cohesive import NotConverged, Result, Scene, run
from cohesive.algebra.bordered import Border
from cohesive.errors import Interrupted, PointFailure
from cohesive.solver.newton import Equilibrium
from cohesive.solver.problem import Problem, State
from cohesive.solver.snap import advance_past_onset
from tests.builders import block, interfered_march


@pytest.mark.parametrize("model", ["discrete", "smeared"])
def test_a_separated_body_ends_the_run_and_says_so(model: str) -> None:
    Zm = block().material.Zm
    result = run(block(model__kind=model, stage=[{"control": "opening", "to": 100 * Zm, "steps": 200}]))
    assert "run through" in result.notes[-1]
    assert result.history["opening"][-1] < 20 * Zm
    assert np.isfinite(result.history["load"]).all()


def test_until_ends_a_stage_where_it_says() -> None:
    stages = [
        {"control": "opening", "to": 0.1, "steps": 25, "until": {"load_ratio": 0.5}},
        {"control": "opening", "to": 0.0, "steps": 10, "until": {"load": -300.0}},
    ]
    result = run(block(stage=stages))
    h = result.history
    turn = int(h["opening"].argmax())
    assert h["load"][turn] == pytest.approx(0.5 * result.peak_load, rel=1e-3)
    assert turn <= 11  # the tenth step passes the event, and interpolation finds the place: not one small step after another
    assert h["load"][-1] == pytest.approx(-300.0, rel=1e-3)


def test_a_crack_that_carries_nothing_for_a_moment_is_not_separated() -> None:
    stages = [{"control": "opening", "to": 0.05, "steps": 5}, {"control": "load", "to": 0.0, "steps": 5}]
    result = run(block(stage=[*stages, {"control": "opening", "to": 0.1, "steps": 5}]))
    assert result.history["opening"][-1] == pytest.approx(0.1)
    assert not [note for note in result.notes if "longer than" not in note]


def test_steps_are_cut_and_recover(beam: Scene) -> None:
    """Huge steps far beyond the peak that fail in their last iterations: whatever it takes, the end is that of small steps."""
    fine = run(beam.with_(**{"stage.0.steps": 40, "stage.0.to": 0.1}))
    scene, calls = beam.with_(**{"stage.0.steps": 4, "stage.0.to": 0.1}), count(1)

    def fail(border: Border) -> None:
        if next(calls) in (4, 9, 17, 19):
            raise NotConverged("simulated")

    march = interfered_march(scene, fail)
    steps = list(march)
    rows = [march.record(step.equilibrium.state) for step in steps]
    assert sum(step.cuts for step in steps) >= 2
    assert (np.diff([row["opening"] for row in rows]) > 0).all()
    assert rows[-1]["opening"] == pytest.approx(0.1, rel=1e-6)
    assert steps[-1].equilibrium.state.load == pytest.approx(fine.history["load"][-1], rel=1e-3)
    # a rejected step leaves no damage behind
    assert steps[-1].equilibrium.state.dissipated == pytest.approx(fine.history["dissipated"][-1], rel=5e-3)


@pytest.mark.parametrize("tol", [1e-2, 1e-4, 1e-6])
def test_dissipation_stages_end_at_their_targets(beam: Scene, tol: float) -> None:
    stages = [{"control": "dissipation", "to": [20.0, 40.0], "steps": 20}]
    result = run(beam.with_(**{"solver.tol": tol}).with_(stage=stages))
    assert result.dissipated_energy == pytest.approx(40.0, abs=3 * tol)
    # from the onset steps of 1 N mm are halved down to a sixty-fourth; none is for a rest within tol
    assert np.diff(result.history["dissipated"][1:]).min() > 0.015


@pytest.mark.parametrize("steps", [4, 8])
def test_steps_by_dissipation_from_an_intact_body_account_for_their_work(beam: Scene, steps: int) -> None:
    """The first of them would go straight from the elastic line to the peak, and lose 15 and 7 % of the work."""
    result = run(beam.with_(stage=[{"control": "dissipation", "to": 40.0, "steps": steps}]))
    assert result.energy_error < 6e-3
    assert result.steps <= 2 + steps + 6  # the onset, a rest, and halved down to 2^-6 each size once


def test_reversals_start_small_whatever_controls_them() -> None:
    stages = [{"control": "opening", "to": 0.08, "steps": 8}, {"control": "driven", "to": 0.04, "steps": 8}]
    driven = run(block(stage=stages)).history["driven"]
    assert driven[9] - driven[8] == pytest.approx((0.04 - driven[8]) / 8 / 4, rel=1e-6)


def test_a_load_beyond_the_largest_one_fails_says_what_helps_and_keeps_what_was_computed(beam: Scene, tmp_path: Path) -> None:
    with pytest.raises(NotConverged, match="control = 'opening' or 'driven' goes on past the peak") as caught:
        run(beam.with_(stage=[{"control": "load", "to": 2000.0, "steps": 20}]), output=tmp_path)
    assert re.match(r"stage 1: the step from load = .* failed down to", str(caught.value))
    result = caught.value.result
    assert isinstance(result, Result)
    assert 900 < result.peak_load < 1100
    rows = (tmp_path / "history.csv").read_text().splitlines()
    assert len(rows) == 1 + len(result.history["step"]) > 2
    result.save(tmp_path)
    assert (tmp_path / "curve.png").stat().st_size > 5000


@pytest.mark.parametrize("condensation", ["always", "never"])
def test_a_plate_on_hinges_comes_apart_at_the_smallest_tolerance(condensation: str) -> None:
    """As nothing but the softening's tail keeps its halves from turning, corrections of 1e-8 to 1e-7 remain, all rounding."""
    scene = Scene.load("notched-tension").with_(
        **{"specimen.platens": "hinged", "mesh.crack_size": 3.0, "mesh.far_size": 12.0, "solver.tol": 1e-11,
           "solver.condensation": condensation, "stage.0.steps": 8, "stage.1.to": 3.0, "stage.1.steps": 20}
    )  # fmt: skip
    result = run(scene)
    assert any("run through" in note for note in result.notes)
    assert result.dissipated_energy == pytest.approx(result.full_energy, rel=1e-6)


@pytest.mark.long
def test_dissipation_control_of_a_band_ends_at_its_targets(beam: Scene) -> None:
    result = run(beam.with_(stage=[{"control": "dissipation", "to": [20.0, 40.0], "steps": 10}]), model="smeared")
    assert result.dissipated_energy == pytest.approx(40.0, abs=1e-3)
    by_opening = run(beam.with_(**{"stage.0.steps": 60}), model="smeared").history
    # two ways through the same equilibria, each a polygon of its own steps
    h = result.history
    between = np.interp(h["opening"], by_opening["opening"], by_opening["load"])
    np.testing.assert_allclose(h["load"][1:], between[1:], atol=0.02 * h["load"].max())


def test_a_failure_in_a_band_names_where_and_keeps_the_run(beam: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """A local iteration that is cut short after the first steps: a crack plane fails, and the run says at which place."""

    def spoil(step: Any, row: dict[str, float]) -> None:
        if row["step"] == 8:
            monkeypatch.setattr("cohesive.cracks.band_iteration.MAX_ITERATIONS", 0)

    with pytest.raises(
        NotConverged, match=r"stage 1: the step from opening = .* point\(s\) have no solution .* at \("
    ) as caught:
        run(beam, model="smeared", on_step=spoil)
    result = caught.value.result
    assert isinstance(result, Result)
    assert result.steps == 8


def test_an_interruption_carries_what_was_computed() -> None:
    def interrupt(step: Any, row: dict[str, float]) -> None:
        if row["step"] == 3:
            raise KeyboardInterrupt("by the user")

    with pytest.raises(Interrupted, match=r"^by the user$") as caught:
        run(block(), on_step=interrupt)
    assert isinstance(caught.value, KeyboardInterrupt) and isinstance(caught.value.result, Result)
    assert caught.value.result.steps == 3 and caught.value.result.notes[-1] == "stopped: by the user"


@pytest.mark.parametrize(("cause", "factor"), [(None, 0.5), (PointFailure("a plane", 0), 0.25)])
def test_a_failed_step_is_cut_in_two_and_a_failed_point_in_four(cause: PointFailure | None, factor: float) -> None:
    calls = count()

    def fail_at_first(border: Border) -> None:
        if next(calls) == 0:
            raise NotConverged("at first") from cause

    march = interfered_march(block(stage=[{"control": "opening", "to": 0.05, "steps": 5}]), fail_at_first)
    steps = list(march)
    assert march.record(steps[0].equilibrium.state)["opening"] == pytest.approx(0.01 * factor)
    assert [step.cuts for step in steps[:2]] == [1, 0]


def test_where_newton_alternates_under_dissipation_control_secant_tangents_lead_on(monkeypatch: pytest.MonkeyPatch) -> None:
    """Steps that fail whatever their size, from one state on: the curve is the same, and a note says it once."""
    scene = block(stage=[{"control": "dissipation", "to": 10.0, "steps": 10}])
    whole = run(scene).history

    def alternating(problem: Problem, start: State, *args: Any) -> Equilibrium:
        if 3.0 < start.dissipated < 6.5:
            raise NotConverged("by turns")
        return advance_past_onset(problem, start, *args)

    monkeypatch.setattr("cohesive.solver.target_path.advance_past_onset", alternating)
    result = run(scene)
    assert sum("Newton's method alternates from dissipation" in note for note in result.notes) == 1
    end = result.history["load"][-1]
    assert end == pytest.approx(whole["load"][-1], rel=1e-6) and result.history["dissipated"][-1] == pytest.approx(10.0)
