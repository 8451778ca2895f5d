"""The crack band at a point in space: what `test_crackband` asks of it in the plane, with six components and three planes."""

from __future__ import annotations

import contextlib
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from cohesive import CrackPlane
from cohesive.cracks.band_iteration import Group, groups
from cohesive.cracks.band_points import BandState, CrackBand
from cohesive.elements.bulk import elasticity
from cohesive.elements.chords import longest_chord
from cohesive.elements.rotations import PAIRS, stress_tensor, stress_transformation
from cohesive.errors import PointFailure
from tests.solids import rotation
from tests.test_crackband import CONCRETE, FT, YIELD, Zm, advance, check, follow
from tests.test_crackband import band as plane_band

Array = NDArray[np.float64]

CUBE = np.array([[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]]) / 2.0
TURNS = np.stack([np.eye(3), *(rotation(seed) for seed in range(5))])  # columns: the normal and the tangents of a plane
I, J = np.array(PAIRS[3]).T
SHEAR = np.where(I == J, 1.0, 2.0)


def voigt(tensor: Array, shear: float = 2.0) -> Array:
    """Components of tensors (..., 3, 3): strains, or with `shear` = 1 stresses."""
    return np.asarray(tensor[..., I, J] * np.where(I == J, 1.0, shear))


def band(side: float = 20.0, turns: Array = TURNS[:1], nu: float = CONCRETE.nu, **options: Any) -> CrackBand:
    """Cubes turned in space."""
    material = replace(CONCRETE, nu=nu)
    corners = np.einsum("nij,cj->nci", turns, side * CUBE)
    return CrackBand(CrackPlane(material, side), elasticity(material.E, nu), corners, **options)


def turned(strain: Any, turns: Array) -> Array:
    """Strains (6,) or (n, 6) of a frame, seen from space: (n, 6)."""
    tensor = stress_tensor(np.atleast_2d(np.asarray(strain, dtype=float)) / SHEAR)
    return voigt(turns @ tensor @ turns.transpose(0, 2, 1))


@pytest.mark.parametrize("side", [2.5, 20.0, 60.0])
@pytest.mark.parametrize(
    "corners",
    [
        [(0, 0, 0), (1.5, 0, 0)], [(0, 0, 0), (0.3, 0, 0), (-0.01, 0, 0)],
        [(0, 0, 0), (0.3, 0, 0), (0.3, 1.0, -0.4), (0.05, 0.5, 0.7)],
    ],
    ids=["opened", "closed", "sheared, then closed"],
)  # fmt: skip
def test_one_crack_is_the_law_with_the_width_of_the_element(corners: list[tuple[float, ...]], side: float) -> None:
    """Jumps in Zm, cubes turned in space all at once. Free of lateral stress: strain -nu sigma / E along both tangents."""
    law, plane = band(side, TURNS), CrackPlane(CONCRETE, side)
    state, Z = law.initial(), np.zeros(1)
    for a, b in pairwise(corners):
        for jump in np.linspace(a, b, 41)[1:] * Zm:
            (t,), Z = plane.traction(jump[None], Z)
            e, lateral = jump / side, -CONCRETE.nu * t[0] / CONCRETE.E
            strain = turned([e[0], lateral, lateral, e[1], 0, e[2]], TURNS)
            _, state = advance(law, strain, state)
            stress = turned(np.array([t[0], 0, 0, t[1], 0, t[2]]) * SHEAR, TURNS) / SHEAR
            np.testing.assert_allclose(state.stress, stress, atol=1e-8 * max(FT, abs(t).max()), rtol=0)
    assert len(state.planes.point) == len(TURNS)
    np.testing.assert_allclose(state.planes.length, side, rtol=1e-12)
    check(law, state)


#: strains in units of Zm / side
LEGS: dict[str, list[list[float]]] = {
    "two cracks": [[0.1, 0, 0, 0, 0, 0], [0.1, 0.08, 0, 0, 0, 0], [0.11, 0.1, 0, 0.02, 0.01, -0.03]],
    "three cracks": [[0.1, 0, 0, 0, 0, 0], [0.1, 0.08, 0, 0, 0, 0], [0.1, 0.08, 0.06, 0, 0, 0],
                     [0.11, 0.1, 0.09, 0.02, -0.03, 0.01]],
    "two cracks, one shut": [[0.3, 0, 0, 0, 0, 0], [0.3, 0.2, 0, 0, 0, 0], [0.01, 0.1, 0, 0.02, 0, 0.01]],
    "oblique": [[0.1, 0, 0, 0.02, 0.01, -0.02], [0.12, 0.01, 0.02, 0.05, -0.1, 0.06], [0.05, 0.03, 0.02, 0.2, 0.1, 0.05]],
}  # fmt: skip


