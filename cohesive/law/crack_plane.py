"""The crack-plane law of Jefferson and Mihai (2015), eqs (1)-(21) and (25).

One law serves interface elements (jump in mm, small `width` or the paper's h) and the crack band
(width = characteristic length, jump = width times local strain). Units N, mm, MPa; tension positive.
If the print leaves a choice, the parameters of `Concrete` say which one is taken.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Array, Index, Mask
from .concrete import Concrete
from .contact_surface import ContactSurface, smoothing_length
from .potential_contact import potential_contact
from .printed_contact import printed_contact
from .registry import Law, LawKeys, register_law
from .softening_branches import Rise
from .softening_choice import softening_name


class CrackPlane(Law):
    """Traction of a rough crack plane as a function of the jump between its faces.

    Parameters
    ----------
    concrete : Concrete
    width : width w of the band that the plane stands for, mm: one number, or an array (n,) with one for each of
        the n points that the methods are then called with. None: w = h, eq. (21) as printed.

    Raises
    ------
    ValueError
        For a width that is not a finite number above 0, or so large that the softening curve rises faster than its secant
        falls: opening would mend damage.

    Attributes
    ----------
    Zt : opening at which damage starts in mode I, mm, with the shape of the width

    Examples
    --------
    >>> import numpy as np
    >>> from cohesive import Concrete, CrackPlane
    >>> plane = CrackPlane(Concrete(E=30000.0, nu=0.2, ft=3.0, Gf=0.1), width=0.1)
    >>> traction, tangent, Z = plane.update(np.array([[0.05, 0.0]]), np.zeros(1))
    >>> print(traction.round(4), Z)
    [[0.6696 0.    ]] [0.05]
    """

    def __init__(self, concrete: Concrete, width: float | Array | None = None) -> None:
        width = concrete.h if width is None else width
        if isinstance(width, np.ndarray):
            if width.ndim != 1 or not ((width > 0) & (width < np.inf)).all():
                raise ValueError(f"width = {width!r}: expected a (n,) array of finite numbers above 0, in mm")
            self.width: Any = np.asarray(width, dtype=float)
        elif isinstance(width, bool) or not isinstance(width, (int, float)) or not 0 < width < np.inf:
            raise ValueError(f"width = {width!r}: expected a finite number above 0, in mm")
        else:
            self.width = float(width)
        self.concrete = concrete
        self.makes_energy = concrete.contact == "printed"
        self.Zt: Any = self.width * concrete.ft / concrete.E
        rise = concrete.steepest_rise
        if rise is not None and not np.max(self.Zt, initial=0.0) < rise.largest_Zt:
            raise ValueError(_too_steep(concrete, float(np.max(self.width)), rise))

    def __repr__(self) -> str:
        return f"CrackPlane({self.concrete!r}, width={self.width!r})"

    def built_for(self, concrete: Concrete, width: Any, components: int = 2) -> CrackPlane:
        return CrackPlaneKeys().built_for(concrete, width, components)

    def with_width(self, width: float | Array) -> CrackPlane:
        return CrackPlane(self.concrete, width)

    @property
    def onset_jump(self) -> float:
        return float(self.Zt)

    @property
    def most_dissipated(self) -> float:
        return self.concrete.most_dissipated(self.width) * self.energy

    @property
    def separation_energy(self) -> float:
        m = self.concrete
        return float(m.Gf + m.ft**2 * self.width / (2 * m.E))

    @property
    def described(self) -> str:
        return f"{softening_name(self.concrete.softening)} softening"

    def energy_text(self, width: str) -> str:
        return f"(Gf + ft^2 {width} / 2E)"

    @property
    def advice(self) -> str:
        printed = " (printed contact can fold as a band closes; material.contact = 'potential' cannot)"
        return printed if self.concrete.contact == "printed" else ""

    def check(self, crack_length: float) -> None:
        self.concrete.check_units(crack_length)

    def initial(self, points: int) -> Array:
        return np.broadcast_to(self.Zt, points).astype(float)

    def stiffness(self, components: int) -> Array:
        """Diagonal of k, eq. (1), MPa/mm: (components,), or (n, components) for an array of widths."""
        m = self.concrete
        moduli = np.array([m.E, m.G, m.G][:components])
        return np.asarray(moduli / (self.width[:, None] if isinstance(self.width, np.ndarray) else self.width))

    def update(self, jump: Array, Z: Array, frozen: bool = False) -> tuple[Array, Array, Array]:
        """Traction, consistent tangent and new history, eq. (21).

        Parameters
        ----------
        jump : (n, d) array, mm, d = 2 or 3
            Local [normal, shear...]; normal > 0 opens.
        Z : (n,) array, mm
            Last converged history. Not modified.
        frozen : bool
            Tangent at constant Z, the unloading branch, if both exist.

        Returns
        -------
        traction : (n, d) array, MPa
        tangent : (n, d, d) array, MPa/mm, unsymmetric
            At Z = Zeq, where loading and unloading differ, the loading one (unless `frozen`).
        Z_new : (n,) array, mm

        Raises
        ------
        ValueError
            If `jump` is not (n, 2) or (n, 3), or `Z` is not (n,).
        """
        jump, Z = _checked(jump, Z)
        n, d = jump.shape
        k = self.stiffness(d)
        Zeq, dZeq = self.equivalent_jump(jump)
        Z0 = np.maximum(Z, self.Zt)
        loading = (Zeq >= Z0) & (not frozen)
        Z_new = np.maximum(Z0, Zeq)
        intact = self.intact(Z_new)
        ku = k * jump
        traction = intact[:, None] * ku
        tangent = np.zeros((n, d, d))
        tangent[:, range(d), range(d)] = intact[:, None] * k
        domega = np.where(loading, self._damage_slope(Z_new), 0.0)
        dt_dZ = -domega[:, None] * ku
        at, contact, slope, dcontact_dZ = self._contact(jump, Z_new)
        if at.size:
            omega = 1.0 - intact[at]
            traction[at] += omega[:, None] * contact
            tangent[at] += omega[:, None, None] * slope
            dt_dZ[at] += domega[at, None] * contact + (omega * loading[at])[:, None] * dcontact_dZ
        tangent += dt_dZ[:, :, None] * dZeq[:, None, :]
        return traction, tangent, Z_new

    def traction(self, jump: Array, Z: Array) -> tuple[Array, Array]:
        """Traction (n, d) and new history (n,) of `update`, without the tangent."""
        jump, Z = _checked(jump, Z)
        Z_new = self.history(jump, Z)
        return self.undamaged_traction(jump, Z_new) + self.contact_traction(jump, Z_new), Z_new

    def history(self, jump: Array, Z: Array) -> Array:
        """New history (n,) of `update`, eq. (4)."""
        return np.asarray(np.maximum(np.maximum(Z, self.Zt), self.equivalent_jump(jump, gradient=False)[0]))

    def equivalent_jump(self, jump: Array, gradient: bool = True) -> tuple[Array, Array]:
        """Zeq of eq. (4a), (n,), mm, and its gradient, (n, d); without `gradient` Zeq twice."""
        m = self.concrete
        gamma, mu = (m.E / m.G) * m.r_sigma, (m.E / m.G) * m.mu_sigma
        A = 0.5 * (1.0 + (mu / gamma) ** 2)
        B = 1.0 - (mu / gamma) ** 2
        u1, v = jump[:, 0], jump[:, 1:]
        root = np.sqrt((B * u1) ** 2 + (2.0 / gamma) ** 2 * np.einsum("ij,ij->i", v, v))
        Zeq = A * u1 + 0.5 * root
        if not gradient:
            return Zeq, Zeq
        safe = np.where(root > 0, root, 1.0)[:, None]
        dZeq = (0.5 / safe) * np.concatenate([(B**2 * u1)[:, None], (2.0 / gamma) ** 2 * v], axis=1)
        dZeq[:, 0] += A
        return Zeq, dZeq

    def undamaged_traction(self, jump: Array, Z: Array) -> Array:
        """First term of eq. (21), (n, d), MPa, at the history `Z` as it stands."""
        jump, Z = _checked(jump, Z)
        return np.asarray(self.intact(np.maximum(Z, self.Zt))[:, None] * (self.stiffness(jump.shape[1]) * jump))

    def contact_traction(self, jump: Array, Z: Array, traction: Array | None = None) -> Array:
        """Second term of eq. (21), (n, d), MPa, at the history `Z` as it stands."""
        if traction is not None:  # what it has besides its first term is exactly zero without contact
            return traction - self.undamaged_traction(jump, Z)
        jump, Z = _checked(jump, Z)
        Z = np.maximum(Z, self.Zt)
        result = np.zeros_like(jump)
        at, contact, _, _ = self._contact(jump, Z, tangent=False)
        result[at] = (1.0 - self.intact(Z)[at])[:, None] * contact
        return result

    def intact(self, Z: Array) -> Array:
        """1 - omega of eq. (5), (n,), for histories of at least Zt: exactly 0 beyond the end of the softening curve. Kept as
        itself: formed as a difference it is 0 from about 7 Zm of the exponential curve."""
        stress = self.concrete.curve.stress(Z - self.Zt)
        return np.asarray(self.Zt / (self.concrete.ft * Z) * stress)

    def strength_left(self, Z: Array) -> Array:
        """Stress of the softening curve at the history Z over ft, (n,); inf for a plane that is not damaged."""
        left = self.concrete.curve.stress(np.maximum(Z - self.Zt, 0.0)) / self.concrete.ft
        return np.where(self.Zt * (1.0 + 1e-9) < Z, left, np.inf)

    def damage(self, Z: Array) -> Array:
        """omega of eq. (5), (n,)."""
        return 1.0 - self.intact(np.maximum(Z, self.Zt))

    def has_ended(self, Z: Array) -> Mask:
        """Whether the softening curve has ended at the history Z, (n,): 1 - omega is 0, and nothing more can be dissipated."""
        return np.asarray(Z - self.Zt >= self.concrete.curve.end)  # as `intact` asks the curve, to the last digit

    def is_fully_softened(self, Z: Array) -> Mask:
        """Whether opening can bring no traction back, (n,): beyond the end of the curve, or with too little left of it."""
        return np.asarray(Z - self.Zt >= self.concrete.fully_softened)

    def is_damaging(self, jump: Array, Z: Array) -> Mask:
        return (self.history(jump, Z) > Z) & ~self.has_ended(Z)

    def is_on_surface(self, jump: Array, Z: Array) -> Mask:
        reached = self.history(jump, np.zeros_like(Z)) >= Z
        return np.asarray(reached & (Z > self.Zt) & ~self.has_ended(Z))

    def contact_distance(self, jump: Array, Z: Array) -> tuple[Array, Array]:
        """Signed distance phi to the contact surface, eqs (8)-(10), and its gradient: (n,), (n, d)."""
        jump, Z = _checked(jump, Z)
        surface = ContactSurface.from_jump(self.concrete, jump, np.maximum(Z, self.Zt))
        return surface.phi, surface.normal

    def contact_reach(self, Z: Array) -> Array:
        """ulm of eq. (19): contact is exactly zero at phi >= ulm. (n,), mm."""
        return self.concrete.c_lm * smoothing_length(self.concrete, np.maximum(Z, self.Zt))[0]

    def stored_energy(self, jump: Array, Z: Array) -> Array:
        """Energy of the undamaged part, (1 - omega) u.k.u / 2, (n,), N/mm, at the history `Z` as it stands."""
        jump, Z = _checked(jump, Z)
        return 0.5 * self.intact(np.maximum(Z, self.Zt)) * self._twice_energy(jump)

    def dissipation(self, jump0: Array, Z0: Array, jump1: Array, Z1: Array) -> tuple[Array, Array]:
        """Damage dissipation of one step, the integral of u.k.u / 2 over omega: (n,), N/mm, and its
        derivative with respect to `jump1`, (n, d).

        Exact while u.k.u / Z^2 stays constant (any proportional path from the origin), second order in
        the step otherwise. The trapezoidal rule over omega would lose 20 Zt ft at the onset of damage.
        With the stress s and the work W of the softening curve, the integral of Z^2 over omega is
        Zt/ft (2 W - Z s): in mode I the step dissipates the change of W - Z s / 2.
        """
        jump0, Z0 = _checked(jump0, Z0)
        jump1, Z1 = _checked(jump1, Z1)
        Z0, Z1 = np.maximum(Z0, self.Zt), np.maximum(Z1, self.Zt)
        Zeq0 = self.equivalent_jump(jump0, gradient=False)[0]
        Zeq1, dZeq1 = self.equivalent_jump(jump1)
        loading = Zeq1 >= Z1
        rise = self._weighted_damage(Z1) - self._weighted_damage(Z0)
        ratio1 = self._twice_energy(jump1) / Z1**2
        # a point that starts its loading inside the damage surface has no ratio of its own there
        on_surface = Zeq0 > (1.0 - 1e-9) * Z0
        ratio = np.where(on_surface, 0.5 * (self._twice_energy(jump0) / Z0**2 + ratio1), ratio1)
        share = np.where(on_surface, 0.5, 1.0)
        ku = self.stiffness(jump1.shape[1]) * jump1
        d_ratio = (2.0 * ku - 2.0 * (ratio1 * Z1)[:, None] * dZeq1) / (Z1**2)[:, None]
        d_rise = Z1**2 * self._damage_slope(Z1)
        gradient = 0.5 * ((ratio * d_rise)[:, None] * dZeq1 + (share * rise)[:, None] * d_ratio)
        return np.where(loading, 0.5 * ratio * rise, 0.0), np.where(loading[:, None], gradient, 0.0)

    # -- pieces, each with its equation ---------------------------------------------------------

    def _twice_energy(self, jump: Array) -> Array:
        """u.k.u"""
        return np.asarray((jump**2 * self.stiffness(jump.shape[1])).sum(axis=1))

    def _damage_slope(self, Z: Array) -> Array:
        """d(omega)/dZ from (5), (n,), 1/mm."""
        curve, w = self.concrete.curve, Z - self.Zt
        return np.asarray(self.Zt / (self.concrete.ft * Z) * (curve.stress(w) / Z - curve.slope(w)))

    def _weighted_damage(self, Z: Array) -> Array:
        """The integral of Z^2 over omega from Zt to Z, but for a constant, (n,), mm^2."""
        curve, w = self.concrete.curve, Z - self.Zt
        return np.asarray(self.Zt / self.concrete.ft * (2.0 * curve.work(w) - Z * curve.stress(w)))

    def _contact(self, jump: Array, Z: Array, tangent: bool = True) -> tuple[Index, Array, Array, Array]:
        """The contact part of the traction, without omega, at the points in contact: their indices, its value, its
        derivative in the jump at constant Z, and its derivative in Z."""
        m, d = self.concrete, jump.shape[1]
        surface = ContactSurface.from_jump(m, jump, Z)
        at = np.flatnonzero(surface.in_contact)
        if not at.size:  # the usual case while a crack opens
            nothing = np.empty((0, d))
            return at, nothing, nothing, nothing
        k, width = self.stiffness(d), self.width
        if isinstance(width, np.ndarray):
            k, width = k[at], width[at]
        if m.contact == "potential":
            return at, *potential_contact(m, k, jump[at], Z[at])
        return at, *printed_contact(m, k, width, jump[at], surface.part(at), tangent)


#: the law of a scene that names none
DEFAULT_LAW = "crack-plane"


@register_law(DEFAULT_LAW)
@dataclass(frozen=True)
class CrackPlaneKeys(LawKeys):
    """The crack-plane law as scenes choose it: its parameters are those of the material."""

    takes_width = is_differentiated = True

    def built_for(self, concrete: Concrete, width: Any, components: int = 2) -> CrackPlane:
        plane = CrackPlane(concrete, width)
        plane.components = components
        return plane

    def zone_length(self, concrete: Concrete) -> float:
        return concrete.zone_length


def _too_steep(concrete: Concrete, width: float, rise: Rise) -> str:
    """Why a softening curve does not fit a width."""
    widest = rise.largest_Zt * concrete.E / concrete.ft
    wanted = f"a width below {widest:.3g} mm" if widest > 0 else "a flatter rise"
    return (
        f"softening: at w = {rise.w:.4g} mm, {rise.stress:.4g} MPa, the stress rises by {rise.slope:.4g} MPa/mm; for a width "
        f"of {width:.4g} mm slope (Zt + w) has to be less than the stress; expected {wanted}"
    )


def _checked(jump: Array, Z: Array) -> tuple[Array, Array]:
    jump, Z = np.asarray(jump, dtype=float), np.asarray(Z, dtype=float)
    if jump.ndim != 2 or jump.shape[1] not in (2, 3):
        raise ValueError(f"jump has shape {jump.shape}: expected (n, 2) or (n, 3)")
    if Z.shape != jump.shape[:1]:
        raise ValueError(f"Z has shape {Z.shape}: expected ({jump.shape[0]},), one per jump")
    return jump, Z
