"""A measured file says the same to run, fit, evaluate, sweep and explore."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from cohesive import Measured, Scene, SceneError, fit, read_measured, run, sweep
from cohesive.commands.command_line import main
from cohesive.explore.explorer import Explorer
from tests.measured.files import X, Y, semicolons, table

VARY = {"material.Gf": (0.05, 0.5)}
SCENE = Scene(
    {
        "specimen": {
            "kind": "notched-beam", "length": 550.0, "span": 500.0, "depth": 150.0, "thickness": 150.0, "notch": 25.0,
        },
        "mesh": {"crack_size": 25.0, "far_size": 60.0, "shape": "quad"},
        "material": {"E": 33e3, "nu": 0.2, "ft": 3.3, "Gf": 0.14, "softening": "hordijk"},
        "interface": {"width": 0.2},
        "stage": [{"control": "cmod", "to": 0.3, "steps": 6}],
    }
)  # fmt: skip
SIZES = [f"--set=specimen.{key}={value}" for key, value in SCENE.data["specimen"].items() if key != "kind"]
EVALUATE = ["--standard", "en-14651", *SIZES]

WRONG = {
    "two loads": table("CMOD,Load,CMOD,Load", X, Y, X, Y),
    "a unit": semicolons("CMOD;Kraft", X, Y, units="mm;xx"),
    "thousands or decimals": "CMOD [um];Kraft [N]\n0;0\n10;912\n20;1.075\n",
    "blocks": "Time Load CMOD\ns kN mm\n0 0.1 0.01\n1 0.2 0.02\nBlock 2\n2 0.3 0.03\n",
    "stacked": "CMOD;Kraft\n0,1;0,2\n0,2;0,4\nProbe;B2\nCMOD;Kraft\n0,1;0,2\n",
    "lost": "CMOD;Kraft\n0,1;0,2\n0,2;---\n0,3;0,5\n",
    "a workbook": "PK\x03\x04\0\0\0",
}
DOUBTED = {
    "negative": semicolons("Zeit;Force;CMOD", X, -1e-3 * Y, X, units="s;kN;mm"),
    "no unit": table("time;load;cmod", X, 1e-3 * Y, X, separator=";"),
}


def scene_of(path: Path) -> Scene:
    return SCENE.with_(reference={"file": str(path), "label": "test"})


def said(of: Callable[[], object]) -> str:
    with pytest.raises(SceneError) as caught:
        of()
    return str(caught.value)


def evaluated(path: Path, capsys: pytest.CaptureFixture[str]) -> str:
    assert main(["evaluate", str(path), *EVALUATE]) == 2
    return capsys.readouterr().err.removeprefix("cohesive: ").strip()


@pytest.mark.parametrize("case", WRONG)
def test_what_cannot_be_read_is_refused_in_one_sentence(
    case: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "measured.csv"
    path.write_text(WRONG[case], encoding="utf-8")
    entries: list[Callable[[], object]] = [
        lambda: read_measured(path),
        lambda: run(scene_of(path)),
        lambda: fit(scene_of(path), VARY),
        lambda: fit(SCENE, VARY, reference=path),
        lambda: sweep(scene_of(path), {"material.ft": [3.0]}, workers=1),
    ]
    sentences = {*map(said, entries), evaluated(path, capsys), Explorer(SCENE).measured(WRONG[case], path.name)["error"]}
    assert len(sentences) == 1
    assert sentences.pop().startswith("reference.file = 'measured.csv': ")


@pytest.mark.parametrize("case", DOUBTED)
def test_what_cannot_be_meant_is_doubted_in_one_sentence(
    case: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "measured.csv"
    path.write_text(DOUBTED[case], encoding="utf-8")
    sentence = said(lambda: fit(scene_of(path), VARY))
    assert "reference.y_unit = " in sentence
    measured = read_measured(path, crack_area=150.0 * 125.0)
    assert {
        said(lambda: fit(SCENE, VARY, reference=path)),
        said(lambda: fit(SCENE, VARY, reference=measured)),
        evaluated(path, capsys),
        Explorer(SCENE).measured(DOUBTED[case], path.name)["error"],
    } == {sentence}
    doubt = "test: " + sentence.removeprefix("reference.file = 'measured.csv': ")
    result = run(scene_of(path))
    assert [line for line in result.summary().splitlines() if line.startswith("test: ")] == [doubt]
    assert sweep(scene_of(path), {"material.ft": [3.0]}, workers=1).notes[-1] == doubt


def test_what_is_read_is_the_same_and_said_by_all(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    truth = run(SCENE).history
    x, y = truth["cmod"], truth["load"]
    columns = (2.0 * x, 1.234 + 1.1 * x, 1.234 + 0.9 * x, 1e-3 * y)
    text = semicolons("Durchbiegung;COD 1;COD 2;Force", *columns, units="mm;mm;mm;kN")
    path = tmp_path / "measured.csv"
    path.write_text(text, encoding="utf-8")
    measured = read_measured(path)
    assert len(measured.notes) == 2 and "are gauges of one quantity" in measured.notes[0]
    fits = [fit(scene_of(path), VARY, check=False), fit(SCENE, VARY, reference=path, check=False)]
    result = run(scene_of(path))
    swept = sweep(scene_of(path), {"material.ft": [3.0]}, workers=1)
    assert main(["evaluate", str(path), *EVALUATE]) == 0
    printed = capsys.readouterr().out
    page = Explorer(SCENE).measured(text, path.name)
    for note in measured.notes:
        assert f"test: {note}" in result.summary() and f"test: {note}" in swept.summary()
        assert all(f"measured.csv: {note}" in joint.summary() for joint in fits)
        assert note in printed and f"measured.csv: {note}" in page["notes"]
    assert result.reference is not None
    for curve in (result.reference.curves[0], *(joint.problem.data[0].curves[0] for joint in fits)):
        np.testing.assert_allclose([curve.x, curve.y], [x, y], rtol=1e-7, atol=1e-9)
        assert curve.against == "cmod"
    assert page["over"] == "cmod"
    assert Explorer(SCENE).fitted({}, text, path.name)["values"].keys() == {"material.ft", "material.Gf"}
    assert fits[0].values == fits[1].values
    assert f"{fits[0].evaluations[0].values['fct,L']:.4g} MPa" in printed


def test_each_scene_of_a_joint_fit_has_its_own_loss(tmp_path: Path) -> None:
    """A band whose mean is in the file too is a band, and its scene's rows count as such beside a curve of another scene."""
    truth = run(SCENE).history
    x, y = truth["cmod"][1:], truth["load"][1:]
    path = tmp_path / "band.csv"
    path.write_text(table("cmod_mm,load_mean_N,load_min_N,load_max_N", x, y, 0.9 * y, 1.1 * y), encoding="utf-8")
    curve = Measured.from_curve(x, y, against="cmod")
    joint = fit([SCENE, SCENE], VARY, reference=[path, curve], check=False)
    assert [data.loss for data in joint.problem.data] == ["band", "linear"]
    assert joint.values["material.Gf"] == pytest.approx(0.14, rel=1e-3)
    other = fit([SCENE, SCENE], VARY, reference=[path, Measured.from_curve(x, 1.05 * y, against="cmod")], check=False)
    inside, outside = other.problem.data[0].gap(1.05 * y)[0], other.problem.data[1].gap(y)[0]
    assert not inside.any() and outside.all()  # 5 % more is no error of the band, 5 % less is one of the curve
