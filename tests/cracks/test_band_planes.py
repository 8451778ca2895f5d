"""Crack planes at a point of a band: how many, how they share the shear, their tangents, energies and failures."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.linalg import block_diag

from cohesive import CrackPlane
from cohesive.arrays import Array
from cohesive.cracks.band_points import CrackBand
from cohesive.elements.rotations import stress_transformation
from cohesive.errors import PointFailure
from tests.cracks.bands import CONCRETE, FT, TURNS, YIELD, Zm, advance, band, check, follow, plane_turns, turned


def test_without_shear_scaling_contact_has_the_printed_reduction() -> None:
    """H instead of H_w, eqs (13) and (25): the ratio of the two contact tractions at one jump."""
    side, jump, contact = 5.0, np.array([[0.1, 0.5]]) * Zm, []
    for scaled in (True, False):
        law, plane = band(side, scaled=scaled), CrackPlane(replace(CONCRETE, shear_scaling=scaled), side)
        t = plane.traction(jump, np.zeros(1))[0][0]
        strain = [jump[0, 0] / side, -CONCRETE.nu * t[0] / CONCRETE.E, jump[0, 1] / side]
        state = follow(law, law.initial(), [0.1 * Zm / side, 0, 0], strain)
        check(law, state)
        np.testing.assert_allclose(state.stress[0], [t[0], 0, t[1]], atol=1e-8 * FT)
        undamaged = (1 - plane.damage(state.planes.history)) * plane.stiffness(2) * state.planes.jump[0]
        contact.append(state.planes.traction[0] - undamaged)
    H = float(np.dot(CONCRETE.p, np.exp(-jump[0, 0] / (np.array(CONCRETE.c) * Zm))))
    np.testing.assert_allclose(contact[0] / contact[1], side / (H * side + (1 - H) * CONCRETE.h), rtol=1e-6)


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
    for f in plane_turns(*angles).transpose(0, 2, 1):
        N, across = (stress_transformation(g[None])[0, 0] for g in (f, f[::-1]))
        state = follow(law, state, 1.001 * YIELD * (N - CONCRETE.nu * across), np.zeros(3), steps=5)
    assert len(state.planes.point) == planes
    normals = np.degrees(np.arctan2(*state.planes.rotation[:, 0, ::-1].T))
    assert (abs((normals - angles[:planes] + 90) % 180 - 90) < 0.1).all()
    wide = 0.5 * Zm / 20.0  # all opened and sheared
    for target in ([wide, 0, 0], [wide, wide, 0], [wide, wide, 0.7 * wide], [0.3 * wide, 0.2 * wide, -0.5 * wide]):
        state = follow(law, state, target)
        check(law, state)


def test_a_new_plane_is_inert() -> None:
    law = band(turns=plane_turns(0.0, 0.0, 0.0))
    start, _ = law.update(YIELD * np.array([[0.5, -2, 0.3], [0.9, 0, 0], [0, 0, 0]]), law.initial())
    for planes in (3, 6):  # on intact points, and beside a plane that is open
        pull = [3 * YIELD, 0, YIELD] if planes == 3 else [0, 3 * YIELD, 0]
        grown = law.nucleate(start, law.update(start.deformation + pull, start)[0])
        assert grown is not None and len(grown.planes.point) == planes
        again, tangent = law.update(start.deformation, grown, frozen=True)
        np.testing.assert_allclose(again.stress, start.stress, atol=1e-11 * FT)
        np.testing.assert_array_equal(again.planes.history, grown.planes.history)
        before = law.update(start.deformation, start, frozen=True)[1]
        np.testing.assert_allclose(tangent, before, rtol=0, atol=1e-8 * law.D.max())
        start = follow(law, law.initial(), [0.1 * Zm / 20, 0, 0])


@pytest.mark.parametrize("plane", ["stress", "strain"])
def test_frozen_gives_the_unloading_tangent(plane: str) -> None:
    """One-sided differences at a state on the damage surface: each direction has its tangent, and not the other one."""
    law, h, seen = band(20.0, plane), 1e-7, set()
    start = follow(law, law.initial(), np.array([0.1, 0, 0.01]) * Zm / 20)
    assert law.is_on_surface(start)
    for direction in np.random.default_rng(2).normal(size=(12, 3)):
        ends = [law.update(start.deformation + size * direction, start)[0] for size in (h, h / 2)]
        loading = bool(ends[0].planes.history[0] > start.planes.history[0])
        coarse, fine = ((end.stress - start.stress)[0] / size for end, size in zip(ends, (h, h / 2), strict=True))
        right, wrong = (law.update(start.deformation, start, frozen=f)[1][0] @ direction for f in (not loading, loading))
        np.testing.assert_allclose(right, 2 * fine - coarse, atol=1e-5 * law.D.max())
        assert abs(wrong - fine).max() > 1e-3 * law.D.max()
        seen.add(loading)
    assert seen == {True, False}


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


def test_a_failure_names_the_point() -> None:
    law = band(turns=TURNS["stress"])
    start = follow(law, law.initial(), [0.1 * Zm / 20, 0, 0])
    strain = start.deformation.copy()
    strain[3, 0] = np.nan
    with np.errstate(invalid="ignore"), pytest.raises(PointFailure, match=r"1 point\(s\) have no solution") as caught:
        law.update(strain, start)
    assert caught.value.point == 3


@pytest.mark.parametrize(("planes", "rank"), [(1, 3), (2, 5), (3, 6)])
def test_open_planes_share_their_shear(planes: int, rank: int) -> None:
    """Opened one after the other to 10 Zm: M has the rank of N, and a step of minimum norm does not enter its null part."""
    turn = TURNS["space"][1:2]
    law, wide = band(space="space", turns=turn), 10 * Zm / 20.0
    legs = np.zeros((2 * planes + 1, 6))
    for i in range(planes):  # each to a little first, so that they form at right angles
        legs[i:, i] = 0.1 - 0.02 * i
    for i in range(planes):
        legs[planes + i :, : i + 1] = np.where(legs[planes + i :, : i + 1], 1.0, 0.0)
    legs[-1, 3:] = [0.1, 0.15 * (planes > 1), -0.2]  # no shear that cracks what is whole
    state = law.initial()
    for leg in legs * wide:
        before, state = state, follow(law, state, turned(leg, turn))
        check(law, state)
    assert len(state.planes.point) == planes
    # M = T + N De N^T (I - C T) of the local iteration
    opened, N = state.planes, stress_transformation(state.planes.rotation).reshape(3 * planes, 6)
    slopes = law.law.with_width(opened.length).update(opened.jump, opened.history)[1] * opened.length[:, None, None]
    T, C = block_diag(*slopes), np.diag(np.tile(law.compliance, planes))
    values = np.linalg.svd(T + N @ law.D @ N.T @ (np.eye(3 * planes) - C @ T))[1]
    assert values[rank - 1] > 0.01 * values[0] and (values[rank:] < 1e-12 * values[0]).all()
    null = np.linalg.svd(N.T)[2]
    step = (state.planes.strain - before.planes.strain).ravel()
    assert abs(null[rank:] @ step).max(initial=0.0) < 1e-9 * np.linalg.norm(step)
