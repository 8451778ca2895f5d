"""Plane specimens: area, crack, sets, halves."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from cohesive.elements.bulk import ElasticBlock, elasticity
from meshing import MeshError, MeshSizes, NotchedBeam, NotchedTension, Outline, SingleCrack, mesh_polygon
from meshing.specimens.base import Gauge
from meshing.specimens.compact_tension import CompactTension
from meshing.specimens.l_panel import LPanel
from meshing.specimens.mixed_mode_plate import MixedModePlate
from meshing.specimens.wedge_splitting import WedgeSplitting

Index = NDArray[np.int64]


SPECIMENS = {
    "beam": (NotchedBeam(175, 125, 50, 50, 25, gauge=20.0), 175 * 50, 25),
    "eccentric, wide notch": (
        NotchedBeam(175, 125, 50, 50, 25, notch_position=20, notch_width=3, gauge=20.0),
        175 * 50 - 75,
        25,
    ),
    "bent path": (NotchedBeam(175, 125, 50, 50, 20, crack=[[0, 20], [4, 35], [4, 50]]), 175 * 50, np.hypot(4, 15) + 15),
    "double": (NotchedTension(120, 60, 50, 10, gauge=35.0), 120 * 60, 40),
    "double, wide": (NotchedTension(120, 60, 50, 10, notch_width=4, gauge=35.0), 120 * 60 - 80, 40),
    "single": (NotchedTension(120, 60, 50, 10, "single", 4, gauge=35.0), 120 * 60 - 40, 50),
    "block": (SingleCrack(40, 30, 10, angle=30), 1200, 40 / np.cos(np.radians(30))),
    "block, tips inside": (SingleCrack(40, 30, 10, angle=-70, crack_length=12, rotation=33, gauge=4), 1200, 12),
    "block, upright": (SingleCrack(40, 30, 10, angle=90), 1200, 30),
}


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("shape", ["triangle", "quad"])
@pytest.mark.parametrize("name", SPECIMENS)
def test_specimens(name: str, shape: str, order: int) -> None:
    specimen, area, crack = SPECIMENS[name]
    mesh = specimen.mesh(MeshSizes(2.0, 8.0, shape, order))
    blocks = [ElasticBlock(b.type, mesh.points, b.data, elasticity(1, 0, "stress"), 1.0) for b in mesh.cells[:-1]]
    assert sum(block.volumes().sum() for block in blocks) == pytest.approx(area, rel=1e-9)
    minus = mesh.cells[-1].data[:, :2]
    lengths = np.linalg.norm(mesh.points[minus[:, 1]] - mesh.points[minus[:, 0]], axis=1)
    assert lengths.sum() == pytest.approx(crack, rel=1e-9)
    assert lengths.max() < 1.35 * 2.0  # gmsh divides every piece evenly
    if shape == "quad":
        assert [b.type for b in mesh.cells[:-1]] == ["quad" if order == 1 else "quad8"]
    assert all(len(nodes) for nodes in mesh.point_sets.values())


@pytest.mark.parametrize("name", ["beam", "double", "single", "double, wide"])
def test_half_specimens(name: str) -> None:
    specimen, area, crack = SPECIMENS[name]
    mesh = specimen.mesh(MeshSizes(2.0, 8.0), half=True)
    block = ElasticBlock("triangle", mesh.points, mesh.cells[0].data, elasticity(1, 0, "stress"), 1.0)
    assert block.volumes().sum() == pytest.approx(area / 2, rel=1e-9)
    minus = mesh.points[mesh.cells[-1].data[:, :2]]
    assert np.linalg.norm(minus[:, 1] - minus[:, 0], axis=1).sum() == pytest.approx(crack, rel=1e-9)
    assert len(mesh.point_sets["load" if name == "beam" else "top"]) >= 2


def test_a_point_outside_the_body_is_named() -> None:
    with pytest.raises(MeshError, match=r"load = \(9, 9\): expected a point of the body"):
        mesh_polygon(Outline([(0, 0), (4, 0), (4, 4), (0, 4)], [[(2, 0), (2, 4)]], nodes={"load": [(9, 9)]}), MeshSizes(1, 1))


def test_a_mixed_mode_plate_keeps_the_bounds_of_its_kind() -> None:
    for changes, key in (({"notch": 30.0}, "notch"), ({"width": -60.0}, "width"), ({"notches": "single"}, "notches")):
        with pytest.raises(MeshError, match=f"^{key} = ") as caught:
            MixedModePlate(**{"length": 60.0, "width": 60.0, "thickness": 50.0, "notch": 5.0, **changes})
        assert caught.value.key == key


def test_an_l_panel_is_measured_at_its_corner_if_the_crack_begins_there() -> None:
    assert LPanel(500, 250, 100, 30).gauges() == {"cmod": Gauge("corner", "corner", (0.0, 1.0))}
    assert not LPanel(500, 250, 100, 30, crack=[[250, 200], [0, 200]]).gauges()
    assert LPanel(500, 250, 100, 30).outline().area == pytest.approx(3 * 250**2)
    assert LPanel(500, 250, 100, 30).mesh_band(MeshSizes(50.0, 100.0), 50.0).points.shape[1] == 2


def test_a_crack_in_a_block_may_be_shorter_than_a_millimetre() -> None:
    assert SingleCrack(40, 30, 10, crack_length=0.5).path_length == pytest.approx(0.5)


_WEDGE = {
    "width": 100.0, "height": 100.0, "thickness": 50.0, "groove_width": 20.0, "groove_depth": 20.0, "notch": 30.0,
    "roller_depth": 10.0, "support_span": 50.0,
}  # fmt: skip


@pytest.mark.parametrize("half", [False, True])
def test_a_wide_notch_of_a_wedge_splitting_block(half: bool) -> None:
    """Its area is missing, below the groove; its mouth are the two corners at the bottom of the groove."""
    bodies = [WedgeSplitting(notch_width=width, **_WEDGE) for width in (0.0, 4.0)]
    areas = [body.outline(half).area for body in bodies]
    assert areas[0] - areas[1] == pytest.approx(4.0 * _WEDGE["notch"] / (2 if half else 1))
    floor = _WEDGE["height"] - _WEDGE["groove_depth"]
    mouth = bodies[1].outline(half).nodes["mouth"]
    assert sorted(mouth) == ([(2.0, floor)] if half else [(-2.0, floor), (2.0, floor)])


def compact(**changes: Any) -> CompactTension:
    sizes: dict[str, Any] = {
        "shape": "rectangle", "width": 80.0, "height": 96.0, "front": 20.0, "thickness": 10.0, "notch": 32.0, "pins": 44.0,
    }  # fmt: skip
    return CompactTension(**sizes | changes)


def test_a_wide_notch_of_a_compact_specimen_is_measured_on_both_sides() -> None:
    nodes = compact(notch_width=4.0).outline().nodes
    for name, x in (("mouth", -20.0), ("gauge_plus", 0.0), ("gauge_minus", 0.0)):
        sides = {"mouth": [2.0, -2.0], "gauge_plus": [2.0], "gauge_minus": [-2.0]}[name]
        assert list(nodes[name]) == [(x, y) for y in sides]


@pytest.mark.parametrize(("off", "depth"), [(0.0, 32.0), (1e-3, None)])
def test_a_path_beside_the_tip_does_not_go_on_from_the_notch(off: float, depth: float | None) -> None:
    specimen = compact(crack=[[32.0 + off, 0.0], [80.0, 0.0]])
    assert specimen.notch_depth == depth
    assert ("tip" in specimen.outline().nodes) == ("ctod" in specimen.gauges()) == (depth is not None)


def test_a_beam_without_a_notch_is_measured_at_a_point() -> None:
    """The width of a notch that is not there does not count."""
    nodes = NotchedBeam(175.0, 125.0, 50.0, 50.0, 0.0, notch_width=3.0).outline().nodes
    assert list(nodes["mouth"]) == [(0.0, 0.0)] and "tip" not in nodes
