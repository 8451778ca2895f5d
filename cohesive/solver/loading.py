"""Loading: what is done to the driven motions of a body, of which a stage moves one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..arrays import Array

#: what a stage may say of the drives that it does not move: held at the force or at the motion reached, or let go
MODES = ("force", "motion", "free")

#: of the drive that the stage moves
_MOVED = "moved"

#: name of the motion that stands for the dead loads: their factor
DEAD = ""


@dataclass(frozen=True)
class Actuator:
    """A drive as the equations see it: one driven motion, or two.

    Attributes
    ----------
    motions : its indices among all driven motions
    is_platen : whether its two motions are those of one platen, which a stage's angle chooses between; if not, they are those
        of two places that opposed forces move apart
    angle : of a platen's motion, degrees: 0 along the first motion, 90 along the second
    hold : whether a platen is held across its motion
    mode : one of MODES, or that a stage moves it
    """

    motions: tuple[int, ...]
    is_platen: bool = False
    angle: float = 0.0
    hold: bool = True
    mode: str = "force"

    @cached_property
    def signs(self) -> Array:
        """Forces of a unit load on its motions; also what measures the driven motion."""
        if len(self.motions) == 1:
            return np.ones(1)
        if not self.is_platen:
            return np.array([1.0, -1.0])
        t = np.radians(self.angle)
        signs = np.array([np.cos(t), np.sin(t)])
        signs[abs(signs) < 1e-15] = 0.0
        return signs

    @property
    def is_free_across(self) -> bool:
        """Whether a platen is free across its motion."""
        return self.is_platen and not self.hold

    def allowed(self) -> Array:
        """Orthonormal columns, (motions, r): how its motions may change."""
        if self.mode == "motion":
            return np.zeros((2, 0)) if self.is_platen or len(self.motions) == 1 else np.full((2, 1), np.sqrt(0.5))
        return self.signs[:, None] if self.is_platen and self.hold else np.eye(len(self.motions))


@dataclass(frozen=True)
class Loading:
    """What is done to the driven motions: one drive is moved, the others are held, loaded or free.

    Attributes
    ----------
    drives : Actuator by name; `DEAD` is the factor of the dead loads, if there are any
    active : name of the one that is moved
    count : number of motions; those of no drive are resisted by springs only
    dead : (count,) array, forces that stay as they are, N
    """

    drives: Mapping[str, Actuator]
    active: str
    count: int
    dead: Array

    @classmethod
    def from_drives(cls, drives: Mapping[str, Actuator], count: int) -> Loading:
        """Before the first stage: the first drive is to be moved, the others are under no force."""
        modes = {name: "motion" if name == DEAD else "force" for name in drives}
        drives = {name: replace(drive, mode=modes[name]) for name, drive in drives.items()}
        return cls(drives, "", count, np.zeros(count)).moving(next(iter(drives)))

    @property
    def names(self) -> list[str]:
        """Of the drives that a stage may name."""
        return [name for name in self.drives if name != DEAD]

    @property
    def moved(self) -> Actuator:
        """The drive that is moved."""
        return self.drives[self.active]

    def row(self, name: str) -> Array:
        """Forces of a unit load on one drive, (count,); also the row that measures its motion."""
        row = np.zeros(self.count)
        row[list(self.drives[name].motions)] = self.drives[name].signs
        return row

    def force(self, name: str, forces: Array) -> float:
        """Load on a drive from the forces on all motions, N."""
        row = self.row(name)
        return float(row @ forces) / float(row @ row)

    @cached_property
    def direction(self) -> Array:
        """The row of the drive that is moved."""
        return self.row(self.active)

    @cached_property
    def allowed(self) -> Array | None:
        """(count, r) array of orthonormal columns, one entry in a row at most: how the motions may change; None: freely."""
        of_drives = {motion for drive in self.drives.values() for motion in drive.motions}
        columns = [np.eye(self.count)[:, [i for i in range(self.count) if i not in of_drives]]]
        for drive in self.drives.values():
            own = drive.allowed()
            part = np.zeros((self.count, own.shape[1]))
            part[list(drive.motions)] = own[: len(drive.motions)]
            columns.append(part)
        matrix = np.concatenate(columns, axis=1)
        return matrix if matrix.shape[1] < self.count else None

    def moving(self, name: str) -> Loading:
        """The same, but that another drive is moved; the one before is held at its force."""
        drives = dict(self.drives)
        if self.active in drives:
            drives[self.active] = replace(drives[self.active], mode="motion" if self.active == DEAD else "force")
        drives[name] = replace(drives[name], mode=_MOVED)
        return replace(self, drives=drives, active=name)

    def turned(self, angle: float | None, hold: bool | None) -> Loading:
        """The same with another angle of the moved platen (degrees), or whether it is held across; None: as it is."""
        drive = self.moved
        drive = replace(drive, angle=drive.angle if angle is None else angle, hold=drive.hold if hold is None else hold)
        return replace(self, drives={**self.drives, self.active: drive})

    def after(self, name: str | None, others: Mapping[str, str], forces: Array) -> Loading:
        """What a stage makes of it.

        Parameters
        ----------
        name : the drive that the stage moves; None: as before.
        others : one of MODES for other drives; those that are not named stay as they are, the one that was moved before is
            held at its force.
        forces : on all motions in the state that the stage begins with, (count,), N.
        """
        new = self.moving(self.active if name is None else name)
        drives = {each: replace(drive, mode=others.get(each, drive.mode)) for each, drive in new.drives.items()}
        dead = np.zeros(self.count)
        for each, drive in drives.items():
            if drive.mode == "force":
                stays = self.drives[each].mode == "force"
                dead += self.force(each, self.dead if stays else forces) * new.row(each)
        return replace(new, drives=drives, dead=dead)
