"""Checks of a scene's keys: one for all tables. Every error names its key."""

from __future__ import annotations

import difflib
import reprlib
import types
import typing
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, fields
from typing import Any

from meshing.errors import MeshError
from meshing.keys import key_of

from ..errors import ParameterError, SceneError

T = typing.TypeVar("T")

#: numbers beyond it are no lengths, forces or counts, and their squares overflow; NaN compares false as well
_LARGEST = 1e100

_KINDS = {float: "a finite number", int: "a whole number", str: "a string", bool: "true or false"}

#: keys of earlier versions, and what takes their place
_RENAMED = {
    "solver.reduction": "solver.condensation = 'auto', 'always', 'never' or 'petsc'",
    "solver.largest_step": "solver.step_growth",
    "solver.tangent": "run(scene, tangent='secant') in Python",
    "band.shear_scaling": "material.shear_scaling",
    "band.tol": "none: the local iteration always converges to 1e-11 of ft",
    "stage.ratio": "stage.angle, the arc tangent of shear over normal motion in degrees",
}
#: kinds of specimens of earlier versions
RENAMED_KINDS = {
    "notched-beam-3d": "specimen.kind = 'notched-beam' and model.dimension = 3",
    "push-off-3d": "specimen.kind = 'push-off' and model.dimension = 3",
}


def refuse(key: str, value: Any, expected: str) -> SceneError:
    """The error for a key whose value is not what was expected."""
    return SceneError(f"{key} = {reprlib.repr(value)}: expected {expected}", key)


def build_table(cls: type[T], table: Mapping[str, Any], prefix: str) -> T:
    """An instance of a dataclass from a table.

    Raises
    ------
    SceneError
        Naming the key that is missing, unknown, of the wrong type or out of range.
    """
    known = {key_of(each): each for each in fields(cls)}  # type: ignore[arg-type]
    check_known(prefix + ".", table, known)
    for name, each in known.items():
        if each.default is MISSING and each.default_factory is MISSING and name not in table:
            raise SceneError(f"{prefix}.{name} is missing", f"{prefix}.{name}")
    hints = typing.get_type_hints(cls)
    for name, value in table.items():
        allowed = alternatives(hints[known[name].name])
        if not any(is_a(value, kind) for kind in allowed):
            raise refuse(f"{prefix}.{name}", value, " or ".join(_KINDS[kind] for kind in allowed if kind in _KINDS))
    try:
        return cls(**{known[name].name: value for name, value in table.items()})
    except (MeshError, ParameterError) as error:
        raise SceneError(f"{prefix}.{error}", f"{prefix}.{error.key}") from None
    except ValueError as error:  # of a specimen of the user's
        raise SceneError(f"{prefix}.{error}", prefix) from None


def alternatives(hint: Any) -> tuple[Any, ...]:
    """The types that a hint allows."""
    return typing.get_args(hint) if isinstance(hint, types.UnionType) else (hint,)


def is_a(value: Any, kind: Any) -> bool:
    """Whether a value of TOML is of a type that a key asks for."""
    if kind is float:
        return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < _LARGEST
    if kind is int:
        return isinstance(value, int) and not isinstance(value, bool) and abs(value) < _LARGEST
    if kind in (str, bool):
        return isinstance(value, kind)
    return kind is not type(None) or value is None  # the class checks lists and tables itself


def table_of(data: Mapping[str, Any], name: str, required: bool = False) -> dict[str, Any]:
    """A copy of a table of the scene; empty if it has none."""
    table = data.get(name, {})
    if not isinstance(table, dict):
        raise SceneError(f"{name} = {table!r}: expected a table [{name}]", name)
    if required and name not in data:
        raise SceneError(f"[{name}] is missing", name)
    return dict(table)


def check_known(prefix: str, table: Mapping[str, Any], names: Iterable[str]) -> None:
    """Refuse an unknown key, with the one that was meant."""
    names = list(names)
    for key in table:
        if key in names:
            continue
        old = f"{prefix.split('.')[0]}.{key}"
        if old in _RENAMED:
            raise SceneError(f"{prefix}{key}: this key is gone; expected {_RENAMED[old]}", f"{prefix}{key}")
        raise SceneError(f"{prefix}{key}: unknown key{hint(key, names)}; expected one of {', '.join(names)}", f"{prefix}{key}")


def hint(word: str, names: Iterable[str]) -> str:
    """What was meant by a misspelt word."""
    close = difflib.get_close_matches(str(word), list(names), 1)
    return f" (did you mean '{close[0]}'?)" if close else ""
