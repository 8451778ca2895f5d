"""Results come back from their folder, and show themselves in notebooks."""

from __future__ import annotations

import sys
import types
from pathlib import Path

import matplotlib
import numpy as np
import pytest

from cohesive import Result, Scene, SceneError, run
from tests.builders import block, plate

matplotlib.use("Agg")


@pytest.fixture(scope="module")
def result() -> Result:
    return run(Scene.load("notched-beam").with_(**{"mesh.crack_size": 5.0, "mesh.far_size": 12.0, "stage.0.steps": 8}))


@pytest.fixture(scope="module")
def folder(result: Result, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("saved")
    result.save(path)
    return path


def test_a_platen_run_comes_back_with_its_way(tmp_path: Path) -> None:
    result = run(
        plate(
            stage=[{"control": "opening", "to": 0.01, "steps": 4}, {"control": "driven", "angle": 40, "to": 0.02, "steps": 3}]
        )
    )
    result.save(tmp_path)
    loaded = Result.load(tmp_path)
    assert loaded.facts.has_platen
    np.testing.assert_allclose(loaded.drive_travel, result.drive_travel, rtol=1e-12)
    assert loaded.plot().get_xlabel() == "travel of the platen, there and back (mm)"


@pytest.mark.parametrize("name", ["result.npz", "scene.toml"])
def test_a_missing_or_broken_file_is_named(name: str, result: Result, tmp_path: Path) -> None:
    result.save(tmp_path)
    whole = (tmp_path / name).read_bytes()
    for text in (b"", whole[: len(whole) // 2] + b"\0{", b"[1, 2]\n"):
        (tmp_path / name).write_bytes(text)
        with pytest.raises(SceneError, match=str(tmp_path)):
            Result.load(tmp_path)
    (tmp_path / name).unlink()
    with pytest.raises(SceneError, match=rf"there is no {name}; expected the folder of a run that this version saved"):
        Result.load(tmp_path)


def test_curve_and_body_are_drawn_into_given_axes(result: Result) -> None:
    from matplotlib import pyplot

    _, (left, right) = pyplot.subplots(1, 2)
    assert result.plot(left) is left and result.plot_deformed(right, row=3) is right
    assert left.get_xlabel() == "opening (mm)" and right.get_title().startswith("step 3")
    assert result.plot_deformed().get_title().startswith("last step")
    pyplot.close("all")


def test_a_solid_asks_for_solid_axes() -> None:
    from matplotlib import pyplot

    scene = Scene.load("single-crack-3d").with_(
        **{"mesh.crack_size": 20.0, "mesh.far_size": 20.0, "stage": [{"control": "driven", "to": 0.001, "steps": 1}]}
    )
    result = run(scene)
    assert result.plot_deformed().name == "3d"
    with pytest.raises(ValueError, match="expected axes with projection='3d'"):
        result.plot_deformed(pyplot.figure().add_subplot())
    pyplot.close("all")


def test_the_table_is_of_pandas_or_says_what_is_missing(result: Result, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match=r"^Result.to_frame needs pandas: pip install pandas$"):
        result.to_frame()

    class Table(dict):  # type: ignore[type-arg]
        attrs: dict[str, dict[str, str]] = {}  # noqa: RUF012

    monkeypatch.setitem(sys.modules, "pandas", types.SimpleNamespace(DataFrame=Table))
    table = result.to_frame()
    assert list(table) == list(result.history) and table.attrs["units"]["load"] == "N"


def test_a_notebook_shows_numbers_and_curve(result: Result, folder: Path) -> None:
    for each in (result, Result.load(folder)):
        text = each._repr_html_()
        assert f"{each.peak_load:.5g} N" in text and "data:image/png;base64,iVBORw0KGgo" in text
    odd = run(block(title="<b>&\"'"))
    assert "&lt;b&gt;&amp;" in odd._repr_html_()


def test_a_notebook_shows_progress(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    class ZMQInteractiveShell:
        """Stands for the kernel's."""

    run(block())
    assert capsys.readouterr().err == ""
    monkeypatch.setitem(sys.modules, "IPython", types.SimpleNamespace(get_ipython=ZMQInteractiveShell))
    run(block())
    assert "8/8" in capsys.readouterr().err
    seen: list[float] = []
    run(block(), on_step=lambda step, row: seen.append(row["step"]))  # what is given takes its place
    assert seen == list(range(1, 9)) and capsys.readouterr().err == ""
