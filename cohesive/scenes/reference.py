"""The measured curves that a scene names, read from their files."""

from __future__ import annotations

import csv

import numpy as np

from ..errors import SceneError
from .measured import Measured, Reference, rising
from .scene import Scene


def load_reference(scene: Scene) -> Reference | None:
    """The measured curve that the scene names.

    Raises
    ------
    SceneError
        If the file is not a CSV with the expected columns of finite numbers.
    """
    if scene.reference is None:
        return None
    path = scene.file(scene.reference.file)
    key = f"reference.file = {scene.reference.file!r}"
    try:
        lines = [line for line in path.read_text(encoding="utf-8").splitlines() if line.strip() and line[0] != "#"]
        rows = list(csv.reader(lines))
        # units may follow a name, and the opening may be called CMOD
        names = [name.strip().lower().removesuffix("_mm").removesuffix("_n").replace("cmod", "opening") for name in rows[0]]
        columns = dict(zip(names, np.array(rows[1:], dtype=float).T, strict=True))
        low, high = (columns.get(name, columns.get("load")) for name in ("load_min", "load_max"))
        if "opening" not in columns or low is None or high is None:
            raise SceneError(f"{key}: its columns are {', '.join(names)}; expected opening and load, or load_min and load_max")
        if not all(np.isfinite(column).all() for column in columns.values()):
            raise SceneError(f"{key}: expected finite numbers")
    except (OSError, ValueError, IndexError) as error:
        if isinstance(error, SceneError):
            raise
        raise SceneError(f"{key}: cannot be read as a CSV of numbers: {error}") from None
    x, low = rising(columns["opening"], low)
    _, high = rising(columns["opening"], high)
    return Reference(scene.reference.label, "opening", (Measured(path.name, x, low, high, "load" not in columns),))
