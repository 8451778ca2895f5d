"""Loads and supports: several drives, opposed forces, supports that give way, own weight, pressures, elastic regions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest

from cohesive import NotConverged, Result, Scene, run, sensitivities
from cohesive.fitting.repeated_run import value_of
from cohesive.model.build import build
from cohesive.solver.problem import State
from cohesive.solver.stepper import solve
from meshing.specimens import SPECIMENS, Drive, MixedModePlate
from tests.builders import assert_refused, assert_same_history, coarse_beam, grid, plate


@pytest.fixture(autouse=True)
def registered(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(SPECIMENS, "plate-of-two-drives", TwoDrives)


@dataclass(frozen=True)
class TwoDrives(MixedModePlate):
    """The plate whose platen is moved by two drives."""

    def drives(self, *, half: bool = False) -> Mapping[str, Drive]:
        return {"pull": Drive("top", (0.0, 1.0)), "shear": Drive("top", (1.0, 0.0))}


#: squares of 10 mm, 4 x 6, the crack half way up
MATERIAL = {"E": 30000.0, "nu": 0.0, "ft": 3.0, "Gf": 0.1}
WIDTH, HEIGHT, THICKNESS = 40.0, 60.0, 10.0


def own(folder: Path, kind: str = "quad", **changes: Any) -> Scene:
    """A plate of 40 x 60 x 10 mm on a user mesh, cracked at mid-height, pulled up."""
    mesh = grid(4, 6, kind)
    points, x, y = 10.0 * mesh.points, 10.0 * mesh.points[:, 0], 10.0 * mesh.points[:, 1]
    centre = points[mesh.cells[0].data].mean(axis=1)
    sets = {
        "base": y == 0, "top": y == HEIGHT, "left": x == 0, "right": x == WIDTH, "one": (y == 30) & (x <= 20),
        "two": (y == 30) & (x >= 20), "corner": (x == 0) & (y == 0),
    }  # fmt: skip
    meshio.Mesh(
        np.column_stack([points, 0 * x]),
        mesh.cells,
        point_sets={name: np.flatnonzero(at) for name, at in sets.items()},
        cell_sets={"platen": [np.flatnonzero(centre[:, 1] > 50)], "soft": [np.flatnonzero(centre[:, 1] < 10)]},
    ).write(folder / "own.inp", file_format="abaqus")
    data: dict[str, Any] = {
        "specimen": {
            "kind": "mesh", "file": "own.inp", "thickness": THICKNESS, "crack": [[0, 30], [40, 30]],
            "supports": [
                {"at": "base", "direction": [0, 1]},
                {"at": [20, 0], "direction": [1, 0]},
                {"at": [20, 60], "direction": [1, 0]},
            ],
            "drive": {"at": "top", "direction": [0, 1]}, "gauge_minus": "base", "gauge_plus": "top",
        },
        "material": MATERIAL,
        "solver": {"tol": 1e-11},
        "stage": [{"control": "opening", "to": 0.02, "steps": 10}],
    }  # fmt: skip
    return Scene(data, folder).with_(**{key.replace("__", "."): value for key, value in changes.items()})


def elastic(folder: Path, **changes: Any) -> Result:
    """Its one elastic step of 1 kN, unless changes say otherwise."""
    return run(own(folder, **{"stage": [{"control": "load", "to": 1000.0, "steps": 1}]} | changes))


@pytest.mark.parametrize("model", ["discrete", "smeared"])
def test_two_drives_held_and_moved_are_a_platen_at_an_angle(model: str) -> None:
    """Sheared while the pull is held at its motion: the platen held across, which moves at 90 degrees."""
    stages = [{"control": "driven", "to": 0.012, "steps": 6}, {"control": "driven", "angle": 90.0, "to": 0.01, "steps": 5}]
    one = run(plate(stage=stages, **{"solver.tol": 1e-11}), model)
    stages = [
        {"control": "driven", "others": {"shear": "motion"}, "to": 0.012, "steps": 6},
        {"control": "driven", "drive": "shear", "others": {"pull": "motion"}, "to": 0.01, "steps": 5},
    ]
    two = run(plate(stage=stages, **{"solver.tol": 1e-11, "specimen.kind": "plate-of-two-drives"}), model)
    assert one.history["dissipated"][-1] > 0.1 * one.history["work"][-1]
    assert_same_history(two, one, 1e-8)  # the same equations, their unknowns in another order


def test_a_force_that_is_held_stays_and_does_its_work() -> None:
    stages = [
        {"control": "load", "drive": "shear", "to": 2000.0, "steps": 2},
        {"control": "opening", "drive": "pull", "to": 0.03, "steps": 60},
    ]
    result = run(plate(stage=stages, **{"specimen.kind": "plate-of-two-drives", "solver.tol": 1e-9}))
    h, later = result.history, result.history["stage"] == 2
    np.testing.assert_allclose(h["load.shear"][later], 2000.0, rtol=1e-6)
    np.testing.assert_allclose(h["load.pull"][later], h["load"][later], rtol=1e-6)
    np.testing.assert_allclose(h["driven.pull"][later], h["driven"][later], rtol=1e-12)
    assert h["driven.shear"][-1] > 1.5 * h["driven.shear"][2]  # it slides as the plate opens
    assert result.energy_error < 5e-3  # of the step over the onset; without the work of the shear force it is far above
    share = 2000.0 * (h["driven.shear"][-1] - h["driven.shear"][2])
    assert share > 2e-2 * h["work"][-1]


def test_a_force_that_is_let_go_is_gone() -> None:
    stages = [
        {"control": "load", "drive": "shear", "to": 2000.0, "steps": 2},
        {"control": "load", "drive": "pull", "others": {"shear": "free"}, "to": 1000.0, "steps": 2},
    ]
    result = run(plate(stage=stages, **{"specimen.kind": "plate-of-two-drives", "solver.tol": 1e-9}))
    assert abs(result.history["load.shear"][-1]) < 1e-3
    assert any("lets go of 2000 N of drive 'shear'" in note for note in result.notes)


def test_drives_that_there_are_not_are_refused() -> None:
    two = plate(**{"specimen.kind": "plate-of-two-drives"})
    for stage, message in (
        ({"drive": "push"}, r"stage.0.drive: the specimen has no drive 'push'; it has pull, shear"),
        ({"others": {"push": "free"}}, r"stage.0.others: the specimen has no drive 'push'"),
        ({"others": {"pull": "free"}}, r"stage.0.others: the stage moves drive 'pull' itself"),
        ({"others": {"shear": "still"}}, r"stage.0.others = .*expected \{name of a drive = 'force' or 'motion' or 'free'\}"),
        ({"angle": 90.0}, r"stage.0.angle = 90.0: this specimen is driven in one direction"),
    ):
        with pytest.raises(Exception, match=message):
            run(two.with_(stage=[{"control": "driven", "to": 0.01, "steps": 1} | stage]))


def test_opposed_forces_move_two_places_apart(tmp_path: Path) -> None:
    """Pulled at both ends and held at neither along the pull: as pulled at one end and held at the other."""
    one = run(own(tmp_path))
    supports = [
        {"at": [0, 20], "direction": [0, 1]},
        {"at": [20, 0], "direction": [1, 0]},
        {"at": [20, 60], "direction": [1, 0]},
    ]
    pair = {"at": "top", "against": "base", "direction": [0, 1]}
    two = run(own(tmp_path, specimen__supports=supports, specimen__drive=pair))
    assert_same_history(two, one, 1e-8, ("load", "opening", "driven", "work", "elastic", "dissipated"))


def test_a_support_gives_way_by_its_load_over_its_stiffness(tmp_path: Path) -> None:
    stiff = elastic(tmp_path)
    supports = own(tmp_path).data["specimen"]["supports"]
    soft = elastic(tmp_path, specimen__supports=[supports[0] | {"stiffness": 2e4}, *supports[1:]])
    assert soft.history["driven"][1] - stiff.history["driven"][1] == pytest.approx(1000.0 / 2e4, rel=1e-9)
    assert soft.history["opening"][1] == pytest.approx(stiff.history["opening"][1], rel=1e-9)
    assert soft.energy_error < 1e-9  # its energy is among the elastic one


def test_a_region_has_its_own_modulus(tmp_path: Path) -> None:
    """Without lateral strain, compliances add up: 10 mm of a tenth of the modulus, 10 mm of the tenfold."""
    plain, same = elastic(tmp_path), elastic(tmp_path, specimen__regions={"soft": {"E": 30000.0, "nu": 0.0}})
    assert_same_history(same, plain, 1e-12, ("load", "driven", "work"))
    mixed = elastic(tmp_path, specimen__regions={"soft": {"E": 3000.0, "nu": 0.0}, "platen": {"E": 3e5, "nu": 0.0}})
    added = 1000.0 / (WIDTH * THICKNESS) * 10.0 * (1 / 3000.0 + 1 / 3e5 - 2 / 30000.0)
    assert mixed.history["driven"][1] - plain.history["driven"][1] == pytest.approx(added, rel=1e-9)


def test_a_region_never_cracks(tmp_path: Path) -> None:
    """Everywhere else may: the soft layer takes its strain without."""
    scene = own(
        tmp_path, specimen__regions={"soft": {"E": 3000.0, "nu": 0.0}}, model__kind="smeared", band__where="everywhere"
    )
    model = build(scene)
    assert [len(block.cells) for block in (*model.bulk, *model.band)] == [4, 20]
    assert model.bulk[0].D[0, 0, 0] == pytest.approx(3000.0)
    assert run(scene.with_(**{"solver.tol": 1e-4})).peak_load == pytest.approx(3.0 * WIDTH * THICKNESS, rel=0.02)


def test_what_a_region_cannot_be(tmp_path: Path) -> None:
    for regions, message in (
        (
            {"steel": {"E": 2e5, "nu": 0.3}},
            r"^specimen.regions.steel: the file has no such set of elements; it has platen, soft",
        ),
        ({"soft": {"E": 2e5}}, r"^specimen.regions.soft = .*expected \{E = ..., nu = ...\}"),
        ({"soft": {"E": 0.0, "nu": 0.3}}, r"^specimen.regions.soft.E = 0.0: expected a number above 0, in MPa"),
        ({"soft": {"E": 1.0, "nu": 0.5}}, r"^specimen.regions.soft.nu = 0.5: expected"),
    ):
        with pytest.raises(Exception, match=message):
            elastic(tmp_path, specimen__regions=regions)


def test_derivatives_start_from_the_body_under_pressure(tmp_path: Path) -> None:
    """Pulled by a pressure, which is a number as others are."""
    scene = own(tmp_path, specimen__pressures=[{"at": "top", "value": -1.5}], stage__0__steps=5, solver__tol=1e-12)
    keys = ["material.E", "material.ft", "material.Gf", "specimen.pressures.0.value"]
    derivatives = sensitivities(scene, keys)
    assert derivatives.is_exact
    for key in keys:
        value = value_of(scene, key)
        half = 1e-5 * abs(value)
        low, high = (run(scene.with_(**{key: value + by})).history for by in (-half, half))
        for name in ("load", "stress_n", "work", "elastic", "dissipated"):
            wanted = (high[name] - low[name])[1:] / (2.0 * half)
            scale = abs(wanted).max()
            # rounding of the runs, 1e-12 over a change of 2e-5, and its square
            np.testing.assert_allclose(derivatives[key][name], wanted, atol=1e-6 * scale, err_msg=f"{key} {name}")


@pytest.mark.parametrize("kind", ["quad", "triangle6"])
def test_pressure_on_faces_is_the_traction_on_the_crack(kind: str, tmp_path: Path) -> None:
    """2 MPa on both ends press the crack: the way there is row 0, from which motions count."""
    changes: dict[str, Any] = {
        "specimen__pressures": [{"at": "top", "value": 2.0}],
        "stage": [{"control": "load", "to": 1.0 * WIDTH * THICKNESS, "steps": 1}],
    }
    result = run(own(tmp_path, kind, **changes))
    start = result.row(0)
    assert start["stress_n"] == pytest.approx(-2.0, rel=1e-6)
    assert start["opening"] == 0.0 and abs(result.crack(0)["opening"]).max() > 0
    assert result.history["stress_n"][1] == pytest.approx(-1.0, rel=1e-6)
    width = result.width
    shortened = 1.0 * (HEIGHT / 30000.0 + width / 30000.0)
    assert result.history["driven"][1] == pytest.approx(shortened, rel=1e-6)
    assert result.energy_error < 1e-9


def under_dead_loads(scene: Scene) -> State:
    """The state from which motions count."""
    model = build(scene)
    return solve(model.problem, scene.stages, model.recorded).problem.initial()


def test_weight_is_borne_by_the_supports(tmp_path: Path) -> None:
    supports = own(tmp_path).data["specimen"]["supports"]
    scene = own(tmp_path, specimen__supports=[supports[0] | {"stiffness": 1e4}, *supports[1:]], material__density=1e6)
    start = under_dead_loads(scene)
    weight = 1e6 * 9.80665e-9 * WIDTH * HEIGHT * THICKNESS
    problem = build(scene).problem
    assert float(start.v[problem.drives[1]]) == pytest.approx(-weight / 1e4, rel=1e-9)
    assert start.work == pytest.approx(start.elastic + start.stored, rel=1e-9)  # half of force times way, all of it stored
    lying = under_dead_loads(scene.with_(**{"specimen.down": [1.0, 0.0]}))
    assert float(lying.v[problem.drives[1]]) == pytest.approx(0.0, abs=1e-3 * weight / 1e4)


@pytest.mark.parametrize(("model", "half"), [("discrete", False), ("discrete", True), ("smeared", False)])
def test_weight_takes_its_moment_from_the_load(model: str, half: bool) -> None:
    """A beam of length L over a span S: the moment of q, q (S^2/8 - (L - S)^2/8), is that of a load less at mid-span."""
    bare = coarse_beam("notched-beam", "stress", **{"model.half": half, "stage.0.to": 0.03, "stage.0.steps": 30})
    s = bare.specimen
    q = 1e-9 * 9.80665 * 4e4 * s.depth * s.thickness  # a heavy concrete, so that it counts
    over = (s.length - s.span) / 2
    less = 4 * (q * s.span**2 / 8 - q * over**2 / 2) / s.span
    one, other = run(bare, model), run(bare.with_(**{"material.density": 4e4}), model)
    assert less > 0.03 * one.peak_load
    at_equal_opening = [float(np.interp(0.02, each.history["opening"], each.history["load"])) for each in (one, other)]
    assert at_equal_opening[0] - at_equal_opening[1] == pytest.approx(less, rel=0.05)  # less bending at a point load
    assert other.energy_error < 2 * one.energy_error + 1e-6


def test_condensed_or_not_weight_is_the_same() -> None:
    scene = coarse_beam("notched-beam", "stress", **{"material.density": 2e4, "stage.0.to": 0.03})
    assert_same_history(run(scene), run(scene.with_(**{"solver.condensation": "never"})), 1e-8)


@pytest.mark.long
def test_a_body_that_does_not_bear_its_weight_says_so() -> None:
    with pytest.raises(NotConverged, match="the body does not bear its dead loads"):
        run(coarse_beam("notched-beam", "stress", **{"material.density": 1e6}))


def test_a_crack_of_several_sets_is_one_crack(tmp_path: Path) -> None:
    one, two = run(own(tmp_path)), run(own(tmp_path, specimen__crack=["one", "two"]))
    assert_same_history(two, one, 1e-9, ("load", "opening", "driven", "work", "dissipated"))
    assert_refused(own(tmp_path, specimen__crack=["one", "three"]), r"^specimen.crack = 'three': the file has no such set")


def test_what_a_users_drive_cannot_be(tmp_path: Path) -> None:
    one = {"name": "pull", "at": "top", "direction": [0, 1]}
    for changes, message in (
        ({"specimen__drives": [one]}, r"^specimen.drive, drives: expected one of these keys"),
        ({"specimen__drive": None, "specimen__drives": [one, one]}, r"^specimen.drives.name = 'pull': expected a name of"),
        (
            {"specimen__drive": None, "specimen__drives": [{"at": "top"}]},
            r"^specimen.drives = .*expected \{name = ..., at = ...",
        ),
        (
            {"specimen__drive": {"at": "top", "against": "top", "direction": [0, 1]}},
            r"^specimen.drive.against = 'top': expected",
        ),
        (
            {"specimen__pressures": [{"at": "corner", "value": 1.0}]},
            r"^specimen.pressures.at = 'corner': no face of the body has",
        ),
        (
            {"specimen__pressures": [{"at": "none", "value": 1.0}]},
            r"^specimen.pressures.at = 'none': the mesh has no such set",
        ),
    ):
        with pytest.raises(Exception, match=message):
            run(own(tmp_path, **changes))
