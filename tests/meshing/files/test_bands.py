"""A crack band in a user's own plane mesh: a set of elements, a row of them if it is one."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import meshio
import numpy as np
import pytest

from meshing import MeshError, MeshSizes, read_band_mesh
from tests.meshing.generation.test_band import BANDS
from tests.meshing.measures import areas, corners


def a_file(path: Path) -> Path:
    """Four unit squares in a row, the second one clockwise, the third one divided; the inner two form a set."""
    points = np.array([(x, y, 0.0) for y in (0.0, 1.0) for x in range(5)])
    cells = [
        ("quad", np.array([[0, 1, 6, 5], [1, 6, 7, 2], [3, 4, 9, 8]])),
        ("triangle", np.array([[2, 3, 8], [2, 8, 7]])),
        ("line", np.array([[0, 5]])),
    ]
    if path.suffix == ".inp":
        meshio.write(path, meshio.Mesh(points, cells))
        path.write_text(path.read_text() + "*ELSET, ELSET=MIDDLE\n2,4,5\n*ELSET, ELSET=BASE\n6\n")
    else:
        groups = {"bulk": np.array([1, 2]), "MIDDLE": np.array([2, 2]), "BASE": np.array([3, 1])}
        tag = [np.array([1, 2, 1]), np.array([2, 2]), np.array([3])]
        mesh = meshio.Mesh(points, cells, field_data=groups, cell_data={"gmsh:physical": tag, "gmsh:geometrical": tag})
        meshio.write(path, mesh, file_format="gmsh22", binary=False)
    return path


@pytest.mark.parametrize("format", ["inp", "msh"])
def test_a_users_band(tmp_path: Path, format: str) -> None:
    path = a_file(tmp_path / f"row.{format}")
    mesh = read_band_mesh(path, "MIDDLE")
    assert [(block.type, len(block.data)) for block in mesh.cells] == [("quad", 2), ("quad", 1), ("triangle", 2)]
    assert [len(i) for i in mesh.cell_sets["body"]] == [2, 0, 0]
    assert [len(i) for i in mesh.cell_sets["band"]] == [0, 1, 2]
    np.testing.assert_allclose(np.concatenate(areas(mesh)), [1, 1, 1, 0.5, 0.5])
    assert {tuple(p) for p in mesh.points[mesh.cells[1].data[0]]} == {(1, 0), (2, 0), (2, 1), (1, 1)}
    assert len(mesh.point_sets["MIDDLE"]) == 6
    assert len(mesh.point_sets["BASE"]) == 2
    plain = read_band_mesh(path)
    assert [(block.type, len(block.data)) for block in plain.cells] == [("quad", 3), ("triangle", 2)]
    assert list(plain.cell_sets) == ["body"]
    np.testing.assert_array_equal(plain.point_data["original"], np.arange(10))


def test_a_users_band_that_does_not_work_is_named(tmp_path: Path) -> None:
    path = a_file(tmp_path / "row.inp")
    with pytest.raises(MeshError, match=r"^band = 'FAULT': the file has no such set of elements; it has MIDDLE$"):
        read_band_mesh(path, "FAULT")
    with pytest.raises(MeshError, match=r"^band = 'BASE': no element of this set is one of triangle"):
        read_band_mesh(path, "BASE")
    with pytest.raises(MeshError, match="there is no such file"):
        read_band_mesh(tmp_path / "none.inp", "MIDDLE")
    mixed = meshio.Mesh(
        np.array([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.5, 0.0), (0.5, 0.5), (0.0, 0.5), (1.0, 1.0)]),
        [("triangle6", np.array([[0, 1, 2, 3, 4, 5]])), ("triangle", np.array([[1, 6, 2]]))],
    )
    mixed.points = np.column_stack([mixed.points, np.zeros(7)])
    mixed.write(tmp_path / "mixed.vtu")
    with pytest.raises(MeshError, match="mixes first and second order"):
        read_band_mesh(tmp_path / "mixed.vtu")


def squares(
    path: Path,
    nx: int,
    ny: int,
    inside: list[tuple[int, int]],
    order: int = 1,
    place: Callable[[float, float], tuple[float, float]] = lambda x, y: (x, y),
    point_sets: dict[str, list[tuple[float, float]]] | None = None,
) -> Path:
    """An Abaqus file of nx by ny unit squares, shuffled and each begun at some corner. Set MIDDLE: the squares `inside`, by
    column and row. Sets of nodes by their place on the grid; `place` moves them."""
    rng = np.random.default_rng(1)
    numbers: dict[tuple[float, float], int] = {}
    cells = []
    squares = [(i, j) for i in range(nx) for j in range(ny)]
    rng.shuffle(squares)
    for i, j in squares:
        ring = list(np.roll([(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)], rng.integers(4), axis=0))
        if order == 2:
            ring += [(a + b) / 2 for a, b in zip(ring, [*ring[1:], ring[0]], strict=True)]
        cells.append([numbers.setdefault((float(x), float(y)), len(numbers)) for x, y in ring])
    points = np.array([(*place(x, y), 0.0) for x, y in numbers])
    meshio.write(path, meshio.Mesh(points, [("quad" if order == 1 else "quad8", np.array(cells))]))
    members = [k + 1 for k, (i, j) in enumerate(squares) if (i, j) in inside]
    path.write_text(path.read_text() + f"*ELSET, ELSET=MIDDLE\n{','.join(map(str, members))}\n")
    for name, at in (point_sets or {}).items():
        path.write_text(path.read_text() + f"*NSET, NSET={name}\n{','.join(str(numbers[p] + 1) for p in at)}\n")
    return path


def centres(mesh: meshio.Mesh) -> list[tuple[float, float]]:
    """Of the band's elements, after a look at their order: minus to the right, the cell set, the mid nodes."""
    band = mesh.cells[-1]
    assert all(block.type != band.type or len(block.data) for block in mesh.cells)
    assert [len(i) for i in mesh.cell_sets["row"]] == [*(0 for _ in mesh.cells[:-1]), len(band.data)]
    for body, row, same in zip(*(mesh.cell_sets[name] for name in ("body", "row", "band")), strict=True):
        np.testing.assert_array_equal(row, same)
        assert not len(body) or not len(row)
    assert all((cells > 0).all() for cells in areas(mesh))
    assert set(np.concatenate([block.data.ravel() for block in mesh.cells])) == set(range(len(mesh.points)))
    np.testing.assert_array_equal(mesh.point_data["original"], np.arange(len(mesh.points)))
    if band.type == "quad8":
        np.testing.assert_array_equal(band.data[:, [5, 7]], band.data[:, [1, 3]])
        for mid, ends in ((4, [0, 1]), (6, [2, 3])):
            np.testing.assert_allclose(mesh.points[band.data[:, mid]], mesh.points[band.data[:, ends]].mean(axis=1), atol=1e-9)
    return [(float(x), float(y)) for x, y in corners(mesh, band).mean(axis=1)]


