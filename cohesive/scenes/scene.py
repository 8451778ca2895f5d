"""Scenes: the declarative input, as TOML or Python. Every error names its key."""

from __future__ import annotations

import copy
import os
import reprlib
import tomllib
from collections.abc import Mapping, Sequence
from importlib import resources
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import tomli_w

from meshing.errors import MeshError
from meshing.generation.sizes import MeshSizes
from meshing.paths import Line
from meshing.specimens import SPECIMENS, Specimen

from ..errors import ParameterError, SceneError
from ..law.concrete import PRESETS, Concrete, with_preset
from ..solver.stages import Stage
from .checks import RENAMED_KINDS, build_table, check_known, hint, is_a, refuse, table_of
from .names import check_curve, check_gauge_names, check_stage_names
from .tables import BandOptions, GrowOptions, InterfaceOptions, ModelOptions, OutputOptions, ReferenceOptions, SolverOptions

#: elements to `Concrete.zone_length` on the mesh that is chosen by rule, and its far size over its crack size
ELEMENTS_IN_ZONE, COARSENING = 15, 8.0

TABLES = (
    "title", "specimen", "grow", "mesh", "material", "interface", "model", "band", "stage", "solver", "reference", "output",
)  # fmt: skip

#: value of `specimen.crack` with which the path is found
GROW = "grow"

#: levels of tables and lists, bits of a whole number, and digits of an index into a list, that a scene may have
_DEEPEST, _MOST_BITS, _MOST_DIGITS = 20, 1000, 10

T = TypeVar("T")

_BUILTIN = resources.files("cohesive.scenes") / "builtin"


