"""Both models on one solid."""

from __future__ import annotations

import csv
from pathlib import Path

import meshio
import numpy as np
import pytest

from cohesive import Scene, SceneError, compare
from cohesive.commands.command_line import main
from tests.builders import coarse_beam

QUICK = ["--set", "mesh.crack_size=3.0", "--set", "mesh.layers=2", "--set", "stage.0.steps=6"]


@pytest.mark.long
def test_files_of_a_comparison_in_3d(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["compare", "notched-beam-3d", "-o", str(tmp_path), *QUICK]) == 0
    assert "discrete     smeared  difference" in capsys.readouterr().out
    for name in ("comparison.png", "discrete/deformed.png", "smeared/deformed.png"):
        assert (tmp_path / name).read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    with open(tmp_path / "comparison.csv", encoding="utf-8") as file:
        rows = {row["quantity"]: float(row["relative_difference"]) for row in csv.DictReader(file)}
    assert abs(rows["peak"]) < 0.02  # measured 0.8 % with six steps
    band = meshio.read(sorted((tmp_path / "smeared").glob("frame_*.vtu"))[-1])
    assert {"planes", "strain_max"} < set(band.cell_data)


@pytest.mark.long
def test_profiles_are_means_over_the_thickness() -> None:
    both, flat = compare(coarse_beam("notched-beam-3d", "strain")), compare(coarse_beam("notched-beam", "strain"))
    for (title, here), (same, there) in zip(both.profiles(), flat.profiles(), strict=True):
        # the opening in three digits, which a rounding error may round either way
        assert float(title.split()[1]) == pytest.approx(float(same.split()[1]), abs=1.1e-3)
        for model in ("discrete", "smeared"):
            (s, opening), (at, expected) = here[model], there[model]
            assert (np.diff(s) > 0).all()
            # points of neighbouring cells have one position, and the same opening
            np.testing.assert_allclose(opening, np.interp(s, at, expected), atol=1e-6 * expected.max())


def test_a_comparison_without_a_band_is_refused_before_its_first_run() -> None:
    for scene, message in (
        (
            coarse_beam("notched-beam-3d", "stress", mesh__shape="triangle", mesh__order=2),
            r"^mesh.order = 2: the elements of a",
        ),
        (Scene.load("single-crack-3d"), r"^band.where = 'path': there is no crack band"),
    ):
        with pytest.raises(SceneError, match=message):
            compare(scene, on_step=lambda *_: pytest.fail("a run was started"))
