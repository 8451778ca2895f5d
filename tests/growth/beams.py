"""Beams and plates in which cracks grow."""

from __future__ import annotations

import math
from typing import Any

from cohesive import Scene


def eccentric_beam(**changes: Any) -> Scene:
    """The beam of Garcia-Alvarez et al., its notch 50 mm off mid-span, coarse; `changes` with __ for the dots of the keys."""
    beam = {"length": 250.0, "span": 200.0, "depth": 80.0, "thickness": 50.0, "notch": 20.0, "notch_position": -50.0}
    data = {
        "grow": {"segment": 8.0},
        "specimen": {"kind": "notched-beam", "gauge": 10.0, "crack": "grow", **beam},
        "mesh": {"crack_size": 2.0, "far_size": 16.0},
        "material": {"E": 33800.0, "nu": 0.2, "ft": 3.5, "Gf": 0.063},
        "stage": [{"control": "opening", "to": 0.12, "steps": 40}],
        "output": {"frames": 0},
    }
    return Scene(data).with_(**{key.replace("__", "."): value for key, value in changes.items()})


def turned(point: tuple[float, float], degrees: float) -> list[float]:
    """A point turned about the origin."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return [c * point[0] - s * point[1], s * point[0] + c * point[1]]


def outlined_beam(degrees: float = 0.0, notches: tuple[float, ...] = (-50.0,), **changes: Any) -> Scene:
    """The same beam as a user outline, turned, with notches at some places; its gauge is at the first one."""

    def at(x: float, y: float) -> list[float]:
        return turned((x, y), degrees)

    x = notches[0]
    up, along = at(0.0, 1.0), at(1.0, 0.0)
    beam = eccentric_beam()
    data = beam.data | {
        "specimen": {
            "kind": "outline",
            "thickness": 50.0,
            "corners": [at(-125, 0), at(125, 0), at(125, 80), at(-125, 80)],
            "notches": [[at(n, 0), at(n, 20)] for n in notches],
            "supports": [
                {"at": at(-100, 0), "direction": up}, {"at": at(-100, 0), "direction": along},
                {"at": at(100, 0), "direction": up},
            ],
            "drive": {"at": at(0, 80), "direction": [-c for c in up]},
            "gauge_minus": at(x - 5, 0),
            "gauge_plus": at(x + 5, 0),
            "crack": "grow",
        }
    }  # fmt: skip
    return Scene(data).with_(**{key.replace("__", "."): value for key, value in changes.items()})


def slanted_notch(slant: float, size: float, **changes: Any) -> Scene:
    """A square plate of 120 mm, pulled at its top, with a notch of 2 x 10 mm in its middle that is slanted by some
    degrees from the perpendicular of the pull; `size` of the elements, mm."""
    x, y = turned((10.0, 0.0), slant)
    data = {
        "grow": {"segment": 4 * size},
        "specimen": {
            "kind": "outline",
            "thickness": 1.0,
            "corners": [[-60, -60], [60, -60], [60, 60], [-60, 60]],
            "edges": {"low": [[-60, -60], [60, -60]], "top": [[-60, 60], [60, 60]]},
            "notches": [[[-x, -y], [x, y]]],
            "supports": [{"at": "low", "direction": [0, 1]}, {"at": [-60, -60], "direction": [1, 0]}],
            "drive": {"at": "top", "direction": [0, 1]},
            "crack": "grow",
        },
        "mesh": {"crack_size": size, "far_size": 8.0},
        "material": {"E": 30000.0, "nu": 0.2, "ft": 3.0, "Gf": 0.0015},
        "stage": [{"control": "driven", "to": 0.012, "steps": 60}],
        "output": {"frames": 0},
    }
    return Scene(data).with_(**{key.replace("__", "."): value for key, value in changes.items()})
