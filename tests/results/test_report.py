"""Warnings of a summary."""

from __future__ import annotations

import numpy as np
import pytest

from cohesive import Scene, run
from cohesive.results.report import warnings
from tests.builders import block, coarse_beam


def test_work_that_is_not_accounted_for_is_a_warning() -> None:
    result = run(block(stage=[{"control": "opening", "to": 0.2, "steps": 1}]))
    assert result.energy_error > 0.05
    assert any("% of the work are unaccounted for" in note for note in warnings(result))


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
    result = run(block(model__kind="smeared", specimen__crack=path, stage__0__to=0.03))
    assert result.facts.departure == pytest.approx(np.degrees(np.arctan(0.4)), abs=1.0)
    assert any("the crack planes depart from the path by 22 degrees" in warning for warning in warnings(result))
    assert run(block(model__kind="smeared")).facts.departure == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("width", [2.1, 4.0, 40.0])
def test_a_width_that_is_felt_is_warned_of_with_one_that_is_not(width: float) -> None:
    """A bar of 40 mm: each mm of width is a mm of concrete more, 2.5 % of the compliance."""
    elastic = [{"control": "driven", "to": 1e-4, "steps": 1}]
    (sentence,) = (note for note in warnings(run(block(interface__width=width, stage=elastic))) if "compliance" in note)
    assert f"adds {100 * width / 40:.3g} % to the elastic compliance of the driven motion" in sentence
    enough = float(sentence.split("interface.width up to ")[1].split(" it")[0])
    assert enough == pytest.approx(2.0, rel=0.02)
    assert not any("compliance" in note for note in warnings(run(block(interface__width=enough, stage=elastic))))
