"""From what a user gives as `softening` to a curve, and to the plain data of a scene."""

from __future__ import annotations

import math
import reprlib
from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np

from ..errors import ParameterError
from .softening import SOFTENING, PiecewiseLinear, Softening, bilinear

#: the strength and energy of a curve may differ from ft and Gf by this part
_AGREEMENT = 1e-6
#: openings at which work and slope are checked, the last one over Gf/ft, and the part of Gf and ft that allows for kinks
_CHECKED, _FURTHEST, _ROUGHLY = 1001, 40.0, 0.05


def normalized(softening: Any) -> Any:
    """The user's value: a registered name, {"kink": [x, y]} or {"points": [[w, stress], ...]} with plain numbers, or an object
    with the protocol.

    Raises
    ------
    ValueError
        For anything else.
    """
    if isinstance(softening, str) and softening in SOFTENING:
        return softening
    if isinstance(softening, Mapping) and len(softening) == 1:
        if "kink" in softening:
            return {"kink": _kink(softening["kink"])}
        if "points" in softening:
            return {"points": _points(softening["points"])}
    needed = ("stress", "slope", "work")
    is_curve = not isinstance(softening, type) and all(callable(getattr(softening, name, None)) for name in needed)
    if is_curve and isinstance(getattr(softening, "end", None), (int, float)):
        return softening
    raise _refused(
        f"softening = {reprlib.repr(softening)}: expected one of {', '.join(SOFTENING)}, or {{kink = [x, y]}}, "
        "{points = [[w, stress], ...]}, or an object with stress, slope, work and end"
    )


def fixes_strength(softening: Any) -> bool:
    """Whether ft and Gf follow from this (normalized) value: from points and from an object."""
    return not isinstance(softening, str) and not (isinstance(softening, Mapping) and "kink" in softening)


def strength_and_energy(softening: Any) -> tuple[float, float]:
    """ft (MPa) and Gf (N/mm) of a normalized value that fixes them.

    Raises
    ------
    ValueError
        If an object has no strength, energy or end.
    """
    curve = _own_curve(softening)
    ft, Gf = float(curve.stress(np.zeros(1))[0]), float(curve.work(np.array([float(curve.end)]))[0])
    for what, value in (("stress(0)", ft), ("work(end)", Gf)):
        if not 0 < value < math.inf:
            raise _refused(f"softening: {what} = {value!r}: expected a finite number above 0")
    return ft, Gf


def curve_of(softening: Any, ft: float, Gf: float) -> Softening:
    """The curve of a normalized value, of the strength ft (MPa) and the fracture energy Gf (N/mm).

    Raises
    ------
    ValueError
        If the curve does not begin at ft, does not have the area Gf, or carries stress at its end.
    """
    if fixes_strength(softening):
        curve = _own_curve(softening)
    elif isinstance(softening, str):
        curve = SOFTENING[softening](ft, Gf)
    else:
        curve = bilinear(ft, Gf, *softening["kink"])
    end = float(curve.end)
    if not end > 0:
        raise _refused(f"softening: end = {end!r}: expected an opening above 0 in mm, or inf")
    last = np.array([end])
    for what, value, wanted, scale in (
        ("stress(0)", curve.stress(np.zeros(1)), ft, ft), ("work(end)", curve.work(last), Gf, Gf),
        ("stress(end)", curve.stress(last), 0.0, ft), ("slope(end)", curve.slope(last), 0.0, ft**2 / Gf),
    ):  # fmt: skip
        if not abs(float(value[0]) - wanted) <= _AGREEMENT * scale:
            raise _refused(f"softening = {reprlib.repr(softening)}: {what} = {float(value[0]):.9g}; expected {wanted:.9g}")
    _check_between(softening, curve, ft, Gf)
    return curve


