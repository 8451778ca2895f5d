"""A beam on a mesh of the user's: both models, elements that are too long, bulk that is crushed."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest

from cohesive import Scene, SceneError, compare, run
from cohesive.results.crushing import crushing
from cohesive.results.report import warnings
from tests.builders import rectangle


def beam(folder: Path, kind: str = "quad", counts: tuple[int, int] = (20, 10)) -> Scene:
    """160 x 40 x 40 mm on two supports, a path over its whole depth."""
    patch = rectangle(kind, counts, (160.0, 40.0))
    points = np.column_stack([patch.points - [80.0, 0.0], np.zeros(len(patch.points))])
    meshio.Mesh(points, [(kind, patch.cells)]).write(folder / "beam.vtu")
    data = {
        "specimen": {
            "kind": "mesh", "file": "beam.vtu", "thickness": 40.0, "crack": [[0.0, 0.0], [0.0, 40.0]],
            "supports": [
                {"at": [-72.0, 0.0], "direction": [0, 1]}, {"at": [72.0, 0.0], "direction": [0, 1]},
                {"at": [0.0, 40.0], "direction": [1, 0]},
            ],
            "drive": {"at": [0.0, 40.0], "direction": [0, -1]}, "gauge_minus": [-8.0, 0.0], "gauge_plus": [8.0, 0.0],
        },
        "material": {"preset": "reinhardt"},
        "output": {"frames": 0},
        "stage": [{"control": "opening", "to": 0.1, "steps": 10}],
    }  # fmt: skip
    return Scene(data, folder)


@pytest.mark.parametrize("kind", ["quad", "triangle", "triangle6"])
def test_the_crack_is_opened_to_a_band(kind: str, tmp_path: Path) -> None:
    """Elements of 4 mm, 1.4 to 2.2 % of the peak in a row of any kind; locations on the path and beside it are those of the
    file, and without a gauge the faces tell the opening."""
    both = compare(beam(tmp_path, kind))
    assert any("the crack band is 4 mm wide" in note for note in both.notes)
    assert abs(both.table["peak"]["relative_difference"]) < 0.025
    assert both.smeared.fields.mesh.is_row and both.smeared.width == pytest.approx(4.0)
    data = beam(tmp_path, kind).data
    del data["specimen"]["gauge_minus"], data["specimen"]["gauge_plus"]
    narrow = run(Scene(data, tmp_path).with_(**{"band.width": 1.0}), "smeared")
    assert narrow.width == pytest.approx(1.0) and not any("mm wide" in note for note in narrow.notes)


def test_a_width_is_refused_with_a_named_band(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"^band.width = 2: with specimen.band = 'ROW' the elements give it"):
        beam(tmp_path).with_(**{"specimen.band": "ROW", "band.width": 2.0})


def test_long_elements_along_the_path_are_warned_of_once(tmp_path: Path) -> None:
    first = [{"control": "opening", "to": 0.001, "steps": 1}]
    for model in ("discrete", "smeared"):
        for count, is_warned in ((3, True), (16, False), (15, True)):
            result = run(beam(tmp_path, counts=(20, count)).with_(stage=first), model)
            coarse = [note for note in result.notes if "longer than" in note]
            assert len(coarse) == is_warned, (model, count)
            if is_warned:
                assert coarse[0].startswith(
                    f"warning: {count} of the {count} elements along the crack are longer than 2.5 mm"
                )


def test_a_crushed_bulk_is_told_with_place_and_step(tmp_path: Path) -> None:
    result = run(beam(tmp_path))
    assert crushing(result) == ""  # 10 ft
    low = run(beam(tmp_path).with_(**{"material.fc": 2.0}))
    (said,) = (note for note in warnings(low) if "compressed beyond" in note)
    assert "fc = 2 MPa away from loads and supports, to -" in said and said in low.summary()
    # what is said is in the fields: the stress at that element in that step
    x, y = (float(c) for c in said.split("at (")[1].split(")")[0].split(", "))
    step = int(said.split("in step ")[1].split(":")[0])
    frame, block = low.frame(int(np.flatnonzero(low.history["step"] == step)[0])), low.fields.bulk[0]
    element = int(np.linalg.norm(block.points[block.cells].mean(axis=1) - [x, y], axis=1).argmin())
    s = frame.stress[0][element]
    minor = (s[0] + s[1]) / 2 - np.hypot((s[0] - s[1]) / 2, s[2])
    assert minor == pytest.approx(float(said.split("to ")[1].split(" MPa")[0]), rel=5e-3)  # three digits
    # beside the load and the supports it does not count
    assert np.hypot(x, y - 40.0) > 8.0 and min(np.hypot(x - 72.0, y), np.hypot(x + 72.0, y)) > 8.0


def test_a_strength_that_is_none_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"^material.fc = -3.0: expected a number above 0"):
        beam(tmp_path).with_(**{"material.fc": -3.0})


def test_odd_nodes_are_remarked(tmp_path: Path) -> None:
    scene = beam(tmp_path)
    mesh = meshio.read(tmp_path / "beam.vtu")
    more = np.vstack([mesh.points, [[0.0, 90.0, 0.0], [1.0, 90.0, 0.0]]])
    meshio.Mesh(more, mesh.cells).write(tmp_path / "beam.vtu")
    first = scene.with_(stage=[{"control": "opening", "to": 0.001, "steps": 1}])
    assert "2 nodes of the file belong to no element and are left out" in run(first).notes
    # a slit: the node at the end of the row below is doubled
    cells, at = mesh.cells[0].data.copy(), int(np.linalg.norm(mesh.points - [-40.0, 0.0, 0.0], axis=1).argmin())
    right = mesh.points[cells].mean(axis=1)[:, 0] > -40.0
    cells[right] = np.where(cells[right] == at, len(mesh.points), cells[right])
    meshio.Mesh(np.vstack([mesh.points, mesh.points[at]]), [("quad", cells)]).write(tmp_path / "beam.vtu")
    assert any("2 nodes of the boundary touch elements that do not have them" in note for note in run(first).notes)


def test_a_region_may_reach_the_crack(tmp_path: Path) -> None:
    """The band takes no element of it."""
    scene = beam(tmp_path)
    mesh = meshio.read(tmp_path / "beam.vtu")
    centres = mesh.points[mesh.cells[0].data].mean(axis=1)
    inside = np.flatnonzero(abs(centres[:, 0]) < 9.0)
    meshio.Mesh(mesh.points, mesh.cells, cell_sets={"steel": [inside]}).write(tmp_path / "beam.inp", file_format="abaqus")
    changed = scene.with_(**{"specimen.file": "beam.inp", "specimen.regions": {"steel": {"E": 2e5, "nu": 0.3}}})
    plain, stiff = (run(each, "smeared") for each in (scene, changed))
    assert plain.history["driven"][1] > stiff.history["driven"][1]
