"""A meshed and assembled scene, ready for the march."""

from __future__ import annotations

from dataclasses import dataclass

from ..algebra.choice import Condensation
from ..elements.bulk import ElasticBlock
from ..solver.columns import COLUMN_NAMES, Column, columns_of
from ..solver.problem import Problem, State
from .cracks import CrackPart
from .mesh import CrackedMesh


@dataclass(frozen=True)
class Model:
    """A meshed and assembled scene.

    Attributes
    ----------
    mesh : CrackedMesh
    bulk : the elastic elements
    band : the elements that may crack, in the smeared model
    cracks : CrackPart
    problem : Problem on the active unknowns
    condensation : Condensation
    total_dofs : number of all unknowns
    timings : seconds, "mesh", "assemble" and "condense"
    notes : what the reader of the results should know about the model
    """

    mesh: CrackedMesh
    bulk: list[ElasticBlock]
    band: list[ElasticBlock]
    cracks: CrackPart
    problem: Problem
    condensation: Condensation
    total_dofs: int
    timings: dict[str, float]
    notes: list[str]

    @property
    def is_smeared(self) -> bool:
        """Whether cracks are smeared over elements."""
        return bool(self.band)

    @property
    def library(self) -> str:
        """What solves the linear systems."""
        return getattr(self.problem.stiffness, "library", "SciPy")

    @property
    def active_dofs(self) -> int:
        """Number of unknowns that Newton's method works on."""
        return len(self.condensation.unknowns)

    @property
    def columns(self) -> tuple[Column, ...]:
        """The columns of the history of its runs."""
        return columns_of(self.problem.measures)

    def record(self, state: State) -> dict[str, float]:
        """The quantities of the history that belong to a state."""
        problem, mean = self.problem, self.cracks.mean_traction(state)
        return {
            "load": state.load,
            "opening": problem.measure("opening", state),
            "sliding": problem.measure("sliding", state),
            "driven": state.driven,
            "stress_n": float(mean[0]),
            "stress_s": float(mean[1]),
            "work": state.work,
            "elastic": state.elastic,
            "stored": state.stored,
            "dissipated": state.dissipated,
            "contact_work": state.contact_work,
            **{name: problem.measure(name, state) for name in problem.measures if name not in COLUMN_NAMES},
        }
