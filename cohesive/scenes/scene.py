"""Scenes: the declarative input, as TOML or Python. Every error names its key."""

from __future__ import annotations

import codecs
import copy
import os
import tomllib
from collections.abc import Mapping, Sequence
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from meshing.paths import Line

from ..errors import SceneError
from .inputs import Inputs, known, read_inputs, without_script
from .names import hint

#: levels of tables and lists, bits of a whole number, and digits of an index into a list, that a scene may have
_DEEPEST, _MOST_BITS, _MOST_DIGITS = 20, 1000, 10

_BUILTIN = resources.files("cohesive.scenes") / "builtin"


class Scene(Inputs):
    """One simulation, described by a nested dict with the keys of the TOML file.

    It cannot be changed: `with_` makes another one.

    Parameters
    ----------
    data : mapping
    folder : where the files that the scene names are looked for.
    run_scripts : whether a .geo file may do more than describe a shape. It is a program: say so of what you trust only. It is
        read once, here; `data` has what it says in its place.

    Raises
    ------
    SceneError
        Naming the key that is missing, unknown, of the wrong type or out of range.

    Attributes
    ----------
    title, kind, specimen, sizes, material, interface, model, band, solver, reference, output : checked parts
    stages : tuple of Stage

    Examples
    --------
    >>> from cohesive import Scene
    >>> beam = Scene.load("notched-beam").with_(**{"material.ft": 3.0})
    >>> beam.kind, beam.material.ft
    ('notched-beam', 3.0)
    """

    _is_made = False

    def __init__(self, data: Mapping[str, Any], folder: str | Path = ".", run_scripts: bool = False) -> None:
        if not isinstance(data, Mapping):
            raise SceneError(f"Scene({data!r}): expected a dict with the tables of a scene; Scene.load(name) reads files")
        self.folder = Path(folder)
        self._data: dict[str, Any] = without_script(_plain(data), self.file, run_scripts)
        self.__dict__ |= vars(read_inputs(self._data, self.file))
        self._is_made = True

    def __setattr__(self, name: str, value: object) -> None:
        if self._is_made:
            raise AttributeError(f"{name}: a scene cannot be changed; expected scene.with_(...), which makes another one")
        super().__setattr__(name, value)

    @property
    def data(self) -> dict[str, Any]:
        """The nested dict as given, each time a copy; corners, edges and points in place of a .geo file."""
        return copy.deepcopy(self._data)

    def given(self, key: str) -> Any:
        """What the dict has for a dotted key, a copy; None if there is nothing."""
        place: Any = self._data
        for part in key.split("."):
            try:
                place = place[int(part)] if isinstance(place, list) else place[part]
            except (KeyError, IndexError, ValueError, TypeError):
                return None
        return copy.deepcopy(place)

    def along(self, lines: Sequence[Line]) -> Scene:
        """The scene with given crack paths, on elements of the same sizes, discrete; SceneError for a mesh of the user's."""
        own = known(self.kind, "the size of its elements", self.sizes)
        sizes = {f"mesh.{name}": getattr(own, name) for name in ("crack_size", "far_size")}
        crack = [[list(point) for point in line] for line in lines]
        scene = self.without_search(crack).with_(**sizes)
        return scene.with_(**{"model.kind": "discrete"})

    def in_plane(self) -> Scene:
        """The plane scene whose path, when it is found, is extruded, on elements of the same sizes."""
        own = known(self.kind, "the size of its elements", self.sizes)
        mesh = {name: value for name, value in self._data.get("mesh", {}).items() if name not in ("layers", "order")}
        tables = {
            "mesh": mesh | {"crack_size": own.crack_size, "far_size": own.far_size},
            "model": self._data["model"] | {"dimension": 2, "kind": "discrete"},
            "grow": self._data["grow"] | {"extrude": False},
        }
        return Scene(self._data | tables, self.folder)

    def without_search(self, crack: Any) -> Scene:
        """The scene with a given crack path."""
        data = {name: value for name, value in self._data.items() if name != "grow"}
        return Scene(data | {"specimen": data["specimen"] | {"crack": crack}}, self.folder)

    @classmethod
    def load(cls, source: str | Path, run_scripts: bool = False) -> Scene:
        """A scene from a TOML file, or a built-in one by name (see `built_in`).

        Parameters
        ----------
        run_scripts : see `Scene`

        Raises
        ------
        SceneError
            If there is no such file or name, or the file is not TOML.
        """
        if not isinstance(source, (str, Path)):
            raise SceneError(
                f"Scene.load({source!r}): expected a file or the name of a built-in scene; Scene(dict) takes a dict"
            )
        path = Path(source)
        if not os.path.isfile(path) and os.path.exists(path) and not os.path.isdir(path):
            raise SceneError(f"scene '{source}': it is a pipe or a device; expected a file")
        if not os.path.isfile(path) and path.suffix != ".toml":
            names = built_in()
            if str(source) not in names:
                raise SceneError(
                    f"scene '{source}': no such file, and no built-in scene of that name; built in are "
                    f"{', '.join(names)}{hint(str(source), names)}"
                )
            path = Path(str(_BUILTIN / f"{source}.toml"))
        try:
            data = tomllib.loads(_text(path.read_bytes()))
        except OSError as error:
            raise SceneError(f"scene '{source}': cannot be read: {error.strerror}") from None
        except (ValueError, RecursionError) as error:  # besides those of the syntax: no UTF-8, thousands of digits or levels
            raise SceneError(f"scene '{source}': not valid TOML: {error}") from None
        return cls(data, path.parent, run_scripts)

    def with_(self, **changes: Any) -> Scene:
        """A copy with some dotted keys changed, `scene.with_(**{"material.Gf": 0.07, "stage.0.to": 0.1})`.

        Raises
        ------
        SceneError
            Naming the key.
        """
        data = self.data
        for key, value in changes.items():
            *path, last = key.split(".")
            place: Any = data
            for part in path:
                if isinstance(place, dict):
                    place = place.setdefault(part, {})
                else:
                    place = _item(key, place, part)
            if isinstance(place, dict):
                place[last] = value
            else:
                _item(key, place, last)
                place[int(last)] = value
        return Scene(data, self.folder)

    def file(self, name: str) -> Path:
        """A file that the scene names: beside it, or one that comes with the built-in scenes."""
        beside, bundled = self.folder / name, Path(str(_BUILTIN / Path(name).name))
        return bundled if not os.path.exists(beside) and os.path.isfile(bundled) else beside


