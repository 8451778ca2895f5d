"""One run at a time writes into a folder."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from filelock import FileLock, Timeout

from ..errors import SceneError
from .files import make_folder

_NAME = ".lock"


@contextmanager
def lock_folder(folder: str | Path | None) -> Iterator[None]:
    """Hold a folder for one run: it is made, and taken away again if nothing has been written into it. What holds it already
    in this thread may hold it again. The system lets go of it if the process is killed.

    Raises
    ------
    SceneError
        If another run holds it, or if the folder cannot be written.
    """
    if folder is None:
        yield
        return
    folder = Path(folder)
    is_new = not os.path.exists(folder)
    make_folder(folder)
    path = folder.resolve() / _NAME
    lock = FileLock(path, timeout=0, is_singleton=True)
    try:
        if path.is_symlink():  # which leads out of the folder; older releases of filelock follow it
            raise OSError(errno.ELOOP, os.strerror(errno.ELOOP))
        lock.acquire()
        if not path.exists():  # one that ended in this moment has taken the file away, and a third one may make it anew
            lock.release()
            raise Timeout(str(path))
    except Timeout:
        raise SceneError(f"output folder '{folder}': another run writes there; expected another folder") from None
    except OSError as error:
        raise SceneError(f"output folder '{folder}': {_NAME} cannot be locked: {error.strerror}") from None
    try:
        yield
    finally:
        if lock.lock_counter == 1:
            path.unlink(missing_ok=True)
        lock.release()
        if is_new:
            with suppress(OSError):  # unless it is empty
                folder.rmdir()
