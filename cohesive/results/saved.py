"""What is read back from the folder of a run: its scene, and one file with all the rest of its data."""

from __future__ import annotations

import os
import zipfile
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import SceneError
from ..growth.found import FoundPath, Vertex
from ..scenes.reference import load_reference
from ..scenes.scene import Scene
from .archive import put_together, taken_apart
from .fields import Fields, Planes
from .files import RESULT, write_file
from .model_facts import ModelFacts
from .run_data import OffPath, RunData

#: entry of the file with the structure as JSON; all others are arrays
_STRUCTURE = "structure"

#: what a result has of its scene, which stands in scene.toml
_OF_THE_SCENE = ("scene", "reference")


def write_result(data: RunData, folder: Path) -> None:
    """result.npz, which `read_folder` reads back."""
    own = {each.name: getattr(data, each.name) for each in fields(data) if each.name not in _OF_THE_SCENE}
    text, arrays = taken_apart(own | {"fields": data.fields.as_data()})

    def write(path: Path) -> None:
        everything: dict[str, Any] = {_STRUCTURE: np.array(text), **arrays}
        np.savez(path, **everything)

    write_file(folder / RESULT, write)


def read_folder(folder: Path) -> dict[str, Any]:
    """What the folder of a run holds: the arguments of its result; SceneError if a file is missing or broken, or the scene
    cannot be made again."""
    for name in (RESULT, "scene.toml"):
        if not os.path.isfile(folder / name):
            raise SceneError(f"'{folder}': there is no {name}; expected the folder of a run that this version saved")
    try:
        scene = Scene.load(folder / "scene.toml")
    except SceneError as error:
        raise SceneError(f"'{folder / 'scene.toml'}': {error}", error.key) from None
    try:
        with open(folder / RESULT, "rb") as file, np.load(file, allow_pickle=False) as arrays:
            own: dict[str, Any] = put_together(str(arrays[_STRUCTURE]), arrays, FoundPath, ModelFacts, OffPath, Planes, Vertex)
        own["fields"] = Fields.from_data(scene, own["fields"])
    except (OSError, EOFError, ValueError, KeyError, TypeError, AttributeError, zipfile.BadZipFile) as error:
        what = f"'{error.args[0]}' is missing" if isinstance(error, KeyError) else str(error)
        raise SceneError(f"'{folder / RESULT}': cannot be read: {what}; expected that of a run that was saved") from None
    return own | {"scene": scene, "reference": load_reference(scene)}
