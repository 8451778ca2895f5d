"""Threads of BLAS: one for small matrices, as many as are asked for large ones."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest
from threadpoolctl import ThreadpoolController

from cohesive import SceneError
from cohesive.algebra.threads import BLAS_VARIABLE, VARIABLE, cores, most_threads, threads_for
from cohesive.studies.pool import processes

SMALL, LARGE = 900, 1100


def _now() -> set[int]:
    return {library.num_threads for library in ThreadpoolController().select(user_api="blas").lib_controllers}


def test_large_matrices_take_the_threads_that_are_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    before = _now()
    assert before, "no BLAS that threadpoolctl knows"
    monkeypatch.setenv(VARIABLE, "2")
    with threads_for(LARGE):
        assert _now() == {2}
        with threads_for(SMALL):
            assert _now() == {2 if os.environ.get(BLAS_VARIABLE) == "1" else 1}
        assert _now() == {2}
    assert _now() == before


def test_small_ones_take_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where BLAS began with more, as from Python."""
    monkeypatch.delenv(BLAS_VARIABLE, raising=False)
    monkeypatch.setenv(VARIABLE, "2")
    blas = ThreadpoolController().select(user_api="blas")
    with blas.limit(limits=2):
        with threads_for(SMALL):
            assert _now() == {1}
        assert _now() == {2}


def test_who_says_how_many(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in (VARIABLE, BLAS_VARIABLE, "OMP_NUM_THREADS"):
        monkeypatch.delenv(name, raising=False)
    assert most_threads() == cores()
    for name, count in (("OMP_NUM_THREADS", 3), (BLAS_VARIABLE, 5), (VARIABLE, 7)):
        monkeypatch.setenv(name, str(count))
        assert most_threads() == count
    for wrong in ("0", "-1", "all", "2.5"):
        monkeypatch.setenv(VARIABLE, wrong)
        with pytest.raises(SceneError, match=f"^{VARIABLE} = '{wrong}': expected a number of threads, 1 or more"):
            most_threads()


@pytest.mark.parametrize(
    ("given", "begun", "large"),
    [
        ({}, "1", str(cores())),
        ({"OMP_NUM_THREADS": "3"}, "1", "3"),
        ({BLAS_VARIABLE: "2"}, "2", None),
        ({VARIABLE: "4"}, "1", "4"),
    ],
)
def test_the_command_begins_with_one(given: dict[str, str], begun: str, large: str | None) -> None:
    code = (
        "import os, sys; sys.argv = ['cohesive', '--version']\n"
        "from cohesive.__main__ import main\n"
        "try: main()\n"
        f"finally: print(os.environ['{BLAS_VARIABLE}'], os.environ.get('{VARIABLE}'))"
    )
    clean = {name: value for name, value in os.environ.items() if not name.endswith("_THREADS")}
    done = subprocess.run([sys.executable, "-c", code], env=clean | given, capture_output=True, text=True, check=False)
    assert done.stdout.splitlines()[-1] == f"{begun} {large}", done.stderr


def test_a_wrong_number_is_refused_at_once() -> None:
    command = [sys.executable, "-m", "cohesive", "scenes"]
    done = subprocess.run(command, env=os.environ | {VARIABLE: "many"}, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr == f"cohesive: {VARIABLE} = 'many': expected a number of threads, 1 or more\n"


def test_each_of_many_processes_takes_one() -> None:
    with processes() as pool:
        assert pool.submit(most_threads).result() == 1
