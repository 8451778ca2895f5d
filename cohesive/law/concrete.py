"""Material parameters of plain concrete, with the paper's presets."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any

from .softening import SOFTENING, Softening


@dataclass(frozen=True)
class Concrete:
    """Elastic bulk and crack-plane parameters. Units N, mm, MPa.

    Source: Jefferson and Mihai (2015), Tables 1 to 3; their symbols are kept.

    Parameters
    ----------
    E, nu : Young's modulus (MPa) and Poisson's ratio, 0 <= nu < 0.5.
    ft : uniaxial tensile strength (MPa).
    Gf : mode I fracture energy (N/mm).
    h : physical width of the fracture process zone (mm), three times the coarse aggregate.
    m_g : slope of the contact cone.
    r_sigma, mu_sigma : shear intercept over ft and friction factor of the damage surface.
    c, p : decay lengths (in units of Zm) and proportions of the three asperity sizes, eq. (13).
    c1 : end of softening, Zm = c1 Gf / ft.
    n_g : nose radius of the contact surface in units of Zm, eq. (10).
    r_z : smoothing length without damage in units of Zm, eq. (18). The print gives 0.018 without a
        unit; read as millimetres (r_z = 0.018 / Zm) contact eats the softening branch.
    c_zn : growth of the smoothing length with damage, eq. (18).
    c_lm : contact begins c_lm smoothing lengths before the surface, eq. (19). The print says 7,
        which leaves Example 3 almost without shear contact; 3 is the default here.
    u_phi0 : opening (mm) below which no contact is lost, eq. (13); it shifts the contact surface,
        apex included, which the print of eq. (10b) forgets.
    onset_cap : keep contact away from a crack that is younger than the smoothing length, so that
        mode I softening is not disturbed at any width (where u_phi0 <= 0).
    contact : "printed", or "potential" for the mended form of `potential_contact`, which creates no energy in cycles at
        constant damage and never is stiffer than the concrete.
    shear_scaling : H_w of eq. (25); without it H of eq. (13) at every width (the paper's Figure 15a).
    softening : name of a registered curve, see `softening.SOFTENING`, or an object with the protocol `softening.Softening`.

    Raises
    ------
    ValueError
        Naming the parameter, its value and what was expected.
    """

    E: float
    nu: float
    ft: float
    Gf: float
    h: float = 60.0
    m_g: float = 0.425
    r_sigma: float = 1.25
    mu_sigma: float = 0.8
    c: tuple[float, float, float] = (0.01, 0.05, 2.0)
    p: tuple[float, float, float] = (0.6, 0.3, 0.1)
    c1: float = 5.0
    n_g: float = 0.025
    r_z: float = 0.018
    c_zn: float = 9.0
    c_lm: float = 3.0
    u_phi0: float = 0.0
    onset_cap: bool = True
    contact: str = "printed"
    shear_scaling: bool = True
    softening: Any = field(default="exponential", hash=False)

    def __post_init__(self) -> None:
        for name in ("c", "p"):
            object.__setattr__(self, name, _triple(name, getattr(self, name)))
        for name in ("onset_cap", "shear_scaling"):
            if not isinstance(getattr(self, name), bool):
                raise ValueError(f"{name} = {getattr(self, name)!r}: expected true or false")
        if self.contact not in ("printed", "potential"):
            raise ValueError(f"contact = {self.contact!r}: expected 'printed' or 'potential'")
        if self.contact == "potential" and not self.shear_scaling:
            raise ValueError("shear_scaling = False: contact = 'potential' does not depend on the width; expected True")
        for name in (f.name for f in fields(self) if f.type == "float"):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
                raise ValueError(f"{name} = {value!r}: expected a finite number")
            if name in _POSITIVE and not value > 0:
                raise ValueError(f"{name} = {value!r}: expected a number above 0")
        if not 0 <= self.nu < 0.5:
            raise ValueError(f"nu = {self.nu!r}: expected 0 <= nu < 0.5")
        if self.mu_sigma < 0 or self.mu_sigma >= self.r_sigma:
            raise ValueError(f"mu_sigma = {self.mu_sigma!r}: expected 0 <= mu_sigma < r_sigma = {self.r_sigma!r}")
        if self.r_z < 0:
            raise ValueError(f"r_z = {self.r_z!r}: expected a number of at least 0")
        if min(self.c) <= 0:
            raise ValueError(f"c = {list(self.c)}: expected three numbers above 0")
        if min(self.p) < 0 or abs(sum(self.p) - 1.0) > 1e-9:
            raise ValueError(f"p = {list(self.p)}: expected three numbers of at least 0 with sum 1, got sum {sum(self.p):g}")

    @property
    def G(self) -> float:
        """Shear modulus, MPa."""
        return self.E / (2.0 * (1.0 + self.nu))

    @property
    def Zm(self) -> float:
        """Opening at the effective end of softening, mm (also the paper's u0)."""
        return self.c1 * self.Gf / self.ft

    @cached_property
    def curve(self) -> Softening:
        """The softening curve, stress over w = Z - Zt."""
        if isinstance(self.softening, str):
            return SOFTENING[self.softening](self.ft, self.Gf)
        curve: Softening = self.softening
        return curve

    @property
    def characteristic_length(self) -> float:
        """E Gf / ft^2, mm."""
        return self.E * self.Gf / self.ft**2

    @classmethod
    def preset(cls, name: str, **changes: object) -> Concrete:
        """A material of the paper by name (see `PRESETS`), with some parameters changed.

        Raises
        ------
        ValueError
            For a name that is not in `PRESETS` or a parameter out of range.
        """
        if name not in PRESETS:
            raise ValueError(f"preset = {name!r}: expected one of {', '.join(PRESETS)}")
        return cls(**{**PRESETS[name], **changes})  # type: ignore[arg-type]


_POSITIVE = ("E", "ft", "Gf", "h", "m_g", "r_sigma", "c1", "n_g", "c_zn", "c_lm")

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


def _triple(name: str, value: object) -> tuple[float, float, float]:
    """`value` as three finite floats, or a ValueError that names the parameter."""
    try:
        a, b, c = (float(x) for x in value)  # type: ignore[attr-defined]
    except (TypeError, ValueError):
        raise ValueError(f"{name} = {value!r}: expected three numbers") from None
    if not all(map(math.isfinite, (a, b, c))):
        raise ValueError(f"{name} = {value!r}: expected three finite numbers")
    return a, b, c