@pytest.mark.parametrize("name", LEGS)
def test_turned_in_space_nothing_changes(name: str) -> None:
    law = band(turns=TURNS)
    state = law.initial()
    for leg in np.array(LEGS[name]) * Zm / 20.0:
        state = follow(law, state, turned(leg, TURNS))
        check(law, state)
        back = turned(state.stress * SHEAR, TURNS.transpose(0, 2, 1)) / SHEAR
        np.testing.assert_allclose(back, np.broadcast_to(back[0], back.shape), atol=1e-8 * FT)
    expected = {"two cracks": 2, "three cracks": 3, "two cracks, one shut": 2}.get(name)
    counts = np.bincount(state.planes.point)
    assert (counts == counts[0]).all() and expected in (None, counts[0])


def test_a_plane_problem_is_that_of_the_plane() -> None:
    """Strain in the xy plane only: the stresses of plane strain, as long as sigma_zz stays below ft."""
    law, plane = band(), plane_band(plane="strain")
    here, there = law.initial(), plane.initial()
    for leg in np.array([[0.1, 0, 0.02], [0.12, -0.001, 0.05], [0.02, -0.002, 0.2], [0.3, 0, -0.1]]) * Zm / 20:
        strain = np.zeros(6)
        strain[[0, 1, 3]] = leg
        here, there = follow(law, here, strain), follow(plane, there, leg)
        np.testing.assert_allclose(here.stress[0, [0, 1, 3]], there.stress[0], atol=1e-8 * FT)
        np.testing.assert_allclose(here.stress[0, 4:], 0.0, atol=1e-8 * FT)
        assert len(here.planes.point) == len(there.planes.point) > 0


@pytest.mark.parametrize(("planes", "rank"), [(1, 3), (2, 5), (3, 6)])
def test_open_planes_share_their_shear(planes: int, rank: int) -> None:
    """Opened one after the other to 10 Zm: M has the rank of N, and a step of minimum norm does not enter its null part."""
    law, wide = band(turns=TURNS[1:2]), 10 * Zm / 20.0
    legs = np.zeros((2 * planes + 1, 6))
    for i in range(planes):  # each to a little first, so that they form at right angles
        legs[i:, i] = 0.1 - 0.02 * i
    for i in range(planes):
        legs[planes + i :, : i + 1] = np.where(legs[planes + i :, : i + 1], 1.0, 0.0)
    legs[-1, 3:] = [0.1, 0.15 * (planes > 1), -0.2]  # no shear that cracks what is whole
    state = law.initial()
    for leg in legs * wide:
        before, state = state, follow(law, state, turned(leg, TURNS[1:2]))
        check(law, state)
    assert len(state.planes.point) == planes
    ((points, numbers),) = groups(state.planes.point)
    group = Group(law.plane, law.D, law.compliance, state.planes, numbers, state.deformation[points])
    group.e = state.planes.strain[numbers].reshape(1, -1)
    M = group._matrix(group._at(group.e, group.strain, np.array([0]))[1], np.array([0]))[0]
    values = np.linalg.svd(M)[1]
    assert values[rank - 1] > 0.01 * values[0] and (values[rank:] < 1e-12 * values[0]).all()
    _, _, null = np.linalg.svd(stress_transformation(state.planes.rotation).reshape(3 * planes, 6).T)
    step = (state.planes.strain - before.planes.strain).ravel()
    assert abs(null[rank:] @ step).max(initial=0.0) < 1e-9 * np.linalg.norm(step)


