"""What a run leaves behind: its history, its states, and the numbers that follow from them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from meshing.paths import along_paths

from ..arrays import Array
from .agreement import Agreement, agreements
from .frames import Frame, frame_of
from .pickling import without_factors

if TYPE_CHECKING:
    from ..growth.found import FoundPath
    from ..model.model import Model
    from ..scenes.measured import Reference
    from ..scenes.scene import Scene
    from ..solver.problem import Problem, State
    from .record import Record


@dataclass(frozen=True)
class Peak:
    """The largest load of a run, and where it comes.

    Attributes
    ----------
    load : N
    at : mm, of the measure in charge
    measure : its column of the history, as "cmod" or "driven"
    """

    load: float
    at: float
    measure: str


class RunData:
    """The data of a run.

    In a pickle displacements stand in place of the stiffness and its factors.

    Attributes
    ----------
    scene : Scene
    model : Model, with mesh and integration points
    history : dict of 1-D arrays; row 0 is the state before the first step, then one row for each converged step
    states : States, by row; a run of many rows keeps some of them only
    way : (rows,) array, length of the way that the drives have gone, mm
    notes : list of remarks on how the stages ended
    reference : Reference or None
    found : FoundPath, if the crack path was looked for
    timings : seconds: mesh, assemble, condense, newton and, after `save`, output
    told : the summary, in a result that was loaded from its folder
    warned : what a reader should be wary of, once it was asked for
    """

    def __init__(
        self,
        scene: Scene,
        model: Model,
        record: Record,
        notes: list[str],
        reference: Reference | None,
        found: FoundPath | None = None,
    ) -> None:
        self.scene, self.model, self.notes, self.reference = scene, model, notes, reference
        own = record.history
        self.history: dict[str, Array] = {column.name: own.get(column.name, np.zeros(0)) for column in model.columns}
        self.timings = model.timings | {"output": 0.0}
        self.states, self.found = record.states, found
        self.way = record.way
        self._displacements: dict[int, Array] | None = None  # of all rows with a state, in a result from a pickle
        self._added_compliance: float | None = None
        self._initial_stiffness: dict[str, float | None] = {}  # by what was asked for
        self.told: str | None = None
        self.warned: list[str] | None = None

    def __getstate__(self) -> dict[str, Any]:
        if self._displacements is None and len(self.states):
            self.initial_stiffness(self.controlled)
        kept = self.__dict__.copy()
        if self._displacements is None:
            kept["_displacements"] = {row: self.displacement(row) for row in self.states.kept.tolist()}
            kept["_added_compliance"] = self.added_compliance() if len(self.states) else None
            kept["model"] = without_factors(self.model)
        return kept

    @property
    def controlled(self) -> str:
        """Name of the measure in charge, the column over which the load is drawn: what was measured, else the last one in mm
        that a stage controls, else that of the main gauge, or of one over the mouth of the notch, or the mean jump."""
        if self.reference is not None and self.reference.against in self.history:
            return self.reference.against
        controls = [stage.control for stage in self.scene.stages if self.unit_of(stage.control) == "mm"]
        gauge = "cmod" if "cmod" in self.history and not self.gauge_is_elastic else "opening"
        return controls[-1] if controls else gauge

    def unit_of(self, column: str) -> str:
        """Unit of a column of the history; empty for a number without one, and for what is no column."""
        return next((each.unit for each in self.model.columns if each.name == column), "")

    @property
    def steps(self) -> int:
        """Number of converged steps."""
        return max(len(self.history["step"]) - 1, 0)

    @property
    def paths(self) -> list[Array]:
        """Crack paths, a (k, 2) polyline each, mm; none for a crack that no path describes."""
        return [np.array(line) for line in self.scene.specimen.paths]

    @property
    def path(self) -> Array:
        """The crack path, the first one if there are several: (k, 2), mm; (0, 2) if there is none."""
        return next(iter(self.paths), np.empty((0, 2)))

    @property
    def peak_row(self) -> int:
        """Row of the largest load of all steps; 0 if there is none."""
        return 1 + int(self.history["load"][1:].argmax()) if self.steps else 0

    @property
    def peak_load(self) -> float:
        """Largest load, N (negative if all loads are)."""
        return float(self.history["load"][self.peak_row]) if self.steps else 0.0

    @property
    def peak(self) -> Peak:
        """The largest load (N), and where it comes (mm) on the measure in charge; zeros if there is no step."""
        at = float(self.history[self.controlled][self.peak_row]) if self.steps else 0.0
        return Peak(self.peak_load, at, self.controlled)

    @property
    def opening_at_peak(self) -> float:
        """Column `opening` at the largest load, mm: that of the main gauge, or without one the mean jump over the crack."""
        return float(self.history["opening"][self.peak_row]) if self.steps else 0.0

    @property
    def dissipated_energy(self) -> float:
        """Damage dissipation at the end, N mm."""
        return float(self.history["dissipated"][-1]) if self.steps else 0.0

    @property
    def full_energy(self) -> float | None:
        """(Gf + ft^2 w / 2E) times the crack area, N mm: the dissipation of mode I separation. In a band w is l_ch.
        None if the area is not known, as for a crack anywhere in a mesh of the user's."""
        material, cracks = self.scene.material, self.model.cracks
        if cracks.area is None:
            return None
        return (material.Gf + material.ft**2 * cracks.width / (2 * material.E)) * cracks.area

    @property
    def energy_error(self) -> float:
        """Largest difference between external work and energies, each integrated on its own, over the largest work."""
        h = self.history
        if not self.steps:
            return 0.0
        error = h["work"] - h["elastic"] - h["stored"] - h["dissipated"] - h["contact_work"] - h["released"]
        return float(abs(error).max() / max(abs(h["work"]).max(), 1e-300))

    @property
    def agreement(self) -> list[Agreement]:
        """How far the run lies from each measured curve of its scene; empty without one."""
        return agreements(self.reference, self.history)

    @property
    def iterations(self) -> int:
        """Newton iterations in all converged steps."""
        return int(self.history["iterations"].sum())

    @property
    def solution_time(self) -> float:
        """Seconds from the scene to the last step, without files."""
        return sum(seconds for name, seconds in self.timings.items() if name != "output")

    @property
    def active_dofs(self) -> int:
        """Unknowns that Newton's method works on."""
        return self.model.active_dofs

    @property
    def total_dofs(self) -> int:
        """Unknowns of the whole body."""
        return self.model.total_dofs

    @property
    def problem(self) -> Problem:
        """The equations that were solved."""
        return self.model.problem

    @property
    def drives_both_ways(self) -> bool:
        """Whether a platen moves along two directions, so that the load is not always that of the opening."""
        return self.model.has_platen

    @property
    def last(self) -> State:
        """The state at the last row."""
        state: State = self.states[-1]
        return state

    @property
    def gauge_is_elastic(self) -> bool:
        """Whether the opening is measured over a length of the body, not as the mean jump."""
        return self.scene.specimen.has_main_gauge

    def initial_stiffness(self, motion: str) -> float | None:
        """Load over a motion of the undamaged body, N/mm; None for a column that is no linear measure of displacements.

        Parameters
        ----------
        motion : name of a gauge, or "driven"
        """
        if motion not in self._initial_stiffness:
            problem = self.problem
            row = problem.drive if motion == "driven" else problem.measures.get(motion)
            moved = 0.0 if row is None else float(row @ problem.response(problem.point_law.elastic()))
            self._initial_stiffness[motion] = 1.0 / moved if moved else None
        return self._initial_stiffness[motion]

    def added_compliance(self) -> float:
        """What the interface's width adds to the elastic compliance of opening under load, as a part of it.

        With the mean jump as gauge, which has no elastic part, the driven motion stands for the opening. A band
        adds none: its elements are part of the body.
        """
        if self.model.is_smeared:
            return 0.0
        if self._added_compliance is None:
            problem = self.problem
            # 1e6 times stiffer: a crack plane without width
            with_width, without = (problem.response(factor * problem.point_law.elastic()) for factor in (1.0, 1e6))
            row = problem.measures["opening"] if self.gauge_is_elastic else problem.drive
            self._added_compliance = float(row @ with_width) / float(row @ without) - 1.0
        return self._added_compliance

    def displacement(self, row: int) -> Array:
        """Displacements of all nodes in a row of the history, (m, d), mm."""
        if self._displacements is not None:
            return self._displacements[row + len(self.states) if row < 0 else row]
        return self.model.condensation.recover(self.states[row].v)

    def row(self, row: int) -> dict[str, float]:
        """One row of the history (-1 is the last one)."""
        return {name: values[row].item() for name, values in self.history.items()}

    def frame(self, row: int) -> Frame:
        """Fields of a row of the history (0 is the state before the first step, -1 the last one)."""
        return frame_of(self.model, self.states[row], self.displacement(row), self.row(row))

    def frame_rows(self) -> list[int]:
        """Rows that are written as frames: evenly spread, the peak and the last one."""
        last, wanted = self.steps, self.scene.output.frames
        if not last or not wanted:
            return []
        spread = np.linspace(0, last, min(wanted, last) + 1).round().astype(int)[1:].tolist()
        return sorted({*map(self.states.nearest, spread), self.peak_row})

    def opening_profile(self, row: int) -> tuple[Array, Array]:
        """Positions (p, d) and openings (p,) of the points with cracks in a row of the history, mm, in the order of
        `profile_distance`. In a band the opening is l_ch times the fracture strain."""
        state = self.states[row]
        values = self.model.cracks.point_values(state)
        order = np.argsort(self._distance(), kind="stable")
        return self.model.cracks.where[order], values["opening"][order]

    def profile_distance(self) -> Array:
        """Distance along the crack path of the points of `opening_profile`, (p,), mm, ascending; without a path, along the
        longest side of the points."""
        return np.sort(self._distance(), kind="stable")

    def _distance(self) -> Array:
        """Distance along the crack path of each point with a crack, (p,), mm."""
        where, lines = self.model.cracks.where, self.scene.specimen.paths
        return along_paths(where[:, :2] if lines else where, lines)
