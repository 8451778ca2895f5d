"""A user's own plane mesh: read, checked, and cut along a named set or a polyline, or with the band it names."""

from __future__ import annotations

import io
from collections.abc import Iterable, Sequence
from contextlib import redirect_stdout
from pathlib import Path

import meshio
import numpy as np
from numpy.typing import ArrayLike, NDArray

from .cracks import Line, bulk_cells, edges_on_path, insert_cracks
from .errors import MeshError
from .plane import SLACK, counter_clockwise
from .star import EDGES

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Blocks = list[tuple[str, Index]]


def read_mesh(path: str | Path, crack: str | Sequence[Line]) -> meshio.Mesh:
    """Read a plane mesh in any format that meshio knows and insert its crack.

    Parameters
    ----------
    path : file with triangle, quad, triangle6 or quad8 cells in the x-y plane, lengths in mm.
    crack : name of a set of line cells (or of nodes) on the crack path, or polylines that follow element edges.

    Returns
    -------
    meshio.Mesh
        As `insert_cracks` gives it. Its point sets are the file's point sets and the nodes of its cell sets
        (gmsh's physical groups included).

    Raises
    ------
    MeshError
        If the file cannot be read, is not plane, has non-finite coordinates or lacks the named set.
    """
    path = Path(path)
    mesh = _load(path)
    lines, sets = _named_sets(mesh)
    clean, index, _ = _plane(path, mesh, sets)
    if not isinstance(crack, str):
        return insert_cracks(clean, edges_on_path(clean, "crack", crack))
    if crack not in sets:
        raise MeshError(f"crack = '{crack}': the file has no such set; it has {_listed(sets)}")
    return insert_cracks(clean, _set_edges(crack, clean, lines.get(crack), clean.point_sets[crack], index))


def read_band_mesh(path: str | Path, cells: str | None = None, along: ArrayLike | None = None) -> meshio.Mesh:
    """Read a plane mesh in any format that meshio knows, some of whose elements form the crack band.

    A set that is one row of quadrilaterals or several, each one element wide, is put in the order of `mesh_band`. In such a
    row each element shares at most two edges with others of the set, opposite ones, and the row does not close on itself.
    A single element is a row from one free edge to the opposite one, if its two other edges are shared with the bulk;
    otherwise it is one only with `along`, between the two opposite edges that `along` joins best.

    Parameters
    ----------
    path : file with triangle, quad, triangle6 or quad8 cells in the x-y plane, lengths in mm.
    cells : name of the set of elements that form the band; None: all of them are the body, which may crack anywhere.
    along : (2,) direction of the crack path, of any length. A row runs from end to end so that (end - start) . along > 0;
        without it, or across it, from the end with the smaller x, then y.

    Returns
    -------
    meshio.Mesh
        Blocks of the bulk, then those of the band, in the order of the file. Cell sets `body` and, with `cells`, `band`.
        Point sets as those of `read_mesh`. `point_data["original"]` is 0, 1, 2, ...

        Where the band is rows, one block of it, row after row in the order of the file, and a cell set `row`, the same as
        `band`: `quad` [a-, b-, b+, a+], a to b along the row, the minus side to its right, or `quad8`
        [a-, b-, b+, a+, mid-, b-, mid+, a+]. The mid nodes across the band are left out, unless an element of the bulk
        uses them; in a point set the two corners beside it stand for such a node.

    Raises
    ------
    MeshError
        If the file cannot be read, is not plane, has non-finite coordinates, mixes orders, or lacks the named set or
        elements in it.
    """
    path = Path(path)
    mesh = _load(path)
    _, sets = _named_sets(mesh)
    members = _members(mesh)
    if cells is not None and cells not in members:
        able = [
            name for name, at in members.items() if any(len(i) for b, i in zip(mesh.cells, at, strict=True) if b.type in EDGES)
        ]
        raise MeshError(f"band = '{cells}': the file has no such set of elements; it has {_listed(able)}")
    clean, _, kept = _plane(path, mesh, sets)
    bulk, band = [], []
    for i, (kind, block) in zip(kept, bulk_cells(clean), strict=True):
        inside = np.zeros(len(block), dtype=bool)
        if cells is not None:
            inside[members[cells][i]] = True
        bulk.append((kind, block[~inside]))
        band.append((kind, block[inside]))
    bulk, band = ([(kind, block) for kind, block in part if len(block)] for part in (bulk, band))
    if cells is not None and not band:
        raise MeshError(f"band = '{cells}': no element of this set is one of {', '.join(EDGES)}; expected some")
    rows = _rows(clean.points, bulk, band, None if along is None else np.asarray(along, dtype=float))
    if rows is not None:
        clean, bulk, band = _with_rows(clean, bulk, rows)
    nothing = np.empty(0, dtype=np.int64)
    cell_sets = {"body": [np.arange(len(block)) for _, block in bulk] + [nothing for _ in band]}
    for name, present in (("band", cells is not None), ("row", rows is not None)):
        if present:
            cell_sets[name] = [nothing for _ in bulk] + [np.arange(len(block)) for _, block in band]
    return meshio.Mesh(
        clean.points,
        [*bulk, *band],
        point_data={"original": np.arange(len(clean.points))},
        point_sets=clean.point_sets,
        cell_sets=cell_sets,
    )


