"""`python -m cohesive` and the command `cohesive`."""

import gc
import os
import signal
import sys
import time


def _leave(*_: object) -> None:
    """End at once: while modules are loaded there is nothing to save, and an exception could end in any of them."""
    os.write(2, b"cohesive: interrupted\n")
    os._exit(130)


if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
    signal.signal(signal.SIGINT, _leave)  # until `main` can tell; so nothing else is imported before

#: seconds after which a process tells of an error that rank 0 has not told by then
_PATIENCE = 5.0


def main() -> int:
    """Run the command line; returns the exit status."""
    # the matrices are small: more threads gain nothing, and on a busy machine they wait for each other
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # imports make many objects and no garbage: looking for it takes a tenth of a short run
    gc.set_threshold(50_000)
    from .algebra.petsc.ranks import rank_and_size

    if number := rank_and_size()[0]:
        return _other_rank(number)
    terminated = False

    def terminate(number: int, frame: object) -> None:
        nonlocal terminated
        terminated = True
        signal.signal(signal.SIGTERM, signal.SIG_IGN)  # some send it twice; what is there is being saved
        raise KeyboardInterrupt("terminated")

    signal.signal(signal.SIGTERM, terminate)
    try:
        from .commands.command_line import main as command_line

        if signal.getsignal(signal.SIGINT) is _leave:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        status = command_line()
    except KeyboardInterrupt as error:
        print(f"cohesive: {str(error) or 'interrupted'}", file=sys.stderr)
        status = 130
    gc.freeze()  # nor is there any to look for at the exit
    return 128 + signal.SIGTERM if terminated else status


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


if __name__ == "__main__":
    sys.exit(main())
