"""The outline of a user's plane mesh, from its boundary, to be meshed again."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from ..arrays import Array, Index
from ..cutting.stars import Star, bulk_cells
from ..errors import MeshError
from ..generation.outline import Outline
from ..paths import SLACK, Line, as_text, signed_area
from .reading import checked, is_solid, load, named_sets


def boundary_outline(path: Path, needed: Iterable[str]) -> Outline:
    """The boundary of a plane mesh: its faces, and its sets, those along the boundary as edges, single nodes as points.

    Parameters
    ----------
    needed : names of sets that must be among these; others are left out if they are neither

    Raises
    ------
    MeshError
        As `read_mesh`; if the mesh is solid, its faces touch each other, it is in parts, or a set that is needed is neither a
        row of edges nor single nodes.
    """
    mesh = load(path)
    if is_solid(mesh):
        raise MeshError.at("crack", f" = 'grow': the mesh of '{path}' is solid, and crack fronts are given, not found")
    clean = checked(path, mesh, named_sets(mesh)[1])[0]
    star = Star.from_cells(bulk_cells(clean))
    rows = star.nodes[np.bincount(star.facet)[star.facet] == 1]  # each has the body on its left
    loops, size = _loops(path, clean.points, rows), float(np.ptp(clean.points, axis=0).max())
    edges, nodes, others = _sets(clean.point_sets, rows)
    if unfit := sorted(set(needed) & others):
        raise MeshError.at("crack", f" = 'grow': set {unfit[0]} is neither a row of edges of the boundary nor single nodes")
    ends = {chain[i] for chain in edges.values() for i in (0, -1) if chain[0] != chain[-1]}
    faces = [_simplified(clean.points, loop, ends, SLACK * size) for loop in loops]
    corners, *holes = sorted(faces, key=lambda face: -abs(signed_area(face)))
    if any(signed_area(hole) > 0 for hole in holes):
        raise MeshError.at("file", f" = '{path}': its elements are in {len(faces)} parts; expected one body")
    return Outline(
        corners,
        [],
        nodes={name: [_xy(clean.points[i]) for i in at] for name, at in nodes.items()},
        edges={name: _simplified(clean.points, chain, {chain[0], chain[-1]}, SLACK * size) for name, chain in edges.items()},
        holes=holes,
    )


def _loops(path: Path, points: Array, rows: Index) -> list[list[int]]:
    """Nodes of the closed parts of a boundary, in a row; mid nodes too, for a side may be curved."""
    first, count = np.unique(rows[:, 0], return_counts=True)
    if (count > 1).any():
        raise MeshError.at("file", f" = '{path}': its boundary meets itself at {as_text(points[first[count.argmax()]])}")
    if len(np.unique(points[first].round(9), axis=0)) < len(first):
        raise MeshError.at("file", f" = '{path}': its boundary has two nodes in one place; expected notches with a width")
    following, loops = _following(rows), []
    while following:
        loops.append(_chain(following, next(iter(following)))[:-1])
    return loops


def _following(rows: Index) -> dict[int, list[int]]:
    """The nodes of an edge after its first one, by this one."""
    return {first: [*mids, second] for first, second, *mids in rows.tolist()}


def _chain(following: dict[int, list[int]], start: int) -> list[int]:
    """Nodes in a row from a start on, whose edges are taken away."""
    chain = [start]
    while chain[-1] in following:
        chain += following.pop(chain[-1])
    return chain


def _sets(sets: dict[str, Index], rows: Index) -> tuple[dict[str, list[int]], dict[str, list[int]], set[str]]:
    """Sets of nodes that are one row of edges of the boundary, those of which no two are neighbours there, and the others."""
    chains: dict[str, list[int]] = {}
    singles: dict[str, list[int]] = {}
    for name, nodes in sets.items():
        inside = rows[np.isin(rows[:, :2], nodes).all(axis=1)]
        if not len(inside):
            singles[name] = nodes.tolist()
            continue
        following = _following(inside)
        chain = _chain(following, min({*inside[:, 0].tolist()} - {*inside[:, 1].tolist()}, default=int(inside[0, 0])))
        if not following and np.isin(nodes, chain).all():
            chains[name] = chain
    return chains, singles, sets.keys() - chains.keys() - singles.keys()


def _simplified(points: Array, nodes: list[int], kept: set[int], slack: float) -> Line:
    """Places of nodes in a closed row without those on the straight line between the last one and the next, unless they are
    kept."""
    line: list[int] = []
    for i, node in enumerate(nodes):
        ends = line[-1] if line else nodes[-1], nodes[(i + 1) % len(nodes)]
        a, b = points[ends[0]], points[ends[1]]
        (x, y), (u, v) = b - a, points[node] - a
        if node in kept or abs(x * v - y * u) > slack * np.hypot(x, y):
            line.append(node)
    return [_xy(points[node]) for node in line]


def _xy(point: Array) -> tuple[float, float]:
    return float(point[0]), float(point[1])
