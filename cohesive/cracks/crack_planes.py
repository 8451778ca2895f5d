"""The crack planes of a band, in one list over all points."""

from __future__ import annotations

from dataclasses import dataclass

from ..arrays import Array, Index


@dataclass(frozen=True)
class CrackPlanes:
    """The crack planes of all points in one list.

    Attributes
    ----------
    point : (c,) array, the point of each plane.
    rotation : (c, d, d) array, rows normal and tangents.
    length : (c,) array, l_ch, mm.
    strain : (c, d) array, e.
    traction : (c, d) array, MPa.
    history : (c,) or (c, h) array, of the law.
    slope : (c, d, k) array, de / deps.
    """

    point: Index
    rotation: Array
    length: Array
    strain: Array
    traction: Array
    history: Array
    slope: Array

    @property
    def jump(self) -> Array:
        """Jump that the plane stands for, (c, d), mm."""
        return self.length[:, None] * self.strain
