"""The trade of accuracy against cost."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from itertools import pairwise
from pathlib import Path

import pytest

from cohesive import Result, Scene, SceneError, run
from cohesive.commands.command_line import main
from cohesive.studies.curves import curve_of
from cohesive.studies.parameters import SETTINGS, changes
from cohesive.studies.trade import Cost, SweepSetting, Trade, combined, finest, trade
from cohesive.studies.trials import MEASURES, errors
from tests.builders import OF_A_FILE

CHANGES = {"mesh.crack_size": 5.0, "mesh.far_size": 15.0, "stage.0.steps": 16}


@pytest.fixture
def pool(once: None) -> Iterator[Executor]:
    """Trials share the process: their memory is not their own, the rest is."""
    with ThreadPoolExecutor(1) as executor:
        yield executor


def secant_finds_the_same(scene: Scene) -> Result:
    """The same equations, solved to a tolerance of 1e-4 of the peak, and as far from it with linear convergence."""
    newton, secant = (run(scene, tangent=tangent) for tangent in ("consistent", "secant"))
    apart = errors(curve_of(secant), curve_of(newton))
    assert max(apart[name] for name in MEASURES) < 1e-3
    return secant


@pytest.mark.long
def test_errors_fall_with_the_settings(pool: Executor, tmp_path: Path) -> None:
    seen: list[SweepSetting] = []
    traded = trade(Scene.load("notched-beam").with_(**(CHANGES | {"mesh.order": 1, "stage.0.steps": 40})), pool, seen.append)
    assert {id(trial) for trial in seen} == {id(trial) for trial in traded.trials} and traded.trials[0].settings == {}
    error = {trial.label: trial.error for trial in traded.trials}
    assert min(error["crack size x 4"], error["crack size x 2"]) > error["as it is"] > error["crack size x 0.5"]
    assert error["steps x 0.25"] > error["as it is"]
    # exact: the condensation, and half of a symmetric body but for its mesh
    assert abs(error["condensation never"] - error["as it is"]) < 1e-4
    assert error["finer x 4"] == 0.0 and error["finer x 2"] == traded.own_error
    iterations = {trial.label: trial.cost.iterations for trial in traded.trials if trial.cost}
    assert secant_finds_the_same(traded.scene).iterations > 3 * iterations["as it is"]
    assert 0 < traded.own_error < 0.5 * error["as it is"]
    front = traded.pareto_front()
    assert all(a.cost.cpu <= b.cost.cpu and a.error > b.error for a, b in pairwise(front))  # type: ignore[union-attr]
    best = traded.cheapest(0.05)
    assert best is not None and best.error + traded.own_error <= 0.05 and best.is_same_problem
    assert all(
        best.cost.cpu <= 1.2 * t.cost.cpu for t in traded.trials if t.cost and t.is_same_problem and traded.promise(t) <= 0.05
    )  # type: ignore[union-attr]
    traded.scene.with_(**changes(traded.scene, best.settings))  # its settings are keys of a scene
    traded.save(tmp_path)
    again = Trade.load(tmp_path / "trade.csv")
    assert again.scene.data == traded.scene.data and again.own_error == traded.own_error
    assert [trial.settings for trial in again.trials] == [trial.settings for trial in traded.trials]
    assert again.cheapest(0.05).settings == best.settings  # type: ignore[union-attr]
    rows = table(tmp_path)
    assert [row["setting"] for row in rows] == [trial.label for trial in traded.trials]
    assert float(rows[0]["error"]) == pytest.approx(traded.trials[0].error, rel=1e-4)
    assert (tmp_path / "trade.png").stat().st_size > 1e4 and "cheapest for 1 %" in (tmp_path / "trade.txt").read_text()


@pytest.mark.parametrize("name", ["notched-beam-3d", "single-crack-3d"])
@pytest.mark.long
def test_a_trade_in_3d(name: str, pool: Executor) -> None:
    sizes = {"mesh.crack_size": 5.0, "mesh.far_size": 20.0, "mesh.layers": 2, "stage.0.steps": 16}
    if name == "single-crack-3d":
        sizes = {"mesh.crack_size": 20.0, "mesh.far_size": 25.0, "stage.0.steps": 4, "stage.0.to": 0.03}
    traded = trade(Scene.load(name).with_(**sizes), pool, settings=["crack size", "layers"])
    error = {trial.label: trial.error for trial in traded.trials}
    assert error["finer x 2.5"] == 0.0 and error["finer x 1.25"] == traded.own_error
    # five elements along a crack let go one by one, and four steps over a snap are as they come
    assert traded.own_error < 1.5 * error["as it is"] or name == "single-crack-3d"
    secant_finds_the_same(traded.scene)
    assert ("layers x 0.5" in error) == (name == "notched-beam-3d")
    assert not any(trial.failure for trial in traded.trials if trial.is_same_problem)


def test_a_body_with_a_large_crack_gets_a_reference_that_can_be_paid() -> None:
    beam = Scene.load("notched-beam-3d")
    assert finest(Scene.load("notched-beam")) == 4.0
    # 25 mm of crack with 4 layers: 50, 100 and 250 elements for 350 would be 2.6, 1.9 and 1.2 times finer
    for keys, factor in (({}, 2.5), ({"mesh.crack_size": 1.0}, 1.9), ({"mesh.crack_size": 1.0, "mesh.layers": 10}, 1.5)):
        assert finest(beam.with_(**keys)) == factor


def test_combinations_take_the_cheapest_value_of_each_knob_that_errs_little() -> None:
    def one(error: float, cpu: float, **settings: object) -> SweepSetting:
        errors = {"peak": error, "energy": 0.0, "curve_distance": 0.0}
        named = {name.replace("_", " "): value for name, value in settings.items()}
        return SweepSetting(named, errors, Cost(cpu, cpu, 100.0, 10))

    trials = [
        one(0.003, 1.0),
        one(0.005, 0.6, steps=0.5),
        one(0.0034, 0.8, steps=0.75),
        one(0.013, 0.4, steps=0.25),
        one(0.002, 0.7, crack_size=2.0),  # errors that cancel
        one(0.003, 0.99, tolerance=0.01),  # not worth it
        one(0.003, 2.0, width=4.0),  # dearer
        one(0.003, 0.1, model="discrete"),  # another physics
        SweepSetting({"half": True}, failure="no"),
    ]
    finer = [one(0.001, 3.0, finer=2.0), one(0.0, 9.0, finer=4.0)]
    assert combined(trials, 0.001, finer) == [
        {"steps": 0.25, "crack size": 2.0},  # 5 %
        {"steps": 0.5, "crack size": 2.0},  # 1 %
        {"finer": 2.0, "steps": 0.75, "crack size": 2.0},  # 0.2 %, which the scene as it is does not reach
    ]
    assert combined(trials, 0.003, finer) == [{"steps": 0.25, "crack size": 2.0}, {"steps": 0.5, "crack size": 2.0}]


def test_a_setting_that_fails_is_a_row_with_its_reason() -> None:
    scene = Scene.load("notched-beam")
    good = SweepSetting({}, {"peak": 0.0, "energy": 0.001, "curve_distance": 0.002}, Cost(1.0, 1.0, 100.0, 10))
    bad = SweepSetting({"half": True}, failure="no convergence")
    traded = Trade(scene, {"peak": 1.0, "at_peak": 1.0, "energy": 1.0}, 1e-3, [good, bad])
    assert bad.error == float("inf") and traded.pareto_front() == [good]
    assert "half" in traded.summary() and "failed: no convergence" in traded.summary()
    assert traded.cheapest(0.01) is good and traded.cheapest(0.002) is None


def test_another_problem_is_no_cheap_setting() -> None:
    errors = {"peak": 0.001, "energy": 0.0, "curve_distance": 0.0}
    base, other = (SweepSetting(s, errors, Cost(c, c, 100.0, 10)) for s, c in (({}, 1.0), ({"model": "discrete"}, 0.1)))
    traded = Trade(Scene.load("notched-beam"), {"peak": 1.0, "at_peak": 1.0, "energy": 1.0}, 1e-3, [base, other])
    assert traded.cheapest(0.01) is base and traded.pareto_front() == [base]
    assert "model discrete" in traded.summary()


def test_on_another_scene_errors_may_not_cancel() -> None:
    def one(error: float, **settings: object) -> SweepSetting:
        errors = {"peak": error, "energy": 0.0, "curve_distance": 0.0}
        return SweepSetting(settings, errors, Cost(1.0, 1.0, 100.0, 10))

    trials = [
        one(0.003), one(0.005, steps=0.5), one(0.009, order=2), one(0.002, condensation="never"),
        one(0.004, steps=0.5, order=2), one(0.002, finer=2.0), one(0.0, finer=2.0, steps=0.5),
    ]  # fmt: skip
    traded = Trade(Scene.load("notched-beam"), {"peak": 1.0, "at_peak": 1.0, "energy": 1.0}, 1e-3, trials)
    assert [traded.promise(trial) for trial in trials] == pytest.approx([0.004, 0.006, 0.010, 0.003, 0.005, 0.003, 0.001])
    elsewhere = [0.003, 0.005, 0.009, 0.002, 0.003 + 0.002 + 0.006, 0.002, 0.002 + 0.002]  # what each loses, added
    assert [traded.promise(trial, True) for trial in trials] == pytest.approx([3.0 * e + 0.001 for e in elsewhere])


def test_some_settings_only(pool: Executor) -> None:
    scene = Scene.load("notched-beam").with_(**CHANGES, **{"stage.0.to": 0.03})
    labels = {trial.label for trial in trade(scene, pool, settings=["half", "tolerance"]).trials}
    singles = {"half", "tolerance 0.01", "tolerance 0.001", "tolerance 1e-06"}
    assert labels >= {"as it is", "finer x 2", "finer x 4", *singles}
    assert not any("steps" in each or "width" in each for each in labels)
    with pytest.raises(SceneError, match=f"settings: 'width of it' is unknown; expected some of {', '.join(SETTINGS)}"):
        trade(scene, pool, settings=["width of it"])
    with (
        pytest.warns(DeprecationWarning, match=r"trade\(knobs=...\) is now trade\(settings=...\)"),
        pytest.raises(SceneError, match="settings: 'no setting' is unknown"),
    ):
        trade(scene, pool, knobs=["no setting"])


def test_the_old_option_says_its_new_name(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["trade", "notched-beam", "-o", str(tmp_path / "out"), "--knobs", "no setting"]) == 2
    said = capsys.readouterr().err
    assert "--knobs is now --settings" in said and "'no setting' is unknown" in said


def table(folder: Path) -> list[dict[str, str]]:
    with open(folder / "trade.csv", newline="") as file:
        assert file.readline().startswith("# {")  # a comment, for those who read it with pandas
        return list(csv.DictReader(file))


def test_a_mesh_file_has_no_sizes_to_turn(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"specimen.kind = 'mesh': a trade measures against a finer mesh"):
        trade(Scene(OF_A_FILE, tmp_path))


@pytest.mark.long
def test_command_in_processes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The smeared single crack, small: each run in a process of its own."""
    changes = ["model.kind=smeared", "mesh.crack_size=20.0", "mesh.far_size=25.0", "stage.0.steps=4", "stage.0.to=0.03"]
    words = ["--settings", "steps, model", *(word for change in changes for word in ("--set", change))]
    assert main(["trade", "single-crack", "-o", str(tmp_path), *words]) == 0
    out = capsys.readouterr().out
    assert "model discrete" in out and "cheapest for 5 %" in out
    assert all(float(row["memory_mb"]) > 50 for row in table(tmp_path) if not row["failure"])


def test_an_interrupted_trade_says_that_there_is_no_table(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("cohesive.studies.trade.trade", interrupted)
    assert main(["trade", "single-crack", "-o", str(tmp_path)]) == 130
    assert "the table is written when all runs are done" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
