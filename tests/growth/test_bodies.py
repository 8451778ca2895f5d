"""Cracks that grow in bodies of all sorts: without a notch, from a user's mesh, through the thickness, and that close."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cohesive import Scene, SceneError, run
from cohesive.growth.search import Search, find_path
from meshing.generation.polygon import mesh_face
from meshing.generation.sizes import MeshSizes

from .beams import eccentric_beam, outlined_beam


def without_notch(**changes: Any) -> Scene:
    """The beam as an outline whose gauge is at mid-span, without a notch."""
    beam = outlined_beam(specimen__gauge_minus=[-20.0, 0.0], specimen__gauge_plus=[20.0, 0.0]).data
    del beam["specimen"]["notches"]
    return Scene(beam).with_(**{key.replace("__", "."): value for key, value in changes.items()})


def plate_with_hole(turn: bool = False) -> Scene:
    """A plate with a hole at (10, 0), pulled along x, or turned by a quarter along y."""

    def at(x: float, y: float) -> list[float]:
        return [-y, x] if turn else [x, y]

    specimen = {
        "kind": "outline",
        "thickness": 20.0,
        "corners": [at(-100, -50), at(100, -50), at(100, 50), at(-100, 50)],
        "holes": [{"center": at(10, 0), "radius": 15.0}],
        "edges": {"left": [at(-100, 50), at(-100, -50)], "right": [at(100, -50), at(100, 50)]},
        "supports": [{"at": "left", "direction": at(1, 0)}, {"at": at(-100, -50), "direction": at(0, 1)}],
        "drive": {"at": "right", "direction": at(1, 0)},
        "crack": "grow",
    }
    sizes = {"crack_size": 2.5, "far_size": 12.0}
    stage = [{"control": "dissipation", "to": 100.0, "steps": 20}]
    return Scene({"specimen": specimen, "mesh": sizes, "material": eccentric_beam().data["material"], "stage": stage})


@pytest.mark.parametrize("turn", [False, True])
def test_a_crack_starts_where_a_hole_is_pulled_most(turn: bool) -> None:
    """Across the pull through the centre of the hole, to half the width of a face of the polygon, whose corners stand there;
    away from the hole."""
    (crack,) = Search(plate_with_hole(turn)).starts
    x, y = crack.tip[::-1] if turn else crack.tip
    assert abs(x) == pytest.approx(10.0, abs=2.0) and abs(y) == pytest.approx(15.0, abs=0.3)
    away = np.array([np.cos(crack.heading), np.sin(crack.heading)]) @ (np.array(crack.tip) - ([0, 10] if turn else [10, 0]))
    assert away == pytest.approx(15.0, abs=0.5)


def test_a_crack_starts_at_mid_span() -> None:
    """The moment is largest there; within the radius of the average, 3.5 mm."""
    (crack,) = Search(without_notch()).starts
    assert crack.tip == pytest.approx((0.0, 0.0), abs=3.5) and crack.heading == pytest.approx(np.pi / 2, abs=0.02)


def test_a_crack_from_a_hole_goes_on_to_the_face() -> None:
    """Straight, for plate and pull are symmetric about it."""
    found = find_path(plate_with_hole())
    line = np.array(found.lines[0])
    assert abs(line[-1, 1]) == pytest.approx(50.0) and abs(line[:, 0] - 10.0).max() < 3.0
    assert "path: nothing is notched; it starts where the faces of the elastic body are pulled most" in found.notes


def test_a_body_that_is_only_pressed_starts_no_crack() -> None:
    block = plate_with_hole().with_(**{"specimen.drive.direction": [-1.0, 0.0]})
    data = block.data
    del data["specimen"]["holes"]
    with pytest.raises(SceneError, match=r"^specimen.crack = 'grow': no face is pulled away from loads and supports"):
        find_path(Scene(data))


@pytest.mark.long
def test_a_mesh_grows_the_crack_of_its_outline(tmp_path: Path) -> None:
    """The boundary of a mesh of the beam is its outline: the same path, to a quarter of an element, for the corners begin
    elsewhere and gmsh makes another mesh of the same sizes."""
    beam = outlined_beam(grow__segment=16.0, stage__0__steps=15).with_(**{"specimen.notches": [[[-51, 0], [-49, 0]]]})
    data = beam.data
    corners = [[-125, 0], [-51, 0], [-50, 20], [-49, 0], [125, 0], [125, 80], [-125, 80]]
    outline = {key: value for key, value in data["specimen"].items() if key != "notches"} | {"corners": corners}
    outline |= {"gauge_minus": [-51, 0], "gauge_plus": [-49, 0]}
    starts = {"grow": data["grow"] | {"starts": [{"at": [-50, 20], "direction": [0, 1]}]}}
    own = Scene(data | starts | {"specimen": outline})
    mesh_face(own.specimen.outline(), MeshSizes(5.0, 10.0), conforming=True).write(tmp_path / "beam.inp")  # type: ignore[attr-defined]
    kept = {key: value for key, value in outline.items() if key not in ("corners", "kind")}
    read = Scene(data | starts | {"specimen": kept | {"kind": "mesh", "file": "beam.inp"}}, tmp_path)
    np.testing.assert_allclose(find_path(read).lines[0], find_path(own).lines[0], atol=0.5)


@pytest.mark.long
def test_a_path_of_the_plane_is_extruded() -> None:
    """It is that of the plane beam, to the last digit; a body in space asks for it by its key."""
    sizes = {"crack_size": 5.0, "far_size": 20.0}
    plane = eccentric_beam(mesh=sizes, stage=[{"control": "opening", "to": 0.02, "steps": 3}])
    solid = plane.with_(**{"model.dimension": 3, "grow.extrude": True, "mesh.layers": 1, "model.kind": "smeared"})
    result = run(solid)
    assert result.scene.is_solid and result.scene.model.kind == "smeared"
    assert result.found is not None and result.found.lines == find_path(plane).lines == [list(map(tuple, result.path))]


@pytest.mark.long
def test_the_crack_that_unloads_is_named_with_the_opening() -> None:
    """Two notches: that at mid-span goes on, that beside it opens first too; the opening is one of the steps of the run."""
    beam = outlined_beam(notches=(0.0, 30.0), grow__segment=16.0, mesh__crack_size=4.0, stage__0__steps=20)
    search = Search(beam.with_(**{"specimen.gauge_minus": [-5.0, 0.0], "specimen.gauge_plus": [35.0, 0.0]}))
    notes = [note for note in search.find().notes if "closes" in note]
    measured, first, second = np.array(search.trials[-1].openings).T
    assert notes == [f"path 2: this one closes from an opening of {measured[second.argmax()]:.3g} mm on"]
    assert 0.015 < measured[second.argmax()] < 0.03
    assert second[-1] < 0.9 * second.max() and first[-1] == first.max()
