"""A user's own mesh, 2D or 3D: read, checked, and cut along a named set or a polyline."""

from __future__ import annotations

import io
import os
import sys
import threading
from collections.abc import Iterable, Sequence
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

import meshio
import numpy as np

from ..arrays import Index
from ..cells import BULK_2D, BULK_3D, CELLS, counter_clockwise
from ..cutting.edges import edges_on_path
from ..cutting.insertion import insert_cracks
from ..cutting.orientation import chained, flipped
from ..cutting.stars import Blocks, Star, bulk_cells
from ..errors import MeshError
from ..paths import Line, as_text
from .abaqus import read_abaqus
from .limits import check_limits, refused
from .packed_vtu import unpacked_vtu

#: coordinates beyond it, mm, are no body's, and their squares overflow
_FURTHEST = 1e12

#: characters of what meshio says that are shown
_LONGEST = 300

#: the streams are those of the whole process: of two threads that replace them one would put the other's back
_ONE_AT_A_TIME = threading.Lock()

Crack = str | Sequence[str] | Sequence[Line]


def read_mesh(path: str | Path, crack: Crack, regions: Sequence[str] = ()) -> meshio.Mesh:
    """Read a mesh in any format that meshio knows and insert its crack.

    Parameters
    ----------
    path : file with triangle, quad, triangle6 or quad8 cells in the x-y plane, or with 3D cells, all tetra, all tetra10 or
        all hexahedron; lengths in mm.
    crack : name of a set of line cells (or of nodes) on the crack path, or polylines that follow element edges. In 3D the
        name of a set of triangles or quadrilaterals on the crack surface, or of its nodes. The surface consists of
        element faces inside the body; it may end inside, and sheets may meet and cross. Of each sheet (a part without
        branches) the first cell's normal points to the plus side; of a set of nodes, the mean normal with positive x, else
        y, else z. Several names are as many parts of the crack.
    regions : names of sets of elements, see `region_numbers`.

    Returns
    -------
    meshio.Mesh
        As `insert_cracks` gives it. Its point sets are the file's point sets and the nodes of its cell sets
        (gmsh's physical groups included). With regions, `cell_data["region"]`: 0, or 1 + the index of a cell's region.
        `info["remarks"]`: sentences on what is odd about the file.

    Raises
    ------
    MeshError
        If the file cannot be read, has non-finite coordinates or lacks the named set; if a 2D mesh is not plane; if a
        3D mesh has inverted cells or 2D cells that are no faces of it, or if the set is no surface inside it.
    """
    path = Path(path)
    mesh = load(path)
    cells, sets = named_sets(mesh)
    clean, index, kept = checked(path, mesh, sets)
    cut = insert_cracks(clean, crack_facets(clean, crack, cells, index, sets))
    cut.info = clean.info
    if regions:
        numbers = region_numbers(mesh, kept, regions)
        cut.cell_data["region"] = [*numbers, np.zeros(len(cut.cells[-1]), dtype=np.int64)]
    return cut


def crack_facets(
    clean: meshio.Mesh, crack: Crack, cells: dict[str, list[Index]], index: Index, sets: dict[str, Index]
) -> Index:
    """Edges or faces of the crack of a file, corners (n, k) in the numbers of the mesh `clean`, see `checked` and `read_mesh`.

    Parameters
    ----------
    cells, sets : of the file, see `named_sets`.
    """
    names = [crack] if isinstance(crack, str) else [name for name in crack if isinstance(name, str)]
    if names:
        return np.concatenate([_facets_of_set(name, clean, cells.get(name, []), index, sets) for name in names])
    if is_solid(clean):
        raise MeshError.at("crack", f" = {list(crack)}: the mesh is solid; expected the name of a set of faces or nodes")
    return edges_on_path(clean, "crack", crack)  # type: ignore[arg-type]  # polylines


