"""Parts of a convex polygon: inside a face, above a plane."""

from __future__ import annotations

import math

import numpy as np

from ..arrays import Array


def part_inside(polygon: Array, face: Array, slack: float) -> Array:
    """Corners of the part of a polygon inside a face, (0, 2) if no part of it lies inside.

    Parameters
    ----------
    polygon : (k, 2), convex; a single point or a segment too.
    face : (n, 2), convex, counter-clockwise.
    slack : by this much the face is made wider on every side.
    """
    for a, b in zip(face, np.roll(face, -1, axis=0), strict=True):
        inward = np.array([a[1] - b[1], b[0] - a[0]]) / math.dist(a, b)
        polygon = part_above(polygon, (polygon - a) @ inward + slack)
    return polygon


def part_above(polygon: Array, height: Array) -> Array:
    """Corners of the part of a convex polygon (k, d) on which a linear function is not negative.

    Parameters
    ----------
    polygon : (k, d)
    height : (k,) the function at the corners.
    """
    kept = []
    for i in range(len(polygon)):
        if (height[i] < 0) != (height[i - 1] < 0):
            share = height[i] / (height[i] - height[i - 1])
            kept.append(polygon[i] + share * (polygon[i - 1] - polygon[i]))
        if height[i] >= 0:
            kept.append(polygon[i])
    return np.array(kept).reshape(-1, polygon.shape[1])