def _rows(points: Array, bulk: Blocks, band: Blocks, along: Array | None) -> Index | None:
    """The band's cells row after row, each [a-, b-, b+, a+(, mid-, mid b, mid+, mid a)]; None if they are not rows."""
    if not band or any(kind not in ("quad", "quad8") for kind, _ in band):
        return None
    cells = np.concatenate([block for _, block in band])
    corners: list[list[int]] = cells[:, :4].tolist()
    # edge k of a cell runs from its corner k to the next; the neighbour has it the other way round
    owner = {(c[k], c[(k + 1) % 4]): (i, k) for i, c in enumerate(corners) for k in range(4)}
    if len(owner) < cells[:, :4].size or any(len(set(c)) < 4 for c in corners):
        return None  # elements that overlap, or have an edge without length
    beyond = [[owner.get((c[(k + 1) % 4], c[k])) for k in range(4)] for c in corners]
    rows: list[list[tuple[int, int]]] = []  # each cell with the edge through which the row leaves it
    done: set[int] = set()
    for first, neighbours in enumerate(beyond):
        shared = [k for k in range(4) if neighbours[k] is not None]
        if len(shared) > 2 or (len(shared) == 2 and shared[1] - shared[0] != 2):
            return None
        if first in done or len(shared) == 2:
            continue
        leave = shared[0] if shared else _leave_single(points, bulk, corners[first], along)
        if leave is None:
            return None
        rows.append([(first, leave)])
        while (step := beyond[rows[-1][-1][0]][rows[-1][-1][1]]) is not None:
            rows[-1].append((step[0], (step[1] + 2) % 4))
        done.update(i for i, _ in rows[-1])
    if len(done) < len(cells):
        return None  # a ring
    rows = [_directed(points, corners, row, along) for row in sorted(rows, key=min)]
    order, leaves = np.array([pair for row in rows for pair in row], dtype=np.int64).T
    turn = (np.arange(4) + leaves[:, None] - 1) % 4
    turn = np.concatenate([turn, turn + 4], axis=1)[:, : cells.shape[1]]
    return np.asarray(np.take_along_axis(cells[order], turn, axis=1))


def _leave_single(points: Array, bulk: Blocks, corners: list[int], along: Array | None) -> int | None:
    """An edge at which a row of one element ends, or None if nothing tells."""
    edges = list(zip(corners, corners[1:] + corners[:1], strict=True))
    free = [
        not any(((block[:, i] == b) & (block[:, j] == a)).any() for kind, block in bulk for i, j, *_ in EDGES[kind])
        for a, b in edges
    ]
    if free[0] == free[2] != free[1] == free[3]:
        return 0 if free[0] else 1
    if along is None or not along.any():
        return None
    middles = points[np.array(edges)].mean(axis=1)
    spans = middles[:2] - middles[2:]
    return int(np.argmax(abs(spans @ along) / np.hypot(*spans.T)))


