"""Frames: their names and times, stress as a tensor, and the row of the history as field data."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from pathlib import Path

import meshio
import numpy as np
import pytest

from cohesive import Scene, SceneError, run
from cohesive.commands.command_line import main
from cohesive.model.build import build
from cohesive.results.measures import curve_measures
from tests.builders import block, coarse_beam


def times(folder: Path) -> tuple[list[float], list[str]]:
    entries = list(ET.parse(folder / "frames.pvd").iter("DataSet"))
    return [float(str(entry.get("timestep"))) for entry in entries], [str(entry.get("file")) for entry in entries]


def test_times_are_the_way_of_the_drive_and_rise(tmp_path: Path) -> None:
    result = run(block(stage=[{"control": "driven", "to": [0.02, 0.005], "steps": 10}], output__frames=10))
    result.save(tmp_path)
    at, names = times(tmp_path)
    steps = [int(name[6:-4]) for name in names]
    np.testing.assert_allclose(at, result.drive_travel[steps], rtol=1e-9)
    first = [i for i, step in enumerate(steps) if step <= 10]
    np.testing.assert_allclose(np.array(at)[first], result.history["driven"][steps][first], rtol=1e-9)  # until it turns
    assert (np.diff(at) > 0).all()


def test_each_frame_tells_its_row(tmp_path: Path) -> None:
    result = run(coarse_beam("notched-beam", "strain"))
    result.save(tmp_path)
    for name in times(tmp_path)[1]:
        mesh = meshio.read(tmp_path / name)
        row = int(mesh.field_data["step"][0])
        assert name == f"frame_{row:04d}.vtu"
        for column in ("load", "opening", "driven", "deflection"):
            assert mesh.field_data[column][0] == result.history[column][row]


def test_numbers_of_frames_have_the_width_of_the_last(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cohesive.results.run_data.RunData.steps", 123456)
    result = run(block(output__frames=0))
    monkeypatch.setattr("cohesive.results.run_data.RunData.frame_rows", lambda self: [2, 8])
    from cohesive.results.files import write_frames

    write_frames(result, tmp_path)
    assert times(tmp_path)[1] == ["frame_000002.vtu", "frame_000008.vtu"]


@pytest.mark.parametrize("plane", ["stress", "strain"])
def test_stress_is_a_symmetric_tensor(plane: str) -> None:
    result = run(coarse_beam("notched-beam", plane, stage__0__to=0.01))
    frame = result.frame(-1)
    tensor = np.concatenate(result.frame_mesh(frame).cell_data["stress"])
    n = sum(len(block.cells) for block in result.fields.bulk)
    np.testing.assert_array_equal(tensor[:, [1, 2, 5]], tensor[:, [3, 6, 7]])
    np.testing.assert_allclose(tensor[:n, [0, 4, 1]], np.concatenate(frame.stress)[:n], rtol=1e-15)
    across = result.scene.material.nu * (tensor[:n, 0] + tensor[:n, 4])
    np.testing.assert_allclose(tensor[:n, 8], across if plane == "strain" else 0.0, rtol=1e-12)
    assert not tensor[n:].any()


def test_a_solid_has_all_six_components() -> None:
    result = run(coarse_beam("notched-beam-3d", "stress", stage__0__steps=2))
    tensor = np.concatenate(result.frame_mesh(result.frame(-1)).cell_data["stress"])
    assert all(abs(tensor[:, k]).max() > 0 for k in (0, 1, 2, 4, 5, 8))
    np.testing.assert_array_equal(tensor[:, [1, 2, 5]], tensor[:, [3, 6, 7]])


@pytest.mark.parametrize("frames", [10**18, 10**9, 100_001, -1])
def test_more_frames_than_files_make_sense_are_refused(frames: int) -> None:
    with pytest.raises(SceneError, match=rf"^output.frames = {frames}: expected a number of at least 0 and at most 100000"):
        block(output__frames=frames)


def test_as_many_frames_as_there_are_steps(tmp_path: Path) -> None:
    result = run(block(output__frames=100_000))
    assert result.frame_rows() == list(range(1, 9))


@pytest.mark.parametrize("name", ["frame_0003.vtu", "history.csv", "mesh.png", "run.json", "frames.pvd"])
def test_a_folder_in_the_way_is_named_before_the_first_step(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """That no step can be made is not found out."""
    (tmp_path / name).mkdir()
    changes = ["mesh.crack_size=5", "stage.0.control=load", "stage.0.to=1e6", "stage.0.steps=1"]
    assert main(["run", "notched-beam", "-o", str(tmp_path), *(word for each in changes for word in ("--set", each))]) == 2
    err = capsys.readouterr().err
    assert err.startswith("cohesive: ") and f"{name} is a folder; expected a file of this name, or none" in err
    assert len(err.splitlines()) == 1 and (tmp_path / name).is_dir()


def test_only_frames_are_removed(tmp_path: Path) -> None:
    for name in ("frame_0001.vtu", "frame_of_mine.vtu"):
        (tmp_path / name).touch()
    run(block(output__frames=0)).save(tmp_path)
    assert not (tmp_path / "frame_0001.vtu").exists() and (tmp_path / "frame_of_mine.vtu").exists()


def test_run_json_tells_energies_and_measures_of_the_curve(beam: Scene, tmp_path: Path) -> None:
    result = run(beam)
    result.save(tmp_path)
    facts = json.loads((tmp_path / "run.json").read_text())
    h, curve = result.history, facts["curve"]
    assert facts["energies"]["work"] == h["work"][-1] and facts["energies"]["released"] == h["released"][-1]
    assert curve["over"] == "opening" and curve["peak"] == result.peak_load and curve["at_peak"] == result.opening_at_peak
    assert curve["last"] == h["load"][-1]
    at = curve["fallen_to_half_at"]
    assert at > result.opening_at_peak
    assert np.interp(at, h["opening"][result.peak_row :], h["load"][result.peak_row :]) == pytest.approx(
        0.5 * result.peak_load
    )
    problem = build(beam).problem
    elastic = problem.response(problem.point_law.elastic())
    assert curve["initial_stiffness"] == pytest.approx(1.0 / float(problem.measures["opening"] @ elastic), rel=1e-9)
    assert facts["summary"] == result.summary().splitlines()


def test_a_run_without_a_fall_has_no_half_of_its_peak() -> None:
    rising = curve_measures(run(block(stage=[{"control": "opening", "to": 1e-5, "steps": 3}])))
    assert rising["fallen_to_half_at"] is None and rising["initial_stiffness"] > 0
