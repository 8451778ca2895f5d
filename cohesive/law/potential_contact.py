"""Contact from a potential: the printed contact of eqs (8)-(20) corrected, `Concrete(contact="potential")`.

The second term of eq. (21), omega H_w g k n, has no potential, and near closure it is stiffer than the concrete around
it. Yet its reduction by opening says what carries it: for small g, H_w k = k H w / [H w + (1 - H) h] is the elastic plane
k in series with asperities of stiffness (1/h) diag(E, G, G) H / (1 - H), which depends on no width. The corrected form
keeps the two in series, and gives the asperities an energy per area of the jump u* that the plane leaves them:

    V(u*) = (G/h) W(phi(u*)) H(u1*) / [1 - H(u1*)],     dW/dphi = g,  W = 0 from c_lm uz on
    contact traction  t = k (u - u*) = dV/du*           times omega, as printed

Its traction is the gradient of Psi = min over u* of (u - u*).k.(u - u*)/2 + V(u*): no closed path at constant damage creates
energy, and with the presets of Table 3 none does while damage grows (u_phi0 > 0 would). Its tangent
T = k A^-1 V'', A = k + V'', is symmetric and never stiffer than k: no band folds in closing. The inelastic jump u* is the same
at every width.
In shear at a given opening it is the printed term, (G/h) g n H/(1 - H) as w -> 0. The normal traction has G for E, and
(G/h) W d[H/(1 - H)]/du1 besides, the compression that keeps rough faces from riding up on each other for nothing. So under a
given pressure sigma above about 1 MPa, which nearly closes the faces, their shear grows far less than sigma, where the printed
form tends to (G/E) sigma/m_g. As 1 - H vanishes at u_phi0, pressed faces approach u1* = u_phi0 and never pass it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..arrays import Array
from ..errors import NoContact
from .concrete import Concrete
from .contact_surface import ContactSurface
from .interlock import interlock

MAX_ITERATIONS = 100  # of the search for the inelastic jump

_CUTS = 60

#: the faces approach closure by at most this part of their distance in one iteration
_APPROACH = 0.9

#: the energy must fall by this part of what its slope promises
_DECREASE = 1e-4

#: converged if the next step is below this number of roundings
_DIGITS = 32.0


def potential_contact(concrete: Concrete, k: Array, jump: Array, Z: Array) -> tuple[Array, Array, Array]:
    """Contact traction without omega, and its slopes, at points in contact.

    Parameters
    ----------
    k : (d,) or (n, d) array, MPa/mm, diagonal of eq. (1).
    jump : (n, d) array, mm.
    Z : (n,) array, mm.

    Returns
    -------
    traction : (n, d) array, MPa
    slope : (n, d, d) array, MPa/mm, derivative in the jump at constant Z
    slope_Z : (n, d) array, MPa/mm, derivative in Z

    Raises
    ------
    NoContact
        If the local iteration fails.
    """
    n, d = jump.shape
    if concrete.u_phi0:  # from there on, so that small distances keep their digits
        jump = jump - concrete.u_phi0 * np.eye(d)[0]
        concrete = replace(concrete, u_phi0=0.0)
    sliding = np.linalg.norm(jump[:, 1:], axis=1)
    along = jump[:, 1:] / np.where(sliding > 0, sliding, 1.0)[:, None]
    k = np.broadcast_to(k[..., :2], (n, 2))
    left = inelastic_jump(concrete, k, np.column_stack([jump[:, 0], sliding]), Z)
    _, t, stiffness, t_Z = _asperity_energy(concrete, left, Z)
    A = stiffness + k[:, :, None] * np.eye(2)
    T = k[:, :, None] * _solved(A, stiffness)
    dZ = k * _solved(A, t_Z[:, :, None])[:, :, 0]
    # (normal, |s|) to components: the shear ones lie along s
    traction = np.column_stack([t[:, 0], t[:, 1:] * along])
    slope_Z = np.column_stack([dZ[:, 0], dZ[:, 1:] * along])
    # across s the traction turns with it
    across = np.where(sliding > 0, t[:, 1] / np.where(sliding > 0, sliding, 1.0), T[:, 1, 1])
    slope = np.empty((n, d, d))
    slope[:, 0, 0] = T[:, 0, 0]
    slope[:, 0, 1:] = T[:, 0, 1:] * along
    slope[:, 1:, 0] = T[:, 1, :1] * along
    slope[:, 1:, 1:] = (T[:, 1, 1] - across)[:, None, None] * along[:, :, None] * along[:, None, :]
    slope[:, range(1, d), range(1, d)] += across[:, None]
    return traction, slope, slope_Z


def _asperity_energy(concrete: Concrete, left: Array, Z: Array) -> tuple[Array, Array, Array, Array]:
    """V at the jumps (n, 2) that are left to the asperities, its gradient and Hessian, and the slope of the gradient in Z."""
    m = concrete
    surface = ContactSurface.from_jump(m, left, Z)
    out = ~surface.in_contact
    g = np.where(out, 0.0, surface.overlap())
    g_phi, g_Z = surface.overlap_slopes(g)
    W, W_Z = surface.work(g)
    H, lost, dH, ddH = interlock(m, left[:, 0])
    B, dB = H / lost, dH / lost**2
    ddB = (ddH + 2.0 * dH**2 / lost) / lost**2
    for quantity in (g_phi, g_Z, W_Z):
        quantity[out] = 0.0
    stiffness = m.G / m.h
    n = surface.normal
    gradient = (B * g)[:, None] * n
    gradient[:, 0] += dB * W
    hessian = (B * g_phi)[:, None, None] * n[:, :, None] * n[:, None, :]
    hessian += (B * g)[:, None, None] * surface.curvature()
    hessian[:, 0] += (dB * g)[:, None] * n
    hessian[:, :, 0] += (dB * g)[:, None] * n
    hessian[:, 0, 0] += ddB * W
    slope_Z = (B * g_Z)[:, None] * n + (B * g)[:, None] * surface.turning()
    slope_Z[:, 0] += dB * W_Z
    return stiffness * B * W, stiffness * gradient, stiffness * hessian, stiffness * slope_Z


def inelastic_jump(concrete: Concrete, k: Array, jump: Array, Z: Array) -> Array:
    """The jumps u* (n, 2) of least energy, by Newton's method with the faces kept apart; k, jump [normal, |s|] (n, 2).

    Raises
    ------
    NoContact
        If the local iteration fails.
    """
    m = concrete
    left = jump.copy()
    # near closure V is about a / u1*: what the plane and the asperities then agree on is the way to begin
    touching = np.column_stack([np.zeros(len(jump)), jump[:, 1]])
    surface = ContactSurface.from_jump(m, touching, Z)
    first_slope = sum(p / (c * m.Zm) for p, c in zip(m.p, m.c, strict=True))
    a = m.G / m.h * surface.work(surface.overlap())[0] / (first_slope * k[:, 0])
    pressed = np.maximum(-jump[:, 0], np.cbrt(a))
    left[:, 0] = np.maximum(jump[:, 0], np.minimum(np.sqrt(a / pressed), m.Zm))
    rounding = np.finfo(float).eps * (abs(jump).max(axis=1) + m.n_g * m.Zm + surface.reach)
    at = np.arange(len(jump))
    value, gradient, hessian = total_energy(m, k, left, jump, Z)
    for _ in range(MAX_ITERATIONS):
        lift = np.maximum(1e-3 * k[at].min(axis=1) - _least(hessian[at]), 0.0)  # downhill also if it is not convex
        step = -_solved(hessian[at] + lift[:, None, None] * np.eye(2), gradient[at, :, None])[:, :, 0]
        room = _APPROACH * left[at, 0]
        length = np.where(-step[:, 0] > room, room / np.where(step[:, 0] < 0, -step[:, 0], 1.0), 1.0)
        converged = (abs(step) <= _DIGITS * rounding[at, None]).all(axis=1)
        left[at[converged]] += length[converged, None] * step[converged]
        at, step, length = at[~converged], step[~converged], length[~converged]
        if not at.size:
            return left
        promised = _DECREASE * (gradient[at] * step).sum(axis=1)
        half = 0.5 * np.linalg.norm(gradient[at], axis=1)
        waiting = np.arange(len(at))
        for _ in range(_CUTS):
            who = at[waiting]
            new = left[who] + length[waiting, None] * step[waiting]
            energy, slope, curvature = total_energy(m, k[who], new, jump[who], Z[who])
            good = energy <= value[who] + length[waiting] * promised[waiting]
            good |= np.linalg.norm(slope, axis=1) < half[waiting]  # if the energy's own digits are spent
            accepted = who[good]
            left[accepted], value[accepted], gradient[accepted], hessian[accepted] = (
                new[good],
                energy[good],
                slope[good],
                curvature[good],
            )
            waiting = waiting[~good]
            if not waiting.size:
                break
            length[waiting] *= 0.4
    raise NoContact(f"no contact found for the jump {jump[at[0]]} at Z = {Z[at[0]]:g}")


def _solved(matrix: Array, right: Array) -> Array:
    """Solutions of systems (n, 2, 2) with right sides (n, 2, k); NoContact if one has none."""
    try:
        return np.asarray(np.linalg.solve(matrix, right))
    except np.linalg.LinAlgError:
        raise NoContact("no contact found: of faces pressed so hard the asperities leave no digit of the plane") from None


def _least(matrix: Array) -> Array:
    """Smaller eigenvalue of symmetric (n, 2, 2)."""
    a, b, c = matrix[:, 0, 0], matrix[:, 0, 1], matrix[:, 1, 1]
    return np.asarray(0.5 * (a + c) - np.hypot(0.5 * (a - c), b))


def total_energy(concrete: Concrete, k: Array, left: Array, jump: Array, Z: Array) -> tuple[Array, Array, Array]:
    """Energy of asperities and plane (n,), N/mm, at the jumps `left` (n, 2), its gradient and its Hessian there."""
    value, gradient, hessian, _ = _asperity_energy(concrete, left, Z)
    value += 0.5 * ((left - jump) ** 2 * k).sum(axis=1)
    gradient += k * (left - jump)
    hessian[:, [0, 1], [0, 1]] += k
    return value, gradient, hessian
