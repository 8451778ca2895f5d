"""A plane body of the user's own outline, from corners, a .geo or a STEP file."""

from __future__ import annotations

import math
import re
from itertools import permutations
from pathlib import Path
from typing import Any

import pytest

from cohesive import Scene, SceneError
from meshing import MeshError
from meshing.files.geo import read_outline, read_step
from meshing.generation.session import session
from tests.growth.beams import outlined_beam
from tests.meshing.measures import areas

GEO = """
Point(1) = {0, 0, 0}; Point(2) = {10, 0, 0}; Point(3) = {10, 10, 0}; Point(4) = {5, 10, 0}; Point(5) = {0, 5, 0};
Point(6) = {0, 10, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Circle(4) = {4, 6, 5}; Line(5) = {5, 1};
Curve Loop(1) = {1, 2, 3, 4, 5}; Plane Surface(1) = {1};
Physical Curve("base") = {1}; Physical Curve("arc") = {4}; Physical Point("pin") = {2};
"""


def test_a_geo_file_gives_outline_and_names(tmp_path: Path) -> None:
    """A square of 10 mm without a quarter of a circle, whose arc becomes 24 chords: they take away less by 1 - sin(a)/a,
    a = 90/24 degrees."""
    (tmp_path / "plate.geo").write_text(GEO)
    outline = read_outline(tmp_path / "plate.geo")
    a = math.radians(90 / 24)
    assert outline.area == pytest.approx(100.0 - 6.25 * math.pi * math.sin(a) / a, rel=1e-9)
    assert len(outline.edges["arc"]) == 25
    assert {tuple(p) for p in outline.edges["base"]} == {(0.0, 0.0), (10.0, 0.0)}
    assert outline.nodes["pin"] == [(10.0, 0.0)]


def test_other_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(MeshError, match=r"^file = .*: there is no such file$"):
        read_outline(tmp_path / "none.geo")
    (tmp_path / "empty.geo").write_text("Point(1) = {0, 0, 0};")
    with pytest.raises(MeshError, match=r"^file = .*: it has 0 faces; expected one$"):
        read_outline(tmp_path / "empty.geo")


def test_notches_start_cracks_at_their_ends_in_the_body() -> None:
    specimen = outlined_beam().specimen
    ((tip, direction),) = specimen.starts
    assert tip == (-50.0, 20.0)
    assert direction == pytest.approx((0.0, 1.0))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"specimen.corners": None}, r"^specimen.corners, file, step: expected one of these keys$"),
        ({"specimen.corners": [[0, 0], "a"]}, r"^specimen.corners = "),
        ({"specimen.edges": {"top": 3}}, r"^specimen.edges.top = "),
        ({"specimen.supports": []}, r"^specimen.supports = \[\]: expected a list"),
        ({"specimen.gauge_plus": None}, r"^specimen.gauge_minus, gauge_plus: expected both or none$"),
    ],
)
def test_what_does_not_fit_is_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(SceneError, match=message):
        outlined_beam().with_(**changes)


def test_a_path_that_is_to_be_found_counts_as_half_the_longest_side() -> None:
    """Of the beam, 250 x 80 mm, turned upright, whose corners lie on all sides of the origin."""
    for degrees in (0.0, 90.0):
        assert outlined_beam(degrees).specimen.path_length == pytest.approx(125.0)


@pytest.mark.parametrize("reverse", [False, True])
@pytest.mark.parametrize("tags", list(permutations((1, 2, 3))))
def test_curves_of_a_group_are_joined_in_any_order(tmp_path: Path, tags: tuple[int, int, int], reverse: bool) -> None:
    """Three sides of a rectangle, of which gmsh hands out the one with the lowest number first; the third is drawn the other
    way round."""
    a, b, c = tags
    loop = f"-4, {c}, -{b}, -{a}" if reverse else f"{a}, {b}, -{c}, 4"
    (tmp_path / "plate.geo").write_text(
        "Point(1) = {0, 0, 0}; Point(2) = {3, 0, 0}; Point(3) = {3, 2, 0}; Point(4) = {0, 2, 0};"
        f"Line({a}) = {{1, 2}}; Line({b}) = {{2, 3}}; Line({c}) = {{4, 3}}; Line(4) = {{4, 1}};"
        f'Curve Loop(1) = {{{loop}}}; Plane Surface(1) = {{1}}; Physical Curve("three") = {{1, 2, 3}};\n'
    )
    outline = read_outline(tmp_path / "plate.geo")
    three = [(0.0, 0.0), (3.0, 0.0), (3.0, 2.0), (0.0, 2.0)]
    assert list(outline.edges["three"]) in (three, three[::-1])
    assert outline.area == pytest.approx(6.0) and set(outline.corners) == set(three)


def test_a_notch_with_a_bend_starts_a_crack_along_its_last_part() -> None:
    bent = outlined_beam(specimen__notches=[[[-50, 0], [-50, 10], [-40, 20]]]).specimen
    ((tip, direction),) = bent.starts
    assert tip == (-40.0, 20.0)
    assert direction == pytest.approx((math.sqrt(0.5), math.sqrt(0.5)))


def test_holes_are_left_out_of_the_body() -> None:
    """A circle has 24 sides, whose area is that of 24 triangles; a polygon its own."""
    holes = [{"center": [0.0, 50.0], "radius": 10.0}, [[40.0, 40.0], [50.0, 40.0], [50.0, 60.0]]]
    scene = outlined_beam(specimen__holes=holes).without_search([[-50.0, 20.0], [-50.0, 80.0]])
    left = 250.0 * 80.0 - 12 * 100.0 * math.sin(math.pi / 12) - 100.0
    assert scene.specimen.outline().area == pytest.approx(left, rel=1e-12)
    mesh = scene.specimen.mesh(scene.sizes)
    assert sum(float(block.sum()) for block in areas(mesh)) == pytest.approx(left, rel=1e-9)


