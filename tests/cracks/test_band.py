"""The crack band at a point, in 2D and 3D: against the crack-plane law, tangents, purity, rotations, robustness."""

from __future__ import annotations

import contextlib
from dataclasses import replace
from itertools import pairwise, product
from typing import Any

import numpy as np
import pytest

from cohesive import CrackPlane
from cohesive.arrays import Array
from cohesive.cracks.band_points import BandState
from cohesive.cracks.crack_planes import CrackPlanes
from cohesive.elements.rotations import PAIRS, stress_tensor
from cohesive.errors import PointFailure
from tests.cracks.bands import (
    CONCRETE,
    FT,
    SPACES,
    TURNS,
    YIELD,
    Zm,
    advance,
    band,
    check,
    dimension,
    follow,
    plane_turns,
    shear,
    turned,
    turned_stress,
)  # fmt: skip


@pytest.mark.parametrize("side", [2.5, 20.0, 60.0])
@pytest.mark.parametrize(
    "corners",
    [
        [(0, 0, 0), (1.5, 0, 0)], [(0, 0, 0), (0.3, 0, 0), (-0.01, 0, 0)],
        [(0, 0, 0), (0.3, 0, 0), (0.3, 1.0, -0.4), (0.05, 0.5, 0.7)],
    ],
    ids=["opened", "closed", "sheared, then closed"],
)  # fmt: skip
@pytest.mark.parametrize("space", ["stress", "space"])
def test_one_crack_is_the_law_with_the_width_of_the_element(space: str, corners: list[tuple[float, ...]], side: float) -> None:
    """Jumps in Zm; elements turned, all at once. Free of lateral stress: strain -nu sigma / E along the tangents."""
    d, turns = dimension(space), TURNS[space]
    law, plane = band(side, space, turns), CrackPlane(CONCRETE, side)
    state, Z = law.initial(), np.zeros(1)
    for a, b in pairwise(corners):
        for jump in np.linspace(a[:d], b[:d], 41)[1:] * Zm:
            (t,), Z = plane.traction(jump[None], Z)
            e, lateral = jump / side, -CONCRETE.nu * t[0] / CONCRETE.E
            strain = [e[0], lateral, e[1]] if d == 2 else [e[0], lateral, lateral, e[1], 0, e[2]]
            _, state = advance(law, turned(strain, turns), state)
            stress = turned_stress([t[0], 0, t[1]] if d == 2 else [t[0], 0, 0, t[1], 0, t[2]], turns)
            np.testing.assert_allclose(state.stress, stress, atol=1e-8 * max(FT, abs(t).max()), rtol=0)
    assert len(state.planes.point) == len(turns)
    np.testing.assert_allclose(state.planes.length, side, rtol=1e-12)
    check(law, state)


#: strains in space, in units of Zm / side
LEGS: dict[str, list[list[float]]] = {
    "two cracks": [[0.1, 0, 0, 0, 0, 0], [0.1, 0.08, 0, 0, 0, 0], [0.11, 0.1, 0, 0.02, 0.01, -0.03]],
    "three cracks": [[0.1, 0, 0, 0, 0, 0], [0.1, 0.08, 0, 0, 0, 0], [0.1, 0.08, 0.06, 0, 0, 0],
                     [0.11, 0.1, 0.09, 0.02, -0.03, 0.01]],
    "two cracks, one shut": [[0.3, 0, 0, 0, 0, 0], [0.3, 0.2, 0, 0, 0, 0], [0.01, 0.1, 0, 0.02, 0, 0.01]],
    "oblique": [[0.1, 0, 0, 0.02, 0.01, -0.02], [0.12, 0.01, 0.02, 0.05, -0.1, 0.06], [0.05, 0.03, 0.02, 0.2, 0.1, 0.05]],
}  # fmt: skip


@pytest.mark.parametrize("name", LEGS)
def test_rotated_in_3d_nothing_changes(name: str) -> None:
    law = band(space="space", turns=TURNS["space"])
    state = law.initial()
    for leg in np.array(LEGS[name]) * Zm / 20.0:
        state = follow(law, state, turned(leg, TURNS["space"]))
        check(law, state)
        back = turned_stress(state.stress, TURNS["space"].transpose(0, 2, 1))
        np.testing.assert_allclose(back, np.broadcast_to(back[0], back.shape), atol=1e-8 * FT)
    expected = {"two cracks": 2, "three cracks": 3, "two cracks, one shut": 2}.get(name)
    counts = np.bincount(state.planes.point)
    assert (counts == counts[0]).all() and expected in (None, counts[0])


