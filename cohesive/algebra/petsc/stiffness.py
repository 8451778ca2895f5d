"""The stiffness of all unknowns, distributed and factored by PETSc on all ranks of an MPI run.

Rank 0 runs the program and is the only one that knows what for. The others wait in `start` for their part of a matrix
and of its solutions, and end with rank 0. A script that runs under mpiexec begins with

    from cohesive import petsc
    petsc.start()

`cohesive run` and `cohesive compare` do so by themselves.
"""

from __future__ import annotations

import atexit
import signal
import sys
import threading
import time
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from types import FrameType
from typing import Any

import numpy as np
import scipy.sparse as sp

from ...arrays import Array, Index
from ...errors import NotConverged, SceneError
from ..bordered import INEXACT, Border
from ..choice import Bulk, Condensation, Recovery
from .layout import Layout
from .ranks import rank_and_size

#: iterations with a reused factorization, after which the matrix is factored anew
_MOST_ITERATIONS = 15

#: tolerance on the error of a solution, as the preconditioner sees it; below the smallest one of Newton's method in use
_KRYLOV_TOLERANCE = 1e-12

#: what asks for this stiffness
_KEY = "solver.condensation"

#: seconds between two looks of a waiting rank, which would otherwise use all of its core
_LOOK = 1e-3


class PetscStiffness:
    """The stiffness of all unknowns; every system is factored, or solved with a reused factorization, by all ranks.

    Parameters
    ----------
    matrix : (n, n) stiffness of the elastic bulk, N/mm.

    Attributes
    ----------
    library : what solves, for the summary: PETSc's version, its direct solver, and the number of processes

    Raises
    ------
    SceneError
        Without petsc4py or, on several processes, mpi4py or a parallel direct solver; and on several processes that
        did not call `start`.
    """

    library = ""

    def __init__(self, matrix: sp.csc_array, factor: float = 1.0) -> None:
        if rank_and_size()[1] > 1 and not _is_started():
            raise _refused(
                f" on {rank_and_size()[1]} processes: expected a call of cohesive.petsc.start() at the beginning of the script"
            )
        solver_type()
        self._matrix, self._factor = matrix, factor
        self._layout: Layout | None = None

    def apply(self, v: Array) -> Array:
        return np.asarray(self._factor * (self._matrix @ v))

    @property
    def scale(self) -> float:
        return self._factor * float(abs(self._matrix).sum(axis=1).max())

    def scaled(self, factor: float) -> PetscStiffness:
        return PetscStiffness(self._matrix, factor * self._factor)

    def drop_factorization(self) -> None:
        self._layout = None

    def solve(self, border: Border, right: Array, last: float, forcing: float = INEXACT) -> Array:
        """As every `Stiffness` does, with a residual below any forcing."""
        rows, columns, values = border.crack
        layout = self._layout
        if layout is None or layout is not Layout.latest or not layout.fits(rows, columns, border.free):
            matrix = self._factor * self._matrix
            layout = self._layout = Layout.latest = Layout.from_entries(matrix, rows, columns, border.free)
            solver = _together("set_up", layout.shares(_processes()))[0]
            self.library = f"PETSc {'.'.join(map(str, petsc().Sys.getVersion()))}, {solver}, {_counted(_processes())}"
        load, row, right = border.forces(border.load), border.forces(border.row), border.forces(right)
        parts = _together("solve", layout.split(values, right, load, _processes()))
        if parts[0] is None:
            raise NotConverged("the tangent stiffness is singular")
        both = np.concatenate(parts, axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):  # Newton's method looks whether the step is finite
            change = (last - row @ both[0]) / (row @ both[1] + border.corner)
        return border.whole(np.append(both[0] + change * both[1], change))


def uncondensed(bulk: Bulk) -> Condensation:
    """All unknowns, with the stiffness that PETSc factors."""
    transform, shape = bulk.unknowns.transform, bulk.points.shape
    stiffness = PetscStiffness(bulk.reduced(transform))
    return Condensation("petsc", stiffness, np.arange(transform.shape[1]), Recovery(transform, shape), "")


