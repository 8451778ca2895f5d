"""What the criteria of a path must meet in linear fracture mechanics, and what a segment of finite length does."""

from __future__ import annotations

import pytest

from tests.growth.kinked_crack import direction_of_hoop_stress, direction_without_sliding


@pytest.mark.parametrize(
    ("slant", "hoop", "no_sliding"), [(15.0, 26.74, 27.4), (30.0, 43.22, 45.5), (45.0, 53.13, 56.7), (60.0, 60.0, 64.6)]
)
def test_the_published_directions_of_a_short_kink(slant: float, hoop: float, no_sliding: float) -> None:
    """The largest hoop stress in closed form; K_II = 0 of M. Amestoy and J.-B. Leblond (Int. J. Solids Struct. 29, 1992) by a
    kink of 1e-4 of half the crack, within 1.2 degrees: its length and the elements make it .4 to 1.1 less or more."""
    assert direction_of_hoop_stress(slant) == pytest.approx(hoop, abs=0.01)
    assert direction_without_sliding(slant, 1e-4) == pytest.approx(no_sliding, abs=1.2)


def test_a_segment_of_finite_length_turns_otherwise() -> None:
    """The stress along the crack, -cos(2 slant) of the pull, turns a kink of .08 of half the crack by 6 degrees less at a
    slant of 15 and by 3.6 more at 60; at 45, where it vanishes, by less than 2. Within .3, for the root is found to .06."""
    slants = (15.0, 45.0, 60.0)
    change = [direction_without_sliding(slant, 0.08) - direction_without_sliding(slant, 1e-4) for slant in slants]
    assert change == pytest.approx([-6.1, -1.6, 3.6], abs=0.3)
