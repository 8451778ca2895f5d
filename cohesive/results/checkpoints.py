"""Checkpoints: where a run stands, as data in a file, from which one that was killed goes on."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import Array
from ..errors import SceneError
from ..growth.found import FoundPath, Vertex
from ..scenes.scene import Scene
from ..solver.loading import Actuator, Loading
from ..solver.newton import Equilibrium
from ..solver.problem import Springs, State
from ..solver.steps import Step
from .archive import classes_in, packed, unpacked
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
            if head["version"] != version:
                raise SceneError(f"'{path}': was written by version {head['version']}; expected {version}")
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
        stepper, size = None, self.begin
        try:
            with open(self.path, "rb") as file:
                file.seek(size)
                while True:
                    own, stepper = unpacked(file, *_CLASSES, *classes_in(model.problem.initial()))
                    rows += own
                    size = file.tell()
        except EOFError:  # a run may be killed while the last one is written
            return rows, stepper, size
        except (OSError, AttributeError, KeyError, ValueError, TypeError) as error:
            raise _refused(self.path, error) from None


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