class Share:
    """What a rank holds of the matrix, its factor and the solver. All ranks call its methods together."""

    def __init__(self, size: int, start: Index, column: Index, bulk: Array, changing: Index) -> None:
        PETSc = petsc()
        self._start, self._column = start.astype(PETSc.IntType), column.astype(PETSc.IntType)
        self._bulk, self._changing = bulk, changing
        rows = (len(start) - 1, size)
        self._matrix = PETSc.Mat().createAIJ((rows, rows), csr=(self._start, self._column, bulk), comm=PETSc.COMM_WORLD)
        self._right, self._solution = self._matrix.createVecs()
        self._response = self._right.duplicate()  # to the load: it changes little from one system to the next
        self._response.set(0.0)
        self._is_factored = False
        self._krylov = PETSc.KSP().create(PETSc.COMM_WORLD)
        self._krylov.setType("gmres")
        self._krylov.setGMRESRestart(_MOST_ITERATIONS)
        self._krylov.setTolerances(rtol=_KRYLOV_TOLERANCE, max_it=_MOST_ITERATIONS)
        self._krylov.setOperators(self._matrix)
        self._krylov.getPC().setType("lu")
        self._krylov.getPC().setFactorSolverType(solver_type())
        options = PETSc.Options()
        if not options.hasName("mat_mumps_icntl_14"):
            options["mat_mumps_icntl_14"] = 100  # memory for pivoting, per cent; MUMPS gives up if it takes more
        self._krylov.setFromOptions()

    def solver(self) -> str:
        """Name of the direct solver, or of another preconditioner from PETSC_OPTIONS."""
        pc = self._krylov.getPC()
        return str(pc.getFactorSolverType() if pc.getType() in ("lu", "cholesky") else pc.getType())

    def solve(self, added: Array, right: Array, load: Array) -> Array | None:
        """Both solutions on the rows of this rank, (2, rows), or None if the matrix is singular."""
        values = self._bulk.copy()
        values[self._changing] += added
        self._matrix.setValuesCSR(self._start, self._column, values)
        self._matrix.assemble()
        for fresh in (False, True) if self._is_factored else (True,):
            self._krylov.getPC().setReusePreconditioner(not fresh)
            if (both := self.both(right, load, fresh)) is not None:
                return both
        return None

    def both(self, right: Array, load: Array, fresh: bool) -> Array | None:
        """Both solutions; None if there is no factor, or a reused one does not do."""
        for side, solution, guess in ((right, self._solution, False), (load, self._response, not fresh)):
            self._right.setArray(side)
            self._krylov.setInitialGuessNonzero(guess)
            self._krylov.solve(self._right, solution)
            reason = self._krylov.getConvergedReason()
            self._is_factored = reason != petsc().KSP.ConvergedReason.DIVERGED_PCSETUP_FAILED
            if not self._is_factored:
                self._krylov.reset()  # else it would remember the failure
                self._krylov.setOperators(self._matrix)
                return None
            if reason < 0 and not fresh:
                return None
        return np.stack([self._solution.getArray(), self._response.getArray()])

    def destroy(self) -> None:
        """Free what PETSc holds."""
        for item in (self._krylov, self._matrix, self._right, self._solution, self._response):
            item.destroy()


#: of this rank
_share: Share | None = None


def _do(task: str, given: tuple[Any, ...]) -> Any:
    """A task in which all ranks take part, each with its own data."""
    global _share
    if task == "set_up":
        if _share is not None:
            _share.destroy()
        _share = Share(*given)
        return _share.solver()
    assert _share is not None
    return _share.solve(*given)


def _together(task: str, given: list[tuple[Any, ...]]) -> list[Any]:
    """Let every rank do a task, each with its own data; the results in the order of the ranks."""
    if len(given) == 1:
        return [_do(task, given[0])]
    world = _mpi().COMM_WORLD
    with _undisturbed(), _or_abort():
        for rank in range(1, len(given)):
            world.send((task, given[rank]), rank)
        return list(world.gather(_do(task, given[0])))