def _facets_of_set(name: str, clean: meshio.Mesh, cells: list[Index], index: Index, sets: dict[str, Index]) -> Index:
    """Edges or faces of a named part of the crack, corners (n, k)."""
    if name not in sets:
        raise MeshError.at("crack", f" = '{name}': the file has no such set; it has {listed(sets)}")
    facets = [index[block] for block in cells]
    if any((block < 0).any() for block in facets):
        raise MeshError.at(
            "crack", f" = '{name}': a cell of this set has a node that no element has; expected parts of elements"
        )
    find = _set_faces if is_solid(clean) else _set_edges
    return find(name, clean, facets, clean.point_sets[name])


def region_numbers(mesh: meshio.Mesh, kept: Sequence[int], regions: Sequence[str]) -> list[Index]:
    """For each cell of the blocks `kept` of a file 0 or, in a region, 1 + its index; MeshError if a region is no set of
    elements of the file, or two of them share an element."""
    members = cell_members(mesh)
    numbers = [np.zeros(len(mesh.cells[i]), dtype=np.int64) for i in kept]
    for number, name in enumerate(regions, start=1):
        at = [members[name][i] for i in kept] if name in members else []
        if not sum(map(len, at)):
            raise MeshError(f"regions.{name}: the file has no such set of elements; it has {listed(members)}", "regions")
        for in_block, own in zip(numbers, at, strict=True):
            if in_block[own].any():
                other = regions[int(in_block[own].max()) - 1]
                raise MeshError(f"regions.{name}: it shares elements with regions.{other}; expected separate sets", "regions")
            in_block[own] = number
    return numbers


def load(path: Path) -> meshio.Mesh:
    """The file as it is, its coordinates checked; (m, 2) unless it has 3D cells."""
    if not os.path.isfile(path):
        if os.path.exists(path) and not os.path.isdir(path):
            raise refused(path, "it is a pipe or a device; expected a file")
        raise refused(path, "there is no such file")
    try:
        check_limits(path)
    except OSError as error:
        raise refused(path, f"cannot be read: {error.strerror or error}") from None
    mesh = read_abaqus(path) if path.suffix.lower() == ".inp" else _by_meshio(path)
    if not len(mesh.points) or not mesh.cells:
        elements = sum(map(len, mesh.cells))
        raise refused(path, f"it has {len(mesh.points)} nodes and {elements} elements; expected a mesh")
    _check_numbers(path, mesh)
    points = np.asarray(mesh.points, dtype=float)
    if len(away := np.flatnonzero(~(abs(points) < _FURTHEST).all(axis=1))):
        raise refused(path, f"node {away[0]} is not finite or beyond {_FURTHEST:g}; expected mm")
    mesh.points = points
    if is_solid(mesh):
        return mesh
    if points.shape[1] == 3 and np.ptp(points[:, 2]) > 1e-9 * np.ptp(points):
        raise refused(path, f"z runs from {points[:, 2].min():g} to {points[:, 2].max():g}; expected a plane mesh")
    mesh.points = points[:, :2]
    return mesh


def _by_meshio(path: Path) -> meshio.Mesh:
    """A file as meshio reads it."""
    suffix = path.suffix.lower()
    said = io.StringIO()  # meshio prints why a reader does not take the file, and a blank line for a gmsh file
    try:
        with _ONE_AT_A_TIME, redirect_stdout(said), redirect_stderr(said):
            if suffix == ".vtu":
                with unpacked_vtu(path) as whole:
                    mesh = meshio.read(whole)
            else:
                mesh = meshio.read(path, "gmsh" if suffix == ".msh" else None)
    except MeshError:
        raise
    except SystemExit:  # meshio's way to say that no reader accepts the file
        raise refused(path, "not a mesh in a format that meshio reads") from None
    except Exception as error:
        raise refused(path, f"{_why(error)}") from None
    if remark := said.getvalue().strip():
        print(remark, file=sys.stderr)
    return _each_once(mesh)