STATES: dict[str, list[list[float]]] = {
    "elastic": [[1e-4, 5e-5, 2e-5, 3e-5, 1e-5, 0]],
    "one crack, loading": [[0.1, 0, 0, 0, 0, 0], [0.12, 0.002, 0.001, 0.01, 0.002, -0.02]],
    "one crack, unloading": [[0.3, 0, 0, 0, 0, 0], [0.2, 0.001, 0.001, 0.005, 0, 0.003]],
    "shut": [[0.3, 0, 0, 0, 0, 0], [-0.01, -0.002, -0.001, 0.001, 0, 0.001]],
    "sheared contact": [[0.3, 0, 0, 0, 0, 0], [0.3, 0, 0, 0.3, 0, 0.3], [0.1, 0.001, 0, 0.32, 0, 0.28]],
    **{name: LEGS[name] for name in ("two cracks", "three cracks")},
}


@pytest.mark.parametrize("side", [5.0, 40.0])
@pytest.mark.parametrize("name", STATES)
def test_tangent_is_consistent(name: str, side: float) -> None:
    """Central differences, Richardson-extrapolated: the local tolerance of 1e-11 ft is 1e-8 of the modulus in them."""
    turn = TURNS[2:3]
    law, *legs = band(side, turn), *(turned(leg, turn) * Zm / side for leg in STATES[name])
    start, h = follow(law, law.initial(), *legs[:-1]), 2.5e-5 * Zm / side

    def central(size: float) -> Array:
        ends = [
            [law.update(legs[-1] + sign * size * unit[None], start)[0].stress[0] for unit in np.eye(6)] for sign in (1, -1)
        ]
        return np.asarray((np.array(ends[0]) - ends[1]).T / (2 * size))

    _, tangent = law.update(legs[-1], start)
    np.testing.assert_allclose(tangent[0], (4 * central(h / 2) - central(h)) / 3, atol=1e-6 * law.D.max(), rtol=1e-6)


def test_update_is_pure() -> None:
    law = band(turns=TURNS)
    start = follow(law, law.initial(), *(turned(leg, TURNS) * Zm / 20 for leg in LEGS["three cracks"]))
    parts = [(part, name) for part in (start, start.planes) for name in vars(part) if name != "planes"]
    copies = [getattr(part, name).copy() for part, name in parts]
    near = start.deformation * 0.9
    (first, T1), _, (second, T2) = (law.update(strain, start) for strain in (near, 3 * near, near))
    np.testing.assert_array_equal(np.r_[first.stress.ravel(), T1.ravel()], np.r_[second.stress.ravel(), T2.ravel()])
    for (part, name), value in zip(parts, copies, strict=True):
        np.testing.assert_array_equal(getattr(part, name), value, err_msg=name)


@pytest.mark.parametrize(("angle", "taken"), [(10.0, True), (20.0, False)])
def test_the_normal_of_the_path_is_taken_where_it_is_as_good(angle: float, taken: bool) -> None:
    """Uniaxial stress along x, and a path whose normal leaves it towards y and z: cos^2 is .97 and .88, the limit .95."""
    t = np.radians(angle)
    normal = np.array([[np.cos(t), np.sin(t) * 0.6, np.sin(t) * 0.8]])
    law = band(path_normal=normal)
    state = follow(law, law.initial(), 1.5 * YIELD * np.array([1, -CONCRETE.nu, -CONCRETE.nu, 0, 0, 0]))
    assert (abs(state.planes.rotation[0, 0] @ normal[0]) > 1 - 1e-12) == taken


@pytest.mark.parametrize("side", [2.5, 40.0])
def test_a_crack_slammed_shut_ends_where_a_slow_one_does(side: float) -> None:
    """To -5 and -15 MPa of uniaxial strain in one step and in 60, where the way there has a solution."""
    law = band(side)
    opened = follow(law, law.initial(), [0.3 * Zm / side, 0, 0, 0, 0, 0])
    for stress, lateral in ((5.0, 0.0), (15.0, 0.0), (15.0, -0.3)):
        target = np.array([-1, lateral, 0.5 * lateral, 0.3 * lateral, 0, 0.2 * lateral]) * stress / CONCRETE.E
        ends = [follow(law, opened, target, steps=steps) for steps in (1, 60)]
        for end in ends:
            check(law, end)
        np.testing.assert_allclose(ends[0].stress, ends[1].stress, atol=1e-7 * stress)
        assert ends[0].stress[0, 0] < -0.9 * stress


