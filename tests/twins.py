"""Twins of a scene, whose histories follow from its own: mirrored, in other units, of another thickness."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import meshio
import numpy as np

from cohesive import Scene
from cohesive.solver.columns import COLUMNS
from meshing.cells import CELLS
from meshing.specimens.registry import SPECIMENS, register_specimen

#: factors of units, from that of a length and that of a stress
_UNITS = {
    "mm": (1, 0), "MPa": (0, 1), "N": (2, 1), "N/mm": (1, 1), "N mm": (3, 1), "kg/m^3": (-1, 1), "": (0, 0), "degrees": (0, 0),
    "Zm": (0, 0), "s": (0, 0),
}  # fmt: skip

#: columns that a twin may have otherwise: how the step was found
_FREE = ("iterations", "cuts", "residual", "wall_time")

#: node orders of quadrilaterals turned about, first edge first: that of a crack cell or a row is its minus face
_TURNED = {"quad": [1, 0, 3, 2], "quad8": [1, 0, 3, 2, 4, 7, 6, 5]}


@dataclass(frozen=True)
class Twin:
    """A scene and what its history is to the history of the one it was made of.

    Attributes
    ----------
    factors : by column; 1 for one that is not named
    """

    scene: Scene
    factors: dict[str, float]

    def difference(self, own: dict[str, Any], history: dict[str, Any]) -> float:
        """Largest difference of the twin's history from what follows from a scene's own, in parts of each column's scale;
        infinite if they differ in rows."""
        if len(own["load"]) != len(history["load"]):
            return float(np.inf)
        scales = {"sliding": "driven", "stored": "work", "contact_work": "work", "released": "work"}
        worst = 0.0
        for name, column in history.items():
            if name in _FREE or not np.isfinite(column).all():
                continue
            factor = self.factors.get(name, 1.0)
            of = [name, *([scales[name]] if name in scales else [])]
            scale = float(max(abs(history[each]).max() for each in of))
            if name.startswith("stress"):  # their means may be rounding
                scale = max(scale, self.scene.material.ft)
            if scale > 0:
                worst = max(worst, float(abs(column - factor * own[name]).max()) / scale)
        return worst


def scaled(scene: Scene, length: float, stress: float) -> Twin:
    """The scene in other units: all lengths and stresses by factors. Powers of two keep every bit of its numbers."""

    def by(unit: str) -> float:
        powers = _UNITS[unit]
        return float(length ** powers[0] * stress ** powers[1])

    data = {name: dict(table) for name, table in scene.data.items() if isinstance(table, dict)}
    for name, table in (("specimen", scene.specimen), ("material", scene.material)):
        for each in fields(table):
            unit, value = each.metadata.get("unit", ""), data[name].get(each.name)
            if unit and value is not None:
                data[name][each.name] = _times(value, by(unit))
    material = scene.material
    data["material"] = {"h": material.h * by("mm")} | data["material"] | {"unusual": True}
    for table, key in (("mesh", "crack_size"), ("mesh", "far_size"), ("interface", "width"), ("band", "width")):
        if key in data.get(table, {}):
            data[table][key] *= by("mm")
    controls = {"load": by("N"), "dissipation": by("N mm")}
    stages = [{**stage, "to": _times(stage["to"], controls.get(stage["control"], by("mm")))} for stage in scene.data["stage"]]
    rest = {name: value for name, value in scene.data.items() if name not in data}
    factors = {column.name: by(column.unit) for column in COLUMNS}
    factors |= {name: by("mm") for name in scene.specimen.gauges() if name not in factors}
    factors |= {name: by("N") for name in scene.specimen.forces()}
    for name in scene.specimen.drives():
        factors |= {f"load.{name}": by("N"), f"driven.{name}": by("mm")}
    return Twin(Scene({**rest, **data, "stage": stages}, scene.folder), factors)


def _times(value: Any, factor: float) -> Any:
    return [_times(each, factor) for each in value] if isinstance(value, (list, tuple)) else value * factor


def thicker(scene: Scene, by: float) -> Twin:
    """A plane scene of so many times the thickness: its forces and energies, and those of its springs, are so many times."""
    specimen = scene.data["specimen"]
    keys = {"specimen.thickness": by * scene.specimen.thickness}  # type: ignore[operator]
    for each in fields(scene.specimen):
        if each.metadata.get("unit") == "N/mm" and specimen.get(each.name) is not None:
            keys[f"specimen.{each.name}"] = by * specimen[each.name]
    stages = [
        {**stage, "to": _times(stage["to"], by)} if stage["control"] in ("load", "dissipation") else stage
        for stage in scene.data["stage"]
    ]
    factors = {column.name: by for column in COLUMNS if column.unit in ("N", "N mm")}
    factors |= dict.fromkeys(scene.specimen.forces(), by) | {f"load.{name}": by for name in scene.specimen.drives()}
    return Twin(scene.with_(**keys, stage=stages), factors)


def mirrored(scene: Scene) -> Twin:
    """A plane scene in a mirror, x for -x, on the mirrored mesh: it slides the other way."""
    kind = scene.kind
    name = f"{kind} in a mirror"
    if name not in SPECIMENS:
        register_specimen(name)(_mirrored(SPECIMENS[kind]))
    twin = scene.with_(specimen={**scene.data["specimen"], "kind": name})
    return Twin(twin, {"sliding": -1.0, "stress_s": -1.0})


def _mirrored(kind: type[Any]) -> type[Any]:
    """A kind of specimen with all that it says in a mirror."""

    def own(self: Any) -> Any:
        return kind(**{each.name: getattr(self, each.name) for each in fields(self)})

    def meshes(name: str) -> Any:
        return lambda self, *given, **options: _mirrored_mesh(getattr(own(self), name)(*given, **options))

    def places(name: str) -> Any:
        def told(self: Any, **options: Any) -> Any:
            found = getattr(own(self), name)(**options)
            if isinstance(found, dict):
                return {key: _mirrored_place(each) for key, each in found.items()}
            return [_mirrored_place(each) for each in found]

        return told

    body: dict[str, Any] = {name: meshes(name) for name in ("mesh", "mesh_band", "mesh_body")}
    body |= {name: places(name) for name in ("held", "drives", "gauges")}
    body["paths"] = property(lambda self: [[(-x, y) for x, y in line] for line in own(self).paths])
    body["symmetry"] = lambda self: _mirrored_vector(own(self).symmetry())
    body["__module__"] = __name__
    made: type[Any] = dataclass(frozen=True)(type(f"Mirrored{kind.__name__}", (kind,), body))
    return made


def _mirrored_vector(vector: Any) -> Any:
    return (-vector[0], *vector[1:]) if isinstance(vector, tuple) else vector


def _mirrored_place(each: Any) -> Any:
    """A support, drive or gauge in a mirror: its vectors are tuples."""
    return type(each)(**{field.name: _mirrored_vector(getattr(each, field.name)) for field in fields(each)})


def _mirrored_mesh(mesh: meshio.Mesh) -> meshio.Mesh:
    mesh.points = mesh.points * [-1.0, 1.0]
    if "closed" in mesh.point_data:
        mesh.point_data["closed"] = mesh.point_data["closed"] * [-1.0, 1.0]
    for block in mesh.cells:
        block.data = block.data[:, _TURNED.get(block.type, list(CELLS[block.type].flip))]
    return mesh
