"""Material parameters."""

import math
from typing import Any

import numpy as np
import pytest

from cohesive import Concrete, CrackPlane
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
        {"u_phi0": -1e-9}, {"u_phi0": -100.0}, {"unusual": 1}, {"c_zn": 3.0}, {"c_zn": 1.0},
    ],
)  # fmt: skip
def test_a_wrong_parameter_is_named(change: dict[str, Any]) -> None:
    (name,) = change
    with pytest.raises(ValueError, match=f"^{name} = .*expected"):
        Concrete(**{"E": 35e3, "nu": 0.2, "ft": 3.0, "Gf": 0.1, **change})


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize(("c_zn", "c_lm"), [(1.0, 3.0), (3.0, 3.0), (5.0, 7.0), (6.9, 7.0), (9.0, 9.5)])
def test_a_smoothing_that_the_cap_would_hide_is_refused(preset: str, c_zn: float, c_lm: float) -> None:
    with pytest.raises(ValueError, match=r"^c_zn = .*expected c_zn above c_lm, or onset_cap = false$"):
        Concrete.preset(preset, c_zn=c_zn, c_lm=c_lm)
    CrackPlane(Concrete.preset(preset, c_zn=c_zn, c_lm=c_lm, onset_cap=False))


@pytest.mark.parametrize("changes", [{"c_zn": 3.3}, {"c_zn": 5.0}, {"c_lm": 7.0}, {"c_lm": 7.0, "c_zn": 7.5}])
def test_a_smoothing_that_is_taken_acts(changes: dict[str, float]) -> None:
    m = Concrete.preset("walraven", **changes)
    Z = np.array([0.99 * m.Zm * (1.0 if "c_lm" in changes else 1.2)])
    reach, other = (CrackPlane(each).contact_reach(Z) for each in (m, Concrete.preset("walraven", **{**changes, "r_z": 0.0})))
    assert reach > other


@pytest.mark.parametrize(
    "change",
    [
        {"E": 36.0}, {"E": 36e9}, {"E": 36e6}, {"ft": 3000.0}, {"ft": 3e6}, {"ft": 33.0}, {"ft": 0.003}, {"Gf": 70.0},
        {"Gf": 40.0}, {"Gf": 20.0}, {"Gf": 7e-5}, {"density": 2.4}, {"density": 2.4e-9}, {"fc": 30e6}, {"fc": 0.03},
    ],
)  # fmt: skip
def test_numbers_in_other_units_are_asked_about(change: dict[str, float]) -> None:
    (name,) = change
    plain = {"E": 36e3, "nu": 0.2, "ft": 3.0, "Gf": 0.1, **change}
    with pytest.raises(ValueError, match=rf"^{name} = .*is it in .*add unusual = true"):
        Concrete(**plain)
    assert getattr(Concrete(**plain, unusual=True), name) == change[name]


@pytest.mark.parametrize(
    ("E", "ft", "Gf"),
    [
        (1.5e3, 0.1, 0.005),  # aerated concrete
        (12e3, 1.0, 0.01),  # mortar, cement paste
        (25e3, 1.6, 0.12), (45e3, 5.0, 0.2),  # the ends of Model Code 2010
        (60e3, 12.0, 25.0), (80e3, 28.0, 30.0),  # fibre concrete of ultra-high performance, slurry-infiltrated fibres
        (33e3, 3.0, 10.0),  # much fibre
    ],
)  # fmt: skip
def test_concretes_of_the_literature_are_taken(E: float, ft: float, Gf: float) -> None:
    assert Concrete(E, 0.2, ft, Gf).Gf == Gf


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
