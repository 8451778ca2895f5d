"""A plane body of the user's own outline, from corners or a .geo file."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from cohesive import SceneError
from meshing import MeshError
from meshing.geo_files import read_outline
from tests.growth.beams import outlined_beam

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
        ({"specimen.corners": None}, r"^specimen.corners, file: expected one of these keys$"),
        ({"specimen.corners": [[0, 0], "a"]}, r"^specimen.corners = "),
        ({"specimen.edges": {"top": 3}}, r"^specimen.edges.top = "),
        ({"specimen.supports": []}, r"^specimen.supports = \[\]: expected a list"),
        ({"specimen.gauge_plus": None}, r"^specimen.gauge_minus, gauge_plus: expected both or none$"),
    ],
)
def test_what_does_not_fit_is_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(SceneError, match=message):
        outlined_beam().with_(**changes)
