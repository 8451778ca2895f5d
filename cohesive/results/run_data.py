"""What a run leaves behind: its history, its fields, and the numbers that follow from them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from meshing.paths import Point, along_paths, as_text

from ..arrays import Array
from .agreement import Agreement, agreements
from .peak import Peak, peak_weights

if TYPE_CHECKING:
    from ..growth.found import FoundPath
    from ..law.registry import Law
    from ..measured.curve import Measured, Reference
    from ..scenes.scene import Scene
    from .fields import Fields, Frame
    from .model_facts import ModelFacts


#: part of its fracture energy that a crack through a place off the path dissipates, and in how many steps
_OPENED, _STEPS_THERE = 0.5, 40


@dataclass(frozen=True)
class OffPath:
    """The place off the path where the bulk is pulled most.

    Attributes
    ----------
    place : (d,) mm
    across : (d,) unit vector of the pull, a crack stands across it
    times : largest averaged principal tension there, over ft
    step : in which it is
    load : at which the tension there first passes ft, N
    radius : of the average, mm
    line : path of a straight crack through it, which a scene can be given, mm; empty if no outline tells where it ends
    is_even : whether the bulk at the crack is pulled as much until the tension passes ft
    """

    place: Array
    across: Array
    times: float
    step: int
    load: float
    radius: float
    line: list[Point]
    is_even: bool

    def scene(self, scene: Scene) -> Scene:
        """A scene with a straight crack through the place instead, opened until half of what it takes is dissipated; its first
        drive moves."""
        assert scene.specimen.thickness is not None  # it has an outline
        area = sum(math.dist(a, b) for a, b in pairwise(self.line)) * scene.specimen.thickness
        first = {key: value for key, value in scene.data["stage"][0].items() if key in ("angle", "hold", "drive", "others")}
        stage = first | {"control": "dissipation", "to": _OPENED * scene.material.Gf * area, "steps": _STEPS_THERE}
        there = scene.without_search([list(point) for point in self.line])
        return there.with_(**{"model.half": False, "output.frames": 0}, stage=[stage])

    @property
    def sentence(self) -> str:
        """For the reader of the results."""
        where = f"at {as_text(self.place.round(6))}, to {self.times:.3g} ft in step {self.step} in the mean over a radius of "
        start = f"off the path the tension passes ft {where}{self.radius:.3g} mm, first at a load of {self.load:.5g} N"
        if self.is_even:
            return f"{start}: the body is pulled there as at the crack, whose place is free; no other place gives less"
        line = [[round(c, 6) + 0.0 for c in point] for point in self.line]
        crack = f"specimen.crack = {line}" if line else "a crack there"
        return (
            f"warning: {start}: the body would rather break there; a run with {crack}, under a control that grows with it (as "
            "dissipation or driven), gives that peak"
        )


@dataclass(eq=False)
class RunData:
    """The data of a run: the same when it is fresh, when it comes from a pickle, and when it was loaded from its folder.

    Attributes
    ----------
    scene : Scene
    history : dict of 1-D arrays; row 0 is the state before the first step, then one row for each converged step
    drive_travel : (rows,) array, length that the motions of the drives have gone, mm
    notes : list of remarks on how the stages ended
    timings : seconds: mesh, assemble, condense, newton and, after `save`, output
    facts : ModelFacts
    fields : Fields, the mesh and its fields
    reference : Reference or None
    found : FoundPath, if the crack path was looked for
    off_path : OffPath, if the bulk is pulled too much off the path
    """

    scene: Scene
    history: dict[str, Array]
    drive_travel: Array
    notes: list[str]
    timings: dict[str, float]
    facts: ModelFacts
    fields: Fields
    reference: Reference | None
    found: FoundPath | None
    off_path: OffPath | None = None

    @property
    def is_smeared(self) -> bool:
        """Whether cracks are smeared over elements."""
        return self.scene.model.kind == "smeared"

    @property
    def controlled(self) -> str:
        """Name of the measure in charge, the column over which the load is drawn: what was measured, else the last one in mm
        that a stage controls, else that of the main gauge, or of one over the mouth of the notch, or the mean jump."""
        if self.reference is not None and self.reference.against in self.history:
            return self.reference.against
        controls = [stage.control for stage in self.scene.stages if self.unit_of(stage.control) == "mm"]
        gauge = "cmod" if "cmod" in self.history and not self.scene.specimen.has_main_gauge else "opening"
        return controls[-1] if controls else gauge

    @property
    def measured(self) -> tuple[Measured, ...]:
        """The measured curves that the scene names."""
        return () if self.reference is None else self.reference.curves

    def unit_of(self, column: str) -> str:
        """Unit of a column of the history; empty for a number without one, and for what is no column."""
        return next((each.unit for each in self.scene.columns if each.name == column), "")

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
        """Row of the largest load of all steps, next to the peak; 0 if there is none."""
        return 1 + int(self.history["load"][1:].argmax()) if self.steps else 0

    def at_peak(self, values: Array) -> float:
        """A quantity of the rows, (rows,), at the largest load, which lies between them: see `peak_weights`; 0 without a step.

        Rows under another direction or drive than the largest one do not count, their load is another."""
        if not self.steps:
            return 0.0
        turned = np.cumsum([stage.redirects for stage in self.scene.stages])[self.history["stage"].astype(int) - 1]
        rows = np.flatnonzero(turned == turned[self.peak_row])
        rows = rows[rows > 0]
        motions = np.stack([self.history[self.controlled], self.history["opening"]])
        near, weights = peak_weights(motions[:, rows], self.history["load"][rows])
        return float(weights @ values[rows[near]])

    @property
    def peak_load(self) -> float:
        """Largest load, N, between the rows: that of `peak` (negative if all loads are)."""
        return self.at_peak(self.history["load"])

    @property
    def peak(self) -> Peak:
        """The largest load (N), and where it comes (mm) on the measure in charge; zeros if there is no step."""
        return Peak(self.peak_load, self.at_peak(self.history[self.controlled]), self.controlled)

    @property
    def opening_at_peak(self) -> float:
        """Column `opening` at the largest load, mm: that of the main gauge, or without one the mean jump over the crack."""
        return self.at_peak(self.history["opening"])

    @property
    def dissipated_energy(self) -> float:
        """Damage dissipation at the end, N mm."""
        return float(self.history["dissipated"][-1]) if self.steps else 0.0

    @property
    def full_energy(self) -> float | None:
        """Dissipation of mode I separation, N mm: (Gf + ft^2 w / 2E) times the crack area, in a band with l_ch for w.
        None if the area is not known, as for a crack anywhere in a user mesh."""
        area = self.facts.crack_area
        return None if area is None else self.law.separation_energy * area

    @property
    def law(self) -> Law:
        """That of the crack, with its material and width."""
        return self.scene.law.built_for(self.scene.material, self.facts.width)

    @property
    def unaccounted(self) -> Array:
        """External work less all energies, each integrated on its own, (rows,), N mm."""
        h = self.history
        return np.asarray(h["work"] - h["elastic"] - h["stored"] - h["dissipated"] - h["contact_work"] - h["released"])

    @property
    def energy_error(self) -> float:
        """Largest difference between external work and energies, each integrated on its own, over the largest work; nan if
        the law leaves its dissipation to the balance."""
        if not self.law.is_checked:
            return math.nan
        if not self.steps:
            return 0.0
        return float(abs(self.unaccounted).max() / max(abs(self.history["work"]).max(), 1e-300))

    @property
    def agreement(self) -> list[Agreement]:
        """How far the run lies from each measured curve of its scene; empty without one."""
        return agreements(self.reference, self.history, self.peak_load)

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
        return self.facts.active_dofs

    @property
    def total_dofs(self) -> int:
        """Unknowns of the whole body."""
        return self.facts.total_dofs

    @property
    def width(self) -> float:
        """Width of the crack plane, or of a band along the path, mm."""
        return self.facts.width

    def added_compliance(self) -> float:
        """What the interface's width adds to the elastic compliance of opening under load, see `ModelFacts`."""
        return self.facts.added_compliance

    def row(self, row: int) -> dict[str, float]:
        """One row of the history (-1 is the last one)."""
        return {name: values[row].item() for name, values in self.history.items()}

    def frame(self, row: int) -> Frame:
        """Fields of a row of the history (0 is the state before the first step, -1 the last one).

        Raises
        ------
        LookupError
            If the run has no such row, or its fields were not kept: see `frame_rows`.
        """
        return self.fields.frame(self._counted(row), self.row(row))

    def frame_rows(self) -> list[int]:
        """Rows that are written as frames: evenly spread, the peak and the last one."""
        last, wanted = self.steps, self.scene.output.frames
        if not last or not wanted:
            return []
        return sorted({*self.fields.nearest(spread(last, min(wanted, last))), self.peak_row})

    def crack(self, row: int) -> dict[str, Array]:
        """The values at the points with cracks in a row of the history, by name, (p,) each: see `Frame`, whose are means over
        cells. They are at `fields.where`; LookupError if they were not kept."""
        return self.fields.at_points(self._counted(row))

    def opening_profile(self, row: int) -> tuple[Array, Array]:
        """Positions (p, d) and openings (p,) of the points with cracks in a row of the history, mm, in the order of
        `profile_distance`. In a band the opening is l_ch times the fracture strain."""
        opening = self.crack(row)["opening"]
        order = np.argsort(self._distance(), kind="stable")
        return self.fields.where[order], opening[order]

    def profile_distance(self) -> Array:
        """Distance along the crack path of the points of `opening_profile`, (p,), mm, ascending; without a path, along the
        longest side of the points."""
        return np.sort(self._distance(), kind="stable")

    def _distance(self) -> Array:
        """Distance along the crack path of each point with a crack, (p,), mm."""
        where, lines = self.fields.where, self.scene.specimen.paths
        return along_paths(where[:, :2] if lines else where, lines)

    def _counted(self, row: int) -> int:
        """The number of a row from the first one on."""
        rows = len(self.history["step"])
        if not -rows <= row < rows:
            raise IndexError(f"row {row}: the run has {rows} rows, the first is 0")
        return row % rows


def spread(last: int, count: int) -> list[int]:
    """So many rows, evenly spread, of which the last is one and the first is not."""
    rows: list[int] = np.linspace(0, last, count + 1).round().astype(int)[1:].tolist()
    return rows
