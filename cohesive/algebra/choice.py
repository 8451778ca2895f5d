"""Which unknowns Newton's method works on: those at cracks, with the elastic bulk condensed away, or all of them."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from ..arrays import Array, Index
from ..elements.bulk import ElasticBlock
from .bordered import DenseStiffness, SparseStiffness, Stiffness
from .condensation import Condensed, EliminationTree
from .dissection import nested_dissection
from .unknowns import Unknowns

#: an operation of a sparse factorization takes the time of so many dense ones
SPARSE_IS_SLOWER = 10.0

#: bytes of a number in a matrix, and of one in a sparse factor with its row
_DENSE, _SPARSE = 8.0, 12.0

#: operations of a condensation from which on the choice is always weighed, for the user to know
LARGE = 1e11

#: part of the machine's memory that matrices may take
_SHARE = 0.6

#: operations for each number of a sparse factor at whose ratio an iteration of GMRES takes half of a factorization
_OPERATIONS_PER_NUMBER = 25.0


@dataclass(frozen=True)
class Bulk:
    """What can be reduced.

    Attributes
    ----------
    points : (m, d) array
    elastic, cracking : the elastic elements, and those of a band
    leader : (m,) array, one of the copies of each split node
    unknowns : Unknowns
    operator : (c p, n) matrix, the deformations of the cracks from the unknowns
    active : numbers of the unknowns that cracks, drives and measures see
    stiffness : (d m, d m) matrix of the bulk for the displacements, N/mm
    """

    points: Array
    elastic: Sequence[ElasticBlock]
    cracking: Sequence[ElasticBlock]
    leader: Index
    unknowns: Unknowns
    operator: sp.csr_array
    active: Index
    stiffness: sp.csr_array


@dataclass(frozen=True)
class Condensation:
    """
    Attributes
    ----------
    kind : "condensed", "none" or "petsc"
    stiffness : Stiffness of the bulk on the unknowns of Newton's method
    unknowns : their numbers among all
    recover : displacements of all nodes, (m, d), from these unknowns
    why : what either kind takes, in words; empty where there was nothing to weigh
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
    wanted : "condensed", "none", or "auto": what takes less work in an iteration, where there is room for it.

    Raises
    ------
    ValueError
        If the body is not held.
    """
    if wanted == "none" or not bulk.elastic:
        return Whole.from_bulk(bulk).condensed("")
    part = Part.from_bulk(bulk)
    if wanted == "condensed":
        return part.condensed("")
    room, once = _SHARE * machine_memory(), part.fronts.cost()[0]
    is_less_work = part.iteration <= SPARSE_IS_SLOWER * once  # which the whole takes besides
    if part.memory < room and is_less_work and once < LARGE:
        return part.condensed("")
    whole = Whole.from_bulk(bulk)
    why = (
        f"condensed {part.memory / 1e9:.2g} GB, else {whole.memory / 1e9:.2g} GB and "
        f"{_two_digits(whole.iteration / part.iteration)} times the work of a factorization"
    )
    if part.memory < room:
        return part.condensed(why) if part.iteration <= whole.iteration else whole.condensed(why)
    if whole.memory < room:
        return whole.condensed(why)
    why += ", more than this machine has to spare; 'petsc' shares it out to several"
    return part.condensed(why) if part.memory <= whole.memory else whole.condensed(why)


@dataclass(frozen=True)
class Part:
    """The active unknowns alone. `K` and `transform` are in the order of elimination."""

    K: sp.csc_array
    fronts: EliminationTree
    basis: sp.csr_array
    active: Index
    numbers: Index
    transform: sp.csr_array
    shape: tuple[int, ...]

    @classmethod
    def from_bulk(cls, bulk: Bulk) -> Part:
        d, m = bulk.points.shape[1], len(bulk.points)
        faces = np.flatnonzero(np.isin(bulk.leader, bulk.leader[bulk.leader != np.arange(m)]))
        last = np.unique(np.concatenate([faces, *(block.cells.ravel() for block in bulk.cracking)]))
        transform, node, basis = bulk.unknowns.with_faces(faces, d)
        group = nested_dissection(bulk.points, [block.cells for block in bulk.elastic], last)[node]
        seen = np.zeros(basis.shape[1])
        seen[bulk.active] = 1.0
        group[(basis @ seen != 0) | (np.arange(len(node)) >= len(node) - d * len(faces))] = m
        order, start = _grouped(group)
        K = _lower((transform.T @ bulk.stiffness @ transform).tocsc(), order)
        stay = order[start[-1] :]
        columns = np.unique(np.append(basis[stay].indices, bulk.active))
        return cls(
            K,
            EliminationTree.from_pattern(K, start),
            basis[stay][:, columns],
            np.searchsorted(columns, bulk.active),
            bulk.active,
            transform[:, order],
            bulk.points.shape,
        )

    @property
    def iteration(self) -> float:
        """Operations."""
        return 2.0 / 3.0 * float(len(self.active)) ** 3

    @property
    def memory(self) -> float:
        """Bytes: the factor, then what stays and its change of basis, or the stiffness and its factor."""
        stay, active = self.basis.shape[1], len(self.active)
        return float(_DENSE * (self.fronts.cost()[1] + max(2.0 * stay**2, stay**2 + 2.0 * active**2)))

    def condensed(self, why: str) -> Condensation:
        condensed = Condensed.eliminate(self.K, self.fronts, self.basis, self.active)
        transform, shape = self.transform, self.shape  # not the rest, which is not needed any more

        def recover(v: Array) -> Array:
            return np.asarray(transform @ condensed.recover(v)).reshape(shape)

        return Condensation("condensed", DenseStiffness(condensed.stiffness), self.numbers, recover, why)


@dataclass(frozen=True)
class Whole:
    """All unknowns, in an order that keeps the factors sparse."""

    K: sp.csc_array
    fronts: EliminationTree
    order: Index
    transform: sp.csr_array
    shape: tuple[int, ...]

    @classmethod
    def from_bulk(cls, bulk: Bulk) -> Whole:
        unknowns = bulk.unknowns
        cells = [bulk.leader[block.cells] for block in (*bulk.elastic, *bulk.cracking)]
        group = nested_dissection(bulk.points, cells, np.zeros(0, dtype=np.int64))[unknowns.node]
        group[unknowns.rotations], group[unknowns.drives] = len(bulk.points), len(bulk.points) + 1
        order, start = _grouped(group)
        K = (unknowns.transform.T @ bulk.stiffness @ unknowns.transform).tocsc()
        sees = abs(bulk.operator)
        fronts = EliminationTree.from_pattern(_lower(K + (sees.T @ sees).tocsc(), order), np.append(start, len(order)))
        return cls(K, fronts, order, unknowns.transform, bulk.points.shape)

    @property
    def iteration(self) -> float:
        """Operations: twice those of a symmetric factorization, in the time of dense ones."""
        return 2.0 * SPARSE_IS_SLOWER * self.fronts.cost()[0]

    @property
    def memory(self) -> float:
        """Bytes of both triangular factors."""
        return 2.0 * _SPARSE * self.fronts.cost()[1]

    def condensed(self, why: str) -> Condensation:
        operations, numbers = self.fronts.cost()
        stiffness = SparseStiffness(self.K, self.order, int(operations / numbers / _OPERATIONS_PER_NUMBER))

        def recover(v: Array) -> Array:
            return np.asarray(self.transform @ v).reshape(self.shape)

        return Condensation("none", stiffness, np.arange(len(self.order)), recover, why)


def _grouped(group: Index) -> tuple[Index, Index]:
    """Order of the unknowns by groups, and where each group starts."""
    order = np.argsort(group, kind="stable")
    return order, np.unique(group[order], return_index=True)[1].astype(np.int64)


def _lower(K: sp.csc_array, order: Index) -> sp.csc_array:
    """Lower triangle of a matrix in another order."""
    place = np.empty(len(order), dtype=np.int32)
    place[order] = np.arange(len(order))
    rows, columns = place[K.indices], place[np.repeat(np.arange(K.shape[1]), np.diff(K.indptr))]
    lower = rows >= columns
    return sp.coo_array((K.data[lower], (rows[lower], columns[lower])), shape=K.shape).tocsc()


def _two_digits(value: float) -> str:
    """350, not 3.5e+02."""
    return f"{float(f'{value:.2g}'):g}"


def machine_memory() -> float:
    """Of the machine, bytes; without limit where that is not known."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, ValueError, OSError):
        return float("inf")