def _text(content: bytes) -> str:
    """The text of a TOML file: UTF-8, with a byte order mark or without, or UTF-16 with one, as PowerShell's `>` writes it."""
    is_wide = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    return content.decode("utf-16" if is_wide else "utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")


def built_in() -> list[str]:
    """Names of the built-in scenes."""
    return sorted(entry.name[:-5] for entry in _BUILTIN.iterdir() if entry.name.endswith(".toml"))


def dump_toml(data: Mapping[str, Any]) -> str:
    """A scene's dict as TOML text; what is None is left out."""
    text: str = tomli_w.dumps(_without_none(data))
    return text


def _without_none(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _without_none(entry) for key, entry in value.items() if entry is not None}
    if isinstance(value, (list, tuple)):
        return [_without_none(entry) for entry in value]
    return value


def _plain(value: Any, key: str = "", depth: int = 0) -> Any:
    """A copy with the dicts, lists and numbers of TOML, out of NumPy's and other mappings and sequences.

    Raises
    ------
    SceneError
        For what no scene holds: levels without end, text that is no UTF-8, whole numbers that are no floating-point numbers.
    """
    if depth > _DEEPEST:
        raise SceneError.at(key, f": it is nested more than {_DEEPEST} levels deep; expected the tables of a scene")
    if isinstance(value, Mapping):
        return {name: _plain(entry, f"{key}.{name}" if key else f"{name}", depth + 1) for name, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(entry, key, depth + 1) for entry in value]
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, str) and any("\ud800" <= letter <= "\udfff" for letter in value):
        raise SceneError.at(key, f" = {value!a}: it has characters that no file can hold; expected text in UTF-8")
    if isinstance(value, int) and value.bit_length() > _MOST_BITS:
        raise SceneError.at(key, f": a whole number of about {value.bit_length() * 0.30103:.0f} digits; expected fewer")
    return value


def _item(key: str, place: Any, part: str) -> Any:
    if isinstance(place, list) and part.isdecimal() and len(part) < _MOST_DIGITS and int(part) < len(place):
        return place[int(part)]
    raise SceneError.at(key, ": there is no such key in the scene")
