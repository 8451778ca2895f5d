"""How many threads BLAS takes: one for small matrices, for which threads only wait for each other, several for large ones."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import TYPE_CHECKING

from ..errors import SceneError

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController

#: says how many threads large matrices take
VARIABLE = "COHESIVE_THREADS"

#: what the command sets for BLAS at its start, and users where other processes keep the machine busy
BLAS_VARIABLE = "OPENBLAS_NUM_THREADS"

#: rows of a dense matrix from which on several threads factor it faster than one
_LARGE = 1_000


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def most_threads() -> int:
    """Threads for large matrices: what COHESIVE_THREADS says, else OPENBLAS_NUM_THREADS or OMP_NUM_THREADS, else one a core.

    Raises
    ------
    SceneError
        If COHESIVE_THREADS is no positive number.
    """
    if asked := os.environ.get(VARIABLE, ""):
        if not asked.isdecimal() or not int(asked):
            raise SceneError(f"{VARIABLE} = {asked!r}: expected a number of threads, 1 or more")
        return int(asked)
    for name in (BLAS_VARIABLE, "OMP_NUM_THREADS"):
        if (asked := os.environ.get(name, "")).isdecimal() and int(asked):
            return int(asked)
    return cores()


def begin_with_one() -> None:
    """Before NumPy is loaded: let BLAS begin with one thread, unless its variable is set; large matrices take more.

    Raises
    ------
    SceneError
        As `most_threads` does.
    """
    most = str(most_threads())
    if BLAS_VARIABLE not in os.environ:
        os.environ[VARIABLE], os.environ[BLAS_VARIABLE] = most, "1"


@contextmanager
def threads_for(rows: int) -> Iterator[None]:
    """BLAS within this context, with as many threads as a matrix of this number of rows is worth.

    Raises
    ------
    SceneError
        As `most_threads` does.
    """
    wanted = most_threads() if rows >= _LARGE else 1
    begun_with_one = os.environ.get(BLAS_VARIABLE) == "1"  # then nothing needs to be loaded to know
    if (wanted == 1 and begun_with_one) or all(library.num_threads == wanted for library in _blas().lib_controllers):
        yield
        return
    with _blas().limit(limits=wanted):
        yield


@cache
def _blas() -> ThreadpoolController:
    """The BLAS libraries of NumPy and of SciPy."""
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController().select(user_api="blas")
