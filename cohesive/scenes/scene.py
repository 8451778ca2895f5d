"""Scenes: the declarative input, as TOML or Python. Every error names its key."""

from __future__ import annotations

import copy
import json
import math
import reprlib
import tomllib
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from meshing import (
    MeshError,
    MeshSizes,
    MixedModePlate,
    NotchedBeam,
    NotchedBeam3D,
    NotchedTension,
    PushOff,
    PushOff3D,
    SandwichPanel,
    SingleCrack,
    SingleCrack3D,
)
from meshing.paths import path_length
from meshing.solids import Extruded

from ..errors import SceneError
from ..law.concrete import PRESETS, Concrete
from ..solver.stages import Stage
from .checks import build_table, check_known, hint, is_a, table_of
from .tables import BandOptions, InterfaceOptions, ModelOptions, OutputOptions, ReferenceOptions, SolverOptions, UserMesh

Specimen = NotchedBeam | NotchedTension | MixedModePlate | SandwichPanel | PushOff | SingleCrack | SingleCrack3D | UserMesh

SPECIMENS: dict[str, type[Specimen]] = {
    "notched-beam": NotchedBeam,
    "notched-tension": NotchedTension,
    "mixed-mode-plate": MixedModePlate,
    "sandwich-panel": SandwichPanel,
    "push-off": PushOff,
    "single-crack": SingleCrack,
    "notched-beam-3d": NotchedBeam3D,
    "push-off-3d": PushOff3D,
    "single-crack-3d": SingleCrack3D,
    "mesh": UserMesh,
}

#: default element sizes: elements along the crack, elements to E Gf / ft^2, and the far size over the crack size
ELEMENTS_ALONG, ELEMENTS_IN_ZONE, COARSENING = 25, 15, 8.0

#: elements along either side of a crack surface that no path describes: twice as many would make an iteration 64 times dearer
ELEMENTS_ON_SIDE = 12

_TABLES = ("title", "specimen", "mesh", "material", "interface", "model", "band", "stage", "solver", "reference", "output")


