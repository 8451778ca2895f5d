"""What a scene is expected to take, before it is meshed."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

import cohesive.algebra.choice
from cohesive import Scene, SceneError, run
from cohesive.algebra.choice import machine_memory
from cohesive.commands.command_line import main
from cohesive.model.estimate import estimate
from cohesive.model.mesh import cracked_mesh
from cohesive.scenes.scene import built_in
from meshing.errors import MeshError

CHANGES = ({}, {"mesh.order": 2}, {"mesh.shape": "quad"}, {"model.kind": "smeared"})


@pytest.mark.parametrize("name", built_in())
def test_nodes_are_foreseen(name: str) -> None:
    """Within 2.2, in the plane within 1.75 for more than 1000 nodes: releases of gmsh differ by 1.3 in space alone."""
    tried = 0
    for factor in (1.0, 2.0):
        for change in CHANGES if factor == 1.0 else ({},):
            scene = Scene.load(name)
            sizes = {"mesh.crack_size": scene.sizes.crack_size * factor, "mesh.far_size": scene.sizes.far_size * factor}
            try:
                scene = scene.with_(**sizes, **change)
                nodes = len(cracked_mesh(scene).points)
            except (MeshError, SceneError):  # what this specimen does not have
                continue
            expected, _ = scene.specimen.expected_nodes(scene.sizes, half=scene.model.half, dimension=scene.dimension)
            limit = 2.2 if nodes < 1000 or scene.dimension == 3 else 1.75
            assert 1 / limit < expected / nodes < limit, (factor, change, expected, nodes)
            tried += 1
    assert tried >= 2  # each has at least one order or shape besides


def test_a_scene_that_the_memory_does_not_hold_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    changes = {"mesh.crack_size": 0.001, "mesh.far_size": 0.01}
    message = r"crack_size = 0\.001 and far_size = 0\.01 give about .* GB.*expected at least"
    with pytest.raises(SceneError, match=message) as error:
        run(Scene.load("notched-beam").with_(**changes))
    assert error.value.key == "mesh.crack_size"
    sets = [word for key, value in changes.items() for word in ("--set", f"{key}={value}")]
    assert main(["run", "notched-beam", "-o", str(tmp_path / "out"), *sets]) == 2
    assert "this machine has" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("name", built_in())
def test_any_kind_with_a_hundred_thousand_elements_along_its_crack_is_refused(name: str) -> None:
    """At once: nothing is meshed."""
    scene = Scene.load(name)
    size = 1e-5 * (scene.crack_area**0.5 if scene.dimension == 3 else scene.specimen.path_length)
    clock = time.process_time()
    with pytest.raises((SceneError, MeshError), match=r"mesh\.crack_size = .*expected at least"):
        cracked_mesh(scene.with_(**{"mesh.crack_size": size, "mesh.far_size": size}))
    assert time.process_time() - clock < 2.0


def test_the_size_that_is_asked_for_fits() -> None:
    scene = Scene.load("notched-beam").with_(**{"mesh.crack_size": 0.001, "mesh.far_size": 0.01})
    with pytest.raises(SceneError) as error:
        cracked_mesh(scene)
    crack, far = (float(word) for word in str(error.value).split("expected at least ")[1].split(" mm")[0].split(" and "))
    fitting = estimate(scene.with_(**{"mesh.crack_size": crack, "mesh.far_size": far}))
    assert fitting is not None and 0.8 < fitting.memory / machine_memory() < 1.1  # two digits are told


def test_the_limit_of_a_job_counts(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    machine = machine_memory()
    limits = [tmp_path / "max", tmp_path / "limit", tmp_path / "none"]
    limits[0].write_text("max\n")
    limits[1].write_text("2000000000\n")
    monkeypatch.setattr(cohesive.algebra.choice, "LIMITS", limits)
    assert machine_memory() == 2e9 < machine


def test_show_tells_what_is_expected(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["show", "notched-beam", "-o", str(tmp_path)]) == 0
    assert "expected:  about 3" in capsys.readouterr().out


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["discrete", "smeared"])
@pytest.mark.parametrize("name", ["en-14651", "l-panel", "nooru-mohamed-4a", "notched-beam-3d", "petersson", "push-off-3d"])
def test_the_time_is_foreseen(name: str, kind: str) -> None:
    """Within a factor of 3, with what the command takes to start and to draw."""
    scene = Scene.load(name).with_(**{"model.kind": kind})
    expected, begin = estimate(scene), time.process_time()
    run(scene)
    assert expected is not None
    assert 1 / 3 < (time.process_time() - begin + 1.5) / expected.seconds < 3


def test_the_time_goes_by_steps_and_model() -> None:
    beam = Scene.load("notched-beam")
    once, often, band = (estimate(beam.with_(**change)) for change in ({}, {"stage.0.steps": 6000}, {"model.kind": "smeared"}))
    assert once is not None and often is not None and band is not None
    assert once.seconds < 2.0 < band.seconds < 5.0 < often.seconds


def test_a_long_run_says_what_it_will_take_in_a_pipe_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """9000 steps, of which an event takes two."""
    sets = ["mesh.crack_size=5", "mesh.far_size=20", "stage.0.steps=9000", "stage.0.until={opening=3e-5}"]
    words = [word for each in sets for word in ("--set", each)]
    long = estimate(Scene.load("notched-beam").with_(**{"mesh.crack_size": 5.0, "mesh.far_size": 20.0, "stage.0.steps": 9000}))
    assert long is not None and long.seconds > 10.0
    assert main(["run", "notched-beam", "-o", str(tmp_path / "out"), *words]) == 0
    assert f"expected: {long.text}" in capsys.readouterr().err
    assert main(["run", "notched-beam", "-o", str(tmp_path / "short"), *words[:4], "--set", "stage.0.steps=2"]) == 0
    assert "expected" not in capsys.readouterr().err
