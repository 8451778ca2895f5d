"""Unknowns: means, jumps and constraints."""

from __future__ import annotations

import numpy as np
import pytest

from cohesive.algebra.dissection import nested_dissection
from cohesive.algebra.unknowns import Constraint, Unknowns
from tests.builders import box, rotation

X, Y = (1.0, 0.0), (0.0, 1.0)
#: nodes 0 to 3; 4 and 5 are copies of 1 and 2
LEADER = np.array([0, 1, 2, 3, 1, 2])
BASE = [Constraint("base", np.array([0]), X), Constraint("base", np.array([0]), Y)]


def unknowns(drive: Constraint, *supports: Constraint) -> Unknowns:
    return Unknowns.from_constraints(LEADER, [*BASE, *supports], [drive])


def test_copies_move_by_mean_and_jump() -> None:
    made = unknowns(Constraint("load", np.array([3]), Y))
    T = made.transform.toarray()
    # node 0 is held: 3 nodes with 2 means each, less the driven one; 2 copies with 2 jumps each; the drive
    assert T.shape == (12, 5 + 4 + 1)
    motion = np.random.default_rng(0).normal(size=10)
    u = (T @ motion).reshape(-1, 2)
    np.testing.assert_array_equal(u[0], 0.0)
    assert u[3, 1] == motion[made.drives[0]]
    means = (u[1] + u[4]) / 2, (u[2] + u[5]) / 2
    jumps = u[4] - u[1], u[5] - u[2]
    np.testing.assert_allclose(sorted(np.r_[(*means, *jumps)]), sorted(motion[[0, 1, 2, 3, *range(5, 9)]]), rtol=1e-12)


def test_a_loaded_point_keeps_its_jump_and_a_driven_face_does_not() -> None:
    point = unknowns(Constraint("load", np.array([1, 4]), Y))
    assert point.transform.shape[1] == 5 + 4 + 1
    u = (point.transform.toarray()[:, point.drives[0]]).reshape(-1, 2)
    np.testing.assert_array_equal(u[[1, 4]], [[0, 1], [0, 1]])
    face = unknowns(Constraint("top", np.array([1, 2, 4, 5]), Y))
    assert face.transform.shape[1] == 4 + 2 + 1
    line = unknowns(Constraint("load", np.array([1, 2, 4, 5]), Y, holds_jumps=False))
    assert line.transform.shape[1] == 4 + 4 + 1
    support = unknowns(Constraint("load", np.array([3]), Y), Constraint("side", np.array([1, 4]), X))
    assert support.transform.shape[1] == 4 + 3 + 1


def test_faces_in_place_of_means_and_jumps() -> None:
    """Also where the first node of a drive, and of a platen that turns, is at the crack."""
    lever = np.array([1.0, -1.0])
    base = [Constraint("base", np.array([0]), X), Constraint("turning", np.array([2, 0]), Y, lever=lever)]
    made = Unknowns.from_constraints(
        LEADER, base, [Constraint("face", np.array([1, 3, 4]), Y), Constraint("push", np.array([3]), X)]
    )
    faces = np.array([1, 2, 4, 5])
    transform, node, basis = made.with_faces(faces, 2)
    np.testing.assert_allclose((transform @ basis).toarray(), made.transform.toarray(), rtol=1e-15)
    np.testing.assert_array_equal(node[-8:], np.repeat(faces, 2))
    np.testing.assert_array_equal(transform.toarray()[:, -8:], np.eye(12)[:, (2 * faces[:, None] + [0, 1]).ravel()])
    # nothing but the displacements of the faces moves them: the two sides know nothing of one another
    assert not transform.toarray()[(2 * faces[:, None] + [0, 1]).ravel(), :-8].any()


def test_constraints_along_slanted_directions() -> None:
    d = (0.6, 0.8)
    made = Unknowns.from_constraints(
        LEADER, [Constraint("a", np.array([3]), d)], [Constraint("load", np.array([0]), (-0.8, 0.6))]
    )
    u = (made.transform @ np.random.default_rng(1).normal(size=made.transform.shape[1])).reshape(-1, 2)
    assert abs(u[3] @ d) < 1e-15


