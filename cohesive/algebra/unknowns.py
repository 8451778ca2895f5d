"""Which unknowns move the nodes: means and jumps of the copies, less what is held, and the motions of the drives.

The copies of a split node move by their mean and their jumps. Tractions depend on jumps only, so the means
are as passive as the rest of the bulk. Supports and drives act on the mean; on a driven or supported face
they hold the jumps too, on a single loaded point they leave them free, so that both faces carry the load.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from ..arrays import Array, Index, Mask
from ..elements.rotations import rotations

_FREE, _FIXED, _DRIVEN = 0, 1, 2

#: directions are equal if their sine, and at right angles if their cosine, is below this
_SKEW = 4e-5


@dataclass(frozen=True)
class Constraint:
    """Motion along a direction of some nodes: zero, or the drive's.

    Attributes
    ----------
    name : for messages
    nodes : (k,) array
    direction : unit vector
    factor : of the drive's motion
    lever : (k,) array; the nodes rotate freely about a hinge besides. Distance of each node from it over the largest one, so
        that the rotation is the motion of the outermost node, mm.
    holds_jumps : whether the copies of a split node move together along the direction; None: those of a support do, and
        those of a drive with more than one node. A line load in 3D is to say no.
    """

    name: str
    nodes: Index
    direction: tuple[float, ...]
    factor: float = 1.0
    lever: Array | None = None
    holds_jumps: bool | None = None


@dataclass(frozen=True)
class Unknowns:
    """The displacements of all nodes from few unknowns: u = transform @ v.

    Attributes
    ----------
    transform : (d m, n) sparse matrix
    rotations : (t,) array, indices of the unknowns that are the rotations of hinged constraints.
    drives : (k,) array, indices of the unknowns that are the driven motions, the last ones.
    node : (n,) array, the leading node of each unknown; for a rotation or drive, any of its nodes; for a factor, any node.
    """

    transform: sp.csr_array
    rotations: Index
    drives: Index
    node: Index

    @classmethod
    def from_constraints(
        cls,
        representative: Index,
        supports: Sequence[Constraint],
        drives: Sequence[Constraint],
        mirror: Constraint | None = None,
        factors: int = 0,
    ) -> Unknowns:
        """Number the unknowns of a split mesh.

        Parameters
        ----------
        representative : (m,) array, for the copies of a node on the crack path the one of them that names the group, for
            every other node itself.
        supports, drives : lists of constraints; each drive is a motion of its own. At a node their directions are equal,
            opposite or at right angles.
        mirror : normal of a plane of symmetry, at nodes whose copy stands for the mirror image. They open along
            the normal and move along the plane, nothing else.
        factors : number of further driven motions that move no node, the last ones: of dead loads.

        Raises
        ------
        ValueError
            If constraints contradict each other at a node, or a constraint has no nodes.
        """
        axes = _Axes.free(len(representative), len((*supports, *drives)[0].direction))
        if mirror is not None:
            axes.reflect(np.unique(representative[mirror.nodes]), mirror)
        for support in supports:
            axes.constrain(np.unique(representative[support.nodes]), support, _FIXED)
        for i, drive in enumerate(drives):
            axes.constrain(np.unique(representative[drive.nodes]), drive, _DRIVEN + i)
        extra = np.flatnonzero(representative != np.arange(len(representative)))
        axes.mean[extra] = _FIXED  # their mean is their representative's

        hinged = [constraint for constraint in (*supports, *drives) if constraint.lever is not None]
        mean_free, jump_free = axes.mean == _FREE, ~axes.held[representative[extra]]
        n_mean, n_jump = int(mean_free.sum()), int(jump_free.sum())
        n_free = n_mean + n_jump
        mean = _numbered(mean_free, 0)
        is_driven = axes.mean >= _DRIVEN
        mean[is_driven] = n_free + len(hinged) + axes.mean[is_driven] - _DRIVEN
        entries = [*_motions(representative, extra, axes, mean, _numbered(jump_free, n_mean)), *_hinges(hinged, n_free)]
        rows, columns, values = (np.concatenate(part) for part in zip(*entries, strict=True))
        first_drive = n_free + len(hinged)
        driven = first_drive + np.arange(len(drives) + factors)
        transform = sp.csr_array((values, (rows, columns)), shape=(axes.mean.size, first_drive + len(driven)))
        transform.eliminate_zeros()
        jumping = representative[extra[np.nonzero(jump_free)[0]]]
        first_nodes = [representative[constraint.nodes[:1]] for constraint in (*hinged, *drives)]
        any_node = np.zeros(factors, dtype=np.int64)
        node = np.concatenate([np.nonzero(mean_free)[0], jumping, *first_nodes, any_node])
        return cls(transform, n_free + np.arange(len(hinged)), driven, node)

    def seen_by(self, operator: sp.csr_array) -> sp.csr_array:
        """An operator on the displacements for these unknowns, without the entries that cancel: a jump does not see the mean
        motion of the faces."""
        operator = (operator @ self.transform).tocsr()
        operator.data[abs(operator.data) < 1e-12] = 0.0
        operator.eliminate_zeros()
        return operator

    def with_faces(self, nodes: Index, dimension: int) -> tuple[sp.csr_array, Index, sp.csr_array]:
        """Displacements of a crack's faces in place of the unknowns that move them, so that the two sides are not coupled.

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


