"""A result is data: fresh, from a pickle and from its folder it is the same in all that a reader may ask for."""

from __future__ import annotations

import json
import pickle
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import matplotlib
import meshio
import numpy as np
import pytest

from cohesive import CrackPlane, NotConverged, Result, Scene, SceneError, run
from tests.builders import block, coarse_beam, plate

matplotlib.use("Agg")


def stopped() -> Result:
    """A run that fails after the peak of its load control."""
    with pytest.raises(NotConverged) as caught:
        run(block(stage=[{"control": "load", "to": 5000.0, "steps": 6}]))
    assert isinstance(caught.value.result, Result)
    return caught.value.result


def grown() -> Result:
    return run(
        Scene.load("notched-beam").with_(
            **{"specimen.crack": "grow", "specimen.notch_position": 20.0, "mesh.crack_size": 5.0, "mesh.far_size": 12.0,
               "stage.0.steps": 4, "output.frames": 2}
        )
    )  # fmt: skip


RUNS: dict[str, Callable[[], Result]] = {
    "discrete": lambda: run(coarse_beam("notched-beam", "strain")),
    "smeared": lambda: run(block(model__kind="smeared", **{"interface": {}})),
    "solid": lambda: run(coarse_beam("notched-beam-3d", "stress", stage__0__steps=3, output__frames=1)),
    "grown": grown,
    "platen": lambda: run(plate(stage=[{"control": "driven", "angle": 40, "to": 0.02, "steps": 3}])),
    "stopped": stopped,
}

#: public members that are called with nothing, with each row, or with the name of a motion
CALLED = ("summary", "frame_rows", "added_compliance", "profile_distance")
OF_ROWS = ("row", "frame", "crack", "opening_profile")
OF_NAMES = ("unit_of",)

#: members that write or draw, tested elsewhere, and alternative constructors
OTHERS = {"from_run", "load", "save", "plot", "plot_deformed", "to_frame", "frame_mesh"}


def members(result: Result) -> dict[str, Any]:
    """All that a reader may ask a result for, by name."""
    entries: dict[str, Any] = {}
    rows = len(result.history["step"])
    for name in dir(result):
        if name.startswith("_") or name in OTHERS:
            continue
        value = getattr(result, name)
        if name in OF_ROWS:
            entries |= {f"{name}({row})": value(row) for row in range(-min(rows, 1), rows)}
        elif name in OF_NAMES:
            entries |= {f"{name}({column})": value(column) for column in result.history}
        elif name == "at_peak":
            entries |= {f"{name}({column})": value(values) for column, values in result.history.items()}
        elif callable(value):
            assert name in CALLED, f"{name}: how is it called?"
            entries[name] = value()
        else:
            entries[name] = value
    return entries


def named(scene: Scene) -> dict[str, Any]:
    """The data of a scene, with the names of its files alone: the folder of a result has copies of them."""
    data = scene.data
    if "reference" in data:
        data["reference"]["file"] = Path(data["reference"]["file"]).name
    return data


def assert_same(one: Any, other: Any, where: str) -> None:
    """Equal to the last bit, in type, too."""
    assert type(one) is type(other), where
    if isinstance(one, Scene):
        assert named(one) == named(other), where
    elif isinstance(one, (meshio.Mesh, CrackPlane)):
        assert_same(vars(one), vars(other), where)
    elif isinstance(one, meshio.CellBlock):
        assert_same((one.type, one.data), (other.type, other.data), where)
    elif isinstance(one, np.ndarray):
        assert one.dtype == other.dtype, where
        np.testing.assert_array_equal(one, other, err_msg=where)
    elif isinstance(one, dict):
        assert list(one) == list(other), where
        for name in one:
            assert_same(one[name], other[name], f"{where}.{name}")
    elif isinstance(one, (list, tuple)):
        assert len(one) == len(other), where
        for i, (a, b) in enumerate(zip(one, other, strict=True)):
            assert_same(a, b, f"{where}.{i}")
    elif is_dataclass(one):
        for each in fields(one):
            assert_same(getattr(one, each.name), getattr(other, each.name), f"{where}.{each.name}")
    else:
        assert one == other or (one != one and other != other), where