def _directed(
    points: Array, corners: list[list[int]], row: list[tuple[int, int]], along: Array | None
) -> list[tuple[int, int]]:
    """A row from its start to its end: `along`, or from the smaller x, then y."""
    (first, leave), (last, out) = row[0], row[-1]
    start, end = (
        points[[corners[i][k], corners[i][(k + 1) % 4]]].mean(axis=0) for i, k in ((first, (leave + 2) % 4), (last, out))
    )
    span = end - start
    slack = SLACK * float(np.ptp(points, axis=0).max())
    if along is not None and abs(span @ along) > slack * np.hypot(*along):
        forward = span @ along > 0
    else:
        forward = (span[0] if abs(span[0]) > slack else span[1]) > 0
    return row if forward else [(i, (k + 2) % 4) for i, k in reversed(row)]


def _with_rows(mesh: meshio.Mesh, bulk: Blocks, rows: Index) -> tuple[meshio.Mesh, Blocks, Blocks]:
    """Points and point sets, bulk and band, without the mid nodes across the rows."""
    if rows.shape[1] == 4:
        return mesh, bulk, [("quad", rows)]
    across, beside = rows[:, [5, 7]].ravel(), rows[:, [[1, 2], [3, 0]]].reshape(-1, 2)
    rows = rows[:, [0, 1, 2, 3, 4, 1, 6, 3]]
    used = np.unique(np.concatenate([*(block.ravel() for _, block in bulk), rows.ravel()]))
    index = np.full(len(mesh.points), -1)
    index[used] = np.arange(len(used))
    gone = index[across] < 0
    across, beside = across[gone], beside[gone]
    sets = {}
    for name, nodes in mesh.point_sets.items():
        stand_in = beside[np.isin(across, nodes)].ravel()
        sets[name] = np.unique(index[np.concatenate([nodes[index[nodes] >= 0], stand_in])])
    return (
        meshio.Mesh(mesh.points[used], [], point_sets=sets),
        [(kind, index[block]) for kind, block in bulk],
        [("quad8", index[rows])],
    )


def _load(path: Path) -> meshio.Mesh:
    """The file as it is, its coordinates checked and plane."""
    if not path.is_file():
        raise MeshError(f"file = '{path}': there is no such file")
    said = io.StringIO()  # meshio prints why a reader does not take the file, a blank line for a gmsh file
    try:
        with redirect_stdout(said):
            mesh = meshio.read(path)
    except SystemExit:  # meshio's way to say that no reader accepts the file
        if said.getvalue().strip():
            print(said.getvalue().strip())
        raise MeshError(f"file = '{path}': not a mesh in a format that meshio reads") from None
    except Exception as error:
        raise MeshError(f"file = '{path}': meshio cannot read it: {error or type(error).__name__}") from None
    points = np.asarray(mesh.points, dtype=float)
    if not np.isfinite(points).all():
        raise MeshError(f"file = '{path}': node {int(np.argwhere(~np.isfinite(points))[0, 0])} is not finite")
    if points.shape[1] == 3 and np.ptp(points[:, 2]) > 1e-9 * np.ptp(points):
        raise MeshError(
            f"file = '{path}': z runs from {points[:, 2].min():g} to {points[:, 2].max():g}; expected a plane mesh"
        )
    mesh.points = points[:, :2]
    return mesh


