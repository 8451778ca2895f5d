"""Meshes for the smeared crack: a band of quadrilaterals, one element wide, along the crack path."""

from __future__ import annotations

import math
from types import ModuleType

import meshio
import numpy as np

from ..arrays import Array, Index
from ..cutting.edges import edges_on_path
from ..cutting.insertion import cut_slits
from ..errors import MeshError
from ..paths import Point, nodes_on_segment
from .band_geometry import Strip, lay_strips
from .clipping import part_inside
from .outline import Outline
from .polygon import check_outline, edge_sets, nearest
from .session import add_face, add_lines, collect, divide, generate, session, set_sizes
from .sizes import MeshSizes


def mesh_band(outline: Outline, sizes: MeshSizes, width: float) -> meshio.Mesh:
    """Mesh a body with a row of quadrilaterals along each crack path, one element wide.

    The row is centred on the path and follows it with mitred joints. Where a path ends on an edge of the body, so does
    the row; inside the body its end is square. A notch without width that a path starts from is opened to the width of
    the row's end, since a row one element wide has no node on its centre line.

    Parameters
    ----------
    outline : Outline
        Whole, not a half.
    sizes : MeshSizes
        `crack_size` is the length of the band's elements along the path. With shape "quad" a few triangles are left over
        in the bulk: dividing every cell would make the band two elements wide.
    width : float
        Of the band, mm.

    Returns
    -------
    meshio.Mesh
        Bulk blocks, then the band: `quad` [a-, b-, b+, a+], a to b along the path, the minus side to its right, or
        `quad8` [a-, b-, b+, a+, mid-, b-, mid+, a+]: across the band, where the crack is one jump, it has no mid node and a
        corner stands in, as in a crack cell. In the order of the path, path after path. Cell sets `body` and `band`, and
        `row`, the same as `band`. A named point on an end of the band stands for all nodes of that end.
        `point_data["original"]` holds the node numbers before slits that are left were cut, else 0, 1, 2, ...

    Raises
    ------
    MeshError
        If the band does not fit: wider than the notch, outside the body, overlapping itself or another, or over a named
        point.
    """
    if outline.half:
        raise MeshError.at("half", " = true: a crack band runs along the middle of the body; expected the whole body")
    check_outline(outline, sizes)
    opened, strips = lay_strips(outline, width)
    free, on_end = _sorted_nodes(opened, strips, width)
    bulk, band, points = _mesh_faces(opened, strips, free, sizes, width)
    whole = _renumbered(points, [*((block.type, block.data) for block in bulk), band])
    for name, group in opened.nodes.items():
        at = [_end_nodes(whole, on_end[p], outline.slack) if p in on_end else [nearest(whole, name, p)] for p in group]
        whole.point_sets[name] = np.unique(np.concatenate(at)).astype(np.int64)
    whole.point_sets |= edge_sets(whole, outline.edges)
    cut = cut_slits(whole, edges_on_path(whole, "notch", opened.slits))
    cells = [np.arange(len(block.data)) for block in cut.cells]
    nothing = [np.empty(0, dtype=np.int64) for _ in bulk]
    row = [*nothing, cells[-1]]
    cut.cell_sets = {"body": [*cells[:-1], np.empty(0, dtype=np.int64)], "band": row, "row": row}
    return cut


def _mesh_faces(
    outline: Outline, strips: list[Strip], free: list[Point], sizes: MeshSizes, width: float
) -> tuple[list[meshio.CellBlock], tuple[str, Index], Array]:
    """Bulk blocks, the block of the band in the order of the path, and the nodes' coordinates; some nodes are not used."""
    with session() as gmsh:
        face = add_face(gmsh, outline.corners, outline.holes)
        tools = [(2, tag) for strip in strips for tag in _add_strip(gmsh, strip)]
        n_faces = len(tools)
        tools += [line for slit in outline.slits for line in add_lines(gmsh, slit)]
        tools += [(0, gmsh.model.occ.addPoint(*p, 0)) for p in free]
        _, image = gmsh.model.occ.fragment([face], tools)
        gmsh.model.occ.synchronize()
        tags = [tag for pieces in image[1 : 1 + n_faces] for _, tag in pieces]
        segments = [ends for strip in strips for ends in zip(strip.path[:-1], strip.path[1:], strict=True)]
        curves = [c for tag, (a, b) in zip(tags, segments, strict=True) for c in _divide_face(gmsh, tag, a, b, sizes, width)]
        set_sizes(gmsh, curves, sizes, 1.0)
        generate(gmsh, sizes.order)
        mesh = collect(gmsh, [(2, tag) for tag in tags])
    bulk, rows = mesh.cells[:-n_faces], mesh.cells[-n_faces:]
    band = np.concatenate([_in_order(mesh.points, row.data, a, b) for row, (a, b) in zip(rows, segments, strict=True)])
    if sizes.order == 2:
        band[:, [5, 7]] = band[:, [1, 3]]
    return bulk, (rows[0].type, band), mesh.points


