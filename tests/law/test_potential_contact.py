"""Contact from a potential: values, tangent, what it gains (no energy from cycles, never stiffer than the plane) and keeps."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import minimize

from cohesive import Concrete, CrackPlane, NotConverged, Scene, run
from cohesive.errors import NoContact
from cohesive.law.potential_contact import inelastic_jump, potential_contact, total_energy

Array = NDArray[np.float64]

CORRECTED = Concrete.preset("reinhardt", contact="potential")
WIDTHS = [1e-3, 0.2, 2.0, 60.0]


def samples(concrete: Concrete, n: int, components: int = 2, seed: int = 1) -> tuple[Array, Array]:
    """Jumps of all sizes and directions, some of them special, and histories."""
    random = np.random.default_rng(seed)
    jump = random.normal(size=(n, components)) * concrete.Zm * 10 ** random.uniform(-5, 1, (n, 1))
    jump[:20, 0], jump[20:40, 1:], jump[40] = 0.0, 0.0, 0.0
    return jump, concrete.Zm * 10 ** random.uniform(-5, 1, n)


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("jump", [(0.002, 0.0), (-0.003, 0.01), (0.05, 0.2), (0.02, 0.01), (-0.0005, 0.0)])
def test_traction_minimises_the_energy(width: float, jump: tuple[float, float]) -> None:
    """Against a minimum found by simplex, with W by quadrature of g and nothing else of the module."""
    law, m, Z = CrackPlane(CORRECTED, width), CORRECTED, 0.1
    uz = min(m.r_z * m.Zm + min(Z, m.Zm) / m.c_zn, Z / m.c_lm)
    R, q = m.n_g * m.Zm + m.c_lm * uz, np.hypot(1.0, m.m_g)

    x, weight = np.polynomial.legendre.leggauss(24)

    def W(phi: float) -> float:
        """Minus the integral of g from phi to where contact begins, by pieces as short as g is smooth."""
        reach = m.c_lm * uz - phi
        if reach <= 0:
            return 0.0
        ends = np.linspace(phi, m.c_lm * uz, 2 + int(reach / (2 * uz)))
        half = 0.5 * np.diff(ends)[:, None]
        at = ends[:-1, None] + half * (1 + x)
        return float((0.5 * uz * (np.logaddexp(0, -2 * at / uz) - np.log1p(np.exp(-2 * m.c_lm))) * half * weight).sum())

    def energy(log_opening: float, s: float) -> float:
        u1 = float(np.exp(log_opening))
        if u1 - R + m.m_g * s > 0:
            phi = (m.m_g * (u1 - R * (m.m_g - q) / m.m_g) - s) / q
        else:
            phi = R - np.hypot(u1 - R, s)
        H = sum(p * np.exp(-u1 / (c * m.Zm)) for p, c in zip(m.p, m.c, strict=True))
        plane = (m.E * (jump[0] - u1) ** 2 + m.G * (jump[1] - s) ** 2) / (2 * width)
        return float(plane + m.G / m.h * W(float(phi)) * H / (1 - H))

    best = None
    for opening in np.geomspace(1e-5, 0.1, 12):
        found = minimize(
            lambda x: energy(*x), [np.log(opening), jump[1]], method="Nelder-Mead",
            options={"xatol": 1e-11, "fatol": np.inf, "maxiter": 2000},
        )  # fmt: skip
        best = found if best is None or found.fun < best.fun else best
    assert best is not None
    omega = law.damage(np.array([Z]))[0]
    traction = law.contact_traction(np.array([jump]), np.array([Z]))[0]
    # the energy is flat at its minimum: half its digits determine the place, which the plane's stiffness multiplies
    place = np.array([np.exp(best.x[0]), best.x[1]])
    expected = omega * law.stiffness(2) * (np.array(jump) - place)
    scale = law.stiffness(2).max() * 1e-8 * max(abs(np.array(jump)).max(), place.max())
    np.testing.assert_allclose(traction, expected, atol=scale)


@pytest.mark.parametrize("components", [2, 3])
@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("u_phi0", [0.0, 0.01])
def test_tangent(width: float, components: int, u_phi0: float) -> None:
    law = CrackPlane(replace(CORRECTED, u_phi0=u_phi0), width)
    jump, Z = samples(law.concrete, 1500, components)
    for frozen in (False, True):
        _, tangent, Z_new = law.update(jump, Z, frozen)
        h = 1e-5 * np.maximum(np.linalg.norm(jump, axis=1), 1e-6)[:, None]
        columns = []
        for unit in np.eye(components):
            if frozen:
                ends = [
                    (1 - law.damage(Z_new))[:, None] * law.stiffness(components) * at + law.contact_traction(at, Z_new)
                    for at in (jump + h * unit, jump - h * unit)
                ]
            else:
                ends = [law.traction(at, Z)[0] for at in (jump + h * unit, jump - h * unit)]
            columns.append((ends[0] - ends[1]) / (2 * h))
        expected = np.stack(columns, axis=2)
        stiff = law.stiffness(components).max()
        error = abs(tangent - expected).max(axis=(1, 2)) / np.maximum(abs(tangent).max(axis=(1, 2)), 1e-6 * stiff)
        # steps of 1e-5: of the size of the rounding at the stiff points; one point in fifty lies at a corner
        assert np.quantile(error, 0.98) < 1e-5


@pytest.mark.parametrize("width", WIDTHS)
def test_never_stiffer_than_the_plane_and_symmetric(width: float) -> None:
    """k - T is positive at constant damage, so that a band in series has no fold; the printed form is 71 times too stiff."""
    jump, Z = samples(CORRECTED, 5000, 3)
    unit = np.sqrt(CrackPlane(CORRECTED, width).stiffness(3))
    highest = {}
    for contact in ("printed", "potential"):
        law = CrackPlane(replace(CORRECTED, contact=contact), width)
        scaled = law.update(jump, np.maximum(Z, law.history(jump, Z)), frozen=True)[1] / unit / unit[:, None]
        highest[contact] = np.linalg.eigvalsh(0.5 * (scaled + scaled.transpose(0, 2, 1))).max()
    assert abs(scaled - scaled.transpose(0, 2, 1)).max() < 1e-12
    assert highest["potential"] < 1 + 1e-12
    assert highest["printed"] > 2


def loop_work(law: CrackPlane, turn: int) -> float:
    """Work of a closed loop at constant history, N/mm: u1 between .05 and .15, s between 0 and .2 mm."""
    corners = np.array([(0.05, 0.0), (0.15, 0.0), (0.15, 0.2), (0.05, 0.2), (0.05, 0.0)])[::turn]
    x, weight = np.polynomial.legendre.leggauss(400)
    work = 0.0
    for a, b in pairwise(corners):
        at = 0.5 * (a + b) + 0.5 * x[:, None] * (b - a)
        Z = np.full(len(at), 0.3)
        traction = (1 - law.damage(Z))[:, None] * law.stiffness(2) * at + law.contact_traction(at, Z)
        work += 0.5 * float(weight @ (traction @ (b - a)))
    return work


@pytest.mark.parametrize("width", [0.2, 60.0])
def test_no_energy_from_closed_loops(width: float) -> None:
    printed = [loop_work(CrackPlane(replace(CORRECTED, contact="printed"), width), turn) for turn in (1, -1)]
    corrected = [loop_work(CrackPlane(CORRECTED, width), turn) for turn in (1, -1)]
    assert printed[0] == pytest.approx(-printed[1])
    assert abs(printed[0]) > 0.1 * CORRECTED.Gf
    # the contact surface has two corners in its second derivative, which 400 points of quadrature feel
    assert max(map(abs, corrected)) < 1e-4 * CORRECTED.Gf


@pytest.mark.parametrize("name", ["crack-plane", "jacobsen", "walraven"])
@pytest.mark.parametrize("width", [0.2, 60.0])
def test_growing_damage_creates_no_energy_either(name: str, width: float) -> None:
    """The energy (1 - omega) u.k.u/2 + omega Psi falls while Z grows at a point on the damage surface."""
    law = CrackPlane(Concrete.preset(name, contact="potential"), width)
    jump, _ = samples(law.concrete, 4000)
    Z = law.traction(jump, np.zeros(len(jump)))[1]
    jump, Z = jump[law.Zt < Z], Z[law.Zt < Z]
    step = 1e-4 * Z

    def energy(history: Array) -> Array:
        from cohesive.law.potential_contact import inelastic_jump, total_energy

        psi = np.zeros(len(jump))
        at = np.flatnonzero(law.contact_distance(jump, history)[0] < law.contact_reach(history))
        u, z = np.column_stack([jump[at, 0], abs(jump[at, 1])]), history[at]
        k = np.broadcast_to(law.stiffness(2), u.shape)
        psi[at] = total_energy(law.concrete, k, inelastic_jump(law.concrete, k, u, z), u, z)[0]
        return np.asarray(law.stored_energy(jump, history) + law.damage(history) * psi)

    before, after = energy(Z), energy(Z + step)
    assert (after - before < 1e-12 * before).all()  # rounding of an energy that does not change


def test_same_inelastic_jump_at_every_width() -> None:
    jump, Z = samples(CORRECTED, 2000)
    wide = CrackPlane(CORRECTED, 60.0)
    at = wide.contact_distance(jump, Z)[0] < wide.contact_reach(Z)
    at &= 0.1 * CORRECTED.Zm < Z  # at both widths beyond the onset of damage
    jump, Z = jump[at], Z[at]
    omega = wide.damage(Z)[:, None]
    traction = wide.contact_traction(jump, Z) / omega
    left = jump - traction / wide.stiffness(2)
    narrow = CrackPlane(CORRECTED, 0.6)
    again = narrow.contact_traction(left + traction / narrow.stiffness(2), Z) / narrow.damage(Z)[:, None]
    # the difference of jumps 100 times larger than what is left loses two digits of the tractions
    np.testing.assert_allclose(again, traction, rtol=1e-7, atol=1e-9)


def test_shear_contact_is_the_printed_one() -> None:
    """At small width, on the faces that have opened: the shear of the two forms differs by the width only."""
    opening, sliding = (grid.ravel() for grid in np.meshgrid([0.05, 0.1, 0.2], [0.05, 0.1, 0.2, 0.4]))
    jump, Z = np.column_stack([opening, sliding]), np.full(opening.size, 0.3)
    printed, corrected = (
        CrackPlane(replace(CORRECTED, contact=contact), 1e-3).contact_traction(jump, Z) for contact in ("printed", "potential")
    )
    np.testing.assert_allclose(corrected[:, 1], printed[:, 1], rtol=1e-4, atol=1e-9)
    assert (abs(corrected[:, 0] / printed[:, 0] - 1.0) > 0.05).any()


def test_shear_at_a_given_pressure_is_not() -> None:
    """Faces that are pressed together: printed (G/E)/m_g of the pressure, corrected far less than in proportion to it."""

    def shear(contact: str, pressure: float) -> float:
        law = CrackPlane(replace(CORRECTED, contact=contact), 0.2)
        opening = np.geomspace(1e-6, 0.3, 40_000)[::-1]
        jump = np.column_stack([opening - 1e-4, np.full(opening.size, 0.3)])
        traction = law.traction(jump, np.full(opening.size, 0.1))[0]
        assert traction[0, 0] > -pressure > traction[-1, 0]
        return float(np.interp(pressure, -traction[:, 0], abs(traction[:, 1])))

    limit = CORRECTED.G / CORRECTED.E / CORRECTED.m_g
    assert shear("printed", 50.0) / 50.0 == pytest.approx(limit, rel=0.01)
    corrected = [shear("potential", pressure) / pressure for pressure in (10.0, 40.0)]
    assert (
        0.25 * corrected[0] < corrected[1] < 0.5 * corrected[0] < 0.3 * limit
    )  # four times the pressure, less than twice the shear


@pytest.mark.parametrize("width", WIDTHS)
def test_softening_is_untouched(width: float) -> None:
    opening = np.geomspace(1e-6, 5 * CORRECTED.Zm, 2000)
    jump = np.column_stack([opening, 0 * opening])
    laws = [CrackPlane(replace(CORRECTED, contact=contact), width) for contact in ("printed", "potential")]
    printed, corrected = (law.update(jump, np.zeros(2000)) for law in laws)
    for one, other in zip(printed, corrected, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-11)  # phi = c_lm uz but for rounding: contact of 1e-16 mm


def test_closing_is_close_to_the_printed_one() -> None:
    """Opened to 0.1 mm and pressed with 3 MPa: an inelastic opening of 2.9 um, printed 1.9 um, at any width."""
    law = CrackPlane(CORRECTED, 0.2)
    opening = np.linspace(0.0, 0.1, 20_001)
    jump, Z = np.column_stack([opening, 0 * opening]), np.full(20_001, 0.1)
    traction = law.traction(jump, Z)[0][:, 0]
    assert (np.diff(traction[:2000]) > 0).all()
    left = np.interp(-3.0, traction, opening) + 3.0 / law.stiffness(2)[0]
    assert left == pytest.approx(0.00285, abs=5e-5)
    printed = CrackPlane(replace(CORRECTED, contact="printed"), 0.2).traction(jump, Z)[0][:, 0]
    assert np.interp(-3.0, printed, opening) + 3.0 / law.stiffness(2)[0] == pytest.approx(0.00195, abs=5e-5)


@pytest.mark.parametrize("changes", [{}, {"c_zn": 1000.0}, {"r_z": 0.0, "c_zn": 1e9}, {"c_lm": 7.0, "onset_cap": False}])
def test_no_jump_is_without_contact(changes: dict[str, float]) -> None:
    concrete = Concrete.preset("jacobsen", contact="potential", **changes)
    for width in (1e-6, 0.1, 200.0):
        jump, Z = samples(concrete, 4000, 3)
        jump[50:150] *= 1e6
        traction, tangent, _ = CrackPlane(concrete, width).update(jump, Z)
        assert np.isfinite(traction).all() and np.isfinite(tangent).all()


def test_a_local_iteration_that_fails_is_a_step_that_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    cyclic = Scene.load("single-crack").with_(
        **{"material.contact": "potential", "stage": [{"control": "driven", "to": [0.05, -0.01], "steps": 5}]}
    )

    def fail_from_now_on(step: object, row: dict[str, float]) -> None:
        if row["step"] == 5:
            monkeypatch.setattr("cohesive.law.potential_contact.MAX_ITERATIONS", 0)

    with pytest.raises(NotConverged, match="no contact found for the jump") as stopped:
        run(cyclic, on_step=fail_from_now_on)
    assert len(stopped.value.result.history["load"]) >= 5  # type: ignore[attr-defined]


def test_bad_input() -> None:
    with pytest.raises(ValueError, match="contact = 'other': expected 'printed' or 'potential'"):
        Concrete.preset("reinhardt", contact="other")
    with pytest.raises(ValueError, match="shear_scaling"):
        replace(CORRECTED, shear_scaling=False)


def test_thin_asperities_are_not_convex_and_find_their_energy() -> None:
    """At h = 0.1 mm the Hessian has negative eigenvalues on the way to the minimum, where it has none."""
    m = Concrete.preset("crack-plane", contact="potential", h=0.1)
    law = CrackPlane(m, 2.0)
    jump, Z = samples(m, 6000, seed=5)
    Z = np.maximum(Z, law.Zt)
    touching = law.contact_distance(jump, Z)[0] < law.contact_reach(Z)
    jump, Z = np.column_stack([jump[touching, 0], abs(jump[touching, 1])]), Z[touching]
    k = np.broadcast_to(law.stiffness(2), jump.shape)
    _, _, hessian = total_energy(m, k, inelastic_jump(m, k, jump, Z), jump, Z)
    assert (np.linalg.eigvalsh(hessian)[:, 0] > 0).all()


def test_faces_pressed_beyond_all_digits_are_a_failed_point() -> None:
    """A trial of Newton's method that is far off: the step is cut, the run goes on."""
    with pytest.raises(NoContact, match="leave no digit of the plane"):
        potential_contact(CORRECTED, np.array([8e3, 3.6e3]), np.array([[-1e60, 1e8]]), np.ones(1))
