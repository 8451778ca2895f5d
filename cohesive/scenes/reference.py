"""Measured curves that a scene names, and how far a run lies from them."""

from __future__ import annotations

import csv
from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..errors import SceneError
from .scene import Scene


@dataclass(frozen=True)
class Reference:
    """A measured curve or band: opening (n,), load_min (n,), load_max (n,)."""

    label: str
    opening: Array
    load_min: Array
    load_max: Array

    def check(self, opening: Array, load: Array) -> list[tuple[float, float, float, bool]]:
        """(opening, load, distance as a part of the nearer bound, inside) at each measured point that the run reached."""
        rows = []
        for x, low, high in zip(self.opening, self.load_min, self.load_max, strict=True):
            if x > opening.max() * (1.0 + 1e-9):
                continue
            y = float(np.interp(x, np.r_[0.0, opening], np.r_[0.0, load]))
            away = (y - low) / low if y < low else (y - high) / high if y > high else 0.0
            rows.append((float(x), y, float(away), low <= y <= high))
        return rows


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
    return Reference(scene.reference.label, columns["opening"], low, high)
