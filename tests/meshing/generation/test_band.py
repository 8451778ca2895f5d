"""Meshes for the crack band of specimens: one element wide, along the path."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from numpy.typing import NDArray

import meshing
from meshing import (
    MeshError,
    MeshSizes,
    NotchedBeam,
    NotchedTension,
    SandwichPanel,
    SingleCrack,
)
from tests.meshing.measures import areas, corners

Array = NDArray[np.float64]

SCENE = Path(meshing.__file__).parents[1] / "cohesive" / "scenes" / "builtin" / "notched-beam.toml"


def beam(**changes: Any) -> NotchedBeam:
    table = tomllib.loads(SCENE.read_text(encoding="utf-8"))["specimen"]
    return NotchedBeam(**{key: value for key, value in table.items() if key != "kind"} | changes)


def angles(mesh: meshio.Mesh, block: meshio.CellBlock) -> Array:
    """Inner angles in degrees; one that is negative or above 180 turns the Jacobian over."""
    p = corners(mesh, block)
    a, b = np.roll(p, -1, axis=1) - p, np.roll(p, 1, axis=1) - p
    return np.asarray(np.degrees(np.arctan2(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0], (a * b).sum(axis=2))))


#         specimen, width, area of the body, length of the path
BANDS: dict[str, tuple[Any, float, float, float]] = {
    "beam": (beam(), 2.0, 175 * 50 - 2 * 25, 25),
    "wide notch": (beam(notch_width=6.0), 2.0, 175 * 50 - 6 * 25, 25),
    "as wide as the notch": (beam(notch_width=2.0), 2.0, 175 * 50 - 2 * 25, 25),
    "no notch": (beam(notch=0.0), 2.0, 175 * 50, 50),
    "kinked": (beam(crack=[[0, 25], [0, 30], [6, 38], [6, 50]]), 2.0, 175 * 50 - 2 * 25, 27),
    "away from the slit": (beam(crack=[[20, 20], [20, 50]]), 2.0, 175 * 50, 30),
    "double": (NotchedTension(120, 60, 50, 10, gauge=35.0), 3.0, 120 * 60 - 2 * 30, 40),
    "single": (NotchedTension(120, 60, 50, 10, "single", gauge=35.0), 3.0, 120 * 60 - 30, 50),
    "two bands": (beam(crack=[[[0, 25], [0, 50]], [[30, 10], [30, 50]]]), 2.0, 175 * 50 - 2 * 25, 65),
    "slanted": (SingleCrack(40, 30, 10, angle=20), 2.0, 1200, 40 / np.cos(np.radians(20))),
    "steep": (SingleCrack(40, 30, 10, angle=45, rotation=33), 2.0, 1200, 30 * np.sqrt(2)),
    "tips inside": (SingleCrack(40, 30, 10, angle=-70, crack_length=12, rotation=33, gauge=4.0), 2.0, 1200, 12),
    "panel": (SandwichPanel(100, 60, 10), 10.0, 6000, 100),
}


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("shape", ["triangle", "quad"])
@pytest.mark.parametrize("name", BANDS)
def test_bands(name: str, shape: str, order: int) -> None:
    specimen, width, area, length = BANDS[name]
    mesh = specimen.mesh_band(MeshSizes(2.0, 8.0, shape, order), width)
    band = mesh.cells[-1]
    assert band.type == ("quad" if order == 1 else "quad8")
    triangle = "triangle" if order == 1 else "triangle6"
    n_triangles = sum(len(block.data) for block in mesh.cells[:-1] if block.type == triangle)
    share = n_triangles / sum(len(block.data) for block in mesh.cells[:-1])
    assert share == 1 if shape == "triangle" else share < 0.35
    *bulk, of_band = areas(mesh)
    assert all((cells > 0).all() for cells in (*bulk, of_band))
    assert of_band.sum() == pytest.approx(width * length, rel=1e-9)
    assert sum(cells.sum() for cells in bulk) + of_band.sum() == pytest.approx(area, rel=1e-9)
    assert set(np.concatenate([block.data.ravel() for block in mesh.cells])) == set(range(len(mesh.points)))
    # one element wide, along the path, minus to the right
    a_minus, b_minus, b_plus, a_plus = np.moveaxis(corners(mesh, band), 1, 0)
    centre = np.stack([(a_minus + a_plus) / 2, (b_minus + b_plus) / 2], axis=1)
    tangent = np.diff(centre, axis=1)[:, 0]
    size = np.hypot(*tangent.T)
    assert size.sum() == pytest.approx(length, rel=1e-9)
    assert size.max() < 1.35 * 2.0
    left = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1) / size[:, None]
    for minus, plus in ((a_minus, a_plus), (b_minus, b_plus)):
        np.testing.assert_allclose(((plus - minus) * left).sum(axis=1), width, rtol=1e-9)
    # cell after cell, path after path
    paths = [np.array(path) for path in specimen.paths]
    starts = np.flatnonzero(np.r_[True, (band.data[1:, [0, 3]] != band.data[:-1, [1, 2]]).any(axis=1)])
    np.testing.assert_allclose(centre[starts, 0], [path[0] for path in paths], atol=1e-9)
    np.testing.assert_allclose(centre[np.r_[starts[1:], len(centre)] - 1, 1], [path[-1] for path in paths], atol=1e-9)
    if order == 2:
        for mid, a, b in ((4, 0, 1), (6, 2, 3)):
            middle = mesh.points[band.data[:, [a, b]]].mean(axis=1)
            np.testing.assert_allclose(mesh.points[band.data[:, mid]], middle, atol=1e-9)
        np.testing.assert_array_equal(band.data[:, [5, 7]], band.data[:, [1, 3]])
    # sets
    body, rows = mesh.cell_sets["body"], mesh.cell_sets["band"]
    assert [len(i) for i in body] == [*(len(block.data) for block in mesh.cells[:-1]), 0]
    assert [len(i) for i in rows] == [*(0 for _ in bulk), len(band.data)]
    assert all(len(nodes) for nodes in mesh.point_sets.values())


def test_original_counts_nodes_before_a_slit_was_cut() -> None:
    for name, copies in (("beam", False), ("away from the slit", True)):
        specimen, width, *_ = BANDS[name]
        mesh = specimen.mesh_band(MeshSizes(2.0, 8.0), width)
        original = mesh.point_data["original"]
        assert (len(np.unique(original)) < len(original)) == copies
        np.testing.assert_array_equal(original[: original.max() + 1], np.arange(original.max() + 1))


@pytest.mark.parametrize("shape", ["triangle", "quad"])
@pytest.mark.parametrize("width", [0.5, 1.0, 5.0, 10.0])
def test_square_elements_of_any_width(width: float, shape: str) -> None:
    mesh = beam().mesh_band(MeshSizes(width, max(8.0, width), shape), width)
    *bulk, band = mesh.cells
    np.testing.assert_allclose(angles(mesh, band), 90.0, atol=1e-6)
    # 23.6 degrees with gmsh 4.12, above 25 with later ones
    assert min(angles(mesh, block).min() for block in bulk) > 22.5
    assert max(angles(mesh, block).max() for block in bulk) < 160.0
    # the notch is opened to the width of the band: no node lies in it, and its corners are those of the band
    x, y = mesh.points.T
    assert not ((abs(x) < width / 2 - 1e-9) & (y < 50.0 - 1e-9)).any()
    np.testing.assert_allclose(mesh.points[band.data[0, [0, 3]]], [[width / 2, 25.0], [-width / 2, 25.0]], atol=1e-9)


def test_a_slanted_band_opens_the_notch_to_its_slanted_end() -> None:
    mesh = beam(crack=[[0, 25], [15, 50]]).mesh_band(MeshSizes(2.0, 8.0), 2.0)
    half = np.hypot(15, 25) / 25
    for cell, nodes, y in ((0, [0, 3], 25.0), (-1, [1, 2], 50.0)):
        ends = mesh.points[mesh.cells[-1].data[cell, nodes]]
        np.testing.assert_allclose(ends[:, 1], y, atol=1e-9)
        np.testing.assert_allclose(np.ptp(ends[:, 0]), 2 * half, rtol=1e-9)
    floor = mesh.points[abs(mesh.points[:, 1]) < 1e-9, 0]
    assert abs(floor).min() == pytest.approx(half, rel=1e-9)


@pytest.mark.parametrize("order", [1, 2])
def test_a_point_on_an_end_of_the_band_stands_for_that_end(order: int) -> None:
    mesh = beam().mesh_band(MeshSizes(2.0, 8.0, order=order), 4.0)
    np.testing.assert_allclose(
        sorted(map(tuple, mesh.points[mesh.point_sets["load"]])),
        [(-2.0, 50.0), (2.0, 50.0)],
        atol=1e-9,
    )
    assert [len(mesh.point_sets[name]) for name in ("support_left", "support_right", "gauge_plus", "gauge_minus")] == [1] * 4
    # a point on a corner of the band has a node of its own
    at_corner = beam(notch=0.0, gauge=4.0).mesh_band(MeshSizes(2.0, 8.0, order=order), 4.0)
    assert [len(at_corner.point_sets[name]) for name in ("load", "gauge_plus", "gauge_minus")] == [2, 1, 1]


def crack(*paths: list[tuple[float, float]], **changes: Any) -> NotchedBeam:
    return beam(**({"gauge": 0.0} | changes), crack=[[list(p) for p in path] for path in paths])


@pytest.mark.parametrize(
    ("specimen", "width", "message"),
    [
        (beam(), -1.0, r"band.width = -1.0: expected a finite number above 0"),
        (beam(notch_width=2.0), 5.0, r"wider than the notch at \(0, 25\), notch_width = 2; expected at most 2$"),
        (beam(gauge=0.0), 180.0, r"band.width = 180: the band leaves the body at \(0, 50\); expected at most 175"),
        (crack([(86, 0), (86, 50)]), 5.0, r"the band leaves the body at \(86, 0\); expected at most 3$"),
        (crack([(-20, 48), (20, 48)]), 5.0, r"the band leaves the body at \(0, 50\)"),
        (crack([(0, 25), (30, 49), (40, 45)]), 5.0, "the band leaves the body"),
        (crack([(-10, 50), (-10, 60), (10, 60), (10, 50)]), 2.0, r"the band leaves the body at \(-10, 55\)"),
        (crack([(-30, 26), (30, 26)], notch_width=4.0), 2.0, r"the band leaves the body at \(-2, 25\)"),
        (
            NotchedTension(20, 60, 50, 10),
            21.0,
            r"the notch at \(-30, 0\), opened to 21 mm, leaves the body; expected less than 20",
        ),
        (crack([(-20, 20), (20, 20)]), 2.0, r"band.width = 2: the band runs into the notch at \(0, 20\)"),
        (crack([(0, 25), (0, 60)]), 2.0, r"the crack path ends outside the body, at \(0, 60\)"),
        (crack([(0, 25), (40, 26)]), 2.0, r"leaves the tip of the notch at \(0, 25\) sideways"),
        (crack([(40, 0), (60, 2)]), 2.0, r"meets the edge of the body at \(40, 0\) at 6 degrees; expected at least 15"),
        (SingleCrack(40, 40, 10, angle=45), 2.0, r"ends in a corner of the body, at \(-20, -20\)"),
        (crack([(0, 25), (0, 40), (0.2, 20)]), 1.0, r"turns too sharply at \(0, 40\)"),
        (
            crack([(0, 25), (0, 30), (4, 31), (4, 34), (0, 35)]),
            6.0,
            r"from \(4, 31\) to \(4, 34\) is too short .* at most 3.07",
        ),
        (crack([(0, 25), (0, 40), (10, 40), (10, 30), (-9, 30)]), 2.0, r"the crack path overlaps itself at \(0, 30\)"),
        (crack([(0, 25), (0, 44), (20, 38), (-10, 29)]), 2.0, r"the crack path overlaps itself at \(0, 32\)"),
        (crack([(0, 25), (0, 50)], [(0, 35), (20, 40)]), 2.0, r"two crack paths overlap .* band.where = \"everywhere\""),
        (crack([(-20, 35), (20, 45)], [(-20, 45), (20, 35)]), 2.0, r"two crack paths overlap at \(0, 40\); .* \"everywhere\""),
        (crack([(0, 25), (0, 35)], [(0, 35), (0, 50)]), 2.0, r"two crack paths overlap at \(0, 35\)"),
        (beam(), 21.0, r"gauge_plus = \(-10, 0\): it falls into the notch, which band.width = 21 opens to 21 mm"),
        (beam(notch=0.0, gauge=5.0), 8.0, r"gauge_minus = \(2.5, 0\): it shares an end of the band"),
        (SingleCrack(40, 30, 10, gauge=4.0), 6.0, r"gauge_minus = .*: it lies in the band, band.width = 6; .* more than 3 mm"),
    ],
)
def test_a_band_that_does_not_fit_is_named(specimen: Any, width: float, message: str) -> None:
    with pytest.raises(MeshError, match=message):
        specimen.mesh_band(MeshSizes(2.0, 8.0), width)


def test_the_width_that_a_message_allows_is_allowed() -> None:
    specimen = crack([(0, 25), (0, 30), (4, 31), (4, 34), (0, 35)])
    assert len(specimen.mesh_band(MeshSizes(1.0, 8.0), 3.07).cells[-1].data)


def test_a_band_needs_the_whole_body() -> None:
    with pytest.raises(MeshError, match="half = true"):
        meshing.mesh_band(beam().outline(half=True), MeshSizes(2.0, 8.0), 1.0)


def test_an_inner_or_bent_slit_cannot_be_opened() -> None:
    square = [(0.0, 0.0), (9.0, 0.0), (9.0, 9.0), (0.0, 9.0)]
    for slit in ([(2.0, 2.0), (2.0, 4.0)], [(0.0, 2.0), (2.0, 2.0), (2.0, 4.0)]):
        with pytest.raises(MeshError, match=r"the notch that ends at \(2, 4\): expected a straight one from the outline"):
            meshing.mesh_band(meshing.Outline(square, [[(2.0, 4.0), (2.0, 9.0)]], [slit]), MeshSizes(1.0, 1.0), 1.0)


@pytest.mark.parametrize("shape", ["triangle", "quad"])
@pytest.mark.parametrize("name", ["beam", "wide notch", "double", "tips inside", "panel"])
def test_the_plain_body(name: str, shape: str) -> None:
    specimen, *_ = BANDS[name]
    mesh = specimen.mesh_body(MeshSizes(1.0, 8.0, shape))
    assert [block.type for block in mesh.cells] == [shape]
    assert list(mesh.cell_sets) == ["body"]
    whole = specimen.mesh(MeshSizes(1.0, 8.0, shape))
    assert areas(mesh)[0].sum() == pytest.approx(sum(a.sum() for a in areas(whole)[:-1]), rel=1e-9)
    assert (areas(mesh)[0] > 0).all()
    assert mesh.point_sets.keys() == whole.point_sets.keys()
    # fine near the path, free of it
    path = np.array(specimen.paths[0])
    inner = path[0] + np.linspace(0.1, 0.9, 50)[:, None] * (path[-1] - path[0])
    distance = np.hypot(*np.moveaxis(corners(mesh, mesh.cells[0]).mean(axis=1)[:, None] - inner, 2, 0)).min(axis=1)
    assert np.median(areas(mesh)[0][distance < 1.0]) < 2.0
    assert areas(mesh)[0].max() > 8.0
    tangent = (path[-1] - path[0]) / np.hypot(*(path[-1] - path[0]))
    across = abs((mesh.points - path[0]) @ [-tangent[1], tangent[0]])
    along = (mesh.points - path[0]) @ tangent / np.hypot(*(path[-1] - path[0]))
    assert ((across < 1e-9) & (along > 0.05) & (along < 0.95)).sum() < 0.5 * np.hypot(*(path[-1] - path[0]))
    # slits are cut up to their tip
    original = mesh.point_data["original"]
    slits = specimen.outline().slits
    assert (len(original) > original.max() + 1) == bool(slits)
    for slit in slits:
        on = [sum(np.hypot(*(mesh.points - p).T) < 1e-9) for p in slit]
        assert sorted(on) == [1, 2]


def test_the_panel_has_a_discrete_crack_too() -> None:
    panel = SandwichPanel(100, 60, 10)
    mesh = panel.mesh(MeshSizes(5.0, 10.0))
    assert len(mesh.cells[-1].data) == 20
    assert set(mesh.point_sets) == {"base", "top"}
    np.testing.assert_allclose(mesh.points[mesh.point_sets["top"], 1], 30.0)
    assert panel.symmetry() is None
    with pytest.raises(MeshError, match="height = 0: expected a number above 0"):
        SandwichPanel(100, 0, 10)


def test_an_edge_beside_a_corner_that_points_inwards_is_no_notch() -> None:
    """The ledge of an L, 2 mm long, too narrow for a band; the end of a notch has such a corner at both ends."""
    ledge = [(0.0, 0.0), (4.0, 0.0), (4.0, 2.0), (2.0, 2.0), (2.0, 4.0), (0.0, 4.0)]
    with pytest.raises(MeshError, match=r"^band.width = 2: the band leaves the body at \(2.5, 2\); expected at most 1$"):
        meshing.mesh_band(meshing.Outline(ledge, [[(2.5, 2.0), (2.5, 0.0)]]), MeshSizes(0.5, 0.5), 2.0)


def test_points_at_a_notch_that_a_band_opens() -> None:
    """A slit from the right side, 4 mm long, becomes a notch 2 mm wide: a point on it two on its sides, one that falls into it
    is refused, as is one in the band, one beside it stays."""
    square = [(1.0, 1.0), (11.0, 1.0), (11.0, 11.0), (1.0, 11.0)]
    slit, crack = [(11.0, 6.0), (7.0, 6.0)], [[(7.0, 6.0), (1.0, 6.0)]]

    def mesh(point: tuple[float, float]) -> meshio.Mesh:
        outline = meshing.Outline(square, crack, [slit], nodes={"here": [point]})
        return meshing.mesh_band(outline, MeshSizes(2.0, 2.0), 2.0)

    for point, expected in (
        ((9.0, 6.0), [[9.0, 5.0], [9.0, 7.0]]), ((11.0, 6.0), [[11.0, 5.0], [11.0, 7.0]]), ((9.0, 8.0), [[9.0, 8.0]]),
    ):  # fmt: skip
        whole = mesh(point)
        at = whole.points[whole.point_sets["here"]]
        np.testing.assert_allclose(at[np.argsort(at[:, 1])], expected, atol=1e-9)
    with pytest.raises(MeshError, match=r"^here = \(9, 6.5\): it falls into the notch, which band.width = 2 opens to 2 mm"):
        mesh((9.0, 6.5))
    with pytest.raises(MeshError, match=r"^here = \(4, 6.5\): it lies in the band"):
        mesh((4.0, 6.5))
