"""`cohesive evaluate CSV|SCENE`."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..errors import SceneError
from ..scenes.reference import load_reference
from ..scenes.scene import Scene
from .common import Commands, assignments

#: a scene whose reference is replaced, to read a file by itself
_READER = "notched-beam"

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
    p.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="specimen.span, .depth, .thickness, .notch, .length (mm), mass (kg, of the beam), mass_loading (kg), "
        "gauge_holder (mm), reference.x and so on",
    )
    p.set_defaults(execute=_execute)


def _execute(options: argparse.Namespace) -> int:
    from ..studies.evaluation import evaluate

    given = assignments(options.set)
    scene, values = _scene(options.source, given)
    reference = load_reference(scene)
    if reference is None:
        raise SceneError(f"reference is missing in {options.source}: expected a measured curve", "reference")
    for curve in reference.curves:
        print(evaluate(curve, reference.against, options.standard, values).summary())
    return 0


def _scene(source: str, given: dict[str, Any]) -> tuple[Scene, dict[str, Any]]:
    """A scene with the measured curve, and what is known of the beam."""
    own = {key: value for key, value in given.items() if key in _OWN}
    others = {key: value for key, value in given.items() if key not in _OWN}
    path = Path(source)
    is_scene = path.suffix == ".toml" or not path.is_file()
    if is_scene:
        scene = Scene.load(source).with_(**others)
        known = {f"specimen.{key}": value for key, value in scene.given("specimen").items()}
        return scene, known | own
    known = {key: value for key, value in others.items() if key.startswith("specimen.")}
    reference = {key: value for key, value in others.items() if key.startswith("reference.")}
    if unknown := sorted(set(others) - set(known) - set(reference)):
        raise SceneError(f"--set {unknown[0]}: a curve has no such key; expected {', '.join(_OWN)}, specimen.* or reference.*")
    reader = Scene.load(_READER)
    data = {**reader.data, "reference": {"file": str(path.resolve())}}
    return Scene(data, reader.folder).with_(**reference), known | own