def test_random_walks_stay_on_the_law() -> None:
    """Opening, closing and shear at random: every state that is returned is in balance, and few steps fail."""
    random, law, passed, planes = np.random.default_rng(10), band(10.0, TURNS[3:4]), 0, 0
    for _ in range(8):
        state: BandState = law.initial()
        for kind in random.integers(0, 3, 20):
            size = ([0.05, 0.04, 0.03, 0.01, 0.01, 0.01], [0.02, 0.02, 0.02, 0, 0, 0], [0.01, 0.01, 0.01, 0.1, 0.1, 0.1])[kind]
            strain = state.deformation * (0.2 if kind == 1 else 1.0) + random.normal(size=6) * size * Zm / 10.0
            low = np.linalg.eigvalsh(stress_tensor(strain / SHEAR))[0, 0]
            strain[:, :3] += max(0.0, -6e-4 - low)  # not crushed
            with contextlib.suppress(PointFailure):
                _, state = advance(law, strain, state)
                check(law, state)
                passed += 1
        planes += len(state.planes.point)
    assert planes >= 16 and passed >= 155


def chords(corners: Array, direction: Array, faces: list[list[int]], count: int) -> float:
    """Longest of many chords of a convex polyhedron: lines through points in its shadow, cut with the planes of its faces."""
    centre, random = corners.mean(axis=0), np.random.default_rng(0)
    weights = random.dirichlet(np.full(len(corners), 0.3), count)
    start, ahead, behind = weights @ corners, np.full(count, np.inf), np.full(count, -np.inf)
    for face in faces:
        a, b, c = corners[face[:3]]
        normal = np.cross(b - a, c - a)
        normal *= -np.sign(normal @ (centre - a))
        rate = normal @ direction
        reach = ((a - start) @ normal) / rate
        ahead, behind = (np.minimum(ahead, reach), behind) if rate > 0 else (ahead, np.maximum(behind, reach))
    return float((ahead - behind).max())


TETRA = [0, 1, 2, 2, 3, 3, 3, 3]


def test_longest_chord_of_known_solids() -> None:
    d2, d3 = np.sqrt(0.5), np.sqrt(1 / 3)
    box = (CUBE + 0.5) * [4, 3, 2]
    corner = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])[TETRA]
    crossed = np.array([[-1, 0, 0], [1, 0, 0], [0, 1, 2], [0, -1, 2]])[TETRA]  # two edges at right angles, one over the other
    for shape, direction, length in (
        (box, (1, 0, 0), 4), (box, (0, -1, 0), 3), (box, (0.8, 0.6, 0), 5), (box, (d2, 0, d2), 2 / d2),
        (box, np.array([4, 3, 2]) / np.sqrt(29), np.sqrt(29)), (CUBE, (d3, d3, d3), 1 / d3),
        (corner, (0, 0, 1), 1), (corner, (d2, -d2, 0), 2 * d2), (corner, (d3, d3, d3), d3),
        (crossed, (0, 0, 1), 2), (crossed, (1, 0, 0), 2),
    ):  # fmt: skip
        got = longest_chord(np.asarray(shape, dtype=float) @ TURNS.transpose(0, 2, 1), TURNS @ np.array(direction))
        np.testing.assert_allclose(got, length, rtol=1e-9)


def test_longest_chord_of_random_solids() -> None:
    """Tetrahedra, and hexahedra with plane faces (cubes under projective maps), against many chords."""
    random = np.random.default_rng(4)
    hexahedron = [[0, 1, 2], [4, 5, 6], [0, 1, 5], [1, 2, 6], [2, 3, 7], [3, 0, 4]]
    for _ in range(20):
        direction = random.normal(size=3)
        direction /= np.linalg.norm(direction)
        tetra = random.normal(size=(4, 3))
        tetra[[0, 1]] = tetra[[0, 1] if np.linalg.det(tetra[1:] - tetra[0]) > 0 else [1, 0]]
        x = CUBE @ (np.eye(3) + 0.3 * random.normal(size=(3, 3)))
        brick = x / (1 + x @ random.uniform(-0.3, 0.3, 3))[:, None]
        for corners, solid, faces in (
            (tetra[TETRA], tetra, [[0, 1, 2], [0, 1, 3], [1, 2, 3], [0, 2, 3]]), (brick, brick, hexahedron),
        ):  # fmt: skip
            got = float(longest_chord(corners[None], direction[None])[0])
            sampled = chords(solid, direction, faces, 40000)
            assert sampled <= got * (1 + 1e-12) and sampled > 0.97 * got  # the sample finds the longest to some percent
