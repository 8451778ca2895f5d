"""Rotations of planes, and the transformation of stresses to them."""

from __future__ import annotations

import numpy as np
import pytest

from cohesive.elements.rotations import rotations, stress_tensor, stress_transformation


def test_rotations_are_right_handed_and_those_of_the_plane() -> None:
    normal = np.concatenate([np.random.default_rng(0).normal(size=(50, 3)), np.eye(3), -np.eye(3)])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    made = rotations(normal)
    np.testing.assert_allclose(made @ made.transpose(0, 2, 1), np.broadcast_to(np.eye(3), made.shape), atol=1e-14)
    np.testing.assert_allclose(np.linalg.det(made), 1.0, rtol=1e-13)
    np.testing.assert_array_equal(made[:, 0], normal)
    flat = np.stack([np.cos(np.arange(7.0)), np.sin(np.arange(7.0))], axis=1)
    np.testing.assert_allclose(rotations(np.column_stack([flat, np.zeros(7)]))[:, :2, :2], rotations(flat), atol=1e-15)


@pytest.mark.parametrize("d", [2, 3])
def test_stress_transformation_is_the_tensor_rule(d: int) -> None:
    random = np.random.default_rng(6)
    frame = np.linalg.qr(random.normal(size=(20, d, d)))[0]
    stress, e = random.normal(size=(20, d * (d + 1) // 2)), random.normal(size=(20, d))
    N, sigma, n = stress_transformation(frame), stress_tensor(stress), frame[:, 0]  # N^T: engineering strain, same work
    i, j = np.array([(0, 0), (1, 1), (0, 1)] if d == 2 else [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)]).T
    np.testing.assert_array_equal(sigma[:, [i, j], [j, i]], np.stack([stress, stress], axis=1))
    local = np.einsum("ndk,nk->nd", N, stress)
    np.testing.assert_allclose(local, np.einsum("nij,njk,nk->ni", frame, sigma, n), atol=1e-14)
    half = np.einsum("ni,nd,ndj->nij", n, e, frame) / 2
    voigt = (half + half.transpose(0, 2, 1))[:, i, j] * np.where(i == j, 1, 2)
    np.testing.assert_allclose(np.einsum("ndk,nd->nk", N, e), voigt, atol=1e-14)
    np.testing.assert_allclose((voigt * stress).sum(axis=1), (e * local).sum(axis=1), atol=1e-13)
