"""scenes/checks"""

from __future__ import annotations

import difflib
import reprlib
import types
import typing
from dataclasses import MISSING, fields
from typing import Any

from meshing import MeshError

from ..errors import SceneError


def table_of(data: dict[str, Any], name: str, required: bool = False) -> dict[str, Any]:
    table = data.get(name, {})
    if not isinstance(table, dict):
        raise SceneError(f"{name} = {table!r}: expected a table [{name}]")
    if required and name not in data:
        raise SceneError(f"[{name}] is missing")
    return dict(table)


T = typing.TypeVar("T")


def build_table(cls: type[T], table: dict[str, Any], prefix: str) -> T:
    """An instance of a dataclass from a table, or a SceneError that names the key."""
    known = {field.name: field for field in fields(cls)}  # type: ignore[arg-type]
    check_known(prefix + ".", table, known)
    for name, field in known.items():
        if field.default is MISSING and field.default_factory is MISSING and name not in table:
            raise SceneError(f"{prefix}.{name} is missing")
    hints = typing.get_type_hints(cls)
    for name, value in table.items():
        hint = hints[name]
        allowed = typing.get_args(hint) if isinstance(hint, types.UnionType) else (hint,)
        if not any(is_a(value, kind) for kind in allowed):
            expected = " or ".join(_KINDS[kind] for kind in allowed if kind in _KINDS)
            raise SceneError(f"{prefix}.{name} = {reprlib.repr(value)}: expected {expected}")
    try:
        return cls(**table)
    except (ValueError, MeshError) as error:
        raise SceneError(f"{prefix}.{error}") from None


_KINDS = {float: "a finite number", int: "a whole number", str: "a string", bool: "true or false"}

#: numbers beyond it are no lengths, forces or counts, and their squares overflow; NaN compares false as well
_LARGEST = 1e100


def is_a(value: Any, kind: Any) -> bool:
    if kind is float:
        return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < _LARGEST
    if kind is int:
        return isinstance(value, int) and not isinstance(value, bool) and abs(value) < _LARGEST
    if kind in (str, bool):
        return isinstance(value, kind)
    return kind is not type(None) or value is None  # the class checks lists and tables itself


def check_known(prefix: str, table: dict[str, Any], names: typing.Iterable[str]) -> None:
    names = list(names)
    for key in table:
        if key not in names:
            raise SceneError(f"{prefix}{key}: unknown key{hint(key, names)}; expected one of {', '.join(names)}")


def hint(word: str, names: typing.Iterable[str]) -> str:
    close = difflib.get_close_matches(str(word), list(names), 1)
    return f" (did you mean '{close[0]}'?)" if close else ""
