"""Plane elements T3, T6, Q4, Q8 and the Q6 of a crack band: stiffness, strain, stress, all elements of a block at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

Array = NDArray[np.float64]


class ElementError(ValueError):
    """An element with no positive area, or of a type that is not implemented."""


def _triangle3(r: Array) -> tuple[Array, Array]:
    x, y = r.T
    N = np.stack([1 - x - y, x, y], axis=1)
    dN = np.broadcast_to([[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]], (len(r), 3, 2))
    return N, np.array(dN)


def _triangle6(r: Array) -> tuple[Array, Array]:
    L, dL = _triangle3(r)
    pairs = [(0, 1), (1, 2), (2, 0)]
    N = np.stack([a * (2 * a - 1) for a in L.T] + [4 * L[:, i] * L[:, j] for i, j in pairs], axis=1)
    corners = (4 * L - 1)[:, :, None] * dL
    mids = [4 * (L[:, [i]] * dL[:, j] + L[:, [j]] * dL[:, i]) for i, j in pairs]
    return N, np.concatenate([corners, np.stack(mids, axis=1)], axis=1)


_CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


def _quad4(r: Array) -> tuple[Array, Array]:
    fx, fy = (1 + r[:, None, :] * _CORNERS).transpose(2, 0, 1)
    return fx * fy / 4, np.stack([_CORNERS[:, 0] * fy, _CORNERS[:, 1] * fx], axis=2) / 4


def _quad8(r: Array) -> tuple[Array, Array]:
    x, y = r[:, :1], r[:, 1:]
    X, Y = _CORNERS.T
    fx, fy, serendipity = 1 + x * X, 1 + y * Y, x * X + y * Y - 1
    corners = fx * fy * serendipity / 4
    d_corners = np.stack([X * fy * (serendipity + fx), Y * fx * (serendipity + fy)], axis=2) / 4
    # mid-sides in the order of the edges: bottom, right, top, left
    s = np.array([-1.0, 1.0])
    flat, steep = (1 - x**2) * (1 + y * s) / 2, (1 - y**2) * (1 + x * s) / 2
    d_flat = np.stack([-x * (1 + y * s), (1 - x**2) * s / 2], axis=2)
    d_steep = np.stack([(1 - y**2) * s / 2, -y * (1 + x * s)], axis=2)
    N = np.stack([flat[:, 0], steep[:, 1], flat[:, 1], steep[:, 0]], axis=1)
    dN = np.stack([d_flat[:, 0], d_steep[:, 1], d_flat[:, 1], d_steep[:, 0]], axis=1)
    return np.concatenate([corners, N], axis=1), np.concatenate([d_corners, dN], axis=1)


def _quad6(r: Array) -> tuple[Array, Array]:
    """Quadratic along the first axis, linear across: the nodes of Q8 without mid-sides on the right and left."""
    x, y = r[:, :1], r[:, 1:]
    s = np.array([-1.0, 1.0])
    end, middle = x * (x + s) / 2, 1 - x**2
    d_end, d_middle = x + s / 2, -2 * x
    low, high = (1 - y) / 2, (1 + y) / 2
    N = np.concatenate([end * low, end[:, ::-1] * high, middle * low, middle * high], axis=1)
    d_x = np.concatenate([d_end * low, d_end[:, ::-1] * high, d_middle * low, d_middle * high], axis=1)
    d_y = np.concatenate([-end, end[:, ::-1], -middle, middle], axis=1) / 2
    return N, np.stack([d_x, d_y], axis=2)


def _gauss_square(n: int) -> tuple[Array, Array]:
    x, w = np.polynomial.legendre.leggauss(n)
    return np.stack(np.meshgrid(x, x, indexing="ij"), axis=-1).reshape(-1, 2), np.outer(w, w).ravel()


_THIRD = 1.0 / 3.0
_T1 = (np.full((1, 2), _THIRD), np.array([0.5]))
_T3 = (np.array([[1.0, 1.0], [4.0, 1.0], [1.0, 4.0]]) / 6.0, np.full(3, 1.0 / 6.0))

#: shape functions, quadrature that integrates the stiffness of a straight element exactly, centre
ELEMENTS = {
    "triangle": (_triangle3, _T1, _T1[0]),
    "triangle6": (_triangle6, _T3, _T1[0]),
    "quad": (_quad4, _gauss_square(2), np.zeros((1, 2))),
    "quad8": (_quad8, _gauss_square(3), np.zeros((1, 2))),
    "quad6": (_quad6, _gauss_square(3), np.zeros((1, 2))),
}

#: columns of a `quad8` cell of a band that are the nodes of a `quad6`
BAND_COLUMNS = {"quad": ("quad", [0, 1, 2, 3]), "quad8": ("quad6", [0, 1, 2, 3, 4, 6])}


def elasticity(E: float, nu: float, plane: str) -> Array:
    """Matrix of plane stress or plane strain, (3, 3), MPa, for [xx, yy, engineering xy]."""
    if plane == "strain":
        E, nu = E / (1 - nu**2), nu / (1 - nu)
    return E / (1 - nu**2) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])


@dataclass(frozen=True)
class ElasticBlock:
    """Elements of one type, linear elastic.

    Parameters
    ----------
    kind : "triangle" | "triangle6" | "quad" | "quad8", meshio's names and node order, or "quad6".
    points : (m, 2) array, mm, of the whole mesh.
    cells : (n, nodes per element) array.
    D : (3, 3) array, MPa, see `elasticity`.
    thickness : mm.

    Raises
    ------
    ElementError
        For another type, or an element with no positive area, naming it.
    """

    kind: str
    points: Array
    cells: NDArray[np.int64]
    D: Array
    thickness: float

    def __post_init__(self) -> None:
        if self.kind not in ELEMENTS:
            raise ElementError(f"cells of type {self.kind!r}: expected one of {', '.join(ELEMENTS)}")

    def _gradients(self, at: Array) -> tuple[Array, Array]:
        """Strain operator (q, n, 3, 2 nodes) and Jacobian determinant (q, n) at local points (q, 2)."""
        _, dN = ELEMENTS[self.kind][0](at)
        J = np.einsum("qad,nax->qnxd", dN, self.points[self.cells])
        det = J[..., 0, 0] * J[..., 1, 1] - J[..., 0, 1] * J[..., 1, 0]
        if (det <= 0).any():
            bad = int(np.argwhere((det <= 0).any(axis=0))[0, 0])
            x, y = self.points[self.cells[bad]].mean(axis=0)
            raise ElementError(
                f"{self.kind} element {bad} at ({x:g}, {y:g}) is inverted or has no area: expected a positive Jacobian"
            )
        inverse = np.stack([J[..., 1, 1], -J[..., 0, 1], -J[..., 1, 0], J[..., 0, 0]], -1) / det[..., None]
        dNdx = np.einsum("qad,qndx->qnax", dN, inverse.reshape(*det.shape, 2, 2))
        B = np.zeros((*det.shape, 3, 2 * self.cells.shape[1]))
        B[..., 0, 0::2] = B[..., 2, 1::2] = dNdx[..., 0]
        B[..., 1, 1::2] = B[..., 2, 0::2] = dNdx[..., 1]
        return B, det

    def stiffness(self) -> Array:
        """Element stiffness matrices, (n, 2 nodes, 2 nodes), N/mm."""
        at, weights = ELEMENTS[self.kind][1]
        B, det = self._gradients(at)
        K = np.zeros((len(self.cells), B.shape[-1], B.shape[-1]))
        for Bq, wq in zip(B, self.thickness * weights[:, None] * det, strict=True):
            K += np.matmul(Bq.transpose(0, 2, 1), (self.D * wq[:, None, None]) @ Bq)
        return K

    def stress(self, displacement: Array) -> Array:
        """Stress [xx, yy, xy] at the element centres, (n, 3), MPa, from displacements (m, 2)."""
        B, _ = self._gradients(ELEMENTS[self.kind][2])
        u = displacement[self.cells].reshape(len(self.cells), -1)
        return np.asarray(np.einsum("ij,njk,nk->ni", self.D, B[0], u))

    def strain_points(self, rule: tuple[Array, Array] | None = None) -> tuple[sp.csr_array, Array, Array, NDArray[np.int64]]:
        """The points of a quadrature rule, by default the element's own: displacements of the mesh nodes to strains
        [xx, yy, engineering xy], a (3 p, 2 m) matrix; volumes (p,), mm^3; positions (p, 2), mm; the cell of each
        point (p,)."""
        at, weights = rule or ELEMENTS[self.kind][1]
        B, det = (value.swapaxes(0, 1) for value in self._gradients(at))  # element by element
        n, q, _, k = B.shape
        dofs = (2 * self.cells[:, :, None] + np.arange(2)).reshape(n, 1, 1, k)
        rows = np.arange(3 * n * q).reshape(n, q, 3, 1)
        operator = sp.csr_array(
            (B.ravel(), (np.broadcast_to(rows, B.shape).ravel(), np.broadcast_to(dofs, B.shape).ravel())),
            shape=(3 * n * q, 2 * len(self.points)),
        )
        where = np.einsum("qa,nax->nqx", ELEMENTS[self.kind][0](at)[0], self.points[self.cells])
        return operator, (self.thickness * weights * det).ravel(), where.reshape(-1, 2), np.repeat(np.arange(n), q)

    def corners(self) -> Array:
        """Corners of the elements, (n, 4, 2), mm; a triangle repeats its last one."""
        return self.points[self.cells[:, [0, 1, 2, 2 if self.kind.startswith("triangle") else 3]]]

    def area(self) -> float:
        """Sum of the element areas, mm^2."""
        at, weights = ELEMENTS[self.kind][1]
        return float((weights[:, None] * self._gradients(at)[1]).sum())