def _why(error: Exception) -> str:
    """Why meshio does not read a file, and what would do."""
    if isinstance(error, ModuleNotFoundError):
        return f"its format needs the package {error.name}; expected pip install {error.name}, or the mesh as .msh or .vtu"
    if "Incompatible cell data 'gmsh:physical'" in str(error):
        return "some of its elements are in no physical group, as Mesh.SaveAll writes them; expected a file without SaveAll"
    said = " ".join(f"{type(error).__name__} {error}".split())
    return f"meshio cannot read it: {said if len(said) < _LONGEST else said[:_LONGEST] + ' ...'}"


def _each_once(mesh: meshio.Mesh) -> meshio.Mesh:
    """A mesh in which gmsh's format 2 has an element once for each of its groups: each element once, its groups as sets."""
    tags = mesh.cell_data.get("gmsh:physical")
    if tags is None or mesh.cell_sets:
        return mesh
    blocks, groups = [], []
    for kind in dict.fromkeys(block.type for block in mesh.cells):
        own = [i for i, block in enumerate(mesh.cells) if block.type == kind]
        cells, tag = np.concatenate([mesh.cells[i].data for i in own]), np.concatenate([tags[i] for i in own])
        is_repeated = len(np.unique(np.column_stack([cells, tag]), axis=0)) < len(tag)  # in one group: a defect, which stays
        rows = np.arange(len(tag))[:, None] if is_repeated else cells
        _, first, number = np.unique(rows, axis=0, return_index=True, return_inverse=True)
        order = np.argsort(first)
        place = np.empty_like(order)
        place[order] = np.arange(len(order))
        blocks.append((kind, cells[first[order]]))
        groups.append((tag, place[number.ravel()]))
    found = meshio.Mesh(mesh.points, blocks)
    for name, (wanted, dimension) in mesh.field_data.items():
        found.cell_sets[name] = [
            np.unique(at[tag == wanted]) if block.dim == dimension else np.empty(0, dtype=np.int64)
            for block, (tag, at) in zip(found.cells, groups, strict=True)
        ]
    return found


def _check_numbers(path: Path, mesh: meshio.Mesh) -> None:
    """Refuse cells and sets that name what is not there; MeshError."""
    n = len(mesh.points)
    for block in mesh.cells:
        count = meshio._mesh.num_nodes_per_cell.get(block.type)
        if count is not None and np.shape(block.data)[1:] != (count,):
            raise refused(path, f"its {block.type} cells do not have {count} nodes; the file is damaged")
    named = [("its cells name", np.ravel(block.data)) for block in mesh.cells if block.data.dtype.kind in "iu"]
    named += [(f"set '{name}' names", np.asarray(nodes, dtype=np.int64)) for name, nodes in mesh.point_sets.items()]
    for what, nodes in named:
        if len(bad := nodes[(nodes < 0) | (nodes >= n)]):
            raise refused(path, f"{what} node {bad[0]} of {n}, counted from 0")
    for name, members in (mesh.cell_sets or {}).items():
        for block, at in zip(mesh.cells, () if name.startswith("gmsh:") else members, strict=False):
            cells = np.asarray([] if at is None else at, dtype=np.int64)
            if len(bad := cells[(cells < 0) | (cells >= len(block))]):
                raise refused(path, f"set '{name}' names {block.type} {bad[0]} of {len(block)}, counted from 0")


def is_solid(mesh: meshio.Mesh) -> bool:
    """Whether a mesh has 3D cells."""
    return any(block.dim == 3 for block in mesh.cells)


