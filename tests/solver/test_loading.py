"""Drives as the equations see them: what moves, what is held, and the forces that stay."""

from __future__ import annotations

import numpy as np
import pytest

from cohesive.solver.loading import DEAD, Actuator, Loading

#: a single drive, two opposed forces, a platen, the dead loads; motion 5 is that of a support that gives mode
DRIVES = {
    "one": Actuator((0,)),
    "pair": Actuator((1, 2)),
    "platen": Actuator((3, 4), is_platen=True),
    DEAD: Actuator((6,)),
}
COUNT = 7


def loading() -> Loading:
    return Loading.from_drives(DRIVES, COUNT)


def test_the_first_drive_is_moved_and_dead_loads_are_held() -> None:
    first = loading()
    assert first.active == "one" and first.names == ["one", "pair", "platen"]
    np.testing.assert_array_equal(first.direction, np.eye(COUNT)[0])
    allowed = first.allowed
    assert allowed is not None and allowed.shape == (COUNT, COUNT - 2)  # neither the dead loads nor across the platen
    np.testing.assert_array_equal(allowed[6], 0.0)
    np.testing.assert_array_equal(allowed[4], 0.0)


@pytest.mark.parametrize("mode", ["force", "motion", "free"])
@pytest.mark.parametrize("name", ["pair", "platen"])
def test_what_a_held_drive_allows(name: str, mode: str) -> None:
    """Motions along it are free, but for "motion"; columns are orthonormal, with one entry in a row at most."""
    held = loading().after("one", {name: mode}, np.zeros(COUNT))
    allowed = held.allowed
    assert allowed is not None
    np.testing.assert_allclose(allowed.T @ allowed, np.eye(allowed.shape[1]), atol=1e-15)
    assert (np.count_nonzero(allowed, axis=1) <= 1).all()
    along = allowed.T @ held.row(name)
    assert (np.linalg.norm(along) < 1e-15) == (mode == "motion")


def test_opposed_forces_held_at_their_motion_still_move_together() -> None:
    held = loading().after(None, {"pair": "motion"}, np.zeros(COUNT))
    together = np.zeros(COUNT)
    together[[1, 2]] = 1.0
    assert held.allowed is not None
    np.testing.assert_allclose(held.allowed @ (held.allowed.T @ together), together, atol=1e-15)


def test_the_drive_that_was_moved_is_held_at_its_force() -> None:
    forces = np.array([30.0, 7.0, -7.0, 0.0, 0.0, 0.0, 0.0])
    second = loading().after("pair", {}, forces)
    np.testing.assert_array_equal(second.dead, [30.0, 0, 0, 0, 0, 0, 0])
    # its force is remembered, not read again from a state that is in equilibrium to a tolerance only
    third = second.after("platen", {}, forces + np.eye(COUNT)[0])
    np.testing.assert_allclose(third.dead, [30.0, 7.0, -7.0, 0, 0, 0, 0], rtol=1e-12)
    assert third.force("pair", third.dead) == pytest.approx(7.0)
    free = third.after(None, {"one": "free"}, forces)
    assert free.dead[0] == 0.0 and free.dead[1] == pytest.approx(7.0)
    assert free.drives[DEAD].mode == "motion"


def test_a_platen_turns_and_is_let_go_across() -> None:
    turned = loading().after("platen", {}, np.zeros(COUNT)).turned(90.0, None)
    np.testing.assert_array_equal(turned.direction, np.eye(COUNT)[4])  # without the rounding of the cosine
    assert not turned.moved.is_free_across
    free = turned.turned(None, False)
    assert free.moved.is_free_across and free.moved.angle == 90.0
    assert free.allowed is not None and free.allowed.shape[1] == COUNT - 1  # all but the dead loads
