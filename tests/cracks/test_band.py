"""The crack band at a point: against the crack-plane law, tangents, purity, l_ch, energies, robustness."""

from __future__ import annotations

import contextlib
from dataclasses import fields, replace
from itertools import pairwise, product
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from cohesive import Concrete, CrackPlane
from cohesive.cracks.band_points import BandState, CrackBand
from cohesive.elements.bulk import elasticity
from cohesive.elements.rotations import stress_transformation
from cohesive.errors import PointFailure

Array = NDArray[np.float64]

CONCRETE = Concrete.preset("reinhardt")
Zm, FT, YIELD = CONCRETE.Zm, CONCRETE.ft, CONCRETE.ft / CONCRETE.E
ANGLES = np.radians([0.0, 30.0, 45.0, 90.0, 137.2])


def rotations(angle: Any) -> Array:
    """Rows normal and tangent of planes whose normals stand at `angle` to the x axis."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([np.stack([c, s], axis=-1), np.stack([s, -c], axis=-1)], axis=-2)


def band(side: float = 20.0, plane: str = "stress", angle: Any = (0.0,), scaled: bool = True, **options: Any) -> CrackBand:
    """Square elements turned by `angle`; options of the band, and of Concrete."""
    own = {f.name for f in fields(CrackBand)} & options.keys()
    material = replace(CONCRETE, **{key: options[key] for key in options.keys() - own})
    square = side * np.array([[-0.5, 0.5], [-0.5, -0.5], [0.5, -0.5], [0.5, 0.5]])  # along normal and -tangent
    corners = np.einsum("nij,ci->ncj", rotations(np.array(angle)) * [[[1], [-1]]], square)
    law = CrackPlane(material, side, shear_scaling=scaled)
    return CrackBand(law, elasticity(material.E, material.nu, plane), corners, **{key: options[key] for key in own})


def advance(law: CrackBand, strain: Array, start: BandState) -> tuple[BandState, BandState]:
    """A step as the solver takes it, planes growing on the committed state until none is due: that state and the new one."""
    state, _ = law.update(strain, start)
    while (grown := law.nucleate(start, state)) is not None:
        start = grown
        state, _ = law.update(strain, start)
    return start, state


def follow(law: CrackBand, start: BandState, *targets: Any, steps: int = 15) -> BandState:
    """Straight legs in the strain."""
    for target in targets:
        begin = start.deformation
        for part in np.linspace(0, 1, steps + 1)[1:]:
            _, start = advance(law, begin + part * (np.asarray(target, dtype=float) - begin), start)
    return start


def check(law: CrackBand, state: BandState) -> None:
    """On every plane the stress is the traction of the law at its jump, eq. (41), and the strain splits as in eq. (30)."""
    cracks, allowed = state.planes, 2 * law.tol * FT + 1e-13 * abs(state.stress).max()
    assert np.isfinite(state.stress).all()
    N, release = stress_transformation(cracks.rotation), np.zeros_like(state.stress)
    for i, point in enumerate(cracks.point):
        plane = CrackPlane(law.concrete, float(cracks.length[i]), shear_scaling=law.plane.shear_scaling)
        traction, Z = plane.traction(cracks.jump[[i]], cracks.Z[[i]])
        np.testing.assert_allclose([N[i] @ state.stress[point], cracks.traction[i]], [*traction, *traction], atol=allowed)
        assert Z[0] == cracks.Z[i]
        release[point] += N[i].T @ (cracks.strain[i] - law.compliance * traction[0])
    np.testing.assert_allclose(state.stress, (state.deformation - release) @ law.D, atol=10 * allowed, rtol=1e-12)


@pytest.mark.parametrize("side", [2.5, 20.0, 60.0])
@pytest.mark.parametrize(
    "corners", [[(0, 0), (1.5, 0)], [(0, 0), (0.3, 0), (-0.01, 0)], [(0, 0), (0.3, 0), (0.3, 1.0), (0.05, 0.5)]],
    ids=["opened", "closed", "sheared, then closed"],
)  # fmt: skip
def test_one_crack_is_the_law_with_the_width_of_the_element(corners: list[tuple[float, float]], side: float) -> None:
    """Jumps in Zm. Lateral stress free: strain -nu sigma / E along the plane. Turned squares all at once, l_ch = side."""
    law, plane, f = band(side, angle=ANGLES), CrackPlane(CONCRETE, side), rotations(ANGLES)
    N, across = stress_transformation(f), stress_transformation(f[:, ::-1])
    state, Z = law.initial(), np.zeros(1)
    for a, b in pairwise(corners):
        for jump in np.linspace(a, b, 41)[1:] * Zm:
            (t,), Z = plane.traction(jump[None], Z)
            strain = N.transpose(0, 2, 1) @ (jump / side) - CONCRETE.nu * t[0] / CONCRETE.E * across[:, 0]
            _, state = advance(law, strain, state)
            # n t1 n + t2 (n t + t n), where N^T makes engineering shear of it
            stress = N.transpose(0, 2, 1) @ (t * [1, 2]) * [1, 1, 0.5]
            np.testing.assert_allclose(state.stress, stress, atol=1e-8 * max(FT, abs(t).max()), rtol=0)
    assert len(state.planes.point) == len(ANGLES)
    np.testing.assert_allclose(state.planes.length, side, rtol=1e-12)


def test_without_shear_scaling_contact_has_the_printed_reduction() -> None:
    """H instead of H_w, eqs (13) and (25): the ratio of the two contact tractions at one jump."""
    side, jump, contact = 5.0, np.array([[0.1, 0.5]]) * Zm, []
    for scaled in (True, False):
        law, plane = band(side, scaled=scaled), CrackPlane(CONCRETE, side, shear_scaling=scaled)
        t = plane.traction(jump, np.zeros(1))[0][0]
        strain = [jump[0, 0] / side, -CONCRETE.nu * t[0] / CONCRETE.E, jump[0, 1] / side]
        state = follow(law, law.initial(), [0.1 * Zm / side, 0, 0], strain)
        check(law, state)
        np.testing.assert_allclose(state.stress[0], [t[0], 0, t[1]], atol=1e-8 * FT)
        undamaged = (1 - plane.damage(state.planes.Z)) * plane.stiffness(2) * state.planes.jump[0]
        contact.append(state.planes.traction[0] - undamaged)
    H = float(np.dot(CONCRETE.p, np.exp(-jump[0, 0] / (np.array(CONCRETE.c) * Zm))))
    np.testing.assert_allclose(contact[0] / contact[1], side / (H * side + (1 - H) * CONCRETE.h), rtol=1e-6)


@pytest.mark.parametrize("components", [2, 3])
def test_a_law_of_many_widths_is_the_laws_of_each(components: int) -> None:
    random, widths = np.random.default_rng(1), np.geomspace(0.1, 60, 40)
    many = CrackPlane(CONCRETE, widths)
    before, jump = random.normal(size=(2, 40, components)) * Zm * np.geomspace(0.01, 2, 40)[:, None]
    Z0, Z = random.uniform(0, Zm, 40), random.uniform(0, Zm, 40)

    def everything(law: CrackPlane, i: Any) -> list[Array]:
        Z1 = law.history(before[i], Z0[i])
        return [
            *law.update(jump[i], Z[i]), law.update(jump[i], Z[i], frozen=True)[1], *law.traction(jump[i], Z[i]),
            *law.dissipation(before[i], Z1, jump[i], law.history(jump[i], Z1)), law.stored_energy(jump[i], Z[i]),
            law.contact_traction(jump[i], Z[i]), *law.contact_distance(jump[i], Z[i]), law.damage(Z[i]),
        ]  # fmt: skip

    each = [everything(CrackPlane(CONCRETE, float(w)), [i]) for i, w in enumerate(widths)]
    for j, value in enumerate(everything(many, slice(None))):
        np.testing.assert_allclose(value, np.concatenate([one[j] for one in each]), rtol=1e-13)
    for bad in (np.array([1.0, 0.0]), np.array([1.0, -2.0]), np.array([np.nan]), np.array([np.inf]), np.ones((2, 2))):
        with pytest.raises(ValueError, match=r"(?s)^width = .*: expected a \(n,\) array of finite numbers above 0"):
            many.with_width(bad)


def test_two_planes_do_not_know_which_is_which_and_share_the_shear() -> None:
    """Opened one after the other to 10 Zm and sheared; the same with the axes exchanged. Two free planes share the shear
    strain with the least norm: the part of de that makes no strain, N^T de = 0, is never entered."""
    law, wide = band(), 10 * Zm / 20.0
    here = there = law.initial()
    for leg in np.array([[0.05, 0, 0], [0.1, 0.05, 0], [1, 0.9, 0], [1, 0.9, 0.1], [1, 0.9, 0.5], [1, 0.9, -0.2]]) * wide:
        before, here, there = here, follow(law, here, leg), follow(law, there, leg[[1, 0, 2]])
        check(law, here)
        np.testing.assert_allclose(here.stress[:, [1, 0, 2]], there.stress, atol=1e-9 * FT)
        if leg[2] != 0:
            step = (here.planes.strain - before.planes.strain).ravel()
            null = np.linalg.svd(stress_transformation(here.planes.rotation).reshape(4, 3).T)[2][-1]
            assert abs(step @ null) < 1e-9 * np.linalg.norm(step)
    np.testing.assert_allclose(abs(here.planes.rotation[:, 0]), np.eye(2), atol=1e-9)


@pytest.mark.parametrize(
    ("options", "angles", "planes"),
    [
        ({"threshold_angle": 58.0}, (0, 61, 121), 3), ({"threshold_angle": 58.0, "max_cracks": 2}, (0, 61, 121), 2),
        ({}, (0, 61, 121), 2), ({}, (0, 58, 130), 1), ({"threshold_angle": 50.0}, (0, 58), 2), ({"max_cracks": 1}, (0, 90), 1),
    ],
)  # fmt: skip
def test_the_threshold_angle_and_the_number_of_planes(options: dict[str, Any], angles: tuple[float, ...], planes: int) -> None:
    """Pulled to barely beyond ft and released, one way after the other: the point stays elastic but for a thousandth."""
    law = band(**options)
    state = law.initial()
    for f in rotations(np.radians(angles)):
        N, across = (stress_transformation(g[None])[0, 0] for g in (f, f[::-1]))
        state = follow(law, state, 1.001 * YIELD * (N - CONCRETE.nu * across), np.zeros(3), steps=5)
    assert len(state.planes.point) == planes
    normals = np.degrees(np.arctan2(*state.planes.rotation[:, 0, ::-1].T))
    assert (abs((normals - angles[:planes] + 90) % 180 - 90) < 0.1).all()
    wide = 0.5 * Zm / 20.0  # all opened and sheared
    for target in ([wide, 0, 0], [wide, wide, 0], [wide, wide, 0.7 * wide], [0.3 * wide, 0.2 * wide, -0.5 * wide]):
        state = follow(law, state, target)
        check(law, state)


@pytest.mark.parametrize(("degrees", "taken"), [(10.0, True), (20.0, False)])
def test_the_normal_of_the_path_is_taken_where_it_is_as_good(degrees: float, taken: bool) -> None:
    normal = rotations(np.radians([degrees]))[:, 0]  # cos^2 is .97 and .88, the limit .95
    law = band(path_normal=normal)
    state = follow(law, law.initial(), [1.5 * YIELD, -0.3 * YIELD, 0])
    assert (abs(state.planes.rotation[0, 0] @ normal[0]) > 1 - 1e-12) == taken


def test_a_new_plane_is_inert() -> None:
    law = band(angle=np.zeros(3))
    start, _ = law.update(YIELD * np.array([[0.5, -2, 0.3], [0.9, 0, 0], [0, 0, 0]]), law.initial())
    for planes in (3, 6):  # on intact points, and beside a plane that is open
        pull = [3 * YIELD, 0, YIELD] if planes == 3 else [0, 3 * YIELD, 0]
        grown = law.nucleate(start, law.update(start.deformation + pull, start)[0])
        assert grown is not None and len(grown.planes.point) == planes
        again, tangent = law.update(start.deformation, grown, frozen=True)
        np.testing.assert_allclose(again.stress, start.stress, atol=1e-11 * FT)
        np.testing.assert_array_equal(again.planes.Z, grown.planes.Z)
        before = law.update(start.deformation, start, frozen=True)[1]
        np.testing.assert_allclose(tangent, before, rtol=0, atol=1e-8 * law.D.max())
        start = follow(law, law.initial(), [0.1 * Zm / 20, 0, 0])


STATES: dict[str, list[list[float]]] = {  # legs that are committed, and the step, in units of Zm / side
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


@pytest.mark.parametrize("plane", ["stress", "strain"])
@pytest.mark.parametrize("side", [5.0, 40.0])
@pytest.mark.parametrize("name", STATES)
def test_tangent_is_consistent(name: str, side: float, plane: str) -> None:
    """Central differences, Richardson-extrapolated: the local tolerance of 1e-11 ft is 1e-8 of the modulus in them."""
    law, *legs = band(side, plane), *(np.array(leg) * Zm / side for leg in STATES[name])
    start, h = follow(law, law.initial(), *legs[:-1]), 2.5e-5 * Zm / side
    assert len(start.planes.point) == (2 if "two" in name else len(legs) > 1)

    def central(size: float) -> Array:
        ends = [
            [law.update(legs[-1] + sign * size * unit[None], start)[0].stress[0] for unit in np.eye(3)] for sign in (1, -1)
        ]
        return (np.array(ends[0]) - ends[1]).T / (2 * size)

    _, tangent = law.update(legs[-1][None], start)
    np.testing.assert_allclose(tangent[0], (4 * central(h / 2) - central(h)) / 3, atol=1e-6 * law.D.max(), rtol=1e-6)


@pytest.mark.parametrize("plane", ["stress", "strain"])
def test_frozen_gives_the_unloading_tangent(plane: str) -> None:
    """One-sided differences at a state on the damage surface: each direction has its tangent, and not the other one."""
    law, h, seen = band(20.0, plane), 1e-7, set()
    start = follow(law, law.initial(), np.array([0.1, 0, 0.01]) * Zm / 20)
    assert law.is_on_surface(start)
    for direction in np.random.default_rng(2).normal(size=(12, 3)):
        ends = [law.update(start.deformation + size * direction, start)[0] for size in (h, h / 2)]
        loading = bool(ends[0].planes.Z[0] > start.planes.Z[0])
        coarse, fine = ((end.stress - start.stress)[0] / size for end, size in zip(ends, (h, h / 2), strict=True))
        right, wrong = (law.update(start.deformation, start, frozen=f)[1][0] @ direction for f in (not loading, loading))
        np.testing.assert_allclose(right, 2 * fine - coarse, atol=1e-5 * law.D.max())
        assert abs(wrong - fine).max() > 1e-3 * law.D.max()
        seen.add(loading)
    assert seen == {True, False}


def test_update_is_pure_and_history_follows_the_committed_state() -> None:
    law, unit = band(angle=ANGLES), Zm / 20
    start = follow(law, law.initial(), [0.1 * unit, 0, 0], [0.1 * unit, 0.05 * unit, 0])
    held = {name: value for part in (start, start.planes) for name, value in vars(part).items() if name != "planes"}
    copies = {name: value.copy() for name, value in held.items()}
    far, near = (np.tile(np.array(x) * unit, (len(ANGLES), 1)) for x in ([1.0, 0.5, 0.3], [0.08, 0.04, 0.01]))
    (first, T1), (thrown, _), (second, T2) = (law.update(strain, start) for strain in (near, far, near))
    assert (thrown.planes.Z > 2 * start.planes.Z).any()
    np.testing.assert_array_equal(np.r_[first.stress.ravel(), T1.ravel()], np.r_[second.stress.ravel(), T2.ravel()])
    for name, value in copies.items():
        np.testing.assert_array_equal(held[name], value, err_msg=name)
    for state in (first, thrown):
        Z = CrackPlane(CONCRETE, state.planes.length).traction(state.planes.jump, start.planes.Z)[1]
        np.testing.assert_array_equal(state.planes.Z, Z)


def books(law: CrackBand, legs: Any, steps: int) -> tuple[Array, float, float]:
    """Work, elastic, stored, dissipated, contact work per volume along legs of strain; the largest work and imbalance."""
    state, totals, largest, worst = law.initial(), np.zeros(5), 0.0, 0.0
    for begin, end in pairwise([[0, 0, 0], *legs]):
        for strain in np.linspace(begin, end, steps + 1)[1:]:
            old, state = advance(law, strain[None], state)
            totals[0] += 0.5 * float(((old.stress + state.stress) * (state.deformation - old.deformation)).sum())
            totals[1:3] = [float(x[0]) for x in law.energies(state)]
            totals[3:] += law.dissipation(old, state)[0][0], law.contact_work(old, state)[0]
            largest, worst = max(largest, totals[0]), max(worst, abs(totals[0] - totals[1:].sum()))
    return totals, largest, worst


@pytest.mark.parametrize(
    ("legs", "contact"),
    [
        ([[0.01, 0, 0], [1.0, 0, 0]], 0.0), ([[0.01, 0, 0], [0.3, 0, 0], [0, 0, 0]], 0.01),
        ([[0.01, 0, 0], [0.1, 0, 0], [0.1, 0, 0.6]], 0.1), ([[0.01, 0, 0], [0.2, 0, 0], [0.2, 0.2, 0.1]], 0.0),
    ],
    ids=["opening", "opening and closing", "opening, then shear", "two cracks"],
)  # fmt: skip
def test_work_is_accounted_for(legs: list[list[float]], contact: float) -> None:
    """Legs in units of Zm / side. The integrals over a step are of second order in it: at 200 steps below 1e-3."""
    totals, largest, worst = books(band(), np.array(legs) * Zm / 20, 200)
    assert worst < 1e-3 * largest and abs(totals[4]) >= contact * largest


@pytest.mark.parametrize("side", [2.0, 20.0, 100.0])
def test_opening_dissipates_the_fracture_energy_over_the_length(side: float) -> None:
    """To 2 Zm, where 6 e^-10 of the energy is to come; without a Poisson's ratio, free of lateral stress."""
    totals, *_ = books(band(side, nu=0.0), [[0.01 * Zm / side, 0, 0], [2 * Zm / side, 0, 0]], 50)
    expected = (CONCRETE.Gf + FT**2 * side / (2 * CONCRETE.E)) / side
    assert 0.999 * expected < totals[3] < expected


