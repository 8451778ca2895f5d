"""Elements of the bulk, plane and solid: shape functions, rigid motions, patch tests, order, prisms, what is refused."""

from __future__ import annotations

from math import comb

import numpy as np
import pytest
import scipy.sparse.linalg as spla

from cohesive.algebra.bulk_matrix import bulk_stiffness
from cohesive.arrays import Array
from cohesive.elements.bulk import ElasticBlock, elasticity
from cohesive.elements.chords import longest_chord
from cohesive.elements.registry import ELEMENTS, centre_rule
from cohesive.elements.rotations import PAIRS
from cohesive.elements.shapes import gauss_cube, quadratic_along
from cohesive.errors import ElementError
from tests.builders import MIDS, Patch, box, rectangle, rotation

PLANE = ["triangle", "triangle6", "quad", "quad8"]
SOLID = ["tetra", "tetra10", "hexahedron"]
KINDS = PLANE + SOLID
#: in the plane with its two elasticities
ELASTIC = [*((kind, plane) for kind in PLANE for plane in ("stress", "strain")), *((kind, None) for kind in SOLID)]
STRAIN = {2: np.array([1.0, -2.0, 0.5]) * 1e-3, 3: np.array([1.0, -2.0, 0.7, 0.5, -0.3, 0.9]) * 1e-3}
SIZE = (1.0, 1.2, 0.9)
#: of plane bodies, mm
THICKNESS = 7.0


def dimension(kind: str) -> int:
    return 2 if kind in PLANE else 3


def regular(kind: str, n: int = 1) -> Patch:
    """n squares or cubes along each axis of a unit square or cube."""
    return rectangle(kind, (n, n)) if kind in PLANE else box(kind, (n, n, n))


def distorted(kind: str) -> Patch:
    """3 x 3 squares or 3 x 3 x 3 cubes whose inner corners are moved at random; sides stay straight."""
    d = dimension(kind)
    patch = rectangle(kind, (3, 3), SIZE[:2]) if d == 2 else box(kind, (3, 3, 3), SIZE)
    inside = ((patch.points > 1e-9) & (patch.points < patch.points.max(axis=0) - 1e-9)).all(axis=1)
    shift = np.random.default_rng(1).uniform(-0.08, 0.08, patch.points.shape) * inside[:, None]
    for mid, a, b in MIDS.get(kind, []):
        shift[patch.cells[:, mid]] = 0.5 * (shift[patch.cells[:, a]] + shift[patch.cells[:, b]])
    patch.points = patch.points + shift
    return patch


def elastic(patch: Patch, plane: str | None = "stress") -> ElasticBlock:
    d = patch.points.shape[1]
    D = elasticity(30e3, 0.2, plane if d == 2 else None)
    return ElasticBlock(patch.kind, patch.points, patch.cells, D, THICKNESS if d == 2 else 1.0)


def volume(kind: str) -> float:
    """Of the distorted patch."""
    return float(np.prod(SIZE[: dimension(kind)])) * (THICKNESS if kind in PLANE else 1.0)


def strain_tensor(strain: Array) -> Array:
    d = 2 if len(strain) == 3 else 3
    tensor = np.zeros((d, d))
    for value, (i, j) in zip(strain, PAIRS[d], strict=True):
        tensor[i, j] = tensor[j, i] = value if i == j else value / 2
    return tensor


def solve(block: ElasticBlock, exact: Array) -> Array:
    """Displacements (m, d) with the nodes on the sides of the body held at `exact`."""
    K = bulk_stiffness([block], block.points.size).tocsc()
    low, high = block.points.min(axis=0), block.points.max(axis=0)
    on_side = ((block.points < low + 1e-9) | (block.points > high - 1e-9)).any(axis=1)
    free = np.flatnonzero(np.repeat(~on_side, block.dimension))
    u = np.where(on_side[:, None], exact, 0.0).ravel()
    u[free] = spla.spsolve(K[free][:, free], -(K @ u)[free])
    return u.reshape(exact.shape)


