"""Which rigid motions of a body its supports, drives and springs leave free.

Exact but for the geometry: every piece of the body has its rigid motions as unknowns, and the rank of the conditions on them
decides. No stiffness enters, so neither E nor rounding in a factorization does. Two pieces on either side of the crack hang
together by its interface elements, which are as stiff as concrete until they break; what comes loose then ends the run. An
element whose corners on each side are of one piece holds the two rigidly: they count as one, however many a crack cuts out.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from meshing.cells import CELLS
from meshing.cutting.pieces import pieces
from meshing.cutting.stars import distinct, owners
from meshing.paths import as_text

from ..algebra.unknowns import Constraint
from ..arrays import Array, Index
from ..errors import SceneError
from ..solver.loading import Loading
from .boundary import Boundary
from .mesh import CrackedMesh

#: a motion is free if all that resists it has arms below this part of the piece's size: coordinates of files have few digits
_ARM = 1e-6

#: more pieces than a body may have that hang together by single nodes
_MOST_PIECES = 200

_AXES = "xyz"


def check_supports(mesh: CrackedMesh, boundary: Boundary, loadings: Iterable[Loading]) -> None:
    """Refuse a body that can move as a whole, or a piece of which can, in one of the stages.

    The motion of the drive that a stage moves holds nothing: without a reaction there is no load.

    Parameters
    ----------
    loadings : of the stages, their forces do not matter

    Raises
    ------
    SceneError
        Naming the motion that is free.
    """
    bodies = _Pieces.from_mesh(mesh)
    if len(bodies.size) > _MOST_PIECES:
        raise SceneError.at(
            "specimen", f": the body is in {len(bodies.size)} pieces that share no element edges or faces; expected one body"
        )
    conditions, acting = _conditions(bodies, mesh, boundary), boundary.acting > 0
    seen: list[Array] = []
    for i, loading in enumerate(loadings):
        moved, count = loading.moved, len(acting)
        if moved.is_free_across:
            acting[moved.motions[0]] |= boundary.later[moved.motions[0]] > 0
        allowed = np.eye(count) if loading.allowed is None else loading.allowed[:count]
        allowed = np.where(acting[:, None], 0.0, allowed)
        if any(np.array_equal(allowed, before) for before in seen):
            continue
        seen.append(allowed)
        free = _free(bodies, conditions, allowed)
        if free.shape[1]:
            said, key = ("the body is not held", "specimen") if i == 0 else ("the body is held no longer", f"stage.{i}")
            raise SceneError.at(
                key, f": {said}, nothing holds {_described(bodies, free)}; expected supports against every motion"
            )


@dataclass(frozen=True)
class _Pieces:
    """Pieces of a body, each with its rigid motions: translations, then rotations, these by the motion at the piece's size.

    Attributes
    ----------
    of_node : (m,) array, a piece that the node belongs to; -1: none, as of the mirror image of a half
    hinges : (h, 2) array of nodes and further pieces that they belong to
    points : (m, d) array, mm
    centre, size : (n, d) and (n,) arrays, mm
    elements : (n,) array, how many each has
    """

    of_node: Index
    hinges: Index
    points: Array
    centre: Array
    size: Array
    elements: Index

    @classmethod
    def from_mesh(cls, mesh: CrackedMesh) -> _Pieces:
        blocks = [(block.type, block.data.astype(np.int64)) for block in (*mesh.bulk, *mesh.band)]
        label, points = pieces(blocks), np.asarray(mesh.points, dtype=float)
        nodes = np.concatenate([block.ravel() for _, block in blocks])
        element = owners(blocks, [block.shape[1] for _, block in blocks])
        label = _joined(mesh, label, nodes, label[element])
        owner, count = label[element], int(label.max()) + 1
        pairs = sp.coo_array((np.ones(len(nodes), dtype=bool), (owner, nodes)), shape=(count, len(points))).tocsr()
        owner, nodes = np.repeat(np.arange(count), np.diff(pairs.indptr)), pairs.indices.astype(np.int64)
        of_node = np.full(len(points), -1)
        of_node[nodes[::-1]] = owner[::-1]  # the first one stays
        further = of_node[nodes] != owner
        weight = np.bincount(owner, minlength=count)
        centre = np.column_stack([np.bincount(owner, points[nodes, i], count) / weight for i in range(points.shape[1])])
        size = np.zeros(count)
        np.maximum.at(size, owner, np.linalg.norm(points[nodes] - centre[owner], axis=1))
        hinges = np.column_stack([nodes[further], owner[further]])
        return cls(of_node, hinges, points, centre, size, np.bincount(label))

    @property
    def motions(self) -> int:
        """Rigid motions of a piece."""
        return 3 if self.points.shape[1] == 2 else 6

    def rows(self, nodes: Index, direction: Array, owner: Index | None = None) -> Array:
        """Motion of nodes along a direction by the rigid motions of all pieces, (k, pieces * motions)."""
        owner = self.of_node[nodes] if owner is None else owner
        arm = (self.points[nodes] - self.centre[owner]) / self.size[owner, None]
        if len(direction) == 2:
            turning = (arm[:, 0] * direction[1] - arm[:, 1] * direction[0])[:, None]
        else:
            turning = np.cross(arm, direction)
        own = np.concatenate([np.broadcast_to(direction, arm.shape), turning], axis=1)
        motion = np.zeros((len(nodes), len(self.size), self.motions))
        motion[np.arange(len(nodes)), owner] = own
        return motion.reshape(len(nodes), len(self.size) * self.motions)


def _joined(mesh: CrackedMesh, label: Index, nodes: Index, owner: Index) -> Index:
    """Pieces of the elements, those joined that crack elements hold rigidly.

    Parameters
    ----------
    label : piece of each element
    nodes, owner : each node of each element and the piece of the element
    """
    if mesh.crack is None:
        return label
    cell = CELLS[mesh.crack.type]
    sides = np.concatenate([mesh.crack.data[:, side[: cell.facet_corners]] for side in cell.sides])
    count, cells = int(label.max()) + 1, len(mesh.crack.data)
    belongs = sp.coo_array((np.ones(len(nodes)), (nodes, owner)), shape=(len(mesh.points), count)).tocsr()
    belongs.data[:] = 1.0
    corners = sp.coo_array(
        (np.ones(sides.size), (np.repeat(np.arange(len(sides)), sides.shape[1]), sides.ravel())),
        shape=(len(sides), len(mesh.points)),
    )
    found = (corners.tocsr() @ belongs).tocoo()  # corners of a side that are of a piece
    whole = (found.data == sides.shape[1]) & (distinct(sides)[found.row] >= mesh.dimension)
    side, piece = found.row[whole], found.col[whole]
    graph = sp.coo_array((np.ones(len(side)), (piece, count + side % cells)), shape=(count + cells, count + cells))
    joined = connected_components(graph, directed=False)[1][:count]
    return np.asarray(np.unique(joined[label], return_inverse=True)[1])


@dataclass(frozen=True)
class _Conditions:
    """What must vanish: pieces @ a + motions @ q + rotations @ r, of rigid motions, driven motions and hinges' rotations."""

    pieces: Array
    motions: Array
    rotations: Array