def test_a_plane_problem_is_that_of_the_plane() -> None:
    """Strain in the xy plane only: the stresses of plane strain, as long as sigma_zz stays below ft."""
    law, plane = band(space="space"), band(space="strain")
    here, there = law.initial(), plane.initial()
    for leg in np.array([[0.1, 0, 0.02], [0.12, -0.001, 0.05], [0.02, -0.002, 0.2], [0.3, 0, -0.1]]) * Zm / 20:
        strain = np.zeros(6)
        strain[[0, 1, 3]] = leg
        here, there = follow(law, here, strain), follow(plane, there, leg)
        np.testing.assert_allclose(here.stress[0, [0, 1, 3]], there.stress[0], atol=1e-8 * FT)
        np.testing.assert_allclose(here.stress[0, 4:], 0.0, atol=1e-8 * FT)
        assert len(here.planes.point) == len(there.planes.point) > 0


#: legs that are committed, and the step, in units of Zm / side
IN_THE_PLANE: dict[str, list[list[float]]] = {
    "elastic": [[1e-4, 5e-5, 3e-5]],
    "one crack, loading": [[0.1, 0, 0], [0.12, 0.002, 0.01]],
    "one crack, unloading": [[0.3, 0, 0], [0.2, 0.001, 0.005]],
    "closing": [[0.3, 0, 0], [0.02, 0.001, 0.002]],
    "shut": [[0.3, 0, 0], [-0.01, -0.002, 0.001]],
    "sheared contact": [[0.3, 0, 0], [0.3, 0, 0.4], [0.1, 0.001, 0.42]],
    "sheared contact, loading": [[0.1, 0, 0], [0.1, 0.001, 0.8]],
    "two cracks": [[0.1, 0, 0], [0.1, 0.08, 0], [0.11, 0.1, 0.02]],
    "two cracks, unloading": [[0.3, 0, 0], [0.3, 0.2, 0], [0.15, 0.1, 0.03]],
    "two cracks, one shut": [[0.3, 0, 0], [0.3, 0.2, 0], [0.01, 0.1, 0.02]],
}
IN_SPACE: dict[str, list[list[float]]] = {
    "elastic": [[1e-4, 5e-5, 2e-5, 3e-5, 1e-5, 0]],
    "one crack, loading": [[0.1, 0, 0, 0, 0, 0], [0.12, 0.002, 0.001, 0.01, 0.002, -0.02]],
    "one crack, unloading": [[0.3, 0, 0, 0, 0, 0], [0.2, 0.001, 0.001, 0.005, 0, 0.003]],
    "shut": [[0.3, 0, 0, 0, 0, 0], [-0.01, -0.002, -0.001, 0.001, 0, 0.001]],
    "sheared contact": [[0.3, 0, 0, 0, 0, 0], [0.3, 0, 0, 0.3, 0, 0.3], [0.1, 0.001, 0, 0.32, 0, 0.28]],
    **{name: LEGS[name] for name in ("two cracks", "three cracks")},
}
STATES = [
    *((space, name) for space in ("stress", "strain") for name in IN_THE_PLANE), *(("space", name) for name in IN_SPACE),
]  # fmt: skip


@pytest.mark.parametrize("side", [5.0, 40.0])
@pytest.mark.parametrize(("space", "name"), STATES)
def test_tangent_is_consistent(space: str, name: str, side: float) -> None:
    """Central differences, Richardson-extrapolated: the local tolerance of 1e-11 ft is 1e-8 of the modulus in them."""
    turn, states = (TURNS[space][2:3], IN_SPACE) if space == "space" else (TURNS[space][:1], IN_THE_PLANE)
    law, *legs = band(side, space, turn), *(turned(leg, turn) * Zm / side for leg in states[name])
    start, h = follow(law, law.initial(), *legs[:-1]), 2.5e-5 * Zm / side
    assert len(start.planes.point) == {"two": 2, "three": 3}.get(name.split()[0], len(legs) > 1)

    def central(size: float) -> Array:
        ends = [
            [law.update(legs[-1] + sign * size * unit[None], start)[0].stress[0] for unit in np.eye(len(law.D))]
            for sign in (1, -1)
        ]
        return np.asarray((np.array(ends[0]) - ends[1]).T / (2 * size))

    _, tangent = law.update(legs[-1], start)
    np.testing.assert_allclose(tangent[0], (4 * central(h / 2) - central(h)) / 3, atol=1e-6 * law.D.max(), rtol=1e-6)


