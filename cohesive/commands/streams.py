"""What a process prints on: a command goes on, and saves, if nobody listens any more, a stream is closed or a disk full."""

from __future__ import annotations

import errno
import io
import os
import select
import sys
from typing import Any, TextIO

#: descriptors of standard input, output and error
_STANDARD = (0, 1, 2)


class _Patient(io.FileIO):
    """A stream that takes everything. The first error is kept; what comes after it goes nowhere.

    Attributes
    ----------
    failure : OSError, or None
    """

    failure: OSError | None = None

    def write(self, content: Any, /) -> int:
        """Write bytes; their number."""
        if self.failure is None:
            try:
                while (count := super().write(content)) is None:  # a pipe that does not block is full: its reader is slow
                    select.select([], [self], [])
                return count
            except OSError as error:
                self.failure = error
        return memoryview(content).nbytes


def make_patient() -> None:
    """Open standard streams that are closed, to nowhere, and let those that are open take whatever is printed: a character
    that the encoding does not have is written as its number."""
    for number in _STANDARD:
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest free number, which is this one: no file of a run may have it
    if sys.stdout is None or sys.stdout is sys.__stdout__:
        sys.stdout = _patient(sys.stdout, 1)
    if sys.stderr is None or sys.stderr is sys.__stderr__:
        sys.stderr = _patient(sys.stderr, 2)


def _patient(stream: TextIO | None, number: int) -> TextIO:
    if os.name != "posix" and isinstance(stream, io.TextIOWrapper):  # a console of Windows is no file
        stream.reconfigure(errors="backslashreplace")
        return stream
    encoding = stream.encoding if stream is not None else "utf-8"
    raw = _Patient(number, "w", closefd=False)
    is_live = number == _STANDARD[-1] or raw.isatty()
    return io.TextIOWrapper(io.BufferedWriter(raw), encoding, "backslashreplace", line_buffering=is_live)


def failure() -> OSError | None:
    """Why something printed on standard output is lost; None if nothing is, or if its reader has left, as `head` does."""
    sys.stdout.flush()
    raw = getattr(getattr(sys.stdout, "buffer", None), "raw", None)
    error = raw.failure if isinstance(raw, _Patient) else None
    return None if error is None or error.errno == errno.EPIPE else error