def _check_between(softening: Any, curve: Softening, ft: float, Gf: float) -> None:
    """Refuse negative stress, and a work or a slope that is not the integral or the derivative of the stress."""
    kinks = np.asarray(getattr(curve, "kinks", ()), dtype=float)
    last = min(float(curve.end), _FURTHEST * Gf / ft)
    w = np.unique(np.concatenate([np.linspace(0.0, last, _CHECKED), kinks * (1.0 - 1e-9), kinks]))  # either side of a kink
    w = w[w <= last]
    stress, slope, step = curve.stress(w), curve.slope(w), np.diff(w)
    sums = (np.r_[0.0, np.cumsum(0.5 * (y[1:] + y[:-1]) * step)] for y in (stress, slope))
    for what, value, wanted, scale in zip(
        ("work", "stress"), (curve.work(w), stress - stress[0]), sums, (Gf, ft), strict=True
    ):
        wrong = np.flatnonzero(~(abs(value - wanted) <= _ROUGHLY * scale))
        if wrong.size:
            at = w[wrong[0]]
            of = "the area under the stress" if what == "work" else "what the slope adds up to"
            raise _refused(f"softening = {reprlib.repr(softening)}: {what}({at:.4g}) is not {of}")
    if stress.min() < 0:
        at = w[stress.argmin()]
        raise _refused(f"softening = {reprlib.repr(softening)}: stress({at:.4g}) = {stress.min():.4g}; expected at least 0")


def softening_name(softening: Any) -> str:
    """A normalized value in few words, for summaries and legends."""
    if isinstance(softening, str):
        return softening
    if not isinstance(softening, Mapping):
        return type(softening).__name__
    if "kink" in softening:
        x, y = softening["kink"]
        return f"kink at {x:g} Gf/ft, {y:g} ft"
    return f"{len(softening['points'])} points"


def softening_data(softening: Any) -> str | dict[str, Any]:
    """The value as it stands in a TOML file: a name, or {"kink": ...} or {"points": ...}.

    Raises
    ------
    ValueError
        For an object, which no file can hold.
    """
    if isinstance(softening, (str, Mapping)):
        plain: str | dict[str, Any] = normalized(softening)
        return plain
    raise _refused(
        f"softening = {reprlib.repr(softening)}: an object that is not registered runs, but its scene cannot be saved; "
        "expected the name of a curve after register_softening"
    )


def _own_curve(softening: Any) -> Softening:
    if isinstance(softening, Mapping):
        w, stress = zip(*softening["points"], strict=True)
        return PiecewiseLinear(w, stress)
    curve: Softening = softening
    return curve


def _numbers(value: Any, count: int) -> list[float] | None:
    """`count` finite numbers, or None."""
    try:
        numbers = [float(x) for x in value if not isinstance(x, (bool, str))]
    except (TypeError, ValueError):
        return None
    return numbers if len(numbers) == count == len(value) and all(map(math.isfinite, numbers)) else None


def _kink(value: Any) -> list[float]:
    numbers = _numbers(value, 2)
    if numbers is None or not (numbers[0] > 0 and 0 < numbers[1] < 1 and numbers[0] * (1 + numbers[1]) < 2):
        raise _refused(
            f"softening.kink = {reprlib.repr(value)}: expected [x, y], an opening in Gf/ft above 0 and a stress in ft between "
            "0 and 1, with x (1 + y) < 2, the area that the whole curve has"
        )
    return numbers


def _points(value: Any) -> list[list[float]]:
    """Pairs of numbers that begin at w = 0, advance, and end at stress 0."""
    try:
        pairs = [_numbers(pair, 2) for pair in value]
    except TypeError:
        pairs = []
    points = [pair for pair in pairs if pair is not None]
    if len(points) < 2 or len(points) < len(pairs):
        raise _refused(
            f"softening.points = {reprlib.repr(value)}: expected at least two pairs [w, stress] of numbers, in mm and MPa"
        )
    if points[0][0] != 0 or not points[0][1] > 0:
        raise _refused(f"softening.points: begins with {points[0]}; expected w = 0 and the strength, above 0 MPa")
    for before, after in pairwise(points):
        if not after[0] > before[0]:
            raise _refused(f"softening.points: {after} follows {before}; expected w to grow from point to point")
        if after[1] < 0 or (after[1] == 0 and after is not points[-1]):
            raise _refused(f"softening.points: {after}; expected a stress above 0, which only the last point ends")
    if points[-1][1] != 0:
        raise _refused(f"softening.points: ends with {points[-1]}; expected a last point with stress 0")
    return points


def _refused(message: str) -> ParameterError:
    return ParameterError(message, "softening")
