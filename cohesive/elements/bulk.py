"""Elements of the bulk and of a crack band: stiffness, strain, stress, all elements of a block at once.

Stress and strain components come in
the order of `elements.rotations.PAIRS`: [xx, yy, xy] or [xx, yy, zz, xy, yz, zx], strains with engineering shear.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from ..arrays import Array, Index
from ..errors import ElementError
from .registry import ELEMENTS, Element
from .rotations import PAIRS
from .shapes import Rule

#: an element counts as flat where its Jacobian is below this part of that of a cube with its longest side
_FLAT = 1e-12


def _inverse(J: Array) -> tuple[Array, Array]:
    """Determinants (...) and inverses (..., d, d) times them."""
    columns = np.moveaxis(J, -1, 0)
    if len(columns) == 2:
        adjugate = np.stack([J[..., 1, 1], -J[..., 0, 1], -J[..., 1, 0], J[..., 0, 0]], -1).reshape(J.shape)
        return J[..., 0, 0] * J[..., 1, 1] - J[..., 0, 1] * J[..., 1, 0], adjugate
    a, b, c = columns
    adjugate = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=-2)
    return np.einsum("...x,...x->...", a, adjugate[..., 0, :]), adjugate


def elasticity(E: float, nu: float, plane: str | None = None) -> Array:
    """Matrix of plane "stress" or plane "strain", (3, 3), or without a plane that of space, (6, 6), MPa."""
    if plane is None:
        G = E / (2 * (1 + nu))
        D = np.diag([2 * G] * 3 + [G] * 3)
        D[:3, :3] += E * nu / ((1 + nu) * (1 - 2 * nu))
        return D
    if plane == "strain":
        E, nu = E / (1 - nu**2), nu / (1 - nu)
    return E / (1 - nu**2) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])


#: elements whose matrices are computed together: as many as a processor's cache holds
_AT_ONCE = 4096


@dataclass(frozen=True)
class ElasticBlock:
    """Elements of one type, linear elastic.

    Parameters
    ----------
    kind : one of `ELEMENTS`, in meshio's node order.
    points : (m, d) array, mm, of the whole mesh.
    cells : (n, nodes per element) array; a hexahedron with two pairs of equal nodes is a prism.
    D : (k, k) array, MPa, see `elasticity`; or (n, k, k), one for each element.
    thickness : mm, of a plane body.

    Raises
    ------
    ElementError
        For another type or one of another dimension than the points, a thickness in space, or an element with no
        positive area or volume, naming it.
    """

    kind: str
    points: Array
    cells: Index
    D: Array
    thickness: float = 1.0

    def __post_init__(self) -> None:
        if self.kind not in ELEMENTS:
            known = [name for name, element in ELEMENTS.items() if element.cell.dimension in PAIRS]
            raise ElementError(f"cells of type {self.kind!r}: expected one of {', '.join(known)}")
        d, k = self.dimension, len(PAIRS[self.dimension])
        if self.element.cell.dimension != d or self.D.shape not in ((k, k), (len(self.cells), k, k)):
            raise ElementError(f"cells of type {self.kind!r}: points have {d} coordinates and D is {self.D.shape}")
        if d == 3 and self.thickness != 1.0:
            raise ElementError(f"cells of type {self.kind!r}, thickness = {self.thickness:g}: expected none in space")

    @property
    def element(self) -> Element:
        """What is computed with its cells."""
        return ELEMENTS[self.kind]

    @property
    def dimension(self) -> int:
        """Of space."""
        return int(self.points.shape[1])

    def _slopes(self, at: Array, first: int = 0, end: int | None = None) -> tuple[Array, Array]:
        """Slopes of the shape functions (q, n, nodes, d) and Jacobian determinant (q, n) at local points (q, d) of some
        elements."""
        cells = self.cells[first:end]
        _, dN = self.element.shape(at)
        J = np.einsum("qad,nax->qnxd", dN, self.points[cells])
        det, adjugate = _inverse(J)
        flat = det <= _FLAT * np.linalg.norm(J, axis=-2).max(axis=-1) ** self.dimension
        if flat.any():
            bad = first + int(np.flatnonzero(flat.any(axis=0))[0])
            place = ", ".join(f"{x:g}" for x in self.points[self.cells[bad]].mean(axis=0))
            size = "area" if self.dimension == 2 else "volume"
            raise ElementError(
                f"{self.kind} element {bad} at ({place}) is inverted or has no {size}: expected a positive Jacobian"
            )
        return np.einsum("qad,qndx->qnax", dN, adjugate / det[..., None, None]), det

    def _gradients(self, at: Array, first: int = 0, end: int | None = None) -> tuple[Array, Array]:
        """Strain operator (q, n, k, d nodes) and Jacobian determinant (q, n) at local points (q, d) of some elements."""
        dNdx, det = self._slopes(at, first, end)
        d = self.dimension
        B = np.zeros((*det.shape, len(PAIRS[d]), d * self.cells.shape[1]))
        for row, (i, j) in enumerate(PAIRS[d]):
            B[..., row, i::d] = dNdx[..., j]
            B[..., row, j::d] = dNdx[..., i]
        return B, det

    def stiffness(self) -> Array:
        """Element stiffness matrices, (n, d nodes, d nodes), N/mm."""
        at, weights = self.element.rule
        n = self.dimension * self.cells.shape[1]
        K = np.zeros((len(self.cells), n, n))
        for a in range(0, len(K), _AT_ONCE):
            part = slice(a, a + _AT_ONCE)
            B, det = self._gradients(at, a, a + _AT_ONCE)
            D = self.D if self.D.ndim == 2 else self.D[part]
            for Bq, wq in zip(B, self.thickness * weights[:, None] * det, strict=True):
                K[part] += np.matmul(Bq.transpose(0, 2, 1), (D * wq[:, None, None]) @ Bq)
        return K

    def stress(self, displacement: Array) -> Array:
        """Stress at the element centres, (n, k), MPa, from displacements (m, d)."""
        slope = np.matmul(displacement[self.cells].transpose(0, 2, 1), self._at_centre)  # of each component along each axis
        pairs = PAIRS[self.dimension]
        strain = np.stack([slope[:, i, j] + (slope[:, j, i] if i != j else 0.0) for i, j in pairs], axis=1)
        return np.asarray(np.matmul(self.D, strain[:, :, None])[..., 0])

    @cached_property
    def _at_centre(self) -> Array:
        """Slopes of the shape functions at the element centres, (n, nodes, d), which the stress of each frame takes."""
        slopes, _ = self._slopes(self.element.centre)
        return np.asarray(slopes[0])

    def body_force(self, force: Array) -> Array:
        """Nodal forces, (m, d), N, of a force per volume, (n, d), N/mm^3."""
        at, weights = self.element.rule
        N, det = self.element.shape(at)[0], self._slopes(at)[1]
        share = np.einsum("qn,qa->na", self.thickness * weights[:, None] * det, N)
        nodal = np.zeros(self.points.shape)
        np.add.at(nodal, self.cells, share[:, :, None] * force[:, None, :])
        return nodal

    def strain_points(self, rule: Rule | None = None) -> tuple[sp.csr_array, Array, Array, Index]:
        """The points of a quadrature rule, by default the element's own: displacements of the mesh nodes to strains,
        a (k p, d m) matrix; volumes (p,), mm^3; positions (p, d), mm; the cell of each point (p,)."""
        at, weights = rule or self.element.rule
        B, det = (value.swapaxes(0, 1) for value in self._gradients(at))  # element by element
        n, q, k, _ = B.shape
        rows = np.arange(k * n * q).reshape(n, q, k, 1)
        columns = self.dofs()[:, None, None, :]
        operator = sp.csr_array(
            (B.ravel(), (np.broadcast_to(rows, B.shape).ravel(), np.broadcast_to(columns, B.shape).ravel())),
            shape=(k * n * q, self.points.size),
        )
        where = np.einsum("qa,nax->nqx", self.element.shape(at)[0], self.points[self.cells])
        volumes = (self.thickness * weights * det).ravel()
        return operator, volumes, where.reshape(-1, self.dimension), np.repeat(np.arange(n), q)

    def dofs(self) -> Index:
        """Numbers of the elements' displacements among those of the mesh, (n, d nodes)."""
        d = self.dimension
        return (d * self.cells[:, :, None] + np.arange(d)).reshape(len(self.cells), -1)

    def corners(self) -> Array:
        """Corners of the elements, (n, 4, 2) or (n, 8, 3), mm, as `longest_chord` takes them."""
        return self.points[self.cells[:, self.element.cell.as_cube]]

    def volumes(self) -> Array:
        """Of each element, (n,), mm^3."""
        at, weights = self.element.rule
        return np.asarray((self.thickness * weights[:, None] * self._slopes(at)[1]).sum(axis=0))