@pytest.fixture(scope="module", params=RUNS)
def result(request: pytest.FixtureRequest) -> Result:
    return RUNS[request.param]()


def files(folder: Path) -> dict[str, bytes]:
    """All files by name; of run.json without the time that writing took, which the summary tells, too."""
    entries = {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    facts = json.loads(entries["run.json"])
    del facts["timings"]["output"], facts["summary"], facts["scene"]
    entries.pop("inputs/sources.txt", None)
    return entries | {"run.json": json.dumps(facts).encode(), "result.npz": b""}  # whose bytes hold the time of writing


def test_it_is_the_same_from_a_pickle_and_from_its_folder(result: Result, tmp_path: Path) -> None:
    folder = tmp_path / "fresh"
    result.save(folder, pictures=False)
    expected = members(result)
    named = {"peak_load", "history", "notes", "found", "fields", "agreement", "frame(-1)", "summary", "drive_travel"}
    assert named <= expected.keys()
    for again in (pickle.loads(pickle.dumps(result)), Result.load(folder)):
        assert_same(members(again), expected, "result")
        again.save(tmp_path / "again", pictures=False)
        assert files(tmp_path / "again") == files(folder)


def test_nothing_of_the_model_is_kept(result: Result) -> None:
    """No equations, factors or functions: what is in a pickle are numbers, words, the scene and its mesh."""
    text = pickle.dumps(result)
    for room in (b"cohesive.algebra", b"cohesive.solver.problem", b"cohesive.solver.stepper", b"cohesive.cracks"):
        assert room not in text, room


def test_a_run_without_a_step_is_data_too(tmp_path: Path) -> None:
    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as caught:
        run(block(), on_step=stop)
    first: Result = caught.value.result  # type: ignore[attr-defined]
    first.save(tmp_path, pictures=False)
    assert first.steps == 1
    assert_same(members(Result.load(tmp_path)), members(first), "result")


def test_a_body_that_does_not_bear_its_weight_has_no_row(tmp_path: Path) -> None:
    with pytest.raises(NotConverged, match="does not bear its dead loads") as caught:
        run(coarse_beam("notched-beam", "stress", **{"material.density": 1e6, "solver.tol": 1e-4}))
    nothing = caught.value.result
    assert isinstance(nothing, Result) and nothing.steps == 0 and nothing.peak_load == 0.0
    nothing.save(tmp_path, pictures=False)
    assert_same(members(Result.load(tmp_path)), members(nothing), "result")


def test_a_large_run_keeps_the_fields_of_its_frames(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("cohesive.results.fields.MOST_NUMBERS", 0)
    result = run(block(stage=[{"control": "opening", "to": 0.05, "steps": 40}], output__frames=2))
    result.save(tmp_path)
    rows = set(result.fields.rows.tolist())
    assert {*result.frame_rows(), result.peak_row, 40} <= rows and len(rows) < 12
    missing = next(row for row in range(40) if row not in rows)
    for call in (result.frame, result.plot_deformed, result.crack):
        with pytest.raises(LookupError, match=rf"^row {missing}: its .* were not kept, .* or a larger output.frames$"):
            call(row=missing)
    with pytest.raises(IndexError, match="row 41: the run has 41 rows, the first is 0"):
        result.frame(41)


@pytest.mark.parametrize("text", [b"", b"PK\x03\x04", "whole"])
def test_broken_fields_are_one_sentence(text: Any, tmp_path: Path) -> None:
    run(block()).save(tmp_path, pictures=False)
    path = tmp_path / "result.npz"
    path.write_bytes(path.read_bytes()[:-40] if text == "whole" else text)
    with pytest.raises(SceneError, match=rf"^'{path}': cannot be read: .*; expected that of a run"):
        Result.load(tmp_path)