def _renumbered(points: Array, blocks: list[tuple[str, Index]]) -> meshio.Mesh:
    """The mesh of some blocks without the nodes that they do not use."""
    used, flat = np.unique(np.concatenate([block.ravel() for _, block in blocks]), return_inverse=True)
    parts = np.split(flat, np.cumsum([block.size for _, block in blocks])[:-1])
    return meshio.Mesh(
        points[used], [(kind, part.reshape(block.shape)) for (kind, block), part in zip(blocks, parts, strict=True)]
    )


def _sorted_nodes(outline: Outline, strips: list[Strip], width: float) -> tuple[list[Point], dict[Point, tuple[Point, Point]]]:
    """Named points at which gmsh must place a node, and those on an end of the band, with that end."""
    slack = outline.slack
    corners = np.concatenate([side for strip in strips for side in (strip.minus, strip.plus)])
    ends = [end for strip in strips for end in strip.ends]
    free: list[Point] = []
    on_end: dict[Point, tuple[Point, Point]] = {}
    for name, group in outline.nodes.items():
        for p in group:
            x, y = p
            at = np.array([p], dtype=float)
            if np.hypot(*(corners - at).T).min() < slack:
                continue  # a node anyhow
            here = [end for end in ends if nodes_on_segment(at, *end, slack)[0]]
            if here and any(end == here[0] for other, end in on_end.items() if other not in group):
                raise MeshError.at(
                    name,
                    f" = ({x:g}, {y:g}): it shares an end of the band with another named point, and both would stand "
                    f"for all of it; expected points more than {width / 2:g} mm from the crack path",
                )
            if here:
                on_end[p] = here[0]
            elif any(len(part_inside(at, face, slack)) for strip in strips for face in strip.faces):
                raise MeshError.at(
                    name,
                    f" = ({x:g}, {y:g}): it lies in the band, band.width = {width:g}; expected a point more than "
                    f"{width / 2:g} mm from the crack path",
                )
            else:
                free.append(p)
    return free, on_end


def _end_nodes(mesh: meshio.Mesh, end: tuple[Point, Point], slack: float) -> Index:
    """Nodes on an end of the band."""
    return np.flatnonzero(nodes_on_segment(mesh.points, *end, slack))


def _add_strip(gmsh: ModuleType, strip: Strip) -> list[int]:
    """The faces of a row in gmsh; neighbours share their edge."""
    occ = gmsh.model.occ
    minus, plus = ([occ.addPoint(*p, 0) for p in side] for side in (strip.minus, strip.plus))
    across = [occ.addLine(a, b) for a, b in zip(minus, plus, strict=True)]
    faces = []
    for i in range(len(minus) - 1):
        low, high = occ.addLine(minus[i], minus[i + 1]), occ.addLine(plus[i], plus[i + 1])
        faces.append(occ.addPlaneSurface([occ.addCurveLoop([low, across[i + 1], -high, -across[i]])]))
    return faces


def _divide_face(gmsh: ModuleType, face: int, a: Array, b: Array, sizes: MeshSizes, width: float) -> list[int]:
    """Have gmsh divide a face of the row into quadrilaterals, one wide; the curves of its two sides."""
    mesh, normal = gmsh.model.mesh, np.array([a[1] - b[1], b[0] - a[0]]) / math.dist(a, b)
    sides: list[int] = []
    for _, tag in gmsh.model.getBoundary([(2, face)], oriented=False):
        ends = [gmsh.model.getValue(0, p, [])[:2] for _, p in gmsh.model.getBoundary([(1, tag)], oriented=False)]
        if abs((np.mean(ends, axis=0) - a) @ normal) > width / 4:
            sides.append(tag)
            mesh.setTransfiniteCurve(tag, max(1, round(math.dist(a, b) / sizes.crack_size)) + 1)
        else:
            divide(gmsh, tag, math.inf)
    mesh.setTransfiniteSurface(face)
    mesh.setRecombine(2, face)
    return sides


def _in_order(points: Array, cells: Index, a: Array, b: Array) -> Index:
    """Counter-clockwise quadrilaterals of one face, from a to b, each beginning with its node a-."""
    along = (b - a) / math.dist(a, b)
    cells = cells[np.argsort(points[cells[:, :4]].mean(axis=1) @ along)]
    minus = (points[cells[:, :4]] - a) @ np.array([-along[1], along[0]]) < 0
    first = (minus & ~np.roll(minus, 1, axis=1)).argmax(axis=1)
    columns = (np.arange(4) + first[:, None]) % 4
    columns = np.concatenate([columns, columns + 4], axis=1)[:, : cells.shape[1]]
    return np.asarray(np.take_along_axis(cells, columns, axis=1))