def first_side(mesh: meshio.Mesh) -> list[tuple[float, float]]:
    """a- and a+ of the first element of the band."""
    return [(float(x), float(y)) for x, y in mesh.points[mesh.cells[-1].data[0, [0, 3]]]]


@pytest.mark.parametrize("order", [1, 2])
def test_a_users_row(tmp_path: Path, order: int) -> None:
    path = squares(tmp_path / "row.inp", 3, 5, [(1, j) for j in range(5)], order)
    up = [(1.5, j + 0.5) for j in range(5)]
    #   direction, centres, a- and a+
    for along, expected, side in (
        (None, up, [(2, 0), (1, 0)]),
        ((0.0, 1.0), up, [(2, 0), (1, 0)]),
        ((0.6, 0.8), up, [(2, 0), (1, 0)]),
        ((0.0, -1.0), up[::-1], [(1, 5), (2, 5)]),
        ((1.0, 0.0), up, [(2, 0), (1, 0)]),  # across: as without
        ((0.0, 0.0), up, [(2, 0), (1, 0)]),
    ):
        mesh = read_band_mesh(path, "MIDDLE", along)
        assert [(block.type, len(block.data)) for block in mesh.cells] == [(("quad", "quad8")[order - 1], n) for n in (10, 5)]
        assert centres(mesh) == expected
        assert first_side(mesh) == side
        assert len(mesh.points) == (24 if order == 1 else 24 + 3 * 6 + 4 * 5 - 6)
    level = squares(tmp_path / "level.inp", 5, 3, [(i, 1) for i in range(5)], order)
    assert first_side(read_band_mesh(level, "MIDDLE")) == [(0, 1), (0, 2)]
    assert first_side(read_band_mesh(level, "MIDDLE", (-1.0, 0.3))) == [(5, 2), (5, 1)]


