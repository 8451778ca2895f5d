"""Runs on a mesh of the user's, plane or solid, and what it cannot have."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest

from cohesive import Scene, SceneError, compare, run
from meshing import MeshSizes, SingleCrack
from tests.builders import Patch, as_file, assert_refused, block, box

#: a box of 40 x 10 x 40 mm, pulled along z
SIZE = (40.0, 10.0, 40.0)
OWN: dict[str, Any] = {
    "specimen": {
        "kind": "mesh", "file": "box.vtu", "crack": "crack",
        "supports": [
            {"at": "base", "direction": [0.0, 0.0, 1.0]},
            {"at": [0.0, 0.0, 0.0], "direction": [1.0, 0.0, 0.0]},
            {"at": [0.0, 0.0, 0.0], "direction": [0.0, 1.0, 0.0]},
            {"at": [40.0, 0.0, 0.0], "direction": [0.0, 1.0, 0.0]},
        ],
        "drive": {"at": "top", "direction": [0.0, 0.0, 2.0]},
    },
    "material": {"preset": "reinhardt"},
    "interface": {"width": 0.3},
    "stage": [{"control": "opening", "to": 0.05, "steps": 4}],
}  # fmt: skip


def write(path: Path, solid: Patch, **sets: np.ndarray) -> None:
    z = solid.points[:, 2]
    named = {"base": z < 1e-6, "top": z > SIZE[2] - 1e-6, "crack": abs(z - SIZE[2] / 2) < 1e-6} | sets
    data = {name: at.astype(int) for name, at in named.items()}
    mesh = meshio.Mesh(solid.points, [(solid.kind, solid.cells)], point_sets={n: np.flatnonzero(v) for n, v in data.items()})
    meshio.write(path, mesh, file_format="abaqus")


def own(folder: Path, **changes: Any) -> Scene:
    return Scene(OWN, folder).with_(**{"specimen.file": "box.inp"} | {k.replace("__", "."): v for k, v in changes.items()})


@pytest.mark.long
@pytest.mark.parametrize("kind", ["hexahedron", "tetra"])
def test_a_solid_mesh_of_ones_own(kind: str, tmp_path: Path) -> None:
    write(tmp_path / "box.inp", box(kind, (2, 1, 2), SIZE))
    result = run(own(tmp_path))
    # uniform tension: the law's traction on 400 mm^2
    np.testing.assert_allclose(result.history["load"], result.history["stress_n"] * 400.0, rtol=1e-6)
    assert result.history["opening"][-1] == pytest.approx(0.05)
    assert result.dissipated_energy == pytest.approx(result.full_energy or 0.0, rel=0.5)
    result.save(tmp_path / "out")
    assert "in three dimensions" in result.summary()
    everywhere = own(
        tmp_path, model__kind="smeared", band__where="everywhere", specimen__gauge_minus="base", specimen__gauge_plus="top"
    )
    both = compare(everywhere)
    assert 0.5 < both.smeared.peak_load / (400.0 * everywhere.material.ft) < 1.001
    assert both.profiles() == []  # there is no path to draw them along
    both.save(tmp_path / "both")
    assert (tmp_path / "both" / "comparison.png").stat().st_size > 20_000


def test_what_a_solid_mesh_cannot_have(tmp_path: Path) -> None:
    solid = box("hexahedron", (2, 1, 2), SIZE)
    corner = np.zeros(len(solid.points), dtype=bool)
    corner[:1] = True
    write(tmp_path / "box.inp", solid, point=corner)
    base = {"at": "base", "direction": [0.0, 1.0]}
    for changes, message in (
        ({"specimen__thickness": 10.0}, r"^specimen.thickness = 10: the mesh is solid; expected no thickness"),
        ({"model__plane": "strain"}, r"^model.plane = 'strain': the mesh is solid"),
        ({"specimen__crack": "base"}, r"^specimen: the crack surface runs along its boundary at"),
        ({"specimen__crack": "point"}, r"^specimen.crack = 'point': no element face joins nodes of this set"),
        ({"specimen__crack": "nothing"}, r"^specimen.crack = 'nothing': the file has no such set; it has base, crack, point"),
        ({"specimen__crack": [[0.0, 20.0], [40.0, 20.0]]}, r"^specimen.crack = .*: the mesh is solid; expected the name"),
        ({"specimen__supports": [base]}, r"^specimen.supports.direction = \[0.0, 1.0\]: the mesh is solid; expected three"),
        ({"specimen__drive": base}, r"^specimen.drive.direction = \[0.0, 1.0\]: the mesh is solid; expected three numbers"),
        ({"specimen__gauge_minus": [0.0, 0.0], "specimen__gauge_plus": "top"}, r"^specimen.gauge_minus = \[0.0, 0.0\]: the m"),
        ({"specimen__supports": [OWN["specimen"]["supports"][0]]}, r"^specimen: the body is not held"),
    ):
        assert_refused(own(tmp_path, **changes), message)
    for changes, message in (
        ({"specimen.supports": [{"at": [0.0], "direction": [1.0, 0.0, 0.0]}]}, r"^specimen.supports.at = \[0.0\]: expected"),
        ({"specimen.drive": {"at": "top", "direction": [1.0] * 4}}, r"^specimen.drive.direction = .*expected two numbers"),
        ({"specimen.crack": [[0.0, 0.0, 20.0], [40.0, 0.0, 20.0]]}, r"^specimen.crack = .*expected a list of points"),
    ):
        with pytest.raises(SceneError, match=message):
            own(tmp_path).with_(**changes)


def test_a_surface_that_ends_inside_the_body_is_a_crack_with_a_front(tmp_path: Path) -> None:
    solid = box("hexahedron", (4, 1, 2), SIZE)
    write(tmp_path / "box.inp", solid, crack=(abs(solid.points[:, 2] - 20) < 1e-6) & (solid.points[:, 0] < 21))
    result = run(own(tmp_path, stage__0__to=0.001))
    assert result.facts.crack_area == pytest.approx(200.0)
    coarse, front = result.notes
    assert coarse.startswith("warning: 2 of the 2 elements along the crack are longer than 1.89 mm, up to 10 mm;")
    assert front == "the crack surface ends inside the body along 10 mm of its edge; there is the front"
    write(tmp_path / "box.inp", solid)
    assert not any("front" in note for note in run(own(tmp_path, stage__0__to=0.001)).notes)
    edge = (abs(solid.points[:, 2] - 20) < 1e-6) & (solid.points[:, 0] < 1)  # a line of nodes is no surface
    write(tmp_path / "box.inp", solid, crack=edge)
    assert_refused(own(tmp_path), r"^specimen.crack = 'crack': no element face joins nodes of this set")


def test_inverted_cells_are_refused(tmp_path: Path) -> None:
    solid = box("tetra", (2, 1, 2), SIZE)
    solid.cells[3] = solid.cells[3, [1, 0, 2, 3]]
    write(tmp_path / "box.inp", solid)
    assert_refused(own(tmp_path), r"^specimen.file = '.*': tetra 3 at .* is inverted or flat")


def test_a_plane_mesh_needs_a_thickness(tmp_path: Path) -> None:
    points = np.array([(x, y, 0.0) for y in (0.0, 20.0, 40.0) for x in (0.0, 40.0)])
    mesh = meshio.Mesh(points, [("quad", [[0, 1, 3, 2], [2, 3, 5, 4]])])
    meshio.write(tmp_path / "box.inp", mesh, file_format="abaqus")
    plane = {"specimen__crack": [[0.0, 20.0], [40.0, 20.0]]}
    assert_refused(own(tmp_path, **plane), r"^specimen.thickness is missing: the mesh is plane")
    assert_refused(
        own(tmp_path, specimen__thickness=10.0, **plane), r"^specimen.supports.direction = .*: the mesh is plane; expected two"
    )


def test_the_body_must_be_held(tmp_path: Path) -> None:
    mesh = SingleCrack(40.0, 30.0, 10.0).mesh(MeshSizes(5.0, 8.0))
    original = mesh.point_data["original"]
    mesh.cells[0].data[:] = original[mesh.cells[0].data]
    mesh.points = mesh.points[: original.max() + 1]
    scene = as_file(tmp_path, mesh, np.eye(2), "loose.vtu", [[-20.0, 0.0], [20.0, 0.0]])
    loose = scene.data["specimen"]["supports"][:1]
    with pytest.raises(ValueError, match="not held"):
        run(scene.with_(**{"specimen.supports": loose}))


@pytest.mark.long
def test_a_band_from_a_file_is_that_of_the_specimen(tmp_path: Path) -> None:
    """The row of quadrilaterals of a built-in mesh, written, shuffled and read back."""
    scene = block(mesh__crack_size=4.0, stage__0__steps=5, band__width=2.0)
    mesh = scene.specimen.mesh_band(scene.sizes, 2.0)  # type: ignore[union-attr,arg-type]
    *bulk, (kind, row) = [(cells.type, cells.data) for cells in mesh.cells]
    shuffled = np.roll(row[np.random.default_rng(3).permutation(len(row))], 1, axis=1)
    sets = {"ROW": [*(np.empty(0, dtype=int) for _ in bulk), np.arange(len(row))]}
    points = np.column_stack([mesh.points, np.zeros(len(mesh.points))])
    meshio.Mesh(points, [*bulk, (kind, shuffled)], cell_sets=sets, point_sets=mesh.point_sets).write(tmp_path / "block.inp")
    data = {key: value for key, value in scene.data.items() if key not in ("mesh", "band")}
    data["specimen"] = {
        "kind": "mesh", "file": "block.inp", "thickness": 10.0, "crack": [[-20.0, 0.0], [20.0, 0.0]], "band": "ROW",
        "supports": [{"at": "base", "direction": [0, 1]}, {"at": "base_corner", "direction": [1, 0]}],
        "drive": {"at": "top", "direction": [0, 1]},
    }  # fmt: skip
    mine, own = run(Scene(data, tmp_path), "smeared"), run(scene, "smeared")
    assert mine.width == pytest.approx(2.0) and mine.full_energy == pytest.approx(own.full_energy)
    for name in ("load", "opening", "driven", "dissipated", "stress_n"):
        np.testing.assert_allclose(mine.history[name], own.history[name], rtol=1e-8, err_msg=name)
    # as a region where the crack may form there is no path: no area, and the opening needs a gauge
    data["band"] = {"where": "everywhere"}
    with pytest.raises(ValueError, match=r"^specimen.gauge_minus, specimen.gauge_plus: this band has no faces"):
        run(Scene(data, tmp_path), "smeared")
    data["specimen"] |= {"gauge_minus": "base", "gauge_plus": "top"}
    anywhere = run(Scene(data, tmp_path), "smeared")
    assert anywhere.full_energy is None and "dissipated: " in anywhere.summary()


def test_a_band_beside_a_crack_has_its_planes_on_it(tmp_path: Path) -> None:
    """The crack slants through the solid, which is pulled upright."""
    solid = box("hexahedron", (2, 1, 2), SIZE)
    level = solid.points[:, 2] == SIZE[2] / 2
    solid.points[level, 2] += 0.2 * (solid.points[level, 0] - SIZE[0] / 2)
    write(tmp_path / "box.inp", solid, crack=level)
    with open(tmp_path / "box.inp", "a", encoding="utf-8") as file:
        file.write("*ELSET, ELSET=PART\n1,2,3\n")
    gauges = {"specimen__gauge_minus": "base", "specimen__gauge_plus": "top", "model__kind": "smeared"}
    on_path = run(own(tmp_path, **gauges))
    assert on_path.facts.departure == pytest.approx(0.0, abs=1e-5)
    principal = run(own(tmp_path, **gauges, band__planes="principal"))
    assert principal.facts.departure == pytest.approx(np.degrees(np.arctan(0.2)), abs=2.0)
    # a set of elements follows no path
    assert_refused(
        own(tmp_path, **gauges, specimen__band="PART", band__planes="path"),
        r"^band.planes = 'path': the elements of specimen.band follow no path; expected 'principal', or one row of them",
    )
