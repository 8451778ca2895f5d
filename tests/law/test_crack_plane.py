"""The law: reference values, consistent tangent on every branch, continuity, purity, energies."""

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from cohesive import Concrete, CrackPlane

Array = NDArray[np.float64]

TABLE_1 = CrackPlane(Concrete.preset("crack-plane"))
NARROW = CrackPlane(Concrete.preset("reinhardt"), 2.0)

# 40-digit evaluation of eqs (1)-(21) and (25), rounded to 12 digits: jump, old Z, traction, new Z
REFERENCE = [
    (TABLE_1, (0.002, 0, 0), 0.0, (1.42857142857, 0, 0), 0.0042),
    (TABLE_1, (0.01, 0, 0), 0.0, (2.59506687933, 0, 0), 0.01),
    (TABLE_1, (0.004, 0, 0), 0.05, (-0.343882479778, 0, 0), 0.05),
    (TABLE_1, (-0.003, 0, 0), 0.05, (-3.46595915376, 0, 0), 0.05),
    (TABLE_1, (0.06, 0.2, 0.1), 0.06, (-3.50980607987, 3.27268758018, 1.63634379009), 0.118899164327),
    (TABLE_1, (0.3, 0.05, -0.02), 0.4, (1.13458913317e-4, 7.87909120e-6, -3.15163648e-6), 0.4),
    (NARROW, (0.002, 0, 0), 0.0, (3.04863413873, 0, 0), 0.002),
    (NARROW, (0.004, 0, 0), 0.05, (-0.432742008196, 0, 0), 0.05),
    (NARROW, (0.06, 0.05, 0), 0.06, (0.392153766182, 0.306595903772, 0), 0.0666086233838),
    (NARROW, (-0.01, 0.03, 0), 0.02, (-278.145110588, 111.25257698, 0), 0.02),
]


@pytest.mark.parametrize("case", REFERENCE, ids=lambda case: f"w={case[0].width:g} u={case[1]}")
def test_reference_values(case: tuple[CrackPlane, tuple[float, ...], float, tuple[float, ...], float]) -> None:
    law, jump, Z, traction, Z_new = case
    got, _, got_Z = law.update(np.array([jump]), np.array([Z]))
    np.testing.assert_allclose(got[0], traction, rtol=1e-9)
    np.testing.assert_allclose(got_Z, Z_new, rtol=1e-9)
    np.testing.assert_allclose(law.traction(np.array([jump]), np.array([Z]))[0], got, rtol=1e-14)
    if jump[2] == 0:  # two components are the plane s = |u2| of three
        plane, _, _ = law.update(np.array([jump[:2]]), np.array([Z]))
        np.testing.assert_allclose(plane[0], got[0, :2], rtol=1e-13)


def differences(law: CrackPlane, jump: Array, Z: Array, h: float) -> Array:
    """Tangent by central differences with step h, Richardson-extrapolated: error O(h^4)."""

    def central(step: float) -> Array:
        columns = []
        for unit in np.eye(jump.shape[1]):
            columns.append((law.traction(jump + step * unit, Z)[0] - law.traction(jump - step * unit, Z)[0]) / (2 * step))
        return np.stack(columns, axis=2)

    return (4 * central(h / 2) - central(h)) / 3


# jump and Z in units of Zm (0.1875 mm); each is well inside its branch
BRANCHES = {
    "undamaged": ([2e-4, 1e-4], 0.0, {}),
    "softening": ([0.1, 0.02], 0.0, {}),
    "softening, onset cap off": ([0.1, 0.02], 0.0, {"onset_cap": False}),
    "softening under the cap, in contact": ([0.01, 0.05], 0.0, {}),
    "the same without the cap": ([0.01, 0.05], 0.0, {"onset_cap": False}),
    "Z beyond Zm": ([1.6, 0.3], 0.0, {}),
    "Z beyond Zm, in contact": ([0.3, 4.0], 0.0, {}),
    "unloading": ([0.3, 0.05], 0.6, {}),
    "nose": ([0.03, 0.02], 0.5, {}),
    "nose, loading": ([0.05, 0.35], 0.02, {}),
    "cone": ([0.3, 0.5], 0.9, {}),
    "cone, loading": ([0.2, 1.5], 0.1, {}),
    "out of contact by distance": ([0.8, 0.01], 1.2, {}),
    "closed": ([-0.02, 0.01], 0.4, {}),
    "closed and sheared, loading": ([-0.001, 0.6], 0.01, {}),
    "pure shear": ([0.0, 0.4], 0.1, {"u_phi0": 0.05}),  # off the corner of H
    "small nose": ([5e-4, 3e-3], 8e-3, {}),
}


