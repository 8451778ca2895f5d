"""Softening curves that the tests take: all registered ones, a kink, points, and an object of a user."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from cohesive import Concrete
from cohesive.arrays import Array
from cohesive.law.softening import SOFTENING

E, NU, FT, GF = 35e3, 0.2, 3.2, 0.12
WIDTHS = [0.05, 2.0, 60.0]


class Cosine:
    """A curve of a user: ft (1 + cos(pi w / end)) / 2, which begins and ends flat."""

    def __init__(self, ft: float = FT, end: float = 0.3) -> None:
        self.ft, self.end = ft, end

    def stress(self, w: Array) -> Array:
        return np.asarray(0.5 * self.ft * (1.0 + np.cos(np.pi * np.minimum(w / self.end, 1.0))))

    def slope(self, w: Array) -> Array:
        inside = -0.5 * self.ft * np.pi / self.end * np.sin(np.pi * np.minimum(w / self.end, 1.0))
        return np.where(w < self.end, inside, 0.0)

    def work(self, w: Array) -> Array:
        x = np.minimum(w / self.end, 1.0)
        return np.asarray(0.5 * self.ft * self.end * (x + np.sin(np.pi * x) / np.pi))


FIBRES = [[0.0, 3.0], [0.05, 0.8], [1.0, 1.6], [4.0, 0.0]]

CASES: dict[str, Any] = {
    **{name: name for name in SOFTENING},
    "kink": {"kink": [0.5, 0.2]},
    "points": {"points": [[0.0, 3.2], [0.02, 1.7], [0.06, 0.6], [0.3, 0.0]]},
    "fibres": {"points": FIBRES},
    "object": Cosine(),
}


def concrete(softening: Any, **changes: Any) -> Concrete:
    """A material with this curve; ft and Gf are given if the curve does not fix them."""
    own = {} if has_own_strength(softening) else {"ft": FT, "Gf": GF}
    return Concrete(**{"E": E, "nu": NU, **own, "m_g": 0.3, "softening": softening, **changes})


def has_own_strength(softening: Any) -> bool:
    return not isinstance(softening, str) and not (isinstance(softening, Mapping) and "kink" in softening)


def openings(m: Concrete, n: int = 4001) -> Array:
    """From 0 to a little beyond the end, the kinks included."""
    kinks = np.asarray(getattr(m.curve, "kinks", ()))
    return np.unique(np.concatenate([1.1 * m.spent * np.linspace(0.0, 1.0, n) ** 2, kinks, [m.spent]]))


def normal(u: Array) -> Array:
    return np.stack([u, np.zeros_like(u)], axis=1)


case = pytest.mark.parametrize("softening", CASES.values(), ids=CASES)
width_of = pytest.mark.parametrize("width", WIDTHS)
