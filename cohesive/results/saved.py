"""The folder of a run: what is read back from it, and the file of its fields."""

from __future__ import annotations

import csv
import json
import zipfile
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import Array
from ..errors import SceneError
from ..growth.found import FoundPath, Vertex
from ..scenes.reference import load_reference
from ..scenes.scene import Scene
from .archive import put_together, taken_apart
from .fields import Fields, Planes
from .files import write_file
from .model_facts import ModelFacts
from .run_data import RunData, run_columns

#: file with the mesh, the fields, the way of the drives and a found path: arrays, and one entry with the structure as JSON
FIELDS, _STRUCTURE = "fields.npz", "structure"


def write_fields(data: RunData, folder: Path) -> None:
    """fields.npz, without which the fields of a result are not known any more."""
    held = {"way": data.way, "found": data.found, "fields": None if data.kept is None else data.kept.as_data()}
    text, arrays = taken_apart(held)

    def write(path: Path) -> None:
        everything: dict[str, Any] = {_STRUCTURE: np.array(text), **arrays}
        np.savez(path, **everything)

    write_file(folder / FIELDS, write)


def read_folder(folder: Path) -> dict[str, Any]:
    """What the folder of a run holds: the arguments of its result.

    Raises
    ------
    SceneError
        If a file is missing or broken, or the scene cannot be made again.
    """
    for name in ("history.csv", "run.json", "scene.toml"):
        if not (folder / name).is_file():
            raise SceneError(f"'{folder}': there is no {name}; expected the folder of a run that was saved")
    try:
        scene = Scene.load(folder / "scene.toml")
    except SceneError as error:
        raise SceneError(f"'{folder / 'scene.toml'}': {error}", error.key) from None
    try:
        facts = json.loads((folder / "run.json").read_text(encoding="utf-8"))
        found = {
            "scene": scene,
            "history": _history(scene, folder),
            "way": np.array(facts.get("way") or []),
            "notes": facts["notes"],
            "timings": facts["timings"],
            "facts": _facts(facts),
            "kept": None,
            "found": None,
        }
        if (folder / FIELDS).is_file():
            found |= _fields(scene, folder)
    except (OSError, EOFError, ValueError, KeyError, TypeError, AttributeError, zipfile.BadZipFile) as error:
        what = f"'{error.args[0]}' is missing" if isinstance(error, KeyError) else str(error)
        raise SceneError(f"'{folder}': its files cannot be read: {what}; expected those of a run that was saved") from None
    return found | {"reference": load_reference(scene)}


def _history(scene: Scene, folder: Path) -> dict[str, Array]:
    with open(folder / "history.csv", encoding="utf-8", newline="") as file:
        names, *rows = csv.reader(file)
    units = {column.name: column.unit for column in run_columns(scene)}
    if unknown := [name for name in names if name not in units]:
        raise ValueError(f"history.csv has a column {unknown[0]!r}, which no run of the scene has")
    if not rows:
        return {name: np.zeros(0) for name in names}
    return {name: _values(text, units[name]) for name, text in zip(names, zip(*rows, strict=True), strict=True)}


def _values(text: Sequence[str], unit: str) -> Array:
    """Numbers of a column; whole ones of a column without a unit are integers, as in the run."""
    if not unit and all(value.isdigit() for value in text):
        return np.array([int(value) for value in text])
    return np.array([float(value) for value in text])


def _facts(facts: dict[str, Any]) -> ModelFacts:
    """Of run.json; that of an older version knows of one initial stiffness only, and no words."""
    curve = facts["curve"]
    older: dict[str, Any] = {
        "modelled": [],
        "initial_stiffness": {curve["over"]: curve["initial_stiffness"]} if curve else {},
        "departure": 0.0,
        "damaged": "",
    }
    return ModelFacts(**{each.name: (older | facts)[each.name] for each in fields(ModelFacts)})


def _fields(scene: Scene, folder: Path) -> dict[str, Any]:
    """The way, the found path and the fields."""
    with open(folder / FIELDS, "rb") as file, np.load(file, allow_pickle=False) as arrays:
        held = put_together(str(arrays[_STRUCTURE]), arrays, Planes, FoundPath, Vertex)
    fields = held["fields"]
    return {
        "way": held["way"],
        "found": held["found"],
        "kept": None if fields is None else Fields.from_data(scene, fields),
    }