@pytest.mark.parametrize("width", [0.1, 2.0, 60.0])
@pytest.mark.parametrize("components", [2, 3])
@pytest.mark.parametrize("branch", BRANCHES)
def test_tangent_is_consistent(branch: str, components: int, width: float) -> None:
    scaled, Z, changes = BRANCHES[branch]
    law = CrackPlane(Concrete.preset("reinhardt", **changes), width)
    Zm = law.concrete.Zm
    jump = np.array([scaled]) * Zm
    if branch == "undamaged":
        jump *= law.Zt / (3e-4 * Zm)  # inside the elastic domain of this width
    if components == 3:
        turn = np.radians(37.0)
        jump = np.array([[jump[0, 0], jump[0, 1] * np.cos(turn), jump[0, 1] * np.sin(turn)]])
    old = np.array([Z * Zm])
    _, tangent, Z_new = law.update(jump, old)
    # the steps stay small against the shortest length of the law, the nose radius or Zt
    length = min(Zm, 10 * max(float(Z_new[0]), law.Zt), float(abs(jump).max()))
    expected = differences(law, jump, old, 2e-4 * length)
    assert np.abs(tangent - expected).max() <= 1e-7 * np.abs(tangent).max()


def test_tangent_at_random_points() -> None:
    random = np.random.default_rng(3)
    for width in (0.1, 2.0, 60.0):
        law = CrackPlane(Concrete.preset("jacobsen"), width)
        Zm = law.concrete.Zm
        jump = random.normal(size=(2000, 3)) * Zm * 10 ** random.uniform(-2, 0.5, (2000, 1))
        Z = Zm * 10 ** random.uniform(-2, 0.6, 2000)
        _, tangent, _ = law.update(jump, Z)
        error = np.abs(tangent - differences(law, jump, Z, 1e-7)).max(axis=(1, 2)) / np.abs(tangent).max(axis=(1, 2))
        # differences across a corner of the law are no tangent: at most one point in two hundred lies within 1e-7 mm of one
        assert np.quantile(error, 0.995) < 1e-6


def test_two_tangents_at_the_damage_surface() -> None:
    at = np.array([[0.1, 0.0]]), np.array([0.1])
    assert NARROW.update(*at)[1][0, 0, 0] == pytest.approx(-5.96, abs=0.01)
    assert NARROW.update(*at, frozen=True)[1][0, 0, 0] == pytest.approx(2.23, abs=0.01)


BOUNDARIES = {  # start and end of a straight path, Z, all in units of Zm
    "damage surface": ([0.1, 0.1], [0.5, 0.3], 0.3),
    "nose to cone": ([0.02, 0.25], [0.4, 0.3], 0.6),
    "end of contact": ([0.1, 0.02], [1.2, 0.03], 0.9),
    "closure, u1 = u_phi0": ([-0.02, 0.05], [0.02, 0.06], 0.5),
    "Z = Zm": ([0.9, 0.5], [1.1, 0.6], 0.0),
    "onset cap": ([0.03, 0.1], [0.12, 0.3], 0.0),
    "through the origin": ([-0.1, -0.05], [0.1, 0.05], 0.2),
}


@pytest.mark.parametrize("width", [0.1, 2.0, 60.0])
@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_traction_is_continuous(boundary: str, width: float) -> None:
    law = CrackPlane(Concrete.preset("reinhardt"), width)
    start, end, Z = (np.array(value) * law.concrete.Zm for value in BOUNDARIES[boundary])
    jumps = []
    for n in (20_001, 40_001):
        path = start + np.linspace(0, 1, n)[:, None] * (end - start)
        traction = law.traction(path, np.full(n, Z))[0]
        jumps.append(np.abs(np.diff(traction, axis=0)).max())
    assert jumps[1] < 0.7 * jumps[0]  # the largest change halves with the step; a jump would stay