@pytest.mark.parametrize("space", SPACES)
def test_update_is_pure_and_history_follows_the_committed_state(space: str) -> None:
    turns = TURNS[space]
    legs = np.array(LEGS["three cracks"] if space == "space" else [[0.1, 0, 0], [0.1, 0.05, 0]]) * Zm / 20
    law = band(20.0, space, turns)
    start = follow(law, law.initial(), *(turned(leg, turns) for leg in legs))
    parts = [(part, name) for part in (start, start.planes) for name in vars(part) if name != "planes"]
    copies = [getattr(part, name).copy() for part, name in parts]
    near, far = 0.9 * start.deformation, 10.0 * start.deformation
    (first, T1), (thrown, _), (second, T2) = (law.update(strain, start) for strain in (near, far, near))
    assert (thrown.planes.history > 2 * start.planes.history).any()
    np.testing.assert_array_equal(np.r_[first.stress.ravel(), T1.ravel()], np.r_[second.stress.ravel(), T2.ravel()])
    for (part, name), value in zip(parts, copies, strict=True):
        np.testing.assert_array_equal(getattr(part, name), value, err_msg=name)
    for state in (first, thrown):
        Z = CrackPlane(CONCRETE, state.planes.length).traction(state.planes.jump, start.planes.history)[1]
        np.testing.assert_array_equal(state.planes.history, Z)


