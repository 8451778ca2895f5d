"""Large meshes from coarser ones: every cell is divided into similar ones, which takes a tenth of the time of meshing."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

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

#: the element at a hinge is halved towards it until the last part is this one: half of it is all that does not open there
LAST_AT_HINGE = 1 / 16

#: where a point of a curve belongs: (curve, (n, 2) points beside it) -> (n, 2)
Projection = Callable[[int, Array], Array]


def halvings(outline: Outline, sizes: MeshSizes) -> int:
    """How often a mesh of 2D cells is to be halved: 0 for one that gmsh makes at its sizes, at most 2."""
    lengths = segment_lengths(outline.crack)
    nodes = 1.15 * sizes.order * expected_cells(sizes, outline.area, sum(lengths), 2)  # 2 / 3**0.5: of equilateral triangles
    on_segment = min(lengths, default=math.inf) / sizes.crack_size
    wanted = sum(nodes > times * WHOLE_UP_TO for times in (1, 2))
    return max(n for n in range(wanted + 1) if n == 0 or on_segment >= 2**n * _LEAST_ON_SEGMENT)


def with_hinges(path: Line, hinges: Sequence[Point], size: float) -> Line:
    """A polyline whose last element of a size (mm), if it ends in a hinge, is halved towards it; one whose last segment is
    shorter stays as it is."""
    (x0, y0), (x, y) = path[-2:]
    length = math.dist(path[-2], path[-1])
    if (x, y) not in hinges or length < (1 + SLACK) * size:
        return path
    parts = [size / length * 0.5**i for i in range(1 + round(-math.log2(LAST_AT_HINGE)))]
    return [*path[:-1], *((x + part * (x0 - x), y + part * (y0 - y)) for part in parts), path[-1]]


def halved(mesh: meshio.Mesh, curves: Mapping[int, Index], project: Projection, times: int, order: int = 1) -> meshio.Mesh:
    """A mesh whose edges are halved some times.

    Parameters
    ----------
    mesh : meshio.Mesh
        Triangles and quadrilaterals of first order.
    curves : edges (n, 2) on each curved line of the outline.
    project : puts new nodes of these edges on their curve.
    times : number of halvings.
    order : of the elements in the end.

    Returns
    -------
    meshio.Mesh
        The blocks of `mesh` in their order, and its nodes before the new ones.
    """
    points, blocks = mesh.points, [(block.type, block.data) for block in mesh.cells]
    curves = dict(curves)
    for _ in range(times):
        points, mids, on_curve = _with_middles(points, blocks, curves, project)
        curves = {
            tag: np.concatenate([np.stack([ends[:, 0], on_curve[tag]], axis=1), np.stack([on_curve[tag], ends[:, 1]], axis=1)])
            for tag, ends in curves.items()
        }
        divided = []
        for (kind, cells), mid in zip(blocks, mids, strict=True):
            nodes = np.concatenate([cells, mid], axis=1)
            children = np.array(CELLS[kind].children)
            if children.max() == nodes.shape[1]:
                nodes = np.concatenate([nodes, len(points) + np.arange(len(cells))[:, None]], axis=1)
                points = np.concatenate([points, points[mid].mean(axis=1)])
            divided.append((kind, nodes[:, children].reshape(-1, children.shape[1])))
        blocks = divided
    if order == 2:
        points, mids, _ = _with_middles(points, blocks, curves, project)
        blocks = [
            (CELLS[kind].second_order, np.concatenate([cells, mid], axis=1))
            for (kind, cells), mid in zip(blocks, mids, strict=True)
        ]
    return meshio.Mesh(points, blocks)


def _with_middles(
    points: Array, blocks: list[tuple[str, Index]], curves: Mapping[int, Index], project: Projection
) -> tuple[Array, list[Index], dict[int, Index]]:
    """The points with the middles of all edges, their numbers for each cell, in the order of its edges, and on each curve."""
    n = len(points)
    ends = [cells[:, np.array(CELLS[kind].edges)] for kind, cells in blocks]
    key = np.concatenate([_key(pair.reshape(-1, 2), n) for pair in ends])
    edges, number = np.unique(key, return_inverse=True)
    first, second = np.divmod(edges, n)
    points = np.concatenate([points, 0.5 * (points[first] + points[second])])
    parts = np.split(n + number, np.cumsum([pair.shape[0] * pair.shape[1] for pair in ends])[:-1])
    mids = [part.reshape(pair.shape[:2]) for part, pair in zip(parts, ends, strict=True)]
    on_curve = {tag: n + np.searchsorted(edges, _key(line, n)) for tag, line in curves.items()}
    for tag, nodes in on_curve.items():
        points[nodes] = project(tag, points[nodes])
    return points, mids, on_curve


def _key(ends: Index, n: int) -> Index:
    """Edges (m, 2) as numbers, the same in both directions."""
    return np.asarray(ends.min(axis=1) * n + ends.max(axis=1))
