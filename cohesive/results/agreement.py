"""How far a run lies from the measured curves that its scene names: for the summary, run.json and the figures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from ..arrays import Array
from ..measured.curve import Measured, Reference, area_under, outside
from .peak import peak_weights


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
    peak : computed largest load over the measured one, less 1; both lie between rows, see `peak_weights`
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


def agreement(measured: Measured, x: Array, y: Array, peak: float) -> Agreement | None:
    """The agreement of a computed curve with a measured one; None if they have no part of x in common.

    Parameters
    ----------
    x, y : (m,) arrays, mm and N, x rising strictly
    peak : largest computed load, N
    """
    start, end = max(x[0], measured.x[0]), min(x[-1], measured.x[-1])
    if not end > start:
        return None
    at = np.union1d(x, measured.x)
    at = np.r_[start, at[(at > start) & (at < end)], end]
    load = np.asarray(np.interp(at, x, y))
    low, high, middle = (np.asarray(np.interp(at, measured.x, values)) for values in (*measured.bounds, measured.y))
    gap = outside(load, low, high)
    largest = max(float(abs(measured.y).max()), 1e-300)
    area, wanted = area_under(load, at), area_under(middle, at)
    judged = Agreement(
        measured.name,
        float(start),
        float(end),
        _root_mean_square(gap, at) / largest,
        area / wanted - 1.0 if wanted else 0.0,
        peak / wanted_peak - 1.0 if (wanted_peak := _peak(measured)) else 0.0,
    )
    return _in_band(judged, measured, x, y) if measured.is_band else judged


def _in_band(judged: Agreement, measured: Measured, x: Array, y: Array) -> Agreement:
    """The agreement with the points of a band that the run meets, and those that it does not."""
    met = (measured.x >= judged.start) & (measured.x <= judged.end * (1.0 + 1e-9))
    at, (low, high) = measured.x[met], (bound[met] for bound in measured.bounds)
    load = np.interp(at, x, y)
    bound = np.where(load < low, low, high)
    away = (load - bound) / np.maximum(abs(bound), 1e-300)
    is_inside = (low <= load) & (load <= high)
    outside = tuple(zip(*(v[~is_inside].tolist() for v in (at, load, away)), strict=True))
    return replace(judged, inside=int(is_inside.sum()), points=len(at), outside=outside)


def _peak(measured: Measured) -> float:
    """The largest measured load, N."""
    rows, weights = peak_weights(measured.x[None], measured.y)
    return float(weights @ measured.y[rows])


def _root_mean_square(height: Array, along: Array) -> float:
    """Root of the mean square of a polyline's points over their x."""
    return float(np.sqrt(area_under(np.square(height), along) / (along[-1] - along[0])))


def agreements(reference: Reference | None, history: Mapping[str, Array], peak: float) -> list[Agreement]:
    """The agreement of a run with a peak (N) with each measured curve that has a part of x in common with it, and with the
    mean of several."""
    if reference is None:
        return []
    computed = reference.computed(history)
    mean = reference.mean()
    curves = [*reference.curves, *([] if mean is None else [mean[0]])]
    return [judged for each in curves if (judged := agreement(each, *computed, peak)) is not None]


def agreement_lines(reference: Reference | None, history: Mapping[str, Array], peak: float) -> list[str]:
    """What the summary of a run with a peak (N) says of the measured curves."""
    if reference is None:
        return []
    computed = reference.computed(history)
    lines = reference.notes
    for each in reference.curves:
        if not each.doubt:
            lines += _lines(reference.name_of(each), each, agreement(each, *computed, peak), reference.against)
    mean = reference.mean()
    if mean is not None and not any(each.doubt for each in reference.curves):
        curve, spread = mean
        peaks = np.array([_peak(each) for each in reference.curves])
        lines += _lines(f"{reference.label}, {curve.name}", curve, agreement(curve, *computed, peak), reference.against)
        lines.append(
            f"  between the tests: {100 * _root_mean_square(spread, curve.x) / max(abs(curve.y).max(), 1e-300):.1f} % of the "
            f"mean's peak (standard deviation), peaks {peaks.mean():.5g} +- {peaks.std(ddof=1):.4g} N"
        )
    return lines


def _lines(name: str, measured: Measured, judged: Agreement | None, against: str) -> list[str]:
    if judged is None:
        return [f"{name}: it and the run have no {against} in common, it begins at {measured.x[0]:.4g} mm"]
    if measured.is_band:
        return [f"{name}: {judged.inside} of {judged.points} points inside the band"] + [
            f"  outside at {x:g} mm: {y:.4g} N, {100 * abs(away):.1f} % {'below' if away < 0 else 'above'} the band"
            for x, y, away in judged.outside
        ]
    return [
        f"{name}: rms {100 * judged.rms:.1f} % of its peak, area {_signed(judged.area)}, peak {_signed(judged.peak)}, "
        f"over {against} from {judged.start:.3g} to {judged.end:.3g} mm"
    ]


def _signed(part: float) -> str:
    """A part in percent with its sign, none for zero."""
    percent = round(100 * part, 1)
    return f"{percent:+.1f} %" if percent else "0.0 %"


def agreement_facts(reference: Reference | None, history: Mapping[str, Array], peak: float) -> dict[str, Any] | None:
    """What run.json says of the measured curves; of a run with a peak (N)."""
    if reference is None:
        return None
    return {
        "against": reference.against,
        "curves": [asdict(each) for each in agreements(reference, history, peak)],
        "notes": [f"{each.name}: {note}" for each in reference.curves for note in each.notes],
        "questions": [f"{each.name}: {each.doubt}" for each in reference.curves if each.doubt],
    }
