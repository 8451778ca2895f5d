"""results/files"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Sequence
from contextlib import suppress
from importlib import metadata
from io import FileIO
from pathlib import Path
from types import TracebackType

from ..errors import SceneError
from .columns import COLUMNS


class HistoryWriter:
    """history.csv that grows by whole rows; without a folder it writes nothing."""

    def __init__(self, folder: str | Path | None) -> None:
        self._folder = None if folder is None else Path(folder)
        self._file: FileIO | None = None

    def __enter__(self) -> HistoryWriter:
        if self._folder is not None:
            make_folder(self._folder)
            try:
                self._file = open(self._folder / "history.csv", "wb", buffering=0)
            except OSError as error:
                raise _refused(self._folder / "history.csv", error) from None
            self._append(COLUMNS)
        return self

    def write(self, row: dict[str, float]) -> None:
        """Append a row; SceneError where the disk is full, and what has come of the row is taken away."""
        self._append([format_value(row[name]) for name in COLUMNS])

    def _append(self, row: Sequence[str]) -> None:
        if self._file is None or self._folder is None:
            return
        rest = (",".join(row) + "\n").encode()
        whole = self._file.tell()
        try:
            while rest:  # one call, but on a disk that is getting full
                rest = rest[self._file.write(rest) :]
        except OSError as error:
            with suppress(OSError):
                self._file.truncate(whole)
            raise _refused(self._folder / "history.csv", error) from None

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self._file is not None:
            self._file.close()


def format_value(value: float) -> str:
    return str(value) if isinstance(value, int) else f"{value:.12g}"


def make_folder(folder: Path) -> None:
    """Create the output folder, or a SceneError that names it."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise SceneError(f"output folder '{folder}': cannot be written: {error.strerror}") from None


def write_file(path: Path, write: Callable[[Path], None]) -> None:
    """Let `write` fill a temporary file beside `path`, then rename it: nothing is ever half-written."""
    temporary = path.with_name(f".{path.stem}.partial{path.suffix}")
    try:
        write(temporary)
        os.replace(temporary, path)
    except OSError as error:
        raise _refused(path, error) from None
    finally:
        temporary.unlink(missing_ok=True)


def _refused(path: Path, error: OSError) -> SceneError:
    return SceneError(f"'{path}': cannot be written: {error.strerror or error}")


def package_version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "not installed"


def write_text(path: Path, text: str) -> None:
    """Write UTF-8 text, for `write_file`."""
    path.write_text(text, encoding="utf-8")