@pytest.mark.parametrize("order", [1, 2])
def test_a_users_kinked_row(tmp_path: Path, order: int) -> None:
    def place(x: float, y: float) -> tuple[float, float]:
        return x, y + max(x - 3, 0)

    path = squares(tmp_path / "kinked.inp", 6, 3, [(i, 1) for i in range(6)], order, place)
    expected = [(i + 0.5, 1.5 + max(i - 2.5, 0)) for i in range(6)]
    assert centres(read_band_mesh(path, "MIDDLE", (0.0, 1.0))) == expected
    assert centres(read_band_mesh(path, "MIDDLE", (0.0, -1.0))) == expected[::-1]


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("rows", [([(0, 0), (1, 0)], [(2, 1), (3, 1), (4, 1)]), ([(0, 0), (1, 0)], [(3, 1), (3, 2), (3, 3)])])
def test_two_rows_of_a_user(tmp_path: Path, rows: tuple[list[tuple[int, int]], ...], order: int) -> None:
    mesh = read_band_mesh(squares(tmp_path / "two.inp", 5, 4, [*rows[0], *rows[1]], order), "MIDDLE")
    order = [(int(x), int(y)) for x, y in centres(mesh)]
    assert order in ([*rows[0], *rows[1]], [*rows[1], *rows[0]])
    band = mesh.cells[-1].data
    joined = (band[1:, [0, 3]] == band[:-1, [1, 2]]).all(axis=1)
    assert len(joined) - joined.sum() == 1


@pytest.mark.parametrize("order", [1, 2])
def test_a_users_row_of_one(tmp_path: Path, order: int) -> None:
    between = squares(tmp_path / "between.inp", 3, 1, [(1, 0)], order)
    for along, side in ((None, [(2, 0), (1, 0)]), ((0.9, -0.1), [(1, 1), (2, 1)])):  # from one free edge to the other
        mesh = read_band_mesh(between, "MIDDLE", along)
        assert centres(mesh) == [(1.5, 0.5)]
        assert first_side(mesh) == side
        assert len(mesh.points) == (8 if order == 1 else 16)
    inside = squares(tmp_path / "inside.inp", 3, 3, [(1, 1)], order, lambda x, y: (2 * x, y))
    assert "row" not in read_band_mesh(inside, "MIDDLE").cell_sets
    assert first_side(read_band_mesh(inside, "MIDDLE", (1.0, 0.2))) == [(2, 1), (2, 2)]
    assert first_side(read_band_mesh(inside, "MIDDLE", (-0.6, -0.8))) == [(2, 2), (4, 2)]
    # a row of one beside a longer one, told by the free edges or not at all
    for ny, told in ((1, True), (3, False)):
        several = squares(tmp_path / f"{ny}.inp", 6, ny, [(1, ny // 2), (3, ny // 2), (4, ny // 2)], order)
        assert ("row" in read_band_mesh(several, "MIDDLE").cell_sets) == told
        assert len(centres(read_band_mesh(several, "MIDDLE", (1.0, 0.5)))) == 3


@pytest.mark.parametrize("along", [None, (0.0, 1.0)])
@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize(
    "inside",
    [
        [(i, j) for i in (1, 2) for j in range(4)],  # two wide
        [(1, 0), (1, 1), (2, 1), (2, 2)],  # round corners
        [(1, 0), (1, 1), (1, 2), (2, 1)],  # a branch
        [(i, j) for i in range(3) for j in range(3) if (i, j) != (1, 1)],  # a ring with corners
    ],
)
def test_a_users_band_that_is_not_a_row(
    tmp_path: Path, inside: list[tuple[int, int]], order: int, along: tuple[float, float] | None
) -> None:
    mesh = read_band_mesh(squares(tmp_path / "wide.inp", 4, 4, inside, order), "MIDDLE", along)
    assert list(mesh.cell_sets) == ["body", "band"]
    assert [len(i) for i in mesh.cell_sets["band"]] == [0, len(inside)]
    assert len(mesh.points) == (25 if order == 1 else 65)
    cells = mesh.cells[-1].data
    assert all(len(set(cell)) == cells.shape[1] for cell in cells)  # all their nodes


def test_triangles_and_rings_are_no_rows(tmp_path: Path) -> None:
    assert "row" not in read_band_mesh(a_file(tmp_path / "row.inp"), "MIDDLE", (1.0, 0.0)).cell_sets
    turn = np.linspace(0, 2 * np.pi, 9)[:-1]
    points = np.array([(r * np.cos(t), r * np.sin(t), 0.0) for r in (1, 2) for t in turn])
    cells = np.array([(i, i + 8, (i + 1) % 8 + 8, (i + 1) % 8) for i in range(8)])
    for n in (8, 7):
        path = tmp_path / f"ring{n}.inp"
        meshio.write(path, meshio.Mesh(points, [("quad", cells)]))
        path.write_text(path.read_text() + f"*ELSET, ELSET=MIDDLE\n{','.join(str(i + 1) for i in range(n))}\n")
        assert ("row" in read_band_mesh(path, "MIDDLE").cell_sets) == (n < 8)
    path = tmp_path / "odd.inp"  # an edge without length
    square = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0)])
    meshio.write(path, meshio.Mesh(square, [("quad", np.array([[0, 1, 2, 2]]))]))
    path.write_text(path.read_text() + "*ELSET, ELSET=MIDDLE\n1\n")
    assert "row" not in read_band_mesh(path, "MIDDLE", (1.0, 0.0)).cell_sets


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("name", ["beam", "kinked", "double", "slanted", "panel"])
def test_a_specimens_band_reads_as_it_was_made(tmp_path: Path, name: str, order: int) -> None:
    specimen, width, *_ = BANDS[name]
    made = specimen.mesh_band(MeshSizes(2.0, 8.0, order=order), width)
    path = tmp_path / "band.inp"
    meshio.write(path, meshio.Mesh(np.column_stack([made.points, np.zeros(len(made.points))]), made.cells), float_fmt=".16e")
    n_bulk, n_band = sum(len(block.data) for block in made.cells[:-1]), len(made.cells[-1].data)
    lines = "".join(f"{n_bulk + i + 1}\n" for i in range(n_band))
    path.write_text(path.read_text() + f"*ELSET, ELSET=MIDDLE\n{lines}")
    mesh = read_band_mesh(path, "MIDDLE", np.subtract(specimen.paths[0][-1], specimen.paths[0][0]))
    assert len(centres(mesh)) == n_band
    assert sorted(mesh.cells[-1].data.tolist()) == sorted(made.cells[-1].data.tolist())