def _conditions(bodies: _Pieces, mesh: CrackedMesh, boundary: Boundary) -> _Conditions:
    """Of supports, drives, mirror, crack, and hinges between pieces."""
    constraints = [*boundary.supports, *boundary.motions]
    hinged = [i for i, each in enumerate(constraints) if each.lever is not None]
    parts = []
    for i, constraint in enumerate(constraints):
        is_there = bodies.of_node[constraint.nodes] >= 0
        nodes = constraint.nodes[is_there]
        motion, rotation = i - len(boundary.supports), hinged.index(i) if i in hinged else None
        rows = bodies.rows(nodes, np.asarray(constraint.direction))
        motions, rotations = np.zeros((len(rows), len(boundary.motions))), np.zeros((len(rows), len(hinged)))
        if motion >= 0:
            motions[:, motion] = -constraint.factor
        if rotation is not None:
            assert constraint.lever is not None
            rotations[:, rotation] = -constraint.lever[is_there]
        part = [rows, motions, rotations]
        if motion >= 0 and not _holds_jumps(mesh, constraint):
            part = [_sums(mesh.representative[nodes], each) for each in part]
        parts.append(part)
    tied = []
    if boundary.mirror is not None:
        nodes = np.flatnonzero(np.isin(np.arange(len(bodies.of_node)), boundary.mirror.nodes) & (bodies.of_node >= 0))
        tied.append(bodies.rows(nodes, np.asarray(boundary.mirror.direction)))
    minus, plus = _across(bodies, mesh)
    nodes, other = bodies.hinges.T
    for direction in np.eye(mesh.dimension):
        tied.append(bodies.rows(minus, direction) - bodies.rows(plus, direction))
        tied.append(bodies.rows(nodes, direction) - bodies.rows(nodes, direction, other))
    parts += [[rows, np.zeros((len(rows), len(boundary.motions))), np.zeros((len(rows), len(hinged)))] for rows in tied]
    return _Conditions(*(np.concatenate(part) for part in zip(*parts, strict=True)))


