"""The stiffness that PETSc factors: the histories of SciPy, on one process and on two, and the end of both."""

from __future__ import annotations

import csv
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp

from cohesive import NotConverged, Scene, SceneError, run
from cohesive.algebra.bordered import Border
from cohesive.algebra.petsc import stiffness
from cohesive.algebra.petsc.ranks import rank_and_size
from cohesive.commands.command_line import main
from cohesive.scenes.scene import dump_toml

#: starts two processes
Start = Callable[..., subprocess.Popen[str]]

needs_petsc = pytest.mark.skipif(find_spec("petsc4py") is None, reason="petsc4py is not installed")
needs_mpiexec = pytest.mark.skipif(
    not all((find_spec("petsc4py"), find_spec("mpi4py"), shutil.which("mpiexec"))),
    reason="petsc4py, mpi4py or mpiexec is not installed",
)

QUICK = {"mesh.crack_size": 2.5, "mesh.far_size": 12.0}
CASES = {
    "beam": Scene.load("notched-beam").with_(**QUICK, **{"stage.0.to": [0.04, 0.01, 0.06], "stage.0.steps": 6}),
    # which begins with a solution that must be in equilibrium to the tolerance
    "beam by dissipation": Scene.load("notched-beam").with_(
        **QUICK, stage=[{"control": "dissipation", "to": 20.0, "steps": 4}]
    ),
    # opened, then sheared with the opening held: two drives, contact, unsymmetric tangents
    "panel": Scene.load("sandwich-panel").with_(
        **{"model.kind": "smeared", "mesh.crack_size": 100.0, "mesh.far_size": 100.0, "stage.0.steps": 5, "stage.1.steps": 10}
    ),
    "block in 3D": Scene.load("single-crack-3d").with_(**{"mesh.crack_size": 20.0, "mesh.far_size": 25.0, "stage.0.steps": 6}),
}
#: what a step solves for and integrates, in units of its largest value
SAME = ("load", "opening", "driven", "elastic", "stored", "dissipated", "contact_work", "work")


def exact(scene: Scene, condensation: str) -> Scene:
    return scene.with_(**{"solver.tol": 1e-11, "solver.condensation": condensation, "output.frames": 0})


def assert_same(history: dict[str, np.ndarray], expected: dict[str, np.ndarray], atol: float) -> None:
    for name in SAME:
        size = abs(expected["work" if name in ("stored", "contact_work") else name]).max()
        np.testing.assert_allclose(history[name], expected[name], atol=atol * size, rtol=0.0, err_msg=name)


# Both converge to 1e-11 of the largest unknown; the loads at a crack of some 1e5 N/mm^3 magnify that less than 1000 times.
AGREE = 1e-8


@needs_petsc
@pytest.mark.parametrize("name", CASES)
def test_petsc_is_scipy(name: str) -> None:
    expected, found = (run(exact(CASES[name], condensation)) for condensation in ("never", "petsc"))
    assert_same(found.history, expected.history, AGREE)
    np.testing.assert_array_equal(found.history["iterations"], expected.history["iterations"])  # no step is inexact
    assert name != "panel" or abs(found.history["contact_work"]).max() > 1e-3 * found.history["work"].max()
    assert "PETSc" in found.summary() and found.summary().count("nothing condensed; PETSc") == 1


