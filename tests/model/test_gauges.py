"""Gauges by name: what they measure, in whole and half, plane and solid, discrete and smeared; and the crack's lengths."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cohesive import Result, Scene, SceneError, run
from cohesive.model.build import build
from meshing import MeshError
from tests.builders import COARSE, as_file, assert_refused, grid

BEAM = Scene.load("notched-beam").with_(**COARSE | {"solver.tol": 1e-8, "mesh.crack_size": 1.0, "stage.0.steps": 12})
NAMES = ("cmod", "ctod", "deflection")


@pytest.fixture(scope="module")
def whole() -> Result:
    return run(BEAM)


def test_the_gauges_of_a_beam(whole: Result) -> None:
    h = whole.history
    assert tuple(h) == tuple(column.name for column in build(BEAM).columns)
    assert set(NAMES) < set(h)
    # both halves rotate about the end of the crack, so that all openings are in proportion to their distance from it
    row = -1
    depth = 25.0 * h["cmod"][row] / (h["cmod"][row] - h["ctod"][row])
    assert depth == pytest.approx(50.0, rel=0.05)  # the crack has not run through yet
    # and the deflection is theirs: half of the span times half of the rotation; the yoke's elastic motion is small
    assert h["deflection"][row] == pytest.approx(0.25 * 125.0 * h["cmod"][row] / depth, rel=0.03)
    assert h["opening"] == pytest.approx(h["cmod"], rel=0.03)


@pytest.mark.parametrize(
    "changes",
    [
        {"model.half": True},
        {"model.kind": "smeared"},
        {"model.kind": "smeared", "specimen.notch_width": 3.0},
        {"model.dimension": 3, "mesh.layers": 1, "mesh.crack_size": 2.0},
        {"model.dimension": 3, "mesh.layers": 1, "mesh.crack_size": 2.0, "model.kind": "smeared"},
    ],
    ids=["half", "smeared", "wide notch", "solid", "solid smeared"],
)
def test_they_measure_the_same_in_every_model(whole: Result, changes: dict[str, Any]) -> None:
    """Within 3 %: the models differ by 2 % in the deflection at a given opening, a wrong set by 100 %."""
    other = run(BEAM.with_(**changes | {"stage.0.steps": 4}))
    for name in NAMES:
        expected = np.interp(other.history["opening"], whole.history["opening"], whole.history[name])
        np.testing.assert_allclose(other.history[name], expected, rtol=0.03, atol=0.03 * expected.max())


def test_a_gauge_is_a_control_and_a_quantity() -> None:
    stages = [
        {"control": "ctod", "to": 0.02, "steps": 8, "until": {"deflection": 0.02}},
        {"control": "deflection", "to": 0.03, "steps": 2, "unload": {"cmod": 0.02}},
    ]
    h = run(BEAM.with_(stage=stages)).history
    first = h["stage"] == 1
    assert h["deflection"][first][-1] == pytest.approx(0.02, rel=2e-3)  # located within 0.1 %
    assert h["deflection"].max() == pytest.approx(0.03, rel=1e-6)
    assert h["cmod"][-1] == pytest.approx(0.02, rel=2e-3)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"stage.0.control": "cmot"}, r"stage.0.control = 'cmot': expected one of .*deflection, cmod, ctod.*mean 'cmod'"),
        ({"stage.0.until": {"ctot": 1.0}}, r"stage.0.until = .*expected a number for one of .*load_ratio.*mean 'ctod'"),
        ({"stage.0.unload": {"work": 1.0}}, r"stage.0.unload = .*expected a number for one of load, .*deflection, cmod, ctod"),
        ({"specimen.notch": 0.0, "stage.0.control": "ctod"}, r"stage.0.control = 'ctod': expected one of .*deflection, cmod"),
    ],
)
def test_names_are_those_that_the_specimen_has(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(SceneError, match=message) as caught:
        BEAM.with_(**changes)
    assert "\n" not in str(caught.value)


def test_gauges_on_a_mesh_of_ones_own(tmp_path: Path) -> None:
    mesh = grid(8, 6)
    mesh.points = mesh.points * 5.0 - np.array([20.0, 15.0])
    mesh.cells.append(mesh.cells[0])  # `as_file` leaves the last block out
    scene = as_file(tmp_path, mesh, np.eye(2), "grid.vtu", [[-20.0, 0.0], [20.0, 0.0]])
    gauges = {
        "left": {"plus": [-20.0, 15.0], "minus": [-20.0, -15.0]},
        "jump": {"plus": [-20.0, 0.0], "minus": [-20.0, 0.0], "direction": [0.0, 2.0]},
        "back": {"plus": [-20.0, 0.0], "minus": [-20.0, 0.0], "direction": [0.0, -1.0]},
    }
    scene = scene.with_(**{"specimen.gauges": gauges, "stage": [{"control": "jump", "to": 0.05, "steps": 2}]})
    h = run(scene).history
    assert h["jump"][-1] == pytest.approx(0.05)
    np.testing.assert_allclose(h["left"], h["opening"], rtol=1e-12)
    np.testing.assert_allclose(h["back"], h["jump"], rtol=1e-12)  # parting is positive whichever way it is measured
    for changes, message in (
        ({"specimen.gauges": {"load": gauges["left"]}}, r"specimen.gauges: a gauge of this mesh is called 'load'"),
        (
            {"specimen.gauges": {"a b": gauges["left"]}},
            r"specimen.gauges: a gauge is called 'a b'; expected a name",
        ),
        ({"specimen.gauges": {"a": {"plus": [0.0, 0.0]}}}, r"specimen.gauges.a = .*: expected {plus = ..., minus = ...}"),
        ({"specimen.gauges": {"jump": {"plus": "x", "minus": "y"}}}, r"specimen.gauges.jump.plus = 'x': the mesh has no such"),
        ({"specimen.gauges": 3}, r"specimen.gauges = 3: expected {name = {plus"),
    ):
        with pytest.raises((SceneError, MeshError), match=message) as caught:
            run(scene.with_(**changes))
        assert "\n" not in str(caught.value)
    inside = {"plus": [0.0, 10.0], "minus": [0.0, 10.0], "direction": [0.0, 1.0]}
    assert_refused(scene.with_(**{"specimen.gauges": {"jump": inside}}), r"stage.0.control = 'jump': no crack parts")


@pytest.mark.parametrize("kind", ["discrete", "smeared"])
def test_the_lengths_of_the_crack(kind: str) -> None:
    h = run(BEAM.with_(**{"model.kind": kind, "stage.0.to": [0.001, 0.5], "stage.0.steps": 20})).history
    effective, cohesive = h["effective_length"][1:], h["cohesive_length"][1:]  # none without a load
    assert effective[0] == pytest.approx(25.0, abs=1.5)
    assert (np.diff(effective) > -1e-9).all() and 46.0 < effective[-1] < 50.0
    assert cohesive[0] < 6.0 and 20.0 < cohesive.max() <= 25.0
    assert cohesive[-1] < cohesive.max()  # its tail has become free of traction


def test_the_compliance_of_an_open_crack_is_that_of_the_handbook() -> None:
    """Tada, Paris and Irwin, The stress analysis of cracks handbook, 3rd ed. (2000), 2.16: three-point bending with span 4 D,
    CMOD = 24 P a / (E B D) V(a/D), good to 1 %. Linear elements add 2 % around the tip."""
    scene = BEAM.with_(
        **{"specimen.span": 200.0, "specimen.length": 240.0, "specimen.notch": 10.0, "interface.width": 0.01}
        | {"mesh.crack_size": 0.5, "mesh.far_size": 4.0, "stage.0.control": "cmod", "stage.0.to": 1e-4, "stage.0.steps": 1}
    )
    model = build(scene)
    curve = model.lengths.curve(model.problem)
    assert curve is not None
    for x, length in zip(*(values[1:] for values in curve), strict=True):
        a = 10.0 + length
        if not 14.0 < a < 40.0:  # the stiff element at the tip is a large part of a short crack and of a short ligament
            continue
        alpha = a / 50.0
        v = 0.76 - 2.28 * alpha + 3.87 * alpha**2 - 2.04 * alpha**3 + 0.66 / (1 - alpha) ** 2
        assert 1.0 / x**2 == pytest.approx(24.0 * a / (37000.0 * 50.0 * 50.0) * v, rel=0.03)


def test_a_slit_has_two_sides_if_cracks_may_form_everywhere() -> None:
    scene = Scene.load("compact-tension").with_(**{"model.kind": "smeared", "mesh.crack_size": 9.0})
    measures = build(scene.with_(**{"band.where": "everywhere"})).problem.measures
    assert {"opening", "cmod"} <= set(measures) and "ctod" not in measures  # at the tip there is one node
    assert measures["cmod"].max() == pytest.approx(1.0) and measures["cmod"].sum() == pytest.approx(0.0, abs=1e-12)
