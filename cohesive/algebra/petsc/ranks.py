"""The ranks of an MPI run: rank 0 runs the program, the others wait for what they have to compute."""

from __future__ import annotations

import os

#: variables by which a process knows its rank and how many there are: Open MPI; MPICH, Intel MPI and Slurm's PMI
_VARIABLES = (("OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"), ("PMI_RANK", "PMI_SIZE"))


def rank_and_size() -> tuple[int, int]:
    """Rank of this process and number of all that mpiexec started, from the environment; (0, 1) without mpiexec."""
    for number, count in _VARIABLES:
        if number in os.environ and count in os.environ:
            return int(os.environ[number]), int(os.environ[count])
    return 0, 1
