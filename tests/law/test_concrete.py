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
    ],
)  # fmt: skip
def test_a_wrong_parameter_is_named(change: dict[str, Any]) -> None:
    (name,) = change
    with pytest.raises(ValueError, match=f"^{name} = .*expected"):
        Concrete(**{"E": 35e3, "nu": 0.2, "ft": 3.0, "Gf": 0.1, **change})


def test_an_unknown_preset_is_named() -> None:
    with pytest.raises(ValueError, match=r"'granite'.*jacobsen"):
        Concrete.preset("granite")
