"""Index maps and sparse assembly: from the displacements of mesh nodes to the unknowns of the solver.

The copies of a split node move by their mean and their jumps. Tractions depend on jumps only, so the means
are as passive as the rest of the bulk. Supports and drives act on the mean; on a driven or supported face
they hold the jumps too, on a single loaded point they leave them free, so that both faces carry the load.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from ..arrays import Array, Index
from ..elements.rotations import rotations

_FREE, _FIXED, _DRIVEN = 0, 1, 2

#: directions are equal or at right angles where their sines or cosines are below this
_SKEW = 4e-5


@dataclass(frozen=True)
class Constraint:
    """Motion along `direction` (unit vector) of the nodes `nodes`: zero, or the drive's.

    With `lever` they turn freely about a hinge besides: the distance of each node from it, over the largest one, so that
    the turn is the motion of the outermost node, mm. With `holds_jumps` the copies of a split node move together along the
    direction; None: those of a support do, and those of a drive with more than one node. A line load in space is to say no.
    """

    name: str
    nodes: Index
    direction: tuple[float, ...]
    factor: float = 1.0  # of the drive's motion
    lever: Array | None = None
    holds_jumps: bool | None = None


@dataclass(frozen=True)
class Unknowns:
    """u = transform @ v.

    Attributes
    ----------
    transform : (d m, n) sparse matrix
    rotations : (t,) array, numbers of the unknowns that are the rotations of hinged ties.
    drives : (k,) array, numbers of the unknowns that are the driven motions, the last ones.
    node : (n,) array, the leading node of each unknown; for a turn or drive, any of its nodes.
    """

    transform: sp.csr_array
    rotations: Index
    drives: Index
    node: Index

    @classmethod
    def from_constraints(
        cls, leader: Index, supports: Sequence[Constraint], drives: Sequence[Constraint], mirror: Constraint | None = None
    ) -> Unknowns:
        """Number the unknowns of a split mesh.

        Parameters
        ----------
        leader : (m,) array, for the copies of a node on the crack path the one of them that names the group, for
            every other node itself.
        supports, drives : lists of ties; each drive is a motion of its own. At a node their directions are equal, opposite
            or at right angles.
        mirror : normal of a plane of symmetry, at nodes whose copy stands for the mirror image. They open along
            the normal and move along the plane, nothing else.

        Raises
        ------
        ValueError
            If ties contradict each other at a node, or a tie has no nodes.
        """
        m = len(leader)
        extra = np.flatnonzero(leader != np.arange(m))
        d = len((*supports, *drives)[0].direction)
        rotation = np.broadcast_to(np.eye(d), (m, d, d)).copy()
        taken = np.zeros(m, dtype=np.int64)  # axes of the rotation that ties have set, the first ones
        mean, held = np.full((m, d), _FREE), np.zeros((m, d), dtype=bool)
        sign = np.ones((m, d))
        if mirror is not None:
            at = np.unique(leader[mirror.nodes])
            rotation[at], taken[at] = rotations(np.array([mirror.direction]))[0], 1
            mean[at, 0], held[at, 1:] = _FIXED, True
        driven = [(drive, _DRIVEN + i) for i, drive in enumerate(drives)]
        for tie, state in [*((support, _FIXED) for support in supports), *driven]:
            at = np.unique(leader[tie.nodes])
            if not len(at):
                raise ValueError(f"{tie.name}: expected at least one node, got none")
            direction = np.asarray(tie.direction)
            cosine = np.where(np.arange(d) < taken[at, None], abs(rotation[at] @ direction), 0.0)
            new = (cosine < _SKEW).all(axis=1)
            if (~new & (cosine.max(axis=1) < 1.0 - 0.5 * _SKEW**2)).any():
                raise ValueError(f"{tie.name}: its direction is oblique to another support at the same node")
            component = np.where(new, taken[at], cosine.argmax(axis=1))
            rotation[at[new]] = _with_axis(rotation[at[new]], taken[at[new]], direction)
            taken[at[new]] += 1
            along = np.einsum("ni,i->n", rotation[at, component], direction)
            if (mean[at, component] >= _DRIVEN).any() or (state >= _DRIVEN and (mean[at, component] != _FREE).any()):
                raise ValueError(f"{tie.name}: a node is both held and driven in the direction {tie.direction}")
            mean[at, component] = state
            sign[at, component] = tie.factor * along
            holds = len(at) > 1 or state == _FIXED if tie.holds_jumps is None else tie.holds_jumps
            held[at, component] |= holds

        mean[extra] = _FIXED  # their mean is their leader's
        mean_free = mean == _FREE
        jump_free = ~held[leader[extra]]
        n_mean, n_jump = int(mean_free.sum()), int(jump_free.sum())
        number = np.full((m, d), -1)
        number[mean_free] = np.arange(n_mean)
        is_driven = mean >= _DRIVEN
        hinged = [tie for tie in (*supports, *drives) if tie.lever is not None]
        n_free = n_mean + n_jump
        number[is_driven] = n_free + len(hinged) + mean[is_driven] - _DRIVEN
        jump_number = np.full((len(extra), d), -1)
        jump_number[jump_free] = n_mean + np.arange(n_jump)

        # copies of one node: u_i = mean + jump_i - (sum of the jumps) / copies, the first one without jump
        belongs = sp.csr_array((np.ones(m), (np.arange(m), leader)), shape=(m, m))
        copies = np.bincount(leader, minlength=m)
        share = belongs @ sp.diags_array(-1.0 / np.maximum(copies, 1)) @ belongs[extra].T
        share = (share + sp.csr_array((np.ones(len(extra)), (extra, np.arange(len(extra)))), shape=share.shape)).tocoo()

        rows, columns, values = [], [], []
        for axis in range(d):
            for nodes, number_of, weight in (
                (np.arange(m), number[leader, axis], sign[leader, axis]),
                (share.row, jump_number[share.col, axis], share.data),
            ):
                use = number_of >= 0
                for i in range(d):
                    rows.append(d * nodes[use] + i)
                    columns.append(number_of[use])
                    values.append(weight[use] * rotation[leader[nodes[use]], axis, i])
        for turn, tie in enumerate(hinged):
            assert tie.lever is not None
            for i in range(d):
                rows.append(d * tie.nodes + i)
                columns.append(np.full(len(tie.nodes), n_free + turn))
                values.append(tie.direction[i] * tie.lever)
        transform = sp.csr_array(
            (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
            shape=(d * m, n_free + len(hinged) + len(drives)),
        )
        transform.eliminate_zeros()
        jumping = leader[extra[np.nonzero(jump_free)[0]]]
        first_nodes = [leader[tie.nodes[:1]] for tie in (*hinged, *drives)]
        node = np.concatenate([np.nonzero(mean_free)[0], jumping, *first_nodes])
        hinges = n_free + np.arange(len(hinged))
        return cls(transform, hinges, n_free + len(hinged) + np.arange(len(drives)), node)

    def with_faces(self, nodes: Index, dimension: int) -> tuple[sp.csr_array, Index, sp.csr_array]:
        """Displacements of a crack's faces in place of the unknowns that move them, so that the two sides know nothing of one
        another.

        Parameters
        ----------
        nodes : all copies of all split nodes, or none.

        Returns
        -------
        transform : (d m, n') matrix, as the one of these unknowns; the displacements of the nodes come last
        node : (n',) array, the node of each unknown
        basis : (n', n) matrix that gives them: self.transform = transform @ basis
        """
        size, n = self.transform.shape
        moves = np.isin(self.node, nodes)
        moves[self.rotations] = moves[self.drives] = False
        kept = np.flatnonzero(~moves)
        rows = (dimension * nodes[:, None] + np.arange(dimension)).ravel()
        elsewhere = np.ones(size)
        elsewhere[rows] = 0.0
        faces = sp.csr_array((np.ones(len(rows)), (rows, np.arange(len(rows)))), shape=(size, len(rows)))
        others = sp.diags_array(elsewhere) @ self.transform[:, kept]
        basis = sp.vstack([sp.eye_array(n, format="csr")[kept], self.transform[rows]], format="csr")
        node = np.concatenate([self.node[kept], rows // dimension])
        return sp.hstack([others, faces], format="csr"), node, basis


def _with_axis(rotation: Array, taken: Index, direction: Array) -> Array:
    """Frames (n, d, d) that keep their first `taken` axes and have the direction, at right angles to these, as their next
    one, up to its sign."""
    rotation = rotation.copy()
    rotation[taken == 0] = rotations(direction[None])
    turn = (taken > 0) & (taken < len(direction) - 1)  # a last axis is given by the others
    first = rotation[turn, 0]
    second = direction - (first @ direction)[:, None] * first
    second /= np.linalg.norm(second, axis=1, keepdims=True)
    if turn.any():
        rotation[turn, 1], rotation[turn, 2] = second, np.cross(first, second)
    return rotation
