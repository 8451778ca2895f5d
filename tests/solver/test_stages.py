"""Stages: counts and sizes of steps, unloading, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from cohesive import Result, Scene, SceneError, run
from cohesive.solver.stages import Stage
from tests.builders import block, plate


def turns(result: Result) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Rows at which the opening turns back."""
    return np.flatnonzero(np.diff(np.sign(np.diff(result.history["opening"])))) + 1


@pytest.mark.parametrize("model", ["discrete", pytest.param("smeared", marks=pytest.mark.long)])
def test_unloading_after_each_target(model: str) -> None:
    stage = {"control": "opening", "to": [0.01, 0.02, 0.03], "step": 0.001, "unload": {"stress_n": -3.0}}
    result = run(block(stage=[{"control": "opening", "to": 0.005, "steps": 20}, stage]), model)
    h = result.history
    at = turns(result)
    np.testing.assert_allclose(h["opening"][at[::2]], [0.01, 0.02, 0.03], rtol=1e-6)
    np.testing.assert_allclose(h["stress_n"][[*at[1::2], -1]], -3.0, rtol=1e-3)
    assert np.diff(h["opening"]).max() < 1.001e-3
    # reloading returns to the envelope: the law's mode I curve, whatever came before
    tops = h["load"][at[::2]] / 400.0
    m = result.scene.material
    width = result.width
    np.testing.assert_allclose(tops, m.ft * np.exp(-m.ft * (h["opening"][at[::2]] - width * m.ft / m.E) / m.Gf), rtol=2e-3)
    # the first step after a turn is small
    first = abs(h["opening"][at + 1] - h["opening"][at])
    assert first.max() < 0.3e-3


@pytest.mark.parametrize("unload", [{"opening": 0.03}, {"stress_n": 9.0}])
def test_unloading_that_leads_away_ends_at_once(unload: dict[str, float]) -> None:
    result = run(block(stage=[{"control": "opening", "to": [0.02], "steps": 10, "unload": unload}]))
    assert any("leads away from" in note for note in result.notes)
    assert result.history["opening"][1:].min() >= 0.002 * (1 - 1e-9)  # it did not press the crack together


def test_unloading_goes_as_deep_as_it_must() -> None:
    """-10 MPa lies far beyond an opening of 0.004 mm mirrored at 0."""
    result = run(block(stage=[{"control": "driven", "to": [0.004], "steps": 10, "unload": {"stress_n": -10.0}}]))
    assert result.history["stress_n"][-1] == pytest.approx(-10.0, rel=1e-3)
    assert result.history["driven"][-1] < -0.004


def test_a_target_that_is_reached_already_takes_no_step() -> None:
    stages = [{"control": "opening", "to": [0.02, 0.02], "steps": 10}, {"control": "opening", "to": 0.02, "steps": 20}]
    once = run(block(stage=stages))
    assert once.history["step"][-1] == 10
    assert "warning: stage.0.to repeats a target, which takes no step: time is not modelled" in once.summary()
    assert "repeats a target" not in run(block()).summary()
    assert (
        list(run(block(stage=[*stages, {"control": "opening", "to": 0.03, "steps": 2}])).history["stage"][1:])
        == [1] * 10 + [3] * 2
    )


def test_the_slack_of_one_control_is_not_that_of_another() -> None:
    """1e-4 of a step of some kN is more than the whole way in mm that follows."""
    stages = [{"control": "load", "to": 400.0, "steps": 2}, {"control": "driven", "to": 0.01, "steps": 3}]
    result = run(block(stage=stages, solver__tol=1e-3))
    assert result.history["driven"][-1] == pytest.approx(0.01)


def test_the_load_ratio_is_that_of_the_largest_pull() -> None:
    """The compression of the cycle before, larger than the peak, does not count."""
    stages = [
        {"control": "opening", "to": 0.01, "steps": 20, "unload": {"stress_n": -10.0}},
        {"control": "opening", "to": 0.1, "steps": 100, "until": {"load_ratio": 0.5}},
    ]
    result = run(block(stage=stages))
    assert result.history["load"][-1] == pytest.approx(0.5 * result.peak_load, rel=2e-3)
    assert result.history["opening"][-1] > 0.01


def test_unloading_to_no_load_ends_though_the_load_is_rounding_noise() -> None:
    """In a shear stage of a plate, free of load from its start on."""
    stages = [
        {"control": "opening", "to": 0.025, "steps": 10},
        {"control": "driven", "angle": 90.0, "to": [0.05, 0.1], "steps": 5, "unload": {"load": 0.0}},
    ]
    result = run(plate(stage=stages))
    assert abs(result.history["load"][-1]) < 1e-3 * result.history["load"].max()


@pytest.mark.parametrize("model", ["discrete", "smeared"])
def test_a_separated_plane_may_be_slid_and_closed_again(model: str) -> None:
    scene = Scene.load("push-off").with_(
        **{"mesh.crack_size": 50.0, "mesh.far_size": 60.0, "output.frames": 0}
    ).with_(stage=[
        {"control": "opening", "to": 0.2, "steps": 10},
        {"control": "driven", "angle": 90.0, "hold": False, "to": [0.6, -0.6], "steps": 10},
    ])  # fmt: skip
    result = run(scene, model)
    assert result.history["driven"][-1] == pytest.approx(-0.6) and not any("ended early" in note for note in result.notes)
    assert result.history["load"][-1] < -0.3 * result.history["load"].max()  # aggregate interlock, the other way


