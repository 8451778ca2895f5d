"""Crack planes in an element: frames, the transformation of stress to them, and the element's length across them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: index pairs of the stress components, by the dimension of space; strains have engineering shear
PAIRS = {2: ((0, 0), (1, 1), (0, 1)), 3: ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))}


def stress_transformation(frame: Array) -> Array:
    """N of eq. (22) and appendix A: stress to the tractions on planes, (n, d, k); its transpose takes local to global strains.

    Parameters
    ----------
    frame : (n, d, d) array, rows normal and tangents of each plane, d = 2 or 3; k = 3 or 6 stress components.
    """
    normal = frame[:, :1, :]
    columns = []
    for i, j in PAIRS[frame.shape[2]]:
        column = normal[..., i] * frame[..., j]
        columns.append(column if i == j else column + normal[..., j] * frame[..., i])
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


def longest_chord(corners: Array, direction: Array) -> Array:
    """Length of the longest chord of convex polygons or polyhedra along directions: l_ch, (n,), mm.

    Parameters
    ----------
    corners : (n, m, 2) array, counter-clockwise, or (n, 8, 3) array, hexahedra with plane faces (of a warped one the mean
        plane counts); a shape with fewer corners repeats its last one.
    direction : (n, d) array, unit vectors.
    """
    on_face, outward, candidates = (_polygon if corners.shape[2] == 2 else _hexahedron)(corners, direction)
    rate = np.einsum("nex,nx->ne", outward, direction)
    rate[abs(rate) < 1e-9 * np.linalg.norm(outward, axis=2).max(axis=1, keepdims=True)] = 0.0
    # distance of each candidate v from each face e, seen from inside
    distance = np.einsum("nex,nvex->nve", outward, on_face[:, None] - candidates[:, :, None])
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = distance / rate[:, None, :]
    ahead = np.where(rate[:, None] > 0, reach, np.inf).min(axis=2)
    behind = np.where(rate[:, None] < 0, reach, -np.inf).max(axis=2)
    return np.asarray((ahead - behind).max(axis=1))


def _polygon(corners: Array, direction: Array) -> tuple[Array, Array, Array]:
    """A point on each side, its outward normal times its length, and points one of which is on the longest chord: a corner."""
    edge = np.roll(corners, -1, axis=1) - corners
    return corners, np.stack([edge[..., 1], -edge[..., 0]], axis=2), corners


#: faces, seen counter-clockwise from outside, and edges of a hexahedron
_FACES = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
_EDGES = [(a, b) for a in range(8) for b in range(a + 1, 8) if sum({a, b} <= set(face) for face in _FACES) == 2]


def _hexahedron(corners: Array, direction: Array) -> tuple[Array, Array, Array]:
    """As `_polygon`; the longest chord passes through a corner or from one edge to another."""
    face = corners[:, _FACES]
    outward = 0.5 * np.cross(face[:, :, 2] - face[:, :, 0], face[:, :, 3] - face[:, :, 1])
    begin, end = (corners[:, [edge[side] for edge in _EDGES]] for side in (0, 1))
    along = end - begin
    across = np.cross(along, direction[:, None])
    # begin_i + t along_i lies on edge j or behind it; a point beside the crossing does no harm
    with np.errstate(divide="ignore", invalid="ignore"):
        t = np.einsum("nijx,njx->nij", begin[:, None] - begin[:, :, None], across) / np.einsum("nix,njx->nij", along, across)
    t = np.clip(np.where(np.isfinite(t), t, 0.0), 0.0, 1.0)
    crossings = begin[:, :, None] + t[..., None] * along[:, :, None]
    return face.mean(axis=2), outward, np.concatenate([corners, crossings.reshape(len(corners), -1, 3)], axis=1)


def frames(normal: Array) -> Array:
    """Rows normal and tangents, (n, d, d). In the plane the normal is the tangent turned by +90 degrees. In space the first
    tangent is normal x z, which is that of the plane where the normal lies in it, or normal x x where the normal is close
    to z. The law is isotropic in the crack's plane: nothing but the two shear components themselves depends on them."""
    if normal.shape[1] == 2:
        return np.stack([normal, np.stack([normal[:, 1], -normal[:, 0]], axis=1)], axis=1)
    aside = np.where(abs(normal[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    first = np.cross(normal, aside)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([normal, first, np.cross(normal, first)], axis=1)
