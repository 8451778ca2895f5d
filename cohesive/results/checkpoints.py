"""Checkpoints: where a run stands, as data in a file, from which one that was killed goes on."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypedDict

import numpy as np

from ..arrays import Array
from ..errors import SceneError
from ..growth.found import FoundPath, Vertex
from ..scenes.scene import Scene
from ..solver.loading import Actuator, Loading
from ..solver.newton import Equilibrium
from ..solver.problem import Problem, Springs, State
from ..solver.steps import Step
from .archive import check_fits, classes_in, fits, packed, taken_apart, unpacked
from .files import package_version

if TYPE_CHECKING:
    from ..model.model import Model
    from ..solver.stepper import LoadStepper

#: name of the file; it is there while a run is going on, and after one that was interrupted or killed
NAME = "checkpoint.data"

#: what a stepper's data are made of, besides the state of the points
_CLASSES = (Actuator, Equilibrium, Loading, Springs, State, Step)

#: a row of the history and its state
Done = tuple[dict[str, float], State]


class _Head(TypedDict):
    """The first value in the file."""

    version: str
    folder: str
    scene: str
    tangent: Literal["consistent", "secant"]
    found: FoundPath | None
    nodes: Array


@dataclass(frozen=True)
class Checkpoint:
    """What a run goes on from.

    Attributes
    ----------
    path : of the file
    scene : Scene
    tangent : of Newton's method, see `run`
    found : FoundPath, if the crack path was looked for
    nodes : (m, d) array, coordinates in the mesh, mm
    begin : where the rows begin in the file
    """

    path: Path
    scene: Scene
    tangent: str
    found: FoundPath | None
    nodes: Array
    begin: int

    @classmethod
    def read(cls, folder: Path) -> Checkpoint:
        """That in a folder.

        Raises
        ------
        SceneError
            If there is none.
        """
        path, version = folder / NAME, package_version("cohesive-cracks")
        if os.path.islink(path):  # the run would go on writing there
            raise SceneError(f"'{path}': it is a link to elsewhere; expected the checkpoint itself")
        try:
            with open(path, "rb") as file:
                head = unpacked(file, FoundPath, Vertex)
                begin = file.tell()
            if not isinstance(head, dict) or head["version"] != version:
                written = str(head["version"])[:40] if isinstance(head, dict) else "none"
                raise SceneError(f"'{path}': was written by version {written}; expected {version}")
            check_fits(_Head, head)
            scene = Scene(json.loads(head["scene"]), head["folder"])
            return cls(path, scene, head["tangent"], head["found"], head["nodes"], begin)
        except FileNotFoundError:
            raise SceneError(
                f"'{folder}': there is no {NAME} to resume from; a run that came to its end leaves none behind"
            ) from None
        except (OSError, EOFError, AttributeError, KeyError, ValueError, TypeError) as error:
            raise _refused(path, error) from None

    def done(self, model: Model) -> tuple[list[Done], dict[str, Any] | None, int]:
        """The rows and states until then, the data of the stepper after them (None before the first checkpoint), and the size
        of the file up to there, bytes.

        Parameters
        ----------
        model : of the scene, built again

        Raises
        ------
        SceneError
            If the mesh came out differently, or the file is broken.
        """
        if not np.array_equal(model.mesh.points, self.nodes):
            raise SceneError(
                "the mesh came out differently from that of the run that is to be resumed; expected the same gmsh on the same "
                "kind of machine, or a run from the beginning"
            )
        rows: list[Done] = []
        stepper, size, initial = None, self.begin, model.problem.initial()
        shapes = _shapes(initial)
        try:
            with open(self.path, "rb") as file:
                file.seek(size)
                while True:
                    own, stepper = unpacked(file, *_CLASSES, *classes_in(initial))
                    _check_rows(own, [column.name for column in model.columns], [*rows[:1], *own])
                    for state in _states_in([own, stepper]):
                        if not _is_like(_shapes(state), shapes):
                            raise ValueError("a state has other unknowns or points than the model")
                    rows += own
                    size = file.tell()
        except EOFError:  # a run may be killed while the last one is written
            return rows, stepper, size
        except (OSError, AttributeError, KeyError, ValueError, TypeError) as error:
            raise _refused(self.path, error) from None

    def restore(self, stepper: LoadStepper, data: dict[str, Any]) -> None:
        """Let a stepper stand where that of the run stood; SceneError if the data are not those of one with these stages."""
        from ..solver.stepper import LoadStepper
        from ..solver.target_path import TargetPath

        try:
            check_fits(LoadStepper, {name: data[name] for name in LoadStepper.moving})
            check_fits(Problem, data["problem"])
            if data["path"] is not None:
                check_fits(TargetPath, {name: data["path"][name] for name in TargetPath.moving})
                control = stepper.stages[data["_number"] - 1].control
                if data["path"]["_has_begun"] and control not in data["_slack"]:
                    raise ValueError(f"its path to a target says not by how much {control} may miss it")
            stepper.go_on_from(data)
        except (IndexError, AttributeError, KeyError, ValueError, TypeError) as error:
            raise _refused(self.path, error) from None


def _check_rows(rows: Any, columns: Sequence[str], first: list[Done]) -> None:
    if fits(rows, list[tuple[dict[str, float], State]]):
        kinds = {name: type(value) for row, _ in first[:1] for name, value in row.items()}  # whole numbers stay whole
        if kinds.keys() == set(columns) and all({name: type(row[name]) for name in row} == kinds for row, _ in rows):
            return
    raise ValueError("its rows are not those of the model's history")


def _states_in(value: Any) -> Iterator[State]:
    """All states in some data."""
    if isinstance(value, State):
        yield value
    elif isinstance(value, (list, tuple)):
        for each in value:
            yield from _states_in(each)
    elif isinstance(value, dict):
        yield from _states_in(list(value.values()))
    elif isinstance(value, Step):
        yield value.equilibrium.state


def _shapes(state: State) -> dict[str, tuple[int, ...]]:
    """Of the arrays in a state."""
    return {path: array.shape for path, array in taken_apart(state)[1].items()}


def _is_like(shapes: dict[str, tuple[int, ...]], initial: dict[str, tuple[int, ...]]) -> bool:
    """Whether a state may come from the initial one: arrays that are empty there, of crack planes, may grow."""
    return shapes.keys() == initial.keys() and all(
        shape == before or (before[:1] == (0,) and shape[1:] == before[1:])
        for shape, before in ((shapes[name], before) for name, before in initial.items())
    )


def _refused(path: Path, error: Exception) -> SceneError:
    return SceneError(f"'{path}': cannot be read: {error}; expected the checkpoint of a run")


@contextmanager
def checkpoint_writer(
    folder: str | Path | None, scene: Scene, tangent: str, found: FoundPath | None, nodes: Array, size: int | None = None
) -> Iterator[Callable[[Sequence[Done], LoadStepper], None]]:
    """What appends the rows since the last checkpoint, and where the stepper stands after them, to the file in a folder;
    without a folder, for a scene that no file can hold, and once the disk is full it writes nothing.

    A record is read whole or not at all, so that a run may be killed while it is written. The file of a run that came to its
    end, or that would stop there again, is removed.

    Parameters
    ----------
    size : of the file, bytes, in which it goes on; None: it begins a new one.
    """
    path = None if folder is None else Path(folder) / NAME

    def append(value: Any, mode: str = "ab") -> None:
        nonlocal path
        assert path is not None
        try:
            with open(path, mode) as file:
                file.write(packed(value))
        except OSError:
            path = None

    if path is not None and size is not None:
        with open(path, "r+b") as file:
            file.truncate(size)
    elif path is not None:
        version, where = package_version("cohesive-cracks"), str(scene.folder.resolve())  # to be resumed from anywhere
        own = {"version": version, "folder": where, "tangent": tangent, "found": found, "nodes": nodes}
        try:
            path.unlink(missing_ok=True)  # it may be a link to elsewhere
            append(own | {"scene": json.dumps(scene.data)}, "xb")
        except TypeError:  # a curve of the user's own
            path.unlink(missing_ok=True)
            path = None

    def write(rows: Sequence[Done], stepper: LoadStepper) -> None:
        if path is not None:
            append((list(rows), stepper.as_data()))

    is_done = True
    try:
        yield write
    except (KeyboardInterrupt, SceneError):
        is_done = False
        raise
    finally:
        if is_done and path is not None:
            path.unlink(missing_ok=True)
