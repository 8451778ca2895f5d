"""Crack cells, plane and solid: normals, area, jumps, rigid motions, forces, oscillation between stiff faces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from cohesive.algebra.bulk_matrix import bulk_stiffness
from cohesive.arrays import Array, Index
from cohesive.elements.bulk import ElasticBlock, elasticity
from cohesive.elements.interface import Interface
from cohesive.elements.rotations import rotations, stress_transformation
from meshing.cells import CELLS
from tests.builders import Patch, box, rotation

#: crack cell of each element of the bulk
BESIDE = {"wedge": "tetra", "wedge15": "tetra10", "hexahedron": "hexahedron"}
QUADRATURES = ["nodal", "gauss"]
FACETS = [(kind, quadrature) for kind in BESIDE for quadrature in QUADRATURES]
#: of plane cells, mm
LENGTH, THICKNESS = 5.0, 3.0


@dataclass
class Crack:
    """Crack cells whose faces are in touch, curved or not, and the frame of their middle: columns normal and tangents."""

    points: Array
    kind: str
    cells: Index
    frame: Array
    area: float
    middle: Array
    is_curved: bool = False

    def interface(self, quadrature: str, cells: slice = slice(None)) -> Interface:
        thickness = THICKNESS if self.points.shape[1] == 2 else 1.0
        return Interface.from_cells(self.kind, self.points, self.cells[cells], thickness, quadrature)


def plane_crack(kind: str, angle: float) -> Crack:
    """One cell at an angle."""
    t = np.radians(angle)
    along, normal = np.array([np.cos(t), np.sin(t)]), np.array([-np.sin(t), np.cos(t)])
    a, b = np.array([1.0, 2.0]), np.array([1.0, 2.0]) + LENGTH * along
    points = [a, b, b, a] + ([(a + b) / 2, b, (a + b) / 2, a] if kind == "quad8" else [])
    cell = [0, 1, 2, 3] + ([4, 1, 6, 3] if kind == "quad8" else [])
    frame = np.stack([normal, along], axis=1)
    return Crack(np.array(points), kind, np.array([cell]), frame, LENGTH * THICKNESS, (a + b) / 2)


def solid_crack(kind: str, warp: float) -> Crack:
    """Cells over a unit square, curved by `warp` and turned in space."""
    solid = box(BESIDE[kind], (3, 2, 2), split=0.5)
    assert solid.crack is not None and solid.crack_kind == kind
    points, Q = solid.points.copy(), rotation(3)
    points[:, 2] += warp * (points[:, 0] ** 2 - 0.5 * points[:, 0] * points[:, 1])
    return Crack(points @ Q.T, kind, solid.crack, Q[:, [2, 0, 1]], 1.0, Q @ [0.5, 0.5, 0.5], warp != 0)


CRACKS = {
    **{f"{kind} at {angle:g}": (plane_crack, kind, angle) for kind in ("quad", "quad8") for angle in (0, 30, 45, 90, 137.2)},
    **{f"{kind}, warped by {warp:g}": (solid_crack, kind, warp) for kind in BESIDE for warp in (0.0, 0.4)},
}


def test_sides_that_are_apart_have_the_line_between_them() -> None:
    """The minus side level, the plus side rising by 1/2: the line rises by 1/4."""
    points = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 1.0]])
    sides = Interface.from_cells("quad", points, np.array([[0, 1, 2, 3]]), THICKNESS)
    np.testing.assert_allclose(sides.normals, np.array([[-0.25, 1.0]] * 2) / np.hypot(1.0, 0.25))
    np.testing.assert_allclose(sides.points, [[0.0, 0.5], [4.0, 1.5]])
    assert sides.area == pytest.approx(THICKNESS * np.hypot(4.0, 1.0))


@pytest.mark.parametrize("quadrature", QUADRATURES)
@pytest.mark.parametrize("name", CRACKS)
def test_jumps_of_crack_cells(name: str, quadrature: str) -> None:
    """Normals from minus to plus, area, uniform and linear jumps, rigid motions."""
    make, kind, how = CRACKS[name]
    crack = make(kind, how)
    points, cells, interface = crack.points, crack.cells, crack.interface(quadrature)
    d, normal = points.shape[1], crack.frame[:, 0]
    assert (interface.weights > 0).all()
    np.testing.assert_allclose(np.linalg.norm(interface.normals, axis=1), 1.0, rtol=1e-13)
    assert (interface.normals @ normal > 0.7).all()
    if not crack.is_curved:
        np.testing.assert_allclose(interface.normals, np.broadcast_to(normal, interface.normals.shape), atol=1e-13)
        assert interface.area == pytest.approx(crack.area, rel=1e-13)
    if d == 2:
        frames = rotations(interface.normals)
        np.testing.assert_allclose(frames, np.broadcast_to(crack.frame.T, frames.shape), atol=1e-12)
    # a uniform jump, every pair of nodes included
    jump, u = np.array([0.3, -0.2, 0.5])[:d], np.zeros_like(points)
    u[cells[:, CELLS[kind].sides[1]]] = jump
    local = (interface.jump_operator @ u.ravel()).reshape(-1, d)
    np.testing.assert_allclose(local, rotations(interface.normals) @ jump, atol=1e-13)
    np.testing.assert_allclose(local[:, 0], interface.normals @ jump, atol=1e-13)
    # a rigid motion of both sides, turning included
    turn = np.random.default_rng(0).normal(size=(d, d))
    rigid = points @ (turn - turn.T) + turn[0]
    np.testing.assert_allclose(interface.jump_operator @ rigid.ravel(), 0.0, atol=1e-13)
    # a jump that grows linearly in space is found at the points, and integrated
    slope = np.array([0.2, -0.7, 0.4])[:d]
    u[cells[:, CELLS[kind].sides[1]]] = (points[cells[:, CELLS[kind].sides[0]]] @ slope)[..., None] * jump
    local = (interface.jump_operator @ u.ravel()).reshape(-1, d)
    np.testing.assert_allclose(local[:, 0], (interface.points @ slope) * (interface.normals @ jump), atol=1e-13)
    if not crack.is_curved:
        integral = float(crack.middle @ slope * (normal @ jump)) * crack.area
        assert interface.weights @ local[:, 0] == pytest.approx(integral, rel=1e-12, abs=1e-13)


@pytest.mark.parametrize("quadrature", QUADRATURES)
@pytest.mark.parametrize("kind", ["quad", "quad8", *BESIDE])
def test_a_crack_cell_resists_every_jump(kind: str, quadrature: str) -> None:
    """Three points, enough for what is linear, would let half of the pairs of a quadratic triangle part freely."""
    crack = solid_crack(kind, 0.0) if kind in BESIDE else plane_crack(kind, 30.0)
    interface, d = crack.interface(quadrature, slice(1)), crack.points.shape[1]
    plus = crack.cells[0, CELLS[kind].sides[1]]
    seen = interface.jump_operator.toarray()[:, (d * plus[:, None] + np.arange(d)).ravel()]
    values = np.linalg.svd(seen, compute_uv=False)
    assert len(values) == d * len(plus) and values[-1] > 0.1 * values[0]  # measured 0.31 to 1


def block_of(solid: Patch) -> ElasticBlock:
    return ElasticBlock(solid.kind, solid.points, solid.cells, elasticity(30e3, 0.2))


@pytest.mark.parametrize(("kind", "quadrature"), FACETS)
def test_uniform_traction_gives_the_forces_of_the_bulk(kind: str, quadrature: str) -> None:
    """What a patch test needs of a rule: nodal forces as the bulk's elements make them of a uniform stress."""
    solid = box(BESIDE[kind], (3, 3, 2), split=0.5)
    block, upper = block_of(solid), solid.points[solid.cells].mean(axis=1)[:, 2] > 0.5
    assert solid.crack is not None
    interface = Interface.from_cells(kind, solid.points, solid.crack, quadrature=quadrature)
    stress = np.array([0.0, 0.0, 2.0, 0.0, -0.7, 0.4])
    operator, volumes, _, cell = block.strain_points()
    bulk = operator.T @ ((volumes * upper[cell])[:, None] * stress).ravel()
    traction = stress_transformation(rotations(interface.normals)) @ stress
    crack = interface.jump_operator.T @ (interface.weights[:, None] * traction).ravel()
    plus = np.unique(solid.crack[:, CELLS[kind].sides[1]])
    inner = ((solid.points[plus, :2] > 0.01) & (solid.points[plus, :2] < 0.99)).all(axis=1)  # the sides carry shear too
    force = (bulk + crack).reshape(-1, 3)[plus]
    np.testing.assert_allclose(force[inner], 0.0, atol=1e-13)


