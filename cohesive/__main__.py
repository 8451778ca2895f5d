"""`python -m cohesive` and the command `cohesive`."""

import gc
import os
import signal
import sys
from types import FrameType


def main() -> int:
    """Run the command line; returns the exit status."""
    # the matrices are small: more threads gain nothing, and on a busy machine they wait for each other
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # imports make many objects and no garbage: looking for it takes a tenth of a short run
    gc.set_threshold(50_000)
    terminated = False

    def terminate(number: int, frame: FrameType | None) -> None:
        nonlocal terminated
        terminated = True
        signal.signal(signal.SIGTERM, signal.SIG_IGN)  # some send it twice; what is there is being saved
        raise KeyboardInterrupt("terminated")

    signal.signal(signal.SIGTERM, terminate)
    try:
        from .cli import main as command_line

        status = command_line()
    except KeyboardInterrupt as error:
        print(f"cohesive: {str(error) or 'interrupted'}", file=sys.stderr)
        status = 130
    gc.freeze()  # nor is there any to look for at the exit
    return 128 + signal.SIGTERM if terminated else status


if __name__ == "__main__":
    sys.exit(main())