@pytest.mark.parametrize("legs", [[[0.1, 0, 0.02]], [[0.1, 0, 0], [0.1, 0.08, 0.02]]], ids=["one crack", "two cracks"])
def test_dissipation_gradient(legs: list[list[float]]) -> None:
    law, unit = band(), Zm / 20
    start, h = follow(law, law.initial(), *np.array([[0.05, 0, 0], *legs]) * unit), 1e-4 * unit
    assert len(start.planes.point) == len(legs)
    at = start.deformation + np.array([0.03, 0.04, 0.03]) * unit

    def value(strain: Array) -> float:
        return float(law.dissipation(start, law.update(strain, start)[0])[0].sum())

    gradient = law.dissipation(start, law.update(at, start)[0])[1][0]
    expected = [(value(at + h * e) - value(at - h * e)) / (2 * h) for e in np.eye(3)]
    np.testing.assert_allclose(gradient, expected, atol=1e-6 * abs(gradient).max())


def test_a_failure_names_the_point(monkeypatch: pytest.MonkeyPatch) -> None:
    law = band(angle=ANGLES)
    start = follow(law, law.initial(), [0.1 * Zm / 20, 0, 0])
    strain = start.deformation + np.eye(5)[:, [3]] * [0.2, 0.1, 0.2] * Zm / 20
    monkeypatch.setattr("cohesive.cracks.band_iteration.MAX_ITERATIONS", 0)
    with pytest.raises(PointFailure, match=r"1 point\(s\) have no solution") as caught:
        law.update(strain, start)
    assert caught.value.point == 3


