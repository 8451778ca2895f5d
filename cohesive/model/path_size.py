"""The elements along the crack path of a user's mesh against the size that a built-in specimen would have."""

from __future__ import annotations

import numpy as np

from ..law.concrete import Concrete
from ..scenes.inputs import ELEMENTS_IN_ZONE
from .mesh import CrackedMesh

#: elements along a crack in the plane, and along the root of a crack's area in space
_ALONG = {2: 25, 3: 12}

#: elements are too long if they pass the rule's size by more than this
_SLACK = 1.01


def path_size_note(mesh: CrackedMesh, concrete: Concrete, crack_length: float) -> str:
    """A warning if elements along the path are longer than the rule's size; empty if not, or without a path.

    Parameters
    ----------
    crack_length : of the crack, mm; in space the root of its area
    """
    if mesh.faces is None:
        return ""
    corners = np.asarray(mesh.closed, dtype=float)[mesh.minus_faces]
    sides = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2).max(axis=1)
    number = _ALONG[mesh.dimension]
    rule = min(crack_length / number, concrete.zone_length / ELEMENTS_IN_ZONE)
    count = int((sides > _SLACK * rule).sum())
    if not count:
        return ""
    return (
        f"warning: {count} of the {len(sides)} elements along the crack are longer than {rule:.3g} mm, up to "
        f"{sides.max():.3g} mm; the peak may come out too high: elsewhere they are by rule the smaller of 1/{number} of the "
        f"crack length and 1/{ELEMENTS_IN_ZONE} of E Gf/ft^2"
    )