@needs_petsc
def test_a_factor_serves_several_iterations(beam: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    fresh: list[bool] = []
    both = stiffness.Share.both

    def counted(self: stiffness.Share, right: np.ndarray, load: np.ndarray, is_fresh: bool) -> np.ndarray | None:
        fresh.append(is_fresh)
        return both(self, right, load, is_fresh)

    monkeypatch.setattr(stiffness.Share, "both", counted)
    result = run(exact(beam, "petsc"))
    assert 1 < sum(fresh) < 0.7 * result.iterations


def small(matrix: np.ndarray) -> stiffness.PetscStiffness:
    return stiffness.PetscStiffness(sp.csc_array(matrix))


@needs_petsc
def test_a_system_of_two_unknowns() -> None:
    """With an unsymmetric crack, whose pattern is another one the second time, and within one motion."""
    K = np.array([[4.0, -1.0], [-1.0, 3.0]])
    stiffness = small(K)
    load, row, right = np.array([1.0, 2.0]), np.array([0.5, 1.0]), np.array([3.0, -1.0])
    for free in (np.eye(2), np.array([[0.6], [0.8]])):
        for rows, columns, values in (([0, 0], [0, 1], [1.0, -0.5]), ([0, 1, 1], [0, 0, 1], [1.0, 0.7, 0.1])):
            entries = np.array(rows), np.array(columns), np.array(values)
            A = K.copy()
            np.add.at(A, entries[:2], entries[2])
            whole = np.block([[free.T @ A @ free, -free.T @ load[:, None]], [row[None] @ free, np.array([[0.3]])]])
            *y, change = np.linalg.solve(whole, [*(free.T @ right), 2.0])
            allowed = None if len(y) == 2 else sp.csr_array(free)
            solution = stiffness.solve(Border(entries, load, row, 0.3, allowed), right, 2.0)
            np.testing.assert_allclose(solution, [*(free @ y), change], rtol=1e-12)  # rounding
    np.testing.assert_allclose(stiffness.apply(load), K @ load)
    assert stiffness.scale == 5.0


@needs_petsc
def test_a_singular_matrix_does_not_converge_and_the_next_one_does() -> None:
    stiffness, unit = small(np.diag([1.0, 0.0])), np.ones(2)
    for value in (0.0, 1.0, 0.0, 1.0):
        entries = np.array([1]), np.array([1]), np.array([value])
        if value:
            np.testing.assert_allclose(stiffness.solve(Border(entries, unit, unit, 0.0), 0 * unit, 1.0), [0.5, 0.5, 0.5])
        else:
            with pytest.raises(NotConverged, match="singular"):
                stiffness.solve(Border(entries, unit, unit, 0.0), unit, 1.0)


def test_without_the_package_the_run_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setitem(sys.modules, "petsc4py", None)
    stiffness.petsc.cache_clear()
    stiffness.solver_type.cache_clear()
    assert main(["run", "single-crack", "-o", str(tmp_path), "--set", "solver.condensation=petsc"]) == 2
    err = capsys.readouterr().err
    assert err.startswith("cohesive: solver.condensation = 'petsc' needs the package petsc4py") and len(err.splitlines()) == 1
    assert "pip install 'cohesive-cracks[petsc]'" in err


def test_without_a_parallel_solver_several_processes_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    size = 3

    class Alone:
        """A PETSc that was built without any other library."""

        class Sys:
            hasExternalPackage = staticmethod(lambda name: False)

        class COMM_WORLD:
            getSize = staticmethod(lambda: size)

    monkeypatch.setattr(stiffness, "petsc", Alone)
    with pytest.raises(SceneError, match=r"on 3 processes: this PETSc was built without a parallel direct solver; expected"):
        stiffness.solver_type.__wrapped__()
    size = 1
    assert stiffness.solver_type.__wrapped__() == "petsc"


@pytest.mark.parametrize("names", [("OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"), ("PMI_RANK", "PMI_SIZE")])
def test_other_commands_are_refused_on_several_processes(
    names: tuple[str, str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """Instead of several copies that write the same files. MPI is not looked for."""
    monkeypatch.setitem(sys.modules, "mpi4py", None)
    monkeypatch.setenv(names[0], "0")
    monkeypatch.setenv(names[1], "4")
    assert rank_and_size() == (0, 4)
    for words in (["run", "single-crack"], ["law"], ["trade", "single-crack", "--set", "solver.condensation=petsc"]):
        assert main([*words, "-o", str(tmp_path)]) == 2
        assert "mpiexec started 4 processes: expected one, or" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


@pytest.fixture
def mpiexec() -> Iterator[Start]:
    """Starts two processes of Python; what is left of them at the end is ended."""
    started: list[subprocess.Popen[str]] = []

    def start(*words: str) -> subprocess.Popen[str]:
        started.append(two_processes(*words))
        return started[-1]

    yield start
    for process in started:
        if process.poll() is None:
            process.terminate()  # upon which mpiexec kills them all
            process.communicate(timeout=30)


def two_processes(*words: str) -> subprocess.Popen[str]:
    """Open MPI wants to be told that root and more processes than cores are meant."""
    of_ours = {name: value for name, value in os.environ.items() if not name.startswith(("OMPI_", "PMI", "PRTE_"))}
    allowed = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMPI_MCA_rmaps_base_oversubscribe": "1"}
    return subprocess.Popen(
        ["mpiexec", "-n", "2", sys.executable, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env=of_ours | allowed | {"OPENBLAS_NUM_THREADS": "1"}, start_new_session=True,
    )  # fmt: skip


def command(folder: Path, scene: str = "notched-beam", **changes: object) -> list[str]:
    words = ["-m", "cohesive", "run", scene, "-o", str(folder)]
    return words + [word for key, value in changes.items() for word in ("--set", f"{key.replace('__', '.')}={value}")]


PETSC = {"solver__condensation": "petsc", "mesh__crack_size": 2.5, "mesh__far_size": 12.0}


def processes_of(folder: Path) -> list[tuple[int, str]]:
    """Those that have the folder on their command line: id and number within MPI."""
    processes = []
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            if str(folder) in (entry / "cmdline").read_text():
                environment = (entry / "environ").read_text().split("\0")
                number = [
                    text.partition("=")[2] for text in environment if text.startswith(("OMPI_COMM_WORLD_RANK=", "PMI_RANK="))
                ]
                processes.append((int(entry.name), *number[:1]) if number else (int(entry.name), ""))
        except OSError:
            continue
    return processes


def history(folder: Path) -> dict[str, np.ndarray]:
    with (folder / "history.csv").open() as file:
        table = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in table]) for name in table[0]}


@needs_mpiexec
@pytest.mark.parametrize("name", ["beam", "panel"])
def test_two_processes_find_the_same(name: str, mpiexec: Start, tmp_path: Path) -> None:
    scene = exact(CASES[name], "petsc").with_(**{"output.frames": 1})
    file = tmp_path / "scene.toml"
    file.write_text(dump_toml(scene.data))
    process = mpiexec(*command(tmp_path / "out", str(file)))
    out, err = process.communicate(timeout=60)
    assert process.returncode == 0, err
    assert out.count("peak load:") == 1  # one program
    facts = json.loads((tmp_path / "out" / "run.json").read_text())
    assert facts["condensation"] == "petsc" and facts["library"].endswith("2 processes") and facts["library"] in out
    assert_same(history(tmp_path / "out"), run(exact(CASES[name], "never")).history, AGREE)
    assert not processes_of(tmp_path)


@needs_mpiexec
@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        (PETSC | {"material__ft": -1}, "material.ft = -1: expected a number above 0"),  # found by all
        (
            PETSC | {"specimen__crack": "[[0.0, 25.0], [0.0, 90.0]]"},
            "specimen: crack path of length",
        ),  # by process 0, when it meshes
        ({}, "mpiexec started 2 processes"),
    ],
)
def test_an_error_is_told_once_and_ends_both(
    changes: dict[str, object], expected: str, mpiexec: Start, tmp_path: Path
) -> None:
    process = mpiexec(*command(tmp_path, **changes))
    out, err = process.communicate(timeout=60)
    assert process.returncode == 2
    assert (out + err).count("cohesive: ") == 1 and f"cohesive: {expected}" in err and "Traceback" not in err
    assert not processes_of(tmp_path)


