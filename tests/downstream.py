"""A laboratory's own script, as it stands outside of the package: `.ci/run` checks it against the installed wheel with mypy
--strict and runs it. It asserts mechanics only."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cohesive import (
    Concrete,
    CrackPlane,
    Fit,
    Measured,
    MeshError,
    NotConverged,
    Result,
    Scene,
    SceneError,
    Sweep,
    compare,
    fit,
    prepare,
    read_measured,
    run,
    sweep,
)

QUICK: Mapping[str, float] = {"mesh.crack_size": 2.5, "mesh.far_size": 15.0, "stage.0.steps": 12}


@dataclass(frozen=True)
class Answer:
    """What the laboratory prints."""

    strengths: Sequence[float]
    peaks: list[float]
    fitted: dict[str, float]


def curve(folder: Path, result: Result) -> Measured:
    """A run written as a logger would, and read back."""
    rows = zip(result.history["opening"][1:].tolist(), (1e-3 * result.history["load"][1:]).tolist(), strict=True)
    path = folder / "logger.csv"
    path.write_text("opening (mm);Force [kN]\n" + "".join(f"{x:.9g};{y:.9g}\n" for x, y in rows))
    return read_measured(path, against="opening")


def main(folder: Path) -> Answer:
    scene = Scene.load("notched-beam").with_(**QUICK)
    prepared = prepare(scene)
    strengths = (3.0, 3.4)
    results: list[Result] = [run(scene.with_(**{"material.ft": ft}), prepared) for ft in strengths]
    peaks = [result.peak.load for result in results]
    assert peaks[0] < peaks[1], "a stronger concrete carries more"
    found: Fit = fit(scene, {"material.ft": (2.5, 4.5)}, reference=curve(folder, results[0]), check=False)
    assert abs(found.values["material.ft"] - 3.0) < 0.02
    swept: Sweep = sweep(scene, {"material.Gf": [0.06, 0.08]}, workers=1)
    assert swept.table["peak"][0] < swept.table["peak"][1]
    assert abs(compare(scene).table["peak"]["relative_difference"]) < 0.03
    plane = CrackPlane(Concrete(E=30e3, nu=0.2, ft=3.0, Gf=0.1), width=0.1)
    traction, _, Z = plane.update(np.array([[0.05, 0.0]]), np.zeros(1))
    assert 0.0 < traction[0, 0] < 3.0 and Z[0] == 0.05
    results[0].save(folder / "out", pictures=False)
    assert Result.load(folder / "out").peak_load == results[0].peak_load
    try:
        run(scene.with_(**{"stage.0.control": "load", "stage.0.to": 3000.0}))
    except NotConverged as error:
        assert error.result is not None and error.result.peak_load > 0.0
    except (SceneError, MeshError) as refused:
        raise AssertionError(refused.key) from refused
    return Answer(strengths, peaks, found.values)


if __name__ == "__main__":
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        print(main(Path(folder)))