class Scene:
    """One simulation, described by a nested dict with the keys of the TOML file.

    It cannot be changed: `with_` makes another one.

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
    data : dict, as given; each time a copy
    title, kind, specimen, sizes, material, interface, model, band, solver, reference, output : checked parts
    stages : tuple of Stage

    Examples
    --------
    >>> from cohesive import Scene
    >>> beam = Scene.load("notched-beam").with_(**{"material.ft": 3.0})
    >>> beam.kind, beam.material.ft
    ('notched-beam', 3.0)
    """

    _is_made = False

    def __init__(self, data: Mapping[str, Any], folder: str | Path = ".") -> None:
        if not isinstance(data, Mapping):
            raise SceneError(f"Scene({data!r}): expected a dict with the tables of a scene; Scene.load(name) reads files")
        self._data: dict[str, Any] = _plain(data)
        self.folder = Path(folder)
        check_known("", self._data, TABLES)
        self.title = self._data.get("title", "untitled")
        if not isinstance(self.title, str):
            raise refuse("title", self.title, "a string")
        self.kind, self.specimen = self._specimen()
        self.material = _material(table_of(self._data, "material", required=True))
        self.sizes = self._sizes()
        self.interface = build_table(InterfaceOptions, table_of(self._data, "interface"), "interface")
        self.model = build_table(ModelOptions, table_of(self._data, "model"), "model")
        self.band = build_table(BandOptions, table_of(self._data, "band"), "band")
        self.solver = build_table(SolverOptions, table_of(self._data, "solver"), "solver")
        self.output = build_table(OutputOptions, table_of(self._data, "output"), "output")
        self.reference = self._reference()
        self._check_model()
        self.grow = self._grow()
        self.stages = self._stages()
        self._is_made = True

    def __setattr__(self, name: str, value: object) -> None:
        if self._is_made:
            raise AttributeError(f"{name}: a scene cannot be changed; expected scene.with_(...), which makes another one")
        super().__setattr__(name, value)

    @property
    def data(self) -> dict[str, Any]:
        """The nested dict, a copy."""
        return copy.deepcopy(self._data)

    def given(self, key: str) -> Any:
        """What the dict has for a dotted key, a copy; None if there is nothing."""
        place: Any = self._data
        for part in key.split("."):
            try:
                place = place[int(part)] if isinstance(place, list) else place[part]
            except (KeyError, IndexError, ValueError, TypeError):
                return None
        return copy.deepcopy(place)

    def _specimen(self) -> tuple[str, Specimen]:
        """Kind and specimen."""
        table = table_of(self._data, "specimen", required=True)
        kind = table.pop("kind", None)
        names = ", ".join(SPECIMENS)
        if kind is None:
            raise SceneError(f"specimen.kind is missing: expected one of {names}", "specimen.kind")
        if isinstance(kind, str) and kind in RENAMED_KINDS:
            raise refuse("specimen.kind", kind, RENAMED_KINDS[kind])
        if not isinstance(kind, str) or kind not in SPECIMENS:
            raise refuse("specimen.kind", kind, f"one of {names}{hint(kind, SPECIMENS)}")
        if table.get("crack") == GROW and SPECIMENS[kind].has_outline:  # it has its default path until another is found
            del table["crack"]
        return kind, build_table(SPECIMENS[kind], table, "specimen").located(self.file)

    def _grow(self) -> GrowOptions | None:
        """[grow], if the crack path is to be found."""
        if self._data["specimen"].get("crack") != GROW or not self.specimen.has_outline:
            if "grow" in self._data:
                raise SceneError("grow: no path is looked for; expected specimen.crack = 'grow' or no such table", "grow")
            return None
        options = build_table(GrowOptions, table_of(self._data, "grow"), "grow")
        key, value = "specimen.crack", GROW
        if self.dimension == 3:
            raise SceneError(f"{key} = {value!r}: paths are found in the plane only; expected model.dimension = 2", key)
        if self.model.half:
            raise SceneError(f"{key} = {value!r}: a path may leave the plane of symmetry; expected model.half = false", key)
        if not self.specimen.starts and not options.starts:
            raise SceneError(f"{key} = {value!r}: this {self.kind} has no notch; expected grow.starts", key)
        return options

    def along(self, lines: Sequence[Line]) -> Scene:
        """The scene with given crack paths, on elements of the same sizes, discrete; SceneError for a mesh of the user's."""
        known = self._known("the size of its elements", self.sizes)
        sizes = {f"mesh.{name}": getattr(known, name) for name in ("crack_size", "far_size")}
        crack = [[list(point) for point in line] for line in lines]
        scene = self.without_search(crack).with_(**sizes)
        return scene.with_(**{"model.kind": "discrete"})

    def without_search(self, crack: Any) -> Scene:
        """The scene with a given crack path."""
        data = {name: value for name, value in self._data.items() if name != "grow"}
        return Scene(data | {"specimen": data["specimen"] | {"crack": crack}}, self.folder)

    def _sizes(self) -> MeshSizes | None:
        """[mesh] with the sizes that it leaves out: enough elements along the crack and within its process zone."""
        if not self.specimen.is_sized:
            if "mesh" in self._data:
                raise SceneError(
                    f"mesh: a specimen of kind '{self.kind}' brings its own mesh; expected no [mesh] table", "mesh"
                )
            return None
        table = table_of(self._data, "mesh")
        if "crack_size" not in table:
            along, zone = self.crack_length / self.specimen.elements_along, self.material.zone_length
            table["crack_size"] = min(along, zone / ELEMENTS_IN_ZONE)
        if "far_size" not in table and is_a(table["crack_size"], float):
            table["far_size"] = COARSENING * table["crack_size"]
        return build_table(MeshSizes, table, "mesh")

    def _reference(self) -> ReferenceOptions | None:
        if "reference" not in self._data:
            return None
        reference = build_table(ReferenceOptions, table_of(self._data, "reference"), "reference")
        for name in reference.files:
            self._check_file("reference.file", name)
        return reference

    def _check_file(self, key: str, name: str) -> None:
        """Refuse a name of no regular file."""
        try:
            path = self.file(name)
            if path.is_file():
                return
            what = f"{path} is not a regular file" if path.exists() else f"there is no file {path}"
        except (OSError, ValueError):  # too long a name, or one with a null character
            what = "that can be no name of a file"
        raise SceneError(f"{key} = {reprlib.repr(name)}: {what}", key)

    def _check_model(self) -> None:
        """Refuse models that the specimen does not have."""
        model, dimensions = self.model, self.specimen.dimensions
        if model.dimension is not None and model.dimension not in dimensions:
            what = f"{' or '.join(map(str, dimensions))} with a {self.kind}" if dimensions else "no such key, the mesh tells"
            raise refuse("model.dimension", model.dimension, what)
        if dimensions == (3,) and model.plane == "strain":
            raise SceneError(f"model.plane = 'strain': a {self.kind} is no plane body; expected no such key", "model.plane")
        if self.band.width is not None and (self.sizes is None or self.band.where == "everywhere"):
            what = "a mesh of your own" if self.sizes is None else "band.where = 'everywhere'"
            raise SceneError(
                f"band.width = {self.band.width:g}: with {what} the elements give it; expected no width", "band.width"
            )
        if self.sizes is not None and model.kind == "smeared" and self.band.where == "path":
            try:
                self.specimen.check_band(self.sizes, dimension=self.dimension)
            except MeshError as error:
                raise SceneError(str(error), error.key) from None
        if model.half and model.kind == "smeared":
            raise SceneError(
                "model.half = true: the crack band lies on both sides of the crack; expected false with 'smeared'",
                "model.half",
            )
        if model.half and self.specimen.symmetry() is None:
            raise SceneError(
                f"model.half = true: this {self.kind} is not symmetric about its crack; expected false, or a symmetric "
                "specimen with its notch in the middle and the default crack path",
                "model.half",
            )

    def _stages(self) -> tuple[Stage, ...]:
        stages = self._data.get("stage")
        if not isinstance(stages, list) or not stages or not all(isinstance(entry, dict) for entry in stages):
            raise SceneError("stage is missing or not a list of tables: expected at least one [[stage]]", "stage")
        found = [build_table(Stage, entry, f"stage.{i}") for i, entry in enumerate(stages)]
        gauges = list(self.specimen.gauges())
        check_gauge_names(self.kind, gauges)
        drives, forces = list(self.specimen.drives()), list(self.specimen.forces())
        check_stage_names(found, gauges, drives, forces)
        check_curve(self.output.curve, gauges, drives, forces)
        return tuple(found)

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
        if not os.path.isfile(path) and os.path.exists(path) and not os.path.isdir(path):
            raise SceneError(f"scene '{source}': it is a pipe or a device; expected a file")
        if not os.path.isfile(path) and path.suffix != ".toml":
            names = built_in()
            if str(source) not in names:
                raise SceneError(
                    f"scene '{source}': no such file, and no built-in scene of that name; built in are "
                    f"{', '.join(names)}{hint(str(source), names)}"
                )
            path = Path(str(_BUILTIN / f"{source}.toml"))
        try:
            data = tomllib.loads(path.read_text(encoding="utf-8"))
        except OSError as error:
            raise SceneError(f"scene '{source}': cannot be read: {error.strerror}") from None
        except (ValueError, RecursionError) as error:  # besides those of the syntax: no UTF-8, thousands of digits or levels
            raise SceneError(f"scene '{source}': not valid TOML: {error}") from None
        return cls(data, path.parent)

    def with_(self, **changes: Any) -> Scene:
        """A copy with some dotted keys changed, `scene.with_(**{"material.Gf": 0.07, "stage.0.to": 0.1})`.

        Raises
        ------
        SceneError
            Naming the key.
        """
        data = self.data
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
            else:
                _item(key, place, last)
                place[int(last)] = value
        return Scene(data, self.folder)

    @property
    def dimension(self) -> int:
        """Dimension in which a sized specimen is modelled."""
        return self.model.dimension or min(self.specimen.dimensions, default=2)

    @property
    def is_solid(self) -> bool:
        """Whether a sized specimen is modelled in 3D."""
        return self.dimension == 3

    @property
    def is_extruded(self) -> bool:
        """Whether a 2D specimen is extruded over its thickness."""
        return self.is_solid and 2 in self.specimen.dimensions

    @property
    def crack_length(self) -> float:
        """Length of the crack path of a sized specimen, mm; that of a crack without one is the root of its area. SceneError
        for a specimen that brings its own mesh, as for `crack_area` and `band_width`."""
        try:
            length = self.specimen.path_length
        except MeshError as error:
            raise SceneError(f"specimen.{error}", f"specimen.{error.key}") from None
        return self._known("the length of its crack", length)

    @property
    def crack_area(self) -> float:
        """Area of the crack of a sized specimen, mm^2."""
        return self._known("the area of its crack", self.specimen.crack_area)

    @property
    def band_width(self) -> float:
        """Width of the band along the path of a sized specimen, mm: the crack size, if the scene names none."""
        sizes = self._known("the width of its band", self.sizes)
        return sizes.crack_size if self.band.width is None else self.band.width

    def _known(self, what: str, value: T | None) -> T:
        """A value that the keys of the specimen tell, if they do."""
        if value is None:
            raise SceneError(
                f"specimen.kind = '{self.kind}': {what} is not known before its mesh is read; expected a kind without a file, "
                "or the result of a run (result.model)",
                "specimen.kind",
            )
        return value

    def file(self, name: str) -> Path:
        """A file that the scene names: beside it, or one that comes with the built-in scenes."""
        beside, bundled = self.folder / name, Path(str(_BUILTIN / Path(name).name))
        return bundled if not os.path.exists(beside) and os.path.isfile(bundled) else beside


