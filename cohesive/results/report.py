"""The printed summary of a run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from meshing.solids import Extruded

from ..elements.bulk import ElasticBlock
from ..elements.rotations import major_stress

if TYPE_CHECKING:
    from ..model.build import Model
    from ..scenes.scene import Scene
    from .result import Result

#: planes of a band that depart more than this from the path make it stiffer than a discrete crack, degrees
_DEPARTURE = 10.0

#: part of the work that no energy accounts for, beyond which a curve is not to be trusted
_UNBALANCED = 0.05

#: major stress in the elastic bulk, over ft, and the part of its volume beyond it, which cannot be without cracks off the path
_OVERLOADED, _OVERLOADED_SHARE = 1.5, 0.1


def summary(result: Result) -> str:
    """What was modelled, what came out, and what to be wary of."""
    h, w = result.history, "l_ch" if result.model.is_smeared else "w"
    lines = [result.scene.title, *describe(result.scene, result.model), *result.notes, *warnings(result)]
    if not len(h["step"]):
        return "\n".join([*lines, "no step converged"])
    full = ""
    if result.full_energy is not None:
        left = 1.0 - h["dissipated"][-1] / result.full_energy
        rest = f"{100 * left:.1f} % is left" if left >= 0 else "sliding takes more, and contact returns some of it"
        full = f" of {result.full_energy:.5g} N mm = (Gf + ft^2 {w} / 2E) x crack area; {rest}"
    last = h["load"][-1] / max(abs(h["load"]).max(), 1e-300)
    energies = {name: float(h[name][-1]) for name in ("elastic", "stored", "dissipated", "contact_work")}
    timings = ", ".join(f"{name} {seconds:.2f}" for name, seconds in result.timings.items())
    lines += [
        f"peak load: {result.peak_load:.5g} N at opening {result.opening_at_peak:.4g} mm",
        f"dissipated: {h['dissipated'][-1]:.5g} N mm{full}; the last load is {100 * last:.1f} % of the largest",
        f"energy balance: work {h['work'][-1]:.5g} = "
        + " + ".join(f"{name.replace('_', ' ')} {value:.5g}" for name, value in energies.items())
        + f" N mm, error {result.energy_error:.1e} of the work"
        + (": smaller steps will close it" if result.energy_error > 1e-2 else ""),
        _of_the_crack(result),
        f"steps: {len(h['step'])}, iterations: {result.iterations}, cuts: {int(h['cuts'].sum())}; seconds: {timings}",
    ]
    if result.reference is not None:
        checks = result.reference.check(h["opening"], h["load"])
        lines.append(f"{result.reference.label}: {sum(c[3] for c in checks)} of {len(checks)} points inside the band")
        lines += [
            f"  outside at {x:g} mm: {y:.4g} N, {100 * abs(away):.1f} % {'below' if away < 0 else 'above'} the band"
            for x, y, away, inside in checks
            if not inside
        ]
    return "\n".join(lines)


def warnings(result: Result) -> list[str]:
    """What a reader of the curve should be wary of."""
    load, found = result.history["load"], []
    if not len(load):
        return []
    peak = int(load.argmax())
    if result.peak_load <= 0:
        found.append(f"warning: no load is positive, they go down to {load.min():.5g} N; check the direction of the drive")
    elif peak in (0, len(load) - 1):
        which = "first" if peak == 0 < len(load) - 1 else "last"
        found.append(f"warning: the largest load comes with the {which} step; the true peak may lie outside")
    if result.energy_error > _UNBALANCED:
        found.append(
            f"warning: {100 * result.energy_error:.0f} % of the work are unaccounted for; the steps are too large, or the "
            "crack has snapped"
        )
    if not result.model.is_smeared and (overload := _overload(result)):
        found.append(overload)
    locking = {block.kind for block in result.model.band} & {"triangle", "tetra"}
    if locking:
        found.append(f"warning: first-order {locking.pop()} elements lock in a band: peak and energy are too high")
    departure = _departure(result)
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
    bulk = count(model.blocks, "linear elastic ") + " and " if model.blocks else ""
    points = f"{len(model.cracks.weights)} points"
    left_out = "cracks off the given path, "
    if not model.is_smeared:
        cracks = f"{len(model.mesh.cells[-1].data)} zero-thickness crack cells, {points}, width {model.cracks.width:.3g} mm"
    elif model.cracks.faces is not None:
        cracks = f"a crack band of {count(model.band)}, {points}, width {model.cracks.width:.3g} mm"
        left_out = "cracks off the band, "
    else:
        cracks = f"{count(model.band)} that may crack, {points}"
        left_out = "cracks off the band, " if model.blocks else ""
    return (
        f"modelled: {whole}{bulk}{cracks}, {_space(scene, model)}",
        f"solved: {model.active_dofs} of {model.total_dofs} unknowns"
        + (", the rest eliminated once" if model.condensation.kind == "condensed" else ", nothing condensed")
        + (f" ({model.condensation.why})" if model.condensation.why else "")
        + (f"; {model.library}" if model.condensation.kind == "petsc" else ""),
        f"left out: {left_out}crushing, time, temperature, large rotations",
    )


def _space(scene: Scene, model: Model) -> str:
    """Of what dimension, and what holds the faces of a body of some thickness."""
    if model.mesh.points.shape[1] == 2:
        return f"in plane {scene.model.plane}"
    if not isinstance(scene.specimen, Extruded):
        return "in three dimensions"
    return f"in three dimensions with front and back {'held' if scene.model.plane == 'strain' else 'free'}"


def _of_the_crack(result: Result) -> str:
    """What the width of the crack plane does."""
    cracks, m = result.model.cracks, result.scene.material
    if not result.model.is_smeared:
        what = "the opening" if result.gauge_is_elastic else "the driven motion"
        added = 100 * result.added_compliance()
        return f"elastic compliance of {what}: +{added:.2f} % from the interface width of {cracks.width:.3g} mm"
    planes = result.last.cracks.planes
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


def _overload(result: Result) -> str:
    """Whether the elastic bulk carries at the peak what would crack it elsewhere, in words."""
    model, ft = result.model, result.scene.material.ft
    frame = result.frame(int(result.history["load"].argmax()))
    over = np.concatenate([major_stress(stress) for stress in frame.stress]) / ft
    volume = np.concatenate([block.volumes() for block in model.blocks])
    share = float(volume[over > _OVERLOADED].sum() / volume.sum())
    if share < _OVERLOADED_SHARE:
        return ""
    return (
        f"warning: at the peak the bulk is pulled beyond {_OVERLOADED:g} ft in {100 * share:.0f} % of its volume, up to "
        f"{over.max():.2g} ft; it would crack off the given path"
    )


def _departure(result: Result) -> float:
    """Mean angle between the open planes of a band and its path, degrees, weighted with their opening."""
    rotations = result.model.cracks.rotations
    if not result.model.is_smeared or rotations is None:
        return 0.0
    planes = result.last.cracks.planes
    opening = np.maximum(planes.length * planes.strain[:, 0], 0.0) * (planes.Z > 0.01 * result.scene.material.Zm)
    if not opening.any():
        return 0.0
    cosine = abs(np.einsum("ci,ci->c", planes.rotation[:, 0], rotations[planes.point, 0]))
    return float(opening @ np.degrees(np.arccos(np.minimum(cosine, 1.0))) / opening.sum())
