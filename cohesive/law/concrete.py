"""Material parameters of plain concrete, with the paper's presets."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np

from meshing.keys import key

from ..errors import ParameterError, SceneError
from .softening import Softening
from .softening_branches import Rise, first_branch, fully_softened, opening_of_first_branch, steepest_rise
from .softening_choice import curve_of, fixes_strength, normalized, strength_and_energy


class Derived(float):
    """A parameter that was not given but follows from others. `dataclasses.replace` hands it on, and it follows again;
    float(value) makes a given number of it."""


@dataclass(frozen=True)
class Concrete:
    """Elastic bulk and crack-plane parameters. Units N, mm, MPa.

    Source: Jefferson and Mihai (2015), Tables 1 to 3; their symbols are kept.

    Parameters
    ----------
    E, nu : Young's modulus (MPa) and Poisson's ratio, 0 <= nu < 0.5.
    ft : uniaxial tensile strength (MPa).
    Gf : mode I fracture energy (N/mm). ft and Gf follow from `softening` if that is a list of points or an object; they may
        then be given besides only if they agree.
    h : physical width of the fracture process zone (mm), three times the coarse aggregate.
    m_g : slope of the contact cone.
    r_sigma, mu_sigma : shear intercept over ft and friction factor of the damage surface.
    c, p : decay lengths (in units of Zm) and proportions of the three asperity sizes, eq. (13).
    c1 : gives Zm = c1 Gf / ft. From the softening curve it cancels.
    n_g : nose radius of the contact surface in units of Zm, eq. (10).
    r_z : smoothing length without damage in units of Zm, eq. (18). The print gives 0.018 without a
        unit; read as millimetres (r_z = 0.018 / Zm) contact eats the softening branch.
    c_zn : growth of the smoothing length with damage, eq. (18).
    c_lm : contact begins c_lm smoothing lengths before the surface, eq. (19). The print says 7,
        which leaves Example 3 almost without shear contact; 3 is the default here.
    u_phi0 : opening (mm) below which no contact is lost, eq. (13), at least 0: below it faces would pass through each other.
        It shifts the contact surface, apex included, which the print of eq. (10b) forgets.
    onset_cap : keep contact away from a crack that is younger than the smoothing length, so that
        mode I softening is not disturbed at any width (if u_phi0 = 0). The cap Z/c_lm rules up to Z = Zm and beyond if
        c_zn <= c_lm, so that neither c_zn nor r_z shapes the growth of contact: refused, as the printed c_lm = 7 with c_zn = 5
        is. With c_lm = 7 and c_zn = 9 it rules up to Z = 0.57 Zm, with the defaults up to 0.08 Zm.
    contact : "printed", or "potential" for the corrected form of `potential_contact`, which creates no energy in cycles at
        constant damage and never is stiffer than the concrete.
    shear_scaling : H_w of eq. (25); without it H of eq. (13) at every width (the paper's Figure 15a).
    softening : stress over opening beyond the onset of damage, w = Z - Zt: the name of a registered curve, see
        `softening.SOFTENING`; {"kink": [x, y]}, two straight branches that meet at the opening x Gf/ft and the stress y ft;
        {"points": [[w, stress], ...]} in mm and MPa, from w = 0 to a last stress of 0; or an object with the protocol
        `softening.Softening`. It may rise again if the secant falls, slope (Zt + w) < stress, see `CrackPlane`.
    Zm : length of the asperities (mm), the paper's u0, which scales everything of the contact and nothing of the curve.
        Default: c1 Gf / ft; with points or an object c1 min(Gf / ft, w1), where w1 is the opening at which the steepest
        secant of the first branch reaches zero stress. For the exponential curve w1 is Gf / ft. The tail of a fibre concrete
        holds most of its energy, and tells nothing of the asperities: with c1 Gf / ft they would be decimetres high. Read
        back, a Zm that was not given is the number that follows, and follows again after `dataclasses.replace`.
    density : of the body (kg/m^3), if its own weight is to act.
    fc : compressive strength (MPa), which the model does not know: a run says where the bulk passes it. Default: 10 ft.
    unusual : take numbers that no concrete has. Without it those outside of `PLAUSIBLE`, or with Gf / ft above
        `LONGEST_OPENING`, are taken for numbers in other units, and refused.

    Raises
    ------
    ValueError
        Naming the parameter, its value and what was expected.
    """

    E: float = key("Young's modulus", unit="MPa")
    nu: float = key("Poisson's ratio, 0 <= nu < 0.5")
    ft: float = key("uniaxial tensile strength; with softening points or an object it follows from them", None, unit="MPa")
    Gf: float = key("mode I fracture energy; with softening points or an object it follows from them", None, unit="N/mm")
    h: float = key("physical width of the fracture process zone, three times the coarse aggregate", 60.0, unit="mm")
    m_g: float = key("slope of the contact cone, eqs (8) and (9)", 0.425)
    r_sigma: float = key("shear intercept of the damage surface over ft", 1.25)
    mu_sigma: float = key("friction factor of the damage surface, below r_sigma", 0.8)
    c: tuple[float, float, float] = key("decay lengths of the three asperity sizes, eq. (13)", (0.01, 0.05, 2.0), unit="Zm")
    p: tuple[float, float, float] = key("proportions of the three asperity sizes, with sum 1, eq. (13)", (0.6, 0.3, 0.1))
    c1: float = key("gives Zm = c1 Gf/ft; it cancels from the softening curve", 5.0)
    n_g: float = key("nose radius of the contact surface, eq. (10)", 0.025, unit="Zm")
    r_z: float = key("smoothing length without damage, eq. (18)", 0.018, unit="Zm")
    c_zn: float = key("the smoothing length grows by Z/c_zn with damage, eq. (18)", 9.0)
    c_lm: float = key("distance from the surface at which contact begins, in smoothing lengths, eq. (19)", 3.0)
    u_phi0: float = key("opening below which no contact is lost, eq. (13); it shifts the contact surface", 0.0, unit="mm")
    onset_cap: bool = key("keep contact away from a crack that is younger than the smoothing length", True)
    contact: str = key("'printed', or 'potential': contact with an energy, which cycles cannot create", "printed")
    shear_scaling: bool = key("H_w of eq. (25); without it H of eq. (13) at every width", True)
    softening: Any = key(
        "softening curve: the name of a registered one, {kink = [x, y]} (two branches that meet at the opening x Gf/ft and "
        "the stress y ft), or {points = [[w, stress], ...]} in mm and MPa",
        "exponential",
        hash=False,
    )
    Zm: float = key("length of the asperities, which scales the contact; default c1 Gf/ft, see Concrete", None, unit="mm")
    density: float = key("density, if the body's own weight is to act", 0.0, unit="kg/m^3")
    fc: float | None = key(
        "compressive strength; the model leaves crushing out, and says where the bulk passes it; default 10 ft",
        None,
        unit="MPa",
    )
    unusual: bool = key("take numbers that no concrete has, which are refused else as given in other units", False)

    def __post_init__(self) -> None:
        for name in ("c", "p"):
            object.__setattr__(self, name, _triple(name, getattr(self, name)))
        for name in ("onset_cap", "shear_scaling", "unusual"):
            if not isinstance(getattr(self, name), bool):
                raise ParameterError.at(name, f" = {getattr(self, name)!r}: expected true or false")
        if self.contact not in ("printed", "potential"):
            raise ParameterError.at("contact", f" = {self.contact!r}: expected 'printed' or 'potential'")
        if self.contact == "potential" and not self.shear_scaling:
            raise ParameterError.at(
                "shear_scaling", " = False: contact = 'potential' does not depend on the width; expected True"
            )
        object.__setattr__(self, "softening", normalized(self.softening))
        self._follow_curve()
        for name in (f.name for f in fields(self) if f.type == "float"):
            value = getattr(self, name)
            if name == "Zm" and (value is None or isinstance(value, Derived)):
                continue
            if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
                raise ParameterError.at(name, f" = {value!r}: expected a finite number")
            if name in _POSITIVE and not value > 0:
                raise ParameterError.at(name, f" = {value!r}: expected a number above 0")
        if self.fc is not None and not (isinstance(self.fc, (int, float)) and 0 < self.fc < math.inf):
            raise ParameterError.at("fc", f" = {self.fc!r}: expected a number above 0")
        if not 0 <= self.nu < 0.5:
            raise ParameterError.at("nu", f" = {self.nu!r}: expected 0 <= nu < 0.5")
        if self.mu_sigma < 0 or self.mu_sigma >= self.r_sigma:
            raise ParameterError.at("mu_sigma", f" = {self.mu_sigma!r}: expected 0 <= mu_sigma < r_sigma = {self.r_sigma!r}")
        for name in ("r_z", "u_phi0", "density"):
            if getattr(self, name) < 0:
                raise ParameterError.at(name, f" = {getattr(self, name)!r}: expected a number of at least 0")
        if min(self.c) <= 0:
            raise ParameterError.at("c", f" = {list(self.c)}: expected three numbers above 0")
        if min(self.p) < 0 or abs(sum(self.p) - 1.0) > 1e-9:
            raise ParameterError.at(
                "p", f" = {list(self.p)}: expected three numbers of at least 0 with sum 1, got sum {sum(self.p):g}"
            )
        if self.onset_cap and self.c_zn <= self.c_lm:
            raise ParameterError.at(
                "c_zn",
                f" = {self.c_zn!r}: contact would grow with onset_cap as it does for any c_zn and r_z up to c_lm = "
                f"{self.c_lm!r}; expected c_zn above c_lm, or onset_cap = false",
            )
        if not self.unusual:
            self._check_plausible()
        self._follow_size()

    def _check_plausible(self) -> None:
        """Refuse numbers that no concrete has: they are in other units."""
        for name, (low, high) in PLAUSIBLE.items():
            value = getattr(self, name)
            if value and not low <= value <= high:
                unit = next(f.metadata["unit"] for f in fields(self) if f.name == name)
                raise ParameterError.at(
                    name, f" = {value:g}: is it in {unit}? Expected {low:g} to {high:g} {unit} for a concrete; {_INSIST}"
                )
        if self.Gf > LONGEST_OPENING * self.ft:
            raise ParameterError.at(
                "Gf",
                f" = {self.Gf:g}: is it in N/mm, and ft = {self.ft:g} in MPa? Gf / ft = {self.Gf / self.ft:.3g} mm; expected "
                f"at most {LONGEST_OPENING:g} mm for a concrete; {_INSIST}",
            )

    @property
    def G(self) -> float:
        """Shear modulus, MPa."""
        return self.E / (2.0 * (1.0 + self.nu))

    def _follow_curve(self) -> None:
        """ft and Gf of a curve that fixes them."""
        if not fixes_strength(self.softening):
            for name in ("ft", "Gf"):
                value = getattr(self, name)
                if value is None:
                    raise ParameterError.at(name, " is missing: expected a number above 0, or softening = {points = ...}")
                if isinstance(value, Derived):  # from points that have been replaced
                    object.__setattr__(self, name, float(value))
            return
        for name, derived in zip(("ft", "Gf"), strength_and_energy(self.softening), strict=True):
            given = getattr(self, name)
            is_given = given is not None and not isinstance(given, Derived)
            if is_given and not (isinstance(given, (int, float)) and abs(given - derived) <= _AGREEMENT * derived):
                raise ParameterError.at(
                    name, f" = {given!r}: the softening curve has {derived:.9g}; expected that, or no {name}"
                )
            object.__setattr__(self, name, Derived(derived))

    def _follow_size(self) -> None:
        """Zm of the curve, which is made and checked here, if it was not given."""
        curve = self.curve
        if self.Zm is not None and not isinstance(self.Zm, Derived):
            return
        length = self.c1 * self.Gf / self.ft
        if fixes_strength(self.softening):
            w1 = opening_of_first_branch(curve)
            if not math.isfinite(w1):
                raise ParameterError.at(
                    "Zm",
                    " is missing: the softening curve rises above its first stress before it falls, which tells nothing of "
                    "the size of the asperities; expected a length in mm",
                )
            length = min(length, self.c1 * w1)
        object.__setattr__(self, "Zm", Derived(length))

    @cached_property
    def curve(self) -> Softening:
        """The softening curve, stress over w = Z - Zt."""
        return curve_of(self.softening, float(self.ft), float(self.Gf))

    @cached_property
    def fully_softened(self) -> float:
        """Opening beyond the onset from which on the curve gives no traction, mm: its end; 17.5 Gf/ft of the exponential one,
        where its stress is below 1e-7 ft."""
        return fully_softened(self.curve)

    @cached_property
    def steepest_rise(self) -> Rise | None:
        """Where the softening curve rises most steeply against its secant, or None if it never rises."""
        return steepest_rise(self.curve)

    @cached_property
    def first_branch_work(self) -> float:
        """Area under the first branch of the softening curve, N/mm: up to its first kink or minimum, see
        `softening_branches.first_branch`, else Gf. The elastic energy of a crack plane, ft^2 width/2E, counts against it:
        a wide plane stretches the curve, and the peak feels it long before Gf does."""
        return float(self.curve.work(np.array([first_branch(self.curve)]))[0])

    @property
    def characteristic_length(self) -> float:
        """E Gf / ft^2, mm."""
        return self.E * self.Gf / self.ft**2

    @property
    def zone_length(self) -> float:
        """E times the area of the first branch over ft^2, mm: what the size of the process zone at the peak goes by. The
        exponential curve has the characteristic length."""
        return self.E * self.first_branch_work / self.ft**2

    def most_dissipated(self, width: float) -> float:
        """Energy that a crack plane of a width can dissipate at most, in shear, over Gf."""
        shear = max(1.0, self.r_sigma**2 * self.E / self.G)
        return float(shear * (1.0 + self.ft**2 * width / (2 * self.E * self.Gf)))

    def check_units(self, crack_length: float) -> None:
        """Refuse numbers in other units than the length of a crack in mm: their ratios are far from any concrete's. Nothing
        is refused if they are `unusual` on purpose.

        Raises
        ------
        SceneError
        """
        if self.unusual:
            return
        if not 1e-6 < self.ft / self.E < 1e-2:
            raise SceneError.at(
                "material.E",
                f" = {self.E:g}, material.ft = {self.ft:g}: ft / E = {self.ft / self.E:.1e}; expected about 1e-4, both in MPa",
            )
        if self.Zm > crack_length:
            raise SceneError.at(
                "material.Gf",
                f" = {self.Gf:g}: softening would end at an opening of {self.Zm:.3g} mm, more than the crack's "
                f"length of {crack_length:.3g} mm; expected Gf in N/mm (MPa mm) and lengths in mm",
            )

    @classmethod
    def preset(cls, name: str, **changes: object) -> Concrete:
        """A material of the paper by name (see `PRESETS`), with some parameters changed.

        Raises
        ------
        ValueError
            For a name that is not in `PRESETS` or a parameter out of range.
        """
        return cls(**with_preset(name, changes))


_POSITIVE = ("E", "ft", "Gf", "h", "m_g", "r_sigma", "c1", "n_g", "c_zn", "c_lm", "Zm")

#: least and largest values in the units of `Concrete`, from aerated mortar to fibre concrete of ultra-high performance.
#: Model Code 2010: E 21e3 to 46e3, ft 1.6 to 5, Gf .12 to .2; cement paste has a Gf of .01, slurry-infiltrated fibre concrete
#: an ft of up to 28 and a Gf of some 30; a scaled weight is carried by a large density
PLAUSIBLE = {"E": (1e3, 2e5), "ft": (0.01, 30.0), "Gf": (1e-4, 50.0), "density": (100.0, 1e7), "fc": (0.1, 1e3)}

#: largest Gf / ft, mm: 0.04 of a plain concrete, 3 of one with fibres, which are pulled out over some 10 mm
LONGEST_OPENING = 5.0

_INSIST = "if it is meant so, add unusual = true"

#: ft and Gf that are given besides points may differ from theirs by this part
_AGREEMENT = 1e-6

#: Tables 1 and 3 of the paper: the crack-plane paths and Examples 1 to 4.
PRESETS: dict[str, dict[str, object]] = {
    "crack-plane": {"E": 40e3, "nu": 0.2, "ft": 3.0, "Gf": 0.12, "h": 56.0},
    "sandwich-panel": {"E": 40e3, "nu": 0.2, "ft": 3.0, "Gf": 0.12, "m_g": 0.3},
    "reinhardt": {"E": 35e3, "nu": 0.2, "ft": 3.2, "Gf": 0.12, "m_g": 0.3},
    "jacobsen": {
        "E": 41e3, "nu": 0.2, "ft": 3.0, "Gf": 0.08, "m_g": 0.18, "h": 20.0,
        "c": (0.01, 0.06, 0.3), "p": (0.2, 0.4, 0.4),
    },
    "walraven": {"E": 25e3, "nu": 0.2, "ft": 2.5, "Gf": 0.10, "m_g": 0.28},
}  # fmt: skip


def with_preset(name: str, changes: Mapping[str, Any]) -> dict[str, Any]:
    """The parameters of a preset with some changed. Of a preset with points or an object for a softening curve, ft and Gf are
    those of the curve.

    Raises
    ------
    ValueError
        For a name that is not in `PRESETS`, or a softening that is none.
    """
    if name not in PRESETS:
        raise ParameterError.at("preset", f" = {name!r}: expected one of {', '.join(PRESETS)}")
    preset = dict(PRESETS[name])
    if fixes_strength(normalized(changes.get("softening", "exponential"))):
        del preset["ft"], preset["Gf"]
    return {**preset, **changes}


def _triple(name: str, value: object) -> tuple[float, float, float]:
    """`value` as three finite floats, or a ValueError that names the parameter."""
    try:
        a, b, c = (float(x) for x in value)  # type: ignore[attr-defined]
    except (TypeError, ValueError):
        raise ParameterError.at(name, f" = {value!r}: expected three numbers") from None
    if not all(map(math.isfinite, (a, b, c))):
        raise ParameterError.at(name, f" = {value!r}: expected three finite numbers")
    return a, b, c
