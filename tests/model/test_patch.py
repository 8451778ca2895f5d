"""A patch test of the whole chain: a uniform stress passes a slanted crack, and a rigid motion gives no force."""

from __future__ import annotations

import numpy as np
import pytest

from cohesive.model.build import build
from cohesive.solver.newton import advance
from tests.builders import block

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
    assert float(state.cracks.history.max()) == problem.point_law.law.Zt  # elastic
    np.testing.assert_allclose(state.cracks.stress, np.broadcast_to(traction, state.cracks.stress.shape), rtol=1e-8)
    np.testing.assert_allclose(state.cracks.deformation, state.cracks.stress / problem.point_law.law.stiffness(2), rtol=1e-8)
    axis = np.radians(13.0 + 90.0)
    direction = np.array([np.cos(axis), np.sin(axis)])
    expected = sigma * np.array([direction[0] ** 2, direction[1] ** 2, direction[0] * direction[1]])
    for elements in model.bulk:
        stress = elements.stress(model.condensation.recover(state.v))
        np.testing.assert_allclose(stress, np.broadcast_to(expected, stress.shape), atol=1e-8 * sigma)


def test_rigid_motion_gives_no_force() -> None:
    model = build(block(specimen__angle=27.0, solver__condensation="never"))
    points = model.mesh.points
    u = np.array([0.1, -0.2]) + 0.01 * np.stack([-points[:, 1], points[:, 0]], axis=1)
    for elements in model.bulk:
        K = elements.stiffness()
        force = np.einsum("nij,nj->ni", K, u[elements.cells].reshape(len(K), -1))
        assert abs(force).max() < 1e-9 * abs(K).max() * abs(u).max()
    assert abs(model.cracks.operator @ u.ravel()).max() < 1e-14
