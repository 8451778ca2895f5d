"""Zero-thickness interface elements: jump, rotation to the crack frame, quadrature.

In the plane a crack cell lists the nodes of its minus side, then of its plus side, as the perimeter of the quadrilateral
into which it opens: `quad` = [a-, b-, b+, a+], `quad8` = [a-, b-, b+, a+, mid-, b-, mid+, a+]. With the tangent from
a to b the normal is the tangent turned by +90 degrees; it points from minus to plus.

In space it lists the facet of the minus side, then that of the plus side: `wedge` = [a-, b-, c-, a+, b+, c+],
`hexahedron` with four corners each, and `wedge15` = [a-, b-, c-, a+, b+, c+, ab-, bc-, ca-, ab+, bc+, ca+, a-, b-, c-].
The normal is (b - a) x (c - a). On a facet that is curved or warped it is taken at each point.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from meshing.cells import CELLS

from ..arrays import Array, Index
from .registry import facet_of
from .rotations import rotations


@dataclass(frozen=True)
class Interface:
    """The integration points of all crack cells.

    Attributes
    ----------
    jump_operator : (d p, d m) sparse matrix
        Displacements of the m mesh nodes to local jumps [normal, shear...] at the p points, see `rotations.rotations`.
    weights : (p,) array, mm^2, quadrature weight times thickness.
    points : (p, d) array, mm.
    normals : (p, d) array, unit vectors from minus to plus.
    cell : (p,) array, the crack cell of each point.
    """

    jump_operator: sp.csr_array
    weights: Array
    points: Array
    normals: Array
    cell: Index

    @property
    def area(self) -> float:
        """Crack area, mm^2."""
        return float(self.weights.sum())

    @classmethod
    def from_cells(
        cls, kind: str, points: Array, cells: Index, thickness: float = 1.0, quadrature: str = "nodal"
    ) -> Interface:
        """Integration points of crack cells of one type.

        Parameters
        ----------
        kind : type of a crack cell, see `meshing.cells`.
        points : (m, d) array, mm, of the whole mesh.
        cells : (n, nodes per cell) array.
        thickness : mm, of a plane body.
        quadrature : "nodal" (Newton-Cotes: each node pair on its own, but for the centre of a quadratic triangle) | "gauss".
            Between stiff faces Gauss quadrature couples neighbouring pairs and the tractions oscillate.
        """
        minus, plus = (cells[:, side] for side in CELLS[kind].sides)
        facet = facet_of(kind)
        rule = facet.nodal if quadrature == "nodal" else facet.gauss
        assert rule is not None
        at, weights = rule
        N, dN = facet.shape(at)
        n, q, d = len(cells), len(at), points.shape[1]
        middle = 0.5 * (points[minus] + points[plus])  # the sides of a band are apart
        normal = _normals(np.einsum("qae,nax->nqex", dN, middle).reshape(n * q, d - 1, d))
        size = np.hypot.reduce(normal, axis=1)
        normal /= size[:, None]
        # rows d p + local, columns d node + global
        shape = (n, q, N.shape[1], d, d)
        values = np.broadcast_to(rotations(normal).reshape(n, q, 1, d, d) * N[None, :, :, None, None], shape)
        rows = np.broadcast_to(np.arange(d * n * q).reshape(n, q, 1, d, 1), shape)
        columns = [np.broadcast_to((d * side)[:, None, :, None, None] + np.arange(d), shape) for side in (minus, plus)]
        operator = sp.coo_array(
            (
                np.concatenate([-values.ravel(), values.ravel()]),
                (np.tile(rows.ravel(), 2), np.concatenate([c.ravel() for c in columns])),
            ),
            shape=(d * n * q, points.size),
        ).tocsr()
        operator.eliminate_zeros()
        return cls(
            operator,
            thickness * (size.reshape(n, q) * weights).ravel(),
            np.einsum("qa,nax->nqx", N, middle).reshape(-1, d),
            normal,
            np.repeat(np.arange(n), q),
        )


def _normals(tangents: Array) -> Array:
    """Normals of the size of the line or facet between tangents (p, d - 1, d), (p, d)."""
    if tangents.shape[2] == 2:
        return np.stack([-tangents[:, 0, 1], tangents[:, 0, 0]], axis=1)
    return np.cross(tangents[:, 0], tangents[:, 1])
