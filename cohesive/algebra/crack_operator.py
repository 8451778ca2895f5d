"""From the unknowns to the deformations of the points with cracks, and from their stresses back to forces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from ..arrays import Array, Index


@dataclass(frozen=True)
class CrackOperator:
    """Deformations and forces at all points with cracks, on the few unknowns that each one sees.

    The deformation is the jump of an interface, with a traction as its stress, or the strain of a band; c is 2 or 3
    in 2D, 3 or 6 in 3D.

    Attributes
    ----------
    index : (p, k) array, unknowns that a point sees; one that sees fewer than k repeats one, with zero in `matrix`.
    matrix : (p, c, k) array, deformation = matrix @ v[index].
    weights : (p,) array, mm^2 of an interface, mm^3 of a band.
    where : (p, d) array, coordinates in mm, for messages.
    size : number of unknowns.
    """

    index: Index
    matrix: Array
    weights: Array
    where: Array
    size: int

    @classmethod
    def from_matrix(cls, operator: sp.csr_array, weights: Array, where: Array) -> CrackOperator:
        """From the (c p, n) matrix that gives the deformations."""
        entries = operator.tocoo()
        p, n = len(weights), operator.shape[1]
        c = operator.shape[0] // p
        pairs, inverse = np.unique((entries.row // c).astype(np.int64) * n + entries.col, return_inverse=True)
        point, column = pairs // n, pairs % n
        slot = np.arange(len(pairs)) - np.searchsorted(point, point)
        k = int(slot.max()) + 1 if len(slot) else 1
        index = np.zeros((p, k), dtype=np.int64)
        index[point, slot] = column
        matrix = np.zeros((p, c, k))
        matrix[entries.row // c, entries.row % c, slot[inverse]] = entries.data
        return cls(index, matrix, weights, where, n)

    def deformation(self, v: Array) -> Array:
        """Jumps or strains, (p, c)."""
        return np.asarray(np.einsum("pik,pk->pi", self.matrix, v[self.index]))

    def force(self, stress: Array) -> Array:
        """Nodal forces of tractions or stresses (p, c), in the solver's unknowns."""
        local = np.einsum("pik,pi->pk", self.matrix, self.weights[:, None] * stress)
        return np.bincount(self.index.ravel(), local.ravel(), self.size).astype(float)

    def stiffness(self, tangent: Array) -> tuple[Index, Index, Array]:
        """Rows, columns and values of the tangent stiffness; entries at one position add up."""
        weighted = self.weights[:, None, None] * tangent
        local = self.matrix.transpose(0, 2, 1) @ weighted @ self.matrix
        rows = np.broadcast_to(self.index[:, :, None], local.shape)
        columns = np.broadcast_to(self.index[:, None, :], local.shape)
        return rows.ravel(), columns.ravel(), local.ravel()
