"""How far a crack has come: the length of its cohesive zone, and its effective length by the body's compliance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshing.paths import along_paths
from meshing.specimens import Specimen

from ..arrays import Array, Index
from ..errors import NotConverged
from ..solver.problem import Problem, State
from .cracks import CrackPart

#: a point is free of traction if less than this part of ft is left of its softening curve: the exponential one has no end
TRACTION_FREE = 0.01

#: lengths at which the compliance is computed; twice as many change the effective length by less than 0.2 % of the path
_LENGTHS = 20

#: root of a stiffness, over that of the undamaged body, below which it is rounding: the rest of the path holds nothing
_ROUNDING = 1e-4


@dataclass(frozen=True)
class CrackLengths:
    """Lengths of a crack in a state.

    Attributes
    ----------
    cracks : CrackPart
    along : (p,) array, distance along the path of each point, mm; None if there is no such path
    share : (p,) array, length of the path that each point stands for, mm
    notch : depth of the notch that the path goes on from, mm; None: no single length says how far the crack has come
    measure : of the problem, whose compliance gives the effective length; None: the driven motion
    """

    cracks: CrackPart
    along: Array | None
    share: Array
    notch: float | None
    measure: str | None

    @classmethod
    def from_specimen(cls, specimen: Specimen, cracks: CrackPart, measures: dict[str, Array]) -> CrackLengths:
        """Lengths along the path of a specimen; the effective one of a single crack from a single notch under one drive."""
        lines, drives = specimen.paths, specimen.drives()
        share = np.full(len(cracks.weights), np.nan)
        if cracks.area is not None:
            share = specimen.crack_length_of(cracks.area) * cracks.weights / cracks.weights.sum()
        is_single = len(lines) == 1 and len(drives) == 1 and all(drive.shear is None for drive in drives.values())
        notch = specimen.notch_depth if is_single and cracks.area is not None else None
        along = None if notch is None else along_paths(cracks.where[:, :2], lines)
        names = [name for name, known in (("cmod", True), ("opening", specimen.has_main_gauge)) if known and name in measures]
        return cls(cracks, along, share, notch, names[0] if names else None)

    def cohesive(self, state: State) -> float:
        """Length of the path that is damaged and not free of traction, mm."""
        left = self.cracks.strength_left(state)
        return float(self.share[np.isfinite(left) & (left > TRACTION_FREE)].sum()) if np.isfinite(self.share).all() else np.nan

    def effective(self, curve: tuple[Array, Array] | None, problem: Problem, state: State) -> float:
        """Length of the crack without tractions, notch included, that has the secant compliance of a state, mm."""
        if curve is None or self.notch is None:
            return np.nan
        motion = problem.motion(self._row(problem), state)
        if state.load <= 0 or motion <= 0:
            return np.nan
        return self.notch + float(np.interp(np.sqrt(state.load / motion), *curve))

    def curve(self, problem: Problem) -> tuple[Array, Array] | None:
        """The root of the body's stiffness, ascending, and the length of the open part of the path with it, mm: it grows about
        linearly as the stiffness falls to 0; None if one length does not say it.

        The points are opened through one after another, in the order of the path. The stiffness is 0 when all are, or from
        the length on at which what is left of the path holds the body no longer.
        """
        if self.along is None:
            return None
        order = np.argsort(self.along, kind="stable")
        where = self.along[order]
        last = np.flatnonzero(np.diff(where, append=np.inf) > 1e-6 * where[-1])  # of the points at each place
        lengths = np.cumsum(self.share[order])[last]
        chosen = np.unique(np.linspace(0, len(last) - 2, _LENGTHS).round().astype(int)) if len(last) > 2 else np.arange(0)
        open_lengths, roots, end = [0.0], [self._root(problem, order[:0])], float(lengths[-1])
        for i in chosen.tolist():
            root = self._root(problem, order[: last[i] + 1])
            if root <= _ROUNDING * roots[0]:
                end = float(lengths[i])
            if not _ROUNDING * roots[0] < root < roots[-1]:
                break
            open_lengths.append(float(lengths[i]))
            roots.append(root)
        return np.array([0.0, *roots[::-1]]), np.array([end, *open_lengths[::-1]])

    def _root(self, problem: Problem, opened: Index) -> float:
        """Root of the load over the motion with some points opened through; 0 if nothing holds the body together."""
        tangent = np.array(problem.point_law.elastic())
        tangent[opened] = 0.0
        try:
            motion = float(self._row(problem) @ problem.response(tangent))
        except NotConverged:
            return 0.0
        return 1.0 / np.sqrt(motion) if motion > 0 else 0.0

    def _row(self, problem: Problem) -> Array:
        return problem.drive if self.measure is None else problem.measures[self.measure]