def test_the_first_stage_may_shear() -> None:
    scene = Scene.load("sandwich-panel").with_(**{"mesh.crack_size": 100.0, "mesh.far_size": 100.0, "output.frames": 0})
    result = run(scene.with_(stage=[{"control": "sliding", "angle": 90.0, "to": 0.001, "steps": 2}]))
    assert result.history["sliding"][-1] == pytest.approx(0.001)
    with pytest.raises(SceneError, match=r"stage.0.control = 'opening': the drive does not change it"):
        run(scene.with_(stage=[{"control": "opening", "angle": 90.0, "to": 0.001, "steps": 2}]))


def test_step_sizes() -> None:
    stage = Stage("opening", [0.1, 0.05], step=0.02)
    assert [stage.count(0.1), stage.count(0.05), stage.count(0.001)] == [pytest.approx(5.0), pytest.approx(2.5), 1.0]
    assert Stage("opening", 0.1).count(0.1) == 50.0
    by_size = run(block(stage=[{"control": "opening", "to": 0.05, "step": 0.0125}]))
    by_count = run(block(stage=[{"control": "opening", "to": 0.05, "steps": 4}]))
    np.testing.assert_allclose(by_size.history["load"], by_count.history["load"], rtol=1e-9)


WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "both": ({"steps": 5, "step": 0.1}, r"stage.0.steps = 5, step = 0.1: expected one of the two"),
    "no size": ({"step": 0.0}, r"stage.0.step = 0.0: expected a number above 0"),
    "ratio": ({"angle": 45.0, "ratio": 1.0}, r"stage.0.ratio: this key is gone; expected stage.angle, the arc tangent"),
    "unload what": ({"unload": {"weight": 1.0}}, r"stage.0.unload = .*expected a number for one of load, opening, "),
    "unload never": ({"unload": {"dissipated": 1.0}}, r"stage.0.unload = .*expected a number for one of load, opening, "),
    "unload to where": ({"unload": -3.0}, r"stage.0.unload = -3.0: expected one quantity and its value"),
    "dissipation": ({"control": "dissipation", "to": 1.0, "unload": {"load": 0.0}}, r"stage.0.unload = .*cannot fall"),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_stages_are_named(case: str) -> None:
    changes, message = WRONG[case]
    with pytest.raises(SceneError, match=message) as caught:
        block(stage=[{"control": "opening", "to": 0.05} | changes])
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("key", ["angle", "hold"])
def test_a_drive_of_one_direction_takes_no_direction(key: str) -> None:
    with pytest.raises(SceneError, match=rf"stage.0.{key} = .*driven in one direction; expected no {key}"):
        run(block(stage=[{"control": "opening", "to": 0.05, key: True if key == "hold" else 1.0}]))


#: elements of the crack in mm; five of them stretch unevenly, and hundreds of steps are cut
SEPARATED = pytest.mark.parametrize("size", [20.0, pytest.param(8.0, marks=pytest.mark.long)])


@SEPARATED
@pytest.mark.parametrize("unload", [{"opening": 0.01}, {"stress_n": -1.0}, None])
def test_a_separated_crack_that_is_to_be_closed_goes_on(unload: dict[str, float] | None, size: float) -> None:
    """Nothing is left of the traction before 20 Zm: that ends a stage unless it has a way back."""
    target = 25 * block().material.Zm
    stage = {"control": "opening", "to": target, "steps": 10, "unload": unload}
    result = run(block(stage=[stage], mesh__crack_size=size, mesh__far_size=size))
    opening = result.history["opening"]
    if unload:
        ((name, value),) = unload.items()  # a stress that stays 0 at first does not lead away from it
        assert opening.max() == pytest.approx(target) and result.history[name][-1] == pytest.approx(value, rel=1e-3)
    else:
        assert opening[-1] < 0.99 * target


@SEPARATED
@pytest.mark.parametrize(
    "others", [[{"to": [1.0, 0.0]}], [{"to": 1.0}, {"to": [0.0, 1.1]}], [{"to": 1.0}, {"control": "driven", "to": 0.0}]]
)
def test_a_separated_crack_is_closed_by_a_target_behind(others: list[dict[str, Any]], size: float) -> None:
    """To 20 Zm, where nothing is left of the traction, then back to where the faces touch, even if it opens again later."""
    wide = 20 * block().material.Zm
    stages = [{"control": "opening", "steps": 6, **stage, "to": (wide * np.array(stage["to"])).tolist()} for stage in others]
    history = run(block(stage=stages, solver__tol=1e-6, mesh__crack_size=size, mesh__far_size=size)).history
    assert history["opening"].max() >= 0.999 * wide
    shut = history["opening"] < 1e-3 * wide
    assert history["stress_n"][shut].min() < -1.0 and shut[len(shut) // 2 :].any()