@needs_mpiexec
def test_a_script_of_two_processes(mpiexec: Start, tmp_path: Path) -> None:
    """With the two lines it runs once; without them it is told."""
    script = tmp_path / "script.py"
    scene = "Scene.load('single-crack').with_(**{'solver.condensation': 'petsc'})"
    body = f"from cohesive import Scene, run\nprint('peak', run({scene}).peak_load)"
    script.write_text(f"from cohesive import petsc\npetsc.start()\n{body}\n")
    out, err = mpiexec(str(script)).communicate(timeout=60)
    assert out.count("peak") == 1, err
    script.write_text(body + "\n")
    process = mpiexec(str(script))
    assert "expected a call of cohesive.petsc.start() at the beginning" in process.communicate(timeout=60)[1]
    assert process.returncode != 0


@needs_mpiexec
@pytest.mark.skipif(not Path("/proc/self/environ").exists(), reason="no /proc to look for processes")
@pytest.mark.parametrize(
    ("number", "whom"), [(signal.SIGINT, "mpiexec"), (signal.SIGTERM, "mpiexec"), (signal.SIGTERM, "0"), (signal.SIGKILL, "1")]
)
def test_a_signal_leaves_no_process_behind(number: signal.Signals, whom: str, mpiexec: Start, tmp_path: Path) -> None:
    """Sent to mpiexec, as from a terminal; to process 0, which saves what there is; and to another one."""
    process = mpiexec(*command(tmp_path, **PETSC, stage__0__steps=20000))
    file, deadline = tmp_path / "history.csv", time.monotonic() + 60
    while time.monotonic() < deadline and not (file.exists() and len(file.read_text().splitlines()) > 10):
        time.sleep(0.05)
    running = processes_of(tmp_path)
    assert sorted(rank for _, rank in running) == ["", "0", "1"]
    os.kill(process.pid if whom == "mpiexec" else next(pid for pid, rank in running if rank == whom), number)
    _, err = process.communicate(timeout=60)
    assert process.returncode != 0 and "Traceback" not in err
    deadline = time.monotonic() + 10
    while processes_of(tmp_path) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not processes_of(tmp_path)
    text = file.read_text()
    assert text.endswith("\n") and len(text.splitlines()) > 10  # whole rows
    if whom == "0":
        assert process.returncode == 143 and (tmp_path / "run.json").exists() and "terminated" in err
