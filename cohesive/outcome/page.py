"""The report: one HTML file with the steps of a run, or of two, under a slider. It needs no server and no network."""

from __future__ import annotations

import html
import json
from collections.abc import Sequence
from importlib import resources
from pathlib import Path

from ..results.files import write_text
from .views import Views


def write_page(views: Sequence[Views], path: Path) -> None:
    """Write the page of one run, or of two that are compared.

    Raises
    ------
    SceneError
        If the file cannot be written.
    """
    template = resources.files("cohesive.outcome").joinpath("page.html").read_text(encoding="utf-8")
    titles = list(dict.fromkeys(each.result.scene.title for each in views))
    data = json.dumps([each.as_data() for each in views], separators=(",", ":"), allow_nan=False).replace("</", "<\\/")
    text = template.replace("{{title}}", html.escape(" and ".join(titles))).replace("{{data}}", data)
    write_text(path, text)
