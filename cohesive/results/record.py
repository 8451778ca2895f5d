"""The rows of a run as they come: their values, and as many of their states as frames can ask for."""

from __future__ import annotations

from array import array
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from ..arrays import Array, Index

if TYPE_CHECKING:
    from ..solver.problem import Problem, State

#: rows up to which a run keeps every state; a longer one keeps at least half as many, evenly spread
ALL_KEPT = 1000

#: states of a longer run for each frame that is asked for, so that frames are spread evenly too
_FOR_A_FRAME = 8


class States:
    """The states of a run by row.

    A run of up to 1000 rows keeps all of them. A longer one keeps those of every second, fourth ... row, of the row with the
    largest load, and of the last one, so that its memory does not grow.

    Parameters
    ----------
    frames : number of frames that will be asked for.
    """

    def __init__(self, frames: int = 0) -> None:
        self._rows = 0
        self._most = max(ALL_KEPT, _FOR_A_FRAME * frames)
        self._apart = 1
        self._kept: dict[int, State] = {}
        self._peak, self._largest = 0, -np.inf

    def append(self, state: State, load: float) -> None:
        """Add the state of the next row with its load, N."""
        row, doubtful = self._rows, [self._rows - 1, self._peak]
        self._kept[row] = state
        self._rows += 1
        if row and load > self._largest:
            self._peak, self._largest = row, load
        if row > self._most * self._apart:
            self._apart *= 2
            doubtful = list(self._kept)
        for old in doubtful:
            if old % self._apart and old not in (self._peak, row):
                self._kept.pop(old, None)

    @property
    def kept(self) -> Index:
        """The rows whose states there are, ascending."""
        return np.array(sorted(self._kept), dtype=int)

    def nearest(self, row: int) -> int:
        """The row with a state that is nearest to a row."""
        return int(self.kept[abs(self.kept - row).argmin()])

    def __getitem__(self, row: int) -> State:
        """The state of a row that is kept; -1 is the last one."""
        return self._kept[row % self._rows]

    def __len__(self) -> int:
        return self._rows


class Record:
    """What a run has come to so far.

    Parameters
    ----------
    problem : Problem, whose drives are followed
    frames : number of frames that will be asked for.
    done : rows and states with which it begins.

    Attributes
    ----------
    states : States
    """

    def __init__(self, problem: Problem, frames: int = 0, done: Iterable[tuple[dict[str, float], State]] = ()) -> None:
        self.states = States(frames)
        self._problem = problem
        self.columns: dict[str, array[float] | array[int]] = {}
        self._travel = array("d")
        self._motions: Array | None = None  # of the drives in the last row
        for row, state in done:
            self.append(row, state)

    def append(self, row: dict[str, float], state: State) -> None:
        """Add a row of the history with its state; wholly or, if an interruption comes between, not at all."""
        if not self.columns:
            self.columns = {name: array("q" if isinstance(value, int) else "d") for name, value in row.items()}
        for name, value in row.items():
            self.columns[name].append(value)  # type: ignore[arg-type]
        motions = self._motions_of(state)
        gone = 0.0 if self._motions is None else float(np.linalg.norm(motions - self._motions))
        self._travel.append(gone + (self._travel[-1] if self._travel else 0.0))
        self._motions = motions
        self.states.append(state, row["load"])

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(self.states)

    @property
    def history(self) -> dict[str, Array]:
        """The columns of the history, (rows,) each."""
        return {name: np.array(values[: self.rows]) for name, values in self.columns.items()}

    @property
    def drive_travel(self) -> Array:
        """Length that the motions of the drives have gone in each row, (rows,), mm."""
        return np.array(self._travel[: self.rows])

    def _motions_of(self, state: State) -> Array:
        """Motions of the drives: both of a platen, else that along the load of each."""
        problem = self._problem
        loading = problem.loading
        motions: list[float] = []
        for name in loading.names:
            drive = loading.drives[name]
            if drive.is_platen:
                motions.extend(state.v[problem.drives[list(drive.motions)]])
            else:
                motions.append(problem.driven_motion(name, state))
        return np.array(motions)
