"""Settings for an accuracy, from stored trades."""

from __future__ import annotations

import copy
import json
from dataclasses import replace
from pathlib import Path

import pytest

from cohesive import Scene, SceneError, run
from cohesive.commands.command_line import main
from cohesive.model.estimate import estimate
from cohesive.scenes.scene import dump_toml
from cohesive.studies.accuracy import parse, settings_for, stored
from cohesive.studies.curves import curve_of
from cohesive.studies.parameters import changes
from cohesive.studies.trade import Trade
from cohesive.studies.trials import ERRORS, Cost, SweepSetting, errors
from tests.builders import OF_A_FILE

BEAM = Scene.load("notched-beam").with_(**{"mesh.crack_size": 1.0, "mesh.far_size": 8.0})
BARE = Scene({key: value for key, value in BEAM.data.items() if key != "reference"})


def made(scene: Scene) -> Trade:
    """A trade of three settings: 4 % in 1 s, 0.8 % in 2 s, 0.3 % in 9 s; the reference is known to 0.1 %."""

    def one(error: float, cpu: float, settings: dict[str, object]) -> SweepSetting:
        errors = dict.fromkeys(("peak", "at_peak", "energy", "curve_distance"), error)
        return SweepSetting(settings, errors, Cost(cpu, cpu, 100.0, 10))

    trials = [one(0.008, 2.0, {}), one(0.04, 1.0, {"steps": 0.5}), one(0.003, 9.0, {"crack size": 0.5})]
    return Trade(scene, {"peak": 1.0, "at_peak": 1.0, "energy": 1.0}, 0.001, trials)


@pytest.mark.parametrize(
    ("text", "value"), [("1%", 0.01), ("0.01", 0.01), (" 0.5 % ", 0.005), (0.002, 0.002), ("1e-3", 0.001)]
)
def test_accuracies(text: str | float, value: float) -> None:
    assert parse(text) == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize("text", ["banana", "0", "-1%", "200%", "100%", "1", "nan", "inf%", "", "%", "1%%", 5])
def test_other_accuracies_are_refused(text: str | float) -> None:
    with pytest.raises(SceneError, match=r"expected a percentage or a part of 1, above 0 and below 100 %, as 1% or 0\.01"):
        parse(text)


def test_the_stored_trades_are_those_of_the_scenes_as_they_are() -> None:
    tables = stored()
    assert {"notched-beam", "notched-beam-smeared", "jacobsen-mixed-mode"} <= set(tables)
    for name, trade in tables.items():
        scene = Scene.load(name.removesuffix("-smeared"))
        if name.endswith("-smeared"):
            scene = scene.with_(**{"model.kind": "smeared"})
        data = {key: value for key, value in scene.data.items() if key not in ("reference", "output")}
        data["model"] = data.get("model", {}) | {"kind": scene.model.kind}
        stored_data = trade.scene.data | {"model": trade.scene.data.get("model", {}) | {"kind": trade.scene.model.kind}}
        assert stored_data == data, f"renew {name}: cohesive trade"
        for accuracy in (0.05, 0.01):
            settings_for(scene, accuracy)


def test_a_table_of_its_own_comes_first(tmp_path: Path) -> None:
    made(BARE).save(tmp_path)
    choice = settings_for(BEAM, "5%", tmp_path / "trade.csv")
    assert choice.changes == {"stage.0.steps": 30} and choice.promised == pytest.approx(0.041)
    assert f"measured on this scene, {tmp_path}" in choice.text and "stage.0.steps = 30" in choice.text
    finer = BEAM.with_(**{"mesh.crack_size": 2.0, "stage.0.steps": 9, "solver.tol": 1e-3})  # the same problem, other settings
    assert settings_for(finer, 0.01, tmp_path / "trade.csv").changes == {
        "mesh.crack_size": 1.0, "stage.0.steps": 60, "solver.tol": 1e-4,
    }  # fmt: skip