def test_constraints_that_contradict_each_other_are_named() -> None:
    with pytest.raises(ValueError, match="load: a node is both held and driven"):
        unknowns(Constraint("load", np.array([0]), Y))
    with pytest.raises(ValueError, match="slope: its direction is oblique"):
        unknowns(Constraint("load", np.array([3]), Y), Constraint("slope", np.array([0]), (0.6, 0.8)))
    with pytest.raises(ValueError, match="slope: its direction is oblique"):  # at one of its nodes only
        unknowns(Constraint("load", np.array([3]), Y), Constraint("slope", np.array([0, 2]), (0.6, 0.8)))
    with pytest.raises(ValueError, match="load: expected at least one node"):
        unknowns(Constraint("load", np.array([], dtype=int), Y))


def test_nested_dissection_has_the_last_nodes_last() -> None:
    n = 40
    x, y = np.meshgrid(np.arange(n + 1.0), np.arange(n + 1.0), indexing="ij")
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    i, j = (part.ravel() for part in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    cells = np.stack([i * (n + 1) + j, (i + 1) * (n + 1) + j, (i + 1) * (n + 1) + j + 1, i * (n + 1) + j + 1], axis=1)
    last = np.flatnonzero(points[:, 0] == 17)
    group, _ = nested_dissection(points, [cells], last)
    np.testing.assert_array_equal(np.flatnonzero(group == group.max()), last)
    # what makes it worth its while: groups that do not follow one another's separators do not meet
    left, right = group[points[:, 0] < 17], group[points[:, 0] > 17]
    assert left.max() < right.min() and np.bincount(group).max() < 0.05 * len(points)
    assert len(np.unique(group[cells].max(axis=1))) > 20


def test_nested_dissection_separates_halves_by_a_face() -> None:
    solid = box("hexahedron", (24, 10, 8), (24.0, 10.0, 8.0))
    group, _ = nested_dissection(solid.points, [solid.cells], np.zeros(0, dtype=np.int64))
    np.testing.assert_array_equal(np.flatnonzero(group == group.max()), np.flatnonzero(solid.points[:, 0] == 12.0))


def test_constraints_in_3d() -> None:
    """Two drives or supports at a node in any directions at right angles to each other; others are refused."""
    Q = rotation(2)
    a, b, c = (tuple(row) for row in Q)
    representative = np.array([0, 1, 2, 0])
    base = [Constraint("base", np.array([0]), a), Constraint("side", np.array([0, 3]), b)]
    made = Unknowns.from_constraints(
        representative, base, [Constraint("pull", np.array([1]), b), Constraint("push", np.array([1]), c)]
    )
    # means: 1 of node 0, 1 of node 1, 3 of node 2; the jump of 0 along c; two drives
    assert made.transform.shape == (12, 1 + 1 + 3 + 1 + 2)
    v = np.random.default_rng(0).normal(size=8)
    u = (made.transform @ v).reshape(-1, 3)
    np.testing.assert_allclose(u[0] @ Q[:2].T, 0.0, atol=1e-14)
    np.testing.assert_allclose(u[3] @ Q[:2].T, 0.0, atol=1e-14)
    np.testing.assert_allclose(u[1] @ Q[1:].T, v[made.drives], rtol=1e-13)
    np.testing.assert_allclose(np.sort(abs(u[2])), np.sort(abs(v[[i for i in range(8) if made.node[i] == 2]])), rtol=1e-13)
    with pytest.raises(ValueError, match="slope: its direction is oblique"):
        Unknowns.from_constraints(
            representative, [*base, Constraint("slope", np.array([0]), tuple(np.array([0, 0.6, 0.8]) @ Q))], base[:1]
        )
    mirror = Unknowns.from_constraints(
        representative,
        [Constraint("top", np.array([2]), a)],
        [Constraint("pull", np.array([2]), b)],
        Constraint("crack", np.array([0]), c),
    )
    u = (mirror.transform @ np.random.default_rng(0).normal(size=mirror.transform.shape[1])).reshape(-1, 3)
    np.testing.assert_allclose(u[0] @ Q[:2].T, u[3] @ Q[:2].T, atol=1e-14)
    np.testing.assert_allclose(u[0] @ Q[2], -u[3] @ Q[2], rtol=1e-12)
