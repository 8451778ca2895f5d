"""elements/interface"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from ..arrays import Array, Index
from .rotations import rotations
from .shapes import Rule, Shape, gauss_cube, gauss_simplex, linear_cube, linear_simplex, quadratic_line, quadratic_simplex

#: columns of the minus and plus nodes in the order of the shape functions
SIDES = {
    "quad": ((0, 1), (3, 2)),
    "quad8": ((0, 1, 4), (3, 2, 6)),
    "wedge": ((0, 1, 2), (3, 4, 5)),
    "wedge15": ((0, 1, 2, 6, 7, 8), (3, 4, 5, 9, 10, 11)),
    "hexahedron": ((0, 1, 2, 3), (4, 5, 6, 7)),
}

_SHAPES: dict[str, Shape] = {
    "quad": linear_cube, "quad8": quadratic_line,
    "wedge": linear_simplex, "wedge15": quadratic_simplex, "hexahedron": linear_cube,
}  # fmt: skip

#: corners, mid-sides and centre. No rule on the node pairs of a quadratic triangle has weight left for the corners: with the
#: mid-sides alone the corners part freely, which between stiff faces costs 2 % of the stiffness of a notched block. With the
#: centre besides, the only point that couples pairs, Newton-Cotes has positive weights and degree 3, and the tractions
#: oscillate by a third of those of the interior rule of degree 4 (`pytest -k stiff_faces`).
_TRIANGLE = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5], [1 / 3, 1 / 3]])

_RULES: dict[tuple[str, str], Rule] = {
    ("quad", "nodal"): (np.array([[-1.0], [1.0]]), np.array([1.0, 1.0])),
    ("quad8", "nodal"): (np.array([[-1.0], [1.0], [0.0]]), np.array([1.0, 1.0, 4.0]) / 3.0),
    ("wedge", "nodal"): (_TRIANGLE[:3], np.full(3, 1 / 6)),
    ("wedge15", "nodal"): (_TRIANGLE, np.repeat([3.0, 8.0, 27.0], [3, 3, 1]) / 120.0),
    ("hexahedron", "nodal"): (np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]), np.ones(4)),
    ("quad", "gauss"): gauss_cube(2, 1),
    ("quad8", "gauss"): gauss_cube(3, 1),
    ("wedge", "gauss"): gauss_simplex(2, 2),
    ("wedge15", "gauss"): gauss_simplex(4, 2),
    ("hexahedron", "gauss"): gauss_cube(2, 2),
}


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
        kind : "quad" | "quad8" in the plane, "wedge" | "wedge15" | "hexahedron" in space
        points : (m, d) array, mm, of the whole mesh.
        cells : (n, nodes per cell) array.
        thickness : mm, of a plane body.
        quadrature : "nodal" (Newton-Cotes: each node pair on its own, but for the centre of a "wedge15") | "gauss".
            Between stiff faces Gauss quadrature couples neighbouring pairs and the tractions oscillate.
        """
        minus, plus = (cells[:, list(side)] for side in SIDES[kind])
        at, weights = _RULES[kind, quadrature]
        N, dN = _SHAPES[kind](at)
        n, q, d = len(cells), len(at), points.shape[1]
        normal = _normals(np.einsum("qae,nax->nqex", dN, points[minus]).reshape(n * q, d - 1, d))
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
            np.einsum("qa,nax->nqx", N, points[minus]).reshape(-1, d),
            normal,
            np.repeat(np.arange(n), q),
        )


def _normals(tangents: Array) -> Array:
    """Normals of the size of the line or facet between tangents (p, d - 1, d), (p, d)."""
    if tangents.shape[2] == 2:
        return np.stack([-tangents[:, 0, 1], tangents[:, 0, 0]], axis=1)
    return np.cross(tangents[:, 0], tangents[:, 1])
