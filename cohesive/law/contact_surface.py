"""The smoothed contact surface of a rough crack, eqs (8)-(10) and (16)-(20), seen from given jumps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import spence

from ..arrays import Array, Index, Mask

if TYPE_CHECKING:
    from .concrete import Concrete


@dataclass(frozen=True)
class ContactSurface:
    """Signed distances of n jumps to the contact surface, and what follows from them.

    Attributes
    ----------
    phi : (n,) array, mm, negative in contact.
    normal : (n, d) array, n = d(phi)/du, a unit vector.
    dphi_dR : (n,) array, where R is the radius of the nose and moves with its centre.
    distance : (n,) array, mm, from the centre of the nose, or q |s| on the cone.
    cone : (n,) array of bool.
    uz, duz : (n,) arrays, smoothing length (18), mm, and its slope in Z.
    concrete : Concrete
    """

    phi: Array
    normal: Array
    dphi_dR: Array
    distance: Array
    cone: Mask
    uz: Array
    duz: Array
    concrete: Concrete

    def part(self, at: Index) -> ContactSurface:
        """Some of the jumps."""
        return ContactSurface(
            self.phi[at], self.normal[at], self.dphi_dR[at], self.distance[at], self.cone[at], self.uz[at], self.duz[at],
            self.concrete,
        )  # fmt: skip

    def overlap(self) -> Array:
        """g of (16) and (B3), (n,), mm, at most 0: phi deep in contact, 0 from c_lm uz on."""
        tail = np.log1p(np.exp(-2.0 * self.concrete.c_lm))
        return np.asarray(np.minimum(0.5 * self.uz * (tail - np.logaddexp(0.0, -2.0 * self.phi / self.uz)), 0.0))

    def overlap_slopes(self, g: Array) -> tuple[Array, Array]:
        """dg/dphi and dg/dZ, (n,) each; all of uz, R and the centre move with Z."""
        g_phi = 0.5 * (1.0 - np.tanh(self.phi / self.uz))
        g_uz = (g - self.phi * g_phi) / self.uz
        return g_phi, np.asarray(g_phi * self.dphi_dR * self._dR + g_uz * self.duz)

    def work(self, g: Array) -> tuple[Array, Array]:
        """W, the integral of -g from phi to c_lm uz, (n,), mm^2, and dW/dZ. Its slope in phi is g."""
        c, x = self.concrete.c_lm, self.phi / self.uz
        tail = np.log1p(np.exp(-2.0 * c))
        W = 0.5 * self.uz**2 * (_remaining(x) - _remaining(np.asarray(c)) - (c - x) * tail)
        W = np.maximum(np.where(x < c, W, 0.0), 0.0)
        return W, g * self.dphi_dR * self._dR + (2.0 * W - self.phi * g) / self.uz * self.duz

    def curvature(self) -> Array:
        """dn/du, (n, d, d): -(I - s s^T)/(q |s|) in the shear plane on the cone, -(I - n n^T)/d on the nose."""
        d = self.normal.shape[1]
        direction = self.normal.copy()
        direction[self.cone] *= np.sqrt(1.0 + self.concrete.m_g**2)  # its shear part is now the unit vector -s
        direction[self.cone, 0] = 0.0
        dn = direction[:, :, None] * direction[:, None, :]
        dn[:, range(d), range(d)] -= 1.0
        dn[self.cone, 0, 0] = 0.0
        return np.asarray(dn / self.distance[:, None, None])

    def turning(self) -> Array:
        """dn/dZ, (n, d): (e1 - n1 n)/d dR/dZ on the nose, none on the cone."""
        dn_dR = -self.normal[:, :1] * self.normal / self.distance[:, None]
        dn_dR[:, 0] += 1.0 / self.distance
        dn_dR[self.cone] = 0.0
        return np.asarray(dn_dR * self._dR[:, None])

    @property
    def _dR(self) -> Array:
        """dR/dZ from (10) and (19)."""
        return self.concrete.c_lm * self.duz


def _remaining(x: Array) -> Array:
    """The integral of ln(1 + e^(-2 t)) from x to infinity, a dilogarithm."""
    beyond = -0.5 * spence(1.0 + np.exp(-2.0 * abs(x)))
    return np.asarray(np.where(x >= 0, beyond, np.pi**2 / 12.0 + x**2 - beyond))
