"""The printed summary of a run, and what a reader of its curve should be wary of."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .agreement import agreement_lines
from .crushing import crushing
from .measures import peak_text

if TYPE_CHECKING:
    from .run_data import RunData

#: planes of a band that depart more than this from the path are those of another crack, degrees
DEPARTURE = 5.0

#: a curve is not to be trusted if no energy accounts for more than this part of the work
_UNBALANCED = 0.05

#: and from this part on its summary names the step at fault
_DOUBTED = 0.01

#: the width of the interface is felt in the curve if it adds more than this part to the elastic compliance
_ADDED = 0.05

#: after the peak the load ripples if it rises again by more than this part of the peak, so often
_RISE, _RIPPLES = 5e-3, 2


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
        + (f" N mm, error {data.energy_error:.1e} of the work" if data.law.is_checked else " N mm, not checked")
        + (_worst_step(data) if data.energy_error > _DOUBTED else ""),
        _crack_line(data),
        f"steps: {data.steps}, iterations: {data.iterations}, cuts: {int(h['cuts'].sum())}; seconds: {timings}",
    ]
    return "\n".join(lines + agreement_lines(data.reference, h, data.peak_load))


def _full_energy(data: RunData) -> str:
    """How much the dissipation is of that of mode I separation, in words; empty if the crack area is not known."""
    if data.full_energy is None:
        return ""
    left = 1.0 - data.history["dissipated"][-1] / data.full_energy
    width = "l_ch" if data.is_smeared else "w"
    opening = f" of {data.full_energy:.5g} N mm = {data.law.energy_text(width)} x crack area"
    if left >= 0:
        return f"{opening}; {100 * left:.1f} % is left"
    sliding, alone = data.law.most_dissipated * (data.facts.crack_area or 0.0), f"{opening}, which opening alone takes"
    if sliding == np.inf:
        return alone
    return f"{alone}; sliding alone takes up to {sliding:.5g} N mm, and more under pressure"


def _worst_step(data: RunData) -> str:
    """Which step leaves most of the work unaccounted for, in words."""
    errors = abs(np.diff(data.unaccounted))
    row = 1 + int(errors.argmax())
    place = f"{data.controlled} {data.history[data.controlled][row]:.4g} mm"
    share = 100 * errors[row - 1] / errors.sum()
    return f"; {share:.0f} % of it comes with step {row}, up to {place}: smaller steps will close it"


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
    found = (_holds(data), _ripples(data), _soft_cracks(data), crushing(data))
    sentences += [warning for warning in found if warning]
    if kinds := data.fields.locking:
        sentences.append(f"warning: first-order {kinds[0]} elements lock in a band: peak and energy are too high")
    departure = data.facts.departure
    if departure > DEPARTURE:
        sentences.append(
            f"warning: the crack planes depart from the path by {departure:.0f} degrees in the mean: no discrete crack along "
            "it compares; with band.planes = 'path' they lie on it"
        )
    return sentences


def _ripples(data: RunData) -> str:
    """A warning if the load rises again and again on the way down, while elements break one after the other; empty if not, or
    if the loading turns."""
    turns = any(each.unload is not None or each.redirects or any(np.diff(each.targets) < 0) for each in data.scene.stages)
    if turns or data.peak_load <= 0:
        return ""
    load = data.history["load"][data.peak_row :] / data.peak_load
    ends = np.flatnonzero(np.diff(np.diff(load) > 0.0, prepend=False, append=False))  # of each rise, its low and its top
    rises = load[ends[1::2]] - load[ends[::2]]
    count = int((rises > _RISE).sum())
    if count < _RIPPLES:
        return ""
    return (
        f"warning: after the peak the load rises {count} times by more than {100 * _RISE:g} % of it, up to "
        f"{100 * rises.max():.2g} %: elements along the crack break one after the other; smaller ones smooth it"
    )


def _crack_line(data: RunData) -> str:
    """What the width of the crack plane adds: to the elastic compliance, or in a band to Gf."""
    if data.is_smeared:
        return data.facts.damaged
    added = 100 * data.added_compliance()
    source = f"interface width of {data.width:.3g} mm" if data.scene.law.takes_width else "stiffness of the law"
    return f"elastic compliance of {_measured(data)}: +{added:.2f} % from the {source}"


def _measured(data: RunData) -> str:
    """What the elastic compliance is of."""
    return "the opening" if data.scene.specimen.has_main_gauge else "the driven motion"


def _soft_cracks(data: RunData) -> str:
    """A warning if the interface's width is felt before anything cracks; empty if not. Crack planes in series, as of a net of
    cracks, add up."""
    added = data.added_compliance()
    if data.is_smeared or added <= _ADDED or not data.scene.law.takes_width:
        return ""
    enough = 0.99 * _ADDED / added * data.width  # what it adds grows with it
    return (
        f"warning: the interface width of {data.width:.3g} mm adds {100 * added:.3g} % to the elastic compliance of "
        f"{_measured(data)}; with interface.width up to {enough:.3g} it is below {100 * _ADDED:g} %"
    )


def _holds(data: RunData) -> str:
    """A warning if a stage has a target twice in a row, as if it held it; empty if none has."""
    for i, stage in enumerate(data.scene.stages):
        if stage.unload is None and (np.diff(stage.targets) == 0).any():
            return f"warning: stage.{i}.to repeats a target, which takes no step: time is not modelled, nothing is held"
    return ""
