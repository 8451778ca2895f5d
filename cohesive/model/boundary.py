"""What holds, drives and measures each kind of specimen: ties and gauge on the named sets of its mesh."""

from __future__ import annotations

from typing import Any

import meshio
import numpy as np

from meshing import MixedModePlate, NotchedBeam, NotchedTension, SandwichPanel, SingleCrack, SingleCrack3D

from ..algebra.unknowns import Constraint
from ..arrays import Array, Index
from ..elements.interface import Interface
from ..elements.rotations import rotations
from ..errors import SceneError
from ..scenes.scene import Scene
from ..scenes.tables import UserMesh


def ties(scene: Scene, mesh: meshio.Mesh) -> tuple[list[Constraint], list[Constraint], Constraint | None]:
    """Supports and drives of a specimen, and its plane of symmetry where half of it is modelled."""
    specimen, sets, d = scene.specimen, mesh.point_sets, mesh.points.shape[1]
    x, y, *_ = axes = [tuple(axis) for axis in np.eye(d).tolist()]
    if isinstance(specimen, NotchedBeam):
        # jumps below the load are free: both faces carry it, in space as in the plane
        drive = Constraint("load", sets["load"], tuple(-c for c in y), holds_jumps=False)
        supports = [Constraint("support_left", sets["support_left"], y), *_across(scene, sets, d)]
        if scene.model.half:
            return supports, [drive], Constraint("crack", np.unique(mesh.cells[-1].data), x)
        supports += [
            Constraint("support_left", sets["support_left"], x),
            Constraint("support_right", sets["support_right"], y),
        ]
        return supports, [drive], None
    if scene.model.half:
        plane = np.unique(mesh.cells[-1].data)
        # the plane of symmetry stays where it is, so the top moves by half of the drive
        return (
            [Constraint("top", sets["top"], x)],
            [Constraint("top", sets["top"], y, factor=0.5)],
            Constraint("crack", plane, y),
        )
    if isinstance(specimen, SandwichPanel):
        base, top = sets["base"], sets["top"]
        supports = [*(Constraint("base", base, axis) for axis in axes), *_across(scene, sets, d)]
        return supports, [Constraint("top", top, y), Constraint("top", top, x)], None
    if isinstance(specimen, NotchedTension):
        base, top = sets["base"], sets["top"]
        levers = [
            mesh.points[face, 0] / (specimen.width / 2) if specimen.platens == "hinged" else None for face in (base, top)
        ]
        supports = [Constraint("base", base, x), Constraint("base", base, y, lever=levers[0])]
        pull, push = Constraint("top", top, y, lever=levers[1]), Constraint("top", top, x)
        if isinstance(specimen, MixedModePlate):
            return supports, [pull, push], None
        return [*supports, push], [pull], None
    if isinstance(specimen, SingleCrack | SingleCrack3D):
        t = np.radians(specimen.drive_angle)
        along: tuple[float, ...] = (float(np.sin(t)), float(np.cos(t)))
        if isinstance(specimen, SingleCrack):
            along = specimen.turned(*along)
        others = [(along[1], -along[0]), *axes[2:]]
        if d == 3:
            along, others[0] = (*along, 0.0), (*others[0], 0.0)
        supports = [Constraint("base", sets["base"], along)]
        if specimen.faces == "free":
            supports.append(Constraint("base_corner", sets["base_corner"], others[0]))
            supports += [Constraint("pin", sets["pin"], axis) for axis in axes[2:]]
        else:
            supports += [Constraint(name, sets[name], other) for other in others for name in ("base", "top")]
        return supports, [Constraint("top", sets["top"], along)], None
    for key, (_, direction) in [*(("supports", entry) for entry in specimen.supports), ("drive", specimen.drive)]:
        _has_components(mesh, f"{key}.direction", direction)
    supports = [Constraint("supports", _nodes(mesh, "supports", at), direction) for at, direction in specimen.supports]
    return supports, [Constraint("drive", _nodes(mesh, "drive", specimen.drive[0]), specimen.drive[1])], None


def _across(scene: Scene, sets: dict[str, Index], d: int) -> list[Constraint]:
    """What holds an extruded specimen along its thickness: front and back in plane strain, else one node."""
    faces = ("back", "front") if scene.model.plane == "strain" else ("pin",)
    return [Constraint(name, sets[name], (0.0, 0.0, 1.0)) for name in faces] if d == 3 else []


