"""A scene's tables read in one pass: each by its own keys, then against the others. Every error names its key."""

from __future__ import annotations

import math
import reprlib
import typing
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from meshing.errors import MeshError
from meshing.generation.sizes import MeshSizes
from meshing.specimens import SPECIMENS, Specimen

from ..errors import ParameterError, SceneError
from ..law.concrete import PRESETS, Concrete, with_preset
from ..law.crack_plane import DEFAULT_LAW
from ..law.registry import LAWS, LawKeys
from ..law.widths import default_band_width
from ..solver.columns import Column, columns_of
from ..solver.stages import Stage
from .names import check_names, hint, refuse
from .table_reader import TABLES, build_table, check_known, is_a, table_of
from .tables import BandOptions, GrowOptions, InterfaceOptions, ModelOptions, OutputOptions, ReferenceOptions, SolverOptions

T = typing.TypeVar("T")

#: elements to `LawKeys.zone_length` on the mesh that is chosen by rule, and its far size over its crack size
ELEMENTS_IN_ZONE, COARSENING = 12, 8.0

#: value of `specimen.crack` with which the path is found
GROW = "grow"

#: kinds of specimens of earlier versions
_RENAMED_KINDS = {
    "notched-beam-3d": "specimen.kind = 'notched-beam' and model.dimension = 3",
    "push-off-3d": "specimen.kind = 'push-off' and model.dimension = 3",
}


@dataclass(frozen=True, eq=False)
class Inputs:
    """What a scene says, checked.

    Attributes
    ----------
    title, kind, specimen, law, material, interface, model, band, solver, output : its tables
    sizes : of the elements, those that follow by rule among them; None with a user mesh
    reference, grow : None if the scene names no measured curve, looks for no path
    stages : tuple of Stage
    columns : of the history, as far as its keys tell
    """

    title: str
    kind: str
    specimen: Specimen
    law: LawKeys
    material: Concrete
    sizes: MeshSizes | None
    interface: InterfaceOptions
    model: ModelOptions
    band: BandOptions
    solver: SolverOptions
    output: OutputOptions
    reference: ReferenceOptions | None
    grow: GrowOptions | None
    stages: tuple[Stage, ...]
    columns: tuple[Column, ...]

    @property
    def dimension(self) -> int:
        """Dimension in which a sized specimen is modelled."""
        return _dimension(self.specimen, self.model)

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
        return known(self.kind, "the length of its crack", _path_length(self.specimen))

    @property
    def crack_area(self) -> float:
        """Area of the crack of a sized specimen, mm^2."""
        return known(self.kind, "the area of its crack", self.specimen.crack_area)

    @property
    def band_width(self) -> float:
        """Width of the band along the path of a sized specimen, mm."""
        return self.band_rule if self.band.width is None else self.band.width

    @property
    def band_rule(self) -> float:
        """This width if the scene names none, mm: by rule, at most the width of the notch."""
        known(self.kind, "the width of its band", self.sizes)
        notch = getattr(self.specimen, "notch_width", 0.0) or math.inf
        return min(default_band_width(self.crack_length, self.zone_length), notch)

    @property
    def zone_length(self) -> float:
        """What sizes and widths go by, see `LawKeys`, mm."""
        return self.law.zone_length(self.material)


def without_script(data: dict[str, Any], find: Callable[[str], Path], run_scripts: bool) -> dict[str, Any]:
    """The dict of a scene with what its specimen's script says in place of the script."""
    table = data.get("specimen")
    if not isinstance(table, dict) or not isinstance(kind := table.get("kind"), str) or kind not in SPECIMENS:
        return data  # which is refused by its keys
    try:
        return data | {"specimen": SPECIMENS[kind].without_script(table, find, run_scripts)}
    except MeshError as error:
        raise SceneError(f"specimen.{error}", f"specimen.{error.key}") from None


