"""Large meshes from coarser ones: every cell is divided into similar ones, which takes a tenth of the time of meshing."""

from __future__ import annotations

import math
from collections.abc import Sequence

import meshio
import numpy as np

from ..arrays import Array, Index
from ..cells import CELLS
from ..paths import SLACK, Line, Point, segment_lengths
from .outline import Outline
from .sizes import MeshSizes, expected_cells

#: a mesh with more corners, those of second order counting twice, is made with twice the element size and halved once, with
#: more than twice as many halved twice
WHOLE_UP_TO = 20_000

#: least number of elements on each segment of the crack path before they are halved
_LEAST_ON_SEGMENT = 2

#: the element at a hinge is halved towards it so often: half of the last part is all that does not open there
_HALVED_AT_HINGE = 4


def halvings(outline: Outline, sizes: MeshSizes) -> int:
    """How often a mesh of 2D cells is to be halved: 0 for one that gmsh makes at its sizes, at most 2."""
    lengths = segment_lengths(outline.crack)
    nodes = 1.15 * sizes.order * expected_cells(sizes, outline.area, sum(lengths), 2)  # 2 / 3**0.5: of equilateral triangles
    on_segment = min(lengths, default=math.inf) / sizes.crack_size
    wanted = sum(nodes > times * WHOLE_UP_TO for times in (1, 2))
    return max(n for n in range(wanted + 1) if n == 0 or on_segment >= 2**n * _LEAST_ON_SEGMENT)


def halvings_at_hinge(outline: Outline, sizes: MeshSizes) -> int:
    """How often the element at a hinge is halved."""
    return max(0, min(_HALVED_AT_HINGE, math.floor(math.log2(sizes.crack_size / max(outline.least_size, 1e-300)))))


def with_hinges(path: Line, hinges: Sequence[Point], size: float, times: int) -> Line:
    """A polyline whose last element of a size (mm), if it ends in a hinge, is halved towards it some times; one whose last
    segment is shorter stays as it is."""
    (x0, y0), (x, y) = path[-2:]
    length = math.dist(path[-2], path[-1])
    if not times or (x, y) not in hinges or length < (1 + SLACK) * size:
        return path
    parts = [size / length * 0.5**i for i in range(times + 1)]
    return [*path[:-1], *((x + part * (x0 - x), y + part * (y0 - y)) for part in parts), path[-1]]


def halved(mesh: meshio.Mesh, times: int) -> meshio.Mesh:
    """A mesh of triangles and quadrilaterals of first order whose edges are halved some times: its blocks in their order, and
    its nodes before the new ones."""
    points, blocks = mesh.points, [(block.type, block.data) for block in mesh.cells]
    for _ in range(times):
        points, mids, _ = _with_middles(points, blocks)
        divided = []
        for (kind, cells), mid in zip(blocks, mids, strict=True):
            nodes = np.concatenate([cells, mid], axis=1)
            children = np.array(CELLS[kind].children)
            if children.max() == nodes.shape[1]:
                nodes = np.concatenate([nodes, len(points) + np.arange(len(cells))[:, None]], axis=1)
                points = np.concatenate([points, points[mid].mean(axis=1)])
            divided.append((kind, nodes[:, children].reshape(-1, children.shape[1])))
        blocks = divided
    return meshio.Mesh(points, blocks)


def with_mid_nodes(mesh: meshio.Mesh) -> meshio.Mesh:
    """A mesh of first order as one of second, its edges straight; a mid node joins the point sets that hold both its ends."""
    blocks = [(block.type, block.data) for block in mesh.cells]
    points, mids, edges = _with_middles(mesh.points, blocks)
    sets = {}
    for name, nodes in mesh.point_sets.items():
        inside = np.isin(edges, nodes).all(axis=1)
        sets[name] = np.concatenate([nodes, len(mesh.points) + np.flatnonzero(inside)])
    cells = [
        (CELLS[kind].second_order, np.concatenate([block, mid], axis=1))
        for (kind, block), mid in zip(blocks, mids, strict=True)
    ]
    return meshio.Mesh(points, cells, point_sets=sets)


def _with_middles(points: Array, blocks: list[tuple[str, Index]]) -> tuple[Array, list[Index], Index]:
    """The points with the middles of all edges, these by number for each cell, in the order of its edges; the edges (m, 2)."""
    n = len(points)
    ends = [np.sort(cells[:, np.array(CELLS[kind].edges)], axis=2) for kind, cells in blocks]
    key = np.concatenate([(pair[..., 0] * n + pair[..., 1]).ravel() for pair in ends])
    found, number = np.unique(key, return_inverse=True)
    edges = np.stack(np.divmod(found, n), axis=1)
    parts = np.split(n + number, np.cumsum([pair.shape[0] * pair.shape[1] for pair in ends])[:-1])
    mids = [part.reshape(pair.shape[:2]) for part, pair in zip(parts, ends, strict=True)]
    return np.concatenate([points, points[edges].mean(axis=1)]), mids, edges