class Scene:
    """One simulation, described by a nested dict with the keys of the TOML file.

    Parameters
    ----------
    data : mapping
    folder : where the files that the scene names are looked for.

    Raises
    ------
    SceneError
        Naming the key that is missing, unknown, of the wrong type or out of range.

    Attributes
    ----------
    data : dict, as given (a copy)
    title, specimen, sizes, material, interface, model, band, stages, solver, reference, output : checked parts
    """

    def __init__(self, data: Mapping[str, Any], folder: str | Path = ".") -> None:
        if not isinstance(data, Mapping):
            raise SceneError(f"Scene({data!r}): expected a dict with the tables of a scene; Scene.load(name) reads files")
        self.data: dict[str, Any] = _plain(data)
        self.folder = Path(folder)
        check_known("", self.data, _TABLES)
        self.title = self.data.get("title", "untitled")
        if not isinstance(self.title, str):
            raise SceneError(f"title = {self.title!r}: expected a string")
        table = table_of(self.data, "specimen", required=True)
        kind = table.pop("kind", None)
        if kind is None:
            raise SceneError(f"specimen.kind is missing: expected one of {', '.join(SPECIMENS)}")
        if not isinstance(kind, str) or kind not in SPECIMENS:
            names = ", ".join(SPECIMENS)
            raise SceneError(f"specimen.kind = {reprlib.repr(kind)}: expected one of {names}{hint(kind, SPECIMENS)}")
        self.kind: str = kind
        self.specimen: Specimen = build_table(SPECIMENS[kind], table, "specimen")
        if kind == "mesh":
            if "mesh" in self.data:
                raise SceneError("mesh: a specimen of kind 'mesh' brings its own mesh; expected no [mesh] table")
            self.sizes = None
        self.material = _material(table_of(self.data, "material", required=True))
        if not isinstance(self.specimen, UserMesh):
            self.sizes = build_table(MeshSizes, self._sizes(table_of(self.data, "mesh")), "mesh")
        self.interface = build_table(InterfaceOptions, table_of(self.data, "interface"), "interface")
        self.model = build_table(ModelOptions, table_of(self.data, "model"), "model")
        self.band = build_table(BandOptions, table_of(self.data, "band"), "band")
        if self.band.width is not None and (kind == "mesh" or self.band.where == "everywhere"):
            what = "a mesh of your own" if kind == "mesh" else "band.where = 'everywhere'"
            raise SceneError(f"band.width = {self.band.width:g}: with {what} the elements give it; expected no width")
        self.solver = build_table(SolverOptions, table_of(self.data, "solver"), "solver")
        self.output = build_table(OutputOptions, table_of(self.data, "output"), "output")
        self.reference = (
            build_table(ReferenceOptions, table_of(self.data, "reference"), "reference") if "reference" in self.data else None
        )
        if isinstance(self.specimen, SingleCrack3D) and self.model.plane == "strain":
            raise SceneError("model.plane = 'strain': a single-crack-3d is no plane body; expected no such key")
        if self.sizes is not None and self.model.kind == "smeared" and self.band.where == "path":
            self._check_band(self.sizes)
        if self.model.half and self.model.kind == "smeared":
            raise SceneError(
                "model.half = true: the crack band lies on both sides of the crack; expected false with 'smeared'"
            )
        if self.model.half and not getattr(self.specimen, "is_symmetric", False):
            raise SceneError(
                f"model.half = true: this {kind} is not symmetric about its crack; expected a notched-beam or "
                "notched-beam-3d with its notch at mid-span, or a notched-tension, with the default crack path"
            )
        if self.reference is not None and not self.file(self.reference.file).is_file():
            raise SceneError(f"reference.file = {self.reference.file!r}: there is no file {self.file(self.reference.file)}")
        stages = self.data.get("stage")
        if not isinstance(stages, list) or not stages or not all(isinstance(entry, dict) for entry in stages):
            raise SceneError("stage is missing or not a list of tables: expected at least one [[stage]]")
        self.stages = [build_table(Stage, dict(entry), f"stage.{i}") for i, entry in enumerate(stages)]

    @classmethod
    def load(cls, source: str | Path) -> Scene:
        """A scene from a TOML file, or a built-in one by name (see `built_in`).

        Raises
        ------
        SceneError
            If there is no such file or name, or the file is not TOML.
        """
        if not isinstance(source, (str, Path)):
            raise SceneError(
                f"Scene.load({source!r}): expected a file or the name of a built-in scene; Scene(dict) takes a dict"
            )
        path = Path(source)
        if not path.is_file() and path.suffix != ".toml":
            names = built_in()
            if str(source) not in names:
                raise SceneError(
                    f"scene '{source}': no such file, and no built-in scene of that name; built in are "
                    f"{', '.join(names)}{hint(str(source), names)}"
                )
            path = Path(str(_SCENES / f"{source}.toml"))
        try:
            data = tomllib.loads(path.read_text(encoding="utf-8"))
        except OSError as error:
            raise SceneError(f"scene '{source}': cannot be read: {error.strerror}") from None
        except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
            raise SceneError(f"scene '{source}': not valid TOML: {error}") from None
        return cls(data, path.parent)

    def with_(self, **changes: Any) -> Scene:
        """A copy with some dotted keys changed, `scene.with_(**{"material.Gf": 0.07, "stage.0.to": 0.1})`.

        Raises
        ------
        SceneError
            Naming the key.
        """
        data = copy.deepcopy(self.data)
        for key, value in changes.items():
            *path, last = key.split(".")
            place: Any = data
            for part in path:
                if isinstance(place, dict):
                    place = place.setdefault(part, {})
                else:
                    place = _item(key, place, part)
            if isinstance(place, dict):
                place[last] = value
            elif isinstance(place, list) and last.isdigit() and int(last) < len(place):
                place[int(last)] = value
            else:
                raise SceneError(f"{key}: there is no such key in the scene")
        return Scene(data, self.folder)

    def _check_band(self, sizes: MeshSizes) -> None:
        """Refuse a crack band that the specimen does not have."""
        assert not isinstance(self.specimen, UserMesh)
        try:
            self.specimen.check_band(sizes)
        except MeshError as error:
            raise SceneError(str(error)) from None

    @property
    def is_solid(self) -> bool:
        """Whether a built-in specimen is modelled in three dimensions."""
        return isinstance(self.specimen, (Extruded, SingleCrack3D))

    @property
    def crack_length(self) -> float:
        """Length of the crack path of a built-in specimen, mm; of a crack without one the root of its area."""
        assert not isinstance(self.specimen, UserMesh)
        if isinstance(self.specimen, SingleCrack3D):
            return math.sqrt(self.specimen.crack_area)
        try:
            return path_length("crack", self.specimen.paths)
        except MeshError as error:
            raise SceneError(f"specimen.{error}") from None

    @property
    def crack_area(self) -> float:
        """Area of the crack of a built-in specimen, mm^2."""
        if isinstance(self.specimen, SingleCrack3D):
            return self.specimen.crack_area
        assert self.specimen.thickness is not None
        return self.crack_length * self.specimen.thickness

    def _sizes(self, table: dict[str, Any]) -> dict[str, Any]:
        """[mesh] with the sizes that it leaves out: enough elements along the crack and within its process zone."""
        if "crack_size" not in table:
            along = ELEMENTS_ON_SIDE if isinstance(self.specimen, SingleCrack3D) else ELEMENTS_ALONG
            table["crack_size"] = min(self.crack_length / along, self.material.characteristic_length / ELEMENTS_IN_ZONE)
        if "far_size" not in table and is_a(table["crack_size"], float):
            table["far_size"] = COARSENING * table["crack_size"]
        return table

    @property
    def band_width(self) -> float:
        """Width of the band along the path of a built-in specimen, mm: the crack size, where the scene names none."""
        assert self.sizes is not None
        return self.sizes.crack_size if self.band.width is None else self.band.width

    def file(self, name: str) -> Path:
        """A file that the scene names: beside it, or one that comes with the built-in scenes."""
        beside, bundled = self.folder / name, Path(str(_SCENES / Path(name).name))
        return bundled if not beside.exists() and bundled.is_file() else beside


