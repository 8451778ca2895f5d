"""Snap-back, followed back by dissipation, and snap-through to the next equilibrium."""

from __future__ import annotations

import numpy as np
import pytest

from cohesive import NotConverged, Result, Scene, run
from cohesive.algebra.bordered import Border
from cohesive.law.crack_plane import CrackPlane
from tests.builders import block, interfered_march


def test_a_crack_that_opens_under_dissipation_control_snaps_back() -> None:
    """A long bar stores more than the crack takes: load and driven motion both fall after the peak."""
    scene = block(specimen__height=1200.0, specimen__width=20.0, mesh__far_size=40.0, mesh__crack_size=4.0)
    scene = scene.with_(stage=[{"control": "dissipation", "to": 20.0, "steps": 40}])
    result = run(scene)
    h = result.history
    assert h["dissipated"][-1] == pytest.approx(20.0, rel=1e-9)
    assert np.diff(h["driven"]).min() < -1e-3
    assert result.energy_error < 1e-3
    law, Z = CrackPlane(result.scene.material, result.width), np.zeros(1)
    for u, load in zip(h["opening"], h["load"], strict=True):
        traction, Z = law.traction(np.array([[u, 0.0]]), Z)
        assert load == pytest.approx(200.0 * traction[0, 0], rel=0.05)  # on the mean jump: the bar bends while it snaps back


@pytest.mark.parametrize("model", ["discrete", pytest.param("smeared", marks=pytest.mark.long)])
def test_a_bar_that_snaps_back_under_its_platen_is_followed_back(model: str) -> None:
    """The same bar pulled by its platen: at the peak its next equilibrium lies behind it, and dissipation leads there."""
    scene = block(specimen__height=1200.0, specimen__width=20.0, mesh__far_size=40.0, mesh__crack_size=4.0, model__kind=model)
    result = run(scene.with_(stage=[{"control": "driven", "to": 0.3, "steps": 40}]))
    h = result.history
    assert h["driven"][-1] == pytest.approx(0.3, rel=1e-4)
    back = [note for note in result.notes if "driven goes back from" in note]
    assert len(back) == 1 and not any("snaps" in note for note in result.notes)
    start, end = (float(word) for word in back[0].replace(",", "").split() if word[:2] == "0.")
    ft_times_length = result.scene.material.ft * 1200.0 / result.scene.material.E
    assert start == pytest.approx(ft_times_length, rel=2e-3)
    assert end == pytest.approx(h["driven"][h["dissipated"] > 1.0].min(), rel=1e-4)
    assert end < 0.85 * start
    assert h["residual"].max() < 1e-9  # tolerance 1e-11, and the rounding of a bar that long
    # every step is an equilibrium: nothing is set free but what the trapezoidal rule of the work misses in large steps
    assert result.energy_error < 0.02


@pytest.mark.parametrize("steps", [10, pytest.param(40, marks=pytest.mark.long)])
def test_a_step_that_jumps_over_a_snap_back_is_not_taken(steps: int) -> None:
    """An inclined band in a tall block has an equilibrium with no load a step further, and Newton's method finds it."""
    scene = Scene.load("single-crack").with_(
        **{"specimen.height": 1200.0, "mesh.order": 1, "model.kind": "smeared",
           "stage": [{"control": "driven", "to": 0.3, "steps": steps}]}
    )
    result = run(scene)
    assert any("driven goes back from 0.090" in note for note in result.notes)
    assert result.energy_error < 0.02  # of the trapezoidal rule; 0.2 to 0.4 where it is jumped over


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("load_ratio", 0.6),
        pytest.param("opening", 0.01, marks=pytest.mark.long),
        ("opening", 0.015),
        pytest.param("dissipated", 5.0, marks=pytest.mark.long),
        pytest.param("dissipated", 10.0, marks=pytest.mark.long),
    ],
)
def test_an_event_on_the_way_back_ends_the_stage_there(name: str, value: float) -> None:
    """Also where a step stops just short of it."""
    scene = block(specimen__height=3000.0, specimen__width=20.0, mesh__far_size=40.0, mesh__crack_size=4.0)
    scene = scene.with_(stage=[{"control": "driven", "to": 0.5, "steps": 20, "until": {name: value}}])
    result = run(scene)
    h = result.history
    last = h["load"][-1] / h["load"].max() if name == "load_ratio" else h[name][-1]
    assert last == pytest.approx(value, rel=2e-3)
    assert h["driven"][-1] < h["driven"].max()
    assert f"stage 1 ended where {name} = {value:g}" in result.notes
    assert not any("snaps" in note for note in result.notes)


