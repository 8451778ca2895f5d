"""Scenes: the declarative input, as TOML or Python. Every error names its key."""

from __future__ import annotations

import copy
import difflib
import json
import math
import reprlib
import tomllib
import types
import typing
from collections.abc import Mapping
from dataclasses import MISSING, fields
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
from meshing.cracks import path_length
from meshing.solids import Extruded

from .concrete import PRESETS, Concrete
from .loading import Stage
from .options import BandOptions, InterfaceOptions, ModelOptions, OutputOptions, ReferenceOptions, SolverOptions, UserMesh


class SceneError(ValueError):
    """A scene that cannot be used; the message names the key, its value and what was expected."""


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
        _known("", self.data, _TABLES)
        self.title = self.data.get("title", "untitled")
        if not isinstance(self.title, str):
            raise SceneError(f"title = {self.title!r}: expected a string")
        table = _table(self.data, "specimen", required=True)
        kind = table.pop("kind", None)
        if kind is None:
            raise SceneError(f"specimen.kind is missing: expected one of {', '.join(SPECIMENS)}")
        if not isinstance(kind, str) or kind not in SPECIMENS:
            names = ", ".join(SPECIMENS)
            raise SceneError(f"specimen.kind = {reprlib.repr(kind)}: expected one of {names}{_hint(kind, SPECIMENS)}")
        self.kind: str = kind
        self.specimen: Specimen = _build(SPECIMENS[kind], table, "specimen")
        if kind == "mesh":
            if "mesh" in self.data:
                raise SceneError("mesh: a specimen of kind 'mesh' brings its own mesh; expected no [mesh] table")
            self.sizes = None
        self.material = _material(_table(self.data, "material", required=True))
        if not isinstance(self.specimen, UserMesh):
            self.sizes = _build(MeshSizes, self._sizes(_table(self.data, "mesh")), "mesh")
        self.interface = _build(InterfaceOptions, _table(self.data, "interface"), "interface")
        self.model = _build(ModelOptions, _table(self.data, "model"), "model")
        self.band = _build(BandOptions, _table(self.data, "band"), "band")
        if self.band.width is not None and (kind == "mesh" or self.band.where == "everywhere"):
            what = "a mesh of your own" if kind == "mesh" else "band.where = 'everywhere'"
            raise SceneError(f"band.width = {self.band.width:g}: with {what} the elements give it; expected no width")
        self.solver = _build(SolverOptions, _table(self.data, "solver"), "solver")
        self.output = _build(OutputOptions, _table(self.data, "output"), "output")
        self.reference = (
            _build(ReferenceOptions, _table(self.data, "reference"), "reference") if "reference" in self.data else None
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
        self.stages = [_build(Stage, dict(entry), f"stage.{i}") for i, entry in enumerate(stages)]

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
                    f"{', '.join(names)}{_hint(str(source), names)}"
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
        if "far_size" not in table and _is_a(table["crack_size"], float):
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


_SCENES = resources.files("cohesive") / "scenes"


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


def _table(data: dict[str, Any], name: str, required: bool = False) -> dict[str, Any]:
    table = data.get(name, {})
    if not isinstance(table, dict):
        raise SceneError(f"{name} = {table!r}: expected a table [{name}]")
    if required and name not in data:
        raise SceneError(f"[{name}] is missing")
    return dict(table)


def _material(table: dict[str, Any]) -> Concrete:
    preset = table.pop("preset", None)
    if preset is not None:
        if not isinstance(preset, str) or preset not in PRESETS:
            raise SceneError(f"material.preset = {reprlib.repr(preset)}: expected one of {', '.join(PRESETS)}")
        table = {**PRESETS[preset], **table}
    return _build(Concrete, table, "material")


T = typing.TypeVar("T")


def _build(cls: type[T], table: dict[str, Any], prefix: str) -> T:
    """An instance of a dataclass from a table, or a SceneError that names the key."""
    known = {field.name: field for field in fields(cls)}  # type: ignore[arg-type]
    _known(prefix + ".", table, known)
    for name, field in known.items():
        if field.default is MISSING and field.default_factory is MISSING and name not in table:
            raise SceneError(f"{prefix}.{name} is missing")
    hints = typing.get_type_hints(cls)
    for name, value in table.items():
        hint = hints[name]
        allowed = typing.get_args(hint) if isinstance(hint, types.UnionType) else (hint,)
        if not any(_is_a(value, kind) for kind in allowed):
            expected = " or ".join(_KINDS[kind] for kind in allowed if kind in _KINDS)
            raise SceneError(f"{prefix}.{name} = {reprlib.repr(value)}: expected {expected}")
    try:
        return cls(**table)
    except (ValueError, MeshError) as error:
        raise SceneError(f"{prefix}.{error}") from None


_KINDS = {float: "a finite number", int: "a whole number", str: "a string", bool: "true or false"}


#: numbers beyond it are no lengths, forces or counts, and their squares overflow; NaN compares false as well
_LARGEST = 1e100


def _is_a(value: Any, kind: Any) -> bool:
    if kind is float:
        return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < _LARGEST
    if kind is int:
        return isinstance(value, int) and not isinstance(value, bool) and abs(value) < _LARGEST
    if kind in (str, bool):
        return isinstance(value, kind)
    return kind is not type(None) or value is None  # the class checks lists and tables itself


def _known(prefix: str, table: dict[str, Any], names: typing.Iterable[str]) -> None:
    names = list(names)
    for key in table:
        if key not in names:
            raise SceneError(f"{prefix}{key}: unknown key{_hint(key, names)}; expected one of {', '.join(names)}")


def _hint(word: str, names: typing.Iterable[str]) -> str:
    close = difflib.get_close_matches(str(word), list(names), 1)
    return f" (did you mean '{close[0]}'?)" if close else ""
