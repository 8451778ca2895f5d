"""`cohesive evaluate CSV|SCENE`."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..errors import SceneError
from ..measured.columns import MOTIONS
from ..measured.curve import Measured
from ..scenes.inputs import build_table
from ..scenes.reference import load_reference, read_with
from ..scenes.scene import Scene
from ..scenes.tables import ReferenceOptions
from .common import Commands, add_set, assignments

#: what --set may give besides keys of the specimen and of the reference
_OWN = ("mass", "mass_loading", "gauge_holder")


def add_parser(commands: Commands) -> None:
    """The command's arguments."""
    p = commands.add_parser(
        "evaluate",
        help="evaluate a measured curve after a standard",
        description="Fracture energy, residual strengths and Young's modulus of a notched beam from its measured curve, "
        "without a model.",
    )
    p.add_argument("source", metavar="CSV|SCENE", help="a measured curve, or a scene that names one")
    p.add_argument("--standard", required=True, metavar="NAME", help="rilem-tc-50, en-14651 or jci-s-001")
    add_set(
        p,
        "specimen.span, .depth, .thickness, .notch, .length (mm), mass (kg, of the beam), mass_loading (kg), "
        "gauge_holder (mm), reference.x and so on",
    )
    p.set_defaults(execute=_execute)


def _execute(options: argparse.Namespace) -> int:
    from ..measured.evaluation import evaluate

    curves, values = _curves(options.source, assignments(options.set), options.run_scripts)
    for curve in curves:
        print(evaluate(curve, options.standard, values).summary())
    return 0


def _curves(source: str, given: dict[str, Any], run_scripts: bool) -> tuple[Sequence[Measured], dict[str, Any]]:
    """The measured curves, and what is known of the beam."""
    from ..measured.evaluation import beam_of

    own = {key: value for key, value in given.items() if key in _OWN}
    others = {key: value for key, value in given.items() if key not in _OWN}
    path = Path(source)
    if path.suffix == ".toml" or not path.is_file():
        scene = Scene.load(source, run_scripts).with_(**others)
        reference = load_reference(scene)
        if reference is None:
            raise SceneError(f"reference is missing in {source}: expected a measured curve", "reference")
        return reference.curves, {f"specimen.{key}": value for key, value in scene.given("specimen").items()} | own
    known = {key: value for key, value in others.items() if key.startswith("specimen.")}
    keys = {key: value for key, value in others.items() if key.startswith("reference.")}
    if unknown := sorted(set(others) - set(known) - set(keys)):
        raise SceneError(f"--set {unknown[0]}: a curve has no such key; expected {', '.join(_OWN)}, specimen.* or reference.*")
    table = {"file": str(path)} | {key.removeprefix("reference."): value for key, value in keys.items()}
    area = beam_of(known).ligament
    reader = build_table(ReferenceOptions, table, "reference")
    return [read_with(reader, path, reader.against, MOTIONS, area)], known | own
