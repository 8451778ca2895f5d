"""Units of lengths and forces as laboratories write them, in keys and in the headings of columns.

A text that claims to be a unit, as in "Force [xy]", is kept as it is, so that it can be refused by its name: it is never taken
as millimetres or newtons.
"""

from __future__ import annotations

import re

from ..errors import ParameterError

#: millimetres in a unit of length
LENGTHS = {"mm": 1.0, "um": 1e-3, "µm": 1e-3, "μm": 1e-3, "micron": 1e-3, "microns": 1e-3, "nm": 1e-6, "cm": 10.0, "dm": 100.0,
           "m": 1e3, **dict.fromkeys(("in", "inch", "inches", "Zoll"), 25.4), **dict.fromkeys(("mil", "mils", "thou"), 0.0254),
           **dict.fromkeys(("ft", "foot", "feet"), 304.8)}  # fmt: skip
#: newtons in a unit of force; a pound is 0.45359237 kg under 9.80665 m/s^2
_POUND = 4.4482216152605
FORCES = {"N": 1.0, "kN": 1e3, "MN": 1e6, "mN": 1e-3, "cN": 0.01, "dN": 0.1, "daN": 10.0, "hN": 100.0, "dyn": 1e-5,
          **dict.fromkeys(("kgf", "kp"), 9.80665), "gf": 9.80665e-3, "tf": 9806.65, "ozf": _POUND / 16.0,
          **dict.fromkeys(("lbf", "lb", "lbs"), _POUND), **dict.fromkeys(("kip", "kips", "klbf"), 1e3 * _POUND)}  # fmt: skip
#: units that are neither, but stand in headings as well
_OTHERS = {"s", "sec", "ms", "min", "h", "V", "mV", "mV/V", "A", "mA", "%", "Pa", "kPa", "MPa", "N/mm2", "N/mm²", "Hz",
           "deg", "°", "°C", "K", "kg", "g", "t", "Nmm", "Nm", "J", "mJ", "kN/s", "N/s", "mm/s", "mm/min", "µm/s"}  # fmt: skip

#: a power of ten, as in "10^-3 mm", "1e-3 mm", "1/1000 mm", "0,001 mm" or "10⁻³ mm"; "5 mm" may be the range of a gauge
_SIGNED = r"10\s*(?:\^|\*\*)\s*\(?([+-]?\d+)\)?|10([⁺⁻]?[⁰¹²³⁴-⁹]+)|1(?:[.,]0)?[eE]([+-]?\d+)"
_POWER = rf"{_SIGNED}|1\s*/\s*1(0+)(?!\d)|0[.,](0*1)(?!\d)"
_BEFORE = re.compile(rf"^[x\u00d7*]?\s*(?:{_POWER})\s*[*·x\u00d7]?\s*")
_AFTER = re.compile(r"\s*/\s*(10+)$")
_SUPERSCRIPTS = str.maketrans("⁺⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "+-0123456789")

#: a unit after a name: "Force [kN]", "CMOD (um)", "Load, N", "Load / N", "Kraft in kN", "load_N", "Force kN"
_BRACKETED = re.compile(r"^(.*?)\s*[\[(<{]\s*([^\[\](){}<>]*?(?:\([^()]*\)[^\[\](){}<>]*?)?)\s*[\])>}]\s*$", re.DOTALL)
_APPENDED = re.compile(r"^(.*?\S)\s*(?:[,;:/_]|\bin\b|\s)\s*(\S.*)$", re.DOTALL)
_CLAIMED = re.compile(r"^(.*\S)\s*(?:[,/]\s*|\bin\s+)([^\s,;:/_]+)\s*$", re.DOTALL)

#: end of a heading in which a unit is looked for, characters
_LONGEST = 200

#: what tells gauges of one quantity apart, besides a number
SIDES = {"left", "right", "front", "back", "top", "bottom", "north", "south", "east", "west", "links", "rechts", "vorne",
         "hinten", "oben", "unten", "gauche", "droite", "a", "b"}  # fmt: skip
#: what stands in brackets as well and is no unit
_QUALIFIERS = SIDES | {"mean", "average", "mittel", "mittelwert", "min", "max", "minimum", "maximum", "lower", "upper",
                       "measured", "gemessen", "corrected", "korrigiert"}  # fmt: skip


def factor_of(unit: str, known: dict[str, float], key: str) -> float:
    """Millimetres or newtons in a unit; a minus before it turns the sign.

    Raises
    ------
    ParameterError
        Naming `key`, if the unit is none of the known ones.
    """
    name = unit.strip()
    sign, name = (-1.0, name[1:].strip()) if name.startswith("-") else (1.0, name)
    factor = factor_in(name, known)
    if factor is None:
        what = ", ".join(each for each in known if each.isascii())
        raise ParameterError.at(key, f" = {unit!r}: expected one of {what}, with a minus before it to turn the sign")
    return sign * factor


def factor_in(text: str, known: dict[str, float]) -> float | None:
    """Millimetres or newtons in a unit, a power of ten before it included; None if it is none of the known ones."""
    text, factor = text.strip(), 1.0
    if match := _BEFORE.match(text):
        power = match[1] or match[2] or match[3]
        exponent = int(power.translate(_SUPERSCRIPTS)) if power else -len(match[4] or match[5])
        if abs(exponent) > 12:
            return None
        text, factor = text[match.end() :], 10.0**exponent
    if match := _AFTER.search(text):
        text, factor = text[: match.start()], factor / float(match[1])
    name = known_unit(text)
    return factor * known[name] if name in known else None


def known_unit(text: str) -> str:
    """A unit as the lists write it, whatever its case if that leaves no doubt; empty if it is none."""
    text = text.strip().removesuffix(".")
    every = [*LENGTHS, *FORCES, *_OTHERS]
    if text in every:
        return text
    folded = [each for each in every if each.lower() == text.lower()]
    return folded[0] if len(folded) == 1 else ""


def split_title(title: str) -> tuple[str, str]:
    """Name and unit of a column's heading; the unit is empty if it claims none, and as it is written if it is not known."""
    before, title = title.strip()[:-_LONGEST], title.strip()[-_LONGEST:]
    name, unit = _split(title)
    return before + name, unit


def _split(title: str) -> tuple[str, str]:
    if match := _BRACKETED.match(title):
        name, inside = match[1].strip(" ,;:/_"), match[2]
        if _is_qualifier(inside):
            name, unit = _split(match[1]) if match[1] else (title, "")
            return f"{name} {inside}".strip(" -"), unit
        return name, bare_unit(inside) or inside
    at = 0
    while match := _APPENDED.match(title[at:]):  # the longest unit is the one that begins first
        end = at + match.end(1)
        if bare_unit(match[2]) and _is_measure(match[2]):
            return title[:end].removesuffix(" in").strip(" ,;:/_"), bare_unit(match[2])
        at = end
    if (match := _CLAIMED.match(title)) and not _is_qualifier(match[2]):
        return match[1].strip(" ,;:/_"), match[2]
    return title, ""


def _is_qualifier(text: str) -> bool:
    words = re.split(r"[\s.,+/-]+", text.lower())
    return all(not word or word.isdecimal() or word in _QUALIFIERS for word in words)


def _is_measure(text: str) -> bool:
    return factor_in(text, LENGTHS) is not None or factor_in(text, FORCES) is not None


def bare_unit(text: str) -> str:
    """The unit that a field of a row of units says, in brackets or not; empty if it is none."""
    text = text.strip().strip("[]{}<>").strip()
    text = text[1:-1].strip() if text.startswith("(") and text.endswith(")") else text
    return known_unit(text) or (text if _is_measure(text) else "")
