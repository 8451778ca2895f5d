"""Softening curves: the stress on a crack over its jump beyond the onset of damage, w = Z - Zt.

A curve enters eq. (5) as 1 - omega = stress(w) Zt / (ft Z), so that a crack that opens monotonically carries stress(w). The
area under it is Gf whatever the width of the crack plane; with the elastic triangle before it, Gf + ft^2 w/2E is spent.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Protocol, TypeVar

import numpy as np

from ..arrays import Array


class Softening(Protocol):
    """What the law asks of a softening curve; w = Z - Zt in mm, an array of any shape, at least 0.

    Attributes
    ----------
    end : opening from which on no stress is left, mm; inf if the curve has no end.
    """

    @property
    def end(self) -> float:
        """See above."""

    def stress(self, w: Array) -> Array:
        """Stress, MPa: ft at w = 0, exactly 0 from `end` on."""

    def slope(self, w: Array) -> Array:
        """Derivative of the stress, MPa/mm; at a kink that of the branch that follows, exactly 0 from `end` on."""

    def work(self, w: Array) -> Array:
        """Area under the curve from 0 to w, N/mm: Gf from `end` on."""


#: what makes a curve of the strength ft (MPa) and the fracture energy Gf (N/mm)
Factory = Callable[[float, float], Softening]

F = TypeVar("F", bound=Factory)

_registered: dict[str, Factory] = {}

#: the registered curves by name
SOFTENING: Mapping[str, Factory] = MappingProxyType(_registered)


def register_softening(name: str) -> Callable[[F], F]:
    """Decorator of a class or function that is called with (ft, Gf) and returns a curve, see `Softening`.

    Raises
    ------
    ValueError
        If there is a curve of that name.
    """

    def register(factory: F) -> F:
        if name in _registered:
            raise ValueError(f"register_softening({name!r}): there is a softening curve of that name; expected another name")
        _registered[name] = factory
        return factory

    return register


@register_softening("exponential")
class Exponential:
    """The paper's curve, eq. (5): ft exp(-ft w / Gf). The c1 that is printed there cancels with Zm = c1 Gf / ft."""

    end = float("inf")

    def __init__(self, ft: float, Gf: float) -> None:
        self.ft, self.Gf = ft, Gf

    def stress(self, w: Array) -> Array:
        return np.asarray(self.ft * np.exp(-self.ft / self.Gf * w))

    def slope(self, w: Array) -> Array:
        return np.asarray(-(self.ft**2) / self.Gf * np.exp(-self.ft / self.Gf * w))

    def work(self, w: Array) -> Array:
        return np.asarray(-self.Gf * np.expm1(-self.ft / self.Gf * w))
