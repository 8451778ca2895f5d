"""Material parameters."""

import math
from typing import Any

import pytest

from cohesive import Concrete
from cohesive.law.concrete import PRESETS


def test_derived_values() -> None:
    concrete = Concrete(37000.0, 0.2, 3.6, 0.07)  # positional, as in the documentation
    assert concrete.G == pytest.approx(37000.0 / 2.4)
    assert concrete.Zm == pytest.approx(5 * 0.07 / 3.6)
    assert concrete.characteristic_length == pytest.approx(37000.0 * 0.07 / 3.6**2)


def test_table_1_gives_its_end_of_softening() -> None:
    assert Concrete.preset("crack-plane").Zm == pytest.approx(0.2)  # the table prints Zm, not Gf


@pytest.mark.parametrize("name", PRESETS)
def test_presets_are_valid_and_can_be_changed(name: str) -> None:
    assert Concrete.preset(name, c_zn=50.0).c_zn == 50.0


@pytest.mark.parametrize(
    "change",
    [
        {"E": 0.0}, {"E": math.nan}, {"nu": 0.5}, {"nu": -0.1}, {"ft": -1.0}, {"Gf": 0.0}, {"Gf": math.inf}, {"Gf": "much"},
        {"h": 0.0}, {"m_g": 0.0}, {"mu_sigma": 1.25}, {"p": (0.6, 0.3, 0.2)}, {"p": (1.2, -0.3, 0.1)}, {"c": (0.01, 0.05)},
        {"c": (0.0, 0.1, 1.0)}, {"c": 3.0}, {"r_z": -0.1}, {"onset_cap": 1}, {"u_phi0": math.nan}, {"E": True},
        {"Zm": -0.1}, {"Zm": math.nan}, {"h": None},
    ],
)  # fmt: skip
def test_a_wrong_parameter_is_named(change: dict[str, Any]) -> None:
    (name,) = change
    with pytest.raises(ValueError, match=f"^{name} = .*expected"):
        Concrete(**{"E": 35e3, "nu": 0.2, "ft": 3.0, "Gf": 0.1, **change})


def test_an_unknown_preset_is_named() -> None:
    with pytest.raises(ValueError, match=r"'granite'.*jacobsen"):
        Concrete.preset("granite")


#: Tables 1 and 3 of the paper: E, nu, ft, Gf, m_g, h
PRINTED = {
    "crack-plane": (40000.0, 0.2, 3.0, 0.12, 0.425, 56.0),
    "sandwich-panel": (40000.0, 0.2, 3.0, 0.12, 0.3, 60.0),
    "reinhardt": (35000.0, 0.2, 3.2, 0.12, 0.3, 60.0),
    "jacobsen": (41000.0, 0.2, 3.0, 0.08, 0.18, 20.0),
    "walraven": (25000.0, 0.2, 2.5, 0.10, 0.28, 60.0),
}


@pytest.mark.parametrize("name", PRESETS)
def test_presets_are_those_that_are_printed(name: str) -> None:
    m = Concrete.preset(name)
    assert (m.E, m.nu, m.ft, m.Gf, m.m_g, m.h) == PRINTED[name]
    usual = name != "jacobsen"
    assert m.c == ((0.01, 0.05, 2.0) if usual else (0.01, 0.06, 0.3))
    assert m.p == ((0.6, 0.3, 0.1) if usual else (0.2, 0.4, 0.4))