@pytest.mark.parametrize("degrees", [0.0, 20.0, 60.0, 90.0])
@pytest.mark.parametrize("space", SPACES)
def test_a_plane_on_the_path_is_the_only_one_however_the_point_is_pulled(space: str, degrees: float) -> None:
    """Pulled along x to 30 times the strains at ft: the normal of the path stands at an angle to x, towards y and z. Along the
    path, at 90 degrees, the concrete stays whole."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    normal = np.array([[c, 0.6 * s, 0.8 * s] if space == "space" else [c, s]])
    law = band(20.0, space, path_normal=normal)
    start, pull = law.initial(), np.linalg.solve(law.D, 30 * FT * np.eye(len(law.D))[0])[None]
    assert len(start.planes.point) == 1
    # elastic at half of ft on the plane or less
    np.testing.assert_allclose(law.update(pull / 60, start)[0].stress, pull / 60 @ law.D, atol=1e-10 * FT)
    state = follow(law, start, pull)
    check(law, state)
    assert law.nucleate(start, state) is None
    np.testing.assert_array_equal(state.planes.rotation[:, 0], normal)
    assert (state.planes.history > start.planes.history).all() == (degrees < 90)
    if degrees == 90:
        np.testing.assert_allclose(state.stress, pull @ law.D, atol=1e-9 * FT)


@pytest.mark.parametrize(("plane", "nu"), [("stress", 0.2), ("strain", 0.2), ("strain", 0.45)])
@pytest.mark.parametrize("side", [2.5, 40.0])
def test_a_crack_slammed_shut_in_2d_ends_where_a_slow_one_does(side: float, plane: str, nu: float) -> None:
    """To -10 .. -40 MPa in one step and in 60. At nu = .45 a fold may bar a way, which then fails."""
    law, random, compared = band(side, plane, nu=nu), np.random.default_rng(9), 0
    opened = follow(law, law.initial(), [0.3 * Zm / side, 0, 0])
    for stress, mixed in product((10.0, 25.0, 40.0), (0, 1)):
        ends, direction = [], np.array([-1, *random.uniform(-0.5, 0.0, 2) * mixed])
        for steps in (1, 60):
            with contextlib.suppress(PointFailure):
                ends.append(follow(law, opened, direction * stress / CONCRETE.E, steps=steps))
                check(law, ends[-1])
        if len(ends) == 2 and np.array_equal(ends[0].planes.history, ends[1].planes.history):
            np.testing.assert_allclose(ends[0].stress, ends[1].stress, atol=1e-7 * stress)
            compared += 1
    assert compared >= (5 if nu == 0.2 else 3)


@pytest.mark.parametrize("side", [2.5, 40.0])
def test_a_crack_slammed_shut_in_3d_ends_where_a_slow_one_does(side: float) -> None:
    """To -5 and -15 MPa of uniaxial strain in one step and in 60, where the way there has a solution."""
    law = band(side, "space")
    opened = follow(law, law.initial(), [0.3 * Zm / side, 0, 0, 0, 0, 0])
    for stress, lateral in ((5.0, 0.0), (15.0, 0.0), (15.0, -0.3)):
        target = np.array([-1, lateral, 0.5 * lateral, 0.3 * lateral, 0, 0.2 * lateral]) * stress / CONCRETE.E
        ends = [follow(law, opened, target, steps=steps) for steps in (1, 60)]
        for end in ends:
            check(law, end)
        np.testing.assert_allclose(ends[0].stress, ends[1].stress, atol=1e-7 * stress)
        assert ends[0].stress[0, 0] < -0.9 * stress


@pytest.mark.parametrize(
    ("plane", "nu"),
    [
        pytest.param("stress", 0.2, marks=pytest.mark.long),
        pytest.param("strain", 0.2, marks=pytest.mark.long),
        ("strain", 0.45),
    ],
)
def test_random_walks_in_2d_stay_on_the_law(plane: str, nu: float) -> None:
    """Opening, closing and shear at random: every state that is returned is in balance, and few steps fail."""
    random, law, passed, planes = np.random.default_rng(10), band(10.0, plane, nu=nu), 0, 0
    for _ in range(10):
        state = law.initial()
        for kind in random.integers(0, 3, 25):
            move = random.normal(size=3) * ([0.05, 0.03, 0.01], [0.02, 0.02, 0.0], [0.01, 0.01, 0.1])[kind] * Zm / 10.0
            strain = state.deformation * ([1, 1, 1], [0.2, 0.2, 1], [1, 1, 1])[kind] + move  # the second: nearly shut
            with contextlib.suppress(PointFailure):
                _, state = advance(law, np.maximum(strain, [-8e-4, -8e-4, -np.inf]), state)
                check(law, state)
                passed += 1
        planes += len(state.planes.point)
    assert planes > 14 and passed >= 247


def test_random_walks_in_3d_stay_on_the_law() -> None:
    """Opening, closing and shear at random: every state that is returned is in balance, and few steps fail."""
    random, law, passed, planes = np.random.default_rng(10), band(10.0, "space", TURNS["space"][3:4]), 0, 0
    for _ in range(8):
        state: BandState = law.initial()
        for kind in random.integers(0, 3, 20):
            size = ([0.05, 0.04, 0.03, 0.01, 0.01, 0.01], [0.02, 0.02, 0.02, 0, 0, 0], [0.01, 0.01, 0.01, 0.1, 0.1, 0.1])[kind]
            strain = state.deformation * (0.2 if kind == 1 else 1.0) + random.normal(size=6) * size * Zm / 10.0
            low = np.linalg.eigvalsh(stress_tensor(strain / shear(3)))[0, 0]
            strain[:, :3] += max(0.0, -6e-4 - low)  # not crushed
            with contextlib.suppress(PointFailure):
                _, state = advance(law, strain, state)
                check(law, state)
                passed += 1
        planes += len(state.planes.point)
    assert planes >= 16 and passed >= 155


@pytest.mark.parametrize(("strains", "separated"), [((1.0, 1.0), True), ((1.0, 0.0), False), ((1.0, -1e-4), False)])
def test_separated_is_where_every_point_is(strains: tuple[float, float], separated: bool) -> None:
    """Opened to 100 Zm; then one of the two points pressed together again, or never opened."""
    law = band(20.0, turns=plane_turns(0.0, 0.0))
    pull = np.array([[strain != 0, 0, 0] for strain in strains]) * 100 * Zm / 20.0
    state = follow(law, law.initial(), 1e-3 * pull, pull)
    if strains[1] < 0:
        state = follow(law, state, pull * [[1.0], [-1e-5]])
        assert abs(state.planes.traction[1]).max() > 0.01 * FT
    assert law.is_separated(state) == separated


def test_a_closed_plane_that_slides_freely_is_not_separated() -> None:
    """A spent plane with a traction along one axis only."""
    law = band(20.0)
    pull = np.array([[100 * Zm / 20.0, 0, 0]])
    state = follow(law, law.initial(), 1e-3 * pull, pull)
    assert law.is_separated(state)
    pressed = replace(state, planes=replace(state.planes, traction=np.array([[-1.0, 0.0]])))
    assert not law.is_separated(pressed)


@pytest.mark.parametrize(("second", "planes"), [(1.06, 2), (1.04, 1)])
def test_points_half_as_far_beyond_ft_crack_together(second: float, planes: int) -> None:
    """Elastic stresses of 1.1 ft at one point, at the other 1.06 or 1.04 ft: its excess is 0.6 or 0.4 of the largest."""
    law = band(20.0, turns=plane_turns(0.0, 0.0))
    stress = FT * np.array([[1.1, 0, 0], [second, 0, 0]])
    start = law.initial()
    state, _ = law.update(np.linalg.solve(law.D, stress.T).T, start)
    grown = law.nucleate(start, state)
    assert grown is not None and len(grown.planes.point) == planes


def test_a_plane_beyond_a_fold_is_not_followed() -> None:
    """Printed contact at nu = .45 is stiffer than the concrete: in closing, the strain of the point has a least value, beyond
    which a smaller jump needs a larger strain. A state there, put together by hand, has no solution that continues it."""
    side = 40.0
    law = band(side, "strain", nu=0.45)
    Z = np.array([0.157 * Zm])

    def state(jump: float) -> BandState:
        traction, _, _ = CrackPlane(law.law.concrete, side).update(np.array([[jump, 0.0]]), Z)
        e = np.array([[jump / side, 0.0]])
        strain = np.array([[jump / side - law.compliance[0] * traction[0, 0] + traction[0, 0] / law.D[0, 0], 0.0, 0.0]])
        stress = (strain - [[e[0, 0] - law.compliance[0] * traction[0, 0], 0.0, 0.0]]) @ law.D
        point, slope = np.zeros(1, dtype=np.intp), np.zeros((1, 2, 3))
        return BandState(strain, stress, CrackPlanes(point, np.eye(2)[None], np.array([side]), e, traction, Z, slope))

    open_, shut = state(0.02 * Zm), state(5.2e-4 * Zm)
    assert np.linalg.norm(law.update(open_.deformation, open_)[0].stress - open_.stress) < 1e-9 * FT
    with pytest.raises(PointFailure):
        law.update(shut.deformation, shut)


@pytest.mark.parametrize("space", SPACES)
def test_committed_slopes_save_an_evaluation_and_change_no_state(space: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of points without a plane, with one and with two; without slopes every point is evaluated where it was committed."""
    d = dimension(space)
    law = band(space=space, turns=np.repeat(TURNS[space][:1], 3, axis=0))
    opened, both = np.zeros(len(PAIRS[d])), np.zeros(len(PAIRS[d]))
    opened[0], both[0], both[1] = 30 * YIELD, 30 * YIELD, 20 * YIELD
    start = follow(law, law.initial(), np.stack([0.01 * opened, opened, opened]), np.stack([0.01 * opened, opened, both]))
    assert np.bincount(start.planes.point, minlength=3).tolist() == [0, 1, 2]
    without = replace(start, planes=replace(start.planes, slope=np.zeros_like(start.planes.slope)))
    step = start.deformation * [[1.0], [1.3], [1.2]]
    calls = 0
    evaluate = CrackPlane.update

    def counted(self: CrackPlane, *given: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        nonlocal calls
        calls += 1
        return evaluate(self, *given)

    monkeypatch.setattr(CrackPlane, "update", counted)
    state, tangent = law.update(step, start)
    with_slopes, calls = calls, 0
    other, other_tangent = law.update(step, without)
    assert calls == with_slopes + 1
    # both solve their points to 1e-11 ft
    np.testing.assert_allclose(state.stress, other.stress, atol=1e-9 * FT)
    np.testing.assert_allclose(tangent, other_tangent, atol=1e-8 * abs(law.D).max())
    calls = 0
    law.update(start.deformation, start)  # where it stands a point is evaluated once
    assert calls == 1
