"""Extremes: each ends in the way that is named, with its history on disk; and what the corrected contact keeps and gains."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from cohesive import Result
from examples import corrected_contact, extremes

#: maps whose runs take seconds even at their ends
SLOW = (
    "steps over", "crack size", "closed loop", "body in pieces", "plane strain, nu",
    "sheared from zero", "smoothing c_zn",
)  # fmt: skip


@pytest.fixture(
    scope="module",
    params=[pytest.param("quick maps", marks=pytest.mark.long), pytest.param("all maps", marks=pytest.mark.slow)],
)
def ends(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> dict[tuple[str, str, str], extremes.Outcome]:
    """The first and last value of every map."""
    folder = tmp_path_factory.mktemp("meshes")
    left_out = SLOW if request.param == "quick maps" else ()
    cases = [case for case in extremes.cases(folder, thorough=False) if not any(name in case.map for name in left_out)]
    return {(case.map, case.row, case.value): extremes.outcome(case) for case in cases}


def test_extremes_converge_or_say_why(ends: dict[tuple[str, str, str], extremes.Outcome]) -> None:
    """`outcome` itself checks that every history is on disk, complete and finite, and lets no other exception pass."""
    for (name, row, value), end in ends.items():
        if end.status in ("failed", "refused", "led on"):
            assert end.reason, (name, row, value)
    failed = {key for key, end in ends.items() if end.status == "failed"}
    assert not any("corrected" in row for _, row, _ in failed)  # no contact of that form has ever stopped a run
    # traps of the printed form: a band in plane strain, and one of .01 mm under the load
    assert all(row == "smeared" and ("strain" in name or value == "0.01") for name, row, value in failed)
    refused = {key for key, end in ends.items() if end.status == "refused"}
    assert {(name, value) for name, _, value in refused} == {
        ("width of the crack plane (mm)", "60"), ("nodes moved at random, part of an element", "0.6"),
    }  # fmt: skip


def test_what_is_read_off_the_extremes(ends: dict[tuple[str, str, str], extremes.Outcome]) -> None:
    at = {key: end.text for key, end in ends.items()}
    units = [float(text) for (name, _, _), text in at.items() if name.startswith("units")]
    assert len(units) == 8
    assert max(units) < 1e-9  # units change the rounding only
    drifts = [float(text) for (name, _, _), text in at.items() if "drift" in name]
    assert max(drifts) < 1e-6  # the tolerance of the steps is 1e-4, and they converge quadratically
    back = [end for (name, _, value), end in ends.items() if name.startswith("bar") and value == "0.1"]
    assert all(end.status == "led on" and "goes back from" in end.reason for end in back)


@pytest.mark.long
def test_a_named_failure_keeps_its_history(tmp_path: Path) -> None:
    case = next(case for case in extremes.cases(tmp_path, thorough=False) if case.map.startswith("bar"))
    stages = [{"control": "load", "to": 1e5, "steps": 3}]
    end = extremes.outcome(extremes.Case("load", "discrete", "1e5", case.scene.with_(stage=stages), extremes.iterations))
    assert end.status == "failed"
    assert end.reason.startswith("stage 1: the step from load = ")
    assert end.steps >= 1


def test_another_exception_is_passed_on(tmp_path: Path) -> None:
    def broken(result: Result) -> str:
        raise ZeroDivisionError

    case = next(case for case in extremes.cases(tmp_path, thorough=False) if case.map.startswith("opening in Zm"))
    with pytest.raises(ZeroDivisionError):
        extremes.outcome(replace(case, read=broken))


@pytest.mark.long
def test_corrected_contact(tmp_path: Path) -> None:
    numbers = corrected_contact.main(size=8.0, plot=tmp_path / "corrected.png")
    for width in corrected_contact.WIDTHS:
        assert numbers[f"potential, w = {width:g}: stiffness"] < 1.0 < numbers[f"printed, w = {width:g}: stiffness"]
        # the inelastic opening is that of the asperities, whatever the width; 1 % is what damage's own stiffness adds
        assert numbers[f"potential, w = {width:g}: µm at -3 MPa"] == pytest.approx(2.85, rel=0.01)
    assert abs(numbers["potential: loop"]) < 1e-4 < 0.3 < abs(numbers["printed: loop"])
    for name in ("reinhardt-cyclic", "jacobsen-mixed-mode"):
        for what in ("peak", "dissipated"):
            printed, corrected = (numbers[f"{name}, {form}: {what}"] for form in corrected_contact.FORMS)
            assert corrected == pytest.approx(printed, rel=1e-3)
    shear = [numbers[f"jacobsen-mixed-mode, {form}: shear"] for form in corrected_contact.FORMS]
    assert shear[1] == pytest.approx(shear[0], rel=0.01)
    assert (tmp_path / "corrected.png").stat().st_size > 1e4
