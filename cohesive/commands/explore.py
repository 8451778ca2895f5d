"""`cohesive explore SCENE`."""

from __future__ import annotations

import argparse
import sys

from .common import Commands, add_set, load_scene


def add_parser(commands: Commands) -> None:
    """The command's arguments."""
    p = commands.add_parser(
        "explore",
        help="move the numbers of a scene in a browser",
        description="A page on this machine alone (127.0.0.1, with a token in its address) with sliders for E, ft, Gf and the "
        "notch, and choices of softening curve and contact: load curve, crack profile and softening curve follow. A measured "
        "CSV dropped on the page is drawn beneath and fitted from where the sliders stand. Nothing is written.",
    )
    p.add_argument("scene", metavar="SCENE", help="a TOML file, or a built-in scene")
    add_set(p, "change a key")
    p.add_argument("--port", type=int, default=0, help="default: a free one")
    p.add_argument("--no-browser", action="store_true", help="print the address only")
    p.set_defaults(execute=_execute)


def _execute(options: argparse.Namespace) -> int:
    import webbrowser

    from ..errors import SceneError
    from ..explore.explorer import Explorer
    from ..explore.server import ExploreServer

    explorer = Explorer(load_scene(options))
    if error := explorer.answer({}).get("error"):
        raise SceneError(f"explore {options.scene}: {error}")
    try:
        server = ExploreServer(explorer, options.port)
    except (OSError, OverflowError) as error:
        raise SceneError(f"--port {options.port}: {error}; expected a free port") from None
    print(f"{server.address}  (Ctrl-C ends it)", flush=True)
    if not options.no_browser and sys.stdout.isatty():
        webbrowser.open(server.address)
    try:
        server.serve_forever()
    except KeyboardInterrupt:
        if str(sys.exc_info()[1]):  # terminated: the status says so
            raise
    finally:
        server.server_close()
    return 0
