"""What a user gives as softening, and what a concrete makes of it: Zm, first branch, strength, messages, pickles, figures."""

from __future__ import annotations

import pickle
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from cohesive import Concrete, CrackPlane
from cohesive.law.concrete import PRESETS, with_preset
from cohesive.law.softening import SOFTENING, Exponential, register_softening
from cohesive.law.softening_branches import first_branch
from cohesive.law.softening_choice import softening_data
from cohesive.studies.law_responses import save_softening_figure, softening_curves
from tests.law.test_softening import FIBRES, FT, GF, NU, Cosine, E, case, concrete, normal, openings

Array = NDArray[np.float64]


def test_zm_follows_unless_it_is_given() -> None:
    m = Concrete(E, NU, FT, GF)
    assert m.Zm == 5.0 * GF / FT and isinstance(m.Zm, float)
    assert replace(m, Gf=2 * GF).Zm == pytest.approx(2 * m.Zm)
    assert replace(replace(m, c1=4.0), ft=2.0).Zm == pytest.approx(4.0 * GF / 2.0)
    fixed = replace(m, Zm=0.3)
    assert fixed.Zm == replace(fixed, Gf=2 * GF).Zm == 0.3
    assert replace(m, Zm=float(m.Zm), Gf=2 * GF).Zm == m.Zm  # a number made of it is a given one
    assert replace(fixed, Zm=None).Zm == m.Zm
    assert Concrete(E, NU, FT, GF, Zm=m.Zm) == m and hash(Concrete(E, NU, FT, GF)) == hash(m)
    for softening in ("hordijk", {"kink": [0.3, 0.2]}):
        assert concrete(softening).Zm == m.Zm
    # it scales the contact and leaves the curve alone
    u, Z = normal(np.array([0.01, 0.05])), np.zeros(2)
    np.testing.assert_array_equal(CrackPlane(m, 2.0).traction(u, Z)[0], CrackPlane(fixed, 2.0).traction(u, Z)[0])
    shear = np.array([[0.05, 0.1]])
    assert abs(np.diff([CrackPlane(x, 2.0).traction(shear, Z[:1])[0] for x in (m, fixed)], axis=0)).max() > 0.01


def test_asperities_of_a_fibre_concrete_are_those_of_its_matrix() -> None:
    m = concrete({"points": FIBRES})
    assert m.Gf / m.ft * m.c1 > 6.0  # mm
    assert m.Zm == pytest.approx(5.0 * 0.05 * 3.0 / 2.2)  # the first branch reaches zero at .068 mm
    assert concrete({"points": [[0, FT], [0.75 * GF / FT, FT / 4], [5 * GF / FT, 0]]}).Zm == pytest.approx(5 * GF / FT)
    assert concrete(Exponential(FT, GF)).Zm == pytest.approx(5 * GF / FT)
    flat = {"points": [[0, 3], [0.02, 3], [0.1, 0.5], [5, 0.5], [6, 0]]}
    assert concrete(flat).Zm == pytest.approx(5.0 * 0.12)
    rises = {"points": [[0, 2], [0.5, 3], [5, 0]]}
    with pytest.raises(ValueError, match="Zm is missing: the softening curve rises above its first stress"):
        concrete(rises)
    assert concrete(rises, Zm=0.2).Zm == 0.2


def test_work_of_the_first_branch() -> None:
    for name in ("exponential", "linear", "hordijk"):
        assert concrete(name).first_branch_work == pytest.approx(GF, rel=1e-12)
    assert concrete("wittmann").first_branch_work == pytest.approx(0.75 * 0.625 * GF)
    assert concrete({"points": FIBRES}).first_branch_work == pytest.approx(0.05 * 1.9)
    assert concrete(Cosine()).first_branch_work == pytest.approx(0.15 * FT)
    # points that trace a smooth curve have no kink
    w = np.linspace(0.0, 1.0, 30)
    smooth = concrete("hordijk").curve
    traced = [[float(x), float(y)] for x, y in zip(w * smooth.end, smooth.stress(w * smooth.end), strict=True)]
    assert concrete({"points": traced}).first_branch_work == pytest.approx(GF, rel=0.01)

    class Valley(Cosine):
        """Falls to a minimum at a quarter of its end, and rises again to fall."""

        def stress(self, w: Array) -> Array:
            return super().stress(w) * (1.0 - 0.9 * np.sin(2 * np.pi * np.minimum(w / self.end, 1.0)) ** 2)

        def slope(self, w: Array) -> Array:
            h = 1e-7
            inside = (self.stress(w + h) - self.stress(np.maximum(w - h, 0.0))) / (w + h - np.maximum(w - h, 0.0))
            return np.where(w < self.end, inside, 0.0)

    valley = Valley()
    assert 0.2 * valley.end < first_branch(valley) < 0.3 * valley.end


