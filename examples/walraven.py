"""Walraven's linear fit of the stresses on a crack that is opened and slid."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def walraven(opening: Array | float, sliding: Array | float, strength: float) -> tuple[Array, Array]:
    """Shear stress, and pressure that is not below 0 (MPa), at an opening and a sliding (mm).

    Walraven and Reinhardt's fit to their push-off tests; strength is that of cubes, MPa.
    """
    w, d = np.asarray(opening, dtype=float), np.asarray(sliding, dtype=float)
    shear = -strength / 30 + (1.80 * w**-0.80 + (0.234 * w**-0.707 - 0.20) * strength) * d
    pressure = -strength / 20 + (1.35 * w**-0.63 + (0.191 * w**-0.552 - 0.15) * strength) * d
    return np.asarray(shear), np.asarray(np.maximum(pressure, 0.0))
