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
from numpy.typing import NDArray

from .continuum import ElasticBlock

Array = NDArray[np.float64]
Index = NDArray[np.int64]

_FREE, _FIXED, _DRIVEN = 0, 1, 2


@dataclass(frozen=True)
class Tie:
    """Motion along `direction` (unit vector) of the nodes `nodes`: zero, or the drive's.

    With `lever` they turn freely about a hinge besides: the distance of each node from it, over the largest one, so that
    the turn is the motion of the outermost node, mm.
    """

    name: str
    nodes: Index
    direction: tuple[float, float]
    factor: float = 1.0  # of the drive's motion
    lever: Array | None = None


@dataclass(frozen=True)
class Unknowns:
    """u = transform @ v.

    Attributes
    ----------
    transform : (2 m, n) sparse matrix
    turns : (t,) array, numbers of the unknowns that are the turns of hinged ties.
    drives : (k,) array, numbers of the unknowns that are the driven motions, the last ones.
    node : (n,) array, the leading node of each unknown; for a turn or drive, any of its nodes.
    """

    transform: sp.csr_array
    turns: Index
    drives: Index
    node: Index

    @classmethod
    def build(cls, leader: Index, supports: Sequence[Tie], drives: Sequence[Tie], mirror: Tie | None = None) -> Unknowns:
        """Number the unknowns of a split mesh.

        Parameters
        ----------
        leader : (m,) array, for the copies of a node on the crack path the one of them that names the group, for
            every other node itself.
        supports, drives : lists of ties; each drive is a motion of its own.
        mirror : normal of a plane of symmetry, at nodes whose copy stands for the mirror image. They open along
            the normal and move along the plane, nothing else.

        Raises
        ------
        ValueError
            If ties contradict each other at a node, or a tie has no nodes.
        """
        m = len(leader)
        extra = np.flatnonzero(leader != np.arange(m))
        frame = np.broadcast_to(np.eye(2), (m, 2, 2)).copy()
        framed = np.zeros(m, dtype=bool)
        mean, held = np.full((m, 2), _FREE), np.zeros((m, 2), dtype=bool)
        sign = np.ones((m, 2))
        if mirror is not None:
            at, (x, y) = np.unique(leader[mirror.nodes]), mirror.direction
            frame[at], framed[at] = np.array([[x, y], [-y, x]]), True
            mean[at, 0], held[at, 1] = _FIXED, True
        driven = [(drive, _DRIVEN + i) for i, drive in enumerate(drives)]
        for tie, state in [*((support, _FIXED) for support in supports), *driven]:
            at = np.unique(leader[tie.nodes])
            if not len(at):
                raise ValueError(f"{tie.name}: expected at least one node, got none")
            d = np.asarray(tie.direction)
            new = at[~framed[at]]
            frame[new] = np.array([[d[0], d[1]], [-d[1], d[0]]])
            framed[new] = True
            along = frame[at] @ d
            component = abs(along).argmax(axis=1)
            if (abs(abs(along).max(axis=1) - 1.0) > 1e-9).any():
                raise ValueError(f"{tie.name}: its direction is oblique to another support at the same node")
            if (mean[at, component] >= _DRIVEN).any() or (state >= _DRIVEN and (mean[at, component] != _FREE).any()):
                raise ValueError(f"{tie.name}: a node is both held and driven in the direction {tie.direction}")
            mean[at, component] = state
            sign[at, component] = tie.factor * along[np.arange(len(at)), component]
            held[at, component] |= len(at) > 1 or state == _FIXED

        mean[extra] = _FIXED  # their mean is their leader's
        mean_free = mean == _FREE
        jump_free = ~held[leader[extra]]
        n_mean, n_jump = int(mean_free.sum()), int(jump_free.sum())
        number = np.full((m, 2), -1)
        number[mean_free] = np.arange(n_mean)
        is_driven = mean >= _DRIVEN
        hinged = [tie for tie in (*supports, *drives) if tie.lever is not None]
        n_free = n_mean + n_jump
        number[is_driven] = n_free + len(hinged) + mean[is_driven] - _DRIVEN
        jump_number = np.full((len(extra), 2), -1)
        jump_number[jump_free] = n_mean + np.arange(n_jump)

        # copies of one node: u_i = mean + jump_i - (sum of the jumps) / copies, the first one without jump
        belongs = sp.csr_array((np.ones(m), (np.arange(m), leader)), shape=(m, m))
        copies = np.bincount(leader, minlength=m)
        share = belongs @ sp.diags_array(-1.0 / np.maximum(copies, 1)) @ belongs[extra].T
        share = (share + sp.csr_array((np.ones(len(extra)), (extra, np.arange(len(extra)))), shape=share.shape)).tocoo()

        rows, columns, values = [], [], []
        for component in (0, 1):
            for nodes, number_of, weight in (
                (np.arange(m), number[leader, component], sign[leader, component]),
                (share.row, jump_number[share.col, component], share.data),
            ):
                use = number_of >= 0
                for axis in (0, 1):
                    rows.append(2 * nodes[use] + axis)
                    columns.append(number_of[use])
                    values.append(weight[use] * frame[leader[nodes[use]], component, axis])
        for turn, tie in enumerate(hinged):
            assert tie.lever is not None
            for axis in (0, 1):
                rows.append(2 * tie.nodes + axis)
                columns.append(np.full(len(tie.nodes), n_free + turn))
                values.append(tie.direction[axis] * tie.lever)
        transform = sp.csr_array(
            (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
            shape=(2 * m, n_free + len(hinged) + len(drives)),
        )
        transform.eliminate_zeros()
        jumping = leader[extra[np.nonzero(jump_free)[0]]]
        first_nodes = [leader[tie.nodes[:1]] for tie in (*hinged, *drives)]
        node = np.concatenate([np.nonzero(mean_free)[0], jumping, *first_nodes])
        turns = n_free + np.arange(len(hinged))
        return cls(transform, turns, n_free + len(hinged) + np.arange(len(drives)), node)


def bulk_stiffness(blocks: Sequence[ElasticBlock], n_points: int, transform: sp.csr_array) -> sp.csc_array:
    """Stiffness of the elastic bulk in the solver's unknowns, N/mm."""
    if not blocks:
        return sp.csc_array((transform.shape[1],) * 2)
    rows, columns, values = [], [], []
    for block in blocks:
        dofs = (2 * block.cells[:, :, None] + np.arange(2)).reshape(len(block.cells), -1).astype(np.int32)
        K = block.stiffness()
        rows.append(np.broadcast_to(dofs[:, :, None], K.shape).ravel())
        columns.append(np.broadcast_to(dofs[:, None, :], K.shape).ravel())
        values.append(K.ravel())
    K = sp.coo_array(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=(2 * n_points, 2 * n_points)
    ).tocsr()
    return (transform.T @ K @ transform).tocsc()


@dataclass(frozen=True)
class Points:
    """Deformations and forces at all points with cracks, on the few unknowns that each one sees.

    The deformation is the jump of an interface, c = 2, with a traction as its stress, or the strain of a band, c = 3.

    Attributes
    ----------
    index : (p, k) array, unknowns; a point that sees fewer than k repeats one, with zero in `matrix`.
    matrix : (p, c, k) array, deformation = matrix @ v[index].
    weights : (p,) array, mm^2 of an interface, mm^3 of a band.
    where : (p, 2) array, mm, for messages.
    size : number of unknowns.
    """

    index: Index
    matrix: Array
    weights: Array
    where: Array
    size: int

    @classmethod
    def build(cls, operator: sp.csr_array, weights: Array, where: Array) -> Points:
        """From the (c p, n) matrix that gives the deformations."""
        entries = operator.tocoo()
        p, n = len(weights), operator.shape[1]
        c = operator.shape[0] // p
        pairs, inverse = np.unique((entries.row // c).astype(np.int64) * n + entries.col, return_inverse=True)
        point, column = pairs // n, pairs % n
        place = np.arange(len(pairs)) - np.searchsorted(point, point)
        k = int(place.max()) + 1 if len(place) else 1
        index = np.zeros((p, k), dtype=np.int64)
        index[point, place] = column
        matrix = np.zeros((p, c, k))
        matrix[entries.row // c, entries.row % c, place[inverse]] = entries.data
        return cls(index, matrix, weights, where, n)

    def deformation(self, v: Array) -> Array:
        """Jumps or strains, (p, c)."""
        return np.asarray(np.einsum("pik,pk->pi", self.matrix, v[self.index]))

    def force(self, stress: Array) -> Array:
        """Nodal forces of tractions or stresses (p, c), in the solver's unknowns."""
        local = np.einsum("pik,pi->pk", self.matrix, self.weights[:, None] * stress)
        return np.bincount(self.index.ravel(), local.ravel(), self.size).astype(float)

    def stiffness(self, tangent: Array) -> tuple[Index, Index, Array]:
        """Rows, columns and values of the tangent stiffness (entries at one place add up)."""
        weighted = self.weights[:, None, None] * tangent
        local = self.matrix.transpose(0, 2, 1) @ weighted @ self.matrix
        rows = np.broadcast_to(self.index[:, :, None], local.shape)
        columns = np.broadcast_to(self.index[:, None, :], local.shape)
        return rows.ravel(), columns.ravel(), local.ravel()
