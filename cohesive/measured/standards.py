"""What standards for notched beams take from a measured curve, without a model. Units N and mm, masses in kg.

RILEM TC 50-FMC, draft recommendation, Mater. Struct. 18 (1985) 285: GF = (W0 + m g d0)/A_lig with the area W0 under load
over deflection, the deflection d0 at failure, m = m1 + 2 m2, the mass m1 of the beam between its supports and the mass m2 of
the part of the loading arrangement that follows the beam.

JCI-S-001-2003: GF = (.75 W0 + W1)/A_lig, W1 = .75 (S/L m1 + 2 m2) g CMODc, with the area W0 under load over crack mouth
opening up to the opening CMODc at rupture, the span S, the length L and the mass m1 of the beam.

EN 14651:2005+A1:2007: f_ct,L and f_R,j = 3 F l/(2 b hsp^2), with the largest load up to an opening of .05 mm, and the loads
at .5, 1.5, 2.5 and 3.5 mm; deflection = .85 CMOD + .04 mm.

fib Model Code 2010, 5.6.4, linear model: f_Fts = .45 f_R1 (5.6-5), f_Ftu = f_Fts - w_u/CMOD3 (f_Fts - .5 f_R3 + .2 f_R1) >= 0
(5.6-6) with CMOD3 = 2.5 mm, here for w_u = CMOD3: f_Ftu = .5 f_R3 - .2 f_R1.

Elices, Guinea, Planas, Mater. Struct. 25 (1992) 212 and 327; Guinea, Planas, Elices, ibid. 305: far in the tail load and
weight turn the two halves about a hinge, so that P - P_R = A (1/u^2 - 1/u_R^2) with the last load P_R at u_R, and the work of
fracture is the area above P_R, and 2 A/u_R. It needs no mass, and counts what was not measured.

Young's modulus from the first compliance C of the opening: RILEM TC 89-FMT, Mater. Struct. 23 (1990) 457,
E = 6 S a V1/(C b d^2), V1 = .76 - 2.28 x + 3.87 x^2 - 2.04 x^3 + .66/(1 - x)^2 at x = a/d, for S = 4 d. From that of the
deflection: a beam with shear, and its notch after Tada, Paris and Irwin.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.constants import g

from ..arrays import Array
from ..errors import SceneError
from .curve import area_under

#: part of the peak over which the first compliance is taken, and load below which the far tail begins
_RISING, _TAIL = (0.1, 0.4), 0.15

#: openings at which EN 14651 asks for the load, and the end of the range of its limit of proportionality, mm
_OPENINGS, _FIRST = (0.5, 1.5, 2.5, 3.5), 0.05


@dataclass(frozen=True)
class Beam:
    """A notched beam in three-point bending.

    Attributes
    ----------
    span, depth, thickness, notch, length : mm
    mass : of the beam, kg; None if it is not known
    mass_loading : of the arrangement that follows it, kg
    """

    span: float
    depth: float
    thickness: float
    notch: float
    length: float
    mass: float | None = None
    mass_loading: float = 0.0

    @property
    def ligament(self) -> float:
        """Area above the notch, mm^2."""
        return self.thickness * (self.depth - self.notch)

    def needs_mass(self, standard: str) -> float:
        """The mass, kg.

        Raises
        ------
        SceneError
            If it is not known.
        """
        if self.mass is None:
            raise SceneError.at("mass", f" is missing: {standard} expects that of the beam in kg, --set mass=...")
        return self.mass


@dataclass(frozen=True)
class Quantity:
    """A number of an evaluation.

    Attributes
    ----------
    name, unit : of it
    value : None if the curve does not reach so far
    remark : where it comes from
    """

    name: str
    value: float | None
    unit: str
    remark: str = ""


def rilem_tc_50(beam: Beam, x: Array, y: Array) -> list[Quantity]:
    """Fracture energy from load over deflection."""
    mass = beam.needs_mass("rilem-tc-50") * beam.span / beam.length + 2.0 * beam.mass_loading
    work, weight = area_under(np.r_[0.0, y], np.r_[0.0, x]), mass * g * float(x[-1])
    return [
        Quantity("GF", (work + weight) / beam.ligament, "N/mm", "(W0 + m g d0)/A_lig"),
        Quantity("W0", work, "N mm", "area under load over deflection"),
        Quantity("m g d0", weight, "N mm", f"m = {mass:.4g} kg, d0 = {float(x[-1]):.4g} mm"),
        *energy_with_tail(beam, x, y, 1.0),
    ]


def jci_s_001(beam: Beam, x: Array, y: Array) -> list[Quantity]:
    """Fracture energy from load over crack mouth opening."""
    mass = beam.needs_mass("jci-s-001") * beam.span / beam.length + 2.0 * beam.mass_loading
    work, weight = area_under(np.r_[0.0, y], np.r_[0.0, x]), 0.75 * mass * g * float(x[-1])
    return [
        Quantity("GF", (0.75 * work + weight) / beam.ligament, "N/mm", "(.75 W0 + W1)/A_lig"),
        Quantity("W0", work, "N mm", "area under load over opening"),
        Quantity("W1", weight, "N mm", f".75 (S/L m1 + 2 m2) g CMODc, CMODc = {float(x[-1]):.4g} mm"),
        *energy_with_tail(beam, x, y, 0.75),
    ]


def en_14651(beam: Beam, x: Array, y: Array) -> list[Quantity]:
    """Limit of proportionality and residual strengths, and what Model Code 2010 takes from these."""
    quantities = residual_strengths(beam, x, y)
    return [*quantities, *model_code(quantities[1].value, quantities[3].value)]


def residual_strengths(beam: Beam, x: Array, y: Array) -> list[Quantity]:
    """Limit of proportionality and residual strengths from load over crack mouth opening."""
    factor = 3.0 * beam.span / (2.0 * beam.thickness * (beam.depth - beam.notch) ** 2)
    first = float(np.max(np.interp(np.r_[x[x <= _FIRST], _FIRST], x, y)))
    limit = Quantity("fct,L", factor * first, "MPa", f"F_L = {first:.5g} N, the largest load up to {_FIRST:g} mm")
    if x[0] > _FIRST:
        limit = Quantity("fct,L", None, "MPa", f"the curve begins at {float(x[0]):.3g} mm, beyond {_FIRST:g} mm")
    quantities = [limit]
    for j, opening in enumerate(_OPENINGS, start=1):
        load = float(np.interp(opening, x, y)) if opening <= x[-1] * (1.0 + 1e-9) else None
        remark = f"at {opening:g} mm" + ("" if load is not None else f": the curve ends at {float(x[-1]):.3g} mm")
        quantities.append(Quantity(f"fR{j}", None if load is None else factor * load, "MPa", remark))
    return quantities


def model_code(fR1: float | None, fR3: float | None) -> list[Quantity]:
    """Strengths of the linear softening of fibre concrete from residual strengths, MPa."""
    service = None if fR1 is None else 0.45 * fR1
    ultimate = None if fR1 is None or fR3 is None else max(0.5 * fR3 - 0.2 * fR1, 0.0)
    return [
        Quantity("fFts", service, "MPa", "Model Code 2010 (5.6-5), .45 fR1"),
        Quantity("fFtu", ultimate, "MPa", "Model Code 2010 (5.6-6) at w_u = 2.5 mm, .5 fR3 - .2 fR1"),
    ]


def energy_with_tail(beam: Beam, x: Array, y: Array, factor: float) -> list[Quantity]:
    """Fracture energy with the far tail in place of the weight; `factor` is the deflection over x far in the tail."""
    last, peak = float(x[-1]), int(np.argmax(y))
    rest = float(y[-1])
    load = y - rest
    tail = (np.arange(len(x)) > peak) & (load < _TAIL * load[peak]) & (x > 0) & (x < last)
    name = "GF, tail"
    if tail.sum() < 3:
        return [Quantity(name, None, "N/mm", f"fewer than 3 rows below {100 * _TAIL:g} % of the peak tell of the tail")]
    reach = 1.0 / x[tail] ** 2 - 1.0 / last**2
    slope = float(reach @ load[tail]) / float(reach @ reach)
    above = np.maximum(load, 0.0)
    work, unseen = area_under(np.r_[0.0, above], np.r_[0.0, x]), 2.0 * slope / last
    remark = (
        f"tail fitted to P - P_R = A (1/u^2 - 1/u_R^2), A = {slope:.4g} N mm^2; {100 * unseen / (work + unseen):.0f} % unseen"
    )
    return [Quantity(name, factor * (work + unseen) / beam.ligament, "N/mm", remark)]


def modulus(beam: Beam, x: Array, y: Array, is_opening: bool, holder: float = 0.0) -> Quantity:
    """Young's modulus from the first compliance.

    Parameters
    ----------
    is_opening : whether x is the crack mouth opening; else a deflection.
    holder : thickness of the holder of the gauge, mm.
    """
    compliance = first_compliance(x, y)
    if not compliance > 0:
        return Quantity("E", None, "MPa", "the motion does not grow with the load between a tenth and four tenths of the peak")
    S, d, b, a = beam.span, beam.depth, beam.thickness, beam.notch
    ratio = f"span/depth {S / d:.3g}, the formula is for 4"
    if is_opening and not a:
        return Quantity("E", None, "MPa", "without a notch its mouth does not open before it cracks")
    if is_opening:
        z = (a + holder) / (d + holder)
        V1 = 0.76 - 2.28 * z + 3.87 * z**2 - 2.04 * z**3 + 0.66 / (1.0 - z) ** 2
        return Quantity(
            "E", 6.0 * S * a * V1 / (compliance * b * d**2), "MPa", f"compliance of the opening, RILEM TC 89; {ratio}"
        )
    z = a / d
    V2 = (z / (1.0 - z)) ** 2 * (5.58 - 19.57 * z + 36.82 * z**2 - 34.94 * z**3 + 12.77 * z**4)
    whole = S**3 / (4.0 * b * d**3) * (1.0 + 2.85 * (d / S) ** 2 - 0.84 * (d / S) ** 3)
    value = (whole + 1.5 * (S / d) ** 2 / b * V2) / compliance
    return Quantity("E", value, "MPa", "compliance of the deflection, which contains supports and rig: at least this")


def first_compliance(x: Array, y: Array) -> float:
    """Motion over load between a tenth and four tenths of the peak, mm/N: of a straight line through the rows there, or, if
    they are fewer than 2, between the interpolated ends of this part."""
    x, y = np.r_[0.0, x], np.r_[0.0, y]
    peak = int(np.argmax(y))
    low, high = (part * y[peak] for part in _RISING)
    rising = np.flatnonzero((y[: peak + 1] >= low) & (y[: peak + 1] <= high))
    if len(rising) >= 2 and np.ptp(y[rising]) > 0:
        return float(np.polyfit(y[rising], x[rising], 1)[0])
    furthest = np.maximum.accumulate(y[: peak + 1])
    first, last = np.interp([low, high], furthest, x[: peak + 1])
    return float((last - first) / (high - low))


#: function, and the motion that it wants, by the name of the standard
STANDARDS = {
    "rilem-tc-50": (rilem_tc_50, "deflection"),
    "en-14651": (en_14651, "opening"),
    "jci-s-001": (jci_s_001, "opening"),
}
