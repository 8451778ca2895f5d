"""Fields of a line of text: how they are separated, and which of them are numbers, as people and machines write them."""

from __future__ import annotations

import csv
import re
import reprlib
from collections.abc import Sequence
from dataclasses import dataclass

SPACE = " "  # stands for any number of spaces and tabs


class TableError(ValueError):
    """A file that is no table of numbers; the message names line and column if there is one."""


_NUMBER = {
    sign: re.compile(rf"^[+-]?(\d+({sign_}\d*)?|{sign_}\d+)([eE][+-]?\d+)?$|^[+-]?(nan|inf|infinity)$", re.IGNORECASE)
    for sign, sign_ in ((".", r"\."), (",", ","))
}
#: digits in groups of three, "1,075.0", "1.075,0", "1'075.0" or "1 075,0", by the decimal sign
_GROUPED = {
    sign: re.compile(rf"^[+-]?[1-9]\d{{0,2}}([{others}])\d{{3}}(\1\d{{3}})*({sign_}\d*)?$")
    for sign, sign_, others in ((".", r"\.", ",' "), (",", ",", ".' "))
}
_GROUP_SIGNS = str.maketrans("", "", "' ")

#: what machines write if there is no value
_LOST = re.compile(r"^(-{2,}|\*+|\?+|nan|n/?a|#.+|null|none|over|under|overflow|error)$", re.IGNORECASE)


@dataclass(frozen=True)
class Dialect:
    """Separator (tab, ";", "," or " ") and decimal sign, and whether fields stand in quotation marks."""

    separator: str
    decimal: str
    is_quoted: bool = False

    def fields(self, line: str) -> list[str]:
        """The fields of one line."""
        if self.is_quoted and self.separator != SPACE:
            return [field.strip() for field in next(csv.reader([line], delimiter=self.separator))]
        return line.split() if self.separator == SPACE else [field.strip() for field in line.split(self.separator)]

    def is_plain(self, field: str) -> bool:
        """Whether a field is a number without groups of digits; NaN and infinity are."""
        return bool(_NUMBER[self.decimal].match(field))

    def is_grouped(self, field: str) -> bool:
        """Whether a field is a number whose thousands are set apart."""
        return bool(_GROUPED[self.decimal].match(field))

    def is_number(self, field: str) -> bool:
        """Whether a field is a number."""
        return self.is_plain(field) or self.is_grouped(field)

    def value(self, field: str) -> float | None:
        """A field as a number; None if it is none."""
        if not _NUMBER[self.decimal].match(field):
            if not self.is_grouped(field):
                return None
            field = field.replace("." if self.decimal == "," else ",", "").translate(_GROUP_SIGNS)
        return float(field.replace(",", "."))

    def check_groups(self, fields: Sequence[str]) -> None:
        """Refuse a column in which a sign may be that of thousands as well as that of decimals.

        Raises
        ------
        TableError
            Naming the field that leaves it open.
        """
        if all(self.decimal in field for field in fields):
            return  # as most machines write
        plain = [field for field in fields if self.is_plain(field)]
        whole = [digits for field in plain if (digits := field.strip("+-").lstrip("0")).isdigit()]
        if grouped := [field for field in fields if not self.is_plain(field) and self.is_grouped(field)]:
            bare = [field for field in grouped if self.decimal not in field]
            if long := [digits for digits in whole if len(digits) > 3]:
                raise _open(grouped[0], long[0])
            if bare and plain and all(self.decimal in field for field in plain):
                raise _open(bare[0], plain[0])
        elif whole and all(len(digits) <= 3 for digits in whole):
            other = _GROUPED["," if self.decimal == "." else "."]
            signed = [field for field in plain if self.decimal in field]
            if signed and all(map(other.match, signed)):
                raise _open(signed[0], whole[0])


def _open(field: str, beside: str) -> TableError:
    return TableError(
        f"{reprlib.repr(field)} stands in one column with {reprlib.repr(beside)}: its sign may be that of thousands or of "
        "decimals; expected numbers of one column written alike"
    )


def is_lost(field: str) -> bool:
    """Whether a field says that there is no value, as "---", "NaN" and nothing at all do."""
    return not field or bool(_LOST.match(field))
