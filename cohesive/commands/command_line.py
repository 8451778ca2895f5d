"""The parser of all commands, and what their errors end in."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from importlib import metadata

from meshing.errors import MeshError

from ..errors import SceneError
from . import compare, evaluate, fit, keys, law, run, scenes, show, sweep, trade
from .common import BAD_INPUT, INTERRUPTED, gather_ranks


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point; returns the exit status."""
    options = parser().parse_args(arguments)
    try:
        gather_ranks(options)
        return int(options.execute(options))
    except (SceneError, MeshError) as error:
        print(f"cohesive: {error}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt as error:
        print(f"cohesive: {str(error) or 'interrupted'}; what was written until then is complete", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:  # the reader of the output has left, as `head` does
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0


def parser() -> argparse.ArgumentParser:
    """The parser of the command line."""
    whole = argparse.ArgumentParser(prog="cohesive", description="Rough cracks in concrete, discrete and smeared.")
    whole.add_argument("--version", action="version", version=f"cohesive-cracks {metadata.version('cohesive-cracks')}")
    commands = whole.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for command in (run, show, compare, trade, sweep, fit, evaluate, law, scenes, keys):
        command.add_parser(commands)
    return whole
