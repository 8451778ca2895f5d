"""The contact term of eq. (21) as printed: H_w g k n."""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from .concrete import Concrete
from .contact_surface import ContactSurface
from .interlock import interlock_factor


def printed_contact(
    concrete: Concrete, k: Array, width: float | Array, jump: Array, surface: ContactSurface, tangent: bool = True
) -> tuple[Array, Array, Array]:
    """Contact traction without omega, and its slopes; k n is turned and stretched with n, see `ContactSurface`.

    Parameters
    ----------
    k : (d,) or (n, d) array, MPa/mm, diagonal of eq. (1).
    width : of the crack plane, mm, one number or (n,).
    jump : (n, d) array, mm, of points in contact.
    surface : the contact surface seen from there.
    tangent : whether the slopes are wanted; without it they are no numbers to use.

    Returns
    -------
    traction : (n, d) array, MPa
    slope : (n, d, d) array, MPa/mm, derivative in the jump at constant Z
    slope_Z : (n, d) array, MPa/mm, derivative in Z
    """
    normal, g = surface.normal, surface.overlap()
    H, dH = interlock_factor(concrete, width, jump[:, 0])
    kn = k * normal
    traction = (H * g)[:, None] * kn
    if not tangent:
        return traction, traction, traction
    g_phi, g_Z = surface.overlap_slopes(g)
    slope = kn[:, :, None] * ((H * g_phi)[:, None] * normal)[:, None, :]
    slope[:, :, 0] += (dH * g)[:, None] * kn
    slope += (H * g)[:, None, None] * k[..., :, None] * surface.curvature()
    return traction, slope, np.asarray((H * g_Z)[:, None] * kn + (H * g)[:, None] * k * surface.turning())
