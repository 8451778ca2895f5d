"""Tension off the path: told with place, multiple and load, in scenes whose path is the wrong one, and in no other."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w

from cohesive import NotConverged, Result, Scene, run
from cohesive.commands.command_line import main
from cohesive.elements.rotations import major_stress
from cohesive.scenes.scene import built_in


def eccentric(**changes: Any) -> Scene:
    """A beam with a small notch far from mid-span, where it would break at about half the load of the notch's path."""
    beam = {"length": 550.0, "depth": 150.0, "thickness": 150.0, "span": 500.0, "notch": 10.0, "notch_position": 150.0}
    data = {
        "specimen": {"kind": "notched-beam", **beam},
        "material": {"E": 33000.0, "nu": 0.2, "ft": 3.3, "Gf": 0.14, "softening": "exponential"},
        "mesh": {"order": 2},
        "stage": [{"control": "cmod", "to": 0.1, "steps": 10}],
        "output": {"frames": 0},
    }
    return Scene(data).with_(**{key.replace("__", "."): value for key, value in changes.items()})


def test_a_beam_that_would_break_at_mid_span_says_so_wherever_its_result_is_read(tmp_path: Path) -> None:
    """The sentence is in notes, summary and saved result; its tension is that of beam theory, less what the average over 13.8
    mm, a seventh of the way to the axis, takes; the load of its ft that of the same tension, for mid-span stays elastic."""
    result = run(eccentric())
    (note,) = (note for note in result.notes if "passes ft at (" in note)
    assert note.startswith("warning: off the path the tension passes ft at (0, 0), to 2.3") and note in result.summary()
    off = result.off_path
    assert off is not None
    beam = result.peak_load * 500.0 / 4 / (150.0 * 150.0**2 / 6) / 3.3
    assert 0.8 * beam < off.times < 0.9 * beam
    assert off.load == pytest.approx(result.peak_load / off.times, rel=0.01)
    result.save(tmp_path)
    assert repr(Result.load(tmp_path).off_path) == repr(off)
    assert (tmp_path / "mesh.png").exists()
    there = run(eccentric(specimen__crack=off.line, stage=[{"control": "driven", "to": 0.2, "steps": 10}]))
    assert off.load < there.peak_load < 0.6 * result.peak_load
    assert there.off_path is None


def test_what_is_told_is_in_the_fields() -> None:
    """An element at the place is pulled as much, within what lies between its centre and the mean."""
    result = run(eccentric(mesh__far_size=15.0))
    off = result.off_path
    assert off is not None
    row = int(np.flatnonzero(result.history["step"] == off.step)[0])
    block, stress = result.fields.bulk[0], result.frame(row).stress[0]
    near = np.linalg.norm(block.points[block.cells].mean(axis=1) - off.place, axis=1) < off.radius
    assert np.average(major_stress(stress[near]), weights=block.volumes()[near]) / 3.3 == pytest.approx(off.times, rel=0.1)


def test_a_run_that_fails_says_so_too() -> None:
    """No beam carries the load that the second stage asks for."""
    brittle = eccentric(stage=[{"control": "cmod", "to": 0.02, "steps": 4}, {"control": "load", "to": 1e5, "steps": 1}])
    with pytest.raises(NotConverged) as failed:
        run(brittle)
    result = failed.value.result
    assert result is not None and result.off_path is not None
    assert any("passes ft at (" in note for note in result.notes)


def test_an_even_moment_leaves_the_place_free() -> None:
    """Between the loads of a beam without a notch every place is pulled alike."""
    even = {"specimen.notch": 0.0, "mesh.order": 2, "mesh.crack_size": 4.0, "mesh.far_size": 12.0, "output.frames": 0}
    result = run(Scene.load("four-point-beam").with_(**even))
    (note,) = (note for note in result.notes if "passes ft at (" in note)
    assert not note.startswith("warning") and "whose place is free" in note


#: those that are run each time; the others are `long`
OFTEN = ["push-off", "notched-beam", "four-point-beam", "nooru-mohamed-4b", "single-crack"]


@pytest.mark.parametrize("name", [n if n in OFTEN else pytest.param(n, marks=pytest.mark.long) for n in built_in()])
def test_of_the_built_in_scenes_push_off_alone_speaks(name: str) -> None:
    assert (run(Scene.load(name).with_(**{"output.frames": 0})).off_path is not None) == (name == "push-off")


def test_the_edge_of_a_hole_beside_the_path_speaks() -> None:
    """A hole of 30 mm whose edge is 25 mm beside the path of a beam: its top is pulled beyond ft, and a crack from it would
    run to the upper face."""
    specimen = {
        "kind": "outline",
        "thickness": 150.0,
        "corners": [[-275, 0], [275, 0], [275, 150], [-275, 150]],
        "notches": [[0, 0], [0, 25]],
        "holes": [{"center": [40.0, 30.0], "radius": 15.0}],
        "supports": [{"at": [-250, 0], "direction": [0, 1]}, {"at": [-250, 0], "direction": [1, 0]},
                     {"at": [250, 0], "direction": [0, 1]}],
        "drive": {"at": [0, 150], "direction": [0, -1]},
        "gauge_minus": [-10, 0],
        "gauge_plus": [10, 0],
        "crack": [[0, 25], [0, 150]],
    }  # fmt: skip
    stage = [{"control": "opening", "to": 0.1, "steps": 15}]
    changes = {"specimen": specimen, "mesh": {"crack_size": 5.0, "order": 2}, "stage": stage}
    off = run(Scene(eccentric().data | changes)).off_path
    assert off is not None and not off.is_even and 1.1 < off.times < 1.5
    assert off.place == pytest.approx([40.0, 45.0], abs=5.0)
    assert max(y for _, y in off.line) == pytest.approx(150.0)


def test_the_command_runs_the_other_crack_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A short run ends in the figure that its crack does not give, in the folder too; the other one speaks of nothing."""
    (tmp_path / "beam.toml").write_text(tomli_w.dumps(eccentric().data))
    assert main(["run", str(tmp_path / "beam.toml"), "-o", str(tmp_path / "out")]) == 0
    result = Result.load(tmp_path / "out")
    (note,) = (note for note in result.notes if note.startswith("a straight crack there gives a peak load of "))
    assert note in capsys.readouterr().out
    peak = float(note.split()[9])
    assert result.off_path is not None and result.off_path.load < peak < 0.6 * result.peak_load
    there = run(result.off_path.scene(result.scene))
    assert there.peak_load == pytest.approx(peak, rel=1e-4) and there.off_path is None