def test_points_fix_strength_and_energy() -> None:
    points = {"points": [[0, 3.0], [0.1, 0.0]]}
    m = Concrete(E, NU, softening=points)
    assert (m.ft, m.Gf) == (3.0, pytest.approx(0.15))
    assert Concrete(E, NU, 3.0, 0.15, softening=points) == m
    with pytest.raises(ValueError, match=r"^ft = 3.1: the softening curve has 3; expected that, or no ft"):
        Concrete(E, NU, 3.1, softening=points)
    with pytest.raises(ValueError, match=r"^Gf = 0.2: the softening curve has 0.15"):
        replace(m, Gf=0.2)
    assert replace(m, softening={"points": [[0, 2.0], [0.1, 0.0]]}).ft == 2.0
    assert replace(m, softening="hordijk").Gf == pytest.approx(0.15)
    assert Concrete.preset("reinhardt", softening=points).ft == 3.0
    assert with_preset("reinhardt", {"softening": "linear"})["ft"] == PRESETS["reinhardt"]["ft"]
    with pytest.raises(ValueError, match=r"^ft is missing"):
        Concrete(E, NU)


@case
def test_pickled_and_replaced(softening: Any) -> None:
    m = concrete(softening)
    again = pickle.loads(pickle.dumps(m))
    w = openings(m, 50)
    np.testing.assert_array_equal(again.curve.stress(w), m.curve.stress(w))
    assert (again.ft, again.Gf, again.Zm, hash(again)) == (m.ft, m.Gf, m.Zm, hash(m))
    assert replace(again, c_zn=5.0).Zm == m.Zm
    assert replace(m) == m


def test_the_given_dict_is_not_shared() -> None:
    given = {"points": [[0.0, 3.0], [0.1, 0.0]]}
    m = concrete(given)
    given["points"][0][1] = 99.0
    assert m.softening == {"points": [[0.0, 3.0], [0.1, 0.0]]}


def test_registration() -> None:
    assert next(iter(SOFTENING)) == "exponential"
    with pytest.raises(ValueError, match=r"there is a softening curve of that name"):
        register_softening("linear")(Exponential)
    with pytest.raises(TypeError):
        SOFTENING["mine"] = Exponential  # type: ignore[index]


def test_data_of_a_scene() -> None:
    assert softening_data("hordijk") == "hordijk"
    assert softening_data({"kink": (0.5, 0.2)}) == {"kink": [0.5, 0.2]}
    with pytest.raises(ValueError, match="an object that is not registered runs, but its scene cannot be saved"):
        softening_data(Cosine())


class Broken(Cosine):
    """Its area is not what its work says at the end of the curve that it is registered as."""

    def work(self, w: Array) -> Array:
        return np.full_like(w, np.nan)