def oscillation(name: str, quadrature: str) -> float:
    """A block with a notch to its middle, bent open, whose other half is an elastic interface between stiff faces: standard
    deviation of the normal tractions, from two elements beyond the notch on, from a smooth curve; over their largest."""
    n, length, width = 8 if name == "tetra10" else 16, 40.0, 0.001
    solid = box(name, (n, 2, n), (length, 10.0, length), split=length / 2)
    assert solid.crack is not None
    crack = solid.crack[solid.points[solid.crack].mean(axis=1)[:, 0] > length / 2]
    interface = Interface.from_cells(solid.crack_kind, solid.points, crack, quadrature=quadrature)
    J, k = interface.jump_operator, np.array([30e3, 12.5e3, 12.5e3]) / width
    K = bulk_stiffness([block_of(solid)], solid.points.size).tocsc()
    K = (K + J.T @ sp.diags_array((interface.weights[:, None] * k).ravel()) @ J).tocsc()
    held = np.column_stack(
        [solid.points[:, 2] == 0] * 2 + [(solid.points[:, 2] == 0) | (solid.points[:, 2] == length)]
    ).ravel()
    u = np.column_stack(
        [0 * solid.points[:, :2], np.where(solid.points[:, 2] == length, length - solid.points[:, 0], 0)]
    ).ravel()
    factor = spla.splu(K[~held][:, ~held], permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    u[~held] = factor.solve(-(K[:, held] @ u[held])[~held])
    x, traction = interface.points[:, 0], (J @ u).reshape(-1, 3)[:, 0] * k[0]
    far = x > length / 2 + 2 * length / n - 1e-6
    smooth = np.polynomial.Polynomial.fit(x[far], traction[far], 4)
    return float((traction[far] - smooth(x[far])).std() / traction[far].max())


@pytest.mark.parametrize("name", BESIDE.values())
def test_nodal_rules_between_stiff_faces_oscillate_less(name: str) -> None:
    """Measured: 0.28, 0.33 and 0.30 of what Gauss rules give."""
    assert oscillation(name, "nodal") < 0.45 * oscillation(name, "gauss")
