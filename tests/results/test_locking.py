"""Two runs into one folder, and folders in which nothing was written."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from cohesive import SceneError, run
from cohesive.commands.command_line import main
from cohesive.results.locking import lock_folder
from tests.builders import block


def test_a_second_run_into_a_folder_is_told_of_the_first(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    holder = (
        "import sys; from cohesive.results.locking import lock_folder\n"
        f"with lock_folder({str(tmp_path)!r}):\n    print('held', flush=True)\n    sys.stdin.read()"
    )
    with subprocess.Popen([sys.executable, "-c", holder], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as other:
        assert other.stdout is not None and other.stdin is not None
        other.stdout.readline()
        words = rf"'{tmp_path}': another run writes there; expected another folder"
        with pytest.raises(SceneError, match=words):
            run(block(), output=tmp_path)
        assert main(["run", "notched-beam", "-o", str(tmp_path)]) == 2
        assert "another run writes there" in capsys.readouterr().err
        assert sorted(os.listdir(tmp_path)) == [".lock"]
        other.kill()
    run(block(), output=tmp_path)  # a lock goes with its process
    assert ".lock" not in os.listdir(tmp_path)


def test_a_thread_holds_its_folder_against_others_only(tmp_path: Path) -> None:
    errors: list[Exception] = []

    def other() -> None:
        try:
            with lock_folder(tmp_path):
                pass
        except SceneError as error:
            errors.append(error)

    with lock_folder(tmp_path), lock_folder(tmp_path):
        thread = threading.Thread(target=other)
        thread.start()
        thread.join()
    assert len(errors) == 1
    other()
    assert len(errors) == 1


def test_a_refused_run_leaves_no_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for keys in (["specimen.notch=60"], ["specimen.gauge=0"], ["stage.0.to=0"], ["stage.0.steps=1e30"]):
        folder = tmp_path / "new"
        assert main(["run", "notched-beam", "-o", str(folder), *(w for key in keys for w in ("--set", key))]) == 2
        assert not folder.exists(), keys
    (tmp_path / "mine").mkdir()
    assert main(["run", "notched-beam", "-o", str(tmp_path / "mine"), "--set", "stage.0.to=0"]) == 2
    assert (tmp_path / "mine").exists()


@pytest.mark.parametrize("key", ["stage.0.steps=1000001", "stage.0.step=1e-90", "stage.0.step=1e-9"])
def test_steps_without_limit_are_refused(key: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    steps = [] if "steps" in key else ["--set", 'stage.0={control="opening", to=0.18}']
    assert main(["run", "notched-beam", *steps, "--set", key, "-o", str(tmp_path)]) == 2
    assert f"{key.split('=')[0]} = " in (err := capsys.readouterr().err) and "1000000" in err
