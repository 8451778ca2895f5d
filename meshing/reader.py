"""A user's own plane mesh: read, checked, and cut along a named set or a polyline, or with the band it names."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import meshio
import numpy as np
from numpy.typing import NDArray

from .cracks import EDGES, Line, edges_on_path, insert_cracks, plane_cells
from .errors import MeshError
from .plane import counter_clockwise

Index = NDArray[np.int64]


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


def read_band_mesh(path: str | Path, cells: str | None = None) -> meshio.Mesh:
    """Read a plane mesh in any format that meshio knows, some of whose elements form the crack band.

    Parameters
    ----------
    path : file with triangle, quad, triangle6 or quad8 cells in the x-y plane, lengths in mm.
    cells : name of the set of elements that form the band; None: all of them are the body, which may crack anywhere.

    Returns
    -------
    meshio.Mesh
        Blocks of the bulk, then those of the band, in the order of the file. Cell sets `body` and, with `cells`, `band`.
        Point sets as those of `read_mesh`. `point_data["original"]` is 0, 1, 2, ...

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
        raise MeshError(f"band.cells = '{cells}': the file has no such set of elements; it has {_listed(able)}")
    clean, _, kept = _plane(path, mesh, sets)
    bulk, band = [], []
    for i, (kind, block) in zip(kept, plane_cells(clean), strict=True):
        inside = np.zeros(len(block), dtype=bool)
        if cells is not None:
            inside[members[cells][i]] = True
        bulk.append((kind, block[~inside]))
        band.append((kind, block[inside]))
    bulk, band = ([(kind, block) for kind, block in part if len(block)] for part in (bulk, band))
    if cells is not None and not band:
        raise MeshError(f"band.cells = '{cells}': no element of this set is one of {', '.join(EDGES)}; expected some")
    nothing = np.empty(0, dtype=np.int64)
    body_set = [np.arange(len(block)) for _, block in bulk] + [nothing for _ in band]
    band_set = [nothing for _ in bulk] + [np.arange(len(block)) for _, block in band]
    return meshio.Mesh(
        clean.points,
        [*bulk, *band],
        point_data={"original": np.arange(len(clean.points))},
        point_sets=clean.point_sets,
        cell_sets={"body": body_set} if cells is None else {"body": body_set, "band": band_set},
    )


def _load(path: Path) -> meshio.Mesh:
    """The file as it is, its coordinates checked and plane."""
    if not path.is_file():
        raise MeshError(f"file = '{path}': there is no such file")
    try:
        mesh = meshio.read(path)
    except SystemExit:  # meshio's way to say that no reader accepts the file
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
