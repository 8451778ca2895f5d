"""The command line of an example: `python -m examples.NAME [-o DIR]`."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any


def command(main: Callable[..., Any], doc: str | None, figure: str) -> None:
    """Run an example at its full size and save its figure in the folder that the user names."""
    parser = argparse.ArgumentParser(description=(doc or "").split("\n")[0])
    parser.add_argument("-o", "--output", type=Path, default=Path("out"), help="folder for the figure")
    folder: Path = parser.parse_args().output
    folder.mkdir(parents=True, exist_ok=True)
    main(plot=folder / figure)
