"""Random meshes of a plate whose load is known, in the formats that are read, whole and damaged.

A plate 100 x 60 x 20 mm with a crack plane of width w across its middle, pulled by u: E A u / (H + w), whatever its elements.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import meshio
import numpy as np
import pytest

from cohesive import SceneError, run
from cohesive.arrays import Array, Index
from meshing import MeshError
from meshing.cells import CELLS
from tests.meshing.files.plate import LOAD, scene

FORMATS = ["inp", "msh2", "msh2b", "msh4", "msh4b"]


def random_plate(rng: np.random.Generator) -> meshio.Mesh:
    """Squares or triangles or both, of first or second order, crooked but at the crack and the ends, in a random numbering."""
    nx, ny = rng.integers(1, 5), 2 * rng.integers(1, 4)
    x, y = np.linspace(0.0, 100.0, nx + 1), np.linspace(0.0, 60.0, ny + 1)
    X, Y = np.meshgrid(x, y)
    inside = np.ones_like(X, dtype=bool)
    inside[[0, ny // 2, ny]] = inside[:, [0, nx]] = False
    shift = rng.uniform(-0.2, 0.2, (2, *X.shape)) * inside
    points = np.column_stack([(X + shift[0] * 100.0 / nx).ravel(), (Y + shift[1] * 60.0 / ny).ravel()])
    i, j = np.meshgrid(np.arange(nx), np.arange(ny))
    a = (j * (nx + 1) + i).ravel()
    squares = np.column_stack([a, a + 1, a + nx + 2, a + nx + 1])
    split = rng.random(len(squares)) < rng.choice([0.0, 0.5, 1.0])
    triangles = np.concatenate([squares[split][:, [0, 1, 2]], squares[split][:, [0, 2, 3]]])
    blocks = [("quad", squares[~split]), ("triangle", triangles)]
    if rng.random() < 0.4:
        points, blocks = _second_order(points, blocks)
    order = rng.permutation(len(points))
    number = np.argsort(order)
    blocks = [(kind, number[rng.permutation(cells)]) for kind, cells in blocks if len(cells)]
    points = points[order]
    level = [np.flatnonzero(abs(points[:, 1] - at) < 1e-9) for at in (0.0, 30.0, 60.0)]
    sets = dict(zip(("bottom", "fault", "top"), level, strict=True))
    return meshio.Mesh(np.column_stack([points, np.zeros(len(points))]), blocks, point_sets=sets)


def _second_order(points: Array, blocks: list[tuple[str, Index]]) -> tuple[Array, list[tuple[str, Index]]]:
    """With a node in the middle of every edge."""
    mid: dict[tuple[int, int], int] = {}
    every, found = points.tolist(), []
    for kind, cells in blocks:
        rows = []
        for cell in cells.tolist():
            for a, b in CELLS[kind].edges:
                pair = (min(cell[a], cell[b]), max(cell[a], cell[b]))
                if pair not in mid:
                    mid[pair] = len(every)
                    every.append((0.5 * (points[pair[0]] + points[pair[1]])).tolist())
            rows.append(cell + [mid[min(cell[a], cell[b]), max(cell[a], cell[b])] for a, b in CELLS[kind].edges])
        if rows:
            found.append(({"quad": "quad8", "triangle": "triangle6"}[kind], np.array(rows, dtype=np.int64)))
    return np.array(every), found


def written(mesh: meshio.Mesh, folder: Path, form: str) -> Path:
    """The file with its sets: of nodes, or as groups of lines in gmsh's formats."""
    if form == "inp":
        path = folder / "plate.inp"
        mesh.write(path)
        return path
    kind = "line3" if any(block.type in ("quad8", "triangle6") for block in mesh.cells) else "line"
    cells, tags = [(block.type, block.data) for block in mesh.cells], [np.full(len(block), 9) for block in mesh.cells]
    for tag, nodes in enumerate(mesh.point_sets.values(), start=1):
        along = nodes[np.argsort(mesh.points[nodes, 0])]
        step = 2 if kind == "line3" else 1
        line = [along[:-1:step], along[step::step]] + ([along[1::2]] if step == 2 else [])
        cells.append((kind, np.column_stack(line)))
        tags.append(np.full(len(line[0]), tag))
    names = {name: np.array([tag, 1]) for tag, name in enumerate(mesh.point_sets, start=1)} | {"body": np.array([9, 2])}
    data = {"gmsh:physical": tags, "gmsh:geometrical": tags}
    grouped = meshio.Mesh(mesh.points, cells, cell_data=data, field_data=names)
    version = "gmsh22"  # meshio writes no groups of its own into version 4
    path = folder / "plate.msh"
    grouped.write(path, file_format=version, binary=form.endswith("b"))
    if form.startswith("msh4"):
        from meshing.generation.session import session

        with session() as gmsh:
            gmsh.open(str(path))
            gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
            gmsh.option.setNumber("Mesh.Binary", float(form.endswith("b")))
            gmsh.write(str(path))
    return path


def random_files(seed: int, folder: Path) -> Iterator[tuple[np.random.Generator, Path, str]]:
    """Ten files of random plates, each with what chose them and a name."""
    rng = np.random.default_rng(seed)
    for number in range(10):
        form = str(rng.choice(FORMATS))
        own = folder / f"{number}"
        own.mkdir()
        yield rng, written(random_plate(rng), own, form), f"{form}, number {number}"


@pytest.mark.long
@pytest.mark.parametrize("seed", range(20))
def test_whole_files_carry_the_load(seed: int, tmp_path: Path) -> None:
    """Ten of each seed: 200."""
    for _, path, what in random_files(seed, tmp_path):
        load = run(scene(path)).history["load"][-1]
        assert load == pytest.approx(LOAD, rel=1e-6), what


@pytest.mark.long
@pytest.mark.parametrize("seed", range(100, 150))
def test_damaged_files_carry_the_load_or_are_refused(seed: int, tmp_path: Path) -> None:
    """Cut short, a line gone or given twice, bytes changed: one sentence, or what was changed does not matter."""
    for rng, path, _ in random_files(seed, tmp_path):
        content, how = bytearray(path.read_bytes()), rng.integers(4)
        at = int(rng.integers(len(content)))
        if how == 0:
            content = content[:at]
        elif how == 1:
            content[at] = int(rng.integers(32, 127))
        else:
            lines = content.split(b"\n")
            at = int(rng.integers(len(lines)))
            lines[at : at + 1] = [] if how == 2 else [lines[at]] * 2
            content = bytearray(b"\n".join(lines))
        path.write_bytes(bytes(content))
        try:
            load = run(scene(path)).history["load"][-1]
        except (SceneError, MeshError) as refused:
            assert "\n" not in str(refused) and str(refused)
        else:
            assert np.isfinite(load)
