"""The law with each softening curve, and its points with cracks."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from cohesive import Concrete, CrackPlane
from cohesive.arrays import Array
from cohesive.cracks.band_points import BandState, CrackBand
from cohesive.cracks.interface_points import InterfaceLaw, InterfaceState
from cohesive.elements.bulk import elasticity
from tests.law.curves import E, case, concrete, normal, openings, width_of


@case
@width_of
@pytest.mark.parametrize("contact", ["printed", "potential"])
def test_mode_one_carries_the_curve_without_contact(softening: Any, width: float, contact: str) -> None:
    m = concrete(softening, contact=contact)
    law = CrackPlane(m, width)
    w = openings(m)
    u = np.concatenate([np.linspace(0.0, law.Zt, 50)[:-1], law.Zt + w])
    t, tangent, Z = law.update(normal(u), np.zeros(len(u)))
    expected = np.concatenate([m.E / width * u[:49], m.curve.stress(Z[49:] - law.Zt)])
    np.testing.assert_allclose(t[:, 0], expected, rtol=1e-9, atol=1e-13 * m.ft)
    assert abs(law.contact_traction(normal(u), Z)).max() <= 1e-12 * m.ft  # phi = ulm but for rounding
    beyond = law.has_ended(Z)
    np.testing.assert_array_equal(t[beyond], 0.0)
    np.testing.assert_array_equal(tangent[beyond], 0.0)
    np.testing.assert_array_equal(law.intact(Z)[beyond], 0.0)
    assert beyond.any() == math.isfinite(m.curve.end)


@case
@width_of
def test_dissipation_of_proportional_paths(softening: Any, width: float) -> None:
    """Opening to beyond the end spends Gf + ft^2 w/2E, in any number of steps; half way W - Z sigma / 2."""
    m = concrete(softening)
    law = CrackPlane(m, width)
    for last in (1.01 * m.spent, 0.3 * m.Gf / m.ft):
        end = law.Zt + last
        stress, work = (float(f(np.array([last]))[0]) for f in (m.curve.stress, m.curve.work))
        expected = 0.5 * m.ft * law.Zt + work - 0.5 * end * stress
        for steps in (1, 7):
            u = normal(np.linspace(0.0, end, steps + 1))
            Z = law.history(u, np.zeros(steps + 1))
            total = sum(law.dissipation(u[[i]], Z[[i]], u[[j]], Z[[j]])[0][0] for i, j in pairwise(range(steps + 1)))
            assert total == pytest.approx(expected, rel=1e-7 if math.isinf(m.curve.end) else 1e-10)
    assert 0.5 * m.ft * law.Zt + m.Gf == pytest.approx(m.Gf + m.ft**2 * width / (2 * m.E))


@case
@width_of
@pytest.mark.parametrize("components", [2, 3])
def test_tangent_by_differences(softening: Any, width: float, components: int) -> None:
    """At random jumps and histories, and from either side of each kink and of the end."""
    m = concrete(softening)
    law, random = CrackPlane(m, width), np.random.default_rng(3)
    n, unit = 300, m.Gf / m.ft
    jump = random.normal(size=(n, components)) * unit * 10 ** random.uniform(-1.5, 0.7, (n, 1))
    Z = unit * 10 ** random.uniform(-1.5, 0.7, n)
    corners = [k for k in (*getattr(m.curve, "kinks", ()), m.curve.end) if math.isfinite(k)]
    for k in corners:
        for side in (-1e-4, 1e-4):
            at = np.zeros((1, components))
            at[0, :2] = [law.Zt + k * (1.0 + side), 0.0]
            jump, Z = np.concatenate([jump, at]), np.append(Z, 0.0)
    _, tangent, Z_new = law.update(jump, Z)
    h = 1e-6 * np.minimum(np.maximum(Z_new, abs(jump).max(axis=1)), unit)[:, None]
    columns = []
    for e in np.eye(components):
        coarse, fine = ((law.traction(jump + s * e, Z)[0] - law.traction(jump - s * e, Z)[0]) / (2 * s) for s in (h, h / 2))
        columns.append((4 * fine - coarse) / 3)
    error = abs(tangent - np.stack(columns, axis=2)).max(axis=(1, 2)) / np.maximum(
        abs(tangent).max(axis=(1, 2)), 1e-3 * m.ft / unit
    )
    assert np.quantile(error[:n], 0.99) < 1e-6  # at most one point in a hundred lies at a corner of the contact
    assert error[n:].max(initial=0.0) < 1e-6


def test_at_a_kink_the_loading_tangent_is_that_of_the_next_branch() -> None:
    m = concrete("wittmann")
    law, (kink,) = CrackPlane(m, 2.0), concrete("wittmann").curve.kinks  # type: ignore[attr-defined]
    u = normal(np.array([law.Zt + np.nextafter(kink, 1.0)]))
    assert law.update(u, np.zeros(1))[1][0, 0, 0] == pytest.approx(m.curve.slope(np.array([kink * 1.1]))[0])


# -- points with cracks -----------------------------------------------------------------------------


def square(m: Concrete, side: float = 5.0, count: int = 1) -> CrackBand:
    corners = side * np.array([[-0.5, 0.5], [-0.5, -0.5], [0.5, -0.5], [0.5, 0.5]])
    return CrackBand(CrackPlane(m, side), elasticity(m.E, m.nu, "stress"), np.broadcast_to(corners, (count, 4, 2)))


def advance(law: CrackBand, strain: Array, start: BandState) -> BandState:
    state, _ = law.update(strain, start)
    while (grown := law.nucleate(start, state)) is not None:
        start = grown
        state, _ = law.update(strain, start)
    return state


@case
def test_separation_and_exhaustion(softening: Any) -> None:
    m = concrete(softening)
    points = InterfaceLaw(CrackPlane(m, 0.5), 1)
    Zt = points.plane.Zt
    for opening, gone in ((0.9, False), (1.1, True)):
        u = normal(np.array([Zt + opening * m.spent]))
        t, Z = points.plane.traction(u, np.zeros(1))
        state = InterfaceState(u, t, Z)
        assert points.is_separated(state) == gone
        ended = gone and math.isfinite(m.curve.end)
        assert points.is_on_surface(state) == (not ended)
        assert points.is_damaging(1.1 * u, state) == (not ended)
    band = square(m)
    state = band.initial()
    for part in np.concatenate([[0.01], np.linspace(0.05, 1.2, 40)]):
        state = advance(band, np.array([[part * m.spent / 5.0, 0.0, 0.0]]), state)
    assert band.is_separated(state)
    assert band.is_on_surface(state) == math.isinf(m.curve.end)


def random_points(random: np.random.Generator) -> dict[str, list[list[float]]]:
    """Two to seven branches, some of them rising, with a secant that falls at every width up to 5 mm."""
    w = np.append(0.0, np.cumsum(random.uniform(0.01, 0.1, random.integers(2, 8))))
    stress, Zt = [random.uniform(2.0, 4.0)], 5.0 * 4.0 / E
    for a, b in pairwise(w[:-1]):
        stress.append(stress[-1] * random.uniform(0.2, 1.0 if len(stress) == 1 else 1.0 + 0.8 * (b - a) / (a + Zt)))
    return {"points": [[float(x), float(y)] for x, y in zip(w, [*stress, 0.0], strict=True)]}


def test_random_points_through_cyclic_tension_in_a_band() -> None:
    """200 curves, opened and closed at a point of the band: the local iteration stops at none of their kinks."""
    random, rising = np.random.default_rng(8), 0
    for _ in range(200):
        softening = random_points(random)
        m = concrete(softening)
        rising += m.steepest_rise is not None
        band, end = square(m), m.curve.end / 5.0
        state, at = band.initial(), 0.0
        for target in (0.1, 0.02, 0.5, 0.05, 1.1, 0.3):
            for part in np.linspace(at, target, 6)[1:]:
                state = advance(band, np.array([[part * end, 0.0, 0.0]]), state)
                t, _ = CrackPlane(m, 5.0).traction(state.planes.jump, state.planes.Z)
                np.testing.assert_allclose(state.planes.traction, t, atol=1e-9 * m.ft)
            at = target
    assert rising > 50


@case
def test_both_models_agree_at_a_point(softening: Any) -> None:
    """A square that opens, without Poisson's ratio: the band is the plane of width l_ch."""
    m = concrete(softening, nu=0.0)
    band, law, side = square(m), CrackPlane(m, 5.0), 5.0
    state, Z = band.initial(), np.zeros(1)
    for u in np.concatenate([[0.5 * law.Zt], law.Zt + m.spent * np.linspace(0.01, 1.1, 60)]):
        (t,), Z = law.traction(normal(np.array([u])), Z)
        state = advance(band, np.array([[u / side, 0.0, 0.0]]), state)
        assert state.stress[0, 0] == pytest.approx(t[0], abs=1e-8 * m.ft)


def test_a_rise_limits_the_width() -> None:
    """slope (Zt + w) < stress at .05 mm: Zt up to .6 micrometres, which is a width of 7 mm."""
    steep = {"points": [[0, 3], [0.05, 0.8], [0.1, 1.59], [4, 0]]}
    m = concrete(steep)
    rise = m.steepest_rise
    assert rise is not None and rise.w == 0.05 and rise.largest_Zt == pytest.approx(0.8 / 15.8 - 0.05)
    widest = rise.largest_Zt * E / 3.0
    CrackPlane(m, 0.99 * widest)
    for width in (1.01 * widest, np.array([0.1, 1.01 * widest])):
        with pytest.raises(ValueError, match=r"softening: at w = 0.05 mm, 0.8 MPa, .* expected a width below 7.38 mm"):
            CrackPlane(m, width)
    with pytest.raises(ValueError, match="expected a flatter rise"):
        CrackPlane(concrete({"points": [[0, 3], [0.05, 0.8], [0.1, 1.7], [4, 0]]}), 0.1)
