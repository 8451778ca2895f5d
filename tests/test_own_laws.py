"""Laws from outside the package in whole runs."""

from __future__ import annotations

import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cohesive import Interrupted, Result, Scene, SceneError, compare, resume, run, sensitivities
from cohesive.scenes.keys import scene_keys
from examples import rubbing
from examples.coulomb import Coulomb
from examples.own_law import Bilinear
from examples.ppr import PPR

ROOT = Path(__file__).parents[1]

BEAM = Scene.load("notched-beam").with_(
    **{"mesh.crack_size": 2.5, "mesh.far_size": 12.0, "stage.0.to": 0.08, "stage.0.steps": 12, "material.law": "my-bilinear"}
)




@pytest.mark.long
def test_a_bilinear_law_is_the_linear_softening_curve_in_both_models() -> None:
    """As long as the crack only opens."""
    own = compare(BEAM)
    printed = compare(BEAM.with_(**{"material.law": "crack-plane", "material.softening": "linear"}))
    for one, other in ((own.discrete, printed.discrete), (own.smeared, printed.smeared)):
        np.testing.assert_allclose(one.history["load"], other.history["load"], rtol=2e-3, atol=1.0)
        assert "law my-bilinear" in one.summary() and "softening" not in one.summary()
    assert abs(own.smeared.peak_load / own.discrete.peak_load - 1.0) < 0.01
    assert own.discrete.history["cohesive_length"].max() > 0


@pytest.mark.parametrize(("to", "steps"), [(0.08, 12), (0.03, 3), (0.03, 8)])
def test_a_balance_that_checks_nothing_says_so(to: float, steps: int) -> None:
    result = run(BEAM.with_(**{"stage.0.to": to, "stage.0.steps": steps}))
    assert np.isnan(result.energy_error) and "not checked" in result.summary()
    assert abs(result.unaccounted).max() < 1e-6 * result.history["work"].max()
    assert result.dissipated_energy > 0 and result.full_energy == pytest.approx(0.07 * 1250.0)


@pytest.mark.long
def test_it_is_saved_loaded_pickled_and_resumed(tmp_path: Path) -> None:
    whole = run(BEAM)

    def stop(step: Any, row: dict[str, float]) -> None:
        if row["step"] == 11:
            raise KeyboardInterrupt

    with pytest.raises(Interrupted):
        run(BEAM, output=tmp_path / "stopped", on_step=stop)
    went_on = resume(tmp_path / "stopped")
    np.testing.assert_array_equal(went_on.history["load"], whole.history["load"])
    whole.save(tmp_path / "saved")
    for again in (Result.load(tmp_path / "saved"), pickle.loads(pickle.dumps(whole))):
        assert again.scene.law == Bilinear(r=0.5) and again.peak_load == whole.peak_load and np.isnan(again.energy_error)


def test_its_derivatives_are_differences() -> None:
    moved = sensitivities(BEAM.with_(**{"law.r": 0.5}), ["material.Gf", "law.r"])
    assert not moved.is_exact
    assert moved["material.Gf"]["load"][-1] > 0 and abs(moved["law.r"]["load"]).max() < 1e-2


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"material.law": "my-bilinea"}, "did you mean 'my-bilinear'"),
        ({"law.q": 1.0}, "law.q: unknown key; expected one of r"),
        ({"law.r": -1.0}, "law.r = -1.0: expected a number above 0"),
        ({"law.r": "a"}, "law.r = 'a': expected a finite number"),
        ({"material.law": "crack-plane", "law.r": 1.0}, "law.r: unknown key; expected none"),
        ({"material.law": "ppr", "model.kind": "smeared"}, "takes no width; expected 'discrete'"),
        ({"material.law": "ppr", "interface.width": 0.1}, "takes no width; expected no such key"),
    ],
)
def test_what_is_wrong_is_said(changes: dict[str, object], said: str) -> None:
    with pytest.raises(SceneError, match=said.replace("(", r"\(")):
        BEAM.with_(**changes)


def test_strength_and_energy_may_be_those_of_the_law() -> None:
    data = BEAM.data
    data["material"] = {"E": 37e3, "nu": 0.2, "law": "ppr"}
    data["law"] = {"Gn": 0.07, "sigma": 3.4}
    scene = Scene(data)
    assert (scene.material.ft, scene.material.Gf, scene.law) == (3.4, 0.07, PPR(Gn=0.07, sigma=3.4))
    assert scene.zone_length == pytest.approx(37e3 * 0.07 / 3.4**2)
    assert 700 < run(scene).peak_load < 1200


def test_keys_of_all_laws_are_listed() -> None:
    own = {key.name: key for key in scene_keys() if key.table == "law"}
    assert {"r", "mu", "Gn"} <= set(own) and own["mu"].range == "at least 0" and "'coulomb'" in own["mu"].meaning
    assert next(key for key in scene_keys() if key.name == "law").default == "crack-plane"


def test_heats_of_damage_and_friction_are_told_apart() -> None:
    """A pressed crack, sheared to and fro: all energies are accounted for, and friction goes on when nothing is damaged."""
    scene = Scene.load("jacobsen-mixed-mode").with_(**{"mesh.crack_size": 8.0, "mesh.far_size": 30.0})
    data = scene.data
    data["material"] |= {"law": "coulomb"}
    data["law"] = {"k": 300.0, "mu": 0.6}
    data["stage"] = [
        {"control": "driven", "to": -0.02, "steps": 4},
        {"control": "driven", "angle": 90.0, "hold": True, "to": [0.3, -0.3, 0.3], "steps": 60},
    ]
    result = run(Scene(data))
    heats = result.history["law.friction_heat"], result.history["law.damage_heat"]
    area = result.facts.crack_area
    assert area is not None
    np.testing.assert_allclose(area * (heats[0] + heats[1]), result.history["dissipated"], rtol=1e-9, atol=1e-9)
    assert heats[0][-1] > heats[1][-1] > 0 and result.energy_error < 0.05
    assert (np.diff(heats[0]) >= -1e-12).all() and np.ptp(heats[1][-60:]) < 1e-9 * heats[1][-1]
    assert set(Coulomb.columns) == {"damage_heat", "friction_heat"}


@pytest.mark.long
def test_a_script_is_a_command_line(tmp_path: Path) -> None:
    """`python own_law.py run scene.toml`: the file with the law, copied out of the package."""
    source = (ROOT / "examples" / "own_law.py").read_text(encoding="utf-8")
    (tmp_path / "own_law.py").write_text(source, encoding="utf-8")
    run(BEAM.with_(**{"output.frames": 1})).save(tmp_path / "from")

    def call(*words: str) -> str:
        command = [sys.executable, "own_law.py", *words]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=300)
        assert done.returncode == 0, done.stderr
        return done.stdout

    assert "law my-bilinear" in call("run", "from/scene.toml", "-o", "out")
    assert "report.html" in call("report", "out")
    assert "run-2" in call("sweep", "from/scene.toml", "--vary", "law.r=0.4,0.8", "-o", "sweep")


def test_the_printed_law_slides_back_and_friction_does_not() -> None:
    work = rubbing.main(points=60)
    assert abs(work["printed contact"]) < 1e-9
    slides = 0.5 * 1.5  # mu times the pressure
    assert work["Coulomb friction"] == pytest.approx(4.0 * slides * (0.3 - slides / 150.0), rel=0.03)