def test_point_sets_follow_a_users_row(tmp_path: Path) -> None:
    """Nodes across the band go, save at its end inside the bulk; in a set the corners beside stand for them."""
    sets = {
        "BASE": [(x / 2, 0.0) for x in range(7)],
        "LOAD": [(1.5, 0.0)],
        "TIP": [(1.5, 3.0)],
        "SIDE": [(3.0, 0.5), (3.0, 1.0)],
        "CENTRE": [(1.5, 0.0), (1.5, 1.0), (1.5, 2.0)],
    }
    path = squares(tmp_path / "row.inp", 3, 5, [(1, j) for j in range(3)], order=2, point_sets=sets)
    mesh = read_band_mesh(path, "MIDDLE")
    assert centres(mesh) == [(1.5, 0.5), (1.5, 1.5), (1.5, 2.5)]
    assert len(mesh.points) == 62 - 3
    places = {name: sorted((float(x), float(y)) for x, y in mesh.points[nodes]) for name, nodes in mesh.point_sets.items()}
    assert places["BASE"] == sorted(p for p in sets["BASE"] if p != (1.5, 0.0))
    assert places["LOAD"] == [(1, 0), (2, 0)]
    assert places["TIP"] == [(1.5, 3)]
    assert places["SIDE"] == sets["SIDE"]
    assert places["CENTRE"] == [(x, y) for x in (1, 2) for y in (0, 1, 2)]
    assert len(places["MIDDLE"]) == 8 + 6 + 1


def test_nothing_is_printed(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    read_band_mesh(a_file(tmp_path / "row.msh"), "MIDDLE")
    assert capfd.readouterr().out == ""
    (tmp_path / "text.msh").write_text("nothing")
    with pytest.raises(MeshError, match=r"text.msh'"):
        read_band_mesh(tmp_path / "text.msh", "MIDDLE")
    assert capfd.readouterr() == ("", "")  # one sentence is enough


def test_elements_beside_a_crack_know_its_normal(tmp_path: Path) -> None:
    """Along y = 2 and then up x = 2, the plus side inside the angle: three squares, the one in the corner either way."""
    path = squares(tmp_path / "angle.inp", 4, 4, [])
    mesh = read_band_mesh(path, crack=[[(0.0, 2.0), (2.0, 2.0), (2.0, 4.0)]])
    assert list(mesh.cell_sets) == ["body", "band"]
    body, band = mesh.cell_data["normal"]
    assert not body.any()
    normals = dict(zip(map(tuple, mesh.points[mesh.cells[1].data].mean(axis=1)), map(tuple, band), strict=True))
    assert normals.pop((1.5, 2.5)) in normals.values()
    assert normals == {(0.5, 2.5): (0.0, 1.0), (1.5, 3.5): (-1.0, 0.0)}
    # a row tells by itself
    assert "normal" not in read_band_mesh(path, crack=[[(0.0, 2.0), (4.0, 2.0)]]).cell_data
