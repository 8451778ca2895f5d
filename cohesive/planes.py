"""Crack planes in an element: frames, the transformation of stress to them, and the element's length across them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: index pairs of the stress components, by the dimension of space
_PAIRS = {2: ((0, 0), (1, 1), (0, 1)), 3: ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))}


def stress_transformation(frame: Array) -> Array:
    """N of eq. (22) and appendix A: stress to the tractions on planes, (n, d, k); its transpose takes local to global strains.

    Parameters
    ----------
    frame : (n, d, d) array, rows normal and tangents of each plane, d = 2 or 3; k = 3 or 6 stress components.
    """
    normal = frame[:, :1, :]
    columns = []
    for i, j in _PAIRS[frame.shape[2]]:
        column = normal[..., i] * frame[..., j]
        columns.append(column if i == j else column + normal[..., j] * frame[..., i])
    return np.stack(columns, axis=2)


def stress_tensor(stress: Array) -> Array:
    """(n, k) stress components as (n, d, d) tensors."""
    d = 2 if stress.shape[1] == 3 else 3
    tensor = np.empty((len(stress), d, d))
    for column, (i, j) in enumerate(_PAIRS[d]):
        tensor[:, i, j] = tensor[:, j, i] = stress[:, column]
    return tensor


def longest_chord(corners: Array, direction: Array) -> Array:
    """Length of the longest chord of convex polygons along directions: l_ch, (n,), mm.

    Parameters
    ----------
    corners : (n, m, 2) array, counter-clockwise; a polygon with fewer than m repeats its last corner.
    direction : (n, 2) array, unit vectors.
    """
    edge = np.roll(corners, -1, axis=1) - corners
    outward = np.stack([edge[..., 1], -edge[..., 0]], axis=2)
    rate = np.einsum("nex,nx->ne", outward, direction)
    rate[abs(rate) < 1e-9 * np.linalg.norm(edge, axis=2).max(axis=1, keepdims=True)] = 0.0
    # the longest chord passes through a corner: distance of each corner v from each edge e, seen from inside
    distance = np.einsum("nex,nvex->nve", outward, corners[:, None] - corners[:, :, None])
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = distance / rate[:, None, :]
    ahead = np.where(rate[:, None] > 0, reach, np.inf).min(axis=2)
    behind = np.where(rate[:, None] < 0, reach, -np.inf).max(axis=2)
    return np.asarray((ahead - behind).max(axis=1))


def frames(normal: Array) -> Array:
    """Rows normal and tangents, (n, d, d); in the plane the normal is the tangent turned by +90 degrees."""
    return np.stack([normal, np.stack([normal[:, 1], -normal[:, 0]], axis=1)], axis=1)
