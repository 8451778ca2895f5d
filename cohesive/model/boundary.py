"""From what a specimen says of itself to constraints on the nodes of its mesh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshing.specimens import Drive, Support
from meshing.specimens.base import Direction, Location

from ..algebra.unknowns import Constraint
from ..arrays import Array, Index
from ..errors import SceneError
from ..solver.loading import Actuator
from .mesh import CrackedMesh
from .setup import Setup


@dataclass(frozen=True)
class Boundary:
    """Constraints of a body.

    Attributes
    ----------
    supports : list of Constraint
    motions : list of Constraint, each a motion of its own: those of the drives, then those of supports that give way
    mirror : Constraint, the plane of symmetry of a half; None for a whole body
    drives : what each drive does with the motions
    acting, later : (motions,) arrays, stiffness of springs that act from the beginning, or where a platen is let go, N/mm
    """

    supports: list[Constraint]
    motions: list[Constraint]
    mirror: Constraint | None
    drives: dict[str, Actuator]
    acting: Array
    later: Array


def boundary(setup: Setup, mesh: CrackedMesh, half: bool) -> Boundary:
    """Where a specimen is held and driven; SceneError for a location that is not in the mesh, or a direction with another
    number of components."""
    supports: list[Constraint] = []
    yielding: list[Constraint] = []
    acting: list[float] = []
    for support in setup.supports:
        constraints = _support(mesh, support)
        if support.stiffness is None:
            supports += constraints
        else:
            yielding += constraints
            acting += [support.stiffness * (2.0 if half else 1.0)] * len(constraints)  # the energy of a half is doubled
    motions: list[Constraint] = []
    drives: dict[str, Actuator] = {}
    later: list[float] = []
    for name, drive in setup.drives.items():
        own = _drive(mesh, drive)
        drives[name] = Actuator(tuple(range(len(motions), len(motions) + len(own))), is_platen=drive.shear is not None)
        motions += own
        later += [drive.spring, *(0.0 for _ in own[1:])]
    mirror = None
    if setup.normal is not None and mesh.faces is not None:
        mirror = Constraint("crack", np.unique(mesh.faces.data), setup.normal)
    none = np.zeros(len(motions))
    springs = (np.append(none, acting), np.append(later, np.zeros(len(yielding))))
    return Boundary(supports, [*motions, *yielding], mirror, drives, *springs)


def _support(mesh: CrackedMesh, support: Support) -> list[Constraint]:
    axes = [tuple(axis) for axis in np.eye(mesh.dimension).tolist()]
    directions = axes if support.direction is None else [_components(mesh, "supports.direction", support.direction)]
    nodes = nodes_at(mesh, "supports.at", support.at)
    lever = _lever(mesh, nodes, support.lever)
    return [Constraint(_name(support.at, "supports"), nodes, direction, lever=lever) for direction in directions]


def _drive(mesh: CrackedMesh, drive: Drive) -> list[Constraint]:
    """Its motions: one, or two of a platen or of opposed forces."""

    def motion(at: Location, direction: Direction, lever: float | None, holds: bool | None) -> Constraint:
        nodes = nodes_at(mesh, "drive.at", at)
        along = _components(mesh, "drive.direction", direction)
        return Constraint(_name(at, "drive"), nodes, along, drive.share, _lever(mesh, nodes, lever), holds)

    motions = [motion(drive.at, drive.direction, drive.lever, drive.holds_jumps)]
    if drive.shear is not None:
        motions.append(motion(drive.at, drive.shear, None, None))
    elif drive.against is not None:
        motions.append(motion(drive.against, drive.against_direction or drive.direction, drive.lever, drive.holds_jumps))
    return motions


def _lever(mesh: CrackedMesh, nodes: Index, half_length: float | None) -> Array | None:
    """Distances of nodes from the hinge of their face, over the largest one."""
    return None if half_length is None else mesh.points[nodes, 0] / half_length


def _name(at: Location, otherwise: str) -> str:
    return at if isinstance(at, str) else otherwise


def _components(mesh: CrackedMesh, key: str, vector: Direction) -> Direction:
    """A vector, refused if it has not as many components as the mesh has dimensions."""
    if len(vector) != mesh.dimension:
        kind, expected = ("solid", "three") if mesh.dimension == 3 else ("plane", "two")
        raise SceneError.at(
            f"specimen.{key}", f" = {[round(c, 6) for c in vector]}: the mesh is {kind}; expected {expected} numbers"
        )
    return vector


def nodes_at(mesh: CrackedMesh, key: str, at: Location) -> Index:
    """Nodes of a location: a set by name, or the copies of the node that was at a point before a band was opened."""
    if isinstance(at, str):
        if at not in mesh.sets:
            names = ", ".join(sorted(mesh.sets)) or "none"
            raise SceneError.at(f"specimen.{key}", f" = {at!r}: the mesh has no such set; it has {names}")
        return np.asarray(mesh.sets[at])
    _components(mesh, key, at)
    distance = np.linalg.norm(mesh.closed - np.asarray(at), axis=1)
    size = float(np.ptp(mesh.points, axis=0).max())
    if distance.min() > 1e-6 * size:
        raise SceneError.at(
            f"specimen.{key}", f" = {list(at)}: the nearest node is {distance.min():.3g} mm away; expected a node there"
        )
    return np.flatnonzero(distance < 1e-6 * size)
