"""Interlock of the asperities: what is left of their grip when a crack has opened, eqs (13) and (25)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from .concrete import Concrete


class Interlock(NamedTuple):
    """H of eq. (13) at n openings, (n,) each.

    Attributes
    ----------
    H : 1 for faces that are closed, falling to 0.
    lost : 1 - H with its digits near closure.
    slope, curvature : dH/du1 in 1/mm and d2H/du1^2 in 1/mm^2; 0 for faces that are closed.
    """

    H: Array
    lost: Array
    slope: Array
    curvature: Array


def interlock(concrete: Concrete, u1: Array) -> Interlock:
    """H(u1) = sum_i p_i exp[-(u1 - u_phi0) / (c_i Zm)], 1 below u_phi0, eq. (13); u1 in mm, (n,)."""
    m = concrete
    p, length = np.array(m.p)[:, None], m.Zm * np.array(m.c)[:, None]  # a row for each term
    opened = np.maximum(u1 - m.u_phi0, 0.0) / length
    share = p * np.exp(-opened)
    falling = np.where(u1 < m.u_phi0, 0.0, share / length)
    lost = -(p * np.expm1(-opened)).sum(axis=0)
    return Interlock(share.sum(axis=0), lost, -falling.sum(axis=0), (falling / length).sum(axis=0))


def interlock_factor(concrete: Concrete, width: float | Array, u1: Array) -> tuple[Array, Array]:
    """H_w = H w / [H w + (1 - H) h], eq. (25), and its slope in u1, (n,) each; H itself without `shear_scaling`.

    `width` in mm, one number or (n,). For w = h the factor is H, eq. (21) as printed.
    """
    H, lost, slope, _ = interlock(concrete, u1)
    if not concrete.shear_scaling:
        return H, slope
    h = concrete.h
    below = H * width + lost * h
    # far open, H underflows: H_w is 0 there, whatever its exact ratio
    return np.asarray(H * width / below), np.asarray(width * h / below**2 * slope)
