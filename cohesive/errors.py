"""All exceptions of cohesive, but for meshing's own `MeshError`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from meshing.errors import InputError


class EndsRun(BaseException):
    """What ends a run early."""

    result: object = None
    finished: Sequence[object] = ()


class SceneError(EndsRun, InputError):
    """A scene that cannot be used; the message names the key, its value and what was expected.

    Attributes
    ----------
    key : dotted key of the scene that the message is about, as in "solver.condensation"; empty if it is about no single one.
    result : everything computed before, if `run` had begun.
    finished : the runs that were finished before, if several were asked for.
    """


class ParameterError(InputError):
    """A parameter out of its range; the message names it, its value and what was expected.

    Attributes
    ----------
    key : name of the parameter
    """


class NotConverged(EndsRun, RuntimeError):
    """A step that did not converge.

    Attributes
    ----------
    key : dotted key of the scene whose change may help; empty if there is none.
    result : everything computed before the step, once `run` has passed the error on.
    finished : the runs that were finished before, if several were asked for.
    """

    def __init__(self, message: str = "", key: str = "") -> None:
        super().__init__(message)
        self.key = key


class PointFailure(NotConverged):
    """Crack planes of one point without a solution; `point` is its index."""

    def __init__(self, message: str, point: int) -> None:
        super().__init__(message)
        self.point = point

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.point), self.__dict__


class NoContact(NotConverged):
    """Jumps for which the local iteration finds no contact tractions."""


class ElementError(ValueError):
    """An element with no positive area or volume, or of a type that is not implemented."""


class Interrupted(EndsRun, KeyboardInterrupt):
    """A run that the user or a signal ended.

    Attributes
    ----------
    result : everything computed before.
    finished : the runs that were finished before, if several were asked for.
    """


class TooCostly(Exception):
    """A run that takes more iterations than it was given."""