@pytest.mark.parametrize("width", [0.1, 2.0, 60.0])
def test_no_contact_in_monotonic_opening(width: float) -> None:
    law = CrackPlane(Concrete.preset("jacobsen"), width)
    m = law.concrete
    u = np.geomspace(1e-4 * law.Zt, 5 * m.Zm, 3000)
    traction = law.traction(np.stack([u, 0 * u], axis=1), np.zeros(3000))[0][:, 0]
    exponential = np.where(u < law.Zt, m.E * u / law.width, m.ft * np.exp(-m.ft * (u - law.Zt) / m.Gf))
    np.testing.assert_allclose(traction, exponential, rtol=1e-10)


def test_without_the_cap_contact_eats_the_strength_of_a_narrow_band() -> None:
    law = CrackPlane(Concrete.preset("jacobsen", onset_cap=False), 2.0)
    u = np.linspace(0, 0.2, 400) * law.concrete.Zm
    assert law.traction(np.stack([u, 0 * u], axis=1), np.zeros(400))[0].min() < 0


def test_damage_starts_in_pure_shear_at_its_strength() -> None:
    m, law = NARROW.concrete, NARROW
    s = m.r_sigma * m.ft * law.width / m.G
    for factor, damaged in ((1 - 1e-9, False), (1 + 1e-9, True)):
        _, Z = law.traction(np.array([[0.0, factor * s]]), np.zeros(1))
        assert (Z[0] > law.Zt) == damaged


@pytest.mark.parametrize("width", [0.1, 1.0, 60.0])
def test_shear_scaling_tends_to_the_inelastic_stiffness(width: float) -> None:
    # eq. (25) with (C4): w/(G H_w) = w/G + (h/G)(1-H)/H, elastic and inelastic compliance in series
    law, printed = CrackPlane(Concrete.preset("reinhardt"), width), CrackPlane(Concrete.preset("reinhardt"))  # w = h: H itself
    m, Z = law.concrete, np.full(3, 0.2)
    u1 = np.array([0.01, 0.05, 0.1]) * m.Zm
    H = np.exp(-u1[:, None] / (np.array(m.c) * m.Zm)) @ m.p  # eq. (13)
    jump = np.column_stack([u1, np.full(3, m.Zm)])  # in contact
    contact, unscaled = (each.width * each.contact_traction(jump, Z) / each.damage(Z)[:, None] for each in (law, printed))
    assert (abs(unscaled) > 1e-3).all()
    scaled = (contact / unscaled)[:, 1] * H
    np.testing.assert_allclose(contact[:, 0] / unscaled[:, 0] * H, scaled, rtol=1e-12)
    np.testing.assert_allclose(width / scaled, width + law.concrete.h * (1 - H) / H, rtol=1e-12)


def test_signed_distance() -> None:
    random = np.random.default_rng(5)
    jump = random.normal(size=(1000, 3)) * 0.2
    Z = random.uniform(0.01, 0.3, 1000)
    phi, n = NARROW.contact_distance(jump, Z)
    np.testing.assert_allclose(np.linalg.norm(n, axis=1), 1.0, rtol=1e-12)
    # from outside, a walk of phi along -n ends on the surface (eq. 7)
    near = phi > 0
    foot = jump[near] - 0.999 * phi[near, None] * n[near]
    np.testing.assert_allclose(NARROW.contact_distance(foot, Z[near])[0], 0.001 * phi[near], atol=1e-9)


@pytest.mark.parametrize("u_phi0", [0.0, 0.01, 0.03])
def test_nose_and_cone_are_tangent_wherever_the_surface_lies(u_phi0: float) -> None:
    law = CrackPlane(replace(NARROW.concrete, u_phi0=u_phi0), 2.0)
    m, Z = law.concrete, np.array([0.1])
    R = m.n_g * m.Zm + law.contact_reach(Z)[0]
    s = np.linspace(0.01, 0.2, 20)
    on_edge = np.stack([u_phi0 + R - m.m_g * s, s], axis=1)  # where u1 - centre + m_g s = 0
    both = [law.contact_distance(on_edge + np.array([side, 0.0]), np.repeat(Z, 20)) for side in (-1e-9, 1e-9)]
    np.testing.assert_allclose(both[0][0], both[1][0], atol=1e-8)
    np.testing.assert_allclose(both[0][1], both[1][1], atol=1e-6)
    assert law.contact_distance(np.array([[u_phi0, 0.0]]), Z)[0][0] == pytest.approx(0.0, abs=1e-15)