def read_inputs(data: Mapping[str, Any], find: Callable[[str], Path]) -> Inputs:
    """The tables of a scene.

    Parameters
    ----------
    data : dict with the keys of the TOML file
    find : the place of a file that the scene names

    Raises
    ------
    SceneError
        Naming the key that is missing, unknown, of the wrong type or out of range.
    """
    check_known("", data, ("title", "specimen", "law", *TABLES))
    title = data.get("title", "untitled")
    if not isinstance(title, str):
        raise refuse("title", title, "a string")
    kind, specimen = _specimen(data)
    specimen = specimen.located(find)
    law, material = _law_and_material(data)
    model = build_table(ModelOptions, table_of(data, "model"), "model")
    inputs = Inputs(
        title,
        kind,
        specimen,
        law,
        material,
        _sizes(data, kind, specimen, law.zone_length(material), model),
        build_table(InterfaceOptions, table_of(data, "interface"), "interface"),
        model,
        build_table(BandOptions, table_of(data, "band"), "band"),
        build_table(SolverOptions, table_of(data, "solver"), "solver"),
        build_table(OutputOptions, table_of(data, "output"), "output"),
        build_table(ReferenceOptions, table_of(data, "reference"), "reference") if "reference" in data else None,
        _grow(data, specimen),
        _stages(data),
        columns_of(list(specimen.gauges()), list(specimen.drives()), list(specimen.forces()), law.columns),
    )
    for name in [] if inputs.reference is None else inputs.reference.files:
        _check_file(name, find)
    _check_model(inputs)
    check_names(kind, list(specimen.gauges()), inputs.stages, inputs.output.curve, inputs.columns)
    return inputs


def _specimen(data: Mapping[str, Any]) -> tuple[str, Specimen]:
    """Kind and specimen."""
    table = table_of(data, "specimen", required=True)
    kind = table.pop("kind", None)
    names = ", ".join(SPECIMENS)
    if kind is None:
        raise SceneError.at("specimen.kind", f" is missing: expected one of {names}")
    if isinstance(kind, str) and kind in _RENAMED_KINDS:
        raise refuse("specimen.kind", kind, _RENAMED_KINDS[kind])
    if not isinstance(kind, str) or kind not in SPECIMENS:
        raise refuse("specimen.kind", kind, f"one of {names}{hint(kind, SPECIMENS)}")
    if table.get("crack") == GROW and SPECIMENS[kind].has_outline:  # it has its default path until another is found
        del table["crack"]
    return kind, build_table(SPECIMENS[kind], table, "specimen")


def _law_and_material(data: Mapping[str, Any]) -> tuple[LawKeys, Concrete]:
    """What [law] and [material] say; a law with scales of its own gives the material's ft and Gf, if they are left out."""
    table = table_of(data, "material", required=True)
    name = table.pop("law", DEFAULT_LAW)
    if not isinstance(name, str) or name not in LAWS:
        raise refuse("material.law", name, f"one of {', '.join(LAWS)}{hint(name, LAWS)}; others after register_law")
    law = build_table(LAWS[name], table_of(data, "law"), "law")
    if (scales := law.scales()) is not None:
        table = dict(zip(("ft", "Gf"), scales, strict=True)) | table
    preset = table.pop("preset", None)
    if preset is not None:
        if not isinstance(preset, str) or preset not in PRESETS:
            raise refuse("material.preset", preset, f"one of {', '.join(PRESETS)}")
        try:
            table = with_preset(preset, table)
        except ParameterError as error:  # of a softening that is none
            raise SceneError(f"material.{error}", f"material.{error.key}") from None
    return law, build_table(Concrete, table, "material")


def _sizes(
    data: Mapping[str, Any], kind: str, specimen: Specimen, zone_length: float, model: ModelOptions
) -> MeshSizes | None:
    """[mesh] with what it leaves out: enough elements along the crack and within its process zone, their order."""
    if not specimen.is_sized:
        if "mesh" in data:
            raise SceneError.at("mesh", f": a specimen of kind '{kind}' brings its own mesh; expected no [mesh] table")
        return None
    table = table_of(data, "mesh")
    if "crack_size" not in table:
        length = known(kind, "the length of its crack", _path_length(specimen))
        table["crack_size"] = min(length / specimen.elements_along, zone_length / ELEMENTS_IN_ZONE)
    if "far_size" not in table and is_a(table["crack_size"], float):
        table["far_size"] = COARSENING * table["crack_size"]
    table.setdefault("order", 2 if _dimension(specimen, model) == 2 else 1)
    return build_table(MeshSizes, table, "mesh")


def _dimension(specimen: Specimen, model: ModelOptions) -> int:
    return model.dimension or min(specimen.dimensions, default=2)


