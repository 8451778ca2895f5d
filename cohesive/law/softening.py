"""Softening curves: the stress on a crack over its jump beyond the onset of damage, w = Z - Zt.

A curve enters eq. (5) as 1 - omega = stress(w) Zt / (ft Z), so that a crack that opens monotonically carries stress(w). The
area under it is Gf whatever the width of the crack plane; with the elastic triangle before it, Gf + ft^2 width/2E is spent.

Sources of the constants. Petersson (1981), report TVBM-1006, Lund: ft/3 at 0.8 Gf/ft, end 3.6 Gf/ft. Wittmann et al. (1988):
ft/4 at 0.75 Gf/ft, end 5 Gf/ft, and Hordijk (1991), thesis, Delft: Gf = 0.1947 ft w_c; both agree with Serendip.jl
(src/mech/constitutive/evolution_laws.jl). fib Model Code 2010, section 5.1.8.2: 0.2 ft at Gf/ft, end 5 Gf/ft. A bilinear
curve is made from its kink; the end that the area Gf then gives, (2 - x)/y Gf/ft, is the cited one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from types import MappingProxyType
from typing import Protocol, TypeVar

import numpy as np

from ..arrays import Array, Index


class Softening(Protocol):
    """What the law asks of a softening curve; w = Z - Zt in mm, an array of any shape, at least 0.

    Attributes
    ----------
    end : opening from which on no stress is left, mm; inf if the curve has no end.
    kinks : optional, a sequence of the openings at which the slope jumps, mm, `end` left out.
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
    """Decorator of a class or function that is called with (ft, Gf) in MPa and N/mm and returns a curve, see `Softening`.

    Raises
    ------
    ValueError
        If `name` is no string or there is a curve of that name.

    Examples
    --------
    >>> import numpy as np
    >>> from cohesive import Concrete, register_softening
    >>> @register_softening("falling at once")
    ... class AtOnce:
    ...     def __init__(self, ft, Gf):
    ...         self.ft, self.Gf, self.end = ft, Gf, 2.0 * Gf / ft
    ...
    ...     def stress(self, w):
    ...         return np.clip(self.ft * (1.0 - w / self.end), 0.0, self.ft)
    ...
    ...     def slope(self, w):
    ...         return np.where((w > 0) & (w < self.end), -self.ft / self.end, 0.0)
    ...
    ...     def work(self, w):
    ...         w = np.clip(w, 0.0, self.end)
    ...         return self.ft * w * (1.0 - 0.5 * w / self.end)
    >>> Concrete(E=30000.0, nu=0.2, ft=3.0, Gf=0.1, softening="falling at once").curve.end
    0.06666666666666667
    """
    if not isinstance(name, str) or not name:
        raise ValueError(f'register_softening({name!r}): expected the name of the curve, @register_softening("name")')

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


class PiecewiseLinear:
    """Straight branches between points (w, stress), mm and MPa, with w = 0 first and stress 0 last."""

    def __init__(self, w: Sequence[float], stress: Sequence[float]) -> None:
        self.w, self.values = np.asarray(w, dtype=float), np.asarray(stress, dtype=float)
        slopes = np.diff(self.values) / np.diff(self.w)
        areas = 0.5 * (self.values[1:] + self.values[:-1]) * np.diff(self.w)
        # of the branch that follows each point, and up to the point
        self.slopes, self.works = np.append(slopes, 0.0), np.append(0.0, np.cumsum(areas))
        self.end = float(self.w[-1])
        bent = abs(np.diff(slopes)) > 1e-9 * abs(slopes).max()
        self.kinks: list[float] = self.w[1:-1][bent].tolist()

    def _branch(self, w: Array) -> tuple[Index, Array]:
        """Number of the branch and opening from its beginning."""
        i = np.searchsorted(self.w, w, side="right") - 1
        return i, w - self.w[i]

    def stress(self, w: Array) -> Array:
        i, x = self._branch(w)
        # no rounding below 0 before the end; beyond it x may be inf
        return np.where(w < self.end, np.maximum(self.values[i] + self.slopes[i] * np.minimum(x, self.end), 0.0), 0.0)

    def slope(self, w: Array) -> Array:
        return np.asarray(self.slopes[self._branch(w)[0]])

    def work(self, w: Array) -> Array:
        i, x = self._branch(np.minimum(w, self.end))
        return np.asarray(self.works[i] + x * (self.values[i] + 0.5 * self.slopes[i] * x))


def bilinear(ft: float, Gf: float, x: float, y: float) -> PiecewiseLinear:
    """A kink at the opening x Gf/ft and the stress y ft; the area puts the end at (2 - x)/y Gf/ft."""
    unit = Gf / ft
    return PiecewiseLinear([0.0, x * unit, (2.0 - x) / y * unit], [ft, y * ft, 0.0])


@register_softening("linear")
def linear(ft: float, Gf: float) -> PiecewiseLinear:
    """Straight to 2 Gf/ft."""
    return PiecewiseLinear([0.0, 2.0 * Gf / ft], [ft, 0.0])


@register_softening("hordijk")
class Hordijk:
    """Cornelissen, Hordijk and Reinhardt: [1 + (c1 x)^3] e^(-c2 x) - x (1 + c1^3) e^(-c2), x = w/w_c, c1 = 3, c2 = 6.93.

    The area sets w_c = 5.136055... Gf/ft in closed form; with the 5.136 that is usually printed 1e-5 of Gf would be missing.
    """

    _c1, _c2 = 3.0, 6.93

    def __init__(self, ft: float, Gf: float) -> None:
        self.ft, self.Gf = ft, Gf
        self.end = Gf / (ft * float(self._area(np.ones(1))[0]))

    def _area(self, x: Array) -> Array:
        """Area from 0 to x of the curve of unit strength and end, with the integral of x^3 e^(-c2 x)."""
        a, b = self._c1**3, self._c2
        falling = np.exp(-b * x)
        cubic = 6.0 / b**4 - falling * (x**3 / b + 3.0 * x**2 / b**2 + 6.0 * x / b**3 + 6.0 / b**4)
        return np.asarray(-np.expm1(-b * x) / b + a * cubic - 0.5 * (1.0 + a) * np.exp(-b) * x**2)

    def stress(self, w: Array) -> Array:
        a, b, x = self._c1**3, self._c2, np.minimum(w / self.end, 1.0)
        return np.asarray(self.ft * np.maximum((1.0 + a * x**3) * np.exp(-b * x) - x * (1.0 + a) * np.exp(-b), 0.0))

    def slope(self, w: Array) -> Array:
        a, b, x = self._c1**3, self._c2, np.minimum(w / self.end, 1.0)
        slope = (3.0 * a * x**2 - b * (1.0 + a * x**3)) * np.exp(-b * x) - (1.0 + a) * np.exp(-b)
        return np.where(w < self.end, self.ft / self.end * slope, 0.0)

    def work(self, w: Array) -> Array:
        return np.asarray(self.ft * self.end * self._area(np.minimum(w / self.end, 1.0)))


#: the kinks of bilinear curves of the literature, opening over Gf/ft and stress over ft; sources above
_KINKS = {"petersson": (0.8, 1.0 / 3.0), "wittmann": (0.75, 0.25), "fib-2010": (1.0, 0.2)}

for _name, (_x, _y) in _KINKS.items():
    register_softening(_name)(partial(bilinear, x=_x, y=_y))
