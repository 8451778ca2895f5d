"""The numbers that a fit varies: their keys, bounds and scales, shared by the scenes or each scene's own."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..errors import SceneError
from ..scenes.scene import Scene
from .repeated_run import value_of

#: key of the offsets of measured curves, which are no numbers of a model
OFFSET = "reference.x_offset"


@dataclass(frozen=True)
class Varied:
    """A number that is varied.

    Attributes
    ----------
    name : its key, and "@1" (the number of the scene) if it is that scene's own
    key : dotted key
    scenes : indices of the scenes that have it
    low, high, start : its bounds and its first value
    curve : of an offset the number of its curve among those of its scene; else None

    Positive numbers are varied by their logarithm, others by their part of the range.
    """

    name: str
    key: str
    scenes: tuple[int, ...]
    low: float
    high: float
    start: float
    curve: int | None = None

    def scaled(self, value: float) -> float:
        """The number as the optimiser sees it."""
        return math.log(value) if self.low > 0 else (value - self.low) / (self.high - self.low)

    def value(self, z: float) -> float:
        """The number from the optimiser's."""
        return math.exp(z) if self.low > 0 else self.low + z * (self.high - self.low)

    def slope(self, z: float) -> float:
        """Derivative of `value`."""
        return self.value(z) if self.low > 0 else self.high - self.low

    @property
    def bounds(self) -> tuple[float, float]:
        """The bounds as the optimiser sees them."""
        return self.scaled(self.low), self.scaled(self.high)

    @property
    def short(self) -> str:
        """Its name in a sentence."""
        return self.name.removeprefix("material.").removeprefix("reference.").replace("softening.", "")


def varied(
    scenes: Sequence[Scene],
    vary: Mapping[str, tuple[float, float]],
    own: Sequence[str] = (),
    offsets: Sequence[Sequence[float]] = (),
) -> list[Varied]:
    """What is varied in some scenes.

    Parameters
    ----------
    vary : {key: (low, high)}
    own : keys of which each scene has its own number
    offsets : of the measured curves of each scene, mm: each has its own

    Raises
    ------
    SceneError
        For bounds that are none, or a key without a number in a scene.
    """
    if not vary:
        raise SceneError("vary is empty: expected at least one key with its bounds, as material.ft=2:5")
    for key in own:
        if key not in vary:
            raise SceneError(f"own: {key} is not varied; expected some of {', '.join(vary)}", key)
    numbers = []
    for key, bounds in vary.items():
        low, high = _bounds(key, bounds)
        if key == OFFSET:
            numbers += _offsets(low, high, offsets)
            continue
        groups = [(i,) for i in range(len(scenes))] if key in own and len(scenes) > 1 else [tuple(range(len(scenes)))]
        for group in groups:
            start = value_of(scenes[group[0]], key)
            name = key if len(groups) == 1 else f"{key}@{group[0] + 1}"
            numbers.append(Varied(name, key, group, low, high, min(max(start, low), high)))
    return numbers


def _offsets(low: float, high: float, offsets: Sequence[Sequence[float]]) -> list[Varied]:
    """An offset for each measured curve of each scene."""
    places = [(i, k, offset) for i, each in enumerate(offsets) for k, offset in enumerate(each)]
    if outside := [offset for _, _, offset in places if not low <= offset <= high]:
        raise SceneError(
            f"vary {OFFSET} = ({low:g}, {high:g}): a curve is counted from {outside[0]:.4g} mm; expected bounds around that",
            OFFSET,
        )
    names = [OFFSET] if len(places) == 1 else [f"{OFFSET}@{number}" for number in range(1, len(places) + 1)]
    return [Varied(name, OFFSET, (i,), low, high, start, k) for name, (i, k, start) in zip(names, places, strict=True)]


def _bounds(key: str, bounds: tuple[float, float]) -> tuple[float, float]:
    try:
        low, high = (float(bound) for bound in bounds)
    except (TypeError, ValueError):
        low = high = math.nan
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise SceneError(f"vary {key} = {bounds!r}: expected two numbers LOW:HIGH, the first below the second", key)
    return low, high


def inside(parameters: Sequence[Varied], z: Array) -> Array:
    """Scaled numbers moved off their bounds, as the optimiser wants its start."""
    low, high = np.array([each.bounds for each in parameters]).T
    room = 1e-3 * (high - low)
    return np.clip(z, low + room, high - room)
