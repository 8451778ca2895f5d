"""Longest chords of elements, l_ch: known shapes, and random ones against many lines, in 2D and 3D."""

from __future__ import annotations

import numpy as np
import pytest

from cohesive.arrays import Array
from cohesive.elements.chords import longest_chord
from cohesive.elements.rotations import rotations
from tests.builders import CUBE, rotation

TETRA = [0, 1, 2, 2, 3, 3, 3, 3]
ANGLES = np.radians([0.0, 30.0, 45.0, 90.0, 137.2])
TURNS = np.stack([np.eye(3), *(rotation(seed) for seed in range(5))])


def turned(angle: Array) -> Array:
    """Rotations of planes whose normals stand at these angles to the x axis."""
    return rotations(np.stack([np.cos(angle), np.sin(angle)], axis=1))


def test_longest_chord_of_known_shapes() -> None:
    rectangle, triangle, d = [[0, 0], [4, 0], [4, 3], [0, 3]], [[0, 0], [2, 0], [0, 2], [0, 2]], np.sqrt(0.5)
    for shape, direction, length in (
        (rectangle, (1, 0), 4), (rectangle, (0, -1), 3), (rectangle, (0.8, 0.6), 5), (rectangle, (d, d), 3 / d),
        (triangle, (1, 0), 2), (triangle, (0, 1), 2), (triangle, (d, -d), 2 / d), (triangle, (d, d), 2 * d),
    ):  # fmt: skip
        turns = turned(ANGLES) * [[[1], [-1]]]
        got = longest_chord(np.array(shape) @ turns, np.array(direction) @ turns)
        np.testing.assert_allclose(got, length, rtol=1e-9)


def test_longest_chord_of_random_quadrilaterals() -> None:
    """Against many lines along the direction, each cut with every edge."""
    random = np.random.default_rng(4)
    angle = np.sort(random.uniform(0, 2 * np.pi, (60, 4)), axis=1)
    quads = np.stack([np.cos(angle), np.sin(angle)], axis=2) * random.uniform(0.2, 3.0, (60, 1, 2))
    toward = turned(random.uniform(0, 2 * np.pi, 60))
    for corners, (way, across), got in zip(quads, toward, longest_chord(quads, toward[:, 0]), strict=True):
        along, offset = corners @ way, corners @ across
        at = np.linspace(offset.min(), offset.max(), 4001)[1:-1, None]
        part = (at - offset) / (np.roll(offset, -1) - offset)  # where the lines cross each edge
        cut = np.where((part >= 0) & (part <= 1), along + part * (np.roll(along, -1) - along), np.nan)
        # the length of a chord is concave in its offset: between two samples it rises by less than a thousandth
        assert (np.nanmax(cut, axis=1) - np.nanmin(cut, axis=1)).max() == pytest.approx(got, rel=1e-3)
        (a, b), (c, d) = corners[2] - corners[0], corners[3] - corners[1]
        assert 0.5 * abs(a * d - b * c) / np.ptp(offset) <= got <= np.ptp(along) * (1 + 1e-12)  # mean chord, extent


def test_longest_chord_of_known_solids() -> None:
    d2, d3 = np.sqrt(0.5), np.sqrt(1 / 3)
    box = (CUBE + 0.5) * [4, 3, 2]
    corner = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])[TETRA]
    crossed = np.array([[-1, 0, 0], [1, 0, 0], [0, 1, 2], [0, -1, 2]])[TETRA]  # two edges at right angles, one over the other
    for shape, direction, length in (
        (box, (1, 0, 0), 4), (box, (0, -1, 0), 3), (box, (0.8, 0.6, 0), 5), (box, (d2, 0, d2), 2 / d2),
        (box, np.array([4, 3, 2]) / np.sqrt(29), np.sqrt(29)), (CUBE, (d3, d3, d3), 1 / d3),
        (corner, (0, 0, 1), 1), (corner, (d2, -d2, 0), 2 * d2), (corner, (d3, d3, d3), d3),
        (crossed, (0, 0, 1), 2), (crossed, (1, 0, 0), 2),
    ):  # fmt: skip
        got = longest_chord(np.asarray(shape, dtype=float) @ TURNS.transpose(0, 2, 1), TURNS @ np.array(direction))
        np.testing.assert_allclose(got, length, rtol=1e-9)


def chords(corners: Array, direction: Array, faces: list[list[int]], count: int) -> float:
    """Longest of many chords of a convex polyhedron: lines through points in its shadow, cut with the planes of its faces."""
    centre, random = corners.mean(axis=0), np.random.default_rng(0)
    weights = random.dirichlet(np.full(len(corners), 0.3), count)
    start, ahead, behind = weights @ corners, np.full(count, np.inf), np.full(count, -np.inf)
    for face in faces:
        a, b, c = corners[face[:3]]
        normal = np.cross(b - a, c - a)
        normal *= -np.sign(normal @ (centre - a))
        rate = normal @ direction
        reach = ((a - start) @ normal) / rate
        ahead, behind = (np.minimum(ahead, reach), behind) if rate > 0 else (ahead, np.maximum(behind, reach))
    return float((ahead - behind).max())


def test_longest_chord_of_random_solids() -> None:
    """Tetrahedra, and hexahedra with plane faces (cubes under projective maps), against many chords."""
    random = np.random.default_rng(4)
    hexahedron = [[0, 1, 2], [4, 5, 6], [0, 1, 5], [1, 2, 6], [2, 3, 7], [3, 0, 4]]
    for _ in range(20):
        direction = random.normal(size=3)
        direction /= np.linalg.norm(direction)
        tetra = random.normal(size=(4, 3))
        tetra[[0, 1]] = tetra[[0, 1] if np.linalg.det(tetra[1:] - tetra[0]) > 0 else [1, 0]]
        x = CUBE @ (np.eye(3) + 0.3 * random.normal(size=(3, 3)))
        brick = x / (1 + x @ random.uniform(-0.3, 0.3, 3))[:, None]
        for corners, solid, faces in (
            (tetra[TETRA], tetra, [[0, 1, 2], [0, 1, 3], [1, 2, 3], [0, 2, 3]]), (brick, brick, hexahedron),
        ):  # fmt: skip
            got = float(longest_chord(corners[None], direction[None])[0])
            sampled = chords(solid, direction, faces, 40000)
            assert sampled <= got * (1 + 1e-12) and sampled > 0.97 * got  # the sample finds the longest to some percent