@pytest.mark.parametrize(
    ("softening", "message"),
    [
        ("hordjik", r"softening = 'hordjik': expected one of exponential, linear"),
        (3.0, r"softening = 3.0: expected one of"),
        (Cosine, r"softening = <class .*: expected one of"),
        ({"kink": [0.5, 0.2], "points": []}, r"expected one of"),
        ({"kink": [0.5]}, r"softening.kink = \[0.5\]: expected \[x, y\]"),
        ({"kink": [1.5, 0.5]}, r"x \(1 \+ y\) < 2"),
        ({"points": 3}, r"softening.points = 3: expected at least two pairs"),
        ({"points": [[0, 3], [0.1]]}, r"expected at least two pairs"),
        ({"points": [[0, 3], [0.1, "a"]]}, r"expected at least two pairs"),
        ({"points": [[0.1, 3], [0.2, 0]]}, r"begins with \[0.1, 3.0\]; expected w = 0"),
        ({"points": [[0, 3], [0.2, 1], [0.2, 0]]}, r"\[0.2, 0.0\] follows \[0.2, 1.0\]; expected w to grow"),
        ({"points": [[0, 3], [0.1, -1], [0.2, 0]]}, r"\[0.1, -1.0\]; expected a stress above 0"),
        ({"points": [[0, 3], [0.1, 1]]}, r"ends with \[0.1, 1.0\]; expected a last point with stress 0"),
        (Broken(), r"softening: work\(end\) = nan: expected a finite number above 0"),
    ],
)
def test_messages(softening: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        concrete(softening)


def test_a_registered_curve_of_another_strength_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    from cohesive.law import softening_choice

    monkeypatch.setattr(softening_choice, "SOFTENING", {"mine": lambda ft, Gf: Cosine(2 * ft)})
    with pytest.raises(ValueError, match=r"softening = 'mine': stress\(0\) = 6.4; expected 3.2"):
        concrete("mine")


def test_a_rise_limits_the_width() -> None:
    """slope (Zt + w) < stress at .05 mm: Zt up to .6 micrometres, which is a width of 7 mm."""
    steep = {"points": [[0, 3], [0.05, 0.8], [0.1, 1.59], [4, 0]]}
    m = concrete(steep)
    rise = m.steepest_rise
    assert rise is not None and rise.w == 0.05 and rise.largest_Zt == pytest.approx(0.8 / 15.8 - 0.05)
    widest = rise.largest_Zt * E / 3.0
    CrackPlane(m, 0.99 * widest)
    for width in (1.01 * widest, np.array([0.1, 1.01 * widest])):
        with pytest.raises(ValueError, match=r"softening: at w = 0.05 mm, 0.8 MPa, .* expected a width below 7.38 mm"):
            CrackPlane(m, width)
    with pytest.raises(ValueError, match=r"expected a width below 0\.\d+ mm"):
        CrackPlane(concrete({"points": [[0, 3], [0.05, 0.8], [0.1, 1.5993], [4, 0]]}), 2.0)
    with pytest.raises(ValueError, match="expected a flatter rise"):
        CrackPlane(concrete({"points": [[0, 3], [0.05, 0.8], [0.1, 1.7], [4, 0]]}), 0.1)


def test_curves_side_by_side(tmp_path: Path) -> None:
    m = Concrete.preset("reinhardt")
    curves = softening_curves(m, ["exponential", "wittmann", {"kink": [0.5, 0.2]}, {"points": FIBRES}, Cosine()])
    assert list(curves) == ["exponential", "wittmann", "kink at 0.5 Gf/ft, 0.2 ft", "4 points", "Cosine"]
    for name, curve in curves.items():
        assert curve[0, 0] == 0 and (np.diff(curve[:, 0]) > 0).all()
        assert curve[-1, 1] <= (0.01 if name == "exponential" else 0.0)
    assert curves["4 points"][0, 1] == 3.0 and curves["wittmann"][0, 1] == m.ft
    assert list(softening_curves(m)) == list(SOFTENING)
    save_softening_figure(m, tmp_path / "softening.png")
    assert (tmp_path / "softening.png").stat().st_size > 1e4


class Doubtful:
    """A line whose work, slope or stress does not fit."""

    end = 0.1

    def __init__(self, what: str) -> None:
        self.what = what

    def stress(self, w: Array) -> Array:
        bump = 8.0 * np.sin(2 * np.pi * w / self.end) * (w < self.end) if self.what == "stress" else 0.0
        return np.maximum(3.0 * (1 - w / self.end), 0.0) + bump

    def slope(self, w: Array) -> Array:
        bump = 8.0 * 2 * np.pi / self.end * np.cos(2 * np.pi * w / self.end) if self.what == "stress" else 0.0
        return np.where(w < self.end, (3.0 if self.what == "slope" else 1.0) * -30.0 + bump, 0.0)

    def work(self, w: Array) -> Array:
        w = np.minimum(w, self.end)
        bump = 8.0 * self.end / (2 * np.pi) * (1 - np.cos(2 * np.pi * w / self.end)) if self.what == "stress" else 0.0
        return (2.0 if self.what == "work" else 1.0) * 3.0 * w * (1 - w / (2 * self.end)) + bump


@pytest.mark.parametrize("what", ["work", "slope", "stress"])
def test_an_object_that_does_not_fit_together_is_refused(what: str) -> None:
    expected = {
        "work": r"work\(.*is not the area",
        "slope": r"stress\(.*is not what the slope",
        "stress": "expected at least 0",
    }
    assert Concrete(30e3, 0.2, softening=Doubtful("nothing")).Gf == pytest.approx(0.15)
    with pytest.raises(ValueError, match=expected[what]):
        Concrete(30e3, 0.2, softening=Doubtful(what))
