"""Shape functions and quadrature rules, in meshio's node order: lines, triangles, quadrilaterals, tetrahedra, hexahedra.

A shape takes local points (q, local dimension) and gives N (q, nodes) and its local derivatives (q, nodes, local dimension).
Simplices lie between 0 and 1, lines and cubes between -1 and 1. A rule is points (q, local dimension) and weights (q,).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..arrays import Array

Rule = tuple[Array, Array]

Shape = Callable[[Array], tuple[Array, Array]]


def linear_simplex(r: Array) -> tuple[Array, Array]:
    """Triangle or tetrahedron with its corners."""
    d = r.shape[1]
    first = 1.0
    for x in r.T:
        first = first - x
    dN = np.concatenate([np.full((1, d), -1.0), np.eye(d)])
    return np.column_stack([first, r]), np.tile(dN, (len(r), 1, 1))


def quadratic_simplex(r: Array) -> tuple[Array, Array]:
    """Triangle or tetrahedron with corners and mid-sides."""
    L, dL = linear_simplex(r)
    pairs = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)][: 3 * (r.shape[1] - 1)]
    N = np.stack([a * (2 * a - 1) for a in L.T] + [4 * L[:, i] * L[:, j] for i, j in pairs], axis=1)
    corners = (4 * L - 1)[:, :, None] * dL
    mids = [4 * (L[:, [i]] * dL[:, j] + L[:, [j]] * dL[:, i]) for i, j in pairs]
    return N, np.concatenate([corners, np.stack(mids, axis=1)], axis=1)


_SQUARE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])

_CUBE_CORNERS = {
    1: np.array([[-1.0], [1.0]]),
    2: _SQUARE,
    3: np.column_stack([np.tile(_SQUARE, (2, 1)), np.repeat([-1.0, 1.0], 4)]),
}


def linear_cube(r: Array) -> tuple[Array, Array]:
    """Line, quadrilateral or hexahedron with its corners."""
    d = r.shape[1]
    corners = _CUBE_CORNERS[d]
    factors = 1 + r[:, None, :] * corners
    others = [corners[:, i] * np.delete(factors, i, axis=2).prod(axis=2) for i in range(d)]
    return factors.prod(axis=2) / 2**d, np.stack(others, axis=2) / 2**d


def quadratic_line(r: Array) -> tuple[Array, Array]:
    """Line with its ends and its middle."""
    s = np.array([-1.0, 1.0])
    return np.concatenate([r * (r + s) / 2, 1 - r**2], axis=1), np.concatenate([r + s / 2, -2 * r], axis=1)[:, :, None]


def serendipity(r: Array) -> tuple[Array, Array]:
    """Quadrilateral with corners and mid-sides, these in the order of the edges: bottom, right, top, left."""
    x, y = r[:, :1], r[:, 1:]
    X, Y = _SQUARE.T
    fx, fy, serendipity = 1 + x * X, 1 + y * Y, x * X + y * Y - 1
    corners = fx * fy * serendipity / 4
    d_corners = np.stack([X * fy * (serendipity + fx), Y * fx * (serendipity + fy)], axis=2) / 4
    s = np.array([-1.0, 1.0])
    flat, steep = (1 - x**2) * (1 + y * s) / 2, (1 - y**2) * (1 + x * s) / 2
    d_flat = np.stack([-x * (1 + y * s), (1 - x**2) * s / 2], axis=2)
    d_steep = np.stack([(1 - y**2) * s / 2, -y * (1 + x * s)], axis=2)
    N = np.stack([flat[:, 0], steep[:, 1], flat[:, 1], steep[:, 0]], axis=1)
    dN = np.stack([d_flat[:, 0], d_steep[:, 1], d_flat[:, 1], d_steep[:, 0]], axis=1)
    return np.concatenate([corners, N], axis=1), np.concatenate([d_corners, dN], axis=1)


def quadratic_along(r: Array) -> tuple[Array, Array]:
    """Quadratic along the first axis, linear across: the nodes of `serendipity` without mid-sides on the right and left."""
    (along, d_along), (across, d_across) = quadratic_line(r[:, :1]), linear_cube(r[:, 1:])
    pairs = [(0, 0), (1, 0), (1, 1), (0, 1), (2, 0), (2, 1)]
    N = np.stack([along[:, i] * across[:, j] for i, j in pairs], axis=1)
    d_x = np.stack([d_along[:, i, 0] * across[:, j] for i, j in pairs], axis=1)
    d_y = np.stack([along[:, i] * d_across[:, j, 0] for i, j in pairs], axis=1)
    return N, np.stack([d_x, d_y], axis=2)


def gauss_cube(n: int, d: int) -> Rule:
    """Gauss rule with n points along each of d axes."""
    x, w = np.polynomial.legendre.leggauss(n)
    points = np.stack(np.meshgrid(*[x] * d, indexing="ij"), axis=-1).reshape(-1, d)
    return points, np.stack(np.meshgrid(*[w] * d, indexing="ij"), axis=-1).prod(axis=-1).ravel()


def _orbit(share: float, size: float, d: int) -> Rule:
    """The d + 1 points of a simplex with barycentric coordinates (1 - d a, a, ..., a), a = `share`, of total weight `size`."""
    return np.full((d + 1, d), share) + (1 - (d + 1) * share) * np.eye(d + 1)[:, 1:], np.full(d + 1, size / (d + 1))


def gauss_simplex(degree: int, d: int) -> Rule:
    """Rule of a triangle or tetrahedron with interior points, exact to a degree of 1, 2 or, in a triangle, 4."""
    volume = 1.0 / (2.0, 6.0)[d - 2]
    if degree == 1:
        return np.full((1, d), 1.0 / (d + 1)), np.array([volume])
    if degree == 2:
        return _orbit((1 - 1 / np.sqrt(d + 2)) / (d + 1), volume, d)
    # two orbits, their places and weights in closed form
    root, cube = np.sqrt(10.0), np.sqrt(38.0 - 44.0 * np.sqrt(0.4))
    shares = [(8 - root + sign * cube) / 18 for sign in (1, -1)]
    sizes = [(620 + sign * np.sqrt(213125.0 - 53320.0 * root)) / 1240 * volume for sign in (1, -1)]
    orbits = [_orbit(share, size, d) for share, size in zip(shares, sizes, strict=True)]
    return np.concatenate([at for at, _ in orbits]), np.concatenate([weights for _, weights in orbits])
