"""One suite for every row of the table of cell types: a new row is tested by being there."""

from __future__ import annotations

from collections import Counter
from itertools import combinations

import meshio
import numpy as np
import pytest

from meshing.arrays import Array
from meshing.cells import BULK_2D, BULK_3D, CELLS, counter_clockwise
from meshing.generation.session import session

BULK = BULK_2D + BULK_3D
CRACK = sorted({CELLS[kind].crack_cell for kind in BULK})


def _with_mids(corners: list[tuple[float, ...]], ends: list[tuple[int, int]]) -> Array:
    points = np.array(corners, dtype=float)
    return np.concatenate([points, points[np.array(ends, dtype=int).reshape(-1, 2)].mean(axis=1)])


_LINE = [(-1.0,), (1.0,)]
_TRIANGLE = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]
_QUAD = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
_TETRA = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]
_WEDGE = [(*p, z) for z in (-1.0, 1.0) for p in _TRIANGLE]
_RING = [(0, 1), (1, 2), (2, 3), (3, 0)]
#: cells of gmsh's reference coordinates in the node order of meshio's documentation (that of VTK)
REFERENCE: dict[str, Array] = {
    "line": _with_mids(_LINE, []),
    "line3": _with_mids(_LINE, [(0, 1)]),
    "triangle": _with_mids(_TRIANGLE, []),
    "triangle6": _with_mids(_TRIANGLE, [(0, 1), (1, 2), (2, 0)]),
    "quad": _with_mids(_QUAD, []),
    "quad8": _with_mids(_QUAD, _RING),
    "quad9": np.concatenate([_with_mids(_QUAD, _RING), [[0.0, 0.0]]]),
    "tetra": _with_mids(_TETRA, []),
    "tetra10": _with_mids(_TETRA, [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]),
    "hexahedron": _with_mids([(*p, z) for z in (-1.0, 1.0) for p in _QUAD], []),
    "wedge": _with_mids(_WEDGE, []),
    "wedge15": _with_mids(_WEDGE, [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)]),
}


def _cross(u: Array, v: Array) -> float:
    return float(u[0] * v[1] - u[1] * v[0])


def _normal(points: Array) -> Array:
    """Of a facet: to the left of an edge, (b - a) x (c - a) of a face."""
    if points.shape[1] == 2:
        (x, y) = points[1] - points[0]
        return np.array([-y, x])
    return np.asarray(np.cross(points[1] - points[0], points[2] - points[0]))


def _size(kind: str, points: Array) -> float:
    """Signed area or volume, by the divergence theorem over the facets; their normals point into the cell."""
    cell, total = CELLS[kind], 0.0
    for facet in cell.facets:
        ring = points[list(facet[: cell.facet_corners])]
        if cell.dimension == 2:
            total += 0.5 * _cross(*ring)
        else:
            fan = [(ring[0], ring[i], ring[i + 1]) for i in range(1, len(ring) - 1)]
            total -= sum(float(np.linalg.det(np.stack(triangle))) for triangle in fan) / 6
    return total


def _ring(facet: tuple[int, ...], corners: int) -> list[tuple[int, int]]:
    return [(facet[i], facet[(i + 1) % corners]) for i in range(corners)]


@pytest.mark.parametrize("kind", CELLS)
def test_meshio_knows_the_cell_and_its_dimension(kind: str) -> None:
    points, cell = REFERENCE[kind], CELLS[kind]
    mesh = meshio.Mesh(points, [(kind, [list(range(len(points)))])])
    assert mesh.cells[0].dim == cell.dimension == points.shape[1]


@pytest.mark.parametrize("kind", [kind for kind, cell in CELLS.items() if cell.gmsh is not None])
def test_gmsh_has_the_same_nodes_in_the_same_order(kind: str) -> None:
    with session() as gmsh:
        _, dimension, order, n_nodes, local, n_corners = gmsh.model.mesh.getElementProperties(CELLS[kind].gmsh)
    points, cell = REFERENCE[kind], CELLS[kind]
    assert (dimension, n_nodes, n_corners) == (cell.dimension, len(points), cell.n_corners)
    assert order == (1 if len(points) == cell.n_corners else 2)
    np.testing.assert_allclose(np.reshape(local, points.shape), points)


@pytest.mark.parametrize(("kind", "number"), [("tetra10", 11), ("wedge15", 18)])
def test_a_cell_without_gmsh_number_has_another_node_order_there(kind: str, number: int) -> None:
    with session() as gmsh:
        local = np.reshape(gmsh.model.mesh.getElementProperties(number)[4], REFERENCE[kind].shape)
    assert not np.allclose(local, REFERENCE[kind])
    assert {tuple(p) for p in local.tolist()} == {tuple(p) for p in REFERENCE[kind].tolist()}


def test_gmsh_numbers_differ() -> None:
    numbers = [cell.gmsh for cell in CELLS.values() if cell.gmsh is not None]
    assert len(set(numbers)) == len(numbers)


