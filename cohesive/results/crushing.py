"""Compression of the bulk beyond its strength, which the model leaves out: long tails and hinges hide it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import cKDTree

from meshing.paths import as_text

from ..arrays import Array, Index, Mask
from ..elements.rotations import major_stress
from ..model.boundary import nodes_at
from .run_data import spread

if TYPE_CHECKING:
    from .run_data import RunData

#: compressive strength over tensile strength, if none is given
_FC_OVER_FT = 10.0

#: elements closer than this times their own size to a load or support, or than a part of the body's narrowest side, do not
#: count: the stress under a point load has no limit
_ELEMENTS_BESIDE, _PART_BESIDE = 2.0, 0.05

#: rows that are looked at, besides the peak, the last one and the one that presses the crack most
_ROWS = 5


def crushing(data: RunData) -> str:
    """A warning if the bulk is compressed beyond its strength outside of loads and supports, empty if not: principal stress,
    place, multiple and step. Some rows are looked at, not all."""
    m, fields = data.scene.material, data.fields
    fc = _FC_OVER_FT * m.ft if m.fc is None else m.fc
    blocks = [*fields.bulk, *fields.band]
    regions = np.concatenate([*fields.mesh.regions, *(np.zeros(len(block.cells), dtype=np.int64) for block in fields.band)])
    centres = np.concatenate([b.points[b.cells].mean(axis=1) for b in blocks])
    worst = (0.0, 0, 0)
    rows = looked_at(data.history["load"], data.history["stress_n"])
    rows = sorted({*fields.nearest(rows)})
    crushed = np.zeros(len(regions), dtype=bool)
    for row in rows:
        pressed = np.concatenate([major_stress(-stress) for stress in data.frame(row).stress])
        candidates = np.flatnonzero((pressed > fc) & (regions == 0))
        candidates = candidates[~beside_loads(data, centres[candidates])]
        if len(candidates):
            crushed[candidates] = True
            most = int(candidates[pressed[candidates].argmax()])
            worst = max(worst, (float(pressed[most]), most, row))
    if not crushed.any():
        return ""
    stress, element, row = worst
    volume = np.concatenate([block.volumes() for block in blocks])
    share = 100 * volume[crushed].sum() / volume.sum()
    of = "" if m.fc is not None else f" ({_FC_OVER_FT:g} ft)"
    return (
        f"warning: the bulk is compressed beyond fc = {fc:g} MPa{of} away from loads and supports, to {-stress:.3g} MPa, "
        f"{stress / fc:.2g} fc, at {as_text(centres[element].round(6))} in step {int(data.history['step'][row])}: "
        f"{share:.2g} % of its volume in the {len(rows)} steps looked at; crushing is left out"
    )


def looked_at(load: Array, stress: Array) -> list[int]:
    """The rows that are looked at, from the load and the mean normal traction in all rows, (rows,) each."""
    peak = 1 + int(load[1:].argmax()) if len(load) > 1 else 0
    return sorted({*spread(len(load) - 1, _ROWS), peak, int(stress.argmin())})


def beside_loads(data: RunData, places: Array) -> Mask:
    """Which places (p, d) are beside loads and supports, (p,)."""
    beside = np.zeros(len(places), dtype=bool)
    if len(places):
        nodes, radius = _loaded(data)
        near = cKDTree(places).query_ball_point(data.fields.mesh.points[nodes], radius)
        beside[np.concatenate([np.array(each, dtype=np.int64) for each in near])] = True
    return beside


def _loaded(data: RunData) -> tuple[Index, Array]:
    """Nodes where forces act, and how far from each the stress does not count, mm."""
    mesh, specimen, half = data.fields.mesh, data.scene.specimen, data.scene.model.half
    drives = specimen.drives(half=half).values()
    at = [each.at for each in specimen.held(half=half)] + [each.at for each in drives]
    at += [each.against for each in drives if each.against is not None]
    nodes = np.unique(np.concatenate([nodes_at(mesh, "supports.at", each) for each in at]))
    size = np.zeros(len(mesh.points))
    for block in (*data.fields.bulk, *data.fields.band):
        extent = np.linalg.norm(np.ptp(block.points[block.cells], axis=1), axis=1)
        np.maximum.at(size, block.cells, np.broadcast_to(extent[:, None], block.cells.shape))
    least = _PART_BESIDE * float(np.ptp(mesh.points, axis=0).min())
    return nodes, np.maximum(_ELEMENTS_BESIDE * size[nodes], least)