def known(kind: str, what: str, value: T | None) -> T:
    """A value that the keys of a specimen tell; SceneError if they do not."""
    if value is None:
        raise SceneError.at(
            "specimen.kind",
            f" = '{kind}': {what} is not known before its mesh is read; expected a kind without a file, "
            "or the result of a run (result.facts)",
        )
    return value


def _path_length(specimen: Specimen) -> float | None:
    try:
        return specimen.path_length
    except MeshError as error:
        raise SceneError(f"specimen.{error}", f"specimen.{error.key}") from None


def _grow(data: Mapping[str, Any], specimen: Specimen) -> GrowOptions | None:
    """[grow], if the crack path is to be found."""
    if data["specimen"].get("crack") == GROW and specimen.has_outline:
        return build_table(GrowOptions, table_of(data, "grow"), "grow")
    if "grow" in data:
        raise SceneError.at("grow", ": no path is looked for; expected specimen.crack = 'grow' or no such table")
    return None


def _stages(data: Mapping[str, Any]) -> tuple[Stage, ...]:
    stages = data.get("stage")
    if not isinstance(stages, list) or not stages or not all(isinstance(entry, dict) for entry in stages):
        raise SceneError.at("stage", " is missing or not a list of tables: expected at least one [[stage]]")
    return tuple(build_table(Stage, entry, f"stage.{i}") for i, entry in enumerate(stages))


def _check_file(name: str, find: Callable[[str], Path]) -> None:
    """Refuse a name of no regular file."""
    try:
        path = find(name)
        if path.is_file():
            return
        what = f"{path} is not a regular file" if path.exists() else f"there is no file {path}"
    except (OSError, ValueError):  # too long a name, or one with a null character
        what = "that can be no name of a file"
    raise SceneError.at("reference.file", f" = {reprlib.repr(name)}: {what}")


def _check_model(inputs: Inputs) -> None:
    """Refuse models that the specimen does not have."""
    model, specimen, dimensions = inputs.model, inputs.specimen, inputs.specimen.dimensions
    if model.dimension is not None and model.dimension not in dimensions:
        what = f"{' or '.join(map(str, dimensions))} with a {inputs.kind}" if dimensions else "no such key, the mesh tells"
        raise refuse("model.dimension", model.dimension, what)
    if not inputs.law.takes_width:
        own = "the law has a stiffness of its own, and takes no width; expected"
        if model.kind == "smeared":
            raise SceneError.at("model.kind", f" = 'smeared': {own} 'discrete', or a law that takes that of the band")
        if inputs.interface.width is not None:
            raise SceneError.at("interface.width", f" = {inputs.interface.width}: {own} no such key")
    if dimensions == (3,) and model.plane == "strain":
        raise SceneError.at("model.plane", f" = 'strain': a {inputs.kind} is no plane body; expected no such key")
    named = getattr(specimen, "band", None)
    if inputs.band.width is not None and (named or inputs.band.where == "everywhere"):
        what = f"specimen.band = '{named}'" if named else "band.where = 'everywhere'"
        raise SceneError.at("band.width", f" = {inputs.band.width:g}: with {what} the elements give it; expected no width")
    if inputs.sizes is not None and model.kind == "smeared" and inputs.band.where == "path":
        try:
            specimen.check_band(inputs.sizes, dimension=inputs.dimension)
        except MeshError as error:
            raise SceneError(str(error), error.key) from None
    if model.half and model.kind == "smeared" and inputs.band.where == "everywhere":
        raise SceneError.at("model.half", " = true: cracks may form everywhere; expected false, or band.where = 'path'")
    if model.half and specimen.symmetry() is None:
        raise SceneError.at(
            "model.half",
            f" = true: this {inputs.kind} is not symmetric about its crack; expected false, or a symmetric "
            "specimen with its notch in the middle and the default crack path",
        )
    if inputs.grow is not None:
        key = "specimen.crack"
        if inputs.is_solid != inputs.grow.extrude:
            has = "crack fronts are given, not found" if inputs.is_solid else "nothing is extruded in the plane"
            wanted = "grow.extrude = true, which finds the path in the plane" if inputs.is_solid else "model.dimension = 3"
            raise SceneError.at(key, f" = '{GROW}': {has}; expected {wanted}")
        if model.half:
            raise SceneError.at(key, f" = '{GROW}': a path may leave the plane of symmetry; expected model.half = false")