@pytest.mark.parametrize(("plane", "nu"), [("stress", 0.2), ("strain", 0.2), ("strain", 0.45)])
@pytest.mark.parametrize("side", [2.5, 40.0])
def test_a_crack_slammed_shut_ends_where_a_slow_one_does(side: float, plane: str, nu: float) -> None:
    """To -10 .. -40 MPa in one step and in 60. At nu = .45 a fold may bar a way, which then fails."""
    law, random, compared = band(side, plane, nu=nu), np.random.default_rng(9), 0
    opened = follow(law, law.initial(), [0.3 * Zm / side, 0, 0])
    for stress, mixed in product((10.0, 25.0, 40.0), (0, 1)):
        ends, direction = [], np.array([-1, *random.uniform(-0.5, 0.0, 2) * mixed])
        for steps in (1, 60):
            with contextlib.suppress(PointFailure):
                ends.append(follow(law, opened, direction * stress / CONCRETE.E, steps=steps))
                check(law, ends[-1])
        if len(ends) == 2 and np.array_equal(ends[0].planes.Z, ends[1].planes.Z):
            np.testing.assert_allclose(ends[0].stress, ends[1].stress, atol=1e-7 * stress)
            compared += 1
    assert compared >= (5 if nu == 0.2 else 3)


@pytest.mark.parametrize(("plane", "nu"), [("stress", 0.2), ("strain", 0.2), ("strain", 0.45)])
def test_random_walks_stay_on_the_law(plane: str, nu: float) -> None:
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
