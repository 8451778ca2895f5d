"""The parser of all commands, and what their errors end in."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from importlib import metadata

from meshing.errors import MeshError

from ..errors import SceneError
from . import compare, evaluate, explore, fit, keys, law, report, run, scenes, show, sweep, trade
from .common import BAD_INPUT, INTERRUPTED, gather_ranks

#: the modules of the commands, in the order of the help
COMMANDS = (run, show, compare, report, explore, trade, sweep, fit, evaluate, law, scenes, keys)


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point; returns the exit status."""
    options = _parser().parse_args(arguments)
    try:
        gather_ranks(options)
        return int(options.execute(options))
    except (SceneError, MeshError) as error:
        print(f"cohesive: {error}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt as error:
        print(f"cohesive: {str(error) or 'interrupted'}; what was written until then is complete", file=sys.stderr)
        return INTERRUPTED
    except OSError as error:
        if error.filename is None:
            raise
        print(f"cohesive: '{error.filename}': {error.strerror}", file=sys.stderr)
        return BAD_INPUT


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="cohesive", description="Rough cracks in concrete, discrete and smeared.")
    parser.add_argument("--version", action="version", version=f"cohesive-cracks {metadata.version('cohesive-cracks')}")
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for command in COMMANDS:
        command.add_parser(commands)
    return parser
