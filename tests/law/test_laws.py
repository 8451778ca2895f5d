"""One suite over all registered laws: a new one is tested by being registered."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.integrate import trapezoid

from cohesive import Concrete, CrackPlane, Law, register_law
from cohesive.arrays import Array
from cohesive.law.registry import LAWS
from examples.coulomb import Coulomb
from examples.own_law import Bilinear
from examples.ppr import PPR
from tests.law import rules

CONCRETE = Concrete(E=30e3, nu=0.2, ft=3.0, Gf=0.1)


def built(name: str, components: int, **changes: object) -> Law:
    return LAWS[name]().built_for(Concrete(E=30e3, nu=0.2, ft=3.0, Gf=0.1, **changes), 0.2, components)  # type: ignore[arg-type]


@pytest.mark.parametrize("components", [2, 3])
@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("rule", rules.RULES)
def test_it_keeps_the_rules(name: str, rule: Callable[[Law], None], components: int) -> None:
    rule(built(name, components))


@pytest.mark.parametrize("rule", rules.RULES)
def test_so_does_the_contact_with_an_energy(rule: Callable[[Law], None]) -> None:
    rule(built("crack-plane", 2, contact="potential"))


@dataclass(frozen=True)
class Wrong(Bilinear):
    """Breaks one rule."""

    rule: str = ""

    def update(self, jump: Array, history: Array, frozen: bool = False) -> tuple[Array, Array, Array]:
        traction, tangent, new = super().update(jump, history, frozen and self.rule != "frozen")
        if self.rule == "tangent":
            tangent = 1.001 * tangent
        if self.rule == "purity":
            history[:] = new
        if self.rule == "rotation":
            traction[:, 1:] *= [1.0, 1.01][: jump.shape[1] - 1]
            tangent = tangent * np.array([1.0, 1.0, 1.01])[: jump.shape[1], None]
        if self.rule == "together":
            traction = traction * (1.0 + 1e-6 * len(jump))
        if self.rule == "zero":
            traction = traction + 1e-3
        if self.rule == "energy":
            traction[:, 1:] -= 20.0 * jump[:, :1]
            tangent = tangent.copy()
            tangent[:, 1:, 0] -= 20.0
        return traction, tangent, new


BREAKS = {
    "tangent": rules.tangents_are_derivatives,
    "purity": rules.updates_are_pure,
    "frozen": rules.frozen_tangents_are_those_of_unloading,
    "rotation": rules.axes_of_shear_mean_nothing,
    "together": rules.points_are_alone,
    "zero": rules.undamaged_planes_carry_nothing,
    "energy": rules.loops_make_energy_only_if_it_is_said,
}


@pytest.mark.parametrize("rule", BREAKS)
def test_a_law_that_breaks_a_rule_is_caught(rule: str) -> None:
    with pytest.raises(AssertionError):
        BREAKS[rule](Wrong(rule=rule).built_for(CONCRETE, 0.2, 3))


def test_a_name_is_given_once() -> None:
    assert isinstance(built("crack-plane", 2), CrackPlane)
    with pytest.raises(ValueError, match="CrackPlaneKeys has this name; expected another one"):
        register_law("crack-plane")(Bilinear)
    with pytest.raises(ValueError, match="no dataclass derived from Law"):
        register_law("no-law")(int)  # type: ignore[type-var]
    with pytest.raises(ValueError, match="expected the name"):
        register_law(Bilinear)  # type: ignore[arg-type]


def test_a_broken_point_rubs_around_a_loop() -> None:
    """Alfano and Sacco: sheared to and fro by D under constant compression a point loses 4 mu |s| (D - mu |s|/k)."""
    law = Coulomb().built_for(CONCRETE, 1.0)
    (k, kt), amplitude, opening = law.stiffness(2), 0.3, -0.01
    pressure, legs = law.mu * k * -opening, np.linspace(-1.0, 1.0, 401) * amplitude
    history = law.update(np.array([[1.0, 0.0]]), law.initial(1))[2]
    assert history[0, 0] == 1.0
    for _ in range(2):  # the first time around it comes from the middle
        before = history
        shears = np.concatenate([legs, legs[::-1]])
        tractions = []
        for s in shears:
            t, _, history = law.update(np.array([[opening, s]]), history)
            tractions.append(t[0, 1])
    expected = 4.0 * pressure * (amplitude - pressure / kt)
    assert trapezoid(tractions, shears) == pytest.approx(expected, rel=1e-3)
    heats = law.fields(np.array([[opening, 0.0]]), history - before)
    assert heats["friction_heat"][0] == pytest.approx(expected, rel=1e-3) and heats["damage_heat"][0] == 0.0
    assert law.update(np.array([[0.01, 0.5]]), history)[0][0].tolist() == [0.0, 0.0]


def test_the_energies_of_the_potential() -> None:
    """Opening alone takes Gn, sliding alone Gt."""
    law = PPR().built_for(CONCRETE, 1.0)
    for i, (energy, strength, end) in enumerate([(0.2, 4.0, law.modes[0].end), (0.4, 5.0, law.modes[1].end)]):
        jumps = np.zeros((20001, 2))
        jumps[:, i] = np.linspace(0.0, end, 20001)
        tractions = law.update(jumps, law.initial(len(jumps)))[0][:, i]
        assert trapezoid(tractions, jumps[:, i]) == pytest.approx(energy, rel=1e-5)
        assert tractions.max() == pytest.approx(strength, rel=1e-4)
