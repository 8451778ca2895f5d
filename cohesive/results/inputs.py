"""Copies of the files that a scene names, in a folder of their own beside its results: none takes the name of another file.

`inputs/sources.txt` lists the copies and where they came from. A later run into the same folder removes those on the list,
and nothing else that stands there.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from operator import methodcaller
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import SceneError
from .files import INPUTS, make_folder, write_file, write_text

if TYPE_CHECKING:
    from ..scenes.scene import Scene

_LIST = "sources.txt"


def copy_inputs(scene: Scene, folder: Path, contents: Sequence[bytes] = ()) -> dict[str, Any]:
    """Copy the files that a scene names and return its data with the names of the copies.

    Parameters
    ----------
    folder : of the results
    contents : the measured files as they were read, so that a file which the run itself overwrites is kept as it was; read
        now if there are none.

    Raises
    ------
    SceneError
        If a file cannot be read or written.
    """
    data, inside = scene.data, folder / INPUTS
    named: list[tuple[str, Path, bytes]] = []
    for table in ("specimen", "reference"):
        names = data.get(table, {}).get("file")
        for i, name in enumerate([names] if isinstance(names, str) else names or []):
            source = scene.file(name)
            named.append((table, source, contents[i] if table == "reference" and i < len(contents) else _bytes(source)))
    if named:
        make_folder(inside)
    old = _listed(inside)
    copies: dict[str, str] = {}  # sources by the names of the copies
    here: dict[str, list[str]] = {"specimen": [], "reference": []}
    for table, source, content in named:
        name, number = source.name, 1
        stands_there = source.resolve().parent == inside.resolve()
        while name in (_LIST, *copies) or (name not in old and (inside / name).exists() and not stands_there):
            number += 1
            name = f"{source.stem}-{number}{source.suffix}"
        write_file(inside / name, methodcaller("write_bytes", content))
        copies[name] = old.get(source.name, "") if stands_there else str(source)
        here[table].append(f"{INPUTS}/{name}")
    for stale in old.keys() - copies.keys():
        (inside / stale).unlink(missing_ok=True)
    lines = "".join(f"{name}\t{source}\n" for name, source in copies.items() if source)  # without the user's own in there
    if lines:
        write_text(inside / _LIST, lines)
    elif inside.is_dir():
        (inside / _LIST).unlink(missing_ok=True)
        with suppress(OSError):  # unless it is empty
            inside.rmdir()
    for table, names in here.items():
        if names:
            data[table]["file"] = names if isinstance(data[table]["file"], list) else names[0]
    return data


def _bytes(source: Path) -> bytes:
    try:
        return source.read_bytes()
    except OSError as error:
        raise SceneError(f"'{source}': cannot be read: {error.strerror or error}") from None


def _listed(inside: Path) -> dict[str, str]:
    """Copies of an earlier run and their sources."""
    try:
        lines = (inside / _LIST).read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError):
        return {}
    pairs = (line.partition("\t") for line in lines if "\t" in line)
    return {name: source for name, _, source in pairs if name == Path(name).name}
