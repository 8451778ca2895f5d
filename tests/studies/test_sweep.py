"""Sweeps: the grid, its table and figure, runs that fail, processes, interruption."""

from __future__ import annotations

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from cohesive import SceneError, prepare, run, sweep
from cohesive.commands.command_line import main
from cohesive.errors import Interrupted
from cohesive.results.files import PICTURES
from cohesive.studies.sweep import Sweep, SweptRun
from tests.builders import assert_same_history, block

GRID = {"material.Gf": [0.08, 0.1], "stage.0.steps": [4, 6]}


def test_each_combination_has_its_run_and_its_row() -> None:
    scene, seen = block(), []
    found = sweep(scene, GRID, workers=1, on_run=seen.append)
    assert [each.values for each in found.runs] == [
        {"material.Gf": gf, "stage.0.steps": steps} for gf in (0.08, 0.1) for steps in (4, 6)
    ]
    assert seen == found.runs
    prepared = prepare(scene)
    for each in found.runs:
        assert each.result is not None and each.is_done
        assert_same_history(each.result, run(scene.with_(**each.values), prepared), 0.0)
    assert found.table["peak"] == [each.result.peak_load for each in found.runs if each.result is not None]
    assert found.table["reason"] == [""] * 4


def test_one_mesh_serves_all_materials() -> None:
    def meshes(found: Sweep) -> int:
        return len({len(each.result.fields.mesh.points) for each in found.runs if each.result is not None})

    found = sweep(block(), {"mesh.crack_size": [5.0, 8.0], "material.E": [3e4, 3.5e4]}, workers=1)
    assert len(found.runs) == 4 and meshes(found) == 2
    assert "one mesh for each of mesh.crack_size" in found.summary()
    assert "one mesh" not in sweep(block(), {"material.nu": [0.18, 0.2]}, workers=1).summary()  # nothing is shared


@pytest.mark.long
def test_a_run_that_fails_is_a_row_and_ends_nothing(tmp_path: Path) -> None:
    stages = [{"control": "opening", "to": 0.05, "steps": 4}, {"control": "load", "to": 1e6, "steps": 400}]
    scene = block(output__frames=0)
    found = sweep(scene, {"material.Gf": [-1.0, 0.1], "stage.0": stages}, workers=1, output=tmp_path)
    reasons = found.table["reason"]
    assert (
        "material.Gf = -1.0: expected a number above 0" in reasons[0] and reasons[2] == "" and "failed down to" in reasons[3]
    )
    stopped = found.runs[3].result
    assert stopped is not None and stopped.steps  # as far as it came
    found.save(tmp_path)
    lines = (tmp_path / "sweep.csv").read_text().splitlines()
    assert lines[0] == "run,material.Gf,stage.0,peak,opening_at_peak,dissipated,energy_error,iterations,seconds,reason"
    assert len(lines) == 5 and lines[1].startswith("run-1,-1,")
    assert sorted(p.name for p in tmp_path.iterdir() if (p / "history.csv").exists()) == ["run-3", "run-4"]
    assert (tmp_path / "sweep.png").stat().st_size > 1e4
    assert "run-1: material.Gf" in (tmp_path / "sweep.txt").read_text()


def test_what_no_run_can_use_is_refused_at_once() -> None:
    for vary, words in (
        ({"material.Gff": [1.0, 2.0]}, "material.Gff"),
        ({}, "a sweep of no runs"),
        ({"material.Gf": []}, "material.Gf: no values"),
        ({"material.Gf": np.linspace(0.1, 1, 101), "material.ft": np.linspace(1, 2, 101)}, "at most 10000 runs"),
    ):
        with pytest.raises(SceneError, match=words):
            sweep(block(), vary, workers=1)


def test_an_interruption_keeps_what_is_finished() -> None:
    def interrupt(each: SweptRun) -> None:
        raise KeyboardInterrupt

    with pytest.raises(Interrupted) as error:
        sweep(block(), GRID, workers=1, on_run=interrupt)
    kept = error.value.result
    assert [each.reason for each in kept.runs] == ["", *["interrupted"] * 3]


