"""What holds, drives and measures a body, as marks for its picture and its table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from meshing.specimens import Specimen
from meshing.specimens.base import MAIN_GAUGE, Direction, Location

from ..arrays import Array
from .boundary import nodes_at
from .mesh import CrackedMesh
from .setup import Setup

SUPPORT, DRIVE, GAUGE, PRESSURE = "held", "driven", "measured", "pressed"


@dataclass(frozen=True)
class Mark:
    """One thing that is done to a body, or measured on it.

    Attributes
    ----------
    kind : SUPPORT, DRIVE, GAUGE or PRESSURE
    name : of the drive or gauge, or the location
    points : (k, d) array, mm, where it is
    directions : (n, d) array of unit vectors: those held, moved or measured; empty for the crack's mean normal
    others : (l, d) array, mm, the location against which it moves or is measured; empty if there is none
    text : a phrase for the table
    """

    kind: str
    name: str
    points: Array
    directions: Array
    others: Array
    text: str


def marks(specimen: Specimen, mesh: CrackedMesh, plane: str, half: bool) -> list[Mark]:
    """All marks of a specimen; SceneError for a location that is not in the mesh."""
    setup = Setup.from_specimen(specimen, mesh, plane, half)
    return [
        *_supports(setup, mesh),
        *_drives(setup, mesh),
        *_gauges(setup, mesh),
        *_pressures(specimen, mesh),
    ]


def _supports(setup: Setup, mesh: CrackedMesh) -> list[Mark]:
    """One mark for each location that is held, with all its directions."""
    by_location: dict[str, Mark] = {}
    for support in setup.supports:
        name, along = _place(support.at), support.direction
        directions = np.eye(mesh.dimension) if along is None else np.array([along])
        gives = "" if support.stiffness is None else f", gives way by 1 mm under {support.stiffness:.4g} N"
        rotates = "" if support.lever is None else ", rotates freely"
        own = Mark(SUPPORT, name, _points(mesh, "supports.at", support.at), directions, _none(mesh), gives + rotates)
        if name in by_location:
            before = by_location[name]
            own = replace(own, directions=np.concatenate([before.directions, directions]), text=before.text + own.text)
        by_location[name] = own
    if setup.normal is not None and mesh.crack is not None:
        crack = mesh.points[np.unique(mesh.crack.data)]
        by_location[""] = Mark(
            SUPPORT, "the plane of symmetry", crack, np.array([setup.normal]), _none(mesh), ", where the crack opens"
        )
    return [replace(mark, text=f"along {_vectors(mark.directions)}{mark.text}") for mark in by_location.values()]


def _drives(setup: Setup, mesh: CrackedMesh) -> list[Mark]:
    drawn = []
    for name, drive in setup.drives.items():
        vectors = [each for each in (drive.direction, drive.shear) if each is not None]
        others, where = _none(mesh), _place(drive.at)
        if drive.against is not None:
            others, where = _points(mesh, "drive.at", drive.against), f"{where} against {_place(drive.against)}"
        at, directions = _points(mesh, "drive.at", drive.at), np.array(vectors, dtype=float)
        drawn.append(Mark(DRIVE, name, at, directions, others, f"{where} along {_vectors(directions, ' or ')}"))
    return drawn


def _gauges(setup: Setup, mesh: CrackedMesh) -> list[Mark]:
    drawn = []
    for name, gauge in setup.gauges.items():
        plus = _points(mesh, "gauge", gauge.plus)
        if gauge.minus is None:
            others, where = _none(mesh), f"{_place(gauge.plus)} against its mirror image"
        elif gauge.minus == gauge.plus:
            others, where = plus, f"the sides of the crack at {_place(gauge.plus)}"
        else:
            others, where = _points(mesh, "gauge", gauge.minus), f"{_place(gauge.plus)} against {_place(gauge.minus)}"
        directions = np.zeros((0, mesh.dimension)) if gauge.direction is None else np.array([gauge.direction])
        text = f"{where} along {_vectors(directions) if len(directions) else 'the mean normal of the crack'}"
        drawn.append(Mark(GAUGE, name, plus, directions, others, text))
    if MAIN_GAUGE not in setup.gauges and mesh.faces is not None:
        none = _none(mesh)
        drawn.insert(0, Mark(GAUGE, MAIN_GAUGE, none, none, none, "the mean jump over the crack"))
    return drawn


def _pressures(specimen: Specimen, mesh: CrackedMesh) -> list[Mark]:
    drawn = []
    for pressure in specimen.pressures():
        at = _points(mesh, "pressures.at", pressure.at)
        drawn.append(
            Mark(PRESSURE, pressure.at, at, _none(mesh), _none(mesh), f"by {pressure.value:g} MPa from the beginning")
        )
    return drawn


def _points(mesh: CrackedMesh, key: str, at: Location) -> Array:
    points: Array = mesh.points[nodes_at(mesh, key, at)]
    return points


def _none(mesh: CrackedMesh) -> Array:
    return np.zeros((0, mesh.dimension))


def _place(at: Location) -> str:
    return at if isinstance(at, str) else _vector(at)


def _vectors(vectors: Array, between: str = " and ") -> str:
    return between.join(_axis(vector) or _vector(vector) for vector in vectors)


def _axis(vector: Sequence[float] | Array) -> str:
    """x, -y ... for a vector along an axis; empty for another one."""
    large = [i for i, component in enumerate(vector) if abs(component) > 1e-9]
    return ("-" if vector[large[0]] < 0 else "") + "xyz"[large[0]] if len(large) == 1 else ""


def _vector(vector: Direction | Array) -> str:
    return f"({', '.join(f'{component:.4g}' for component in vector)})"