@contextmanager
def _undisturbed() -> Iterator[None]:
    """Signals wait until the end: an interruption half-way would leave the other ranks waiting for ever."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[tuple[int, FrameType | None]] = []
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    for number in before:
        signal.signal(number, lambda *signalled: came.append(signalled))
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        if came:
            first, frame = came[0]
            if callable(handler := before[signal.Signals(first)]):
                handler(first, frame)
            elif handler == signal.SIG_DFL:
                signal.raise_signal(first)


@contextmanager
def _or_abort() -> Iterator[None]:
    """End all ranks if one has an error that the others do not know of."""
    try:
        yield
    except BaseException:
        print(traceback.format_exc(), file=sys.__stderr__, flush=True)
        _mpi().COMM_WORLD.Abort(1)


_started = False


def _is_started() -> bool:
    return _started


def start() -> None:
    """Let rank 0 go on; the others stay here, compute what it asks for, and end with it.

    Does nothing without mpiexec.

    Raises
    ------
    SceneError
        Without petsc4py, mpi4py or a parallel direct solver.
    SystemExit
        In the other ranks, when rank 0 has ended.
    """
    global _started
    rank, count = rank_and_size()
    if count == 1 or _started:
        return
    sizes = _mpi().COMM_WORLD.Get_size(), petsc().COMM_WORLD.getSize()
    if sizes != (count, count):
        raise SceneError(
            f"mpiexec started {count} processes, of which mpi4py sees {sizes[0]} and PETSc {sizes[1]}: expected mpiexec, "
            "mpi4py and petsc4py of one MPI library",
            key=_KEY,
        )
    solver_type()
    _started = True
    if rank == 0:
        atexit.register(_end)
    else:
        _serve()
        sys.exit(0)


def _serve() -> None:
    """Take part in what rank 0 asks for, until it ends."""
    for number in (signal.SIGINT, signal.SIGTERM):  # they reach all ranks; rank 0 decides what follows
        signal.signal(number, signal.SIG_IGN)
    world = _mpi().COMM_WORLD
    with _or_abort():
        while True:
            while not world.iprobe(0):
                time.sleep(_LOOK)
            task, given = world.recv(None, 0)
            if task == "end":
                return
            world.gather(_do(task, given))


def _end() -> None:
    """Let the other ranks end."""
    world = _mpi().COMM_WORLD
    for rank in range(1, world.Get_size()):
        world.send(("end", ()), rank)


@cache
def solver_type() -> str:
    """PETSc's name of the best direct solver that it was built with.

    Raises
    ------
    SceneError
        Without petsc4py, or on several processes without a parallel direct solver.
    """
    PETSc = petsc()
    for name in ("mumps", "superlu_dist"):
        if PETSc.Sys.hasExternalPackage(name):
            return name
    if _processes() > 1:
        raise _refused(
            f" on {_processes()} processes: this PETSc was built without a parallel direct solver; "
            "expected one with MUMPS or SuperLU_DIST (its configure option --download-mumps --download-scalapack, or on "
            "Debian and Ubuntu apt-get install python3-petsc4py-real)"
        )
    return "petsc"


def _counted(processes: int) -> str:
    return f"{processes} process{'es' if processes > 1 else ''}"


def _processes() -> int:
    return int(petsc().COMM_WORLD.getSize())


@cache
def petsc() -> Any:
    """The module petsc4py.PETSc, initialized; it takes its options from PETSC_OPTIONS, not from our command line."""
    try:
        import petsc4py

        petsc4py.init([])
        from petsc4py import PETSc
    except ImportError as error:
        raise _missing("petsc4py", error) from None
    return PETSc


@cache
def _mpi() -> Any:
    """The module mpi4py.MPI, initialized."""
    try:
        from mpi4py import MPI
    except ImportError as error:
        raise _missing("mpi4py", error) from None
    return MPI


def _missing(package: str, error: ImportError) -> SceneError:
    return _refused(
        f" needs the package {package}, which cannot be imported ({error}): pip install 'cohesive-cracks[petsc]', see "
        "'Use several machines' in the guide"
    )


def _refused(why: str) -> SceneError:
    return SceneError(f"{_KEY} = 'petsc'{why}", key=_KEY)