def test_update_is_pure_and_damage_never_falls() -> None:
    random = np.random.default_rng(7)
    jump, Z = random.normal(size=(200, 3)) * 0.1, random.uniform(0, 0.3, 200)
    copies = jump.copy(), Z.copy()
    first, second = NARROW.update(jump, Z), NARROW.update(jump, Z)
    np.testing.assert_array_equal(jump, copies[0])
    np.testing.assert_array_equal(Z, copies[1])
    for a, b in zip(first, second, strict=True):
        np.testing.assert_array_equal(a, b)
    assert (first[2] >= Z).all()
    assert (NARROW.damage(first[2]) >= NARROW.damage(Z)).all()


@pytest.mark.parametrize("width", [0.1, 0.5, 2.0, 10.0, 60.0])
def test_no_nan_anywhere(width: float) -> None:
    random = np.random.default_rng(11)
    law = CrackPlane(Concrete.preset("reinhardt"), width)
    Zm = law.concrete.Zm
    jump = random.uniform(-10 * Zm, 10 * Zm, (200_000, 3))
    jump[:10] = 0.0
    jump[10:20, 1:] = 0.0
    jump[20] = [
        law.concrete.u_phi0 + 0.025 * Zm + 3 * law.contact_reach(np.array([Zm]))[0] / law.concrete.c_lm,
        0,
        0,
    ]  # the nose's centre
    Z = random.uniform(0, 10 * Zm, 200_000)
    with np.errstate(all="raise", under="ignore"):
        for values in law.update(jump, Z):
            assert np.isfinite(values).all()


def test_rotation_in_the_crack_plane() -> None:
    c, s = np.cos(0.7), np.sin(0.7)
    Q = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    jump, Z = np.array([[0.02, 0.05, 0.03], [-0.01, 0.02, 0.04], [0.2, -0.3, 0.1]]), np.array([0.05, 0.1, 0.02])
    t, T, z = NARROW.update(jump, Z)
    t2, T2, z2 = NARROW.update(jump @ Q.T, Z)
    np.testing.assert_allclose(t2, t @ Q.T, rtol=1e-12)
    np.testing.assert_allclose(T2, Q @ T @ Q.T, rtol=1e-10, atol=1e-9 * np.abs(T).max())
    np.testing.assert_allclose(z2, z, rtol=1e-14)


@pytest.mark.parametrize("direction", [(1.0, 0.0), (0.0, 1.0), (0.6, 0.8)])
def test_dissipation_of_a_proportional_path_is_exact(direction: tuple[float, float]) -> None:
    # work of the damage part less its stored energy, by fine quadrature of t.du, against one and three steps
    m = NARROW.concrete
    law = CrackPlane(m, 0.3)
    end = 2.0 * m.Zm
    r = np.concatenate([[0.0], np.geomspace(1e-5, 1.0, 40_001)]) * end
    path = r[:, None] * np.array(direction)
    Z = law.history(path, np.zeros(len(r)))
    t = law.undamaged_traction(path, Z)  # without contact
    work = np.sum(0.5 * (t[1:] + t[:-1]) * np.diff(path, axis=0))
    expected = work - law.stored_energy(path[-1:], Z[-1:])[0]
    for steps in (1, 3):
        index = np.linspace(0, len(r) - 1, steps + 1).astype(int)
        total = 0.0
        for i, j in pairwise(index):
            total += law.dissipation(path[[i]], Z[[i]], path[[j]], Z[[j]])[0][0]
        assert total == pytest.approx(expected, rel=2e-5)  # the quadrature's own error


def test_dissipation_of_a_bent_path_converges_with_the_square_of_the_step() -> None:
    law = CrackPlane(NARROW.concrete, 0.3)

    def total(steps: int) -> float:
        t = np.linspace(0, 1, steps + 1)
        path = np.stack([0.02 + 0.05 * t, 0.3 * t**2], axis=1)
        Z, value = law.history(path[:1], np.zeros(1)), 0.0
        for a, b in pairwise(path):
            new = law.history(b[None], Z)
            value += law.dissipation(a[None], Z, b[None], new)[0][0]
            Z = new
        return value

    exact = total(4096)
    errors = [abs(total(n) - exact) for n in (16, 32, 64)]
    assert errors[0] < 2e-3 * exact
    assert errors[1] < 0.3 * errors[0] and errors[2] < 0.3 * errors[1]


