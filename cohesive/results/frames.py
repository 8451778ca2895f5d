"""The fields of one step: recovered from the unknowns, and as a mesh that ParaView reads."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import meshio
import numpy as np

from ..arrays import Array
from ..elements.rotations import PAIRS, major_stress

if TYPE_CHECKING:
    from ..model.model import Model
    from ..solver.problem import State


@dataclass(frozen=True)
class Frame:
    """Fields of one step.

    Attributes
    ----------
    step : its number in the history
    displacement : (m, d), mm
    stress : for each elastic block, then for each block of a band, the mean stress of its cells, (n, k), MPa; components
        in the order of `elements.rotations.PAIRS`
    cracks : by name, one value for each crack cell or cell of the band: opening, sliding (mm), damage, traction_n,
        traction_s (MPa), planes. In a band the crack plane that is open widest counts; its opening and sliding are
        l_ch times the fracture strain, and strain_max is the major principal strain.
    """

    step: int
    displacement: Array
    stress: list[Array]
    cracks: dict[str, Array]


def frame_of(model: Model, state: State, displacement: Array, step: int) -> Frame:
    """The fields of a state, from the displacements (m, d) of all nodes in it, mm."""
    stress = [block.stress(displacement) for block in model.bulk]
    stress += model.cracks.cell_stresses(state, [len(block.cells) for block in model.band])
    return Frame(step, displacement, stress, model.cracks.cell_values(state))


def frame_mesh(model: Model, frame: Frame) -> meshio.Mesh:
    """Bulk and crack cells with the fields of a frame, in three dimensions; warp by `displacement` to see the crack open."""
    mesh, n = model.mesh.whole, sum(len(block.cells) for block in model.bulk)
    m, d = mesh.points.shape
    points, displacement = (np.column_stack([x, np.zeros((m, 3 - d))]) for x in (mesh.points, frame.displacement))
    total = sum(len(block.data) for block in mesh.cells)
    # cells that a field does not belong to carry 0: NaN would break readers of the ASCII format
    flat = {name: np.r_[np.zeros(n), values] for name, values in frame.cracks.items()}
    flat["is_crack"] = np.r_[np.zeros(n), np.ones(total - n)]
    stress = np.concatenate(frame.stress)
    stress = np.concatenate([stress, np.zeros((total - len(stress), stress.shape[1]))])
    flat |= {f"stress_{'xyz'[i]}{'xyz'[j]}": stress[:, k] for k, (i, j) in enumerate(PAIRS[d])}
    flat["stress_max"] = major_stress(stress)
    ends = np.cumsum([len(block.data) for block in mesh.cells])[:-1]
    data = {name: np.split(values, ends) for name, values in flat.items()}
    return meshio.Mesh(points, [(b.type, b.data) for b in mesh.cells], {"displacement": displacement}, data)
