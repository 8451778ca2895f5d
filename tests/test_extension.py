"""A specimen, a softening curve and a control, each added in a script outside the package, and run there."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"


@pytest.mark.parametrize("name", ["own_specimen", "own_softening", "own_control"])
def test_a_script_adds_it_and_runs(name: str, tmp_path: Path) -> None:
    source = (EXAMPLES / f"{name}.py").read_text(encoding="utf-8")
    assert len(source.splitlines()) <= 40
    script = tmp_path / "script.py"
    script.write_text(source, encoding="utf-8")
    done = subprocess.run([sys.executable, script.name], cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    assert "peak load:" in done.stdout and "unaccounted" not in done.stdout
