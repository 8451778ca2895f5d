"""Copies of the files that a scene names, in a folder of their own beside its results: none takes the name of another file.

`inputs/sources.txt` lists the copies and where they came from. A later run into the same folder removes those on the list,
and nothing else that stands there.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from operator import methodcaller
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import SceneError
from .files import make_folder, write_file, write_text

if TYPE_CHECKING:
    from ..scenes.scene import Scene

_FOLDER, _LIST = "inputs", "sources.txt"


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
    data = scene.data
    named: list[tuple[str, Path, bytes | None]] = []
    for table in ("specimen", "reference"):
        names = data.get(table, {}).get("file")
        for i, name in enumerate([names] if isinstance(names, str) else names or []):
            kept = contents[i] if table == "reference" and i < len(contents) else None
            named.append((table, scene.file(name), kept))
    inside = folder / _FOLDER
    old = _listed(inside)
    read = [_bytes(source) if kept is None else kept for _, source, kept in named]
    copies = _names([source for _, source, _ in named], inside, old)
    if named:
        make_folder(inside)
    for content, name in zip(read, copies, strict=True):
        write_file(inside / name, methodcaller("write_bytes", content))
    for stale in old.keys() - set(copies):
        (inside / stale).unlink(missing_ok=True)
    ours = {}
    for (_, source, _), name in zip(named, copies, strict=True):
        if not _is_in(source, inside):
            ours[name] = str(source)
        elif name in old:
            ours[name] = old[name]
    _write_list(inside, ours)
    for table in ("specimen", "reference"):
        here = [f"{_FOLDER}/{name}" for (of, _, _), name in zip(named, copies, strict=True) if of == table]
        if here:
            data[table]["file"] = here if isinstance(data[table]["file"], list) else here[0]
    return data


def _bytes(source: Path) -> bytes:
    try:
        return source.read_bytes()
    except OSError as error:
        raise SceneError(f"'{source}': cannot be read: {error.strerror or error}") from None


def _is_in(source: Path, inside: Path) -> bool:
    return source.resolve().parent == inside.resolve()


def _listed(inside: Path) -> dict[str, str]:
    """Copies of an earlier run and their sources."""
    try:
        lines = (inside / _LIST).read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError):
        return {}
    pairs = (line.partition("\t") for line in lines if "\t" in line)
    return {name: source for name, _, source in pairs if name == Path(name).name}


def _names(sources: Sequence[Path], inside: Path, old: Mapping[str, str]) -> list[str]:
    """A name for each copy: its own if that is free, else with a number. Files that are there already keep theirs."""
    taken = {_LIST, *(source.name for source in sources if _is_in(source, inside))}
    names = []
    for source in sources:
        name, number = source.name, 1
        while not _is_in(source, inside) and (name in taken or (name not in old and (inside / name).exists())):
            number += 1
            name = f"{source.stem}-{number}{source.suffix}"
        taken.add(name)
        names.append(name)
    return names


def _write_list(inside: Path, copies: Mapping[str, str]) -> None:
    """The list of copies; without any it goes, and the folder with it if nothing else is there."""
    if copies:
        write_text(inside / _LIST, "".join(f"{name}\t{source}\n" for name, source in copies.items()))
    elif inside.is_dir():
        (inside / _LIST).unlink(missing_ok=True)
        if not any(inside.iterdir()):
            inside.rmdir()
