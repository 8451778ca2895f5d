"""Checkpoints: the whole state of a march in a file, from which a run that was killed goes on."""

from __future__ import annotations

import pickle
from collections.abc import Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import SceneError
from .files import package_version

if TYPE_CHECKING:
    from ..model.model import Model
    from ..scenes.scene import Scene
    from ..solver.problem import State
    from ..solver.stepper import LoadStepper

#: name of the file; it is there while a run is going on, and after one that was interrupted or killed
NAME = "checkpoint.pickle"

#: a row of the history and its state
Done = tuple[dict[str, float], "State"]


@dataclass(frozen=True)
class Checkpoint:
    """What a run goes on from.

    Attributes
    ----------
    scene : Scene
    tangent : of Newton's method, see `run`
    done : list of rows and states until then
    nodes : coordinates in the mesh, (m, d), mm
    march : pickled LoadStepper, see `march_on`; None before the first checkpoint
    size : of the file up to there, bytes
    """

    scene: Scene
    tangent: str
    done: list[Done]
    nodes: Any
    march: bytes | None
    size: int

    @classmethod
    def read(cls, folder: Path) -> Checkpoint:
        """The last complete one in a folder.

        Raises
        ------
        SceneError
            If there is none.
        """
        path = folder / NAME
        done: list[Done] = []
        march = None
        try:
            with open(path, "rb") as file:
                head = pickle.load(file)
                size = file.tell()
                while (record := _next(file)) is not None:
                    rows, march = record
                    done += rows
                    size = file.tell()
        except FileNotFoundError:
            raise SceneError(
                f"'{folder}': there is no {NAME} to resume from; a run that came to its end leaves none behind"
            ) from None
        except (OSError, pickle.UnpicklingError, EOFError, AttributeError, ImportError, ValueError, TypeError) as error:
            raise SceneError(f"'{path}': cannot be read: {error}; expected the checkpoint of a run") from None
        if head["version"] != package_version("cohesive-cracks"):
            raise SceneError(
                f"'{path}': was written by version {head['version']}; expected {package_version('cohesive-cracks')}"
            )
        return cls(head["scene"], head["tangent"], done, head["nodes"], march, size)

    def march_on(self, model: Model) -> LoadStepper | None:
        """The march as it stood, on the model of this scene, built again; None before the first checkpoint.

        Raises
        ------
        SceneError
            If the mesh came out differently.
        """
        if not np.array_equal(model.mesh.points, self.nodes):
            raise SceneError(
                "the mesh came out differently from that of the run that is to be resumed; expected the same gmsh on the same "
                "kind of machine, or a run from the beginning"
            )
        if self.march is None:
            return None
        march: LoadStepper = _Unpickler(BytesIO(self.march), model).load()
        return march


def _next(file: Any) -> tuple[list[Done], bytes] | None:
    """The next record; None at the end, and if the last one was not written whole."""
    try:
        record: tuple[list[Done], bytes] = pickle.load(file)
    except (EOFError, pickle.UnpicklingError):
        return None
    return record


class CheckpointWriter:
    """Appends checkpoints to the file in a folder; without a folder, or a scene that cannot be pickled, it writes nothing.

    A record is read whole or not at all, so that a run may be killed while it is written.
    """

    def __init__(self, folder: str | Path | None, scene: Scene, tangent: str, model: Model, after: Checkpoint | None) -> None:
        self._path = None if folder is None else Path(folder) / NAME
        self._model = model
        if self._path is None:
            return
        if after is not None:
            with open(self._path, "r+b") as file:
                file.truncate(after.size)
            return
        scene = type(scene)(scene.data, scene.folder.resolve())  # to be resumed from anywhere
        head = {"version": package_version("cohesive-cracks"), "scene": scene, "tangent": tangent, "nodes": model.mesh.points}
        try:
            self._append(pickle.dumps(head), "wb")
        except (pickle.PicklingError, AttributeError, TypeError):  # a curve of the user's own
            self._path.unlink(missing_ok=True)
            self._path = None

    def __enter__(self) -> CheckpointWriter:
        return self

    def write(self, rows: Sequence[Done], march: LoadStepper) -> None:
        """Set down the rows since the last checkpoint, and the march as it stands after them."""
        if self._path is None:
            return
        text = BytesIO()
        _Pickler(text, self._model).dump(march)
        self._append(pickle.dumps((list(rows), text.getvalue())), "ab")

    def _append(self, record: bytes, mode: str) -> None:
        """At the end of the file; the run goes on without further checkpoints if the disk is full."""
        assert self._path is not None
        try:
            with open(self._path, mode) as file:
                file.write(record)
        except OSError:
            self._path = None

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        """A run that came to its end, or that would stop there again, is not to be resumed."""
        if self._path is not None and not isinstance(error, (KeyboardInterrupt, SceneError)):
            self._path.unlink(missing_ok=True)


def _shared(model: Model) -> dict[str, Any]:
    """What the march and the model have in common, which is built anew and not written."""
    problem = model.problem
    parts = ("point_law", "operator", "stiffness", "measures", "start")
    return {"model": model} | {name: getattr(problem, name) for name in parts if getattr(problem, name) is not None}


class _Pickler(pickle.Pickler):
    """Writes the names of what is shared."""

    def __init__(self, file: BytesIO, model: Model) -> None:
        super().__init__(file)
        self._names = {id(part): name for name, part in _shared(model).items()}

    def persistent_id(self, each: Any) -> str | None:
        return self._names.get(id(each))


class _Unpickler(pickle.Unpickler):
    """Finds what is shared by its name."""

    def __init__(self, file: BytesIO, model: Model) -> None:
        super().__init__(file)
        self._parts = _shared(model)

    def persistent_load(self, name: str) -> Any:
        return self._parts[name]
