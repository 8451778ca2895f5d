"""The printed summary of a run, and what a reader of its curve should be wary of."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..elements.bulk import ElasticBlock
from ..elements.rotations import major_stress
from ..law.softening_choice import softening_name
from .agreement import agreement_lines
from .crushing import crushing

if TYPE_CHECKING:
    from ..model.model import Model
    from ..scenes.scene import Scene
    from .run_data import RunData

#: planes of a band that depart more than this from the path make it stiffer than a discrete crack, degrees
_DEPARTURE = 10.0

#: a curve is not to be trusted if no energy accounts for more than this part of the work
_UNBALANCED = 0.05

#: the bulk would crack off the path if its major stress over ft is larger in more than this part of its volume
_OVERLOADED, _OVERLOADED_SHARE = 1.5, 0.1


def summary(data: RunData) -> str:
    """What was modelled, what came out, and what to be wary of."""
    h = data.history
    lines = [data.scene.title, *describe(data.scene, data.model), *data.notes, *warnings(data)]
    if not data.steps:
        return "\n".join([*lines, "no step converged"])
    full = _full_energy(data)
    last = h["load"][-1] / max(abs(h["load"]).max(), 1e-300)
    energies = {name: float(h[name][-1]) for name in ("elastic", "stored", "dissipated", "contact_work")}
    timings = ", ".join(f"{name} {seconds:.2f}" for name, seconds in data.timings.items())
    lines += [
        f"peak load: {data.peak_load:.5g} N at opening {data.opening_at_peak:.4g} mm{_other_gauge(data)}",
        f"dissipated: {h['dissipated'][-1]:.5g} N mm{full}; the last load is {100 * last:.1f} % of the largest",
        f"energy balance: work {h['work'][-1]:.5g} = "
        + " + ".join(f"{name.replace('_', ' ')} {value:.5g}" for name, value in energies.items())
        + f" N mm, error {data.energy_error:.1e} of the work"
        + (": smaller steps will close it" if data.energy_error > 1e-2 else ""),
        _crack_line(data),
        f"steps: {data.steps}, iterations: {data.iterations}, cuts: {int(h['cuts'].sum())}; seconds: {timings}",
    ]
    return "\n".join(lines + agreement_lines(data.reference, h))


def _other_gauge(data: RunData) -> str:
    """What the stage of the peak controls, if that is another gauge than the opening."""
    control = data.scene.stages[int(data.history["stage"][data.peak_row]) - 1].control
    if control == "opening" or control not in data.scene.specimen.gauges():
        return ""
    return f", {control} {data.history[control][data.peak_row]:.4g} mm"


def _full_energy(data: RunData) -> str:
    """How much the dissipation is of that of mode I separation, in words; empty if the crack area is not known."""
    if data.full_energy is None:
        return ""
    left = 1.0 - data.history["dissipated"][-1] / data.full_energy
    rest = f"{100 * left:.1f} % is left" if left >= 0 else "sliding takes more, and contact returns some of it"
    width = "l_ch" if data.model.is_smeared else "w"
    return f" of {data.full_energy:.5g} N mm = (Gf + ft^2 {width} / 2E) x crack area; {rest}"


def warnings(data: RunData) -> list[str]:
    """What a reader of the curve should be wary of; looked for once, for it takes the stresses of several rows."""
    if data.warned is None:
        data.warned = _warnings(data)
    return data.warned


def _warnings(data: RunData) -> list[str]:
    found: list[str] = []
    if not data.steps:
        return []
    peak = data.peak_row
    if data.peak_load > 0 and peak in (1, data.steps):
        which = "first" if peak < data.steps else "last"
        found.append(f"warning: the largest load comes with the {which} step; the true peak may lie outside")
    if data.energy_error > _UNBALANCED:
        found.append(
            f"warning: {100 * data.energy_error:.0f} % of the work are unaccounted for; the steps are too large, or the "
            "crack has snapped"
        )
    if not data.model.is_smeared and (overload := _overload(data)):
        found.append(overload)
    if crushed := crushing(data):
        found.append(crushed)
    locking = {block.kind for block in data.model.band} & {"triangle", "tetra"}
    if locking:
        found.append(f"warning: first-order {locking.pop()} elements lock in a band: peak and energy are too high")
    departure = _departure(data)
    if departure > _DEPARTURE:
        found.append(
            f"warning: the crack planes depart from the path by {departure:.0f} degrees in the mean; the band is stiffer "
            "than a discrete crack along it"
        )
    return found


def describe(scene: Scene, model: Model) -> Sequence[str]:
    """Three lines: what was modelled, how, and what was left out."""

    def count(blocks: Sequence[ElasticBlock], what: str = "") -> str:
        kinds = " and ".join(sorted({block.kind for block in blocks}))
        return f"{sum(len(block.cells) for block in blocks)} {what}{kinds} elements"

    whole = "one half of a symmetric body, " if scene.model.half else ""
    bulk = count(model.bulk, "linear elastic ") + " and " if model.bulk else ""
    points = f"{len(model.cracks.weights)} points"
    left_out = "cracks off the given path, "
    if model.mesh.crack is not None:
        cracks = f"{len(model.mesh.crack.data)} zero-thickness crack cells, {points}, width {model.cracks.width:.3g} mm"
    elif model.cracks.faces is not None:
        cracks = f"a crack band of {count(model.band)}, {points}, width {model.cracks.width:.3g} mm"
        left_out = "cracks off the band, "
    else:
        cracks = f"{count(model.band)} that may crack, {points}"
        left_out = "cracks off the band, " if model.bulk else ""
    return (
        f"modelled: {whole}{bulk}{cracks}, {softening_name(scene.material.softening)} softening, {_dimension(scene, model)}",
        f"solved: {model.active_dofs} of {model.total_dofs} unknowns"
        + (", the rest eliminated once" if model.condensation.kind == "condensed" else ", nothing condensed")
        + (f" ({model.condensation.why})" if model.condensation.why else "")
        + (f"; {model.library}" if model.condensation.kind == "petsc" else ""),
        f"left out: {left_out}crushing, time, temperature, large rotations",
    )


def _dimension(scene: Scene, model: Model) -> str:
    """Dimension of the body, and what holds its faces."""
    if model.mesh.dimension == 2:
        return f"in plane {scene.model.plane}"
    if not scene.is_extruded:
        return "in three dimensions"
    return f"in three dimensions with front and back {'held' if scene.model.plane == 'strain' else 'free'}"


def _crack_line(data: RunData) -> str:
    """What the width of the crack plane adds: to the elastic compliance, or in a band to Gf."""
    cracks, m = data.model.cracks, data.scene.material
    if not data.model.is_smeared:
        what = "the opening" if data.gauge_is_elastic else "the driven motion"
        added = 100 * data.added_compliance()
        return f"elastic compliance of {what}: +{added:.2f} % from the interface width of {cracks.width:.3g} mm"
    planes = data.last.cracks.planes
    damaged = planes.Z > planes.length * m.ft / m.E
    if not damaged.any():
        return "no crack has opened"
    count = np.bincount(planes.point[damaged])
    lengths = planes.length[damaged]
    excess = m.ft**2 * lengths.mean() / (2 * m.E * m.Gf)
    return (
        f"cracks: {damaged.sum()} damaged planes at {(count > 0).sum()} points, l_ch {lengths.min():.3g} to "
        f"{lengths.max():.3g} mm, which adds {100 * excess:.1f} % to Gf"
    )


def _overload(data: RunData) -> str:
    """A warning if the bulk would crack off the path at the peak; empty if not."""
    model, ft = data.model, data.scene.material.ft
    frame = data.frame(data.peak_row)
    over = np.concatenate([major_stress(stress) for stress in frame.stress]) / ft
    volume = np.concatenate([block.volumes() for block in model.bulk])
    share = float(volume[over > _OVERLOADED].sum() / volume.sum())
    if share < _OVERLOADED_SHARE:
        return ""
    return (
        f"warning: at the peak the bulk is pulled beyond {_OVERLOADED:g} ft in {100 * share:.0f} % of its volume, up to "
        f"{over.max():.2g} ft; it would crack off the given path"
    )


def _departure(data: RunData) -> float:
    """Mean angle between the open planes of a band and its path, degrees, weighted with their opening."""
    rotations = data.model.cracks.rotations
    if not data.model.is_smeared or rotations is None:
        return 0.0
    planes = data.last.cracks.planes
    opening = np.maximum(planes.length * planes.strain[:, 0], 0.0) * (planes.Z > 0.01 * data.scene.material.Zm)
    if not opening.any():
        return 0.0
    cosine = abs(np.einsum("ci,ci->c", planes.rotation[:, 0], rotations[planes.point, 0]))
    return float(opening @ np.degrees(np.arccos(np.minimum(cosine, 1.0))) / opening.sum())
