"""errors"""

from __future__ import annotations


class SceneError(ValueError):
    """A scene that cannot be used; the message names the key, its value and what was expected."""


class NotConverged(RuntimeError):
    """A step that did not converge. `result` holds everything computed before it, once `run` has passed it on;
    `finished` the runs that `compare` had finished."""

    result: object = None
    finished: object = None


class PointFailure(NotConverged):
    """Crack planes of one point without a solution; `point` is its number."""

    def __init__(self, message: str, point: int) -> None:
        super().__init__(message)
        self.point = point


class NoContact(NotConverged):
    """Jumps for which the local iteration finds no contact tractions."""


class ElementError(ValueError):
    """An element with no positive area or volume, or of a type that is not implemented."""