def test_elasticity_of_space_holds_that_of_the_plane() -> None:
    D, plane = elasticity(30e3, 0.2), [0, 1, 3]
    np.testing.assert_allclose(D[np.ix_(plane, plane)], elasticity(30e3, 0.2, "strain"), rtol=1e-12)
    C = np.linalg.inv(D)
    np.testing.assert_allclose(np.linalg.inv(C[np.ix_(plane, plane)]), elasticity(30e3, 0.2, "stress"), rtol=1e-12)


def test_plane_strain_holds_the_third_direction() -> None:
    E, nu = 30e3, 0.3
    D = elasticity(E, nu, "strain")
    lame, G = E * nu / (1 + nu) / (1 - 2 * nu), E / 2 / (1 + nu)
    np.testing.assert_allclose(D, [[lame + 2 * G, lame, 0], [lame, lame + 2 * G, 0], [0, 0, G]], rtol=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_shape_functions(kind: str) -> None:
    """1 at their own node and 0 at the others; derivatives against differences; they sum to 1."""
    shape, (at, weights) = ELEMENTS[kind].shape, ELEMENTS[kind].rule
    one, d = regular(kind), dimension(kind)
    p = one.points[one.cells[0]]
    is_simplex = kind.startswith(("tri", "tet"))
    local = np.linalg.solve((p[1 : d + 1] - p[0]).T, (p - p[0]).T).T if is_simplex else 2 * p - 1
    np.testing.assert_allclose(shape(local)[0], np.eye(len(local)), atol=1e-14)
    N, dN = shape(at)
    np.testing.assert_allclose(N.sum(axis=1), 1.0, rtol=1e-14)
    for axis, step in enumerate(1e-6 * np.eye(d)):
        np.testing.assert_allclose(dN[:, :, axis], (shape(at + step)[0] - shape(at - step)[0]) / 2e-6, atol=1e-9)
    assert weights.sum() == pytest.approx(1 / (2, 6)[d - 2] if is_simplex else 2.0**d, rel=1e-14)


@pytest.mark.parametrize("kind", KINDS)
def test_stiffness_is_symmetric_with_rigid_motions(kind: str) -> None:
    """Three in the plane, six in space, and no other motion without force."""
    block, d = elastic(distorted(kind)), dimension(kind)
    K, n_rigid = block.stiffness(), d + comb(d, 2)
    np.testing.assert_allclose(K, K.transpose(0, 2, 1), atol=1e-9 * K.max())
    values = np.linalg.eigvalsh(K)
    assert (abs(values[:, :n_rigid]) < 1e-10 * values[:, -1:]).all()
    assert (values[:, n_rigid] > 1e-4 * values[:, -1]).all()
    turn = np.random.default_rng(0).normal(size=(d, d))
    rigid = block.points @ (turn - turn.T) + turn[0]
    force = np.einsum("nij,nj->ni", K, rigid[block.cells].reshape(len(K), -1))
    assert abs(force).max() < 1e-12 * abs(K).max() * abs(rigid).max() * len(K[0])
    np.testing.assert_allclose(block.stress(rigid), 0.0, atol=1e-12 * block.D.max())


@pytest.mark.parametrize(("kind", "plane"), ELASTIC)
def test_patch_of_distorted_elements(kind: str, plane: str | None) -> None:
    block, strain = elastic(distorted(kind), plane), STRAIN[dimension(kind)]
    stress, size = block.D @ strain, volume(kind)
    assert block.volumes().sum() == pytest.approx(size, rel=1e-13)
    exact = block.points @ strain_tensor(strain)
    u = solve(block, exact)
    np.testing.assert_allclose(u, exact, atol=1e-12 * abs(exact).max())
    seen = block.stress(u)
    np.testing.assert_allclose(seen, np.broadcast_to(stress, seen.shape), atol=1e-11 * abs(stress).max())
    of_cells = u[block.cells].reshape(len(block.cells), -1)
    energy = 0.5 * float(np.einsum("ni,nij,nj->", of_cells, block.stiffness(), of_cells))
    assert energy == pytest.approx(0.5 * strain @ stress * size, rel=1e-11)
    operator, volumes, where, cell = block.strain_points()
    seen = (operator @ u.ravel()).reshape(-1, len(strain))
    np.testing.assert_allclose(seen, np.broadcast_to(strain, seen.shape), atol=1e-13)
    assert volumes.sum() == pytest.approx(size, rel=1e-13)
    centres = np.stack([np.bincount(cell, x * volumes) / np.bincount(cell, volumes) for x in where.T], axis=1)
    if kind.startswith(("tri", "tet")):  # of others, distorted, the centre of volume lies elsewhere
        corners = block.points[block.cells[:, : dimension(kind) + 1]]
        np.testing.assert_allclose(centres, corners.mean(axis=1), atol=1e-12)


def test_a_hexahedron_with_equal_nodes_is_a_prism() -> None:
    """As an extruded triangle: the patch test, and l_ch."""
    solid = distorted("hexahedron")
    solid.cells = solid.cells[:, [[0, 1, 2, 2, 4, 5, 6, 6], [0, 2, 3, 3, 4, 6, 7, 7]]].reshape(-1, 8)
    block, strain = elastic(solid), STRAIN[3]
    assert block.volumes().sum() == pytest.approx(volume("hexahedron"), rel=1e-13)
    exact = block.points @ strain_tensor(strain)
    u = solve(block, exact)
    np.testing.assert_allclose(u, exact, atol=1e-12 * abs(exact).max())
    stress = np.broadcast_to(block.D @ strain, (len(block.cells), 6))
    np.testing.assert_allclose(block.stress(u), stress, atol=1e-11 * block.D.max() * 1e-3)
    straight = box("hexahedron")
    prism = straight.points[straight.cells[:, [0, 1, 2, 2, 4, 5, 6, 6]]]
    d = np.sqrt(0.5)
    for direction, length in (((0, 0, 1), 1), ((1, 0, 0), 1), ((d, -d, 0), d), ((d, d, 0), 2 * d), ((0, d, d), 2 * d)):
        np.testing.assert_allclose(longest_chord(prism, np.array([direction])), length, rtol=1e-12)


def bending_error(kind: str, n: int) -> float:
    """Error of the energy norm in pure bending with the sides held at the exact displacements, relative."""
    block, d, nu, kappa = elastic(regular(kind, n)), dimension(kind), 0.2, 1e-3
    x, *y, z = (block.points - 0.5).T  # xx = kappa z, and -nu kappa z across
    beside = [-nu * y[0] * z] if y else []
    exact = kappa * np.stack([x * z, *beside, -0.5 * (x**2 + nu * (z**2 - (y[0] ** 2 if y else 0.0)))], axis=1)
    u = solve(block, exact)
    exact_enough = {"tetra": "tetra10", "triangle": "triangle6"}.get(kind, kind)
    operator, volumes, where, _ = block.strain_points(ELEMENTS[exact_enough].rule)
    uniaxial = np.array([1.0, *[-nu] * (d - 1), *[0.0] * comb(d, 2)])
    error = (operator @ u.ravel()).reshape(-1, len(uniaxial)) - kappa * (where[:, -1:] - 0.5) * uniaxial
    whole = 30e3 * kappa**2 / 12 * (THICKNESS if d == 2 else 1.0)
    return float(np.sqrt(np.einsum("p,pi,ij,pj->", volumes, error, block.D, error) / whole))


@pytest.mark.parametrize("kind", KINDS)
def test_order_in_bending(kind: str) -> None:
    """Strains of first-order elements err with h; those of second order have pure bending among their displacements."""
    coarse, fine = bending_error(kind, 3), bending_error(kind, 6)
    if kind in MIDS:
        assert coarse < 1e-12 and fine < 1e-12
    else:
        assert 0.95 < np.log2(coarse / fine) < 1.05


INVERTED = {
    "triangle": [0, 2, 1], "triangle6": [0, 2, 1, 5, 4, 3], "quad": [3, 2, 1, 0], "quad8": [3, 2, 1, 0, 6, 5, 4, 7],
    "tetra": [0, 2, 1, 3], "tetra10": [0, 2, 1, 3, 6, 5, 4, 7, 9, 8], "hexahedron": [4, 5, 6, 7, 0, 1, 2, 3],
}  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_inverted_and_flat_elements_are_named(kind: str) -> None:
    one, d = regular(kind), dimension(kind)
    D, size = elasticity(30e3, 0.2, "stress" if d == 2 else None), ("area", "volume")[d - 2]
    place = ", ".join([".*"] * d)
    with pytest.raises(ElementError, match=rf"{kind} element 0 at \({place}\) is inverted or has no {size}"):
        ElasticBlock(kind, one.points, one.cells[:1, INVERTED[kind]], D).stiffness()
    for seed in range(10):  # flat but for rounding, which makes some of these volumes positive
        flat = (one.points * [1, 1, 0][-d:]) @ rotation(seed, d).T + [1, 2, 3][:d]
        with pytest.raises(ElementError, match=f"no {size}"):
            ElasticBlock(kind, flat, one.cells[:1], D).stiffness()
    other = one.points[:, :2] if d == 3 else np.column_stack([one.points, one.points[:, 0]])
    with pytest.raises(ElementError, match=rf"'{kind}': points have {5 - d} coordinates"):
        ElasticBlock(kind, other, one.cells, D)


def test_what_no_element_is_and_has() -> None:
    quad, tetra = elastic(regular("quad")), elastic(regular("tetra"))
    with pytest.raises(ElementError, match="'wedge': expected one of triangle"):
        ElasticBlock("wedge", tetra.points, tetra.cells, tetra.D)
    with pytest.raises(ElementError, match="'hexahedron'"):
        ElasticBlock("hexahedron", quad.points, quad.cells, quad.D, 1.0)
    with pytest.raises(ElementError, match="thickness = 5: expected none in space"):
        ElasticBlock("tetra", tetra.points, tetra.cells, tetra.D, 5.0)


def test_the_mid_plane_sees_all_but_twisting() -> None:
    """17 of the 18 deformations of a hexahedron; the other, u = (yz, xz, -xy), strains the bulk on its faces."""
    solid = box("hexahedron", (1, 1, 1), (2.0, 2.0, 2.0))
    block = elastic(solid)
    operator, volumes, where, _ = block.strain_points(centre_rule("hexahedron"))
    np.testing.assert_allclose(where[:, 2], 1.0, rtol=1e-14)
    assert volumes.sum() == pytest.approx(8.0, rel=1e-14)
    assert np.linalg.matrix_rank(operator.toarray()) == 17
    x, y, z = (solid.points - 1).T
    np.testing.assert_allclose(operator @ np.stack([y * z, x * z, -x * y], axis=1).ravel(), 0.0, atol=1e-14)
    linear = (operator @ np.stack([0 * x, 0 * x, (1 + 0.4 * x - 0.3 * y) * z], axis=1).ravel()).reshape(-1, 6)
    np.testing.assert_allclose(linear[:, [0, 1, 3, 4, 5]], 0.0, atol=1e-14)  # a crack that opens linearly: no shear
    np.testing.assert_allclose(linear[:, 2], 1 + 0.4 * (where[:, 0] - 1) - 0.3 * (where[:, 1] - 1), rtol=1e-13)


def test_the_rule_of_a_band_element_integrates_its_stiffness() -> None:
    """A rectangle of 3 x 2 mm with mid-sides along x only, against 6 x 6 points; any deformation of its nodes."""
    at, weights = gauss_cube(6, 2)
    nodes = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [0, -1], [0, 1]]) * [1.5, 1.0]
    block = ElasticBlock("quad6", nodes, np.arange(6)[None], elasticity(30e3, 0.2, "stress"), THICKNESS)
    dN = quadratic_along(at)[1] / [1.5, 1.0]
    B = np.zeros((len(at), 3, 12))
    B[:, 0, 0::2] = B[:, 2, 1::2] = dN[:, :, 0]
    B[:, 1, 1::2] = B[:, 2, 0::2] = dN[:, :, 1]
    exact = np.einsum("q,qia,ij,qjb->ab", THICKNESS * 1.5 * weights, B, block.D, B)
    np.testing.assert_allclose(block.stiffness()[0], exact, rtol=0, atol=1e-12 * exact.max())