def test_where_no_setting_is_accurate_enough_the_best_is_taken_and_it_is_said(tmp_path: Path) -> None:
    made(BARE).save(tmp_path)
    choice = settings_for(BEAM, "0.2%", tmp_path / "trade.csv")
    assert "no setting reaches it, the most accurate one is taken" in choice.text
    assert choice.changes == {"mesh.crack_size": 0.5} and choice.promised == pytest.approx(0.004)


def test_the_price_is_named_and_the_place_of_the_peak(tmp_path: Path) -> None:
    made(BARE).save(tmp_path)
    choice = settings_for(BEAM, "5%", tmp_path / "trade.csv")
    expected = estimate(BEAM.with_(**choice.changes))
    assert expected is not None and choice.seconds == expected.seconds and f"it takes about {expected.time}" in choice.text
    assert choice.promised_place == pytest.approx(0.04) and "the place of the peak to 4 %" in choice.text
    finer = replace(made(BARE), trials=[*made(BARE).trials, SweepSetting({"finer": 2.0}, dict.fromkeys(ERRORS, 0.002))])
    assert finer.promised_place(finer.trials[1]) == pytest.approx(0.042)
    assert finer.promised_place(finer.trials[1], elsewhere=True) == pytest.approx(0.122)
    assert finer.promised_place(finer.trials[3]) == 0.01  # no cubic tells it better


def test_settings_of_hours_are_not_taken_and_it_is_said_what_would_take_them(tmp_path: Path) -> None:
    trade = made(BARE)
    trade.trials.append(SweepSetting({"crack size": 1e-4}, dict.fromkeys(ERRORS, 1e-4), Cost(5e4, 5e4, 1e5, 10)))
    trade.save(tmp_path)
    choice = settings_for(BEAM, "0.2%", tmp_path / "trade.csv")
    assert "crack size x 0.0001 would take " in choice.text
    assert " h, the most accurate one within an hour is taken" in choice.text
    assert choice.changes == {"mesh.crack_size": 0.5} and choice.promised == pytest.approx(0.004) and choice.seconds < 10.0
    assert settings_for(BEAM, "1%", tmp_path / "trade.csv").changes == {}  # others reach it


def test_a_table_of_another_version_is_left_aside_and_it_is_said(tmp_path: Path) -> None:
    made(BARE).save(tmp_path)
    other = BEAM.with_(**{"material.Gf": 0.08})
    choice = settings_for(other, "5%", tmp_path / "trade.csv")
    assert "is of another version of this scene (other material) and left aside" in choice.text
    assert "carried over from the stored trade of notched-beam, not measured on this scene" in choice.text
    with pytest.raises(SceneError, match="not a table of this version of `cohesive trade`"):
        (tmp_path / "trade.csv").write_text("setting,error\nas it is,0.1\n")
        settings_for(BEAM, 0.01, tmp_path / "trade.csv")


def test_the_nearest_scene_lends_its_table() -> None:
    def lender(scene: Scene) -> str:
        return settings_for(scene, 0.05).text.split("stored trade of ")[1].split()[0].rstrip("),:")

    assert lender(BEAM.with_(**{"specimen.notch": 10.0})) == "notched-beam"
    assert lender(BEAM.with_(**{"specimen.notch": 10.0, "model.kind": "smeared"})) == "notched-beam-smeared"
    plate = Scene.load("jacobsen-mixed-mode").with_(**{"specimen.notch": 40.0})
    assert lender(plate) == "jacobsen-mixed-mode"
    cyclic = Scene.load("reinhardt-cyclic")  # both are notched plates; one of them is loaded in cycles
    tension = Scene.load("notched-tension")
    assert lender(cyclic.with_(**{"specimen.notch": 8.0})) == "reinhardt-cyclic"
    assert lender(tension.with_(**{"specimen.notch": 8.0})) == "notched-tension"
    growing = {"specimen.notch": 8.0, "stage": [{"control": "opening", "to": [0.02, 0.3]}]}  # in no cycles
    assert lender(tension.with_(**growing)) == "notched-tension"


