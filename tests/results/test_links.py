"""Links in the folder of a run: nothing is written through them."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from cohesive import Scene, SceneError, run
from cohesive.results.checkpoints import NAME
from cohesive.results.files import FILES
from cohesive.simulation import resume

pytestmark = pytest.mark.skipif(os.name != "posix", reason="POSIX")


def test_no_file_of_a_run_is_written_through_a_link(tmp_path: Path) -> None:
    folder, outside = tmp_path / "out", tmp_path / "outside"
    folder.mkdir()
    outside.mkdir()
    partial = [f".{Path(name).stem}.partial{Path(name).suffix}" for name in FILES]
    for name in (*FILES, *partial, NAME, "frame_0000.vtu", ".frame_0000.partial.vtu"):
        (outside / name).write_text("theirs")
        (folder / name).symlink_to(outside / name)
    (folder / ".lock").symlink_to(outside / "lock")
    small = {"mesh.crack_size": 5.0, "mesh.far_size": 20.0, "stage.0.steps": 3, "output.frames": 2}
    scene = Scene.load("notched-beam").with_(**small)
    with pytest.raises(SceneError, match="lock cannot be locked"):
        run(scene, output=folder)
    (folder / ".lock").unlink()
    run(scene, output=folder).save(folder)
    assert {path.read_text() for path in outside.iterdir()} == {"theirs"}
    assert not (folder / "history.csv").is_symlink() and not (folder / "result.npz").is_symlink()


def test_a_link_in_place_of_a_checkpoint_or_of_inputs_is_refused(tmp_path: Path) -> None:
    (tmp_path / "theirs").mkdir()
    (tmp_path / NAME).symlink_to(tmp_path / "theirs" / NAME)
    with pytest.raises(SceneError, match="is a link to elsewhere"):
        resume(tmp_path)
    (tmp_path / "inputs").symlink_to(tmp_path / "theirs")
    with pytest.raises(SceneError, match="inputs is a link to elsewhere"):
        run(Scene.load("notched-beam"), output=tmp_path)
    assert not list((tmp_path / "theirs").iterdir())
