"""One orientation for the faces of a surface and the edges of a path."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from ..arrays import Index, Mask
from ..errors import MeshError
from .stars import numbered


def flipped(name: str, faces: Index) -> tuple[Mask, Index]:
    """Which faces to flip for neighbours to have the same sense as the first face of their sheet, and the sheet of each.

    A sheet goes on over edges that two faces share, and ends where more of them meet.

    Parameters
    ----------
    name : of the set, for messages.
    faces : (n, k) corners.

    Raises
    ------
    MeshError
        For a surface with only one side.
    """
    n, k = faces.shape
    ring = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    edge = numbered(ring, directed=False)
    order = np.argsort(edge, kind="stable")
    first = np.flatnonzero(np.bincount(edge)[edge[order]] == 2)[::2]
    one, other = order[first], order[first + 1]
    agree = ring[one, 0] != ring[other, 0]
    i, j = one // k, other // k
    # face i as it is has the number i, flipped n + i
    graph = sp.coo_array(
        (np.ones(2 * len(i)), (np.r_[i, n + i], np.r_[np.where(agree, j, n + j), np.where(agree, n + j, j)])),
        shape=(2 * n, 2 * n),
    )
    _, group = connected_components(graph, directed=False)
    same, against = group[:n], group[n:]
    if (same == against).any():
        raise MeshError.at(
            "crack", f" = '{name}': this surface has only one side, as a Moebius strip; expected one with two sides"
        )
    _, start, sheet = np.unique(np.minimum(same, against), return_index=True, return_inverse=True)
    return np.asarray(same != same[start][sheet]), np.asarray(sheet)


def chained(edges: Index) -> Index:
    """Edges (n, 2), each in the direction in which it continues its neighbour, from an end of the path if there is one."""
    neighbours: dict[int, list[int]] = {}
    for i, (a, b) in enumerate(edges.tolist()):
        neighbours.setdefault(a, []).append(i)
        neighbours.setdefault(b, []).append(i)
    ends = [node for node, at in neighbours.items() if len(at) != 2]
    done = np.zeros(len(edges), dtype=bool)
    directed = edges.copy()
    for start in [*sorted(ends), *edges[:, 0].tolist()]:
        pending = [start]
        while pending:
            node = pending.pop()
            for i in neighbours[node]:
                if not done[i]:
                    done[i] = True
                    if directed[i, 0] != node:
                        directed[i] = directed[i, ::-1]
                    pending.append(int(directed[i, 1]))
    return directed
