"""`python -m cohesive` and the command `cohesive`."""

import os
import sys


def main() -> int:
    """Run the command line; returns the exit status."""
    # the matrices are small: more threads gain nothing, and on a busy machine they wait for each other
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    try:
        from .cli import main as command_line

        return command_line()
    except KeyboardInterrupt:
        print("cohesive: interrupted", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
