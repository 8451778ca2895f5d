"""`python -m cohesive` and the command `cohesive`."""

import gc
import os
import signal
import sys
import threading
import time
from contextlib import suppress


def _leave(*_: object) -> None:
    """End at once: while modules are loaded there is nothing to save, and an exception could end in any of them."""
    os.write(2, b"cohesive: interrupted\n")
    os._exit(130)


if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
    signal.signal(signal.SIGINT, _leave)  # until `main` can tell; so nothing else is imported before

#: least exit status of a command that was interrupted
INTERRUPTED = 128

#: seconds in which the interpreter must come to a signal; else it is in a long call of gmsh or LAPACK, and the process ends
_GRACE = 1.0

#: seconds after which a process reports an error that rank 0 has not reported by then
_PATIENCE = 5.0


def main() -> int:
    """Run the command line; returns the exit status."""
    from .algebra import threads
    from .commands import streams
    from .errors import SceneError

    streams.make_patient()
    # most matrices are small: more threads gain nothing, and on a busy machine they wait for each other
    try:
        threads.begin_with_one()
    except SceneError as error:
        print(f"cohesive: {error}", file=sys.stderr)
        return 2
    # imports make many objects and no garbage: looking for it takes a tenth of a short run
    gc.set_threshold(50_000)
    from .algebra.petsc.ranks import rank_and_size

    if number := rank_and_size()[0]:
        return _other_rank(number)
    terminated = False
    seen = threading.Event()

    def interrupt(number: int, frame: object) -> None:
        seen.set()
        raise KeyboardInterrupt

    def terminate(number: int, frame: object) -> None:
        nonlocal terminated
        seen.set()
        terminated = True
        signal.signal(signal.SIGTERM, signal.SIG_IGN)  # some send it twice; what is there is being saved
        raise KeyboardInterrupt("terminated")

    signal.signal(signal.SIGTERM, terminate)
    try:
        from .commands.command_line import main as command_line

        if signal.getsignal(signal.SIGINT) in (_leave, signal.default_int_handler):
            signal.signal(signal.SIGINT, interrupt)
        _end_long_calls(seen)
        status = command_line()
        if lost := streams.failure():
            print(f"cohesive: what was printed could not be written: {lost.strerror}", file=sys.stderr)
            status = status or 2
    except KeyboardInterrupt as error:
        print(f"cohesive: {str(error) or 'interrupted'}", file=sys.stderr)
        status = 130
    gc.freeze()  # nor is there any to look for at the exit
    return 128 + signal.SIGTERM if terminated else status


def _end_long_calls(seen: threading.Event) -> None:
    """End the process if a signal comes in a call that does not return for a while: rows of the history are on disk by then.

    Parameters
    ----------
    seen : is set once the interpreter has come to the signal, and what there is is being saved.
    """
    read, write = os.pipe()
    if hasattr(os, "set_blocking"):  # on Windows since Python 3.12
        os.set_blocking(write, False)

    def watch() -> None:
        while number := os.read(read, 1)[0]:  # the system writes it at once, whatever the main thread does
            if number in (signal.SIGINT, signal.SIGTERM) and not seen.wait(_GRACE):
                word = "interrupted" if number == signal.SIGINT else "terminated"
                os.write(2, f"\ncohesive: {word}\n".encode())
                os._exit(128 + number)

    with suppress(ValueError):  # not from another thread than the main one
        signal.set_wakeup_fd(write, warn_on_full_buffer=False)
        threading.Thread(target=watch, daemon=True).start()


def _other_rank(number: int) -> int:
    """Another rank under mpiexec. Rank 0 tells the errors that all find, and its end ends all."""
    from contextlib import redirect_stderr, redirect_stdout
    from io import StringIO

    for each in (signal.SIGINT, signal.SIGTERM):
        signal.signal(each, signal.SIG_IGN)
    with redirect_stdout(StringIO()), redirect_stderr(StringIO()) as said:
        from .commands.command_line import main as command_line

        try:
            status = command_line()
        except SystemExit as end:
            status = end.code if isinstance(end.code, int) else 0
    if status:  # on a machine without the scene's file, say
        time.sleep(_PATIENCE)
        print(f"rank {number}: {said.getvalue()}", end="", file=sys.stderr)
    return status


def entry() -> None:
    """The command: run it, and leave with its exit status."""
    status = main()
    if status >= INTERRUPTED:  # an interpreter that was interrupted in an import would replace the status by its own
        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError, ValueError):  # nobody may be listening any more
                stream.flush()
        os._exit(status)
    sys.exit(status)


if __name__ == "__main__":
    entry()