def test_settings_are_carried_over_as_the_knobs_say() -> None:
    twice = BEAM.with_(**{"specimen.depth": 100.0, "specimen.notch": 50.0, "mesh.crack_size": 3.0})
    table = stored()["notched-beam"]
    best = table.cheapest(0.01, elsewhere=True)
    assert best is not None
    choice = settings_for(twice, 0.01)
    assert choice.changes == changes(twice, best.settings, table.scene) and choice.changes["mesh.crack_size"] <= 2.0
    assert choice.promised == table.promise(best, elsewhere=True) > 2.0 * best.error


def test_a_mesh_of_the_users_has_no_sizes(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="a user mesh has no sizes to choose"):
        settings_for(Scene(OF_A_FILE, tmp_path), 0.01)


@pytest.mark.long
def test_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    mine = BARE.with_(**{"material.Gf": 0.06, "mesh.crack_size": 2.5, "mesh.far_size": 12.5, "stage.0.steps": 20})
    (tmp_path / "my.toml").write_text(dump_toml(mine.data))
    made(mine).save("my-trade")
    assert main(["run", "my.toml", "--accuracy", "5%"]) == 0
    out = capsys.readouterr().out
    note = out.splitlines()[0]
    assert note.startswith("accuracy 5 %: steps x 0.5, which promises 4.1 % (measured on this scene, my-trade/trade.csv)")
    facts = json.loads((tmp_path / "my" / "run.json").read_text())
    assert facts["notes"][0] == note and facts["steps"] == 10
    assert out.count(note) == 2  # before the run, and in its summary
    assert main(["run", "my.toml", "--accuracy", "5%", "--set", "stage.0.steps=40"]) == 2
    assert "--set stage.0.steps: --accuracy chooses it" in capsys.readouterr().err
    assert main(["run", "my.toml", "--accuracy", "banana"]) == 2
    err = capsys.readouterr().err
    assert err.startswith("cohesive: accuracy banana: expected a percentage") and len(err.splitlines()) == 1


@pytest.mark.parametrize(
    ("scale", "Gf"),
    [pytest.param(1.0, 0.07, marks=pytest.mark.long), pytest.param(8.0, 0.07, marks=pytest.mark.long), (1.0, 0.01)],
)
def test_default_element_sizes_cost_less_than_one_percent(scale: float, Gf: float) -> None:
    """The beam at E Gf / ft^2 of 9, 1.1 and 1.3 times its ligament, against elements of a quarter of the size."""
    data = copy.deepcopy(Scene.load("notched-beam").data)
    del data["reference"]
    for name in ("length", "span", "depth", "notch", "gauge"):
        data["specimen"][name] *= scale
    data["material"]["Gf"] = Gf
    data["stage"][0]["to"] = 0.18 * scale**0.5 * (Gf / 0.07) ** 0.75
    scene = Scene(data)
    assert scene.sizes is not None
    assert scene.sizes.crack_size == pytest.approx(25.0 * scale / 20.0)  # the ligament over 20: the zone is longer
    assert scene.sizes.far_size == 8.0 * scene.sizes.crack_size
    fine = scene.with_(**{"mesh.crack_size": scene.sizes.crack_size / 4, "mesh.far_size": scene.sizes.far_size / 4})
    differences = errors(curve_of(run(scene)), curve_of(run(fine)))
    assert max(differences["peak"], differences["energy"], differences["curve_distance"]) < 0.01


def test_default_elements_divide_the_process_zone_too() -> None:
    brittle = Scene.load("notched-beam").with_(**{"material.Gf": 0.001, "mesh": {}})
    assert brittle.sizes is not None
    assert brittle.sizes.crack_size == pytest.approx(brittle.material.characteristic_length / 12)


def test_a_solid_borrows_from_its_own_kind() -> None:
    beam = Scene.load("notched-beam-3d")
    choice = settings_for(beam.with_(**{"specimen.thickness": 100.0, "mesh.layers": 8}), "10%")
    assert "carried over from the stored trade of notched-beam-3d" in choice.text
    assert choice.changes["model.half"] is True
    assert choice.changes["mesh.layers"] == 4  # half of its own; a stored number would be that of the beam there
