"""`from cohesive import petsc; petsc.start()`: the first lines of a script that runs under mpiexec."""

from .algebra.petsc.stiffness import start

__all__ = ["start"]
