"""One run at a time writes into a folder."""

from __future__ import annotations

import errno
import os
import platform
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

from ..errors import SceneError
from .files import make_folder

try:
    import fcntl
except ImportError:  # Windows has no such locks: two runs into one folder are not told apart there
    fcntl = None  # type: ignore[assignment]

_NAME = ".lock"

#: folders that this process holds, with the thread that does
_HELD: dict[Path, int] = {}


@contextmanager
def held(folder: str | Path | None) -> Iterator[None]:
    """Hold a folder for one run: it is made, and taken away again if nothing has been written into it. What holds it already
    in this thread may hold it again. The system lets go of it if the process is killed.

    Raises
    ------
    SceneError
        If another run holds it, naming that one, or if the folder cannot be written.
    """
    if folder is None:
        yield
        return
    folder = Path(folder)
    own = folder.resolve()
    if _HELD.get(own) == threading.get_ident():
        yield
        return
    is_new = not folder.exists()
    make_folder(folder)
    lock = _lock(folder)
    _HELD[own] = threading.get_ident()
    try:
        yield
    finally:
        del _HELD[own]
        with suppress(OSError):
            (folder / _NAME).unlink()
        if lock is not None:
            lock.close()
        if is_new:
            with suppress(OSError):  # unless it is empty
                folder.rmdir()


def _lock(folder: Path) -> IO[str] | None:
    """The open and locked file; None if the file system has no locks."""
    if fcntl is None:
        return None
    path = folder / _NAME
    while True:
        file = open(path, "a+", encoding="utf-8")  # noqa: SIM115  it stays open as long as the lock
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if os.fstat(file.fileno()).st_ino == path.stat().st_ino:
                break
        except FileNotFoundError:  # taken away by the run that held it: again
            pass
        except OSError as error:
            if error.errno not in (errno.EAGAIN, errno.EACCES):
                file.close()
                return None
            file.seek(0)
            other = file.read().strip() or "another run"
            file.close()
            raise SceneError(f"output folder '{folder}': {other} writes there; expected another folder") from None
        file.close()
    file.truncate(0)
    file.write(f"the run of process {os.getpid()} on {platform.node()}, begun at {time.strftime('%H:%M:%S')},")
    file.flush()
    return file
