"""What the folder of a run tells of it: read back without meshing or solving anything."""

from __future__ import annotations

import csv
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from ..arrays import Array, Index
from ..errors import SceneError
from ..scenes.scene import Scene
from ..solver.columns import Column, columns_of

_NOT_THERE = (
    "a result that was loaded from its folder has no mesh, states and equations; expected its frames to be opened in "
    "ParaView, or its scene to be run again"
)


class SavedStates(Sequence[Any]):
    """Stands in place of the states."""

    def __init__(self, rows: int) -> None:
        self._rows = rows

    @property
    def kept(self) -> Index:
        """The rows whose states there are: none."""
        return np.zeros(0, dtype=int)

    def nearest(self, row: int) -> int:
        """The row with a state that is nearest to a row."""
        raise LookupError(_NOT_THERE)

    def __getitem__(self, row: Any) -> Any:
        raise LookupError(_NOT_THERE)

    def __len__(self) -> int:
        return self._rows


@dataclass(frozen=True)
class SavedModel:
    """Stands in place of the model.

    Attributes
    ----------
    columns : of the history
    is_smeared, has_platen : as those of a Model
    active_dofs, total_dofs, library : as those of a Model
    timings : seconds
    cracks : with area and width
    """

    columns: tuple[Column, ...]
    is_smeared: bool
    has_platen: bool
    active_dofs: int
    total_dofs: int
    library: str
    timings: dict[str, float]
    cracks: SimpleNamespace

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(f"{name}: {_NOT_THERE}")


@dataclass(frozen=True)
class Saved:
    """The files of a run.

    Attributes
    ----------
    scene : Scene
    facts : of run.json
    history : columns of history.csv
    model : SavedModel
    """

    scene: Scene
    facts: dict[str, Any]
    history: dict[str, Array]
    model: SavedModel

    @classmethod
    def read(cls, folder: Path) -> Saved:
        """Read a folder.

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
            with open(folder / "history.csv", encoding="utf-8", newline="") as file:
                names, *rows = csv.reader(file)
            columns = _columns(scene)
            units = {column.name: column.unit for column in columns}
            history = {
                name: _values(text, units.get(name, "")) for name, text in zip(names, zip(*rows, strict=True), strict=True)
            }
            history = history or {name: np.zeros(0) for name in names}
            model = SavedModel(
                columns, facts["model"] == "smeared", facts["has_platen"], facts["active_dofs"], facts["total_dofs"],
                facts["library"], facts["timings"], SimpleNamespace(area=facts["crack_area"], width=facts["width"]),
            )  # fmt: skip
            return cls(scene, facts, history, model)
        except (OSError, ValueError, KeyError, TypeError) as error:
            what = f"'{error.args[0]}' is missing" if isinstance(error, KeyError) else str(error)
            raise SceneError(f"'{folder}': its files cannot be read: {what}; expected those of a run that was saved") from None


def _columns(scene: Scene) -> tuple[Column, ...]:
    specimen = scene.specimen
    return columns_of(list(specimen.gauges()), list(specimen.drives()), list(specimen.forces()))


def _values(text: Sequence[str], unit: str) -> Array:
    """Numbers of a column; whole ones of a column without a unit are integers, as in the run."""
    if not unit and all(value.isdigit() for value in text):
        return np.array([int(value) for value in text])
    return np.array([float(value) for value in text])
