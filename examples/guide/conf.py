"""The guide's site: `sphinx-build -W -b html examples/guide site`. What stands once in the code is generated from it here."""

from __future__ import annotations

import argparse
import importlib
import inspect
import json
import re
import shutil
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import cohesive
from cohesive.commands.command_line import COMMANDS
from cohesive.scenes.keys import scene_keys, specimen_kinds
from cohesive.solver.columns import COLUMNS

HERE = Path(__file__).parent
GENERATED = HERE / "generated"
sys.path.insert(0, str(HERE.parents[1]))  # the examples, which are not installed

project, author, release = "cohesive-cracks", "The cohesive-cracks developers", cohesive.__version__
copyright = author
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.mathjax", "sphinx-mathjax-offline"]
myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 3
exclude_patterns = ["README.md"]
html_theme, html_title = "furo", "Rough cracks in concrete"
napoleon_google_docstring = False
autodoc_typehints = "signature"
autodoc_member_order = "bysource"
suppress_warnings = ["myst.header", "ref.python"]


def table(head: list[str], rows: Iterator[list[str]]) -> str:
    """A Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|").replace("\n", " ") for cell in line) + " |" for line in lines)


def keys() -> str:
    """All keys of a scene, then those of each kind of specimen."""
    parts = ["# Keys of a scene", "`cohesive keys [KIND]` prints the same."]
    of_all = scene_keys()
    for name in dict.fromkeys(key.table for key in of_all):
        parts += [f"## {'[' + name + ']' if name else 'Above the tables'}", _key_table(k for k in of_all if k.table == name)]
    for kind in specimen_kinds():
        own = (key for key in scene_keys(kind) if key.table == "specimen" and key.name != "kind")
        parts += [f'## kind = "{kind}"', _key_table(own)]
    return "\n\n".join(parts)


def _key_table(keys: Iterator) -> str:  # type: ignore[type-arg]
    def row(key) -> list[str]:  # type: ignore[no-untyped-def]
        default = "needed" if key.is_needed else f"`{key.default}`" if key.default else ""
        return [f"`{key.name}`", key.type, key.unit, default, key.range, key.meaning]

    return table(["key", "type", "unit", "default", "range", "meaning"], map(row, keys))


def columns() -> str:
    """The columns of the history."""
    rows = ([f"`{c.name}`", c.unit, "yes" * c.watched, "yes" * c.unloaded, c.meaning] for c in COLUMNS)
    head = ["column", "unit", "in until", "in unload", "meaning"]
    return (
        "# Columns of the history\n\n"
        + table(head, rows)
        + ("\n\nA column for each further gauge and each named drive follows, as `deflection` or `load.pull`.")
    )


def commands() -> str:
    """The help of each command."""
    parts = ["# Commands in full"]
    choices = argparse.ArgumentParser(prog="cohesive").add_subparsers()
    for command in COMMANDS:
        command.add_parser(choices)
    for name, each in choices.choices.items():
        each.formatter_class = partial(argparse.HelpFormatter, width=100)  # whatever the terminal
        parts += [f"## cohesive {name}", f"```text\n{each.format_help()}```"]
    return "\n\n".join(parts)


def api() -> str:
    """The public names."""
    parts = ["# Functions and classes", "All are imported from `cohesive`."]
    for name in cohesive.__all__:
        home = getattr(cohesive, name)
        kind = "autoclass" if inspect.isclass(home) else "autofunction"
        members = "\n   :members:\n   :inherited-members: BaseException" if inspect.isclass(home) else ""
        parts.append(f"## {name}\n\n```{{eval-rst}}\n.. {kind}:: {home.__module__}.{home.__qualname__}{members}\n```")
    return "\n\n".join(parts)


def gallery() -> str:
    """The index of the examples, each with its script and a notebook."""
    text = (HERE.parent / "README.md").read_text(encoding="utf-8").replace("# Examples\n", "# Gallery\n", 1)
    text = text.replace("](figures/", "](../../figures/").replace("](guide/", "](../")
    text = re.sub(r"\[(own_\w+)\]\(\w+\.py\)", lambda m: f"{{download}}`{m[1]}.py <../../{m[1]}.py>`", text)
    text = re.sub(r"\]\((\w+)\.py\)", r"](../../\1.py)", text)

    def links(match: re.Match[str]) -> str:
        name = match[1]
        write(f"{name}.ipynb", notebook(name))
        return f"{match[0]}\n\n{{download}}`script <../../{name}.py>` · {{download}}`notebook <{name}.ipynb>`"

    return re.sub(r"^    python -m examples\.(\w+)(?: .*)?$", links, text, flags=re.MULTILINE)


def notebook(name: str) -> str:
    """A notebook that runs an example: its docstring, then its main function."""
    module = importlib.import_module(f"examples.{name}")
    words = {"cell_type": "markdown", "metadata": {}, "source": inspect.getdoc(module)}
    code = f'from pathlib import Path\n\nfrom examples import {name}\n\nfound = {name}.main(plot=Path("{name}.png"))'
    cell = {"cell_type": "code", "metadata": {}, "source": code, "outputs": [], "execution_count": None}
    return json.dumps({"cells": [words, cell], "metadata": {}, "nbformat": 4, "nbformat_minor": 4})


def write(name: str, text: str) -> None:
    """A generated file."""
    (GENERATED / name).write_text(text + "\n", encoding="utf-8")


shutil.rmtree(GENERATED, ignore_errors=True)
GENERATED.mkdir()
for page in (keys, columns, commands, api, gallery):
    write(f"{page.__name__}.md", page())
