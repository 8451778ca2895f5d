"""Which unknowns Newton's method works on: those at cracks, with the elastic bulk condensed away, or all of them."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy.sparse as sp

from ..arrays import Array, Index
from ..elements.bulk import ElasticBlock
from ..errors import SceneError
from .bordered import DenseStiffness, SparseStiffness, Stiffness
from .condensation import Condensed, EliminationTree
from .dissection import incidence, nested_dissection
from .unknowns import Unknowns

#: time of an operation of a sparse factorization over that of a dense one
SPARSE_IS_SLOWER = 10.0

#: bytes of a number in a matrix, and of one in a sparse factor with its row
_DENSE, _SPARSE = 8.0, 12.0

#: operations of a condensation from which on the choice is weighed in any case, for the user to know
LARGE = 1e11

#: part of the machine's memory that matrices may take
_SHARE = 0.6

#: operations for each number of a sparse factor at whose ratio an iteration of GMRES takes half of a factorization
_OPERATIONS_PER_NUMBER = 25.0


@dataclass(frozen=True)
class Bulk:
    """The body as it is assembled, before the choice.

    Attributes
    ----------
    points : (m, d) array, of the nodes, mm
    elastic, cracking : the elastic elements, and those that may crack
    representative : (m,) array, one of the copies of each split node
    unknowns : Unknowns
    operator : (c p, n) matrix, the deformations of the cracks from the unknowns
    active : indices of the unknowns that cracks, drives and measures see
    stiffness : (d m, d m) matrix of the bulk for the displacements, N/mm
    dead : (d m,) array, forces that act while the last of the driven motions is 1 mm, N; None: there are none
    """

    points: Array
    elastic: Sequence[ElasticBlock]
    cracking: Sequence[ElasticBlock]
    representative: Index
    unknowns: Unknowns
    operator: sp.csr_array
    active: Index
    stiffness: sp.csr_array
    dead: Array | None = None

    def reduced(self, transform: sp.csr_array, factor: int = -1) -> sp.csc_array:
        """Stiffness for the unknowns of a transform, in which dead loads are coupled to the displacements by their factor, so
        that condensation takes them along.

        Parameters
        ----------
        factor : which of the unknowns is the factor of the dead loads.
        """
        K = (transform.T @ self.stiffness @ transform).tocsc()
        if self.dead is None:
            return K
        force = transform.T @ self.dead
        at = np.flatnonzero(force)
        last = np.full(len(at), factor % K.shape[0])
        border = sp.coo_array((-force[at], (at, last)), shape=K.shape)
        return (K + border + border.T).tocsc()


@dataclass(frozen=True)
class Recovery:
    """Displacements of all nodes from the unknowns of Newton's method.

    Attributes
    ----------
    transform : (d m, N) matrix, displacements from all unknowns
    shape : (m, d)
    condensed : Condensed, which finds the condensed unknowns from the others; None if none are condensed
    """

    transform: sp.csr_array
    shape: tuple[int, ...]
    condensed: Condensed | None = None

    def __call__(self, v: Array) -> Array:
        """Displacements (m, d) from unknowns (n,), or (k, m, d) from those of several states, (k, n), mm."""
        every = v.T if self.condensed is None else self.condensed.recover(v.T)
        return np.asarray((self.transform @ every).T.reshape(*v.shape[:-1], *self.shape))


@dataclass(frozen=True)
class Condensation:
    """The unknowns of Newton's method, and the way back from them.

    Attributes
    ----------
    kind : "condensed", "whole" or "petsc"
    stiffness : Stiffness of the bulk on the unknowns of Newton's method
    unknowns : their indices among all
    recover : displacements of all nodes, (m, d), from these unknowns
    why : what either kind takes, in words; empty if there was nothing to weigh
    """

    kind: str
    stiffness: Stiffness
    unknowns: Index
    recover: Callable[[Array], Array]
    why: str


def condense(bulk: Bulk, wanted: str) -> Condensation:
    """Condense the bulk, or do not.

    Parameters
    ----------
    wanted : "always", "never", or "auto": what takes less work in an iteration, if there is memory for it.

    Raises
    ------
    ValueError
        If the body is not held; a SceneError if there is nothing to condense that always is to be condensed.
    """
    if wanted == "always" and not bulk.elastic:
        raise SceneError(
            "solver.condensation = 'always': every element may crack, so that there is no elastic bulk to condense; "
            "expected 'auto' or 'never'",
            key="solver.condensation",
        )
    if wanted == "never" or not bulk.elastic:
        return Whole.from_bulk(bulk).condensed("")
    part = Part.from_bulk(bulk)
    if wanted == "always":
        return part.condensed("")
    memory, once = _SHARE * machine_memory(), part.tree.cost()[0]
    is_less_work = part.iteration <= SPARSE_IS_SLOWER * once  # which the whole takes besides
    if part.memory < memory and is_less_work and once < LARGE:
        return part.condensed("")
    whole = Whole.from_bulk(bulk)
    why = (
        f"condensed {part.memory / 1e9:.2g} GB, else {whole.memory / 1e9:.2g} GB and "
        f"{_two_digits(whole.iteration / part.iteration)} times the work of a factorization"
    )
    if part.memory < memory:
        return part.condensed(why) if part.iteration <= whole.iteration else whole.condensed(why)
    if whole.memory < memory:
        return whole.condensed(why)
    why += ", more than this machine has to spare; solver.condensation = 'petsc' shares it out to several"
    return part.condensed(why) if part.memory <= whole.memory else whole.condensed(why)


@dataclass(frozen=True)
class Part:
    """The active unknowns alone.

    Attributes
    ----------
    K, transform : stiffness (N/mm, lower triangle) and displacements of the nodes, in the order of elimination
    tree : of K
    basis : (s, t) matrix, the unknowns that the tree leaves from t others
    active : (n,) array, indices of the active ones among these t
    unknowns : (n,) array, their indices among all
    shape : of the displacements, (m, d)
    """

    K: sp.csc_array
    tree: EliminationTree
    basis: sp.csr_array
    active: Index
    unknowns: Index
    transform: sp.csr_array
    shape: tuple[int, ...]

    @classmethod
    def from_bulk(cls, bulk: Bulk) -> Part:
        d, m = bulk.points.shape[1], len(bulk.points)
        faces = np.flatnonzero(np.isin(bulk.representative, bulk.representative[bulk.representative != np.arange(m)]))
        last = np.unique(np.concatenate([faces, *(block.cells.ravel() for block in bulk.cracking)]))
        transform, node, basis = bulk.unknowns.with_faces(faces, d)
        group, beside = (each[node] for each in nested_dissection(bulk.points, [block.cells for block in bulk.elastic], last))
        seen = np.zeros(basis.shape[1])
        seen[bulk.active] = 1.0
        group[(basis @ seen != 0) | (np.arange(len(node)) >= len(node) - d * len(faces))] = m
        order, start = _grouped(group, beside)
        K = _lower(bulk.reduced(transform, -d * len(faces) - 1), order)
        left = order[start[-1] :]
        columns = np.unique(np.append(basis[left].indices, bulk.active))
        return cls(
            K,
            EliminationTree.from_pattern(K, start),
            basis[left][:, columns],
            np.searchsorted(columns, bulk.active),
            bulk.active,
            transform[:, order],
            bulk.points.shape,
        )

    @property
    def iteration(self) -> float:
        """Operations of a factorization."""
        return 2.0 / 3.0 * float(len(self.active)) ** 3

    @property
    def memory(self) -> float:
        """Bytes: the factor and its last rows, the stiffness, and what either comes from or what its factor takes."""
        left, active = self.basis.shape[1], len(self.active)
        before, after = sum(self.tree.places.sizes), active**2
        return float(_DENSE * (self.tree.cost()[1] + left * (left - active) + active**2 + max(before, after)))

    def condensed(self, why: str) -> Condensation:
        condensed = Condensed.eliminate(self.K, self.tree, self.basis, self.active)
        recover = Recovery(self.transform, self.shape, condensed)  # not the rest, which is not needed any more
        return Condensation("condensed", DenseStiffness(condensed.stiffness), self.unknowns, recover, why)


@dataclass(frozen=True)
class Whole:
    """All unknowns.

    Attributes
    ----------
    bulk : Bulk
    group, beside : (m,) arrays, the order of its nodes that keeps a factor sparse, see `nested_dissection`
    operations, numbers : of the factor of a symmetric tangent stiffness, counted on the nodes
    """

    bulk: Bulk
    group: Index
    beside: Index
    operations: float
    numbers: float

    @classmethod
    def from_bulk(cls, bulk: Bulk) -> Whole:
        m = len(bulk.points)
        cells = [bulk.representative[block.cells] for block in (*bulk.elastic, *bulk.cracking)]
        group, beside = nested_dissection(bulk.points, cells, np.zeros(0, dtype=np.int64))
        order, start = _grouped(group, beside)
        nodes_of = incidence(cells, m)
        tree = EliminationTree.from_pattern(_lower((nodes_of.T @ nodes_of).tocsc(), order), np.append(start, m))
        unknowns = np.bincount(bulk.unknowns.node, minlength=m)
        return cls(bulk, group, beside, *tree.cost(unknowns[order]))

    @property
    def iteration(self) -> float:
        """Operations of a factorization, twice those of a symmetric one, in the time of dense ones."""
        return 2.0 * SPARSE_IS_SLOWER * self.operations

    @property
    def memory(self) -> float:
        """Bytes of both triangular factors."""
        return 2.0 * _SPARSE * self.numbers

    def condensed(self, why: str) -> Condensation:
        unknowns, m = self.bulk.unknowns, len(self.bulk.points)
        group, beside = self.group[unknowns.node], self.beside[unknowns.node]
        group[unknowns.rotations], group[unknowns.drives] = m, m + 1
        beside[unknowns.drives] = 0  # these keep their order: the last one may be missing in a tangent stiffness
        order = _grouped(group, beside)[0]
        worth = int(self.operations / self.numbers / _OPERATIONS_PER_NUMBER)
        stiffness = SparseStiffness(self.bulk.reduced(unknowns.transform), order, worth)
        recover = Recovery(unknowns.transform, self.bulk.points.shape)
        return Condensation("whole", stiffness, np.arange(len(order)), recover, why)


def _grouped(group: Index, beside: Index) -> tuple[Index, Index]:
    """Order of the unknowns by groups, those of a group by the parts beside them, and where each group starts."""
    order = np.lexsort((beside, group))
    return order, np.unique(group[order], return_index=True)[1].astype(np.int64)


def _lower(K: sp.csc_array, order: Index) -> sp.csc_array:
    """Lower triangle of a matrix in another order."""
    position = np.empty(len(order), dtype=np.int32)
    position[order] = np.arange(len(order))
    rows, columns = position[K.indices], position[np.repeat(np.arange(K.shape[1]), np.diff(K.indptr))]
    lower = rows >= columns
    return sp.coo_array((K.data[lower], (rows[lower], columns[lower])), shape=K.shape).tocsc()


def _two_digits(value: float) -> str:
    """350, not 3.5e+02."""
    return f"{float(f'{value:.2g}'):g}"


#: where Linux says how much memory a job may take, in either version of its control groups
LIMITS = ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes")


def machine_memory() -> float:
    """Memory of the machine, or what a job may take of it, bytes; without limit if that is not known."""
    try:
        memory = float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, ValueError, OSError):
        memory = float("inf")
    for path in LIMITS:
        try:
            memory = min(memory, float(Path(path).read_text(encoding="utf-8")))
        except (OSError, ValueError):  # not there, or "max"
            continue
    return memory