def checked(path: Path, mesh: meshio.Mesh, sets: dict[str, Index]) -> tuple[meshio.Mesh, Index, list[int]]:
    """Bulk cells and the nodes that they use.

    Parameters
    ----------
    path : of the file, for messages.
    mesh, sets : the file as it is, and its sets of nodes.

    Returns
    -------
    clean, index, kept : the mesh of them, 2D cells counter-clockwise; the new number of each node, or -1; which blocks of
        `mesh` they are.

    Raises
    ------
    MeshError
        If there are none, or other 3D cells, or some are inverted or flat; see also `defects.check_elements`.
    """
    points, solid = mesh.points, is_solid(mesh)
    kept = [i for i, block in enumerate(mesh.cells) if block.type in (BULK_3D if solid else BULK_2D)]
    known = BULK_3D if solid else BULK_2D
    other = {block.type for block in mesh.cells if block.dim == (3 if solid else 2) and block.type not in known}
    if not kept or other:
        kinds, known = other or {b.type for b in mesh.cells}, known if solid or kept else BULK_2D + BULK_3D
        raise refused(path, f"its cells are {', '.join(sorted(kinds)) or 'none'}; expected {', '.join(known)}")
    blocks = [(mesh.cells[i].type, mesh.cells[i].data.astype(np.int64)) for i in kept]
    if solid:
        _check_solid(path, mesh, blocks)
    else:
        blocks = [(kind, counter_clockwise(points, kind, cells)) for kind, cells in blocks]
    used = np.unique(np.concatenate([cells.ravel() for _, cells in blocks]))
    index = np.full(len(points), -1)
    index[used] = np.arange(len(used))
    clean = meshio.Mesh(
        points[used],
        [(kind, index[cells]) for kind, cells in blocks],
        point_sets={name: index[nodes][index[nodes] >= 0] for name, nodes in sets.items()},
    )
    from .defects import check_elements  # SciPy's search trees, which no other mesh waits for

    remarks = check_elements(path, clean.points, bulk_cells(clean))
    if lost := len(points) - len(used):
        named = [name for name, nodes in sets.items() if (index[nodes] < 0).any()]
        of_sets = f", some of them of the set {listed(named)}" if named else ""
        remarks.append(f"{lost} nodes of the file belong to no element and are left out{of_sets}")
    clean.info = {"remarks": remarks}
    return clean, index, kept


def _check_solid(path: Path, mesh: meshio.Mesh, blocks: Blocks) -> None:
    """Refuse inverted 3D cells, and 2D cells that are no faces of them; MeshError."""
    for kind, cells in blocks:
        p = mesh.points[cells]
        triples = [np.moveaxis(p[:, list(n)] - p[:, [i]], 1, 0) for i, n in enumerate(CELLS[kind].neighbours)]
        volume = np.stack([np.einsum("ni,ni->n", np.cross(u, v), w) for u, v, w in triples], axis=1)
        size = np.ptp(p, axis=1).max(axis=1)
        for i in np.flatnonzero((volume < -1e-9 * size[:, None] ** 3).any(axis=1) | ~(volume > 0).any(axis=1))[:1].tolist():
            raise refused(
                path,
                f"{kind} {i} at {as_text(p[i].mean(axis=0))} is inverted or flat; expected cells "
                "with a positive volume in the node order of meshio",
            )
    star = Star.from_cells(bulk_cells(mesh))
    for block in mesh.cells:
        if block.dim == 2:
            k = CELLS[block.type].n_corners if block.type in CELLS else 0
            faces = block.data[:, :k].astype(np.int64)
            loose = (
                np.ones(len(faces), bool) if k != star.corners else (star.find(faces) < 0) & (star.find(faces[:, ::-1]) < 0)
            )
            for i in np.flatnonzero(loose)[:1].tolist():
                raise refused(
                    path,
                    f"it mixes solid and plane cells, {block.type} {i} at "
                    f"{as_text(mesh.points[block.data[i]].mean(axis=0))} is no face of a solid cell; expected faces of them",
                )


def listed(names: Iterable[str]) -> str:
    """Names as text."""
    return ", ".join(sorted(names)) or "none"


