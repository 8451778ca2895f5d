"""Length of an element across a crack plane, l_ch: its longest chord."""

from __future__ import annotations

import numpy as np

from ..arrays import Array


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
