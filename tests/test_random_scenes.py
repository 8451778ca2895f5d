"""Random valid scenes end, or say why not; what must hold in any run is asserted on the way."""

from __future__ import annotations

import numpy as np
import pytest

from cohesive import run
from tests.random_scenes import difference, outcome, random_scene, table, twin_differences, with_steps
from tests.twins import scaled

#: two take as long as all the others: they are pushed shut with printed contact, or beyond where they began
QUICK = [seed for seed in range(62) if seed not in (35, 37)]


@pytest.mark.parametrize("part", [0, *(pytest.param(part, marks=pytest.mark.long) for part in range(1, 24))])
def test_sixty_small_scenes(part: int) -> None:
    for seed in QUICK[part::24]:
        end = outcome(random_scene(seed, small=True))
        assert end.status != "stopped", (seed, end.reason)


@pytest.mark.slow
def test_a_thousand_scenes() -> None:
    """Less than .3 % of those that start stop; the balance closes as the steps are refined."""
    found = table(1000)
    started = [end for end in found if end.status != "refused"]
    assert sum(end.status == "stopped" for end in started) < 0.003 * len(started)


@pytest.mark.slow
def test_three_hundred_extreme_scenes() -> None:
    """Each ends, stops with a reason, or is refused; no other exception."""
    assert all(end.reason for end in table(300, extreme=True) if end.status != "ended")


@pytest.mark.slow
def test_a_hundred_scenes_with_and_without_condensation() -> None:
    """To 1e-8 of each column's scale, but for 3: rounding makes two of them cut a step in one way only, and one is at 2e-8."""
    found = np.sort([value for seed in range(115) if (value := difference(seed)) is not None])
    assert len(found) >= 100
    assert found[-4] < 1e-8


@pytest.mark.slow
def test_balances_close_with_the_square_of_the_steps() -> None:
    """Where none of them is named: four times the steps leave less than a quarter, of what is above the tolerance."""
    for seed in range(40):
        coarse = outcome(random_scene(seed))
        if coarse.balance > 0.01 and not coarse.is_named:
            fine = outcome(with_steps(random_scene(seed), 4))
            assert fine.is_named or fine.balance < coarse.balance / 4, seed


@pytest.mark.parametrize("seed", [42, 51])
def test_dissipation_control_leaves_its_onset(seed: int) -> None:
    """A first point that is damaged by less than rounding shows would be gone to again and again: ten rows were alike."""
    load = run(random_scene(seed)).history["load"]
    assert (abs(load[1:] / load[1] - 1.0) < 1e-8).sum() <= 2


@pytest.mark.parametrize("seed", [1, pytest.param(4, marks=pytest.mark.long), pytest.param(13, marks=pytest.mark.long)])
def test_a_run_repeats_to_the_last_bit(seed: int) -> None:
    one, other = (run(random_scene(seed, small=True)).history for _ in range(2))
    for name in one:
        if name != "wall_time":
            np.testing.assert_array_equal(one[name], other[name])


@pytest.mark.parametrize(
    "seed", [92003, *(pytest.param(each, marks=pytest.mark.long) for each in (92002, 92004, 92006, 92008, 92019))]
)
def test_twins_follow_from_a_scene(seed: int) -> None:
    """Other units and another thickness keep every bit; in a mirror sums round otherwise, which a snap would blow up."""
    for name, found in (twin_differences(seed) or {}).items():
        assert found <= (1e-8 if name == "mirrored" else 0.0), name


@pytest.mark.parametrize("length, stress", [(2.0, 1.0), (1.0, 8.0), (512.0, 0.5)])
@pytest.mark.parametrize("condensation", ["always", "never"])
def test_units_change_no_bit(condensation: str, length: float, stress: float) -> None:
    """The bulk is condensed over a power of two, for the root of 2 is not a whole one."""
    scene = random_scene(92003, small=True).with_(**{"solver.condensation": condensation})
    twin = scaled(scene, length, stress)
    assert twin.difference(run(scene).history, run(twin.scene).history) == 0.0


@pytest.mark.slow
def test_a_line_search_ends_if_a_point_has_no_solution_at_the_full_step() -> None:
    """Nor did a shorter one lower the residual: it went on to a length of 0."""
    assert outcome(random_scene(92032)).status == "ended"


@pytest.mark.slow
def test_newton_that_alternates_under_dissipation_control_is_led_on() -> None:
    result = run(random_scene(283))
    assert any("alternates from dissipation" in note for note in result.notes)
    assert result.history["dissipated"][-1] == pytest.approx(result.scene.stages[0].to, rel=1e-3)
