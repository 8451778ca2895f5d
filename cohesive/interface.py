"""Zero-thickness interface elements: jump, rotation to the crack frame, quadrature, and the law at their points.

A crack cell lists the nodes of its minus side, then of its plus side, as the perimeter of the quadrilateral
into which it opens: `quad` = [a-, b-, b+, a+], `quad8` = [a-, b-, b+, a+, mid-, b-, mid+, a+]. With the tangent from
a to b the normal is the tangent turned by +90 degrees; it points from minus to plus.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from .concrete import Concrete
from .crackplane import CrackPlane

Array = NDArray[np.float64]

#: columns of the minus and plus nodes in the order a, b[, mid]
SIDES = {"quad": ((0, 1), (3, 2)), "quad8": ((0, 1, 4), (3, 2, 6))}


def _line2(r: Array) -> tuple[Array, Array]:
    return np.stack([1 - r, 1 + r], axis=1) / 2, np.tile([-0.5, 0.5], (len(r), 1))


def _line3(r: Array) -> tuple[Array, Array]:
    return np.stack([r * (r - 1) / 2, r * (r + 1) / 2, 1 - r**2], axis=1), np.stack([r - 0.5, r + 0.5, -2 * r], axis=1)


_SHAPES = {"quad": _line2, "quad8": _line3}
_RULES = {
    ("quad", "nodal"): (np.array([-1.0, 1.0]), np.array([1.0, 1.0])),
    ("quad8", "nodal"): (np.array([-1.0, 1.0, 0.0]), np.array([1.0, 1.0, 4.0]) / 3.0),
    ("quad", "gauss"): np.polynomial.legendre.leggauss(2),
    ("quad8", "gauss"): np.polynomial.legendre.leggauss(3),
}


@dataclass(frozen=True)
class Interface:
    """The integration points of all crack cells.

    Attributes
    ----------
    jump_operator : (2 p, 2 m) sparse matrix
        Displacements of the m mesh nodes to local jumps [normal, shear] at the p points.
    weights : (p,) array, mm^2, quadrature weight times thickness.
    points : (p, 2) array, mm.
    normals : (p, 2) array, unit vectors from minus to plus.
    cell : (p,) array, the crack cell of each point.
    """

    jump_operator: sp.csr_array
    weights: Array
    points: Array
    normals: Array
    cell: NDArray[np.int64]

    @property
    def area(self) -> float:
        """Crack area, mm^2."""
        return float(self.weights.sum())

    @classmethod
    def from_cells(
        cls, kind: str, points: Array, cells: NDArray[np.int64], thickness: float, quadrature: str = "nodal"
    ) -> Interface:
        """Integration points of crack cells of one type.

        Parameters
        ----------
        kind : "quad" | "quad8"
        points : (m, 2) array, mm, of the whole mesh.
        cells : (n, 4) or (n, 8) array.
        thickness : mm.
        quadrature : "nodal" (Newton-Cotes: each node pair on its own) | "gauss".
            Between stiff faces Gauss quadrature couples neighbouring pairs and the tractions oscillate.
        """
        minus, plus = (cells[:, list(side)] for side in SIDES[kind])
        at, weights = _RULES[kind, quadrature]
        N, dN = _SHAPES[kind](at)
        n, q = len(cells), len(at)
        tangent = np.einsum("qa,nax->nqx", dN, points[minus]).reshape(-1, 2)
        length = np.hypot(*tangent.T)
        tangent /= length[:, None]
        normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)
        R = np.stack([normal, tangent], axis=1)  # (p, local, global)
        # rows 2 p + local, columns 2 node + global
        shape = (n, q, N.shape[1], 2, 2)
        values = np.broadcast_to(R.reshape(n, q, 1, 2, 2) * N[None, :, :, None, None], shape)
        rows = np.broadcast_to(np.arange(2 * n * q).reshape(n, q, 1, 2, 1), shape)
        columns = [np.broadcast_to((2 * side)[:, None, :, None, None] + np.arange(2), shape) for side in (minus, plus)]
        operator = sp.coo_array(
            (
                np.concatenate([-values.ravel(), values.ravel()]),
                (np.tile(rows.ravel(), 2), np.concatenate([c.ravel() for c in columns])),
            ),
            shape=(2 * n * q, 2 * len(points)),
        ).tocsr()
        operator.eliminate_zeros()
        return cls(
            operator,
            thickness * (length.reshape(n, q) * weights).ravel(),
            np.einsum("qa,nax->nqx", N, points[minus]).reshape(-1, 2),
            normal,
            np.repeat(np.arange(n), q),
        )


@dataclass(frozen=True)
class InterfaceState:
    """Jump (p, 2) in mm, traction (p, 2) in MPa and history Z (p,) in mm of all points."""

    deformation: Array
    stress: Array
    Z: Array


@dataclass(frozen=True)
class InterfaceLaw:
    """The crack-plane law at p interface points: a `PointLaw` whose deformation is the jump, its stress the traction."""

    law: CrackPlane
    size: int
    quantity = "jump in mm"

    @property
    def concrete(self) -> Concrete:
        return self.law.concrete

    @property
    def onset(self) -> float:
        return float(self.law.Zt)

    def initial(self) -> InterfaceState:
        zeros = np.zeros((self.size, 2))
        return InterfaceState(zeros, zeros, np.full(self.size, self.law.Zt))

    def elastic(self) -> Array:
        return np.broadcast_to(np.diag(self.law.stiffness(2)), (self.size, 2, 2))

    def update(self, deformation: Array, start: InterfaceState, frozen: bool = False) -> tuple[InterfaceState, Array]:
        traction, tangent, Z = self.law.update(deformation, start.Z, frozen)
        return InterfaceState(deformation, traction, Z), tangent

    def grow(self, start: InterfaceState, state: InterfaceState) -> None:
        """The planes are there from the beginning."""

    def is_damaging(self, deformation: Array, start: InterfaceState) -> bool:
        return bool((self.law.history(deformation, start.Z) > start.Z).any())

    def is_on_surface(self, state: InterfaceState) -> bool:
        on_surface = self.law.history(state.deformation, np.zeros_like(state.Z)) >= state.Z
        return bool((on_surface & (state.Z > self.law.Zt)).any())

    def is_gone(self, state: InterfaceState) -> bool:
        # beyond 3.5 Zm the softening branch is below 1e-7 ft: the traction cannot come back by opening
        gone = abs(state.stress).max() < 1e-8 * self.concrete.ft
        return bool(gone) and bool(state.Z.min() > 3.5 * self.concrete.Zm)

    def energies(self, state: InterfaceState) -> tuple[Array, Array]:
        return np.zeros(self.size), self.law.stored_energy(state.deformation, state.Z)

    def dissipation(self, start: InterfaceState, state: InterfaceState) -> tuple[Array, Array]:
        return self.law.dissipation(start.deformation, start.Z, state.deformation, state.Z)

    def contact_work(self, start: InterfaceState, state: InterfaceState) -> Array:
        before, after = (self.law.contact_traction(s.deformation, s.Z) for s in (start, state))
        return np.asarray(0.5 * np.einsum("ij,ij->i", before + after, state.deformation - start.deformation))
