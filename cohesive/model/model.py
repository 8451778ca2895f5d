"""A meshed and assembled scene, ready to be loaded."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

from ..algebra.choice import Condensation
from ..arrays import Array
from ..elements.bulk import ElasticBlock
from ..solver.columns import COLUMN_NAMES, Column, columns_of
from ..solver.problem import Problem, State
from .cracks import CrackPart
from .lengths import CrackLengths
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
    lengths : CrackLengths
    forces : further forces by name, as multiples of the load
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
    lengths: CrackLengths
    forces: Mapping[str, float]
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

    @cached_property
    def _compliance(self) -> tuple[Array, Array] | None:
        # by a stiffness of its own: the run goes on with the factorization that it has, whenever this is first asked for
        return self.lengths.curve(replace(self.problem, stiffness=self.problem.stiffness.scaled(1.0)))

    def crack_lengths(self, state: State) -> dict[str, float]:
        """The quantities of the history that say how far the crack has come in a state."""
        return {
            "cohesive_length": self.lengths.cohesive(state),
            "effective_length": self.lengths.effective(self._compliance, self.problem, state),
        }

    @property
    def columns(self) -> tuple[Column, ...]:
        """The columns of the history of its runs."""
        return columns_of(self.problem.measures, self.problem.loading.names, self.forces, self.cracks.point_law.law.columns)

    def record(self, state: State) -> dict[str, float]:
        """The quantities of the history that belong to a state."""
        return self.recorded(self.problem, state)

    def recorded(self, problem: Problem, state: State) -> dict[str, float]:
        """The same, counted as `problem` does: from the body under its dead loads, see `solver.stepper.solve`."""
        mean, share = self.cracks.mean_traction(state), self.cracks.weights / self.cracks.weights.sum()
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
            "released": state.released,
            **{name: problem.measure(name, state) for name in problem.measures if name not in COLUMN_NAMES},
            **{name: factor * state.load for name, factor in self.forces.items()},
            **_of_drives(problem, state),
            **{name: float(share @ value) for name, value in self.cracks.law_values(state).items()},
        }


def _of_drives(problem: Problem, state: State) -> dict[str, float]:
    """Load and motion of each of several drives."""
    loading, values = problem.loading, {}
    if len(loading.names) > 1:
        forces = problem.driven_forces(state)
        for name in loading.names:
            values[f"load.{name}"] = loading.force(name, forces)
            values[f"driven.{name}"] = problem.driven_motion(name, state)
    return values