def named_sets(mesh: meshio.Mesh) -> tuple[dict[str, list[Index]], dict[str, Index]]:
    """Corners of the line cells, or of the triangles and quadrilaterals of a 3D mesh, by set name; nodes by set name."""
    facets: dict[str, list[Index]] = {}
    nodes: dict[str, Index] = {name: np.asarray(at, dtype=np.int64) for name, at in (mesh.point_sets or {}).items()}
    dimension = 2 if is_solid(mesh) else 1
    for name, members in cell_members(mesh).items():
        parts = [(b, b.data[at].astype(np.int64)) for b, at in zip(mesh.cells, members, strict=True) if len(at)]
        if parts:
            nodes[name] = np.unique(np.concatenate([data.ravel() for _, data in parts]))
        corners = [data[:, : CELLS[b.type].n_corners] for b, data in parts if b.dim == dimension and b.type in CELLS]
        if corners:
            facets[name] = corners
    return facets, nodes


def cell_members(mesh: meshio.Mesh) -> dict[str, list[Index]]:
    """Cells of each block by set name, gmsh's physical groups included: a group is told by its dimension and its tag."""
    members: dict[str, list[Index]] = {}
    for name, at in (mesh.cell_sets or {}).items():
        if not name.startswith("gmsh:"):
            members[name] = [np.asarray([] if i is None else i, dtype=np.int64) for i in at]
    return members


def _set_edges(name: str, mesh: meshio.Mesh, lines: list[Index], nodes: Index) -> Index:
    """Edges of a set: its line cells, else every element edge between two of its nodes; chained to one direction."""
    if lines:
        return chained(np.concatenate(lines))
    edges = np.unique(np.sort(_facets_between(mesh, nodes).nodes[:, :2], axis=1), axis=0)
    if not len(edges):
        raise MeshError.at(
            "crack", f" = '{name}': no element edge joins two nodes of this set; expected lines or nodes along the path"
        )
    return chained(edges)


def _set_faces(name: str, mesh: meshio.Mesh, cells: list[Index], nodes: Index) -> Index:
    """Faces of a set: its triangles or quadrilaterals, else every element face between its nodes; oriented alike."""
    if cells:
        faces = np.concatenate(cells)
        return np.where(flipped(name, faces)[0][:, None], faces[:, ::-1], faces)
    star = _facets_between(mesh, nodes)
    if not len(star.facet):
        raise MeshError.at(
            "crack", f" = '{name}': no element face joins nodes of this set; expected surface cells or nodes on the surface"
        )
    owner, count = np.unique(star.cell, return_counts=True)
    if (count == len(CELLS[mesh.cells[0].type].faces)).any():
        raise MeshError.at(
            "crack",
            f" = '{name}': this set has all corners of element {owner[count.argmax()]}; expected nodes on one surface, "
            "or a set of its faces",
        )
    faces = star.nodes[np.unique(star.facet, return_index=True)[1], : star.corners]
    to_flip, sheet = flipped(name, faces)
    faces = np.where(to_flip[:, None], faces[:, ::-1], faces)
    a, b, c = (mesh.points[faces[:, i]] for i in range(3))
    for i in range(sheet.max() + 1):
        normal = np.cross(b - a, c - a)[sheet == i].sum(axis=0)
        leading = normal[abs(normal) > 1e-6 * abs(normal).max()]
        if len(leading) and leading[0] < 0:
            faces[sheet == i] = faces[sheet == i][:, ::-1]
    return faces


def _facets_between(mesh: meshio.Mesh, nodes: Index) -> Star:
    """The rows of the star of a mesh whose corners are all among some nodes."""
    on = np.zeros(len(mesh.points), dtype=bool)
    on[nodes] = True
    star = Star.from_cells(bulk_cells(mesh))
    rows = on[star.nodes[:, : star.corners]].all(axis=1)
    return Star(star.cell[rows], star.facet[rows], star.nodes[rows], star.corners)
