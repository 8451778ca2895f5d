"""results/frames"""

from __future__ import annotations

from dataclasses import dataclass

from ..arrays import Array


@dataclass(frozen=True)
class Frame:
    """Fields of one step.

    Attributes
    ----------
    displacement : (m, d), mm
    stress : components in the order of `elements.rotations.PAIRS` in each cell of the elastic blocks, then in those of a band, (n, k)
        each, MPa
    cracks : by name, one value for each crack cell or cell of the band: opening, sliding (mm), damage, traction_n,
        traction_s (MPa), planes. Of a band the crack plane that is open widest counts; its opening and sliding are
        l_ch times the fracture strain, and strain_max is the major principal strain.
    """

    step: int
    displacement: Array
    stress: list[Array]
    cracks: dict[str, Array]
