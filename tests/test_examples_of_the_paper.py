"""The studies of the paper's Examples 2 to 4 and of its sections 2 and 6.3, small."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from cohesive import Concrete, CrackPlane, Scene
from examples import (
    as_printed,
    closure_overshoot,
    contact_smoothing,
    growing_front,
    jacobsen,
    push_off,
    push_off_3d,
    reinhardt,
)
from examples.walraven import walraven


@pytest.mark.long
def test_reinhardt_reverses_at_the_lower_stress_and_meets_the_envelope(tmp_path: Path) -> None:
    numbers = reinhardt.main(size=5.0, turns=(0.03,), plot=tmp_path / "a.png")
    for model in ("discrete", "smeared"):
        assert abs(numbers[f"{model}: Gf of the envelope off"]) < 0.02  # the body's own energy has come back by then
        assert numbers[f"{model}: cuts"] == 0
    assert numbers["models apart"] < 0.02
    for model, name in reinhardt.CYCLIC:
        assert numbers[f"{model}, {name}: reversals"] == 1  # one for each turn
        assert (
            numbers[f"{model}, {name}: reversals off"] < 1.5e-3
        )  # events are found within 1e-3 of the stress before tolerance
        assert numbers[f"{model}, {name}: from the envelope"] < 0.01  # contact damages nothing
    discrete, smeared = (numbers[f"{model}, fixed: peak"] for model in ("discrete", "smeared"))
    assert 3.0 < discrete < 3.2  # at most ft, less for the stress that the slits concentrate
    assert smeared == pytest.approx(discrete, rel=0.01)  # one law in both
    # on the symmetric plate the even solution does not turn, so that its platens cannot matter
    assert numbers["discrete, hinged: area"] == pytest.approx(numbers["discrete, fixed: area"], rel=1e-5)
    for model in ("discrete", "smeared"):
        # a hinged plate has no moment, so that the crack opens from one side
        left, right = (numbers[f"{model}, hinged, kinked: {end} end"] for end in ("left", "right"))
        assert abs(left) < 0.05 * right
        assert numbers[f"{model}, hinged, kinked: area"] < 0.95 * numbers[f"{model}, fixed: area"]
    # the kink alone does nothing of the kind
    assert numbers["discrete, fixed, kinked: area"] == pytest.approx(numbers["discrete, fixed: area"], rel=0.01)
    assert (tmp_path / "a.png").stat().st_size > 1e4


@pytest.mark.long
def test_jacobsen_follows_the_law_on_its_own_path(tmp_path: Path) -> None:
    numbers = jacobsen.main(size=4.0, openings=(0.015, 0.04), plot=tmp_path / "a.png")
    for un0, peak in ((0.015, 1.34), (0.04, 0.49)):
        assert numbers[f"point, {un0:g}: w = h"] == pytest.approx(peak, abs=0.005)  # the value of the nominal path
        discrete, smeared = (numbers[f"{model}, {un0:g}: peak shear"] for model in ("discrete", "smeared"))
        assert smeared == pytest.approx(discrete, rel=0.01)  # one law in both
        # the ligament shears evenly: it is a point on the path of its mean jump
        assert discrete == pytest.approx(numbers[f"point, {un0:g}: the crack's path"], rel=0.01)
        # the plate gives back what the falling stress had stretched, so that the crack opens further than its platen
        assert numbers[f"discrete, {un0:g}: beyond nominal"] > 5e-4
        assert discrete < numbers[f"point, {un0:g}: w = interface"]
        for model in ("discrete", "smeared"):
            assert numbers[f"{model}, {un0:g}: hinged"] < 1e-6  # no moment at both ends, no shear force
    assert numbers["discrete, 0.015: peak shear"] > numbers["discrete, 0.04: peak shear"]  # less contact in a wider crack
    assert (tmp_path / "a.png").stat().st_size > 1e4


@pytest.mark.long
def test_push_off_restraint_gives_stress_below_the_fit(tmp_path: Path) -> None:
    numbers = push_off.main(size=30.0, restraints=(0.5e5, 2e5), steps=20, plot=tmp_path / "a.png")
    soft, stiff = (
        {k.split(": ")[1]: v for k, v in numbers.items() if k.startswith(f"discrete, {r}:")} for r in (50000, 200000)
    )
    assert stiff["shear"] > soft["shear"] > 0  # pressure from the bars holds the faces together
    assert stiff["normal"] < soft["normal"] < 0
    assert stiff["opening"] < soft["opening"]
    for k in (50000, 200000):
        for d in (0.2, 1.0, 1.8):
            assert 0.15 < numbers[f"discrete, {k}: ratio at {d:g}"] < 0.65  # the gap that the study reports
        smeared, discrete = (numbers[f"{model}, {k}: shear"] for model in ("smeared", "discrete"))
        assert smeared == pytest.approx(discrete, rel=0.02)  # one law in both
    shear, pressure = walraven(0.5, 1.0, 30.0)
    # the formula by hand: 0.5^-0.8 = 1.7411, 0.5^-0.707 = 1.6323; 0.5^-0.63 = 1.5476, 0.5^-0.552 = 1.4661
    assert shear == pytest.approx(-1.0 + 1.8 * 1.7411 + (0.234 * 1.6323 - 0.2) * 30, abs=2e-3)
    assert pressure == pytest.approx(-1.5 + 1.35 * 1.5476 + (0.191 * 1.4661 - 0.15) * 30, abs=2e-3)
    assert (tmp_path / "a.png").stat().st_size > 1e4


@pytest.mark.long
def test_push_off_in_3d_is_that_in_2d(tmp_path: Path) -> None:
    numbers = push_off_3d.main(size=40.0, steps=10, increments=10, plot=tmp_path / "a.png")
    assert numbers["discrete, plane: apart"] < 1e-3  # what Poisson's ratio does through the thickness: 1e-4
    assert numbers["smeared: apart"] < 0.02  # one law in both
    for model in ("discrete", "smeared"):
        # the blocks are stiff beside the crack, which shears as one: a few per cent at the ends of the plane
        assert numbers[f"{model}: uneven along"] < 0.05
        assert numbers[f"{model}: uneven across"] < 1e-3
        assert numbers[f"{model}: shear"] == pytest.approx(2.74, rel=0.01)  # on finer meshes
        counts = [numbers[f"{model}, c_zn = {c}: iterations"] for c in (50, 9, 5)]
        assert max(counts) - min(counts) <= 3  # what the study reports: no order
        for c in (50, 9, 5):
            assert numbers[f"{model}, c_zn = {c}: tail"] < 3.0  # consistent tangent: quadratic
    assert [numbers[f"paper, c_zn = {c}: iterations"] for c in (50, 9, 5)] == [46, 23, 23]  # its Table 4, counted by hand
    assert numbers["paper, c_zn = 9: tail"] > 100  # 3.3e-4 to 1.64e-5 in increment 12 alone: 151
    assert (tmp_path / "a.png").stat().st_size > 1e4


@pytest.mark.long
def test_closure_overshoot_is_the_papers_and_the_line_search_prevents_it(tmp_path: Path) -> None:
    numbers = closure_overshoot.main(plot=tmp_path / "a.png")
    # the three numbers of section 2
    assert numbers["first iterate"] == pytest.approx(-0.855, abs=1e-3)
    assert numbers["strain"] == pytest.approx(-0.171, abs=5e-4)
    assert numbers["stress"] == pytest.approx(-5130.0, rel=1e-3)
    for c in (5, 9, 50):
        without, searched = (f"c_zn = {c}, {word} line search" for word in ("without", "with"))
        # no contact at 0.1 mm: the first tangent is the secant, whatever follows
        assert numbers[f"{without}: lowest opening"] == pytest.approx(numbers["first iterate"], rel=1e-9)
        assert numbers[f"{without}: crossings"] >= 2  # alternates between closed and open
        assert numbers[f"{searched}: crossings"] == 0
        assert numbers[f"{searched}: lowest stress"] > -2.0  # the residual may not rise above its first value of 0.56 MPa
        assert numbers[f"{searched}: iterations"] < numbers[f"{without}: iterations"]
        assert numbers[f"{searched}: solution"] == pytest.approx(numbers[f"{without}: solution"], rel=1e-6)  # one root
    # two straight lines: the second step is exact
    assert numbers["abrupt, without line search: iterations"] == 2
    assert (tmp_path / "a.png").stat().st_size > 1e4


@pytest.mark.long
def test_contact_smoothing_does_not_change_the_iterations(tmp_path: Path) -> None:
    numbers = contact_smoothing.main(size=30.0, steps=(20,), plot=tmp_path / "a.png")
    # a softer closure meets the faces earlier
    assert numbers["c_zn = 5: no stress at"] > numbers["c_zn = 9: no stress at"] > numbers["c_zn = 50: no stress at"] > 0
    cases = {key.rsplit(", ", 2)[0] for key in numbers if "c_zn" in key and ", 20," in key}
    assert {"block, discrete", "block, smeared"} < cases and len(cases) == 8
    for case in cases:
        counts = [numbers[f"{case}, 20, c_zn = {c}"] for c in (50, 9, 5)]
        assert max(counts) - min(counts) <= 3  # what the study reports: no order
        assert numbers[f"{case}, 20: r(n+1) / r(n)^2"] < 3.0  # consistent tangent: quadratic
    assert (tmp_path / "a.png").stat().st_size > 1e4


def test_readings_of_the_print_at_a_point(tmp_path: Path) -> None:
    numbers = as_printed.main(models=(), plot=tmp_path / "a.png")
    for reading in ("defaults", "c_lm = 7", "0.018 mm"):
        for width in ("h", "band", "interface"):
            for example in (2, 3):
                # with the cap contact is exactly zero in mode I: the exponential holds all of the energy
                assert numbers[f"{reading}, {width}, Example {example}: area"] == pytest.approx(1.0, abs=2e-3)
                assert numbers[f"{reading}, {width}, Example {example}: least"] > 0 - 1e-12
    assert numbers["0.018 mm, no cap, h, Example 3: area"] == pytest.approx(0.44, abs=0.01)  # crack-plane law, section 5
    assert numbers["no cap, interface, Example 2: least"] < -1.0  # a narrow plane is eaten by contact
    for reading, values in (("defaults", (1.34, 0.88, 0.49)), ("c_lm = 7", (0.25, 0.18, 0.12))):
        for un0, value in zip((0.015, 0.025, 0.04), values, strict=True):
            assert numbers[f"{reading}, h, Example 3: shear {un0:g}"] == pytest.approx(value, abs=0.006)  # both of section 5
    assert (tmp_path / "a.png").stat().st_size > 1e4


@pytest.mark.long
def test_readings_of_the_print_in_a_specimen() -> None:
    numbers = as_printed.main(size=8.0, models=(("discrete", "w = h"),), readings=("defaults", "c_lm = 7"))
    peak = {reading: numbers[f"Example 3, discrete, w = h, {reading}: shear"] for reading in ("defaults", "c_lm = 7")}
    assert peak["c_lm = 7"] < 0.3 * peak["defaults"]  # as at the point
    for reading in peak:
        name = f"Example 2, discrete, w = h, {reading}"
        assert not numbers[f"{name}: stopped"]
        assert numbers[f"{name}: least"] == pytest.approx(reinhardt.LOWER, rel=2e-3)  # where it turns


@pytest.mark.long
def test_a_run_that_stops_is_a_finding(capsys: pytest.CaptureFixture[str]) -> None:
    """Pulled by a load beyond the strength, 9 kN on the ligament: what came before is kept and the reason printed."""
    scene = Scene.load("jacobsen-mixed-mode").with_(**{"mesh.crack_size": 8.0, "output.frames": 0})
    result, stopped = as_printed.attempt(scene.with_(stage=[{"control": "load", "to": 12e3, "steps": 6}]), "discrete")
    assert "stage 1" in stopped
    numbers = as_printed.specimen_numbers("plate", "defaults", result, stopped)
    assert numbers["plate, defaults: stopped"] == 1.0
    assert 0.5 * scene.material.ft < numbers["plate, defaults: peak"] <= scene.material.ft  # up to the strength
    assert "stopped: stage 1" in capsys.readouterr().out


def test_a_reading_in_millimetres_is_a_length() -> None:
    concrete = Concrete.preset("jacobsen")
    found = as_printed.changes("0.018 mm", concrete)
    law = CrackPlane(Concrete.preset("jacobsen", c_zn=1e9, onset_cap=False, **found))
    # without damage the smoothing length is 0.018 mm, and contact reaches c_lm times as far
    assert law.contact_reach(np.zeros(1))[0] == pytest.approx(3 * 0.018, rel=1e-5)


@pytest.mark.long
def test_a_penny_grows_round_and_below_the_stress_of_a_brittle_body(tmp_path: Path) -> None:
    numbers = growing_front.main(
        size=180.0, steps=20, energies=(0.105, 0.15), beam_size=5.0, layers=4, plot=tmp_path / "a.png"
    )
    brittle, tough = (f"E Gf / ft^2 = {part} a, block of 8 a" for part in ("0.7", "1"))
    # two elements in E Gf / ft^2; the full size finds 0.87
    assert 0.82 < numbers[f"{brittle}: at 1.4 a"] < 1.0
    assert numbers[f"{tough}: at 1.2 a"] < numbers[f"{brittle}: at 1.2 a"] - 0.03  # a longer cohesive zone
    assert 0.0 < numbers["lost to the block"] < 0.05
    radii = [numbers[f"penny {i}: radius"] for i in range(5)]
    assert all(b > a for a, b in pairwise(radii)) and radii[-1] > 1.4 * growing_front.RADIUS
    assert all(numbers[f"penny {i}: spread"] < 1.0 for i in range(5))  # round within an element
    assert all(numbers[name] < 0.01 for name in numbers if name.endswith("balance"))  # as the steps are long
    assert numbers["beam at 0.03: edge ahead"] > 0.1  # a free face carries less: 0.6 mm on a fine mesh
    assert (tmp_path / "a.png").stat().st_size > 1e4
