"""Pictures: whatever a title holds they are drawn, and one that is not is reported."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from matplotlib.axes import Axes

from cohesive import Result, Scene, run
from cohesive.commands.command_line import main
from cohesive.figures.drawing import draw_curve, fitted, new_figure, save, set_title
from cohesive.figures.mesh import save_mesh
from cohesive.model.marks import marks
from cohesive.model.mesh import cracked_mesh
from tests.builders import block

PICTURES = ("mesh.png", "curve.png", "deformed.png")

TITLES = {
    "bad mathtext": r"$\frac{1}{$ and $x_$",
    "beyond the plane": "\U0001d546 crack \U0001f9f1",
    "controls": "a\tb\nc\x07\x00d",
    "right to left": "שבר \u202e reversed",
    "long": "word " * 1000,
    "no spaces": "x" * 5000,
    "empty": "",
    "dollar": "costs $5 to $6",
}
#: those that stood in the way of most of what is drawn
WORST = ("bad mathtext", "controls", "long")


@pytest.fixture(scope="module")
def result() -> Result:
    return run(block())


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.long] * (name not in WORST)) for name in TITLES])
def test_any_title_is_drawn(name: str, result: Result, tmp_path: Path) -> None:
    from cohesive.figures.pictures import write_pictures

    assert write_pictures(replace(result, scene=result.scene.with_(title=TITLES[name])), tmp_path) == []
    for picture in PICTURES:
        size = matplotlib.image.imread(tmp_path / picture).shape
        assert max(size[:2]) < 2000 and (tmp_path / picture).stat().st_size > 5000


def test_a_picture_is_what_matplotlib_saves(result: Result, tmp_path: Path) -> None:
    """Though it is drawn once: the layout included."""
    for name in ("once.png", "twice.png"):
        figure = new_figure(6.4, 4.4)
        axes = figure.add_subplot()
        draw_curve(axes, result)
        figure.colorbar(axes.scatter([0.0, 0.01], [0.0, 100.0], c=[0.0, 1e-3]), ax=axes, label="a scale")
        set_title(figure, "Title")
        if name == "once.png":
            save(figure, tmp_path / name)
        else:
            figure.savefig(tmp_path / name, dpi=130)
    once, twice = (matplotlib.image.imread(tmp_path / name) for name in ("once.png", "twice.png"))
    np.testing.assert_array_equal(once, twice)


def test_a_text_is_broken_and_cut() -> None:
    assert fitted("a b", 10, 2) == ["a b"] and fitted("", 10, 2) == []
    lines = fitted("one two three four five six seven", 10, 2)
    assert len(lines) == 2 and lines[-1].endswith("...") and max(map(len, lines)) <= 10


def test_a_legend_takes_names_as_they_are(tmp_path: Path) -> None:
    data = tmp_path / "measured.csv"
    data.write_text("opening,load\n0,0\n0.01,900\n0.05,100\n")
    result = run(block(reference={"file": str(data), "label": r"$\bad{ label"}))
    result.save(tmp_path / "out")
    assert all((tmp_path / "out" / name).exists() for name in PICTURES)
    assert not any("could not be drawn" in note for note in result.notes)


def test_a_picture_that_fails_costs_a_sentence(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(*_: object) -> None:
        raise ZeroDivisionError("by a pixel")

    monkeypatch.setattr("cohesive.figures.pictures.save_deformed", fail)
    (tmp_path / "deformed.png").write_text("of an earlier run")
    assert main(["run", "notched-beam", "-o", str(tmp_path), "--set", "stage.0.steps=5", "--set", "mesh.crack_size=5"]) == 0
    assert "warning: deformed.png could not be drawn: ZeroDivisionError: by a pixel" in capsys.readouterr().out
    names = {path.name for path in tmp_path.iterdir()}
    assert {"history.csv", "curve.png", "mesh.png", "run.json", "scene.toml", "frames.pvd"} <= names
    assert "deformed.png" not in names and not [name for name in names if "partial" in name]


def drawn(result: Result) -> Axes:
    axes = new_figure(4.0, 3.0).add_subplot()
    draw_curve(axes, result)
    return axes


@pytest.mark.parametrize(
    ("control", "curve", "labels"),
    [
        ("opening", None, ("opening (mm)", "load (N)")),
        ("driven", None, ("driven (mm)", "load (N)")),
        ("load", None, ("opening (mm)", "load (N)")),
        ("opening", ["stress_s", "dissipated"], ("stress s (MPa)", "dissipated (N mm)")),
    ],
)
def test_the_curve_is_the_one_that_was_controlled_or_asked_for(
    control: str, curve: list[str] | None, labels: tuple[str, str]
) -> None:
    to = 300.0 if control == "load" else 0.01
    output = {} if curve is None else {"curve": curve}
    axes = drawn(run(block(stage=[{"control": control, "to": to, "steps": 2}], output=output)))
    assert (axes.get_xlabel(), axes.get_ylabel()) == labels


def test_a_further_gauge_that_is_controlled_is_drawn(beam: Scene) -> None:
    unmeasured = Scene({name: table for name, table in beam.data.items() if name != "reference"})
    result = run(unmeasured.with_(stage=[{"control": "deflection", "to": 0.02, "steps": 4}]))
    axes = drawn(result)
    assert axes.get_xlabel() == "deflection (mm)"
    np.testing.assert_array_equal(axes.lines[-2].get_xdata(), result.history["deflection"][[result.peak_row]])


KINDS = {
    "notched-beam": {"model.half": True},
    "four-point-beam": {"model.kind": "smeared"},
    "notched-tension": {},
    "wedge-splitting": {},
    "nooru-mohamed-4a": {},
    "single-crack-3d": {"mesh.crack_size": 20.0, "mesh.far_size": 20.0},
}


@pytest.mark.parametrize("name", KINDS)
def test_every_mesh_is_drawn_with_what_is_done_to_it(name: str, tmp_path: Path) -> None:
    scene = Scene.load(name).with_(**KINDS[name])
    mesh = cracked_mesh(scene)
    save_mesh(scene, mesh, tmp_path / "mesh.png")
    assert (tmp_path / "mesh.png").stat().st_size > 15_000
    shown = marks(scene.specimen, mesh, scene.model.plane, scene.model.half)
    assert {"held", "driven", "measured"} <= {mark.kind for mark in shown} | (
        {"measured"} if name == "single-crack-3d" else set()
    )
    assert [mark.name for mark in shown if mark.kind == "driven"] == list(scene.specimen.drives())
    assert {mark.name for mark in shown if mark.kind == "measured"} >= set(scene.specimen.gauges())


def test_a_body_of_its_own_is_drawn_with_its_pressures_and_springs(tmp_path: Path) -> None:
    from tests.model.test_loads import own

    scene = own(tmp_path, specimen__pressures=[{"at": "top", "value": 1.0}])
    mesh = cracked_mesh(scene)
    shown = {mark.kind: mark for mark in marks(scene.specimen, mesh, "stress", False)}
    assert shown["pressed"].text == "by 1 MPa from the beginning"
    save_mesh(scene, mesh, tmp_path / "mesh.png")


def test_deformed_shows_peak_and_end_side_by_side_or_above_each_other(result: Result, tmp_path: Path) -> None:
    from cohesive.figures.body import save_deformed

    save_deformed(result, tmp_path / "both.png")
    early = run(block(stage=[{"control": "opening", "to": 1e-5, "steps": 2}]))
    save_deformed(early, tmp_path / "one.png")
    both, one = (matplotlib.image.imread(tmp_path / name).shape for name in ("both.png", "one.png"))
    assert both[0] > 1.5 * one[0]  # the peak is its last step
