"""Areas under and between curves."""

from __future__ import annotations

import numpy as np
import pytest

from cohesive.studies.curves import Curve, Pair


def curve(opening: list[float], load: list[float]) -> Curve:
    return Curve(np.array(opening), np.array(load), np.zeros(len(load)), None, max(load), opening[load.index(max(load))])


def test_areas() -> None:
    pair = Pair.from_curves(curve([0.0, 1.0, 3.0], [0.0, 10.0, 4.0]), curve([0.0, 2.0], [0.0, 6.0]))
    assert pair.end == 2.0
    assert [pair.energy(0), pair.energy(1)] == pytest.approx([5.0 + 8.5, 6.0])
    assert pair.between() == pytest.approx(13.5 - 6.0)