def test_dissipation_gradient() -> None:
    law = CrackPlane(NARROW.concrete, 0.5)
    jump0, Z0 = np.array([[0.02, 0.01]]), np.array([0.0])
    Z0 = law.history(jump0, Z0)
    jump1 = np.array([[0.03, 0.03]])

    def value(jump: Array) -> float:
        return float(law.dissipation(jump0, Z0, jump, law.history(jump, Z0))[0][0])

    gradient = law.dissipation(jump0, Z0, jump1, law.history(jump1, Z0))[1][0]
    for unit, slope in zip(np.eye(2), gradient, strict=True):
        assert slope == pytest.approx((value(jump1 + 1e-6 * unit) - value(jump1 - 1e-6 * unit)) / 2e-6, rel=1e-7)


def test_wrong_arrays_are_refused() -> None:
    with pytest.raises(ValueError, match=r"jump has shape \(3,\)"):
        NARROW.update(np.zeros(3), np.zeros(1))
    with pytest.raises(ValueError, match=r"jump has shape \(2, 4\)"):
        NARROW.update(np.zeros((2, 4)), np.zeros(2))
    with pytest.raises(ValueError, match=r"Z has shape \(3,\)"):
        NARROW.update(np.zeros((2, 2)), np.zeros(3))
    for width in (0.0, -1.0, np.nan, "h"):
        with pytest.raises(ValueError, match=r"^width = "):
            CrackPlane(NARROW.concrete, width)  # type: ignore[arg-type]


@pytest.mark.parametrize("components", [2, 3])
def test_a_law_of_many_widths_is_the_laws_of_each(components: int) -> None:
    concrete, random, widths = NARROW.concrete, np.random.default_rng(1), np.geomspace(0.1, 60, 40)
    many = CrackPlane(concrete, widths)
    before, jump = random.normal(size=(2, 40, components)) * concrete.Zm * np.geomspace(0.01, 2, 40)[:, None]
    Z0, Z = random.uniform(0, concrete.Zm, 40), random.uniform(0, concrete.Zm, 40)

    def everything(law: CrackPlane, i: Any) -> list[Array]:
        Z1 = law.history(before[i], Z0[i])
        return [
            *law.update(jump[i], Z[i]), law.update(jump[i], Z[i], frozen=True)[1], *law.traction(jump[i], Z[i]),
            *law.dissipation(before[i], Z1, jump[i], law.history(jump[i], Z1)), law.stored_energy(jump[i], Z[i]),
            law.contact_traction(jump[i], Z[i]), *law.contact_distance(jump[i], Z[i]), law.damage(Z[i]),
        ]  # fmt: skip

    each = [everything(CrackPlane(concrete, float(w)), [i]) for i, w in enumerate(widths)]
    for j, value in enumerate(everything(many, slice(None))):
        np.testing.assert_allclose(value, np.concatenate([one[j] for one in each]), rtol=1e-13)
    for bad in (np.array([1.0, 0.0]), np.array([1.0, -2.0]), np.array([np.nan]), np.array([np.inf]), np.ones((2, 2))):
        with pytest.raises(ValueError, match=r"(?s)^width = .*: expected a \(n,\) array of finite numbers above 0"):
            many.with_width(bad)


def test_dissipation_tells_rounding_from_a_start_below_the_surface() -> None:
    """A start that misses the damage surface by rounding counts as on it, with the mean of both ends' u.k.u / Z^2; one that is
    clearly below has no such ratio of its own: only that of the end counts, wherever it starts."""
    start, end = np.array([[0.05, 0.0]]), np.array([[0.06, 0.08]])
    Z0 = NARROW.history(start, np.zeros(1))
    Z1 = NARROW.history(end, Z0)

    def value(part: float) -> float:
        return float(NARROW.dissipation(part * start, Z0, end, Z1)[0][0])

    assert value(1 - 1e-12) == pytest.approx(value(1.0), rel=1e-9)
    assert value(1 - 1e-7) == value(0.5)
    assert abs(value(0.5) - value(1.0)) > 1e-3 * value(1.0)
