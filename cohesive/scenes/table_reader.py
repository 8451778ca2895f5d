"""From the tables of a scene to dataclasses: types and names of keys are checked here, ranges by the classes."""

from __future__ import annotations

import types
import typing
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, fields
from typing import Any

from meshing.errors import MeshError
from meshing.generation.sizes import MeshSizes
from meshing.keys import key_of

from ..errors import ParameterError, SceneError
from ..law.concrete import Concrete
from ..solver.stages import Stage
from .names import hint, refuse
from .tables import BandOptions, GrowOptions, InterfaceOptions, ModelOptions, OutputOptions, ReferenceOptions, SolverOptions

T = typing.TypeVar("T")

#: dataclass of each table but [specimen]
TABLES: dict[str, type] = {
    "grow": GrowOptions,
    "mesh": MeshSizes,
    "material": Concrete,
    "interface": InterfaceOptions,
    "model": ModelOptions,
    "band": BandOptions,
    "stage": Stage,
    "solver": SolverOptions,
    "reference": ReferenceOptions,
    "output": OutputOptions,
}

#: numbers beyond it are no lengths, forces or counts, and their squares overflow; NaN compares false as well
_LARGEST = 1e100

_KINDS = {float: "a finite number", int: "a whole number", str: "a string", bool: "true or false"}

#: keys with which a user asks for time, and what is said of them
_OF_TIME = {"hold", "creep", "relaxation", "shrinkage", "viscosity", "time", "duration", "rate", "speed", "pause", "wait"}
_NO_TIME = "time is not modelled: no creep, relaxation or rate of loading"

#: keys of earlier versions, and what takes their place
_RENAMED = {
    "solver.reduction": "solver.condensation = 'auto', 'always', 'never' or 'petsc'",
    "solver.largest_step": "solver.step_growth",
    "solver.tangent": "run(scene, tangent='secant') in Python",
    "band.shear_scaling": "material.shear_scaling",
    "band.tol": "none: the local iteration always converges to 1e-11 of ft",
    "stage.ratio": "stage.angle, the arc tangent of shear over normal motion in degrees",
}


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
            raise SceneError.at(f"{prefix}.{name}", " is missing")
    hints = typing.get_type_hints(cls)
    for name, value in table.items():
        allowed = alternatives(hints[known[name].name])
        if not any(is_a(value, kind) for kind in allowed):
            kinds = " or ".join(_KINDS[kind] for kind in allowed if kind in _KINDS)
            raise refuse(f"{prefix}.{name}", value, f"{kinds}; {_NO_TIME}" if name in _OF_TIME else kinds)
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
        raise SceneError.at(name, f" = {table!r}: expected a table [{name}]")
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
            raise SceneError.at(f"{prefix}{key}", f": this key is gone; expected {_RENAMED[old]}")
        near = "" if prefix else table_hint(key)
        one_of = f"one of {', '.join(names)}" if names else "none, as the law has none of its own"
        why = f", {_NO_TIME}" if str(key).lower() in _OF_TIME else near or hint(key, names)
        raise SceneError.at(f"{prefix}{key}", f": unknown key{why}; expected {one_of}")


def table_hint(key: str) -> str:
    """What was meant by a key without its table."""
    places = [(name, cls) for name, cls in TABLES.items() if key in (key_of(each) for each in fields(cls))]
    meant = [f"stage.0.{key}" if cls is Stage else f"{name}.{key}" for name, cls in places]
    return f" (did you mean '{meant[0]}'?)" if len(meant) == 1 else ""
