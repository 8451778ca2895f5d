"""The measure in charge of a run, and where it stands: one quantity under one name."""

from __future__ import annotations

import csv
from pathlib import Path

import matplotlib
import pytest

from cohesive import Result, Scene, compare, run, sweep
from cohesive.figures.drawing import draw_curve, new_figure
from cohesive.scenes.scene import built_in

#: what each built-in scene is controlled and measured by
IN_CHARGE = {
    "cmod": ["en-14651", "four-point-beam", "jci-s-001", "petersson", "rilem-tc-50"],
    "driven": [
        "jacobsen-mixed-mode", "l-panel", "push-off", "push-off-3d", "sandwich-panel", "single-crack", "single-crack-3d",
    ],
    "opening": [
        "compact-tension", "nooru-mohamed-4a", "nooru-mohamed-4b", "notched-beam", "notched-beam-3d", "notched-tension",
        "reinhardt-cyclic", "wedge-splitting",
    ],
}  # fmt: skip
CASES = [(name, measure) for measure, names in IN_CHARGE.items() for name in names]


def short(name: str, **changes: object) -> Scene:
    """A built-in scene that takes three steps of its first stages on a mesh as coarse as may be."""
    scene = Scene.load(name)
    size = scene.crack_length / 4
    stages = [stage | {"steps": 3} for stage in scene.data["stage"] if "unload" not in stage] or [
        {key: value for key, value in scene.data["stage"][0].items() if key != "unload"} | {"steps": 3}
    ]
    for stage in stages:
        stage.pop("step", None)
    coarse = {"mesh.crack_size": size, "mesh.far_size": 3 * size, "output.frames": 0, "stage": stages}
    return scene.with_(**coarse, **changes)


def axes_of(result: Result) -> matplotlib.axes.Axes:
    axes = new_figure(6.0, 4.0).add_subplot()
    draw_curve(axes, result)
    return axes


def test_every_scene_is_here() -> None:
    assert sorted(name for name, _ in CASES) == built_in()


@pytest.mark.parametrize(("name", "measure"), CASES)
def test_the_peak_is_told_over_the_measure_in_charge(name: str, measure: str) -> None:
    result = run(short(name))
    peak, row = result.peak, result.peak_row
    assert (peak.measure, peak.load, peak.at) == (measure, result.peak_load, result.history[measure][row])
    where = "a driven motion of" if measure == "driven" else measure
    assert f"peak load: {peak.load:.5g} N at {where} {peak.at:.4g} mm" in result.summary().splitlines()
    assert f"{peak.load:.5g} N at {where} {peak.at:.4g} mm" in result._repr_html_()
    assert result.opening_at_peak == result.history["opening"][row]
    if not result.facts.has_platen:
        assert axes_of(result).get_xlabel() == f"{measure} (mm)"


@pytest.mark.parametrize(
    ("name", "changes", "measure"),
    [
        ("en-14651", {"stage.0.control": "deflection"}, "deflection"),
        ("en-14651", {"stage.0.control": "dissipation", "stage.0.to": 20.0}, "cmod"),  # which is no motion
        ("notched-beam", {"stage.0.control": "cmod"}, "opening"),  # over which it was measured
        ("notched-beam", {"stage.0.control": "cmod", "reference.against": "deflection"}, "deflection"),
        ("single-crack", {"stage.0.control": "load", "stage.0.to": 2000.0}, "opening"),
    ],
)
def test_what_is_in_charge(name: str, changes: dict[str, object], measure: str) -> None:
    result = run(short(name).with_(**changes))
    assert result.peak.measure == measure
    assert f" N at {measure} " in result.summary()


def test_beside_another_gauge_the_opening_is_called_the_mean_jump() -> None:
    beam = short("en-14651")
    asked = {"output.curve": ["opening", "load"]}
    assert axes_of(run(beam.with_(**asked))).get_xlabel() == "mean jump (mm)"
    assert axes_of(run(short("notched-beam").with_(**asked))).get_xlabel() == "opening (mm)"  # a gauge measures it
    assert axes_of(run(short("single-crack").with_(**asked))).get_xlabel() == "opening (mm)"  # there is no other


def test_the_title_of_a_deformed_body_names_it() -> None:
    result = run(short("en-14651"))
    axes = new_figure(6.4, 4.0).add_subplot()
    result.plot_deformed(axes, result.peak_row)
    assert f"N, cmod {result.peak.at:.3g} mm, displacements x" in axes.get_title()


def test_tables_and_pictures_of_several_runs_name_it(tmp_path: Path) -> None:
    beam = short("en-14651", **{"band.width": 5.0})
    both = compare(beam)
    assert both.table["cmod_at_peak"]["discrete"] == both.discrete.peak.at and "opening_at_peak" not in both.table
    axes = both.plot().axes
    assert axes[0].get_xlabel() == axes[1].get_xlabel() == "cmod (mm)"
    assert all(text.get_text().startswith(("cmod", "smeared")) for text in axes[2].get_legend().get_texts())
    assert "mm of cmod: energy and curve distance" in both.summary() and "opening" not in both.summary()

    swept = sweep(beam, {"material.Gf": [0.05, 0.1]}, workers=1)
    assert swept.table["cmod_at_peak"] == [each.result.peak.at for each in swept.runs if each.result is not None]
    assert "cmod_at_peak (mm)" in swept.summary() and "opening" not in swept.summary()
    assert swept.plot().axes[0].get_xlabel() == "cmod (mm)"
    swept.save(tmp_path)
    with open(tmp_path / "sweep.csv", newline="") as file:
        assert "cmod_at_peak" in next(csv.reader(file))