def _plane(path: Path, mesh: meshio.Mesh, sets: dict[str, Index]) -> tuple[meshio.Mesh, Index, list[int]]:
    """Plane cells and the nodes they use, counter-clockwise; new number of each node (or -1); which blocks were kept."""
    points = mesh.points
    kept = [i for i, block in enumerate(mesh.cells) if block.type in EDGES]
    blocks = [(mesh.cells[i].type, counter_clockwise(points, mesh.cells[i].data.astype(np.int64))) for i in kept]
    if not blocks:
        raise MeshError(
            f"file = '{path}': its cells are {', '.join({b.type for b in mesh.cells}) or 'none'}; expected {', '.join(EDGES)}"
        )
    used = np.unique(np.concatenate([cells.ravel() for _, cells in blocks]))
    index = np.full(len(points), -1)
    index[used] = np.arange(len(used))
    clean = meshio.Mesh(
        points[used],
        [(kind, index[cells]) for kind, cells in blocks],
        point_sets={name: index[nodes][index[nodes] >= 0] for name, nodes in sets.items()},
    )
    return clean, index, kept


def _listed(names: Iterable[str]) -> str:
    return ", ".join(sorted(names)) or "none"


def _named_sets(mesh: meshio.Mesh) -> tuple[dict[str, Index], dict[str, Index]]:
    """Line cells by set name, and nodes by set name."""
    lines: dict[str, Index] = {}
    nodes: dict[str, Index] = {name: np.asarray(at, dtype=np.int64) for name, at in (mesh.point_sets or {}).items()}
    for name, members in _members(mesh).items():
        parts = [(b.type, b.data[at]) for b, at in zip(mesh.cells, members, strict=True) if len(at)]
        if parts:
            nodes[name] = np.unique(np.concatenate([data.ravel() for _, data in parts])).astype(np.int64)
        edges = [data[:, :2] for kind, data in parts if kind in ("line", "line3")]
        if edges:
            lines[name] = np.concatenate(edges).astype(np.int64)
    return lines, nodes


def _members(mesh: meshio.Mesh) -> dict[str, list[Index]]:
    """Cells of each block by set name, gmsh's physical groups included."""
    members: dict[str, list[Index]] = {}
    for name, at in (mesh.cell_sets or {}).items():
        if not name.startswith("gmsh:"):
            members[name] = [np.asarray([] if i is None else i, dtype=np.int64) for i in at]
    physical = mesh.cell_data.get("gmsh:physical")
    for name, (tag, _) in (mesh.field_data or {}).items():
        if physical is not None:
            members[name] = [np.flatnonzero(p == tag) for p in physical]
    return members


def _set_edges(name: str, mesh: meshio.Mesh, lines: Index | None, nodes: Index, index: Index) -> Index:
    """Edges of a set: its line cells, else every element edge between two of its nodes; chained to one direction."""
    if lines is not None:
        return _chained(index[lines])
    on = np.zeros(len(mesh.points), dtype=bool)
    on[nodes] = True
    corners = np.concatenate(
        [b.data[:, [(i, (i + 1) % n) for i in range(n)]].reshape(-1, 2) for b in mesh.cells for n in [len(EDGES[b.type])]]
    )
    edges = np.unique(np.sort(corners[on[corners].all(axis=1)], axis=1), axis=0)
    if not len(edges):
        raise MeshError(
            f"crack = '{name}': no element edge joins two nodes of this set; expected lines or nodes along the path"
        )
    return _chained(edges)


def _chained(edges: Index) -> Index:
    """Edges turned so that each continues its neighbour, from an end of the path where there is one."""
    neighbours: dict[int, list[int]] = {}
    for i, (a, b) in enumerate(edges.tolist()):
        neighbours.setdefault(a, []).append(i)
        neighbours.setdefault(b, []).append(i)
    ends = [node for node, at in neighbours.items() if len(at) != 2]
    done = np.zeros(len(edges), dtype=bool)
    turned = edges.copy()
    for start in [*sorted(ends), *edges[:, 0].tolist()]:
        pending = [start]
        while pending:
            node = pending.pop()
            for i in neighbours[node]:
                if not done[i]:
                    done[i] = True
                    if turned[i, 0] != node:
                        turned[i] = turned[i, ::-1]
                    pending.append(int(turned[i, 1]))
    return turned