@dataclass
class _Axes:
    """The axes along which each leading node moves, and what becomes of the motions.

    Attributes
    ----------
    rotation : (m, d, d) array, rows the axes; those that a constraint has set come first
    taken : (m,) array, how many are set
    mean : (m, d) array, _FREE, _FIXED, or _DRIVEN + index of the drive
    held : (m, d) array, whether the jumps are zero
    sign : (m, d) array, the mean's motion over that of its unknown
    """

    rotation: Array
    taken: Index
    mean: Index
    held: Mask
    sign: Array

    @classmethod
    def free(cls, m: int, d: int) -> _Axes:
        """m nodes in d dimensions that nothing constrains."""
        rotation = np.broadcast_to(np.eye(d), (m, d, d)).copy()
        return cls(
            rotation, np.zeros(m, dtype=np.int64), np.full((m, d), _FREE), np.zeros((m, d), dtype=bool), np.ones((m, d))
        )

    def reflect(self, at: Index, mirror: Constraint) -> None:
        """Let nodes stand for their mirror images, too."""
        self.rotation[at], self.taken[at] = rotations(np.array([mirror.direction]))[0], 1
        self.mean[at, 0], self.held[at, 1:] = _FIXED, True

    def constrain(self, at: Index, constraint: Constraint, state: int) -> None:
        """Hold nodes along a direction, or drive them."""
        if not len(at):
            raise ValueError(f"{constraint.name}: expected at least one node, got none")
        axis = self._axis(at, constraint)
        along = np.einsum("ni,i->n", self.rotation[at, axis], np.asarray(constraint.direction))
        if (self.mean[at, axis] >= _DRIVEN).any() or (state >= _DRIVEN and (self.mean[at, axis] != _FREE).any()):
            raise ValueError(f"{constraint.name}: a node is both held and driven in the direction {constraint.direction}")
        self.mean[at, axis] = state
        self.sign[at, axis] = constraint.factor * along
        holds = len(at) > 1 or state == _FIXED if constraint.holds_jumps is None else constraint.holds_jumps
        self.held[at, axis] |= holds

    def _axis(self, at: Index, constraint: Constraint) -> Index:
        """Index of the axis along a constraint's direction at each node; it becomes the next one where it is new."""
        direction = np.asarray(constraint.direction)
        is_set = np.arange(len(direction)) < self.taken[at, None]
        cosine = np.where(is_set, abs(self.rotation[at] @ direction), 0.0)
        new = (cosine < _SKEW).all(axis=1)
        if (~new & (cosine.max(axis=1) < 1.0 - 0.5 * _SKEW**2)).any():
            raise ValueError(f"{constraint.name}: its direction is oblique to another support at the same node")
        axis: Index = np.where(new, self.taken[at], cosine.argmax(axis=1))
        self.rotation[at[new]] = _with_axis(self.rotation[at[new]], self.taken[at[new]], direction)
        self.taken[at[new]] += 1
        return axis


#: rows, columns and values of some entries of a sparse matrix
_Part = tuple[Index, Index, Array]


def _numbered(is_free: Mask, first: int) -> Index:
    """Consecutive indices of the free motions from `first` on; -1 elsewhere."""
    number = np.full(is_free.shape, -1)
    number[is_free] = first + np.arange(int(is_free.sum()))
    return number


def _motions(representative: Index, extra: Index, axes: _Axes, mean: Index, jump: Index) -> list[_Part]:
    """Entries by which means and jumps move the nodes.

    Parameters
    ----------
    extra : (e,) array, the copies that are no representatives
    mean : (m, d) array, index of the unknown that moves the mean along each axis; -1: none
    jump : (e, d) array, likewise for the jumps
    """
    m, d = mean.shape
    share = _shares(representative, extra)
    parts = []
    for axis in range(d):
        for nodes, index, weight in (
            (np.arange(m), mean[representative, axis], axes.sign[representative, axis]),
            (share.row, jump[share.col, axis], share.data),
        ):
            use = index >= 0
            for i in range(d):
                values = weight[use] * axes.rotation[representative[nodes[use]], axis, i]
                parts.append((d * nodes[use] + i, index[use], values))
    return parts


def _shares(representative: Index, extra: Index) -> sp.coo_array:
    """(m, e) matrix of the jumps: u_i = mean + jump_i - (sum of the jumps) / copies, where the representative has no jump."""
    m = len(representative)
    belongs = sp.csr_array((np.ones(m), (np.arange(m), representative)), shape=(m, m))
    copies = np.bincount(representative, minlength=m)
    share = belongs @ sp.diags_array(-1.0 / np.maximum(copies, 1)) @ belongs[extra].T
    return (share + sp.csr_array((np.ones(len(extra)), (extra, np.arange(len(extra)))), shape=share.shape)).tocoo()


def _hinges(hinged: Sequence[Constraint], first: int) -> list[_Part]:
    """Entries by which the rotations about hinges move the nodes."""
    parts = []
    for index, constraint in enumerate(hinged, start=first):
        assert constraint.lever is not None
        nodes, d = constraint.nodes, len(constraint.direction)
        for i, component in enumerate(constraint.direction):
            parts.append((d * nodes + i, np.full(len(nodes), index), component * constraint.lever))
    return parts


def _with_axis(rotation: Array, taken: Index, direction: Array) -> Array:
    """Rotations (n, d, d) that keep their first `taken` axes and have the direction, at right angles to these, as their next
    one, up to its sign."""
    rotation = rotation.copy()
    rotation[taken == 0] = rotations(direction[None])
    is_second = (taken > 0) & (taken < len(direction) - 1)  # a last axis is given by the others
    first = rotation[is_second, 0]
    second = direction - (first @ direction)[:, None] * first
    second /= np.linalg.norm(second, axis=1, keepdims=True)
    if is_second.any():
        rotation[is_second, 1], rotation[is_second, 2] = second, np.cross(first, second)
    return rotation
