"""THE list of a scene's keys, from the dataclasses that they are fields of: for `cohesive keys` and the reference pages."""

from __future__ import annotations

import json
import typing
from collections.abc import Iterator
from dataclasses import MISSING, dataclass, fields, replace
from typing import Any

from meshing.keys import default_of, expected, key_of
from meshing.specimens import SPECIMENS

from ..law.crack_plane import DEFAULT_LAW
from ..law.registry import LAWS
from .scene import Scene
from .table_reader import TABLES, alternatives

_TYPES = {float: "number", int: "whole number", str: "string", bool: "true or false"}


@dataclass(frozen=True)
class Key:
    """A key of a scene.

    Attributes
    ----------
    table, name : as in [table] name = ...
    type, unit, default, range, meaning : in words; empty if there is nothing to say
    is_needed : whether a scene must give it
    """

    table: str
    name: str
    type: str
    unit: str
    default: str
    range: str
    meaning: str
    is_needed: bool = False


def keys_of_table(table: str, cls: type) -> Iterator[Key]:
    """The keys of one table, in order."""
    hints = typing.get_type_hints(cls)
    for each in fields(cls):
        types = [_TYPES[kind] for kind in alternatives(hints[each.name]) if kind in _TYPES]
        meta, default = each.metadata, default_of(each)
        yield Key(
            table, key_of(each), " or ".join(types), meta.get("unit", ""), "" if default is MISSING else _text(default),
            expected(meta).removeprefix("of "), meta.get("meaning", ""), default is MISSING and not meta.get("by_rule"),
        )  # fmt: skip


def scene_keys(kind: str | None = None) -> list[Key]:
    """All keys of a scene, those of [specimen] for one kind, or none if no kind is named."""
    keys = [Key("", "title", "string", "", "untitled", "", "title of the figures and the summary")]
    keys.append(Key("specimen", "kind", "string", "", "", " or ".join(map(repr, SPECIMENS)), "kind of the specimen", True))
    if kind is not None:
        keys += keys_of_table("specimen", SPECIMENS[kind])
    for table, cls in TABLES.items():
        keys += keys_of_table(table, cls)
        if table == "material":
            keys.append(Key(table, "law", "string", "", DEFAULT_LAW, " or ".join(map(repr, LAWS)), "law of the crack planes"))
            own = ((name, key) for name, law in LAWS.items() for key in keys_of_table("law", law))
            keys += (replace(key, meaning=f"law {name!r}: {key.meaning}") for name, key in own)
    return keys


def key_units(scene: Scene) -> dict[str, str]:
    """Unit of each dotted key of a scene, empty for a number without one."""
    return {f"{key.table}.{key.name}": key.unit for key in scene_keys(scene.kind)}


def specimen_kinds() -> list[str]:
    """Kinds of specimens, those of a user's script included."""
    return list(SPECIMENS)


def _text(default: Any) -> str:
    return "" if default is None else json.dumps(default)
