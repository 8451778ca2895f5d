"""The printed summary of a run, and what a reader of its curve should be wary of."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .agreement import agreement_lines
from .crushing import crushing
from .measures import peak_text

if TYPE_CHECKING:
    from .fields import Fields
    from .run_data import RunData

#: planes of a band that depart more than this from the path make it stiffer than a discrete crack, degrees
_DEPARTURE = 10.0

#: a curve is not to be trusted if no energy accounts for more than this part of the work
_UNBALANCED = 0.05

#: the width of the interface is felt in the curve if it adds more than this part to the elastic compliance
_ADDED = 0.05


def summary(data: RunData) -> str:
    """What was modelled, what came out, and what to be wary of."""
    h = data.history
    lines = [data.scene.title, *data.facts.modelled, *data.notes, *warnings(data)]
    if not data.steps:
        return "\n".join([*lines, "no step converged"])
    full = _full_energy(data)
    last = h["load"][-1] / max(abs(h["load"]).max(), 1e-300)
    energies = {name: float(h[name][-1]) for name in ("elastic", "stored", "dissipated", "contact_work")}
    timings = ", ".join(f"{name} {seconds:.2f}" for name, seconds in data.timings.items())
    lines += [
        f"peak load: {peak_text(data)}",
        f"dissipated: {h['dissipated'][-1]:.5g} N mm{full}; the last load is {100 * last:.1f} % of the largest",
        f"energy balance: work {h['work'][-1]:.5g} = "
        + " + ".join(f"{name.replace('_', ' ')} {value:.5g}" for name, value in energies.items())
        + f" N mm, error {data.energy_error:.1e} of the work"
        + (": smaller steps will close it" if data.energy_error > 1e-2 else ""),
        _crack_line(data),
        f"steps: {data.steps}, iterations: {data.iterations}, cuts: {int(h['cuts'].sum())}; seconds: {timings}",
    ]
    return "\n".join(lines + agreement_lines(data.reference, h))


def _full_energy(data: RunData) -> str:
    """How much the dissipation is of that of mode I separation, in words; empty if the crack area is not known."""
    if data.full_energy is None:
        return ""
    left = 1.0 - data.history["dissipated"][-1] / data.full_energy
    rest = f"{100 * left:.1f} % is left" if left >= 0 else "sliding takes more, and contact returns some of it"
    width = "l_ch" if data.is_smeared else "w"
    return f" of {data.full_energy:.5g} N mm = (Gf + ft^2 {width} / 2E) x crack area; {rest}"


def warnings(data: RunData) -> list[str]:
    """What a reader of the curve should be wary of."""
    sentences: list[str] = []
    if not data.steps:
        return []
    peak = data.peak_row
    if data.peak_load > 0 and peak in (1, data.steps):
        which = "first" if peak < data.steps else "last"
        sentences.append(f"warning: the largest load comes with the {which} step; the true peak may lie outside")
    if data.energy_error > _UNBALANCED:
        sentences.append(
            f"warning: {100 * data.energy_error:.0f} % of the work are unaccounted for; the steps are too large, or the "
            "crack has snapped"
        )
    found = (_soft_cracks(data), crushing(data), _locking(data.fields))
    sentences += [warning for warning in found if warning]
    departure = data.facts.departure
    if departure > _DEPARTURE:
        sentences.append(
            f"warning: the crack planes depart from the path by {departure:.0f} degrees in the mean; the band is stiffer "
            "than a discrete crack along it"
        )
    return sentences


def _crack_line(data: RunData) -> str:
    """What the width of the crack plane adds: to the elastic compliance, or in a band to Gf."""
    if data.is_smeared:
        return data.facts.damaged
    added = 100 * data.added_compliance()
    return f"elastic compliance of {_measured(data)}: +{added:.2f} % from the interface width of {data.width:.3g} mm"


def _measured(data: RunData) -> str:
    """What the elastic compliance is of."""
    return "the opening" if data.gauge_is_elastic else "the driven motion"


def _soft_cracks(data: RunData) -> str:
    """A warning if the interface's width is felt before anything cracks; empty if not. Crack planes in series, as of a net of
    cracks, add up."""
    added = data.added_compliance()
    if data.is_smeared or added <= _ADDED:
        return ""
    enough = 0.99 * _ADDED / added * data.width  # what it adds grows with it
    return (
        f"warning: the interface width of {data.width:.3g} mm adds {100 * added:.3g} % to the elastic compliance of "
        f"{_measured(data)}; with interface.width up to {enough:.3g} it is below {100 * _ADDED:g} %"
    )


def _locking(fields: Fields) -> str:
    """A warning if elements of a band lock; empty if not."""
    locking = {block.kind for block in fields.band if block.element.has_constant_strain}
    return f"warning: first-order {locking.pop()} elements lock in a band: peak and energy are too high" if locking else ""
