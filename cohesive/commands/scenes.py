"""`cohesive scenes [NAME]`."""

from __future__ import annotations

import argparse

from ..scenes.scene import Scene, built_in
from .common import Commands


def add_parser(commands: Commands) -> None:
    """The command's arguments."""
    p = commands.add_parser("scenes", help="list the built-in scenes, or print one", description="Built-in scenes.")
    p.add_argument("name", nargs="?", help="print this scene's TOML, a start for your own")
    p.set_defaults(execute=_execute)


def _execute(options: argparse.Namespace) -> int:
    if options.name:
        scene = Scene.load(options.name)
        print((scene.folder / f"{options.name}.toml").read_text(encoding="utf-8"), end="")
        return 0
    for name in built_in():
        print(f"{name:18s} {Scene.load(name).title}")
    return 0
