"""What the lines above a table say of the specimen: its name, and dimensions that are offered, never taken unsaid."""

from __future__ import annotations

from collections.abc import Sequence

from .fields import Dialect
from .units import LENGTHS, bare_unit, factor_in, split_title

#: words with which a line names the specimen
_NAMES = {"probe", "probekörper", "prüfkörper", "probenname", "probenbezeichnung", "specimen", "specimen id", "specimen name",
          "sample", "sample id", "test name", "test", "beam", "balken", "versuch", "éprouvette", "eprouvette"}  # fmt: skip

#: words for a quantity of a beam, by its key
_DIMENSIONS = {
    "specimen.thickness": ("breite", "probenbreite", "width", "thickness", "largeur", "b"),
    "specimen.depth": ("höhe", "hoehe", "probenhöhe", "depth", "height", "hauteur", "h"),
    "specimen.span": ("stützweite", "stuetzweite", "auflagerabstand", "span", "portée", "portee"),
    "specimen.notch": ("kerbtiefe", "kerbe", "notch", "notch depth", "entaille", "a0"),
    "specimen.length": ("länge", "laenge", "probenlänge", "length", "longueur"),
    "mass": ("masse", "mass", "gewicht", "weight"),
}
_MASSES = {"kg": 1.0, "g": 1e-3, "t": 1e3}


def name_in(lines: Sequence[str], dialect: Dialect) -> tuple[str, bool]:
    """Name of the specimen, and whether a line says that it is one; else the last line that is a single word, or nothing."""
    single = ""
    for line in reversed(lines):
        filled = _filled(line, dialect)
        if len(filled) >= 2 and _word(filled[0]) in _NAMES:
            return filled[1], True
        if len(filled) == 1:
            single = single or filled[0]
    return single, False


def dimensions_in(lines: Sequence[str], dialect: Dialect) -> dict[str, float]:
    """Quantities of the specimen by their keys, mm and kg; a line that says no unit of theirs is left alone."""
    found: dict[str, float] = {}
    for line in lines:
        filled = _filled(line, dialect)
        if len(filled) < 2:
            continue
        name, unit = split_title(filled[0].rstrip(": ="))
        rest = filled[1].split()
        number, said = (filled[1], filled[2:3]) if len(rest) == 1 else (rest[0], rest[1:2])
        value = dialect.value(number) if dialect.is_number(number) else _other(dialect).value(number)
        unit = bare_unit(said[0]) if said else unit
        key = dimension_of(name)
        factor = factor_to(key, unit) if key and unit else None
        if key and value is not None and factor is not None and value * factor > 0:
            found.setdefault(key, value * factor)
    return found


def dimension_of(name: str) -> str:
    """The key of a quantity of a beam that a word names; empty if it names none."""
    return next((key for key, words in _DIMENSIONS.items() if _word(name) in words), "")


def factor_to(key: str, unit: str) -> float | None:
    """Millimetres or kilograms in a unit of a quantity, 1 if it names none; None if it is of another kind."""
    if not unit:
        return 1.0
    return _MASSES.get(unit) if key.startswith("mass") else factor_in(unit, LENGTHS)


def _filled(line: str, dialect: Dialect) -> list[str]:
    """The fields of a line that say something; a colon parts a name from its value too."""
    line = line.strip().lstrip("#%/ ")
    fields = [line] if dialect.separator == " " else Dialect(dialect.separator, dialect.decimal, '"' in line).fields(line)
    filled = [field for field in fields if field]
    if len(filled) == 1:
        for sign in (":", "="):
            name, found, value = filled[0].partition(sign)
            if found and value.strip():
                return [name.strip(), value.strip()]
    return filled


def _word(text: str) -> str:
    return " ".join(text.lower().strip(" :=.").split())


def _other(dialect: Dialect) -> Dialect:
    return Dialect(dialect.separator, "." if dialect.decimal == "," else ",", dialect.is_quoted)
