"""`cohesive keys [KIND]`."""

from __future__ import annotations

import argparse
import textwrap

from ..errors import SceneError
from ..scenes.keys import scene_keys, specimen_kinds
from ..scenes.names import hint
from .common import Commands

_WIDTH = 110


def add_parser(commands: Commands) -> None:
    """The command's arguments."""
    p = commands.add_parser(
        "keys",
        help="list the keys of a scene",
        description="All keys of a scene with unit, default, range and meaning, and those of one kind of specimen.",
    )
    p.add_argument("kind", nargs="?", help="kind of specimen whose keys are listed too, as in notched-beam")
    p.set_defaults(execute=_execute)


def _execute(options: argparse.Namespace) -> int:
    kinds = specimen_kinds()
    if options.kind is not None and options.kind not in kinds:
        raise SceneError(f"keys {options.kind}: expected one of {', '.join(kinds)}{hint(options.kind, kinds)}")
    table = None
    for key in scene_keys(options.kind):
        if key.table != table:
            table = key.table
            head = f"[[{table}]]" if table == "stage" else f"[{table}]"
            print(f"\n{head}" if table else "")
        facts = [key.type, f"in {key.unit}" if key.unit else "", key.range]
        facts.append("needed" if key.is_needed else f"default {key.default}" if key.default else "")
        print(f"  {key.name}: {', '.join(fact for fact in facts if fact)}")
        print(textwrap.fill(key.meaning, _WIDTH, initial_indent=6 * " ", subsequent_indent=6 * " "))
    if options.kind is None:
        print(f"\ncohesive keys KIND lists those of [specimen] too; KIND is one of {', '.join(kinds)}")
    return 0
