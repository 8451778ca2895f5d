"""Pictures: whatever a title holds they are drawn, and one that is not is reported."""

from __future__ import annotations

from dataclasses import replace
from operator import methodcaller
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from matplotlib.axes import Axes

from cohesive import Result, Scene, SceneError, run
from cohesive.commands.command_line import main
from cohesive.figures.drawing import draw_curve, fitted, new_figure, save, set_title, write_figure
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


def test_pictures_for_print(tmp_path: Path) -> None:
    from cohesive.figures.pictures import write_pictures

    keys = {"formats": ["svg", "pdf"], "dpi": 200, "figure_size": [120.0, 80.0], "force_unit": "kN"}
    printed = run(block(output=keys))
    assert write_pictures(printed, tmp_path) == []
    for name in PICTURES:
        assert (tmp_path / name).with_suffix(".pdf").read_bytes().startswith(b"%PDF")
        assert "</svg>" in (tmp_path / name).with_suffix(".svg").read_text(encoding="utf-8")
    size = matplotlib.image.imread(tmp_path / "curve.png").shape
    assert size[:2] == pytest.approx((80.0 / 25.4 * 200, 120.0 / 25.4 * 200), abs=1.0)  # whole pixels
    axes = new_figure(6.4, 4.4).add_subplot()
    draw_curve(axes, printed)
    assert axes.get_ylabel() == "load (kN)" and axes.yaxis.get_major_formatter()(1500.0) == "1.5"
    assert f"peak {1e-3 * printed.peak_load:.5g} kN" in [text.get_text() for text in axes.get_legend().get_texts()]
    less = printed.scene.with_(**{"output.formats": ["pdf"]}).output
    write_figure(tmp_path / "curve.png", methodcaller("write_text", "a figure"), less)
    assert not (tmp_path / "curve.svg").exists() and (tmp_path / "curve.pdf").read_text(encoding="utf-8") == "a figure"


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [("formats", ["eps"], r"formats = \['eps'\]: expected a list of some of 'pdf', 'svg'"),
     ("formats", 1.0, "expected a list"),
     ("figure_size", [120.0], "width and height"),
     ("figure_size", [1.0, 1.0], "20 to 1000 mm"), ("force_unit", "MN", "expected 'N' or 'kN'")],
)  # fmt: skip
def test_what_no_figure_can_be_is_refused(key: str, value: object, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        Scene(block().data | {"output": {key: value}})


def test_what_was_measured_is_on_top(tmp_path: Path) -> None:
    data = tmp_path / "measured.csv"
    data.write_text("opening,load\n0,0\n0.01,900\n0.05,100\n", encoding="utf-8")
    axes = new_figure(6.4, 4.4).add_subplot()
    draw_curve(axes, run(block(reference={"file": str(data)})))
    by_label = {str(line.get_label()).split(",")[0]: line.get_zorder() for line in axes.lines}
    assert by_label["measured"] > by_label["discrete crack"]


def test_stresses_have_one_signed_scale_and_no_checkerboard(result: Result) -> None:
    """Both pictures are centred at 0 and end at ft at most; the stress of a cell is averaged over its nodes, so that a
    constant one stays, and neighbours differ less."""
    from cohesive.figures.body import draw_deformed

    for row in (result.peak_row, result.steps):
        axes = new_figure(6.4, 4.4).add_subplot()
        draw_deformed(axes, result, row)
        low, high = next(each for each in axes.collections if each.get_array() is not None).get_clim()
        assert low == -high and 0 < high <= float(result.scene.material.ft)

    frame = result.frame(result.peak_row)

    def drawn(stresses: list[np.ndarray]) -> np.ndarray:
        axes = new_figure(6.4, 4.4).add_subplot()
        draw_deformed(axes, _with_frame(result, replace(frame, stress=stresses)), result.peak_row)
        return np.asarray(next(each for each in axes.collections if each.get_array() is not None).get_array())

    alike = [np.tile([1.0, 0.0, 0.0], (len(stress), 1)) for stress in frame.stress]
    np.testing.assert_allclose(drawn(alike), 1.0, rtol=1e-12)
    rng = np.random.default_rng(0)
    rough = [np.array([1.0, 0.0, 0.0]) * rng.uniform(0.5, 1.5, (len(stress), 1)) for stress in frame.stress]
    assert drawn(rough).std() < 0.6 * np.concatenate(rough)[:, 0].std()


def _with_frame(result: Result, frame: object) -> Result:
    changed = replace(result)
    object.__setattr__(changed, "frame", lambda row: frame)
    return changed
