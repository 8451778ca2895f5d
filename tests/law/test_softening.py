"""Softening curves: one suite over the registry, kinks, points and an object; then the law with each of them."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from cohesive import Concrete, CrackPlane
from cohesive.cracks.band_points import BandState, CrackBand
from cohesive.cracks.interface_points import InterfaceLaw, InterfaceState
from cohesive.elements.bulk import elasticity
from cohesive.law.softening import SOFTENING
from cohesive.law.softening_choice import fixes_strength

Array = NDArray[np.float64]

E, NU, FT, GF = 35e3, 0.2, 3.2, 0.12
WIDTHS = [0.05, 2.0, 60.0]


class Cosine:
    """A curve of a user: ft (1 + cos(pi w / end)) / 2, which begins and ends flat."""

    def __init__(self, ft: float = FT, end: float = 0.3) -> None:
        self.ft, self.end = ft, end

    def stress(self, w: Array) -> Array:
        return np.asarray(0.5 * self.ft * (1.0 + np.cos(np.pi * np.minimum(w / self.end, 1.0))))

    def slope(self, w: Array) -> Array:
        inside = -0.5 * self.ft * np.pi / self.end * np.sin(np.pi * np.minimum(w / self.end, 1.0))
        return np.where(w < self.end, inside, 0.0)

    def work(self, w: Array) -> Array:
        x = np.minimum(w / self.end, 1.0)
        return np.asarray(0.5 * self.ft * self.end * (x + np.sin(np.pi * x) / np.pi))


FIBRES = [[0.0, 3.0], [0.05, 0.8], [1.0, 1.6], [4.0, 0.0]]

CASES: dict[str, Any] = {
    **{name: name for name in SOFTENING},
    "kink": {"kink": [0.5, 0.2]},
    "points": {"points": [[0.0, 3.2], [0.02, 1.7], [0.06, 0.6], [0.3, 0.0]]},
    "fibres": {"points": FIBRES},
    "object": Cosine(),
}


def concrete(softening: Any, **changes: Any) -> Concrete:
    """A material with this curve; ft and Gf are given if the curve does not fix them."""
    own = {} if fixes_strength(softening) else {"ft": FT, "Gf": GF}
    return Concrete(**{"E": E, "nu": NU, **own, "m_g": 0.3, "softening": softening, **changes})


def openings(m: Concrete, n: int = 4001) -> Array:
    """From 0 to a little beyond the end, the kinks included."""
    kinks = np.asarray(getattr(m.curve, "kinks", ()))
    return np.unique(np.concatenate([1.1 * m.fully_softened * np.linspace(0.0, 1.0, n) ** 2, kinks, [m.fully_softened]]))


def normal(u: Array) -> Array:
    return np.stack([u, np.zeros_like(u)], axis=1)


case = pytest.mark.parametrize("softening", CASES.values(), ids=CASES)
width_of = pytest.mark.parametrize("width", WIDTHS)


# -- the curve --------------------------------------------------------------------------------------


@case
def test_area_end_and_strength(softening: Any) -> None:
    m = concrete(softening)
    curve, last = m.curve, np.array([m.curve.end])
    assert curve.stress(np.zeros(1))[0] == pytest.approx(m.ft, rel=1e-12)
    assert curve.work(last)[0] == pytest.approx(m.Gf, rel=1e-10)
    if math.isfinite(curve.end):
        beyond = curve.end * np.array([1.0, 1.0 + 1e-12, 2.0, 1e6])
        np.testing.assert_array_equal(curve.stress(beyond[1:]), 0.0)
        np.testing.assert_array_equal(curve.slope(beyond[1:]), 0.0)
        np.testing.assert_allclose(curve.work(beyond), m.Gf, rtol=1e-12)


@case
def test_slope_and_work_by_differences(softening: Any) -> None:
    m = concrete(softening)
    curve, unit = m.curve, m.Gf / m.ft
    kinks = np.append(np.asarray(getattr(curve, "kinks", ())), curve.end)
    w = np.random.default_rng(1).uniform(0.01 * unit, 1.2 * min(m.fully_softened, 8 * unit), 500)
    h = 1e-4 * unit
    w = w[abs(w[:, None] - kinks).min(axis=1) > 2 * h]
    for value, slope, scale in ((curve.stress, curve.slope, m.ft / unit), (curve.work, curve.stress, m.ft)):
        coarse, fine = ((value(w + s) - value(w - s)) / (2 * s) for s in (h, h / 2))
        np.testing.assert_allclose((4 * fine - coarse) / 3, slope(w), atol=1e-7 * scale)


@case
def test_continuous_and_secant_falls(softening: Any) -> None:
    m = concrete(softening)
    w = openings(m)
    stress = m.curve.stress(w)
    assert (stress >= 0).all()
    assert abs(np.diff(stress)).max() <= 1.01 * (np.diff(w) * abs(m.curve.slope(w)).max()).max()
    for at in getattr(m.curve, "kinks", ()):
        left, right = m.curve.stress(np.array([at * (1 - 1e-12), at]))
        assert left == pytest.approx(right, rel=1e-9)
    for width in WIDTHS:
        intact = CrackPlane(m, width).intact(w + width * m.ft / m.E)
        assert intact[0] == pytest.approx(1.0, rel=1e-12)
        # once the stress is but rounding the secant may stand still
        assert (np.diff(intact) < 0)[stress[:-1] > 1e-12 * m.ft].all()


@case
def test_work_is_the_integral(softening: Any) -> None:
    m = concrete(softening)
    w = openings(m, 20_001)
    stress = m.curve.stress(w)
    area = np.append(0.0, np.cumsum(0.5 * (stress[1:] + stress[:-1]) * np.diff(w)))
    np.testing.assert_allclose(m.curve.work(w), area, atol=1e-6 * m.Gf)


def test_exponential_is_equation_5() -> None:
    m = Concrete.preset("reinhardt")
    for width in WIDTHS:
        law = CrackPlane(m, width)
        Z = law.Zt + np.linspace(0.0, 3.0, 300) * m.Zm
        printed = 1.0 - law.Zt / Z * np.exp(-m.c1 * (Z - law.Zt) / m.Zm)
        np.testing.assert_allclose(law.damage(Z), printed, rtol=1e-14, atol=1e-15)
        np.testing.assert_allclose(law.intact(Z), law.Zt / Z * np.exp(-m.ft * (Z - law.Zt) / m.Gf), rtol=1e-13)


def test_ends_and_kinks_of_the_named_curves() -> None:
    unit = GF / FT
    ends = {"linear": 2.0, "hordijk": 5.1360553, "petersson": 3.6, "wittmann": 5.0, "fib-2010": 5.0}
    for name, end in ends.items():
        assert concrete(name).curve.end == pytest.approx(end * unit, rel=1e-7)
    for name, (x, y) in {"petersson": (0.8, 1 / 3), "wittmann": (0.75, 0.25), "fib-2010": (1.0, 0.2)}.items():
        m = concrete(name)
        assert m.curve.kinks == pytest.approx([x * unit])  # type: ignore[attr-defined]
        assert m.curve.stress(np.array([x * unit]))[0] == pytest.approx(y * FT)
    # Cornelissen, Hordijk, Reinhardt as printed
    m, x = concrete("hordijk"), np.linspace(0.0, 1.0, 50)
    printed = (1 + (3 * x) ** 3) * np.exp(-6.93 * x) - x * 28 * np.exp(-6.93)
    np.testing.assert_allclose(m.curve.stress(x * m.curve.end), FT * printed, atol=1e-14)


def test_fully_softened_is_todays_number_for_the_exponential_curve() -> None:
    m = Concrete.preset("reinhardt")
    assert m.fully_softened == pytest.approx(3.5 * m.Zm, rel=1e-7)
    assert concrete("linear").fully_softened == concrete("linear").curve.end


# -- the law with it --------------------------------------------------------------------------------


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
    for last in (1.01 * m.fully_softened, 0.3 * m.Gf / m.ft):
        end = law.Zt + last
        stress, work = (float(f(np.array([last]))[0]) for f in (m.curve.stress, m.curve.work))
        expected = 0.5 * m.ft * law.Zt + work - 0.5 * end * stress
        for steps in (1, 7):
            u = normal(np.linspace(0.0, end, steps + 1))
            Z = law.history(u, np.zeros(steps + 1))
            total = sum(law.dissipation(u[[i]], Z[[i]], u[[j]], Z[[j]])[0][0] for i, j in pairwise(range(steps + 1)))
            assert total == pytest.approx(expected, rel=1e-7 if math.isinf(m.curve.end) else 1e-10)


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


@pytest.mark.parametrize("softening", [entry for entry in CASES.values() if math.isfinite(concrete(entry).curve.end)])
def test_the_end_is_one_number(softening: Any) -> None:
    """At whatever width, around Zt + end: where the curve has ended 1 - omega and the tangent are 0, to the last digit."""
    m, random = concrete(softening), np.random.default_rng(8)
    law = CrackPlane(m, random.uniform(1e-3, 60.0, 4000))
    at = law.Zt + m.curve.end
    for Z in (np.nextafter(at, 0.0), at, np.nextafter(at, np.inf), 1.001 * at):
        ended = law.has_ended(Z)
        assert not law.intact(Z)[ended].any()
        _, tangent, reached = law.update(normal(Z), np.zeros(len(Z)))
        assert not tangent[law.has_ended(reached)].any()
    assert ended.all() and not law.has_ended(0.999 * at).any()


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
    Zt = points.law.Zt
    for opening, gone in ((0.99, False), (1.1, True)):
        u = normal(np.array([Zt + opening * m.fully_softened]))
        t, Z = points.law.traction(u, np.zeros(1))
        state = InterfaceState(u, t, Z)
        assert points.is_separated(state) == gone
        ended = gone and math.isfinite(m.curve.end)
        assert points.is_on_surface(state) == (not ended)
        assert points.is_damaging(1.1 * u, state) == (not ended)
    band = square(m)
    state = band.initial()
    for part in np.concatenate([[0.01], np.linspace(0.05, 1.2, 40)]):
        state = advance(band, np.array([[part * m.fully_softened / 5.0, 0.0, 0.0]]), state)
    assert band.is_separated(state)
    assert band.is_on_surface(state) == math.isinf(m.curve.end)


def random_points(random: np.random.Generator) -> dict[str, list[list[float]]]:
    """Two to seven branches, some of them rising, with a secant that falls at every width up to 5 mm."""
    w = np.append(0.0, np.cumsum(random.uniform(0.01, 0.1, random.integers(2, 8))))
    stress, Zt = [random.uniform(2.0, 4.0)], 5.0 * 4.0 / E
    for a, b in pairwise(w[:-1]):
        stress.append(stress[-1] * random.uniform(0.2, 1.0 if len(stress) == 1 else 1.0 + 0.8 * (b - a) / (a + Zt)))
    return {"points": [[float(x), float(y)] for x, y in zip(w, [*stress, 0.0], strict=True)]}


@pytest.mark.parametrize("curves", [25, pytest.param(200, marks=pytest.mark.slow)])
def test_random_points_through_cyclic_tension_in_a_band(curves: int) -> None:
    """Random curves, opened and closed at a point of the band: the local iteration stops at none of their kinks."""
    random, rising = np.random.default_rng(8), 0
    for _ in range(curves):
        softening = random_points(random)
        m = concrete(softening)
        rising += m.steepest_rise is not None
        band, end = square(m), m.curve.end / 5.0
        state, at = band.initial(), 0.0
        for target in (0.1, 0.02, 0.5, 0.05, 1.1, 0.3):
            for part in np.linspace(at, target, 6)[1:]:
                state = advance(band, np.array([[part * end, 0.0, 0.0]]), state)
                t, _ = CrackPlane(m, 5.0).traction(state.planes.jump, state.planes.history)
                np.testing.assert_allclose(state.planes.traction, t, atol=1e-9 * m.ft)
            at = target
    assert rising > curves / 4


@case
def test_both_models_agree_at_a_point(softening: Any) -> None:
    """A square that opens, without Poisson's ratio: the band is the plane of width l_ch."""
    m = concrete(softening, nu=0.0)
    band, law, side = square(m), CrackPlane(m, 5.0), 5.0
    state, Z = band.initial(), np.zeros(1)
    for u in np.concatenate([[0.5 * law.Zt], law.Zt + m.fully_softened * np.linspace(0.01, 1.1, 60)]):
        (t,), Z = law.traction(normal(np.array([u])), Z)
        state = advance(band, np.array([[u / side, 0.0, 0.0]]), state)
        assert state.stress[0, 0] == pytest.approx(t[0], abs=1e-8 * m.ft)
