"""The elements along the crack path against the size that is chosen by rule, whether a file or a specimen gave them."""

from __future__ import annotations

import numpy as np

from ..scenes.inputs import ELEMENTS_IN_ZONE
from .mesh import CrackedMesh

#: elements along a crack by rule, in the plane, and along the root of a crack's area in space
_ALONG = {2: 20, 3: 12}

#: from this multiple of the rule's size on, by dimension, elements of first order cost more than 1 % of the peak on beams and
#: panels, and those of second order from twice as much on
_COARSE = {2: 1.25, 3: 1.6}


def path_size_note(mesh: CrackedMesh, zone_length: float, crack_length: float, extruded: bool) -> str:
    """A warning if elements along the path are much longer than the rule's size; empty if not, or without a path.

    Parameters
    ----------
    zone_length : see `LawKeys.zone_length`, mm
    crack_length : of the crack, mm; in space the root of its area
    extruded : whether a plane mesh was extruded: layers through the thickness may be thicker.
    """
    if mesh.faces is None:
        return ""
    corners = np.asarray(mesh.closed, dtype=float)[mesh.minus_faces][..., : 2 if extruded else None]
    sides = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2).max(axis=1)
    number = _ALONG[mesh.dimension]
    rule = min(crack_length / number, zone_length / ELEMENTS_IN_ZONE)
    order = 1 if mesh.faces.data.shape[1] == 2 * corners.shape[1] else 2
    limit = _COARSE[mesh.dimension] * rule * order
    count = int((sides > limit).sum())
    if not count:
        return ""
    return (
        f"warning: {count} of the {len(sides)} elements along the crack are longer than {limit:.3g} mm, up to "
        f"{sides.max():.3g} mm; the peak may come out more than 1 % too high, and the load fall in ripples: by rule they are "
        f"{rule:.3g} mm, the smaller of 1/{number} of the crack length and 1/{ELEMENTS_IN_ZONE} of E Gf/ft^2"
    )
