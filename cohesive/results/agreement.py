"""How far a run lies from the measured curves that its scene names: for the summary, run.json and the figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ..arrays import Array
from ..scenes.measured import Measured, Reference


@dataclass(frozen=True)
class Agreement:
    """How far a computed curve lies from a measured one or from a band, over the part of x that both have.

    Attributes
    ----------
    name : of the measured curve
    start, end : the common part of x, mm
    rms : root of the mean square of the difference in load over x, over the largest measured load; of a band the
        distance from its nearer bound counts
    area : computed less measured area under the load, over the measured one; of a band that under its middle
    peak : computed largest load over the measured one, less 1
    inside, points : how many of the measured points within the common part have the computed load in the band; of a
        single curve both are 0
    outside : opening (mm), computed load (N) and distance as a part of the nearer bound at the other points
    """

    name: str
    start: float
    end: float
    rms: float
    area: float
    peak: float
    inside: int = 0
    points: int = 0
    outside: tuple[tuple[float, float, float], ...] = ()


def agreement(measured: Measured, x: Array, y: Array) -> Agreement | None:
    """The agreement of a computed curve with a measured one; None if they have no part of x in common.

    Parameters
    ----------
    x, y : (m,) arrays, mm and N, x rising strictly
    """
    start, end = max(x[0], measured.x[0]), min(x[-1] * (1.0 + 1e-9), measured.x[-1])
    if not end > start:
        return None
    at = np.union1d(x, measured.x)
    at = np.r_[start, at[(at > start) & (at < end)], end]
    load, low, high, middle = (
        np.interp(at, of, values)
        for of, values in ((x, y), (measured.x, measured.low), (measured.x, measured.high), (measured.x, measured.y))
    )
    gap = np.maximum(load - high, 0.0) + np.minimum(load - low, 0.0)
    largest = max(float(abs(measured.y).max()), 1e-300)
    area, wanted = _integral(load, at), _integral(middle, at)
    found = Agreement(
        measured.name,
        float(start),
        float(end),
        float(np.sqrt(_integral(np.square(gap), at) / (end - start))) / largest,
        area / wanted - 1.0 if wanted else 0.0,
        float(y.max() / measured.y.max()) - 1.0 if measured.y.max() else 0.0,
    )
    return _in_band(found, measured, x, y) if measured.is_band else found


def _in_band(found: Agreement, measured: Measured, x: Array, y: Array) -> Agreement:
    """The agreement with the points of a band that the run meets, and those that it does not."""
    met = (measured.x >= found.start) & (measured.x <= found.end)
    at, low, high = measured.x[met], measured.low[met], measured.high[met]
    load = np.interp(at, x, y)
    bound = np.where(load < low, low, high)
    away = (load - bound) / np.maximum(abs(bound), 1e-300)
    is_inside = (low <= load) & (load <= high)
    outside = tuple(zip(*(v[~is_inside].tolist() for v in (at, load, away)), strict=True))
    facts = {name: getattr(found, name) for name in ("name", "start", "end", "rms", "area", "peak")}
    return Agreement(**facts, inside=int(is_inside.sum()), points=len(at), outside=outside)


def _integral(height: Array, along: Array) -> float:
    """Area under a polyline."""
    return float(0.5 * (height[1:] + height[:-1]) @ np.diff(along))


def agreements(reference: Reference | None, history: Mapping[str, Array]) -> list[Agreement]:
    """The agreement with each measured curve that has a part of x in common with the run."""
    if reference is None:
        return []
    computed = reference.computed(history)
    found = [agreement(each, *computed) for each in reference.curves]
    return [each for each in found if each is not None]


def agreement_lines(reference: Reference | None, found: Sequence[Agreement]) -> list[str]:
    """What the summary says of the measured curves."""
    if reference is None:
        return []
    lines = []
    met = {each.name: each for each in found}
    for each in reference.curves:
        what = met.get(each.name)
        if what is None:
            lines.append(f"{reference.label}: {each.name} and the run have no {reference.against} in common")
        elif each.is_band:
            lines.append(f"{reference.label}: {what.inside} of {what.points} points inside the band")
            lines += [
                f"  outside at {x:g} mm: {y:.4g} N, {100 * abs(away):.1f} % {'below' if away < 0 else 'above'} the band"
                for x, y, away in what.outside
            ]
        else:
            lines.append(
                f"{reference.label}: {100 * what.rms:.1f} % of its peak away (rms), area {100 * what.area:+.1f} %, from "
                f"{what.start:.3g} to {what.end:.3g} mm of {reference.against}"
            )
    return lines


def agreement_facts(reference: Reference | None, found: Sequence[Agreement]) -> dict[str, Any] | None:
    """What run.json says of the measured curves."""
    if reference is None:
        return None
    return {"against": reference.against, "curves": [asdict(each) for each in found]}
