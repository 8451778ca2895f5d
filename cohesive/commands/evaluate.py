"""`cohesive evaluate CSV...|SCENE`."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import SceneError
from ..measured.columns import MOTIONS
from ..measured.curve import Measured
from ..scenes.reference import load_reference, read_with
from ..scenes.scene import Scene
from ..scenes.table_reader import build_table
from ..scenes.tables import OutputOptions, ReferenceOptions
from .common import Commands, add_set, assignments, is_scene

if TYPE_CHECKING:
    from ..measured.evaluation import Evaluation

#: what --set may give besides keys of the specimen and of the reference
_OWN = ("mass", "mass_loading", "gauge_holder")
_TABLES = ("specimen.", "reference.", "output.")


def add_parser(commands: Commands) -> None:
    """The command's arguments."""
    p = commands.add_parser(
        "evaluate",
        help="evaluate measured curves after a standard",
        description="Fracture energy, residual strengths and Young's modulus of notched beams from their measured curves, "
        "without a model; of several specimens also mean, scatter and characteristic values.",
    )
    p.add_argument("sources", metavar="CSV|SCENE", nargs="+", help="measured curves, or a scene that names one")
    p.add_argument("--standard", required=True, metavar="NAME", help="rilem-tc-50, en-14651 or jci-s-001")
    p.add_argument(
        "--specimens", metavar="TABLE", help="table with a row for each specimen: file, sheet, block, span, depth, mass ..."
    )
    p.add_argument("-o", "--output", metavar="DIR", help="folder for series.csv, .json and .png (default: none)")
    add_set(
        p,
        "specimen.span, .depth, .thickness, .notch, .length (mm), mass (kg, of the beam), mass_loading (kg), "
        "gauge_holder (mm), reference.x, output.formats and so on",
    )
    p.set_defaults(execute=_execute)


def _execute(options: argparse.Namespace) -> int:
    from ..measured.evaluation import evaluate
    from ..measured.series import Series

    if options.output:
        from ..results.files import make_folder

        make_folder(Path(options.output))  # refused now, not when it is written
    curves, names, values = _specimens(options)
    evaluations = []
    for name, curve, each in zip(names, curves, values, strict=True):
        evaluations.append(evaluate(curve, options.standard, each))
        print(f"{name}: {evaluations[-1].summary()}" if len(curves) > 1 else evaluations[-1].summary())
    quantities = evaluations[0].quantities
    columns = {each.name: [one.values[each.name] for one in evaluations] for each in quantities}
    series = Series(names, columns, {each.name: each.unit for each in quantities})
    if len(curves) > 1:
        print(series.summary())
    if options.output:
        from ..figures.series import FILES, write_series

        specimens = {name: _facts(each, known) for name, each, known in zip(names, evaluations, values, strict=True)}
        facts = {"standard": options.standard, "specimens": specimens}
        given = assignments(options.set)
        output = {key.removeprefix("output."): value for key, value in given.items() if key.startswith("output.")}
        write_series(Path(options.output), series, curves, facts, build_table(OutputOptions, output, "output"))
        print(f"files: {options.output}/  ({', '.join(FILES)})")
    return 0


def _facts(evaluation: Evaluation, known: dict[str, Any]) -> dict[str, Any]:
    """Of one specimen, for JSON."""
    remarks = {each.name: each.remark for each in evaluation.quantities if each.remark}
    return {"file": evaluation.name, "known": known, "remarks": remarks, "notes": list(evaluation.notes)}


def _specimens(options: argparse.Namespace) -> tuple[list[Measured], list[str], list[dict[str, Any]]]:
    """The measured curves with their names, and what is known of each beam."""
    from ..measured.series import specimens_of

    given = assignments(options.set)
    if len(options.sources) == 1 and is_scene(options.sources[0]):
        if options.specimens:
            raise SceneError("--specimens: expected files with curves, not a scene", "specimens")
        own = {key: value for key, value in given.items() if key in _OWN}
        others = {key: value for key, value in given.items() if key not in _OWN}
        scene = Scene.load(options.sources[0], options.run_scripts).with_(**others)
        reference = load_reference(scene)
        if reference is None:
            raise SceneError(f"reference is missing in {options.sources[0]}: expected a measured curve", "reference")
        known = {f"specimen.{key}": value for key, value in scene.given("specimen").items()} | own
        return list(reference.curves), [each.name for each in reference.curves], [known] * len(reference.curves)
    known = {key: value for key, value in given.items() if key.startswith(_TABLES) or key in _OWN}
    if unknown := sorted(set(given) - set(known)):
        raise SceneError(
            f"--set {unknown[0]}: a curve has no such key; expected {', '.join(_OWN)}, specimen.*, reference.* or output.*"
        )
    specimens = specimens_of(options.sources, options.specimens)
    values = [known | dict(each.values) for each in specimens]
    curves = [_curve(each.file, value) for each, value in zip(specimens, values, strict=True)]
    names = [each.name for each in specimens]
    return curves, names, values


def _curve(path: Path, values: dict[str, Any]) -> Measured:
    """The curve of one specimen by the keys of its reference; doubts are judged by the area of its crack, if that is known."""
    keys = {key.removeprefix("reference."): value for key, value in values.items() if key.startswith("reference.")}
    reader = build_table(ReferenceOptions, {"file": str(path)} | keys, "reference")
    sizes = [values.get(f"specimen.{key}") for key in ("thickness", "depth", "notch")]
    area = None
    if all(isinstance(size, (int, float)) for size in sizes):
        thickness, depth, notch = map(float, sizes)  # type: ignore[arg-type]
        area = thickness * (depth - notch) if depth > notch else None
    return read_with(reader, path, reader.against, MOTIONS, area)
