"""The pages of the guide: their code runs, their links lead somewhere, and the site's index names each."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

GUIDE = Path(__file__).parents[1] / "examples" / "guide"
PAGES = sorted(page for page in GUIDE.rglob("*.md") if "generated" not in page.parts)
BLOCK = re.compile(r"```python\n(.*?)```", flags=re.DOTALL)
CODE = {page: "\n".join(BLOCK.findall(page.read_text(encoding="utf-8"))) for page in PAGES}

#: pages whose code takes more than about two seconds
LONG = {"2-size-effect", "6-paths", "7-smeared", "8-identification", "many-runs", "python", "test-to-material"}


def named(page: Path) -> str:
    return page.stem


@pytest.mark.parametrize(
    "page",
    [pytest.param(page, marks=pytest.mark.slow if page.stem in LONG else ()) for page, code in CODE.items() if code],
    ids=named,
)
def test_the_code_of_a_page_runs(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Assertions in it are the answers to exercises."""
    monkeypatch.chdir(tmp_path)
    exec(compile(CODE[page], page.name, "exec"), {"__name__": "__main__"})


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_the_links_of_a_page_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#\s]+)(?:#[\w-]+)?\)", page.read_text(encoding="utf-8")):
        if not target.startswith("http") and "generated/" not in target:
            assert (page.parent / target).exists(), target


def test_the_index_names_every_page() -> None:
    trees = re.findall(r"```{toctree}\n(.*?)```", "".join(p.read_text(encoding="utf-8") for p in PAGES), flags=re.DOTALL)
    listed = {line.split("/")[-1] for tree in trees for line in tree.splitlines() if line and not line.startswith(":")}
    assert {page.stem for page in PAGES} - {"index"} <= listed
