"""A plate with a crack plane across its middle, pulled: what every file of it must carry."""

from __future__ import annotations

from pathlib import Path

from cohesive import Scene

#: stiffness of an elastic plate 100 x 60 x 20 mm with a crack plane of width w across its middle: E A / (H + w)
E, WIDTH, MOTION = 30e3, 0.5, 0.005
LOAD = E * 100.0 * 20.0 * MOTION / (60.0 + WIDTH)


def scene(path: Path, **specimen: object) -> Scene:
    """Of a file with the sets bottom, top and fault; `specimen`: further keys, or others."""
    supports = [{"at": "bottom", "direction": [0, 1]}, {"at": [0, 0], "direction": [1, 0]}]
    plate = {"kind": "mesh", "file": str(path), "thickness": 20.0, "crack": "fault", "supports": supports}
    return Scene(
        {
            "specimen": plate | {"drive": {"at": "top", "direction": [0, 1]}} | specimen,
            "material": {"E": E, "nu": 0.2, "ft": 3.0, "Gf": 0.1},
            "interface": {"width": WIDTH},
            "stage": [{"control": "driven", "to": MOTION, "steps": 1}],
        }
    )
