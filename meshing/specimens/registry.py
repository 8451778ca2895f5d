"""Kinds of specimens by name: those of this package, and those that a user's script registers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import is_dataclass
from typing import TypeVar

from .base import Specimen

#: class of each kind, by the name that a scene gives as `specimen.kind`
SPECIMENS: dict[str, type[Specimen]] = {}

S = TypeVar("S", bound=type[Specimen])


def register_specimen(kind: str) -> Callable[[S], S]:
    """Decorator: scenes know the class as `specimen.kind = kind`, its fields are the keys.

    Raises
    ------
    ValueError
        For a name that is taken or no string, or a class that is no dataclass derived from `Specimen`.
    """
    if not isinstance(kind, str) or not kind:
        raise ValueError(f"register_specimen({kind!r}): expected a name, as in @register_specimen('notched-beam')")

    def register(cls: S) -> S:
        taken = SPECIMENS.get(kind)
        if taken is not None and (taken.__module__, taken.__qualname__) != (cls.__module__, cls.__qualname__):
            raise ValueError(f"register_specimen('{kind}'): {taken.__qualname__} has this name; expected another one")
        if not is_dataclass(cls) or not issubclass(cls, Specimen):
            raise ValueError(f"register_specimen('{kind}'): {cls!r} is no dataclass derived from Specimen")
        SPECIMENS[kind] = cls
        return cls

    return register
