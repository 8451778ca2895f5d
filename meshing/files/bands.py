"""A user's own mesh with the crack band it names: read, checked, and put in order."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import meshio
import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from ..arrays import Array, Index
from ..cells import BULK_2D, BULK_3D, CELLS
from ..cutting.insertion import insert_cracks
from ..cutting.stars import Blocks, bulk_cells, directed_areas
from ..errors import MeshError
from ..paths import SLACK
from .reading import Crack, cell_members, checked, crack_facets, is_solid, listed, load, named_sets, region_numbers


def read_band_mesh(
    path: str | Path,
    cells: str | None = None,
    along: ArrayLike | None = None,
    regions: Sequence[str] = (),
    crack: Crack | None = None,
) -> meshio.Mesh:
    """Read a mesh in any format that meshio knows, some of whose elements form the crack band.

    In a 2D mesh, a set that is one row of quadrilaterals or several, each one element wide, is put in the order of
    `mesh_band`. In such a row each element shares at most two edges with others of the set, opposite ones, and the row does
    not close on itself. A single element is a row from one free edge to the opposite one, if its two other edges are shared
    with the bulk; otherwise it is one only with `along`, between the two opposite edges that `along` joins best.

    Parameters
    ----------
    path : file as `read_mesh` takes it.
    cells : name of the set of elements that form the band; None: those beside the crack, or all, which may crack anywhere.
    along : (2,) direction of the crack path, of any length. A row runs from end to end so that (end - start) . along > 0;
        without it, or across it, from the end with the smaller x, then y.
    regions : names of sets of elements that never crack, see `reading.region_numbers`.
    crack : without `cells`, the crack as `read_mesh` takes it; the elements on its plus side that touch it form the band.

    Returns
    -------
    meshio.Mesh
        Blocks of the bulk, then those of the band, in the order of the file. Cell sets `body` and, with `cells`, `band`.
        Point sets as those of `read_mesh`. `point_data["original"]` is 0, 1, 2, ...

        If the band is rows, one block of it, row after row in the order of the file, and a cell set `row`, the same as
        `band`: `quad` [a-, b-, b+, a+], a to b along the row, the minus side to its right, or `quad8`
        [a-, b-, b+, a+, mid-, b-, mid+, a+]. The mid nodes across the band are left out, unless an element of the bulk
        uses them; in a point set the two corners beside it stand for such a node.

        If the band lies beside a crack without being rows, `cell_data["normal"]`: (n, d), for an element of the band the unit
        normal of the crack's edge or face that is nearest to its centre, towards the plus side, for others 0.

    Raises
    ------
    MeshError
        If the file cannot be used, see `read_mesh`, or lacks the named set or elements in it.
    """
    path, nothing = Path(path), np.empty(0, dtype=np.int64)
    mesh = load(path)
    facets, sets = named_sets(mesh)
    members, known = cell_members(mesh), BULK_3D if is_solid(mesh) else BULK_2D
    if cells is not None and cells not in members:
        able = [
            name for name, at in members.items() if any(len(i) for b, i in zip(mesh.cells, at, strict=True) if b.type in known)
        ]
        raise MeshError.at("band", f" = '{cells}': the file has no such set of elements; it has {listed(able)}")
    clean, index, kept = checked(path, mesh, sets)
    numbers = region_numbers(mesh, kept, regions)
    is_banded = cells is not None or crack is not None
    if cells is not None:
        inside = [members[cells][i] for i in kept]
    elif crack is not None:
        split = insert_cracks(clean, crack_facets(clean, crack, facets, index, sets))
        inside = _beside(split)
        clean.info["remarks"].append(
            f"the crack band is the {sum(map(len, inside))} elements beside the crack on its plus side; "
            "specimen.band names others"
        )
    else:
        inside = [np.flatnonzero(own == 0) if regions else nothing for own in numbers]
    bulk, band = _parted(bulk_cells(clean), inside)
    if cells is not None and not band:
        raise MeshError.at("band", f" = '{cells}': no element of this set is one of {', '.join(known)}; expected some")
    rows, info, cell_data = None, clean.info, {}
    if is_banded:
        rows = _rows(clean.points, bulk, band, None if along is None else np.asarray(along, dtype=float))
    if rows is not None:
        clean, bulk, rows = _with_rows(clean, bulk, rows)
        band = [(band[0][0], rows)]
    elif cells is None and crack is not None:
        cell_data["normal"] = [np.zeros((len(block), clean.points.shape[1])) for _, block in bulk]
        cell_data["normal"] += [_nearest_normals(split, block[:, : CELLS[kind].n_corners]) for kind, block in band]
    if regions:
        cell_data["region"] = _outside(numbers, regions, inside, band)
    cell_sets = {"body": [np.arange(len(block)) for _, block in bulk] + [nothing for _ in band]}
    for name, present in (("band", bool(band)), ("row", rows is not None)):
        if present:
            cell_sets[name] = [nothing for _ in bulk] + [np.arange(len(block)) for _, block in band]
    return meshio.Mesh(
        clean.points,
        [*bulk, *band],
        point_data={"original": np.arange(len(clean.points))},
        point_sets=clean.point_sets,
        cell_sets=cell_sets,
        cell_data=cell_data,
        info=info,
    )


def _beside(split: meshio.Mesh) -> list[Index]:
    """Elements of each block of a mesh with its crack that touch it from its plus side, where it parts the body."""
    crack = split.cells[-1]
    side = len(CELLS[split.cells[0].type].facets[0])
    is_minus = np.array(CELLS[crack.type].crack_columns) < side
    plus = np.setdiff1d(crack.data[:, ~is_minus], crack.data[:, is_minus])
    return [np.flatnonzero(np.isin(block.data, plus).any(axis=1)) for block in split.cells[:-1]]


def _nearest_normals(split: meshio.Mesh, corners: Index) -> Array:
    """Unit normals (n, d) of the crack cells nearest to the centres of elements with some corners (n, k)."""
    crack, cell = split.cells[-1], CELLS[split.cells[-1].type]
    faces = split.points[crack.data[:, cell.sides[0][: cell.facet_corners]]]
    _, nearest = cKDTree(faces.mean(axis=1)).query(split.points[corners].mean(axis=1))
    normal = directed_areas(faces)[nearest]
    return np.asarray(normal / np.linalg.norm(normal, axis=1, keepdims=True))


def _outside(numbers: Sequence[Index], regions: Sequence[str], inside: Sequence[Index], band: Blocks) -> list[Index]:
    """Numbers of the regions by blocks, bulk and band; MeshError for a region that reaches into the band."""
    for cracking in (own[at] for own, at in zip(numbers, inside, strict=True)):
        if cracking.any():
            name = regions[int(cracking.max()) - 1]
            raise MeshError(f"regions.{name}: elements of it are in the band; expected a region outside of it", "regions")
    outside = [np.delete(own, at) for own, at in zip(numbers, inside, strict=True)]
    return [part for part in outside if len(part)] + [np.zeros(len(block), dtype=np.int64) for _, block in band]


def _parted(blocks: Blocks, members: Sequence[Index]) -> tuple[Blocks, Blocks]:
    """What of each block is no member, and what is; blocks without a cell are left out."""
    bulk, band = [], []
    for (kind, block), at in zip(blocks, members, strict=True):
        inside = np.zeros(len(block), dtype=bool)
        inside[at] = True
        bulk.append((kind, block[~inside]))
        band.append((kind, block[inside]))
    return [part for part in bulk if len(part[1])], [part for part in band if len(part[1])]


def _rows(points: Array, bulk: Blocks, band: Blocks, along: Array | None) -> Index | None:
    """The band's cells row after row, each [a-, b-, b+, a+(, mid-, mid b, mid+, mid a)]; None if they are not rows."""
    if not band or any(CELLS[kind].dimension == 3 or not CELLS[kind].is_row_cell for kind, _ in band):
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
    columns = (np.arange(4) + leaves[:, None] - 1) % 4
    columns = np.concatenate([columns, columns + 4], axis=1)[:, : cells.shape[1]]
    return np.asarray(np.take_along_axis(cells[order], columns, axis=1))


def _leave_single(points: Array, bulk: Blocks, corners: list[int], along: Array | None) -> int | None:
    """An edge at which a row of one element ends, or None if nothing tells."""
    edges = list(zip(corners, corners[1:] + corners[:1], strict=True))
    free = [
        not any(((block[:, i] == b) & (block[:, j] == a)).any() for kind, block in bulk for i, j, *_ in CELLS[kind].edges)
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


def _with_rows(mesh: meshio.Mesh, bulk: Blocks, rows: Index) -> tuple[meshio.Mesh, Blocks, Index]:
    """A mesh of nodes and point sets, the bulk and the band, all without the mid nodes across the rows."""
    if rows.shape[1] == 4:
        return mesh, bulk, rows
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
        index[rows],
    )
