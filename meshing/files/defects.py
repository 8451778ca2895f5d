"""What is wrong with the elements of a user's mesh: given twice, on top of one another, folded, not joined.

Seen exactly: elements given twice, a facet with two elements on one side, folded elements. Elements that lie on others
without sharing a facet are found by points just inside each facet of the boundary, which belong to one element only: an
overlap that contains no such point, narrower than the facets around it, is not seen. Curved edges count as straight.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from ..arrays import Array, Index, Mask
from ..cells import CELLS
from ..cutting.pieces import pieces
from ..cutting.stars import Blocks, Star, distinct, numbered
from ..errors import MeshError
from ..paths import as_text
from .limits import refused

#: nodes are at the same place if they are closer than this part of the shortest edge of the mesh that ends in them
_NEAR = 1e-3

#: a node is on an edge or face if it is closer to it than this part of its size
_ON = 1e-6

#: how far points inside a boundary facet are from it, on the way to the centre of its element
_INSIDE = 0.02


class _Named(NamedTuple):
    """The elements of some blocks, by running number."""

    path: Path
    points: Array
    blocks: Blocks

    def refused(self, what: str) -> MeshError:
        """The error of the file."""
        return refused(self.path, what)

    def text(self, i: int) -> str:
        """Its type, its number, and its middle."""
        first = 0
        for kind, block in self.blocks:
            if i < first + len(block):
                return f"{kind} {i} at {as_text(self.points[block[i - first, : CELLS[kind].n_corners]].mean(axis=0))}"
            first += len(block)
        raise IndexError(i)


def check_elements(path: Path, points: Array, blocks: Blocks) -> list[str]:
    """Refuse elements that no body consists of, and say what is odd.

    Parameters
    ----------
    path : of the file, for messages
    points : (m, d)
    blocks : 2D elements counter-clockwise, 3D elements with a positive volume; facets alike.

    Returns
    -------
    remarks : a sentence each: nodes that are at the same place and not shared, as along a slit.

    Raises
    ------
    MeshError
        Naming elements and their number.
    """
    named = _Named(path, points, blocks)
    _check_repeats(named)
    if points.shape[1] == 2:
        _check_folded(named)
    star = Star.from_cells(blocks)
    _check_sides(named, star)
    single = np.flatnonzero(np.bincount(star.facet)[star.facet] == 1)
    _check_overlaps(named, star, single)
    return _not_joined(named, star, single)


def _check_repeats(named: _Named) -> None:
    """Refuse elements with the same corners."""
    first = np.cumsum([0, *(len(block) for _, block in named.blocks)])
    for kind in dict.fromkeys(kind for kind, _ in named.blocks):
        own = [(i, block) for i, (each, block) in zip(first[:-1].tolist(), named.blocks, strict=True) if each == kind]
        number = np.concatenate([i + np.arange(len(block)) for i, block in own])
        corners = np.sort(np.concatenate([block for _, block in own])[:, : CELLS[kind].n_corners], axis=1)
        order = np.lexsort(corners.T)
        same = np.flatnonzero((corners[order][1:] == corners[order][:-1]).all(axis=1))
        if len(same):
            one, other = np.sort(number[order[same[0] : same[0] + 2]]).tolist()
            raise named.refused(
                f"{named.text(other)} has the corners of {kind} {one}, {len(same)} in all are given twice; "
                "expected each element once",
            )


def _check_folded(named: _Named) -> None:
    """Refuse 2D elements that are flat, folded or not convex."""
    bad: list[int] = []
    first = 0
    for kind, block in named.blocks:
        p = named.points[block[:, : CELLS[kind].n_corners]]
        out, back = np.roll(p, -1, axis=1) - p, np.roll(p, 1, axis=1) - p
        turn = out[..., 0] * back[..., 1] - out[..., 1] * back[..., 0]
        least = 1e-9 * np.ptp(p, axis=1).max(axis=1)[:, None] ** 2
        bad += (first + np.flatnonzero((turn < -least).any(axis=1) | ~(turn > least).any(axis=1))).tolist()
        first += len(block)
    if bad:
        raise named.refused(
            f"{named.text(bad[0])} is flat, folded or not convex, {len(bad)} in all; expected convex "
            "elements with an area, corners in a ring",
        )


def _check_sides(named: _Named, star: Star) -> None:
    """Refuse a facet with two elements on one side, or with a mid node for each side."""
    corners = star.nodes[:, : star.corners]
    what = "an edge" if star.corners == 2 else "a face"
    directed = numbered(corners, directed=True)
    twice = np.flatnonzero((np.bincount(directed)[directed] > 1) & (distinct(corners) >= min(star.corners, 3)))
    if len(twice):
        one, other = star.cell[np.flatnonzero(directed == directed[twice[0]])[:2]].tolist()
        raise named.refused(
            f"{named.text(one)} and {named.text(other)} are on the same side of {what} that they share, "
            f"{len(np.unique(star.cell[twice]))} elements in all overlap so; expected one on each side",
        )
    if star.nodes.shape[1] == star.corners:
        return
    stands_in = np.isin(star.nodes[:, star.corners], corners)  # a corner, as across a band
    order = np.argsort(star.facet + stands_in * len(star.facet), kind="stable")[: int((~stands_in).sum())]
    mids = np.sort(star.nodes[:, star.corners :], axis=1)[order]
    torn = np.flatnonzero((star.facet[order][1:] == star.facet[order][:-1]) & (mids[1:] != mids[:-1]).any(axis=1))
    if len(torn):
        one, other = star.cell[order[torn[0] : torn[0] + 2]].tolist()
        raise named.refused(
            f"{named.text(one)} and {named.text(other)} share the corners of {what} but not its mid node, "
            f"{len(torn)} in all; expected shared nodes",
        )


def _check_overlaps(named: _Named, star: Star, single: Index) -> None:
    """Refuse points just inside the boundary that belong to a second element."""
    elements = _Convex.from_blocks(named.points, named.blocks)
    corners = named.points[star.nodes[single, : star.corners]]
    middle = corners.mean(axis=1)
    pairs: set[tuple[int, int]] = set()
    for at in (middle, *(0.1 * middle + 0.9 * corners[:, i] for i in range(star.corners))):
        inside = at + _INSIDE * (elements.centre[star.cell[single]] - at)
        for point, element in elements.around(inside):
            hit = element != star.cell[single][point]
            hit[hit] = elements.contain(element[hit], inside[point[hit]])
            pairs |= set(zip(star.cell[single][point[hit]].tolist(), element[hit].tolist(), strict=True))
    if pairs:
        one, other = min(pairs)
        raise named.refused(
            f"{named.text(one)} lies on {named.text(other)}, {len({i for i, _ in pairs})} elements at the "
            "boundary in all overlap others; expected elements side by side",
        )


@dataclass(frozen=True)
class _Convex:
    """Elements as convex bodies: each of n is where normal . x < offset for all of its sides.

    Attributes
    ----------
    centre, radius : (n, d) and (n,) arrays
    normal, offset : (n, s, d) and (n, s) arrays; a side that an element lacks has the offset inf
    """

    centre: Array
    radius: Array
    normal: Array
    offset: Array

    @classmethod
    def from_blocks(cls, points: Array, blocks: Blocks) -> _Convex:
        d, most = points.shape[1], max(len(CELLS[kind].facets) for kind, _ in blocks)
        parts = []
        for kind, block in blocks:
            cell = CELLS[kind]
            p = points[block[:, : cell.n_corners]]
            facets = points[block[:, np.array(cell.facets)[:, : cell.facet_corners]]]
            if d == 2:
                edge = facets[:, :, 1] - facets[:, :, 0]
                normal = np.stack([edge[..., 1], -edge[..., 0]], axis=2)
            else:  # those of cells point inwards
                normal = -np.cross(facets[:, :, 2] - facets[:, :, 0], facets[:, :, -1] - facets[:, :, 1])
            normal /= np.maximum(np.linalg.norm(normal, axis=2, keepdims=True), 1e-300)
            offset = np.einsum("nsd,nsd->ns", normal, facets.mean(axis=2))
            lacking = most - len(cell.facets)
            centre = p.mean(axis=1)
            parts.append(
                (
                    centre,
                    np.linalg.norm(p - centre[:, None], axis=2).max(axis=1),
                    np.pad(normal, ((0, 0), (0, lacking), (0, 0))),
                    np.pad(offset, ((0, 0), (0, lacking)), constant_values=np.inf),
                )
            )
        return cls(*(np.concatenate(part) for part in zip(*parts, strict=True)))

    def around(self, at: Array) -> Iterator[tuple[Index, Index]]:
        """Pairs of points (k, d) and elements that may contain them; elements of like size at a time."""
        size = np.floor(np.log2(np.maximum(self.radius, 1e-300))).astype(np.int64)
        tree = cKDTree(at)
        for each in np.unique(size):
            elements = np.flatnonzero(size == each)
            near = tree.query_ball_point(self.centre[elements], self.radius[elements])
            count = np.array([len(points) for points in near])
            if count.any():
                yield np.concatenate([points for points in near if points]).astype(np.int64), np.repeat(elements, count)

    def contain(self, element: Index, at: Array) -> Mask:
        """Whether elements contain points, well inside."""
        depth = self.offset[element] - np.einsum("ksd,kd->ks", self.normal[element], at)
        return np.asarray((depth > 1e-3 * self.radius[element, None]).all(axis=1))


def _not_joined(named: _Named, star: Star, single: Index) -> list[str]:
    """Refuse a body in pieces that touch where they share no nodes; a remark of a slit."""
    points = named.points
    corners = star.nodes[single, : star.corners]
    nodes = np.unique(corners)
    ring = points[corners]
    edge = np.linalg.norm(ring - np.roll(ring, -1, axis=1), axis=2)
    shortest = np.full(len(points), np.inf)
    for i in range(star.corners):
        np.minimum.at(shortest, corners[:, i], np.minimum(edge[:, i], edge[:, i - 1]))
    distance, other = cKDTree(points[nodes]).query(points[nodes], k=2)
    near = distance[:, 1] < _NEAR * np.minimum(shortest[nodes], shortest[nodes[other[:, 1]]])
    hanging = nodes[~near][_on_facets(points, nodes[~near], corners)]
    at = np.concatenate([nodes[near], hanging])
    if not len(at):
        return []
    where = f"{len(at)} nodes of the boundary touch elements that do not have them, the first at {as_text(points[at[0]])}"
    label = pieces(named.blocks)
    if label.max():
        raise named.refused(
            f"the body is in {int(label.max()) + 1} pieces, and {where}; expected elements that share nodes",
        )
    return [f"warning: {where}: a slit there; expected shared nodes if it is none"]


def _on_facets(points: Array, nodes: Index, corners: Index) -> Mask:
    """Which nodes lie on facets, corners (n, k), that do not have them: within them, or on an edge in space."""
    ring = points[corners]
    centre, is_on = ring.mean(axis=1), np.zeros(len(nodes), dtype=bool)
    radius = np.linalg.norm(ring - centre[:, None], axis=2).max(axis=1)
    near = cKDTree(points[nodes]).query_ball_point(centre, radius * (1 + _ON))
    count = np.array([len(each) for each in near])
    if not count.any():
        return is_on
    facet = np.repeat(np.arange(len(corners)), count)
    node = np.concatenate([each for each in near if each]).astype(np.int64)
    strange = ~(corners[facet] == nodes[node][:, None]).any(axis=1)
    facet, node = facet[strange], node[strange]
    p, size = points[nodes[node]], radius[facet]
    a, b = ring[facet, 0], ring[facet, 1]
    if points.shape[1] == 2:
        along = (b - a) / np.linalg.norm(b - a, axis=1, keepdims=True)
        off = abs(along[:, 0] * (p - a)[:, 1] - along[:, 1] * (p - a)[:, 0])
        is_on[node[off < _ON * size]] = True
        return is_on
    normal = np.cross(b - a, ring[facet, 2] - a)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    on = abs(np.einsum("kd,kd->k", normal, p - a)) < _ON * size
    for i in range(corners.shape[1]):
        start, end = ring[facet, i], ring[facet, (i + 1) % corners.shape[1]]
        on &= np.einsum("kd,kd->k", np.cross(normal, end - start), p - start) > -_ON * size**2
    is_on[node[on]] = True
    return is_on
