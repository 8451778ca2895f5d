"""The trade of accuracy against cost."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from itertools import pairwise
from pathlib import Path

import pytest

from cohesive import Scene, SceneError
from cohesive.cli import main
from cohesive.trade import Cost, Trade, Trial, _combined, trade

CHANGES = {"mesh.crack_size": 5.0, "mesh.far_size": 15.0, "stage.0.steps": 16}


@pytest.fixture
def pool() -> Iterator[Executor]:
    """Trials share the process: their memory is not their own, the rest is."""
    with ThreadPoolExecutor(1) as executor:
        yield executor


def test_errors_fall_with_the_knobs(pool: Executor, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cohesive.trade._REPEATED", 0.0)
    seen: list[Trial] = []
    found = trade(Scene.load("notched-beam").with_(**CHANGES), pool, seen.append)
    assert seen == found.trials and found.trials[0].changes == {}
    error = {trial.label: trial.error for trial in found.trials}
    assert error["crack size x 4"] > error["crack size x 2"] > error["as it is"] > error["crack size x 0.5"]
    assert error["steps x 0.25"] > error["as it is"]
    # exact: the reduction, and half of a symmetric body but for its mesh
    assert abs(error["reduction none"] - error["as it is"]) < 1e-4
    assert 0 < found.own_error < 0.5 * error["as it is"]
    front = found.front()
    assert all(a.cost.cpu <= b.cost.cpu and a.error > b.error for a, b in pairwise(front))  # type: ignore[union-attr]
    best = found.cheapest(0.05)
    assert best is not None and best.error + found.own_error <= 0.05
    assert all(best.cost.cpu <= t.cost.cpu for t in found.trials if t.cost and t.error + found.own_error <= 0.05)  # type: ignore[union-attr]
    found.scene.with_(**best.changes)  # its settings are keys of a scene
    found.save(tmp_path)
    with open(tmp_path / "trade.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["setting"] for row in rows] == [trial.label for trial in found.trials]
    assert float(rows[0]["error"]) == pytest.approx(found.trials[0].error, rel=1e-4)
    assert (tmp_path / "trade.png").stat().st_size > 1e4 and "cheapest for 1 %" in (tmp_path / "trade.txt").read_text()


def test_combinations_take_the_cheapest_value_of_each_knob_that_errs_little() -> None:
    def one(label: str, key: str, error: float, cpu: float) -> Trial:
        errors = {"peak": error, "energy": 0.0, "curve_distance": 0.0}
        return Trial(label, {key: label}, errors, Cost(cpu, cpu, 100.0, 10))

    trials = [
        Trial("as it is", {}, {"peak": 0.001, "energy": 0.0, "curve_distance": 0.0}, Cost(1.0, 1.0, 100.0, 10)),
        one("steps x 0.5", "steps", 0.003, 0.6),
        one("steps x 0.25", "steps", 0.015, 0.4),
        one("crack size x 2", "size", 0.003, 0.7),
        one("tolerance 0.01", "tol", 0.0, 0.99),  # not worth it
        one("width x 4", "width", 0.0, 2.0),  # dearer
        one("model discrete", "model", 0.0, 0.1),  # another physics
        Trial("half", {"half": True}, failure="no"),
    ]
    assert [(label, changes) for label, changes in _combined(trials)] == [
        ("for 5 %: steps x 0.25, crack size x 2", {"steps": "steps x 0.25", "size": "crack size x 2"}),
        ("for 1 %: steps x 0.5, crack size x 2", {"steps": "steps x 0.5", "size": "crack size x 2"}),
    ]


def test_a_setting_that_fails_is_a_row_with_its_reason() -> None:
    scene = Scene.load("notched-beam")
    good = Trial("as it is", {}, {"peak": 0.0, "energy": 0.001, "curve_distance": 0.002}, Cost(1.0, 1.0, 100.0, 10))
    bad = Trial("half", {"model.half": True}, failure="no convergence")
    found = Trade(scene, {"peak": 1.0, "opening_at_peak": 1.0, "energy": 1.0}, 1e-3, [good, bad])
    assert bad.error == float("inf") and found.front() == [good]
    assert "half" in found.summary() and "failed: no convergence" in found.summary()
    assert found.cheapest(0.01) is good and found.cheapest(0.002) is None


def test_a_mesh_file_has_no_sizes_to_turn(tmp_path: Path) -> None:
    data = {
        "specimen": {
            "kind": "mesh", "file": "a.msh", "thickness": 1.0, "crack": "c",
            "supports": [{"at": "b", "direction": [0, 1]}], "drive": {"at": "t", "direction": [0, 1]},
        },
        "material": {"preset": "reinhardt"},
        "stage": [{"control": "driven", "to": 0.1}],
    }  # fmt: skip
    with pytest.raises(SceneError, match=r"specimen.kind = 'mesh': a trade turns the sizes"):
        trade(Scene(data, tmp_path))


def test_command_in_processes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The smeared single crack, small: each run in a process of its own."""
    changes = ["model.kind=smeared", "mesh.crack_size=20.0", "mesh.far_size=25.0", "stage.0.steps=4", "stage.0.to=0.03"]
    words = [word for change in changes for word in ("--set", change)]
    assert main(["trade", "single-crack", "-o", str(tmp_path), *words]) == 0
    out = capsys.readouterr().out
    assert "model discrete" in out and "cheapest for 5 %" in out
    with open(tmp_path / "trade.csv", newline="") as file:
        assert all(float(row["memory_mb"]) > 50 for row in csv.DictReader(file) if not row["failure"])