def _holds_jumps(mesh: CrackedMesh, constraint: Constraint) -> bool:
    """Whether the copies of a node move together with a drive, as in `Unknowns.from_constraints`."""
    if constraint.holds_jumps is None:
        return len(np.unique(mesh.representative[constraint.nodes])) > 1
    return constraint.holds_jumps


def _sums(groups: Index, rows: Array) -> Array:
    """Sums of the rows of each group, as conditions those of their means."""
    first, number = np.unique(groups, return_inverse=True)
    sums = np.zeros((len(first), rows.shape[1]))
    np.add.at(sums, number, rows)
    return sums


def _across(bodies: _Pieces, mesh: CrackedMesh) -> tuple[Index, Index]:
    """Nodes on the minus and the plus side of the crack, at the corners of its elements, that are of different pieces."""
    if mesh.crack is None:
        return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    cell = CELLS[mesh.crack.type]
    minus, plus = (mesh.crack.data[:, side[: cell.facet_corners]].ravel() for side in cell.sides)
    apart = (bodies.of_node[minus] != bodies.of_node[plus]) & (bodies.of_node[minus] >= 0) & (bodies.of_node[plus] >= 0)
    return minus[apart], plus[apart]


def _free(bodies: _Pieces, conditions: _Conditions, allowed: Array) -> Array:
    """Orthonormal columns, (pieces * motions, f): motions of the pieces that nothing resists."""
    matrix = np.concatenate([conditions.pieces, conditions.motions @ allowed, conditions.rotations], axis=1)
    if len(matrix) > matrix.shape[1]:
        matrix = np.linalg.qr(matrix).R
    _, size, right = np.linalg.svd(matrix)
    rank = int((size > _ARM).sum())
    left, size, _ = np.linalg.svd(right[rank:, : conditions.pieces.shape[1]].T, full_matrices=False)
    return np.asarray(left[:, size > _ARM])


def _described(bodies: _Pieces, free: Array) -> str:
    """What is free, and how it moves: "it along x", "its part of 12 elements at (3, 4) against turning about (0, 0)"."""
    by_piece = free.reshape(len(bodies.size), bodies.motions, -1)
    moving = np.linalg.norm(by_piece, axis=(1, 2))
    i = int(moving.argmax())
    what = "it"
    if len(bodies.size) > 1 and not (moving > _ARM).all():
        count = f"{bodies.elements[i]} element{'s' if bodies.elements[i] > 1 else ''}"
        what = f"its part of {count} at {as_text(bodies.centre[i])}"
    basis, size, _ = np.linalg.svd(by_piece[i], full_matrices=False)
    basis = basis[:, size > _ARM * size[0]]
    d = bodies.points.shape[1]
    _, size, right = np.linalg.svd(basis[d:])
    turns = int((size > _ARM).sum())
    shifts = basis[:d] @ right[turns:].T
    said = [f"along {_named(shifts)}"] if shifts.shape[1] else []
    if turns:
        said.append(f"against turning{_about(bodies, i, basis @ right[:turns].T, shifts.shape[1])}")
    return f"{what} {' and '.join(said)}"


def _named(directions: Array) -> str:
    """The axes that span some orthonormal directions (d, r), or the directions."""
    axes = [_AXES[i] for i, row in enumerate(directions) if row @ row > 1 - _ARM]
    if len(axes) < directions.shape[1]:
        axes = [as_text(column if column[abs(column).argmax()] > 0 else -column) for column in directions.T]
    return " and ".join([", ".join(axes[:-1]), axes[-1]] if len(axes) > 1 else axes)


def _about(bodies: _Pieces, i: int, turning: Array, shifts: int) -> str:
    """The centre or axes of rotations, (motions, r), of a piece; nothing in the plane where it shifts too."""
    d = bodies.points.shape[1]
    if d == 3:
        axes = np.linalg.qr(turning[d:])[0]
        return f" about {_named(axes)}"
    if shifts:
        return ""
    u, w = turning[:2, 0], turning[2, 0] / bodies.size[i]
    centre = bodies.centre[i] + np.array([-u[1], u[0]]) / w
    centre[abs(centre) < 1e-9 * bodies.size[i]] = 0.0
    return f" about {as_text(centre)}"
