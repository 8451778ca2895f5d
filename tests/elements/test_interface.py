"""Elastic and interface elements: patch tests, rigid motions, rotation."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from cohesive.elements.bulk import ElasticBlock, elasticity
from cohesive.elements.interface import Interface
from cohesive.errors import ElementError
from cohesive.model.build import build
from cohesive.solver.newton import advance
from tests.builders import block

Array = NDArray[np.float64]

#: one distorted element of each kind (straight sides, as the specimens have)
CORNERS = {"triangle": [[0, 0], [2, 0.3], [0.7, 1.6]], "quad": [[0, 0], [2, 0.3], [1.7, 1.6], [-0.2, 1.1]]}


def element(kind: str) -> ElasticBlock:
    corners = np.array(CORNERS[kind.rstrip("68")], dtype=float)
    points = corners
    if kind[-1] in "68":
        points = np.concatenate([corners, (corners + np.roll(corners, -1, axis=0)) / 2])
    return ElasticBlock(kind, points, np.arange(len(points))[None], elasticity(30e3, 0.2, "stress"), 7.0)


@pytest.mark.parametrize("kind", ["triangle", "triangle6", "quad", "quad8"])
def test_stiffness_is_symmetric_with_three_rigid_motions(kind: str) -> None:
    K = element(kind).stiffness()[0]
    np.testing.assert_allclose(K, K.T, atol=1e-9 * K.max())
    values = np.linalg.eigvalsh(K)
    assert (abs(values[:3]) < 1e-10 * values[-1]).all()
    assert values[3] > 1e-4 * values[-1]


@pytest.mark.parametrize("plane", ["stress", "strain"])
@pytest.mark.parametrize("kind", ["triangle", "triangle6", "quad", "quad8"])
def test_uniform_strain(kind: str, plane: str) -> None:
    one = element(kind)
    D = elasticity(30e3, 0.2, plane)
    one = ElasticBlock(kind, one.points, one.cells, D, 7.0)
    strain = np.array([1e-3, -2e-3, 5e-4])
    u = one.points @ np.array([[strain[0], strain[2] / 2], [strain[2] / 2, strain[1]]])
    np.testing.assert_allclose(one.stress(u)[0], D @ strain, rtol=1e-11)
    energy = 0.5 * u.ravel() @ one.stiffness()[0] @ u.ravel()
    assert energy == pytest.approx(0.5 * strain @ D @ strain * one.volumes().sum(), rel=1e-12)


def test_plane_strain_holds_the_third_direction() -> None:
    E, nu = 30e3, 0.3
    D = elasticity(E, nu, "strain")
    lame, G = E * nu / (1 + nu) / (1 - 2 * nu), E / 2 / (1 + nu)
    np.testing.assert_allclose(D, [[lame + 2 * G, lame, 0], [lame, lame + 2 * G, 0], [0, 0, G]], rtol=1e-12)


def test_an_inverted_element_is_named() -> None:
    one = element("quad")
    with pytest.raises(ElementError, match=r"quad element 0 at .*inverted"):
        ElasticBlock("quad", one.points, one.cells[:, ::-1], one.D, 1.0).stiffness()
    with pytest.raises(ElementError, match="'hexahedron'"):
        ElasticBlock("hexahedron", one.points, one.cells, one.D, 1.0)


ANGLES = [0.0, 30.0, 45.0, 90.0, 137.2]
KINDS = [("quad", "nodal"), ("quad", "gauss"), ("quad8", "nodal"), ("quad8", "gauss")]


def opened(kind: str, angle: float) -> tuple[Array, NDArray[np.int64], Array]:
    """Points, one crack cell of length 5 at an angle, and the rotation from its frame to space."""
    t = np.radians(angle)
    along, normal = np.array([np.cos(t), np.sin(t)]), np.array([-np.sin(t), np.cos(t)])
    a, b = np.array([1.0, 2.0]), np.array([1.0, 2.0]) + 5 * along
    points = [a, b, b, a] + ([(a + b) / 2, b, (a + b) / 2, a] if kind == "quad8" else [])
    cell = [0, 1, 2, 3] + ([4, 1, 6, 3] if kind == "quad8" else [])
    return np.array(points), np.array([cell]), np.stack([normal, along], axis=1)


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize(("kind", "quadrature"), KINDS)
def test_interface_jump(kind: str, quadrature: str, angle: float) -> None:
    points, cells, frame = opened(kind, angle)
    interface = Interface.from_cells(kind, points, cells, 3.0, quadrature)
    assert interface.area == pytest.approx(15.0, rel=1e-12)
    np.testing.assert_allclose(interface.normals, np.broadcast_to(frame[:, 0], interface.normals.shape), atol=1e-12)
    # a uniform jump between the sides, every pair of nodes included
    u = np.zeros_like(points)
    plus = [2, 3, 6] if kind == "quad8" else [2, 3]
    u[plus] = frame @ [0.3, -0.2]
    jump = (interface.jump_operator @ u.ravel()).reshape(-1, 2)
    np.testing.assert_allclose(jump, np.broadcast_to([0.3, -0.2], jump.shape), atol=1e-13)
    # a rigid motion of both sides, turning included
    rigid = np.array([0.1, -0.4]) + 0.01 * np.stack([-points[:, 1], points[:, 0]], axis=1)
    np.testing.assert_allclose(interface.jump_operator @ rigid.ravel(), 0.0, atol=1e-13)


@pytest.mark.parametrize(("kind", "quadrature"), KINDS)
def test_interface_integrates_a_linear_jump(kind: str, quadrature: str) -> None:
    points, cells, frame = opened(kind, 30.0)
    interface = Interface.from_cells(kind, points, cells, 1.0, quadrature)
    s = (points - points[0]) @ frame[:, 1]
    u = np.zeros_like(points)
    plus = [2, 3, 6] if kind == "quad8" else [2, 3]
    u[plus] = s[plus, None] * frame[:, 0]
    opening = (interface.jump_operator @ u.ravel()).reshape(-1, 2)[:, 0]
    np.testing.assert_allclose(opening, (interface.points - points[0]) @ frame[:, 1], atol=1e-13)
    assert interface.weights @ opening == pytest.approx(12.5, rel=1e-12)


MESHES = [("triangle", 1), ("triangle", 2), ("quad", 1), ("quad", 2)]


@pytest.mark.parametrize("quadrature", ["nodal", "gauss"])
@pytest.mark.parametrize(("shape", "order"), MESHES)
def test_patch_through_a_slanted_interface(shape: str, order: int, quadrature: str) -> None:
    """Uniaxial stress passes a slanted elastic interface: stress uniform, jumps as the traction wants them."""
    scene = block(
        specimen__angle=27.0, specimen__rotation=13.0, mesh__shape=shape, mesh__order=order, interface__quadrature=quadrature,
        interface__width=5.0,
    )  # fmt: skip
    model = build(scene)
    problem = model.problem
    state = advance(problem, problem.initial(), "load", 100.0).state
    sigma = 100.0 / 400.0
    # the upper half moves against the lower one without turning, which the free faces allow
    t = np.radians(27.0)
    traction = sigma * np.array([np.cos(t) ** 2, np.cos(t) * np.sin(t)])
    assert float(state.cracks.Z.max()) == problem.point_law.plane.Zt  # elastic
    np.testing.assert_allclose(state.cracks.stress, np.broadcast_to(traction, state.cracks.stress.shape), rtol=1e-8)
    np.testing.assert_allclose(state.cracks.deformation, state.cracks.stress / problem.point_law.plane.stiffness(2), rtol=1e-8)
    axis = np.radians(13.0 + 90.0)
    direction = np.array([np.cos(axis), np.sin(axis)])
    expected = sigma * np.array([direction[0] ** 2, direction[1] ** 2, direction[0] * direction[1]])
    for elements in model.blocks:
        stress = elements.stress(model.condensation.recover(state.v))
        np.testing.assert_allclose(stress, np.broadcast_to(expected, stress.shape), atol=1e-8 * sigma)


def test_rigid_motion_gives_no_force() -> None:
    model = build(block(specimen__angle=27.0, solver__reduction="none"))
    points = model.mesh.points
    u = np.array([0.1, -0.2]) + 0.01 * np.stack([-points[:, 1], points[:, 0]], axis=1)
    for elements in model.blocks:
        K = elements.stiffness()
        force = np.einsum("nij,nj->ni", K, u[elements.cells].reshape(len(K), -1))
        assert abs(force).max() < 1e-9 * abs(K).max() * abs(u).max()
    assert abs(model.cracks.operator @ u.ravel()).max() < 1e-14
