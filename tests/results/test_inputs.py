"""Files that a scene names are copied beside the results, and never over them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from cohesive import Result, Scene, SceneError, run
from cohesive.results.inputs import copy_inputs
from tests.builders import OF_A_FILE, coarse_beam

BARE = {key: value for key, value in coarse_beam("notched-beam", "stress").data.items() if key != "reference"}
SHORT = BARE | {"stage": [{"control": "opening", "to": 0.01, "steps": 2}], "output": {"frames": 0}}


def saved(folder: Path, to: float = 0.01, **reference: Any) -> Result:
    scene = Scene(SHORT | ({"reference": reference} if reference else {})).with_(**{"stage.0.to": to})
    result = run(scene, output=folder)
    result.save(folder)
    return result


@pytest.mark.long
def test_an_earlier_run_in_the_same_folder_is_compared_with_and_kept(tmp_path: Path) -> None:
    saved(tmp_path)
    earlier = (tmp_path / "history.csv").read_bytes()
    result = saved(tmp_path, to=0.008, file=str(tmp_path / "history.csv"))
    assert (tmp_path / "inputs" / "history.csv").read_bytes() == earlier
    assert (tmp_path / "history.csv").read_bytes() != earlier
    assert len((tmp_path / "history.csv").read_text().splitlines()) == len(result.history["load"]) + 1
    again = run(Scene.load(tmp_path / "scene.toml"), output=tmp_path)  # it runs from there, into there
    again.save(tmp_path)
    assert (tmp_path / "inputs" / "history.csv").read_bytes() == earlier
    assert again.agreement == result.agreement


@pytest.mark.long
def test_copies_of_another_scene_do_not_stay_and_other_files_do(tmp_path: Path) -> None:
    folder, mine = tmp_path / "out", tmp_path / "out" / "inputs" / "a.csv"
    mine.parent.mkdir(parents=True)
    mine.write_text("my own")
    for name in ("x", "y"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "a.csv").write_text("opening,load\n0.001,100\n0.02,900\n")
    saved(folder, file=[str(tmp_path / "x" / "a.csv"), str(tmp_path / "y" / "a.csv")])
    assert sorted(path.name for path in mine.parent.iterdir()) == ["a-2.csv", "a-3.csv", "a.csv", "sources.txt"]
    assert mine.read_text() == "my own"
    assert Scene.load(folder / "scene.toml").reference.files == ["inputs/a-2.csv", "inputs/a-3.csv"]  # type: ignore[union-attr]
    saved(folder)
    assert [path.name for path in mine.parent.iterdir()] == ["a.csv"]
    mine.unlink()
    saved(folder)
    assert not mine.parent.exists()


def test_a_mesh_takes_no_name_of_ours(tmp_path: Path) -> None:
    """Of a frame, which is replaced with the next run."""
    (tmp_path / "frame_0001.vtu").write_text("a mesh")
    scene = Scene(OF_A_FILE, tmp_path).with_(**{"specimen.file": "frame_0001.vtu"})
    assert copy_inputs(scene, tmp_path)["specimen"]["file"] == "inputs/frame_0001.vtu"
    (tmp_path / "frame_0001.vtu").unlink()
    with pytest.raises(SceneError, match=r"frame_0001.vtu': cannot be read: No such file"):
        copy_inputs(scene, tmp_path / "other")


def test_what_cannot_be_copied_does_not_cost_the_results(tmp_path: Path) -> None:
    held = {"specimen.supports": [{"at": "support_left", "direction": [0, 1]}]}
    gone = {"specimen.file": "gone.msh", "specimen.drive": {"at": "load", "direction": [0, -1]}} | held
    result = replace(run(Scene(SHORT)), scene=Scene(OF_A_FILE).with_(**gone))
    (tmp_path / "inputs").write_text("a file where the folder would be")
    with pytest.raises(SceneError, match=r"gone.msh': cannot be read"):
        result.save(tmp_path, pictures=False)
    assert (tmp_path / "history.csv").exists() and (tmp_path / "scene.toml").exists()
