"""Blocks in uniform states against closed forms, with an interface and with a band."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from cohesive import Scene, run
from cohesive.law.crack_plane import CrackPlane
from tests.builders import assert_same_history, block, run_and_keep

#: crack area of a block, mm^2
AREA = 400.0


@pytest.mark.parametrize(("shape", "order"), [("triangle", 1), ("triangle", 2), ("quad", 1), ("quad", 2)])
@pytest.mark.parametrize("rotation", [0.0, 30.0, 45.0, 90.0, 137.2])
def test_block_in_tension_is_the_law_in_series_with_elasticity(rotation: float, shape: str, order: int) -> None:
    to = [0.02, 0.005, 0.05, 0.0]  # opened, nearly closed, opened further, closed
    result = run(block(specimen__rotation=rotation, mesh__shape=shape, mesh__order=order, **{"stage__0__to": to}))
    law, area = CrackPlane(result.scene.material, result.width), 400.0
    Z = np.zeros(1)
    for u, load, driven, sliding in zip(*(result.history[k] for k in ("opening", "load", "driven", "sliding")), strict=True):
        traction, Z = law.traction(np.array([[u, 0.0]]), Z)
        stress = traction[0, 0]
        assert load == pytest.approx(area * stress, rel=1e-6, abs=1e-6 * area)
        assert driven == pytest.approx(u + stress * 40.0 / law.concrete.E, rel=1e-6, abs=1e-9)
        assert abs(sliding) < 1e-9


def test_pure_shear_without_contact() -> None:
    width = 0.3  # next to h nothing: eq. (25) leaves no contact
    scene = block(
        specimen__faces="clamped", specimen__drive_angle=90.0, interface__width=width, material__h=1e15,
        solver__tol=1e-8, **{"stage__0": {"control": "sliding", "to": 1.6, "steps": 100}},
    )  # fmt: skip
    result = run(scene)
    m = scene.material
    assert abs(result.history["opening"]).max() < 1e-8
    GIIf = m.r_sigma**2 * (m.E / m.G) * (m.Gf + m.ft**2 * width / (2 * m.E))
    assert result.dissipated_energy == pytest.approx(GIIf * 400.0, rel=1e-3)  # e^-7 is left at s = 1.6 mm
    assert result.history["load"].max() <= m.r_sigma * m.ft * 400.0


def test_load_control_up_and_down() -> None:
    result = run(block(stage=[{"control": "load", "to": [1000.0, 200.0, -800.0], "steps": 4}]))
    assert result.history["load"][-1] == pytest.approx(-800.0)
    assert result.dissipated_energy == 0.0
    stiffness = result.history["load"][1:] / result.history["driven"][1:]
    np.testing.assert_allclose(stiffness, stiffness[0], rtol=1e-8)


def test_added_compliance_of_a_block_is_the_width_over_its_height() -> None:
    result = run(block(stage=[{"control": "driven", "to": 1e-4, "steps": 1}]))
    assert result.added_compliance() == pytest.approx(0.3 / 40.0, rel=1e-4)  # the rigid crack plane is 1e6 times stiffer


def test_the_gauge_measures_what_the_crack_does() -> None:
    """Far beyond its strength a block slides and opens as its crack does: gauge and mean jump agree in sign and size."""
    stages = [{"control": "driven", "to": 0.3, "steps": 30}]
    shear = {"specimen__faces": "clamped", "specimen__drive_angle": 60.0, "specimen__rotation": 20.0}
    jump, gauge = (run(block(**shear, specimen__gauge=g, stage=stages, solver__tol=1e-6)) for g in (0.0, 20.0))
    for name in ("opening", "sliding"):
        assert gauge.history[name][-1] == pytest.approx(jump.history[name][-1], rel=0.1)
    assert abs(jump.history["sliding"][-1]) > 0.1


def smeared(**changes: Any) -> Scene:
    return block(model__kind="smeared", **changes)


def excess(scene: Scene, width: float) -> float:
    """Energy beyond Gf that a band of this width dissipates, N/mm."""
    m = scene.material
    return m.ft**2 * width / (2 * m.E)


@pytest.mark.parametrize("shape", ["triangle", "quad"])
@pytest.mark.parametrize("along", [1, 3, pytest.param(9, marks=pytest.mark.long)])
@pytest.mark.parametrize("width", [1.0, pytest.param(8.0, marks=pytest.mark.long), 30.0])
def test_a_bar_dissipates_the_same_on_any_mesh(width: float, along: int, shape: str) -> None:
    """The row has `along` elements, of quads an even number; opened to 2 Zm, where e^-10 (1 + 5) of the energy is left."""
    scene = smeared(band__width=width, mesh__crack_size=40.0 / along, mesh__far_size=40.0, mesh__shape=shape)
    Zm = scene.material.Zm
    stages = [{"control": "driven", "to": 0.02 * Zm, "steps": 6}, {"control": "driven", "to": 2.0 * Zm, "steps": 60}]
    result, states, built = run_and_keep(scene.with_(stage=stages))
    assert len(built.cracks.weights) == 2 * (2 * max(1, round(along / 2)) if shape == "quad" else along)
    expected = (scene.material.Gf + excess(scene, width)) * AREA
    assert result.full_energy == pytest.approx(expected, rel=1e-12)
    assert result.dissipated_energy == pytest.approx(expected, rel=0.01)
    # the law of the band's width in series with the rest of the bar, whose lateral motion is free
    law, h = CrackPlane(scene.material, width), result.history
    Z = np.zeros(1)
    for state, load, driven in zip(states, h["load"], h["driven"], strict=True):
        cracks = state.cracks.planes
        if not len(cracks.point):
            assert driven == pytest.approx(load / AREA * 40.0 / scene.material.E, rel=1e-9)
            continue
        u = cracks.jump[:, 0].mean()
        traction, Z = law.traction(np.array([[u, 0.0]]), Z)
        assert load == pytest.approx(AREA * traction[0, 0], abs=1e-6 * AREA)
        assert driven == pytest.approx(u + load / AREA * (40.0 - width) / scene.material.E, abs=1e-8)
    np.testing.assert_allclose(state.cracks.planes.length, width, rtol=1e-9)


def test_a_crack_at_right_angles_to_the_faces_is_that_of_the_plane() -> None:
    """Of a block without a Poisson's ratio, pulled: both are uniform, whatever the mesh. It is not shut to 0, the corner of
    the law: which side rounding takes there decides between 3 iterations and 10, and so on the next steps."""
    size = {"width": 40.0, "height": 40.0, "thickness": 20.0}
    data: dict[str, Any] = {
        "specimen": {"kind": "single-crack", **size}, "mesh": {"crack_size": 10.0, "far_size": 10.0},
        "material": {"preset": "reinhardt", "nu": 0.0}, "interface": {"width": 0.3}, "solver": {"tol": 1e-11},
        "stage": [{"control": "opening", "to": [0.02, 0.001, 0.05], "steps": 6}],
    }  # fmt: skip
    solid = Scene(data | {"specimen": {"kind": "single-crack-3d", **size}})
    assert_same_history(run(solid), run(Scene(data)), 1e-8)