def _nodes(mesh: meshio.Mesh, key: str, place: str | tuple[float, ...]) -> Index:
    """Nodes of a place in a user's mesh: a set by name, or the copies of the node at a point."""
    key = f"{key}.at" if key in ("supports", "drive") else key
    if isinstance(place, str):
        if place not in mesh.point_sets:
            names = ", ".join(sorted(mesh.point_sets)) or "none"
            raise SceneError(f"specimen.{key} = {place!r}: the mesh has no such set; it has {names}")
        return np.asarray(mesh.point_sets[place])
    _has_components(mesh, key, place)
    distance = np.linalg.norm(mesh.points - np.asarray(place), axis=1)
    size = float(np.ptp(mesh.points, axis=0).max())
    if distance.min() > 1e-6 * size:
        raise SceneError(
            f"specimen.{key} = {list(place)}: the nearest node is {distance.min():.3g} mm away; expected a node there"
        )
    return np.flatnonzero(distance < 1e-6 * size)


def _has_components(mesh: meshio.Mesh, key: str, vector: tuple[float, ...]) -> None:
    if len(vector) != mesh.points.shape[1]:
        kind, expected = ("solid", "three") if mesh.points.shape[1] == 3 else ("plane", "two")
        raise SceneError(f"specimen.{key} = {[round(c, 6) for c in vector]}: the mesh is {kind}; expected {expected} numbers")


def gauge(scene: Scene, mesh: meshio.Mesh, faces: Interface | None) -> dict[str, Array]:
    """Opening and sliding as linear measures of the mesh nodes' displacements, (d m,) each; `faces` are those of the
    crack path, if there is one. Sliding is that along the first tangent of `elements.rotations.rotations`."""
    specimen, d = scene.specimen, mesh.points.shape[1]
    if isinstance(specimen, UserMesh):
        has_gauge = specimen.gauge_minus is not None
    else:
        has_gauge = getattr(specimen, "gauge", 0.0) > 0
    mean = np.zeros(d) if faces is None else faces.weights @ faces.normals / faces.area
    if not has_gauge:  # the mean jump over the crack
        if faces is None:
            keys = "gauge_minus, specimen.gauge_plus" if isinstance(specimen, UserMesh) else "gauge"
            raise SceneError(f"specimen.{keys}: this band has no faces whose mean jump could be the opening; expected a gauge")
        return {
            name: faces.jump_operator.T @ np.kron(faces.weights / faces.area, unit)
            for name, unit in zip(("opening", "sliding"), np.eye(d), strict=False)
        }
    if isinstance(specimen, UserMesh):
        minus, plus = (_nodes(mesh, key, getattr(specimen, key)) for key in ("gauge_minus", "gauge_plus"))
    else:
        plus = mesh.point_sets["gauge_plus"]
        minus = mesh.point_sets.get("gauge_minus", plus)
    apart = mesh.points[plus].mean(axis=0) - mesh.points[minus].mean(axis=0)
    if faces is None and isinstance(specimen, SingleCrack | SingleCrack3D):
        normal = np.array(specimen.normal)
    elif faces is None and isinstance(specimen, UserMesh):  # without a path, from one place to the other
        normal = _gauge_normal(specimen, apart)
    else:
        normal = _gauge_normal(specimen, mean)
    if isinstance(specimen, UserMesh) and normal @ apart < 0:  # the opening grows where the places part
        normal = -normal
    measures = {}
    for name, direction in zip(("opening", "sliding"), rotations(normal[None])[0], strict=False):
        row = np.zeros(mesh.points.size)
        # the mirror image of the plus points opens as they do, and slides with them
        sides = (
            ((plus, 1.0), (minus, 1.0 if name == "opening" else -1.0)) if scene.model.half else ((plus, 1.0), (minus, -1.0))
        )
        for nodes, sign in sides:
            for axis in range(d):
                np.add.at(row, d * nodes + axis, sign * direction[axis] / len(nodes))
        if name == "opening" and not row.any():
            raise SceneError("specimen.gauge_minus, specimen.gauge_plus: both name the same nodes; expected two places")
        measures[name] = row
    return measures


def _gauge_normal(specimen: Any, mean: Array) -> Array:
    """Direction in which the gauge measures the opening: along the beam or plate, else the crack's mean normal."""
    axes = np.eye(len(mean))
    if isinstance(specimen, NotchedBeam):
        return np.asarray(-axes[0])
    if isinstance(specimen, NotchedTension):
        return np.asarray(axes[1])
    length = np.hypot.reduce(mean)
    if length < 1e-9:
        raise SceneError("specimen.gauge: the crack has no mean normal to measure along; leave the gauge out")
    return np.asarray(mean / length)
