"""Widths of crack planes and crack bands, against the length of the crack and the energy of the softening curve."""

from __future__ import annotations

from ..errors import SceneError
from .concrete import Concrete

#: the default width of the interface: this part of the crack length, and at most this part of E Gf / ft^2
WIDTH_OF_CRACK, WIDTH_OF_MATERIAL = 0.0025, 0.001

#: the default width of a band along the path, in the same way
BAND_OF_CRACK, BAND_OF_MATERIAL = 0.01, 1 / 60

#: energy that a band dissipates beyond Gf, as a part of Gf: ft^2 l_ch / (2 E Gf)
_WARN_EXCESS, _REFUSE_EXCESS = 0.05, 1.0


def default_width(crack_length: float, zone_length: float) -> float:
    """Width of the crack plane in mm if the scene names none: the smaller of 0.25 % of the crack length and 0.1 %
    of `LawKeys.zone_length`, E Gf / ft^2 with the exponential curve. On the built-in beam it costs less than .4 % of the load
    at small opening and .1 % of the peak against a vanishing width."""
    return min(WIDTH_OF_CRACK * crack_length, WIDTH_OF_MATERIAL * zone_length)


def default_band_width(crack_length: float, zone_length: float) -> float:
    """Width of a band along the path in mm if the scene names none: the smaller of 1 % of the crack length and 1/60 of
    `LawKeys.zone_length`."""
    return min(BAND_OF_CRACK * crack_length, BAND_OF_MATERIAL * zone_length)


def plane_width(zone_length: float, h: float, width: float | str | None, crack_length: float) -> float:
    """Width of the crack plane, mm: as given, that of the print ("h") or, if it is None, that of the rule.

    Raises
    ------
    SceneError
        For a width that is far from that of any crack plane.
    """
    if width is None:
        return default_width(crack_length, zone_length)
    if isinstance(width, str):  # "h"
        return h
    least, most = 1e-6 * crack_length, max(h, crack_length)
    if not least <= width <= most:
        raise SceneError.at("interface.width", f" = {width:g}: expected between {least:.1e} and {most:g} mm")
    return width


def _excess(concrete: Concrete, width: float) -> float:
    """Energy that a band of a width dissipates beyond Gf, over the area of the softening curve's first branch (for the
    exponential curve Gf): a steep first branch suffers long before Gf does."""
    return width / (2.0 * concrete.zone_length)


def check_band_width(concrete: Concrete, width: float, key: str) -> None:
    """Refuse a band that dissipates twice Gf; SceneError."""
    excess = _excess(concrete, width)
    if excess > _REFUSE_EXCESS:
        raise SceneError(
            f"{key} = {width:g}: a band so wide dissipates {100 * (1 + excess):.0f} % of {_what(concrete)} "
            f"(ft^2 l_ch / 2E is {excess:.2g} of it); expected less than {2 * concrete.zone_length:.4g} mm",
            key.partition(":")[0],
        )


def band_note(concrete: Concrete, width: float) -> str | None:
    """A warning if the band's width is felt in the energy."""
    excess = _excess(concrete, width)
    if excess <= _WARN_EXCESS:
        return None
    return (
        f"warning: a band of {width:g} mm dissipates {100 * excess:.1f} % more than {_what(concrete)} (ft^2 l_ch / 2E); "
        f"up to {2 * _WARN_EXCESS * concrete.zone_length:.3g} mm it is below {100 * _WARN_EXCESS:g} %"
    )


def _what(concrete: Concrete) -> str:
    """What the energy of a band is compared with."""
    return "Gf" if concrete.first_branch_work == concrete.Gf else "the softening curve's first branch"