@pytest.mark.parametrize(
    ("holes", "message"),
    [
        (3, r"^specimen.holes = 3: expected a list of polygons and circles$"),
        ([{"center": [0, 40]}], r"^specimen.holes.0 = .*expected a polygon \[\[x, y\], ...\] or a circle"),
        ([{"center": [0, 40], "radius": -1.0}], r"^specimen.holes.0 = .*expected a polygon"),
        ([[[0, 40], [1, 40]]], r"^specimen.holes.0 = .*expected a polygon"),
        ([{"center": [0, 75], "radius": 9.0}], r"^specimen.holes.0 = .*expected a hole inside the body$"),
        ([[[0, 40], [5, 40], [2, math.nan]]], r"^specimen.holes.0 = .*expected a polygon"),
    ],
)
def test_what_is_no_hole_is_refused(holes: Any, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        outlined_beam(specimen__holes=holes)


def test_a_geo_file_may_have_holes(tmp_path: Path) -> None:
    """The square without a circle of two arcs, 24 chords each: a polygon of 48 sides."""
    hole = """
Point(7) = {7, 2, 0}; Point(8) = {6, 2, 0}; Point(9) = {8, 2, 0};
Circle(6) = {8, 7, 9}; Circle(7) = {9, 7, 8}; Curve Loop(2) = {6, 7};
"""
    (tmp_path / "plate.geo").write_text(GEO.replace("Plane Surface(1) = {1};", hole + "Plane Surface(1) = {1, 2};"))
    outline = read_outline(tmp_path / "plate.geo")
    (polygon,) = outline.holes
    assert len(polygon) == 48
    a = math.radians(90 / 24)
    square = 100.0 - 6.25 * math.pi * math.sin(a) / a
    assert outline.area == pytest.approx(square - 24 * math.sin(math.pi / 24), rel=1e-9)


def test_a_hole_may_run_either_way_round() -> None:
    """gmsh loses the crack beside one that runs clockwise."""
    holes = [[[40.0, 40.0], [50.0, 60.0], [50.0, 40.0]], [[-20.0, 40.0], [-10.0, 40.0], [-10.0, 60.0]]]
    scene = outlined_beam(specimen__holes=holes).without_search([[-50.0, 20.0], [-50.0, 80.0]])
    mesh = scene.specimen.mesh(scene.sizes)
    assert sum(float(block.sum()) for block in areas(mesh)) == pytest.approx(250.0 * 80.0 - 200.0, rel=1e-9)


def write_step(path: Path, unit: str = "SI_UNIT(.MILLI.,.METRE.)", solid: bool = False, height: float = 0.0) -> Path:
    """A plate of 100 x 50 with a circle of 20 in it, in a unit."""
    with session() as gmsh:
        occ = gmsh.model.occ
        plate, circle = occ.addRectangle(0, 0, height, 100, 50), occ.addDisk(60, 25, height, 10, 10)
        occ.cut([(2, plate)], [(2, circle)])
        if solid:
            occ.extrude([(2, plate)], 0, 0, 10)
        occ.synchronize()
        gmsh.write(str(path))
    path.write_text(path.read_text().replace("SI_UNIT(.MILLI.,.METRE.)", unit))
    return path


@pytest.mark.parametrize(("unit", "factor"), [("SI_UNIT(.MILLI.,.METRE.)", 1.0), ("SI_UNIT($,.METRE.)", 1000.0)])
def test_a_step_file_is_read_in_its_unit(tmp_path: Path, unit: str, factor: float) -> None:
    """What stands beside it is not read: gmsh would run a file of options of the same name."""
    path = write_step(tmp_path / "plate.step", unit)
    (tmp_path / "plate.step.opt").write_text(f'Printf("ran") > "{tmp_path / "ran"}";')
    beam = outlined_beam()
    specimen = {key: value for key, value in beam.data["specimen"].items() if key != "corners"} | {"step": "plate.step"}
    made = Scene(beam.data | {"specimen": specimen}, tmp_path).data["specimen"]
    assert "step" not in made and len(made["holes"][0]) == 24
    assert sorted(made["corners"]) == [[0, 0], [0, 50 * factor], [100 * factor, 0], [100 * factor, 50 * factor]]
    assert read_step(path).area == pytest.approx((5000 - 12 * 100 * math.sin(math.pi / 12)) * factor**2, rel=1e-9)
    assert not (tmp_path / "ran").exists()


def test_a_step_file_that_is_no_plane_body_in_a_known_unit_is_refused(tmp_path: Path) -> None:
    path = write_step(tmp_path / "plate.step")
    other = "(NAMED_UNIT(*) SI_UNIT($,.STERADIAN.) SOLID_ANGLE_UNIT() );"
    path.write_text(re.sub(r"\(\s*LENGTH_UNIT\(\)[^;]*;", other, path.read_text()))
    with pytest.raises(MeshError, match=r"^step = '.*': it states no unit of length; expected a STEP file with a"):
        read_step(path)
    with pytest.raises(MeshError, match=r"^step = '.*': it has 7 faces; expected one$"):
        read_step(write_step(tmp_path / "solid.step", solid=True))
    with pytest.raises(MeshError, match=r"^step = '.*': its face has z from 3 to 3; expected one in the plane z = 0$"):
        read_step(write_step(tmp_path / "high.step", height=3.0))
    with pytest.raises(MeshError, match=r"^step = '.*none.step': there is no such file$"):
        read_step(tmp_path / "none.step")
    with pytest.raises(SceneError, match=r"^specimen.corners, file, step: expected one of these keys$"):
        outlined_beam(specimen__step="plate.step")
