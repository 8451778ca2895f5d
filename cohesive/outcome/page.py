"""The report: one HTML file with the steps of a run, or of two, under a slider. It needs no server and no network."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Sequence
from importlib import resources
from pathlib import Path
from typing import Any

from ..results.files import write_text
from .views import Views


def write_page(views: Sequence[Views], path: Path) -> None:
    """Write the page of one run, or of two that are compared; SceneError if the file cannot be written."""
    template = resources.files("cohesive.outcome").joinpath("page.html").read_text(encoding="utf-8")
    titles = list(dict.fromkeys(each.result.scene.title for each in views))
    write_text(path, filled(template, [each.as_data() for each in views], " and ".join(titles)))


def filled(template: str, data: Any, title: str = "") -> str:
    """A page with its {{title}}, and its {{data}} as JSON: neither can be taken for a part of the page.

    Parameters
    ----------
    data : whatever JSON can hold; "<" and "&" are written as their numbers, as everything beyond ASCII is.
    """
    text = json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c").replace("&", "\\u0026")
    parts = {"{{title}}": html.escape(title), "{{data}}": text}
    return re.sub("|".join(parts), lambda found: parts[found[0]], template)  # at once: a title may be "{{data}}"
