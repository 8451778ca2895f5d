"""A trade on a Dask cluster of two processes."""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from cohesive.commands.command_line import main
from cohesive.studies.trade import trade
from tests.builders import block

SMALL = {"stage__0__to": 0.02, "solver__tol": 1e-6}


pytestmark = pytest.mark.usefixtures("once")


@pytest.mark.long
def test_a_client_runs_the_trials() -> None:
    distributed = pytest.importorskip("distributed")
    seen: list[str] = []
    with (
        distributed.LocalCluster(2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        outcomes = trade(block(**SMALL), client.get_executor(), lambda trial: seen.append(trial.label), ["steps", "order"])
    with ThreadPoolExecutor(1) as pool:
        here = trade(block(**SMALL), pool, settings=["steps", "order"])
    errors = {trial.label: trial.error for trial in here.trials}
    assert sorted(seen) == sorted(trial.label for trial in outcomes.trials)
    for trial in outcomes.trials:
        if trial.label in errors:  # which settings are combined depends on the times
            assert trial.error == pytest.approx(errors[trial.label], rel=1e-6, abs=1e-12)  # the same run in another process
    assert {"as it is", "order 2", "steps x 2", "finer x 4"} <= {trial.label for trial in outcomes.trials}


@pytest.mark.long
def test_the_command_starts_a_cluster_of_its_own(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("distributed")
    words = [
        "--set",
        "mesh.crack_size=20.0",
        "--set",
        "mesh.far_size=25.0",
        "--set",
        "stage.0.steps=4",
        "--settings",
        "condensation",
    ]
    assert main(["trade", "single-crack", "--dask", "local", "-o", str(tmp_path), *words]) == 0
    assert "condensation never" in capsys.readouterr().out and (tmp_path / "trade.csv").exists()


def test_no_scheduler_is_one_sentence(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    assert main(["trade", "single-crack", "--dask", "nonsense://nowhere", "-o", str(tmp_path)]) == 2
    err = capsys.readouterr().err
    assert err.startswith("cohesive: --dask nonsense://nowhere: no scheduler answers there") and len(err.splitlines()) == 1


def test_without_the_package_the_command_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert main(["trade", "single-crack", "--dask", "local", "-o", str(tmp_path)]) == 2
    err = capsys.readouterr().err
    assert "pip install 'cohesive-cracks[dask]'" in err and len(err.splitlines()) == 1
