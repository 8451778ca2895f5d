"""The smoothed contact surface of a rough crack, eqs (8)-(10) and (16)-(20), seen from given jumps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array, Index, Mask
from .concrete import Concrete


def smoothing_length(concrete: Concrete, Z: Array) -> tuple[Array, Array]:
    """uz of eq. (18), mm, and its slope in Z, (n,) each.

    With `onset_cap` uz is at most Z / c_lm: then contact begins no further than Z before the surface, and a crack that opens
    monotonically meets none at any width.
    """
    m = concrete
    uz = m.r_z * m.Zm + np.minimum(Z, m.Zm) / m.c_zn
    slope = np.where(Z < m.Zm, 1.0 / m.c_zn, 0.0)
    if m.onset_cap:
        capped = Z / m.c_lm < uz
        uz, slope = np.where(capped, Z / m.c_lm, uz), np.where(capped, 1.0 / m.c_lm, slope)
    return uz, slope


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

    @classmethod
    def from_jump(cls, concrete: Concrete, jump: Array, Z: Array) -> ContactSurface:
        """The surface at the histories Z (n,) seen from the jumps (n, d), mm: cone (8), (9) and nose (10)."""
        m = concrete
        q = np.sqrt(1.0 + m.m_g**2)
        uz, duz = smoothing_length(m, Z)
        R = m.n_g * m.Zm + m.c_lm * uz
        u1, v = jump[:, 0], jump[:, 1:]
        s = np.sqrt(np.einsum("ij,ij->i", v, v))
        opened = u1 - m.u_phi0
        x = opened - R  # from the centre of the nose
        cone = x + m.m_g * s > 0
        d = np.hypot(x, s)
        d = np.where(d > 0, d, 1.0)
        s_safe = np.where(s > 0, s, 1.0)
        apex = R * (m.m_g - q) / m.m_g
        # R - d, with its digits where the nose is small and where it is touched
        nose = ((2.0 * R - opened) * opened - s**2) / (R + d)
        phi = np.where(cone, (m.m_g * (opened - apex) - s) / q, nose)
        normal = np.empty_like(jump)
        normal[:, 0] = np.where(cone, m.m_g / q, -x / d)
        distance = np.where(cone, q * s_safe, d)
        normal[:, 1:] = -v / distance[:, None]
        dphi_dR = np.where(cone, (q - m.m_g) / q, 1.0 - normal[:, 0])
        return cls(phi, normal, dphi_dR, distance, cone, uz, duz, m)

    @property
    def reach(self) -> Array:
        """ulm of eq. (19), (n,), mm: contact is exactly zero at phi >= ulm."""
        return np.asarray(self.concrete.c_lm * self.uz)

    @property
    def in_contact(self) -> Mask:
        """Whether the faces touch, (n,)."""
        return self.phi < self.reach

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
    from scipy.special import spence  # the corrected contact alone waits for it

    beyond = -0.5 * spence(1.0 + np.exp(-2.0 * abs(x)))
    return np.asarray(np.where(x >= 0, beyond, np.pi**2 / 12.0 + x**2 - beyond))
