"""Where a straight way meets something, and where cracks end: pure geometry."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from cohesive.growth.body import Body
from cohesive.growth.crack import Crack, trial_lines

SQUARE = Body([[(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)]], [[(5.0, 0.0), (5.0, 2.0)]])
UP = math.pi / 2


def test_a_way_ends_at_the_first_obstacle() -> None:
    """A face, a notch, another crack, also if it is met at its end or head on."""
    right, up = np.array([1.0, 0.0]), np.array([0.0, 1.0])
    for start, heading, cracks, what, point in (
        ((5.0, 2.0), up, [], "the face", (5.0, 10.0)),
        ((0.0, 1.0), right, [], "a notch", (5.0, 1.0)),
        ((0.0, 2.0), right, [], "a notch", (5.0, 2.0)),
        ((5.0, 2.0), up, [[(0.0, 6.0), (10.0, 6.0)]], "another crack", (5.0, 6.0)),
        ((5.0, 2.0), up, [[(5.0, 9.0), (5.0, 7.0)]], "another crack", (5.0, 7.0)),
    ):
        hit = SQUARE.first_hit(start, heading, cracks)
        assert hit is not None
        assert (hit.what, hit.point) == (what, pytest.approx(point))
    assert SQUARE.first_hit((20.0, 20.0), up) is None


def test_the_last_segment_is_no_sliver() -> None:
    """Whatever is left of the way, the last segment has at least half the length of the others."""
    for start in np.linspace(2.0, 3.0, 11):
        crack = Crack(((1.0, float(start)),), (UP,))
        while not crack.end:
            crack = crack.grown(UP, 1.0, SQUARE, [])
        assert crack.tip == pytest.approx((1.0, 10.0))
        assert 0.5 <= math.dist(*crack.points[-2:]) <= 1.5


def test_cracks_that_head_for_each_other_share_one_way() -> None:
    """Two tips on one line: one path from one to the other, which the mesh can follow. Crossing ones stop at the first."""
    a, b = Crack(((0.0, 5.0), (2.0, 5.0)), (0.0, 0.0)), Crack(((10.0, 5.0), (8.0, 5.0)), (math.pi, math.pi))
    lines = trial_lines([a, b], SQUARE)
    assert sum(math.dist(*ends) for line in lines for ends in pairwise(line)) == pytest.approx(10.0)
    c = Crack(((6.0, 10.0), (6.0, 8.0)), (-UP, -UP))
    assert trial_lines([a, c], SQUARE)[1][-1] == pytest.approx((6.0, 5.0))


def test_a_fixed_crack_keeps_the_mean_direction_of_its_last_segments() -> None:
    crack = Crack(((1.0, 1.0), (1.0, 2.0), (1.0, 3.0), (1.0, 4.0)), (UP, UP + 0.1, UP - 0.1, UP))
    fixed = crack.with_fixed_direction("for a test", 1.0, SQUARE, [])
    assert fixed.tip == pytest.approx((1.0, 10.0))
    assert (fixed.fixed_from, fixed.end, fixed.why) == (3, "the face", "for a test")
