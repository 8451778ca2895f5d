"""What a scene says of a user's mesh: its entries checked, each error naming its key."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from ..errors import MeshError
from .base import MAIN_GAUGE, Direction, Drive, Gauge, Location, Pressure, Region, Specimen, Support

#: names of drives and gauges are, or end, names of columns of the history
_NAME = "a name of letters, digits, - and _"


def are_names(value: Any) -> bool:
    """Whether it is a list of names."""
    return isinstance(value, list) and bool(value) and all(isinstance(each, str) for each in value)


def location(name: str, value: Any) -> Location:
    """The name of a set, or a point."""
    if isinstance(value, str):
        return value
    return _vector(name, value, "the name of a set or a point [x, y], in space [x, y, z]")


def unit_vector(name: str, value: Any) -> Direction:
    """A direction of any length as a unit vector."""
    direction = _vector(name, value, "two numbers [x, y], in space three")
    length = math.hypot(*direction)
    if not length > 0:
        raise MeshError.at(name, f" = {value!r}: expected a vector that is not zero")
    return tuple(c / length for c in direction)


def support_of(entry: Any) -> Support:
    """{at, direction(, stiffness)}"""
    _check_entry("supports", entry, {"at", "direction"}, {"stiffness"}, "{at = ..., direction = [x, y]}")
    at, direction = location("supports.at", entry["at"]), unit_vector("supports.direction", entry["direction"])
    stiffness = entry.get("stiffness")
    if stiffness is not None:
        _check_number("supports.stiffness", stiffness, lambda k: k > 0, "a number above 0, in N/mm")
    return Support(at, direction, stiffness=stiffness)


def drives_of(one: Any, several: Any) -> dict[str, Drive]:
    """The drives by name, from the key `drive` or the key `drives`."""
    if (one is None) == (several is None):
        raise MeshError.at("drive", ", drives: expected one of these keys")
    if several is None:
        return {"drive": _drive("drive", one, set())}
    if not isinstance(several, list) or not several:
        raise MeshError.at("drives", f" = {several!r}: expected a list of {{name = ..., at = ..., direction = [x, y]}}")
    drives: dict[str, Drive] = {}
    for entry in several:
        drive = _drive("drives", entry, {"name"})
        name = entry["name"]
        if not _is_name(name) or name in drives:
            raise MeshError.at("drives.name", f" = {name!r}: expected {_NAME}, that no other drive has")
        drives[name] = drive
    return drives


def gauges_of(given: Any) -> dict[str, Gauge]:
    """{name = {plus, minus(, direction)}}"""
    gauges: dict[str, Gauge] = {}
    for name, entry in _entries("gauges", given, "{name = {plus = ..., minus = ..., direction = [x, y]}}").items():
        if not _is_name(name) or name == MAIN_GAUGE:
            raise MeshError.at("gauges", f": a gauge is called {name!r}; expected {_NAME}, and not '{MAIN_GAUGE}'")
        key = f"gauges.{name}"
        _check_entry(key, entry, {"plus", "minus"}, {"direction"}, "{plus = ..., minus = ...}")
        plus, minus = (location(f"{key}.{side}", entry[side]) for side in ("plus", "minus"))
        direction = unit_vector(f"{key}.direction", entry["direction"]) if "direction" in entry else None
        gauges[name] = Gauge(plus, minus, direction)
    return gauges


def regions_of(given: Any) -> dict[str, Region]:
    """{name = {E, nu(, density)}}"""
    entries = _entries("regions", given, "{name = {E = ..., nu = ...}}")
    for name, entry in entries.items():
        _check_entry(f"regions.{name}", entry, {"E", "nu"}, {"density"}, "{E = ..., nu = ...}")
        _check_number(f"regions.{name}.E", entry["E"], lambda E: E > 0, "a number above 0, in MPa")
        _check_number(f"regions.{name}.nu", entry["nu"], lambda nu: 0 <= nu < 0.5, "a number of at least 0 and below 0.5")
        if "density" in entry:
            _check_number(f"regions.{name}.density", entry["density"], lambda d: d >= 0, "a number of at least 0, in kg/m^3")
    return {name: Region(**entry) for name, entry in entries.items()}


def _entries(key: str, given: Any, expected: str) -> Mapping[str, Any]:
    """A table of entries by name; empty without one."""
    if given is not None and (not isinstance(given, Mapping) or not given):
        raise MeshError.at(key, f" = {given!r}: expected {expected}")
    return given or {}


def pressures_of(given: Any) -> list[Pressure]:
    """A list of {at, value}."""
    if given is None:
        return []
    if not isinstance(given, list) or not given:
        raise MeshError.at("pressures", f" = {given!r}: expected a list of {{at = set, value = MPa}}")
    for entry in given:
        _check_entry("pressures", entry, {"at", "value"}, set(), "{at = set of nodes, value = MPa}")
        if not isinstance(entry["at"], str):
            raise MeshError.at("pressures.at", f" = {entry['at']!r}: expected the name of a set")
        _check_number("pressures.value", entry["value"], lambda p: True, "a number, in MPa")
    return [Pressure(**entry) for entry in given]


def _drive(key: str, entry: Any, further: set[str]) -> Drive:
    """{at, direction(, against)} and further names."""
    names = "".join(f"{name} = ..., " for name in further)
    _check_entry(key, entry, {"at", "direction"} | further, {"against"}, f"{{{names}at = ..., direction = [x, y]}}")
    at, direction = location(f"{key}.at", entry["at"]), unit_vector(f"{key}.direction", entry["direction"])
    against = location(f"{key}.against", entry["against"]) if "against" in entry else None
    if against == at:
        raise MeshError.at(f"{key}.against", f" = {against!r}: expected another location than at")
    return Drive(at, direction, against=against)


def _is_name(name: Any) -> bool:
    return isinstance(name, str) and name.replace("-", "").replace("_", "").isalnum() and name.isascii()


def _vector(name: str, value: Any, expected: str) -> Direction:
    try:
        components = tuple(float(c) for c in value)
    except (TypeError, ValueError):
        raise MeshError.at(name, f" = {value!r}: expected {expected}") from None
    if len(components) not in (2, 3) or not all(math.isfinite(c) for c in components):
        raise MeshError.at(name, f" = {value!r}: expected {expected}")
    return components


def _check_entry(name: str, entry: Any, needed: set[str], more: set[str], expected: str) -> None:
    if not isinstance(entry, Mapping) or not needed <= set(entry) <= needed | more:
        also = f", and {' or '.join(sorted(more))} if wanted" if more else ""
        raise MeshError.at(name, f" = {entry!r}: expected {expected}{also}")


def _check_number(name: str, value: Any, holds: Callable[[float], bool], expected: str) -> None:
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 1e100
    if not is_number or not holds(value):
        raise MeshError.at(name, f" = {value!r}: expected {expected}")


class StatedSetup(Specimen):
    """A specimen whose supports, drives and gauges are keys of a scene."""

    supports: Any
    drive: Any
    drives_: Any
    gauge_minus: Any
    gauge_plus: Any
    gauges_: Any

    def read_setup(self) -> None:
        """What the keys say in place of what a scene gives; MeshError naming a key."""
        if not isinstance(self.supports, list) or not self.supports:
            raise MeshError.at("supports", f" = {self.supports!r}: expected a list of {{at = ..., direction = [x, y]}}")
        if (self.gauge_minus is None) != (self.gauge_plus is None):
            raise MeshError.at("gauge_minus", ", gauge_plus: expected both or none")
        ends = {name: getattr(self, name) for name in ("gauge_minus", "gauge_plus")}
        for name, value in {
            "supports": [support_of(entry) for entry in self.supports],
            "drives_": drives_of(self.drive, self.drives_),
            "gauges_": gauges_of(self.gauges_),
            **{name: None if at is None else location(name, at) for name, at in ends.items()},
        }.items():
            object.__setattr__(self, name, value)

    def held(self, *, half: bool = False) -> list[Support]:
        """As the key `supports` says."""
        return list(self.supports)

    def drives(self, *, half: bool = False) -> Mapping[str, Drive]:
        """As the key `drives` or `drive` says."""
        return dict(self.drives_)
