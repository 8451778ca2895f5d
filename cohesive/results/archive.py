"""Data as arrays and text: data classes, lists and tables taken apart into JSON and named arrays, and put together again."""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from functools import cache
from io import SEEK_END, BytesIO
from types import NoneType, UnionType
from typing import IO, Any, Literal, Union, get_args, get_origin, get_type_hints

import numpy as np

from ..arrays import Array

#: kinds of an entry of the text that is no plain value; each such entry is a table of one key
_ARRAY, _TUPLE, _TABLE = "array", "tuple", "table"

#: before a value in a file: its length and its checksum
_HEAD = struct.Struct("<QI")


def taken_apart(value: Any) -> tuple[str, dict[str, Array]]:
    """The structure of a value as JSON, and its arrays by their path in it.

    Parameters
    ----------
    value : None, a number, text, an array, or lists, tuples, mappings and data classes of such.

    Raises
    ------
    TypeError
        For anything else.
    """
    arrays: dict[str, Array] = {}
    return json.dumps(_apart(value, "", arrays)), arrays


def put_together(text: str, arrays: Mapping[str, Array], *classes: type) -> Any:
    """What `taken_apart` took apart.

    Parameters
    ----------
    classes : the data classes that may occur.

    Raises
    ------
    ValueError, KeyError, TypeError
        If it is nothing of this kind.
    """
    return _together(json.loads(text), arrays, {each.__name__: each for each in classes})


def _apart(value: Any, path: str, arrays: dict[str, Array]) -> Any:
    def inner(name: object, entry: Any) -> Any:
        return _apart(entry, f"{path}.{name}" if path else f"{name}", arrays)

    if isinstance(value, np.generic):
        value = value.item()
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, np.ndarray):
        arrays[path] = value
        return {_ARRAY: path}
    if isinstance(value, (list, tuple)):
        entries = [inner(i, entry) for i, entry in enumerate(value)]
        return entries if isinstance(value, list) else {_TUPLE: entries}
    if isinstance(value, Mapping):
        return {_TABLE: {name: inner(name, entry) for name, entry in value.items()}}
    if is_dataclass(value):
        own = {each.name: inner(each.name, getattr(value, each.name)) for each in fields(value) if each.init}
        return {type(value).__name__: own}
    raise TypeError(f"{path}: {type(value).__name__} is no data")


def _together(entry: Any, arrays: Mapping[str, Array], classes: Mapping[str, type]) -> Any:
    if isinstance(entry, list):
        return [_together(each, arrays, classes) for each in entry]
    if not isinstance(entry, dict):
        return entry
    ((kind, value),) = entry.items()
    if kind == _ARRAY:
        return arrays[value]
    if kind == _TUPLE:
        return tuple(_together(each, arrays, classes) for each in value)
    table = {name: _together(each, arrays, classes) for name, each in value.items()}
    if kind == _TABLE:
        return table
    check_fits(classes[kind], table)
    return classes[kind](**table)


def check_fits(cls: type, table: Mapping[str, Any]) -> None:
    """Refuse values of attributes that are not what the class says they are; TypeError."""
    hints = _hints(cls)
    for name, value in table.items():
        if not fits(value, hints.get(name, Any)):
            raise TypeError(f"{cls.__name__}.{name} is {type(value).__name__}, which it cannot be")


def fits(value: Any, hint: Any) -> bool:
    """Whether a value is what a type hint says: one of numbers, text, arrays, lists, tuples, mappings and data classes."""
    kind, inner = get_origin(hint) or hint, get_args(hint)
    if kind is Any:
        return True
    if kind in (Union, UnionType):
        return any(fits(value, each) for each in inner)
    if kind is Literal:
        return isinstance(value, str) and value in inner
    if kind is np.ndarray:
        return isinstance(value, np.ndarray) and value.dtype.kind in "biuf"
    if kind in (list, Sequence):
        return isinstance(value, (list, tuple)) and all(fits(each, inner[0]) for each in value)
    if kind is tuple:
        wanted = [inner[0]] * len(value) if inner[1:] == (...,) and isinstance(value, tuple) else list(inner)
        return isinstance(value, tuple) and len(value) == len(wanted) and all(map(fits, value, wanted))
    if kind in (dict, Mapping):
        return isinstance(value, dict) and all(fits(name, inner[0]) and fits(value[name], inner[1]) for name in value)
    if kind in (float, int):
        return isinstance(value, (int, float) if kind is float else int) and not isinstance(value, bool)
    return isinstance(value, NoneType if kind is None else kind)


@cache
def _hints(cls: type) -> dict[str, Any]:
    return get_type_hints(cls)


def packed(value: Any) -> bytes:
    """A value as bytes, see `taken_apart`: its structure, then its arrays as NumPy writes them, with length and checksum."""
    text, arrays = taken_apart(value)
    file = BytesIO()
    np.save(file, np.frombuffer(json.dumps([text, *arrays]).encode(), dtype=np.uint8), allow_pickle=False)
    for array in arrays.values():
        np.save(file, array, allow_pickle=False)
    content = file.getvalue()
    return _HEAD.pack(len(content), zlib.crc32(content)) + content


def unpacked(file: IO[bytes], *classes: type) -> Any:
    """The next value that `packed` gave in a file.

    Raises
    ------
    EOFError
        At the end of the file, and if the value was not written whole.
    ValueError, KeyError, TypeError
        If it is nothing of this kind.
    """
    head = file.read(_HEAD.size)
    if len(head) < _HEAD.size:
        raise EOFError("no value left in file")
    length, checksum = _HEAD.unpack(head)
    begin = file.tell()
    if file.seek(0, SEEK_END) - begin < length:
        raise EOFError("the last value was not written whole")
    file.seek(begin)
    content = file.read(length)
    if zlib.crc32(content) != checksum:
        raise ValueError("its content is not that which was written")
    inner = BytesIO(content)
    text, *paths = json.loads(np.load(inner, allow_pickle=False).tobytes())
    return put_together(text, {path: np.load(inner, allow_pickle=False) for path in paths}, *classes)


def classes_in(value: Any) -> set[type]:
    """The data classes that occur in a value."""
    if not is_dataclass(value) or isinstance(value, type):
        return set()
    inner = (classes_in(getattr(value, each.name)) for each in fields(value))
    return {type(value)}.union(*inner)
