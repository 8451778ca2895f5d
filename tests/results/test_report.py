"""Warnings of a summary."""

from __future__ import annotations

import re

import numpy as np
import pytest

from cohesive import Result, Scene, run
from cohesive.results.report import warnings
from tests.builders import block, coarse_beam


def test_work_that_is_not_accounted_for_is_a_warning() -> None:
    result = run(block(stage=[{"control": "opening", "to": 0.2, "steps": 1}]))
    assert result.energy_error > 0.05
    assert any("% of the work are unaccounted for" in note for note in warnings(result))


def test_the_step_that_leaves_work_unaccounted_for_is_named() -> None:
    """Small steps to the peak and beyond, then large ones."""
    stages = [{"control": "opening", "to": 0.01, "steps": 20}, {"control": "opening", "to": 0.06, "steps": 1}]
    result = run(block(stage=stages))
    assert result.unaccounted[0] == 0.0 and result.energy_error == abs(result.unaccounted).max() / result.history["work"].max()
    (line,) = (line for line in result.summary().splitlines() if line.startswith("energy balance"))
    assert re.search(r"; \d+ % of it comes with step 21, up to opening 0\.0\d+ mm: smaller steps will close it$", line)
    fine = run(block(stage=[{"control": "opening", "to": 0.06, "steps": 120}]))
    assert "comes with step" not in fine.summary()


@pytest.mark.parametrize(("angle", "said"), [(0.0, " % is left"), (90.0, "which opening alone takes; sliding alone takes")])
def test_what_a_crack_may_dissipate_is_said(angle: float, said: str) -> None:
    stage = [{"control": "driven", "to": 0.2, "steps": 10}]
    sheared = {"specimen__drive_angle": angle, "specimen__faces": "clamped", "mesh__crack_size": 40.0, "mesh__far_size": 40.0}
    result = run(block(**sheared, stage=stage))
    (line,) = (line for line in result.summary().splitlines() if line.startswith("dissipated"))
    assert said in line and (result.dissipated_energy > result.full_energy) == (angle > 0)
    if angle:  # a shear stress of r_sigma ft at the onset: r_sigma^2 E/G times the energy of opening
        m = result.scene.material
        most = m.r_sigma**2 * m.E / m.G * result.full_energy
        assert f"up to {most:.5g} N mm" in line and result.dissipated_energy < most


def test_a_bulk_that_would_crack_is_warned_of() -> None:
    """A small crack inside a block that is pulled until it opens: the ligament carries many times its strength."""
    small = {"specimen.crack_radius": 15.0, "mesh.crack_size": 5.0, "mesh.far_size": 6.0, "output.frames": 0}
    pulled = Scene.load("single-crack-3d").with_(**small, stage=[{"control": "driven", "to": 0.05, "steps": 4}])
    off = run(pulled).off_path
    # clamped faces at a distance of 100 mm, pulled by 0.05 mm: E 0.05 / 100 of ft, and more beside the crack
    m = pulled.material
    assert off is not None and not off.line and off.times > m.E * 0.05 / 100 / m.ft
    assert run(coarse_beam("notched-beam-3d", "stress")).off_path is None


def test_first_order_tetrahedra_in_a_band_are_warned_of() -> None:
    everywhere = {
        "model.kind": "smeared",
        "band.where": "everywhere",
        "mesh.crack_size": 25.0,
        "mesh.far_size": 50.0,
        "specimen.gauge": 40.0,
    }
    scene = Scene.load("single-crack-3d").with_(**everywhere, stage=[{"control": "driven", "to": 0.001, "steps": 1}])
    assert any("tetra elements lock" in note for note in warnings(run(scene)))


def test_planes_that_depart_from_the_path_are_warned_of() -> None:
    """Pulled along y every plane stands across y; the path rises and falls by 2 in 5, which is 21.8 degrees."""
    path = [[-20.0, 0.0], [0.0, 8.0], [20.0, 0.0]]
    band = block(model__kind="smeared", specimen__crack=path, stage__0__to=0.03)
    result = run(band.with_(**{"band.planes": "principal"}))
    assert result.facts.departure == pytest.approx(np.degrees(np.arctan(0.4)), abs=1.0)
    assert any("the crack planes depart from the path by 22 degrees" in warning for warning in warnings(result))
    straight = block(model__kind="smeared", band__planes="principal")
    for scene in (band, straight):
        assert run(scene).facts.departure == pytest.approx(0.0, abs=1e-5)


@pytest.mark.parametrize("width", [2.1, 4.0, 40.0])
def test_a_width_that_is_felt_is_warned_of_with_one_that_is_not(width: float) -> None:
    """A bar of 40 mm: each mm of width is a mm of concrete more, 2.5 % of the compliance."""
    elastic = [{"control": "driven", "to": 1e-4, "steps": 1}]
    (sentence,) = (note for note in warnings(run(block(interface__width=width, stage=elastic))) if "compliance" in note)
    assert f"adds {100 * width / 40:.3g} % to the elastic compliance of the driven motion" in sentence
    enough = float(sentence.split("interface.width up to ")[1].split(" it")[0])
    assert enough == pytest.approx(2.0, rel=0.02)
    assert not any("compliance" in note for note in warnings(run(block(interface__width=enough, stage=elastic))))


def test_a_load_that_ripples_is_warned_of_and_smaller_elements_smooth_it() -> None:
    """A brittle beam with elements of .4 and .1 times E Gf / ft^2: the load of the first one rises again and again."""
    stages = [{"control": "cmod", "to": [0.03, 0.1], "steps": 40}]
    brittle = Scene.load("en-14651").with_(**{"material.Gf": 0.02, "material.ft": 5.0, "output.frames": 0}, stage=stages)
    coarse = run(brittle.with_(**{"mesh.order": 1, "mesh.crack_size": 10.4, "mesh.far_size": 60.0}))
    (sentence,) = (note for note in warnings(coarse) if "the load rises" in note)
    count, most = int(sentence.split("rises ")[1].split()[0]), float(sentence.split("up to ")[1].split(" %")[0])
    assert 2 <= count <= 12 and 0.5 < most < 20.0  # 12 elements
    assert any("elements along the crack are longer than" in note for note in coarse.notes)
    fine = run(brittle.with_(**{"mesh.order": 1, "mesh.crack_size": 2.5, "mesh.far_size": 60.0}))
    assert not any("the load rises" in note for note in warnings(fine))
    assert not any("longer than" in note for note in fine.notes)
    turned = coarse.scene.with_(**{"stage.0.to": [0.03, 0.1, 0.09]})  # a load that rises may be asked for
    assert not any("the load rises" in note for note in warnings(Result(**{**vars(coarse), "scene": turned})))