def test_nothing_is_followed_back_where_a_block_is_pushed_or_unloaded() -> None:
    """A failure there is not that of a crack which sets energy free: dissipation lies the other way."""
    driven = [0.0]

    def fail(border: Border) -> None:
        if np.array_equal(border.row, march.problem.drive) and driven[-1] <= -0.002:  # any other control finds its way
            raise NotConverged("simulated")

    march = interfered_march(block(stage=[{"control": "driven", "to": -0.02, "steps": 8}]), fail)
    with pytest.raises(NotConverged, match="simulated"):
        driven.extend(step.equilibrium.state.driven for step in march)
    assert len(driven) > 1 and max(driven[1:]) < 0


@pytest.fixture(scope="module")
def branched() -> Result:
    """A T-branch sheared open."""
    crack = [[[-30, 0], [30, 0]], [[0, 0], [0, 30]]]
    return run(Scene.load("single-crack").with_(**{"specimen.crack": crack, "specimen.drive_angle": 45.0}))


def test_a_crack_without_an_equilibrium_close_by_snaps_to_the_next_one(branched: Result) -> None:
    """A narrow plane that is first damaged under compression and shear falls to contact at once."""
    result, h = branched, branched.history
    assert h["driven"].max() == pytest.approx(0.06, rel=1e-4)
    snaps = [note for note in result.notes if "snaps at driven" in note]
    assert 1 <= len(snaps) <= 4
    at, size = int(h["cuts"].argmax()), np.diff(h["driven"])  # no step is cut as often as the one that must snap
    assert size[at] > 0.5 * size[at - 1]  # the next one begins with its size, not with that which failed
    released = [float(note.split("sets ")[1].split()[0]) for note in snaps]
    assert all(0 < energy < 1e-2 * h["work"].max() for energy in released)  # a snap sets energy free, a little
    assert h["released"][-1] == pytest.approx(sum(released), rel=1e-2)  # three digits in the notes
    assert h["residual"].max() <= result.scene.solver.tol  # and ends in equilibrium
    assert result.energy_error < 1e-3


@pytest.mark.long
def test_an_event_within_a_snap_ends_the_stage_behind_it(branched: Result) -> None:
    at = int(branched.history["cuts"].argmax())  # no step is cut as often as the one that must snap
    before, after = branched.history["dissipated"][at - 1 : at + 1]
    assert after - before > 0.1
    scene = branched.scene.with_(**{"stage.0.until": {"dissipated": 0.5 * float(before + after)}, "stage.0.to": 0.06})
    result = run(scene)
    assert len([note for note in result.notes if "snaps" in note]) == 1
    assert any("stage 1 ended where dissipated" in note for note in result.notes)
    assert result.history["dissipated"][-1] == pytest.approx(after, rel=0.05)


def test_a_long_bar_with_a_band_snaps_back_under_dissipation_control() -> None:
    scene = block(
        model__kind="smeared",
        specimen__height=1200.0,
        specimen__width=20.0,
        mesh__far_size=40.0,
        mesh__crack_size=20.0,
        band__width=4.0,
    )
    scene = scene.with_(**{"solver.tol": 1e-8})  # at the onset planes are formed 1e-9 ft late
    result = run(scene.with_(stage=[{"control": "dissipation", "to": 20.0, "steps": 30}]))
    h = result.history
    assert h["dissipated"][-1] == pytest.approx(20.0, rel=1e-9)
    assert np.diff(h["driven"]).min() < -1e-3
    assert result.energy_error < 2e-3
