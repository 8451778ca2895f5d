"""The direction that the stress ahead of a tip tells: against exact fields."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cohesive.elements.bulk import ElasticBlock, elasticity
from cohesive.growth.stress import RAYS, NodalStress, Probe, Reading

LARGEST = math.radians(75.0)


def grid(n: int) -> ElasticBlock:
    """A square of 2 x 2 mm around the origin, in triangles."""
    x = np.linspace(-1.0, 1.0, n + 1)
    points = np.stack(np.meshgrid(x, x, indexing="ij"), axis=-1).reshape(-1, 2)
    corner = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    a, b, c, d = corner, corner + n + 1, corner + n + 2, corner + 1
    return ElasticBlock(
        "triangle", points, np.concatenate([np.c_[a, b, c], np.c_[a, c, d]]), elasticity(1000.0, 0.2, "stress")
    )


def probe_of(heading: float = 0.0) -> tuple[Probe, ElasticBlock]:
    block = grid(12)
    return Probe.from_tip(NodalStress.from_blocks([block]), (0.03, 0.05), heading, 0.6), block


def near_field(slant: float) -> Reading:
    """The singular stress ahead of a notch that is slanted so much from the perpendicular of a pull."""
    one, two, t = math.cos(slant), math.sin(slant), RAYS
    c, s = np.cos(t / 2), np.sin(t / 2)
    xx = one * c * (1 - s * np.sin(1.5 * t)) - two * s * (2 + c * np.cos(1.5 * t))
    yy = one * c * (1 + s * np.sin(1.5 * t)) + two * s * c * np.cos(1.5 * t)
    xy = one * c * s * np.cos(1.5 * t) + two * c * (1 - s * np.sin(1.5 * t))
    rays = np.stack([xx, yy, xy])
    return Reading(rays, rays[:, abs(RAYS) <= math.pi / 2].mean(axis=1))


@pytest.mark.parametrize(("slant", "kink"), [(0, 0.0), (15, 26.74), (30, 43.22), (45, 53.13), (60, 60.0)])
def test_the_singular_field_gives_the_maximum_hoop_stress(slant: float, kink: float) -> None:
    """tan(kink / 2) = (q - sqrt(q^2 + 8)) / 4, q = KI / KII; rays of 2.5 degrees and their smoothing cost .2 degrees. The
    principal direction of the half disc turns much less."""
    probe, _ = probe_of()
    reading = near_field(math.radians(slant))
    turn, stress = probe.strongest(reading, LARGEST)
    assert math.degrees(turn) == pytest.approx(-kink, abs=0.3)
    assert probe.is_clear(reading, turn, stress)
    assert -math.degrees(probe.principal_turn(reading)) <= max(0.75 * kink, 1e-9)


@pytest.mark.parametrize("heading", [0.0, 37.0, -120.0])
def test_an_even_pull_is_crossed_at_a_right_angle(heading: float) -> None:
    """An even stress is exact in triangles: a pull along y opens a crack along x, whatever its heading; to rounding."""
    probe, block = probe_of(math.radians(heading))
    pull = np.linalg.solve(block.D, [0.0, 3.0, 0.0])
    reading = probe.read(block.points * pull[:2])
    np.testing.assert_allclose(reading.half_disc, [0.0, 3.0, 0.0], atol=1e-9)
    wanted = (-heading + 90.0) % 180.0 - 90.0
    turn, stress = probe.strongest(reading, LARGEST)
    assert math.degrees(turn) == pytest.approx(wanted, abs=1e-3)
    assert math.degrees(probe.principal_turn(reading)) == pytest.approx(wanted, abs=1e-6)
    assert stress == pytest.approx(3.0, rel=0.05)  # the mean of neighbouring rays
    assert probe.is_clear(reading, turn, stress)


@pytest.mark.parametrize("stress", [(1.0, 1.0, 0.0), (1.0, 1.02, 0.0), (-1.0, -3.0, 0.0), (0.0, 0.0, 0.0)])
def test_alike_or_compressive_stresses_tell_no_direction(stress: tuple[float, ...]) -> None:
    probe, _ = probe_of()
    values = np.array(stress)
    reading = Reading(np.repeat(values[:, None], len(RAYS), axis=1), values)
    assert not probe.is_clear(reading, *probe.strongest(reading, LARGEST))


def test_rays_outside_the_body_do_not_count() -> None:
    block = grid(12)
    probe = Probe.from_tip(NodalStress.from_blocks([block]), (0.0, -1.0), math.pi / 2, 0.5)  # from a face
    assert (probe.inside[abs(RAYS) < math.radians(85)] == 1.0).all()
    assert (probe.inside[abs(RAYS) > math.radians(95)] == 0.0).all()
    assert np.isneginf(probe.hoop(probe.nothing)[[0, -1]]).all()