@pytest.mark.parametrize("kind", BULK)
def test_facets_close_and_face_the_cell(kind: str) -> None:
    points, cell = REFERENCE[kind], CELLS[kind]
    k = cell.facet_corners
    for facet in cell.facets:
        assert set(facet[:k]) <= set(range(cell.n_corners))
        at = points[list(facet[:k])]
        assert _normal(at) @ (points.mean(axis=0) - at.mean(axis=0)) > 0
    if cell.dimension == 2:
        assert not cell.faces
        assert sorted(f[0] for f in cell.facets) == sorted(f[1] for f in cell.facets) == list(range(cell.n_corners))
    else:
        directed = Counter(edge for face in cell.faces for edge in _ring(face, k))
        assert set(directed.values()) == {1}
        assert all(directed[b, a] == 1 for a, b in directed)
    assert {node for facet in cell.facets for node in facet} == set(range(len(points)))
    assert _size(kind, points) > 0


@pytest.mark.parametrize("kind", BULK)
def test_edges_are_those_of_the_facets_with_their_mid_nodes(kind: str) -> None:
    points, cell = REFERENCE[kind], CELLS[kind]
    k = cell.facet_corners
    edges = {frozenset(edge[:2]): edge[2:] for edge in cell.edges}
    assert len(edges) == len(cell.edges)
    if cell.dimension == 3:
        assert set(edges) == {frozenset(edge) for face in cell.faces for edge in _ring(face, k)}
        for face in cell.faces:
            assert list(face[k:]) == [mid for edge in _ring(face, k) for mid in edges[frozenset(edge)]]
    for edge in cell.edges:
        for mid in edge[2:]:
            np.testing.assert_allclose(points[mid], points[list(edge[:2])].mean(axis=0))
    mids = [mid for edge in cell.edges for mid in edge[2:]]
    assert mids == list(range(cell.n_corners, len(points)))


@pytest.mark.parametrize("kind", BULK)
def test_a_flip_is_its_own_inverse_and_reverses_the_orientation(kind: str) -> None:
    points, cell = REFERENCE[kind], CELLS[kind]
    flip = list(cell.flip)
    assert [flip[i] for i in flip] == list(range(len(points)))
    flipped = points[flip]
    assert _size(kind, flipped) == pytest.approx(-_size(kind, points))
    for edge in cell.edges:
        for mid in edge[2:]:
            np.testing.assert_allclose(flipped[mid], flipped[list(edge[:2])].mean(axis=0))


@pytest.mark.parametrize("kind", BULK_3D)
def test_neighbours_tell_an_inverted_cell(kind: str) -> None:
    points, cell = REFERENCE[kind], CELLS[kind]
    edges = {frozenset(edge[:2]) for edge in cell.edges}
    for i, beside in enumerate(cell.neighbours):
        assert all(frozenset((i, j)) in edges for j in beside)
        for at, sign in ((points, 1.0), (points[list(cell.flip)], -1.0)):
            assert sign * np.linalg.det(at[list(beside)] - at[i]) > 0
    assert len(cell.neighbours) in (1, cell.n_corners)  # one corner tells all of a tetrahedron


@pytest.mark.parametrize("kind", BULK)
def test_a_crack_cell_has_the_minus_side_first_and_opens_to_the_plus_side(kind: str) -> None:
    cell = CELLS[kind]
    crack, k = CELLS[cell.crack_cell], cell.facet_corners
    columns = np.array(crack.crack_columns)
    assert (crack.dimension, crack.facet_corners, crack.n_corners) == (cell.dimension, k, 8 if k == 4 else 2 * k)
    for facet in cell.facets:
        n = len(facet)
        minus, plus = columns[:k], columns[k : 2 * k]
        np.testing.assert_array_equal(minus, np.arange(k))
        np.testing.assert_array_equal(plus - n, minus[::-1] if cell.dimension == 2 else minus)  # a quadrilateral goes round
        corners = REFERENCE[kind][list(facet[:k])]
        sides = corners, corners + _normal(corners)
        if cell.dimension == 2:
            assert _size("quad", np.concatenate([sides[0], sides[1][::-1]])) > 0
        else:
            assert _normal(sides[0]) @ (sides[1] - sides[0]).mean(axis=0) > 0


@pytest.mark.parametrize("kind", BULK)
def test_mid_nodes_of_a_crack_cell_lie_along_it_and_corners_stand_in_across_it(kind: str) -> None:
    cell = CELLS[kind]
    crack, reference = CELLS[cell.crack_cell], REFERENCE[cell.crack_cell]
    columns = np.array(crack.crack_columns)
    assert len(columns) == len(reference)
    for facet in cell.facets:
        minus = REFERENCE[kind][list(facet)]
        nodes = np.concatenate([minus, minus + _normal(minus[: cell.facet_corners])])[columns]
        for i in range(crack.n_corners, len(columns)):
            pairs = combinations(range(crack.n_corners), 2)
            ((a, b),) = [ends for ends in pairs if np.allclose(reference[list(ends)].mean(axis=0), reference[i])]
            is_minus = columns[[a, b]] < len(facet)
            if is_minus[0] == is_minus[1]:
                np.testing.assert_allclose(nodes[i], nodes[[a, b]].mean(axis=0))
            else:
                assert columns[i] in columns[[a, b]]


@pytest.mark.parametrize("kind", CRACK)
def test_a_crack_cell_says_where_its_nodes_stand(kind: str) -> None:
    assert CELLS[kind].crack_columns


@pytest.mark.parametrize("kind", BULK_2D)
def test_clockwise_cells_are_flipped_and_no_others(kind: str) -> None:
    points, flip = REFERENCE[kind], list(CELLS[kind].flip)
    upright = np.arange(len(points))
    cells = counter_clockwise(points, kind, np.stack([upright, upright[flip]]))
    np.testing.assert_array_equal(cells, [upright, upright])
