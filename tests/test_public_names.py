"""What `from cohesive import ...` and `from meshing import ...` give, at runtime and to a type checker."""

from __future__ import annotations

import importlib
import subprocess
import sys
from pathlib import Path

import pytest

import cohesive
import meshing

ROOT = Path(__file__).parents[1]

#: a user's script; each line with a mark is an error that the type checker must find
DOWNSTREAM = '''
import cohesive
import meshing
from cohesive import Interrupted, LinearControl, MeshError, NotConverged, PlaneSpecimen, Result, Scene, Sweep, run
from cohesive import Nonsense  # wrong
from meshing import Nonsense as Another  # wrong

scene: Scene = Scene.load("notched-beam")
version: str = cohesive.__version__
print(cohesive.nonsense)  # wrong
try:
    result = run(scene)
except NotConverged as error:
    print(error.result.peak_load)  # wrong
    kept: Result | None = error.result
    if error.result is not None:
        print(error.result.peak_load + 1.0, error.result.peak.load + error.result.peak.at)
        print(error.result.peak_lode)  # wrong
except Interrupted as ended:
    so_far: Result | Sweep | None = ended.result
except MeshError as refused:
    print(refused.key)


def both(lists: list[list[tuple[float, float]]], tuples: tuple[tuple[tuple[float, float], ...], ...]) -> tuple[Scene, Scene]:
    return scene.along(lists), scene.along(tuples)


class Mine(PlaneSpecimen):
    @property
    def paths(self) -> tuple[tuple[tuple[float, float], ...], ...]:
        return (((0.0, 0.0), (0.0, 1.0)),)
'''


@pytest.mark.parametrize("package", [cohesive, meshing])
def test_every_public_name_is_there_and_no_other(package: object) -> None:
    for name in package.__all__:  # type: ignore[attr-defined]
        assert getattr(package, name).__name__ == name
        assert name in dir(package)
    with pytest.raises(AttributeError, match="has no attribute 'Nonsense'"):
        package.Nonsense  # type: ignore[attr-defined]  # noqa: B018


def test_importing_the_package_loads_nothing_else() -> None:
    """No room and no library before a name is asked for."""
    code = "import sys; before = set(sys.modules); import cohesive; print(*sorted(set(sys.modules) - before))"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT).stdout.split()
    assert [name for name in found if name.split(".")[0] in ("numpy", "scipy", "gmsh", "meshio", "matplotlib")] == []
    assert [name for name in found if name.startswith(("cohesive", "meshing"))] == ["cohesive"]


@pytest.mark.slow
def test_a_type_checker_knows_every_public_name_and_no_other(tmp_path: Path) -> None:
    """A user's script under mypy --strict: exactly the lines that are marked as wrong are errors."""
    pytest.importorskip("mypy")
    every = "".join(
        f"from {package} import {name} as {package}_{name}\n"
        for package in ("cohesive", "meshing")
        for name in importlib.import_module(package).__all__
    )
    script = tmp_path / "script.py"
    script.write_text(DOWNSTREAM + every)
    command = [sys.executable, "-m", "mypy", "--strict", "--no-error-summary", "--config-file", str(ROOT / "pyproject.toml")]
    found = subprocess.run([*command, str(script)], capture_output=True, text=True, cwd=ROOT)
    at = sorted({int(line.split(":")[1]) for line in found.stdout.splitlines() if ": error:" in line})
    wrong = [i for i, line in enumerate(DOWNSTREAM.splitlines(), start=1) if line.endswith("# wrong")]
    assert at == wrong, found.stdout + found.stderr