_SCENES = resources.files("cohesive.scenes") / "builtin"


def built_in() -> list[str]:
    """Names of the built-in scenes."""
    return sorted(entry.name[:-5] for entry in _SCENES.iterdir() if entry.name.endswith(".toml"))


def _plain(value: Any) -> Any:
    """A copy with the dicts, lists and numbers of TOML, out of NumPy's and other mappings and sequences."""
    if isinstance(value, Mapping):
        return {key: _plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(entry) for entry in value]
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    return value


def dump_toml(data: Mapping[str, Any]) -> str:
    """A scene's dict as TOML text."""
    lines = [f"{key} = {_toml(value)}" for key, value in data.items() if not _is_tables(value)]
    for name, value in data.items():
        if _is_tables(value):
            for table in value if isinstance(value, list) else [value]:
                lines += ["", f"[[{name}]]" if isinstance(value, list) else f"[{name}]"]
                lines += [f"{key} = {_toml(entry)}" for key, entry in table.items() if entry is not None]
    return "\n".join(lines) + "\n"


def _is_tables(value: Any) -> bool:
    return isinstance(value, dict) or (isinstance(value, list) and bool(value) and isinstance(value[0], dict))


def _toml(value: Any) -> str:
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key} = {_toml(entry)}" for key, entry in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_toml, value)) + "]"
    return json.dumps(value)  # TOML's strings, numbers and booleans are JSON's


def _item(key: str, place: Any, part: str) -> Any:
    if isinstance(place, list) and part.isdigit() and int(part) < len(place):
        return place[int(part)]
    raise SceneError(f"{key}: there is no such key in the scene")


def _material(table: dict[str, Any]) -> Concrete:
    preset = table.pop("preset", None)
    if preset is not None:
        if not isinstance(preset, str) or preset not in PRESETS:
            raise SceneError(f"material.preset = {reprlib.repr(preset)}: expected one of {', '.join(PRESETS)}")
        table = {**PRESETS[preset], **table}
    return build_table(Concrete, table, "material")
