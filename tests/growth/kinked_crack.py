"""A crack, and one with a kink, in a large plate under tension, by linear fracture mechanics: what the criteria of a path must
meet.

Independent of the package. The whole field of the straight crack is that of H. M. Westergaard (J. Appl. Mech. 6, 1939), with
the stress along the crack of G. R. Irwin (Proc. SESA 16, 1958). The crack with a kink is made of displacement discontinuities,
constant along elements, by the stresses of edge dislocations in an infinite plane (J. P. Hirth and J. Lothe, Theory of
Dislocations, 1982). The kink has a finite length, so that the stress along the crack (T) counts as it does in a path of
segments.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

from cohesive.arrays import Array

#: elements to each side of the middle of the crack and of the kink; the smallest, in lengths of the kink
_OF_CRACK, _OF_KINK, _SMALLEST = 100, 60, 1e-3

#: elements to each side of the middle of a segment of a crack that grows
_OF_SEGMENT = 14


def direction_without_sliding(slant: float, length: float) -> float:
    """Turn of a kink whose tip does not slide (K_II = 0), degrees.

    Parameters
    ----------
    slant : of the crack from the perpendicular of the pull, degrees
    length : of the kink over half the length of the crack
    """
    return math.degrees(brentq(lambda turn: _sliding(math.radians(slant), turn, length), 0.05, 1.45, xtol=1e-3))


def direction_of_hoop_stress(slant: float) -> float:
    """Turn to the largest hoop stress of the singular field, degrees."""
    return -math.degrees(_turn_to_hoop_stress(1.0 / math.tan(math.radians(slant))))


def direction_of_averaged_hoop_stress(slant: float, radius: float) -> float:
    """Turn to the largest hoop stress along rays of finite length, degrees: the mean over points of the ray with weights
    r exp(-2 r^2 / radius^2), as of `cohesive.growth.stress.Probe`, without the smoothing over rays.

    Parameters
    ----------
    slant : of the crack from the perpendicular of the pull, degrees
    radius : length of the rays over half the length of the crack
    """
    turns = np.radians(np.arange(0.0, 90.0, 0.05))
    r = radius * (np.arange(64) + 0.5) / 64
    weight = r * np.exp(-2.0 * (r / radius) ** 2)
    xx, yy, xy = _westergaard(1.0 + r * np.exp(-1j * turns[:, None]), math.radians(slant))
    n = np.sin(turns)[:, None], np.cos(turns)[:, None]
    hoop = (xx * n[0] ** 2 + yy * n[1] ** 2 + 2 * xy * n[0] * n[1]) @ weight
    return math.degrees(turns[hoop.argmax()])


def grown_crack(slant: float, segment: float, number: int) -> Array:
    """Points of a crack that grows at both ends alike, each segment in the direction of the largest hoop stress of the
    singular field at its tip: (number + 1, 2) from the end of the first crack on, in half lengths of it.

    Parameters
    ----------
    slant : of the first crack from the perpendicular of the pull, degrees
    segment : length of the segments over half the length of the first crack
    number : of segments
    """
    heading = math.radians(slant)
    points = [np.array([math.cos(heading), math.sin(heading)])]
    for _ in range(number):
        corners = [*(-point for point in points[::-1]), *points]
        nodes = [corners[0][None]]
        for start, end in pairwise(corners):
            along = _graded(_OF_KINK, 1e-3 * segment) if len(nodes) == len(points) else _graded(_OF_SEGMENT, 2e-3)
            nodes.append(start + (end - start) * along[1:, None])
        opening, sliding = _jumps(np.concatenate(nodes))
        heading += _turn_to_hoop_stress(float(opening[-3] / sliding[-3]))
        points.append(points[-1] + segment * np.array([math.cos(heading), math.sin(heading)]))
    return np.array(points)


def _turn_to_hoop_stress(q: float) -> float:
    """Turn to the largest hoop stress of a singular field with K_I = q K_II, radians (F. Erdogan and G. C. Sih, J. Basic Eng.
    85, 1963)."""
    return 2.0 * math.atan(0.25 * (q - math.copysign(math.sqrt(q * q + 8.0), q)))


def _westergaard(z: Array, slant: float) -> tuple[Array, Array, Array]:
    """Stresses [xx, yy, xy] at places z = x + i y of a crack from -1 to 1, under a unit pull at an angle to its normal."""
    c, s = math.cos(slant), math.sin(slant)
    root = np.sqrt(z - 1.0) * np.sqrt(z + 1.0)
    value, slope = z / root, 1.0 / root - z * z / root**3
    y, pull, shear = z.imag, c * c, s * c
    one = pull * (value.real - y * slope.imag) + s * s - pull, pull * (value.real + y * slope.imag), -pull * y * slope.real
    two = shear * (2 * value.imag + y * slope.real), -shear * y * slope.real, shear * (value.real - y * slope.imag)
    return one[0] + two[0], one[1] + two[1], one[2] + two[2]


def _sliding(slant: float, turn: float, length: float) -> float:
    """Sliding over opening close behind the tip of the kink."""
    along = np.array([math.cos(slant), math.sin(slant)])
    kink = length * np.array([math.cos(slant - turn), math.sin(slant - turn)])
    smallest = _SMALLEST * length
    nodes = np.concatenate(
        [along * (2.0 * _graded(_OF_CRACK, 0.5 * smallest)[:, None] - 1.0),
         along + kink * _graded(_OF_KINK, _SMALLEST)[1:, None]]
    )  # fmt: skip
    opening, sliding = _jumps(nodes)
    return float(sliding[-3] / opening[-3])


def _graded(n: int, smallest: float) -> Array:
    """2 n + 1 places from 0 to 1, whose distances grow by one factor from both ends to the middle."""
    smallest = min(smallest, 0.01)
    factor = brentq(lambda q: smallest * (q**n - 1.0) / (q - 1.0) - 0.5, 1.0 + 1e-7, 50.0)
    half = smallest * (factor ** np.arange(n + 1) - 1.0) / (factor - 1.0)
    return np.concatenate([half, 1.0 - half[-2::-1]])


def _jumps(nodes: Array) -> tuple[Array, Array]:
    """Opening and sliding of the elements between nodes (n + 1, 2) under a unit pull along y."""
    tangent = np.diff(nodes, axis=0)
    tangent /= np.hypot(*tangent.T)[:, None]
    normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)
    middle = 0.5 * (nodes[1:] + nodes[:-1])
    # a jump along an element is a dislocation at its start and the opposite one at its end
    stress = [a - b for a, b in zip(_dislocations(middle, nodes[:-1]), _dislocations(middle, nodes[1:]), strict=True)]
    nx, ny = normal.T[:, :, None]
    matrix = np.block([[s[0] * nx + s[2] * ny for s in stress], [s[2] * nx + s[1] * ny for s in stress]])
    jump = np.linalg.solve(matrix, -np.concatenate([np.zeros(len(normal)), normal[:, 1]])).reshape(2, -1).T
    opening, sliding = (jump * normal).sum(axis=1), (jump * tangent).sum(axis=1)
    sign = math.copysign(1.0, float(opening.sum()))
    return sign * opening, sign * sliding


def _dislocations(at: Array, places: Array) -> tuple[Array, Array]:
    """Stresses [xx, yy, xy] at points from edge dislocations with unit Burgers vectors along x and y, up to a factor: two
    (3, n, n) arrays."""
    x, y = np.moveaxis(at[:, None] - places, -1, 0)
    r4 = (x * x + y * y) ** 2
    glide = np.stack([-y * (3 * x * x + y * y), y * (x * x - y * y), x * (x * x - y * y)]) / r4
    climb = np.stack([x * (x * x - y * y), x * (x * x + 3 * y * y), y * (x * x - y * y)]) / r4
    return glide, climb
