"""Units of lengths and forces as laboratories write them, in keys and in the headings of columns."""

from __future__ import annotations

import re

from ..errors import ParameterError

#: millimetres in a unit of length
LENGTHS = {"mm": 1.0, "um": 1e-3, "µm": 1e-3, "μm": 1e-3, "micron": 1e-3, "microns": 1e-3, "nm": 1e-6, "cm": 10.0, "m": 1e3,
           "in": 25.4, "inch": 25.4, "mil": 0.0254}  # fmt: skip
#: newtons in a unit of force; a pound is 0.45359237 kg under 9.80665 m/s^2
FORCES = {"N": 1.0, "kN": 1e3, "MN": 1e6, "mN": 1e-3, "daN": 10.0, "kgf": 9.80665, "lbf": 4.4482216152605,
          "lb": 4.4482216152605, "kip": 4448.2216152605}  # fmt: skip
#: units that are neither, but stand in headings as well
_OTHERS = {"s", "sec", "ms", "min", "h", "V", "mV", "mV/V", "A", "mA", "%", "Pa", "kPa", "MPa", "N/mm2", "N/mm²", "Hz", "deg",
           "°", "°C", "K", "kg", "g", "t", "Nmm", "Nm", "J", "mJ"}  # fmt: skip

#: a unit after a name: "Force [kN]", "CMOD (um)", "Load, N", "Load / N", "Kraft in kN", "load_N", "Force kN"
_BRACKETED = re.compile(r"^(.*?)\s*[\[(<{]\s*([^\[\](){}<>]*?)\s*[\])>}]\s*$", re.DOTALL)
_APPENDED = re.compile(r"^(.*\S)\s*(?:[,;:/_]|\bin\b|\s)\s*([^\s,;:/_]+)\s*$", re.DOTALL)


def factor_of(unit: str, known: dict[str, float], key: str) -> float:
    """Millimetres or newtons in a unit; a minus before it turns the sign.

    Raises
    ------
    ParameterError
        Naming `key`, if the unit is none of the known ones.
    """
    name = unit.strip()
    sign, name = (-1.0, name[1:].strip()) if name.startswith("-") else (1.0, name)
    found = known_unit(name)
    if found not in known:
        what = ", ".join(each for each in known if each.isascii())
        raise ParameterError(f"{key} = {unit!r}: expected one of {what}, with a minus before it to turn the sign", key)
    return sign * known[found]


def known_unit(text: str) -> str:
    """A unit as the lists write it, whatever its case if that leaves no doubt; empty if it is none."""
    text = text.strip()
    every = [*LENGTHS, *FORCES, *_OTHERS]
    if text in every:
        return text
    folded = [each for each in every if each.lower() == text.lower()]
    return folded[0] if len(folded) == 1 else ""


def split_title(title: str) -> tuple[str, str]:
    """Name and unit of a column's heading; the unit is empty if it says none that is known."""
    title = title.strip()
    if (match := _BRACKETED.match(title)) and known_unit(match[2]):
        return match[1].strip(" ,;:/_"), known_unit(match[2])
    if (match := _APPENDED.match(title)) and match[1] and (known_unit(match[2]) in {*LENGTHS, *FORCES}):
        return match[1].removesuffix(" in").strip(" ,;:/_"), known_unit(match[2])
    return title, ""


def bare_unit(text: str) -> str:
    """The unit that a field of a row of units says, in brackets or not; empty if it is none."""
    return known_unit(text.strip().strip("[](){}<>"))
