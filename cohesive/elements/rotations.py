"""Frames of crack planes, components of stress and strain, and their transformation to planes."""

from __future__ import annotations

import numpy as np

from ..arrays import Array

#: index pairs of the stress components, by the dimension of space; strains have engineering shear
PAIRS = {2: ((0, 0), (1, 1), (0, 1)), 3: ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))}


def stress_transformation(rotation: Array) -> Array:
    """N of eq. (22) and appendix A: stress to the tractions on planes, (n, d, k); its transpose takes local to global strains.

    Parameters
    ----------
    rotation : (n, d, d) array, rows normal and tangents of each plane, d = 2 or 3; k = 3 or 6 stress components.
    """
    normal = rotation[:, :1, :]
    columns = []
    for i, j in PAIRS[rotation.shape[2]]:
        column = normal[..., i] * rotation[..., j]
        columns.append(column if i == j else column + normal[..., j] * rotation[..., i])
    return np.stack(columns, axis=2)


def stress_tensor(stress: Array) -> Array:
    """(n, k) stress components as (n, d, d) tensors."""
    d = 2 if stress.shape[1] == 3 else 3
    tensor = np.empty((len(stress), d, d))
    for column, (i, j) in enumerate(PAIRS[d]):
        tensor[:, i, j] = tensor[:, j, i] = stress[:, column]
    return tensor


def major_strain(strain: Array) -> Array:
    """Largest principal strain of (n, k) strains with engineering shear, in the plane if the components are, (n,)."""
    share = np.array([1.0 if i == j else 0.5 for i, j in PAIRS[2 if strain.shape[1] == 3 else 3]])
    return np.asarray(np.linalg.eigvalsh(stress_tensor(share * strain))[:, -1])


def rotations(normal: Array) -> Array:
    """Rows normal and tangents, (n, d, d). In the plane the normal is the tangent turned by +90 degrees. In space the first
    tangent is normal x z, which is that of the plane where the normal lies in it, or normal x x where the normal is close
    to z. The law is isotropic in the crack's plane: nothing but the two shear components themselves depends on them."""
    if normal.shape[1] == 2:
        return np.stack([normal, np.stack([normal[:, 1], -normal[:, 0]], axis=1)], axis=1)
    aside = np.where(abs(normal[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    first = np.cross(normal, aside)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([normal, first, np.cross(normal, first)], axis=1)


def major_stress(stress: Array) -> Array:
    """Largest principal stress, in the plane if the components are, (n,)."""
    if stress.shape[1] == 6:
        return np.asarray(np.linalg.eigvalsh(stress_tensor(stress))[:, -1])
    xx, yy, xy = stress.T
    return np.asarray(0.5 * (xx + yy) + np.hypot(0.5 * (xx - yy), xy))