def test_an_executor_runs_the_scenes_and_files_stay_here(tmp_path: Path) -> None:
    with ThreadPoolExecutor(1) as pool:
        found = sweep(block(output__frames=0, stage__0__steps=2), {"material.Gf": [0.08, 0.1]}, executor=pool, output=tmp_path)
    assert all((tmp_path / each.name / "run.json").exists() for each in found.runs)


SCRIPT = """
from tests.builders import block
from cohesive import sweep

{guard}
    found = sweep(block(), {{"material.Gf": [0.08, 0.1]}}, workers=2)
    print(found.table["reason"], found.runs[0].result.peak_load)
"""


@pytest.mark.long
@pytest.mark.parametrize("guard", ['if __name__ == "__main__":', "if True:"])
def test_processes_from_a_script(guard: str, tmp_path: Path) -> None:
    script = tmp_path / "swept.py"
    script.write_text(SCRIPT.format(guard=guard))
    root = Path(__file__).parents[2]
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, env={"PYTHONPATH": str(root)}, timeout=60)
    if "main" in guard:
        peak = sweep(block(), {"material.Gf": [0.08, 0.1]}, workers=1).runs[0].result
        failures, printed = done.stdout.rsplit(" ", 1)
        assert peak is not None and failures == "['', '']"
        assert float(printed) == pytest.approx(peak.peak_load, rel=1e-10)  # threads add up in another order
    else:
        assert done.stderr.count('below `if __name__ == "__main__":`') == 1 and "bootstrapping" not in done.stderr


def test_the_command_writes_table_figure_and_runs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sizes = ["--set", "mesh.crack_size=5", "--set", "mesh.far_size=20", "--set", "stage.0.steps=4", "--set", "output.frames=0"]
    vary = ["--vary", "material.Gf=0.05:0.10:2", "--vary", "material.softening=linear,hordijk", "--workers", "1"]
    assert main(["sweep", "notched-beam", *vary, *sizes, "-o", str(tmp_path)]) == 0
    assert capsys.readouterr().out.splitlines()[1].split()[:3] == ["run-1", "0.05", "linear"]
    assert {"sweep.csv", "sweep.png", "sweep.txt", "run-1", "run-4"} <= {path.name for path in tmp_path.iterdir()}


@pytest.mark.long
def test_pictures_of_single_runs_are_there_if_asked_for(tmp_path: Path) -> None:
    """Those of an earlier sweep go."""
    command = ["sweep", "notched-beam", "--vary", "material.Gf=0.05,0.1", "--workers", "1", "-o", str(tmp_path)]
    command += ["--set", "mesh.crack_size=5", "--set", "mesh.far_size=20", "--set", "stage.0.steps=2"]
    for asked in (True, False):
        assert main([*command, *["--pictures"] * asked]) == 0
        names = {path.name for path in (tmp_path / "run-2").iterdir()}
        assert {"history.csv", "run.json", "scene.toml", "frames.pvd"} <= names
        assert set(PICTURES) & names == (set(PICTURES) if asked else set())


@pytest.mark.parametrize(
    ("vary", "words"),
    [
        ("material.Gf", "expected KEY=VALUES"),
        ("material.Gf=", "expected KEY=VALUES"),
        ("material.Gf=1:2:1", "a count from 2 to 10000"),
        ("material.Gf=1:2:1e9", "a count from 2 to 10000"),
        ("material.Gf=1:inf:3", "two numbers"),
        ("material.Gff=1,2", "material.Gff"),
    ],
)
def test_values_that_are_none_are_told(vary: str, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sweep", "notched-beam", "--vary", vary, "-o", str(tmp_path / "none")]) == 2
    assert words in capsys.readouterr().err
    assert not (tmp_path / "none").exists()
