"""Energies: what a crack dissipates, and the balance of work as the steps shrink, through contact too."""

from __future__ import annotations

import numpy as np
import pytest

from cohesive import Scene, run
from cohesive.scenes.scene import built_in
from tests.builders import block, run_and_keep

#: built-in scenes that take more than a second
SECONDS = ("single-crack-3d", "reinhardt-cyclic")


def pulled(steps: int, tol: float = 1e-4) -> Scene:
    """The notched plate until every point of the ligament is past 1.4 Zm."""
    scene = Scene.load("notched-tension").with_(**{"mesh.crack_size": 2.0, "mesh.far_size": 12.0, "solver.tol": tol})
    Zm = scene.material.Zm
    stages = [{"control": "opening", "to": 0.02, "steps": steps}, {"control": "opening", "to": 1.6 * Zm, "steps": 2 * steps}]
    return scene.with_(stage=stages)


def test_notched_plate_dissipates_the_fracture_energy() -> None:
    result, states, _ = run_and_keep(pulled(40))
    state = states[-1]
    assert state.cracks.deformation[:, 0].min() > 1.4 * result.scene.material.Zm
    assert abs(state.cracks.stress).max() < 1e-3 * result.scene.material.ft
    assert result.dissipated_energy == pytest.approx(result.full_energy, rel=0.01)
    assert result.dissipated_energy < result.full_energy  # the tail is not cut off


def test_energy_balance_closes_as_the_steps_shrink() -> None:
    errors = [run(pulled(steps)).energy_error for steps in (20, 40, 80)]
    assert errors[1] < 1e-3
    assert errors[2] < 0.5 * errors[1] < 0.25 * errors[0]  # at least first order, through the peak's corner


def test_energy_balance_holds_through_contact() -> None:
    to = [0.08, -0.004, 0.08]
    result = run(block(specimen__angle=20.0, mesh__crack_size=4.0, stage=[{"control": "driven", "to": to, "steps": 150}]))
    h = result.history
    assert abs(h["contact_work"]).max() > 0.02 * h["work"].max()
    assert result.energy_error < 1e-3


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.long] * (name in SECONDS)) for name in built_in()])
def test_a_built_in_scene_closes_its_balance(name: str) -> None:
    """Of second order in the steps: the beam in 3D has 40 of them where the one in 2D has 60."""
    limit = 2e-3 if name == "notched-beam-3d" else 1e-3
    assert run(Scene.load(name).with_(**{"output.frames": 0})).energy_error < limit


@pytest.mark.long
@pytest.mark.parametrize("to", [[0.12], [0.06, 0.0, 0.12]], ids=["opened", "opened, closed, reopened"])
def test_the_energies_of_a_beam_add_up(beam: Scene, to: list[float]) -> None:
    """The trapezoidal work of a step is second order in it: half the steps, a quarter of the error (2e-4 at 80)."""
    errors = []
    for steps in (40, 80):
        result = run(beam.with_(**{"model.kind": "smeared", "stage.0.to": to, "stage.0.steps": steps}))
        errors.append(result.energy_error)
        assert result.history["opening"][-1] == pytest.approx(to[-1], rel=1e-5)
    assert errors[1] < 5e-4
    assert errors[1] < 0.4 * errors[0]
    if len(to) > 1:
        h = result.history
        assert h["load"][h["opening"] < 0.005].min() < 0  # it takes a push to close rough faces
        closed, opened = (int(i) for i in (h["opening"][60:].argmin() + 60, h["opening"].argmax()))
        assert h["dissipated"][closed] < 1.02 * h["dissipated"][np.flatnonzero(h["opening"] > 0.0599)[0]]
        assert h["dissipated"][opened] > 1.2 * h["dissipated"][closed]


@pytest.mark.parametrize("model", ["discrete", "smeared"])
def test_the_step_in_which_damage_begins_has_no_error_of_its_own(model: str) -> None:
    """Elastic up to the onset, an even crack then: both parts are integrated exactly, however long the step. A trapezoid over
    both is 10 % off."""
    result = run(block(solver__tol=1e-9, stage=[{"control": "opening", "to": 0.004, "steps": 1}]), model)
    onset = result.scene.material.ft * 0.3 / result.scene.material.E
    h = result.history
    assert h["dissipated"][1] > 0 and h["opening"][1] > 10 * onset
    error = h["work"] - sum(h[name] for name in ("elastic", "stored", "dissipated", "contact_work", "released"))
    assert abs(error[1]) < 0.01 * h["load"][1] * h["driven"][1]


def test_pulled_again_after_unloading_the_balance_is_that_of_small_steps() -> None:
    """The way back to the damage surface is elastic too."""
    stages = [{"control": "opening", "to": [0.02, 0.015, 0.03], "steps": 5}]
    coarse = run(block(solver__tol=1e-9, stage=stages))
    fine = run(block(solver__tol=1e-9, stage=[stages[0] | {"steps": 40}]))
    assert coarse.energy_error < 2e-2
    assert fine.energy_error < coarse.energy_error / 30  # with the square of the steps
