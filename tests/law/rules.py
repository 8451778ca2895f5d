"""What every registered law keeps to, as functions that raise AssertionError."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.integrate import trapezoid

from cohesive import Law
from cohesive.arrays import Array

#: jumps far from each other, over the onset jump and over the opening that energy and strength give
_POINTS, _STEPS = 60, 6


def scale(law: Law) -> float:
    return law.energy / law.strength


def states(law: Law, seed: int = 1) -> Iterator[tuple[Array, Array]]:
    """Jumps of n points, (n, d), and the histories before them, step by step along random ways: opened, pressed, sheared."""
    random, d = np.random.default_rng(seed), law.components
    history = law.initial(_POINTS)
    size = np.geomspace(0.3 * law.onset_jump, 3.0 * scale(law), _POINTS)[:, None]
    for _ in range(_STEPS):
        jump = size * random.normal(size=(_POINTS, d))
        jump[::3, 0] = -0.05 * abs(jump[::3, 0])  # pressed together, and sheared
        yield jump, history
        history = law.update(jump, history)[2]


def undamaged_planes_carry_nothing(law: Law) -> None:
    zero, history = np.zeros((3, law.components)), law.initial(3)
    traction, tangent, new = law.update(zero, history)
    assert not traction.any() and not law.stored_energy(zero, history).any() and not law.is_damaged(new).any()
    k = np.diag(law.stiffness(law.components))
    np.testing.assert_allclose(tangent, np.broadcast_to(k, tangent.shape), rtol=1e-6, atol=1e-9 * k.max())


def updates_are_pure(law: Law) -> None:
    """Nothing that is given changes, the answer is the same again, and a step to where it stands changes nothing."""
    for jump, history in states(law):
        before = jump.copy(), history.copy()
        one, other = law.update(jump, history), law.update(jump, history)
        np.testing.assert_array_equal(jump, before[0])
        np.testing.assert_array_equal(history, before[1])
        for a, b in zip(one, other, strict=True):
            np.testing.assert_array_equal(a, b)
        again = law.update(jump, one[2])
        np.testing.assert_allclose(again[0], one[0], rtol=1e-9, atol=1e-9 * law.strength)
        np.testing.assert_allclose(again[2], one[2], rtol=1e-9, atol=1e-12 * law.energy)


def points_are_alone(law: Law) -> None:
    """One call for all points gives what a call for each gives."""
    jump, history = list(states(law))[-1]
    together = law.update(jump, history)
    for i in range(0, len(jump), 7):
        for whole, one in zip(together, law.update(jump[[i]], history[[i]]), strict=True):
            np.testing.assert_allclose(whole[i], one[0], rtol=1e-12, atol=1e-12 * abs(whole).max())


def _differences(law: Law, jump: Array, history: Array, way: Array, step: Array) -> tuple[Array, Array]:
    """One-sided derivatives of the traction along a way, forwards and backwards, of the second order, (n, d) each."""

    def traction(by: float) -> Array:
        return law.update(jump + by * step * way, history)[0]

    here, sides = traction(0.0), []
    for sign in (1.0, -1.0):
        sides.append(sign * (4.0 * traction(sign) - traction(2.0 * sign) - 3.0 * here) / (2.0 * step))
    return sides[0], sides[1]


def tangents_are_derivatives(law: Law) -> None:
    """On every branch: where the traction is smooth, which is nearly everywhere."""
    smooth, total, k = 0, 0, law.stiffness(2).max()
    for jump, history in states(law):
        tangent = law.update(jump, history)[1]
        step = 1e-5 * np.maximum(abs(jump).max(axis=1, keepdims=True), law.onset_jump)
        for i, way in enumerate(np.eye(law.components)):
            forward, backward = _differences(law, jump, history, way, step)
            size = abs(tangent).max(axis=(1, 2))[:, None] + abs(forward) + 1e-9 * k
            is_smooth = (abs(forward - backward) < 1e-5 * size).all(axis=1)
            error = abs(0.5 * (forward + backward) - tangent[:, :, i]) / size
            assert error[is_smooth].max() < 1e-4
            smooth, total = smooth + is_smooth.sum(), total + len(jump)
    assert smooth > 0.8 * total


def frozen_tangents_are_those_of_unloading(law: Law) -> None:
    """At the surface, backwards: where opening falls, and where sliding turns, to its origin or the way that it came."""
    k, last, shear = law.stiffness(2).max(), np.zeros((_POINTS, law.components)), np.arange(law.components) > 0
    for jump, history in states(law):
        new = law.update(jump, history)[2]
        tangent = law.update(jump, new, frozen=True)[1]
        np.testing.assert_array_equal(law.update(jump, history, frozen=True)[0], law.update(jump, history)[0])
        step = 1e-5 * np.maximum(abs(jump).max(axis=1, keepdims=True), law.onset_jump)
        size = abs(tangent).max(axis=(1, 2))[:, None] + 1e-9 * k

        errors = []
        for way in (np.broadcast_to(np.eye(law.components)[0], jump.shape), jump * shear, (jump - last) * shear):
            way = way / np.linalg.norm(way, axis=1, keepdims=True)
            _, backward = _differences(law, jump, new, way, step)
            wanted = np.einsum("nij,nj->ni", tangent, way)
            errors.append((abs(backward - wanted) / (size + abs(backward))).max(axis=1))
        assert np.quantile(errors[0], 0.95) < 1e-4
        assert np.quantile(np.minimum(*errors[1:]), 0.95) < 1e-4
        last = jump


def axes_of_shear_mean_nothing(law: Law) -> None:
    """Turned about the normal in 3D, and the same jump in 2D and in 3D."""
    solid = law.built_for(law.concrete, law.width, 3)
    turn = np.eye(3)
    turn[1:, 1:] = [[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]]
    jumps = [jump for jump, _ in states(solid)]
    own, turned = solid.initial(_POINTS), solid.initial(_POINTS)
    for jump in jumps:
        t, T, own = solid.update(jump, own)
        s, S, turned = solid.update(jump @ turn.T, turned)
        np.testing.assert_allclose(s, t @ turn.T, rtol=1e-8, atol=1e-8 * law.strength)
        np.testing.assert_allclose(S, turn @ T @ turn.T, atol=1e-8 * abs(T).max())
    flat = law.built_for(law.concrete, law.width, 2)
    for jump, history in states(flat):
        start = solid.initial(_POINTS)
        if not flat.is_damaged(history).any():
            t, s = flat.update(jump, history)[0], solid.update(np.column_stack([jump, 0 * jump[:, 0]]), start)[0]
            np.testing.assert_allclose(s[:, :2], t, rtol=1e-9, atol=1e-9 * law.strength)
            assert not s[:, 2].any()


def opening_takes_strength_and_energy(law: Law) -> None:
    """A slow opening reaches the strength, and takes the energy of separation; then nothing is left."""
    last = 30.0 * scale(law)
    openings = np.unique(np.r_[np.linspace(0, 3 * law.onset_jump, 40), np.geomspace(3 * law.onset_jump, last, 160)])
    history, tractions, lost, before = law.initial(1), [0.0], 0.0, np.zeros((1, law.components))
    start = history
    for opening in openings[1:]:
        jump = np.zeros((1, law.components))
        jump[0, 0] = opening
        t, _, history = law.update(jump, start)
        lost += float(law.dissipation(before, start, jump, history)[0][0])
        tractions.append(float(t[0, 0]))
        before, start = jump, history
    assert abs(max(tractions) / law.strength - 1.0) < 0.02
    assert abs(trapezoid(tractions, openings) / law.separation_energy - 1.0) < 0.02
    assert abs(lost / law.separation_energy - 1.0) < 0.02
    assert law.is_fully_softened(history).all() and (law.strength_left(history) < 1e-6).all() and law.damage(history)[0] > 0.99
    assert not law.is_fully_softened(law.initial(2)).any() and np.isinf(law.strength_left(law.initial(2))).all()


def gradients_of_dissipation_are_derivatives(law: Law) -> None:
    for jump, history in list(states(law))[:3]:
        start = np.zeros_like(jump)
        before = law.update(start, history)[2]

        def lost(to: Array, start: Array = start, before: Array = before) -> Array:
            return law.dissipation(start, before, to, law.update(to, before)[2])[0]

        gradient = law.dissipation(start, before, jump, law.update(jump, before)[2])[1]
        wanted = law.slope(lost, jump)
        error = abs(gradient - wanted).max(axis=1) / (abs(wanted).max(axis=1) + 1e-3 * law.strength)
        assert np.quantile(error, 0.9) < 1e-3


def loops(law: Law) -> float:
    """The most energy that a closed loop at constant damage makes, over the energy of separation: jumps within what a point
    has seen, twice around, of which the second counts."""
    random, parts = np.random.default_rng(3), np.repeat([0.1, 0.5, 1.0, 2.0], 12) * scale(law)
    furthest = np.zeros((len(parts), law.components))
    furthest[:, :2] = parts[:, None]
    history = law.update(furthest, law.initial(len(parts)))[2]
    corners = random.uniform(0.0, 0.6, size=(4, len(parts), law.components)) * parts[:, None]
    corners[:, :, 2:] = 0.0
    way = np.concatenate([np.linspace(a, b, 160) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)])
    for _ in range(2):
        tractions = np.zeros_like(way)
        for i, jump in enumerate(way):
            tractions[i], _, history = law.update(jump, history)
    around = np.roll(way, -1, axis=0) - way
    work = 0.5 * np.einsum("sni,sni->n", tractions + np.roll(tractions, -1, axis=0), around)
    return float(-work.min() / law.separation_energy)


def loops_make_energy_only_if_it_is_said(law: Law) -> None:
    assert (loops(law) > 1e-3) == law.makes_energy


RULES = (
    undamaged_planes_carry_nothing,
    updates_are_pure,
    points_are_alone,
    tangents_are_derivatives,
    frozen_tangents_are_those_of_unloading,
    axes_of_shear_mean_nothing,
    opening_takes_strength_and_energy,
    gradients_of_dissipation_are_derivatives,
    loops_make_energy_only_if_it_is_said,
)