def built_in() -> list[str]:
    """Names of the built-in scenes."""
    return sorted(entry.name[:-5] for entry in _BUILTIN.iterdir() if entry.name.endswith(".toml"))


def dump_toml(data: Mapping[str, Any]) -> str:
    """A scene's dict as TOML text; what is None is left out."""
    text: str = tomli_w.dumps(_without_none(data))
    return text


def _without_none(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _without_none(entry) for key, entry in value.items() if entry is not None}
    if isinstance(value, (list, tuple)):
        return [_without_none(entry) for entry in value]
    return value


def _plain(value: Any, key: str = "", depth: int = 0) -> Any:
    """A copy with the dicts, lists and numbers of TOML, out of NumPy's and other mappings and sequences.

    Raises
    ------
    SceneError
        For what no scene holds: levels without end, and whole numbers that are no floating-point numbers.
    """
    if depth > _DEEPEST:
        raise SceneError(f"{key}: it is nested more than {_DEEPEST} levels deep; expected the tables of a scene", key)
    if isinstance(value, Mapping):
        return {name: _plain(entry, f"{key}.{name}" if key else f"{name}", depth + 1) for name, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(entry, key, depth + 1) for entry in value]
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, int) and value.bit_length() > _MOST_BITS:
        raise SceneError(f"{key}: a whole number of about {value.bit_length() * 0.30103:.0f} digits; expected fewer", key)
    return value


def _item(key: str, place: Any, part: str) -> Any:
    if isinstance(place, list) and part.isdecimal() and len(part) < _MOST_DIGITS and int(part) < len(place):
        return place[int(part)]
    raise SceneError(f"{key}: there is no such key in the scene", key)


def _material(table: dict[str, Any]) -> Concrete:
    preset = table.pop("preset", None)
    if preset is not None:
        if not isinstance(preset, str) or preset not in PRESETS:
            raise refuse("material.preset", preset, f"one of {', '.join(PRESETS)}")
        try:
            table = with_preset(preset, table)
        except ParameterError as error:  # of a softening that is none
            raise SceneError(f"material.{error}", f"material.{error.key}") from None
    return build_table(Concrete, table, "material")
