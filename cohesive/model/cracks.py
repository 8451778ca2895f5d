"""What stands for the crack in either model: its points, and what they say of a state."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp

from ..arrays import Array, Index
from ..elements.interface import Interface
from ..solver.problem import State


@dataclass(frozen=True)
class CrackPart(ABC):
    """The points with cracks.

    Attributes
    ----------
    point_law : PointLaw
    operator : (c p, d m) sparse matrix, displacements of the nodes to jumps or strains
    weights, where, cell : (p,), (p, d), (p,): weight, position and cell of each point, the cells counted over all
        blocks of the part
    area : of the crack, mm^2; None if there is neither a path nor a row of elements that tells
    width : of the crack plane: w, or the l_ch of a crack along the path
    rotations : (p, d, d) normal and tangents of the path at each point; None without a path
    faces : Interface between the two sides of the path, which gives the mean jump; None without a path
    """

    point_law: Any
    operator: sp.csr_array
    weights: Array
    where: Array
    cell: Index
    area: float | None
    width: float
    rotations: Array | None
    faces: Interface | None

    @abstractmethod
    def mean_traction(self, state: State) -> Array:
        """Mean [normal, shear] traction on the crack, MPa; without a path, on all crack planes. In 3D the shear along the
        first tangent of `elements.rotations.rotations`."""

    @abstractmethod
    def point_values(self, state: State) -> dict[str, Array]:
        """The crack at each point, see `Frame`: (p,) each."""

    @abstractmethod
    def strength_left(self, state: State) -> Array:
        """Stress of the softening curve that each damaged point has come to, over ft, (p,); inf if it is undamaged. In a band
        the least of its planes."""

    @abstractmethod
    def law_values(self, state: State) -> dict[str, Array]:
        """Quantities of the law's own at each point, (p,) each, by the names of their columns."""


def values_by_name(jump: Array, traction: Array, damage: Array, planes: Array) -> dict[str, Array]:
    """Opening, sliding, tractions, damage and number of planes at points, (p,) each."""
    return {
        "opening": jump[:, 0],
        "sliding": _shear(jump),
        "traction_n": traction[:, 0],
        "traction_s": _shear(traction),
        "damage": damage,
        "planes": planes,
    }


def _shear(components: Array) -> Array:
    """The shear component of [normal, shear], (n, 2); in 3D, where its axes mean nothing, the size of both of them."""
    return np.asarray(components[:, 1] if components.shape[1] == 2 else np.linalg.norm(components[:, 1:], axis=1))
