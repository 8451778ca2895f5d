"""`evaluate`: a measured curve of a notched beam after a standard, without a model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Array
from ..errors import SceneError
from .curve import Measured
from .standards import STANDARDS, Beam, Quantity, energy_with_tail, modulus, residual_strengths

#: quantities of a beam by their keys, with what is asked for if one is missing
_ASKED = {
    "specimen.span": "the distance between the supports",
    "specimen.depth": "the depth of the beam",
    "specimen.thickness": "the thickness of the beam",
    "specimen.notch": "the depth of the notch",
}

#: columns that are deflections of mid-span
_DEFLECTIONS = ("deflection", "driven")


@dataclass(frozen=True)
class Evaluation:
    """What a standard takes from a curve.

    Attributes
    ----------
    standard, name : of the standard and of the curve
    quantities : list of Quantity
    notes : remarks of the reading of the curve, and on what became of its x
    """

    standard: str
    name: str
    quantities: list[Quantity]
    notes: tuple[str, ...] = ()

    @property
    def values(self) -> dict[str, float | None]:
        """The numbers by name."""
        return {each.name: each.value for each in self.quantities}

    def summary(self) -> str:
        """The printed table."""
        lines = [f"{self.name}, {self.standard}"]
        for each in self.quantities:
            value = "-" if each.value is None else f"{each.value:.4g}"
            lines.append(f"  {each.name:<9}{value:>10} {each.unit:<6}{each.remark}".rstrip())
        return "\n".join([*lines, *(f"  {note}" for note in self.notes)])


def evaluate(measured: Measured, standard: str, values: Mapping[str, Any]) -> Evaluation:
    """Evaluate a curve.

    Parameters
    ----------
    measured : load over crack mouth opening, deflection or the motion of a platen, as its `against` says
    standard : "rilem-tc-50", "en-14651" or "jci-s-001"
    values : specimen.span, specimen.depth, specimen.thickness, specimen.notch (mm), mass (kg), and if they differ from span,
        0 and 0: specimen.length, mass_loading (kg), gauge_holder (mm)

    Raises
    ------
    SceneError
        Naming what is missing, or what speaks against the curve.
    """
    if standard not in STANDARDS:
        raise SceneError.at("standard", f" = {standard!r}: expected one of {', '.join(STANDARDS)}")
    beam = beam_of(values, measured.dimensions)
    function, wanted = STANDARDS[standard]
    x, y, remarks = _as_wanted(measured.without_doubt(), standard, wanted)
    quantities = function(beam, x, y)
    if int(np.argmax(y)) == len(y) - 1:
        remarks = [*remarks, "the load rises up to the last row: the peak may not have been reached"]
    is_opening = measured.against not in _DEFLECTIONS
    quantities.append(modulus(beam, measured.x, measured.y, is_opening, _number(values, "gauge_holder", 0.0)))
    return Evaluation(standard, measured.name, quantities, (*measured.notes, *remarks))


def beam_of(values: Mapping[str, Any], offered: Mapping[str, float] | None = None) -> Beam:
    """The beam of some values by their keys; what the file of its curve offers is named if it is missing, and not taken."""
    numbers = {}
    for key, what in _ASKED.items():
        if values.get(key) is None:
            number = (offered or {}).get(key)
            said = "" if number is None else f"; the heading of the file says {number:g}"
            raise SceneError.at(key, f" is missing: expected {what} in mm, --set {key}={number or '...'}{said}")
        numbers[key.split(".")[1]] = _number(values, key, 0.0)
    if not numbers["notch"] < numbers["depth"]:
        raise SceneError.at("specimen.notch", f" = {numbers['notch']:g}: expected less than the depth")
    mass = None if values.get("mass") is None else _number(values, "mass", 0.0)
    length = _number(values, "specimen.length", numbers["span"])
    return Beam(**numbers, length=length, mass=mass, mass_loading=_number(values, "mass_loading", 0.0))


def _as_wanted(measured: Measured, standard: str, wanted: str) -> tuple[Array, Array, list[str]]:
    """The curve over what a standard wants."""
    is_deflection = measured.against in _DEFLECTIONS
    if is_deflection == (wanted == "deflection"):
        return measured.x, measured.y, []
    if standard == "en-14651":
        opening = (measured.x - 0.04) / 0.85
        kept = opening > 0
        x, y = np.r_[0.0, opening[kept]], np.r_[0.0, measured.y[kept]]
        return x, y, ["openings from the deflection, (deflection - .04 mm)/.85"]
    raise SceneError.at(
        "reference.against",
        f" = '{measured.against}': {standard} wants load over {wanted}; expected a curve with "
        f"reference.against = '{wanted}', or another standard",
    )


def _number(values: Mapping[str, Any], key: str, default: float) -> float:
    value = values.get(key, default)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not value >= 0:
        raise SceneError.at(key, f" = {value!r}: expected a number of at least 0")
    return float(value)


def without_mass(measured: Measured, specimen: Mapping[str, Any]) -> Evaluation | None:
    """What a curve says of a beam whose mass is not known, as far as the curve goes; None for another specimen.

    Parameters
    ----------
    specimen : the table of a scene.
    """
    if specimen.get("kind") != "notched-beam" or specimen.get("notch_position"):
        return None
    beam = beam_of({f"specimen.{key}": value for key, value in specimen.items()})
    x, y, is_opening = measured.x, measured.y, measured.against not in _DEFLECTIONS
    quantities = energy_with_tail(beam, x, y, 0.75 if is_opening else 1.0)
    if is_opening:
        quantities += residual_strengths(beam, x, y)
    quantities.append(modulus(beam, x, y, is_opening))
    return Evaluation("without a model", measured.name, [each for each in quantities if each.value is not None])
