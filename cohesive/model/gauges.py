"""What is measured: gauges as linear measures of the displacements of the nodes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from meshing.specimens import Gauge, Specimen
from meshing.specimens.base import MAIN_GAUGE

from ..arrays import Array, Index
from ..elements.interface import Interface
from ..elements.rotations import rotations
from ..errors import SceneError
from .boundary import nodes_at
from .mesh import CrackedMesh

#: a node lies on one side of a crack if the elements around it do: sum of the ways to their centres along the direction across
#: the crack, over the sum of their sizes; 1 on a face square to it, 0.7 on one at 45 degrees, about 0 inside the body
_ONE_SIDED = 0.4


def measures(specimen: Specimen, gauges: Mapping[str, Gauge], mesh: CrackedMesh, faces: Interface | None) -> dict[str, Array]:
    """Opening and sliding of the main gauge, then the motion of each further gauge, as linear measures of the nodes'
    displacements, (d m,) each.

    A further gauge between the sides of a crack is left out if the mesh has no such sides, as a body without its crack.

    Parameters
    ----------
    gauges : of the specimen; without a main gauge the mean jump over the crack is the opening.
    faces : those of the crack path, if there is one.

    Raises
    ------
    SceneError
        If nothing tells what the opening is, or a gauge does not measure anything.
    """
    main = gauges.get(MAIN_GAUGE)
    rows = _mean_jump(specimen, mesh, faces) if main is None else _opening_and_sliding(main, mesh, faces)
    for name, gauge in gauges.items():
        motion = None if gauge is main else _relative_motion(gauge, mesh, faces, f"gauges.{name}")
        if motion is not None:
            rows[name] = motion[0]
    return rows


def _mean_jump(specimen: Specimen, mesh: CrackedMesh, faces: Interface | None) -> dict[str, Array]:
    if faces is None:
        keys = [f"specimen.{key}" for key in ("gauge_minus", "gauge_plus", "gauge") if hasattr(specimen, key)]
        why = "this band has no faces whose mean jump could be the opening; expected"
        if not keys:
            raise SceneError.at("band.where", f" = 'everywhere': {why} 'path', or a kind with a gauge")
        raise SceneError(f"{', '.join(keys)}: {why} a gauge", keys[0])
    return {
        name: faces.jump_operator.T @ np.kron(faces.weights / faces.area, unit)
        for name, unit in zip(("opening", "sliding"), np.eye(mesh.dimension), strict=False)
    }


def _opening_and_sliding(gauge: Gauge, mesh: CrackedMesh, faces: Interface | None) -> dict[str, Array]:
    """Of the main gauge."""
    motion = _relative_motion(gauge, mesh, faces, "gauge")
    if motion is None:
        raise SceneError.at("specimen.gauge_minus", ", specimen.gauge_plus: both name the same nodes; expected two places")
    return dict(zip(("opening", "sliding"), motion, strict=True))


def _relative_motion(gauge: Gauge, mesh: CrackedMesh, faces: Interface | None, key: str) -> tuple[Array, Array] | None:
    """Motion of one location against another one, or against its mirror image, which opens alike and slides with it; None if
    it is one location and no crack parts it. The second motion is that along the first tangent of
    `elements.rotations.rotations`."""
    plus = nodes_at(mesh, _key(key, "plus"), gauge.plus)
    if gauge.minus is None:  # without the nodes that stand for the mirror image
        plus = minus = plus[np.isin(plus, np.concatenate([block.data.ravel() for block in mesh.bulk]))]
    else:
        minus = nodes_at(mesh, _key(key, "minus"), gauge.minus)
    apart = mesh.points[plus].mean(axis=0) - mesh.points[minus].mean(axis=0)
    normal = np.asarray(_normal(gauge, mesh, faces, apart, key))
    if gauge.minus == gauge.plus:
        plus, minus = _sides(mesh, plus, normal)
        if not len(plus) or not len(minus):
            return None
    elif gauge.minus is not None and np.array_equal(plus, minus):
        return None
    first, second = rotations(normal[None])[0, :2]
    opens = 1.0 if gauge.minus is None else -1.0
    return _row(mesh, plus, minus, first, opens), _row(mesh, plus, minus, second, -1.0)


def _key(key: str, side: str) -> str:
    return f"{key}_{side}" if key == "gauge" else f"{key}.{side}"


def _row(mesh: CrackedMesh, plus: Index, minus: Index, direction: Array, sign: float) -> Array:
    """Mean motion of some nodes along a direction, and `sign` times that of others, (d m,)."""
    row = np.zeros(mesh.points.size)
    for nodes, factor in ((plus, 1.0), (minus, sign)):
        for axis in range(mesh.dimension):
            np.add.at(row, mesh.dimension * nodes + axis, factor * direction[axis] / len(nodes))
    return row


def _sides(mesh: CrackedMesh, nodes: Index, direction: Array) -> tuple[Index, Index]:
    """The nodes whose elements lie along a direction (unit vector), and those whose elements lie against it; those of a row
    lie between the sides."""
    nodes = np.unique(nodes)
    lean, size = np.zeros(len(nodes)), np.zeros(len(nodes))
    for block in mesh.bulk if mesh.is_row else [*mesh.bulk, *mesh.band]:
        cell, column = np.nonzero(np.isin(block.data, nodes))
        at = np.searchsorted(nodes, block.data[cell, column])
        away = (mesh.points[block.data[cell]].mean(axis=1) - mesh.points[nodes[at]]) @ direction
        np.add.at(lean, at, away)
        np.add.at(size, at, abs(away))
    lean /= np.maximum(size, 1e-300)
    return nodes[lean > _ONE_SIDED], nodes[lean < -_ONE_SIDED]


def _normal(gauge: Gauge, mesh: CrackedMesh, faces: Interface | None, apart: Array, key: str) -> Array:
    """Direction of the motion: as given, else the crack's mean normal, from minus to plus."""
    if gauge.direction is not None:
        return np.array(gauge.direction)
    mean = apart if faces is None else faces.weights @ faces.normals / faces.area
    length = np.hypot.reduce(mean)
    if length < 1e-9:
        expected = "leave the gauge out" if key == "gauge" else "give it a direction"
        raise SceneError.at(f"specimen.{key}", f": the crack has no mean normal to measure along; {expected}")
    return np.asarray((-1.0 if mean @ apart < 0 else 1.0) * mean / length)
