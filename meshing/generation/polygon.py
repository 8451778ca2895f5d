"""Meshes of a 2D body with lines that element edges follow, by gmsh."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import meshio
import numpy as np

from ..arrays import Index
from ..cutting.edges import edges_on_path
from ..cutting.insertion import cut_slits, insert_cracks, mirror_cracks
from ..errors import MeshError
from ..paths import SLACK, Point, as_text, nodes_on_segment, path_length
from .outline import Outline
from .refinement import halved, halvings, halvings_at_hinge, with_hinges, with_mid_nodes
from .session import add_face, add_lines, collect, divide, session, set_sizes
from .sizes import MeshSizes, check_not_layered, check_sizes


def mesh_polygon(outline: Outline, sizes: MeshSizes) -> meshio.Mesh:
    """Mesh a body, cut it along its crack (with crack cells) and slits (without).

    Returns
    -------
    meshio.Mesh
        As `insert_cracks` gives it.

    Raises
    ------
    MeshError
        Naming the entity: a polyline that is degenerate or leaves the body, a point outside it.
    """
    mesh = mesh_face(outline, sizes, conforming=True)
    path = edges_on_path(mesh, "crack", outline.crack)
    if outline.half:
        return mirror_cracks(mesh, path)
    return insert_cracks(mesh, path, edges_on_path(mesh, "notch", outline.slits))


def mesh_body(outline: Outline, sizes: MeshSizes) -> meshio.Mesh:
    """Mesh a body without its crack, for cracks that may form anywhere.

    Returns
    -------
    meshio.Mesh
        Bulk blocks only, fine near the crack path but not aligned with it; cut along the slits. Cell set `body`,
        the point sets of `outline`, and `point_data["original"]`: the node numbers before the slits were cut.

    Raises
    ------
    MeshError
        As `mesh_polygon`.
    """
    mesh = mesh_face(outline, sizes, conforming=False)
    return cut_slits(mesh, edges_on_path(mesh, "notch", outline.slits))


def mesh_face(outline: Outline, sizes: MeshSizes, conforming: bool) -> meshio.Mesh:
    """The uncut mesh with its point sets; element edges follow the slits, and the crack if `conforming`."""
    check_not_layered(sizes)
    path_length("notch", outline.slits)
    check_sizes(sizes, path_length("crack", outline.crack), outline.area)
    with session() as gmsh:
        occ = gmsh.model.occ
        face = add_face(gmsh, outline.corners, outline.holes)
        # quadrilaterals come from a mesh of twice the size, each of whose cells is divided: no triangle is left over
        is_quad = sizes.has_quads
        times = halvings(outline, sizes)
        factor = 2.0 ** (times + is_quad)
        parts = halvings_at_hinge(outline, sizes)
        paths = [with_hinges(path, outline.hinges, factor * sizes.crack_size, parts) for path in outline.crack]
        crack = [line for path in paths for line in add_lines(gmsh, path)]
        tools = [*crack] if conforming else []
        tools += [line for path in outline.slits for line in add_lines(gmsh, path)]
        tools += [(0, occ.addPoint(*p, 0)) for group in outline.nodes.values() for p in group]
        image = [[face]]
        if tools:
            _, image = occ.fragment([face], tools)
        occ.synchronize()
        if conforming:
            crack = [(dim, tag) for pieces in image[1 : 1 + len(crack)] for dim, tag in pieces if dim == 1]
            for _, tag in crack:
                divide(gmsh, tag, factor * sizes.crack_size)
        set_sizes(gmsh, [tag for _, tag in crack], sizes, factor, is_quad, outline.hinges if conforming else (), 0.5**parts)
        gmsh.model.mesh.generate(2)
        mesh = halved(collect(gmsh), times)
    if sizes.order == 2:
        mesh = with_mid_nodes(mesh)
    mesh.point_sets = {name: np.array([nearest(mesh, name, p) for p in group]) for name, group in outline.nodes.items()}
    mesh.point_sets |= edge_sets(mesh, outline.edges)
    return mesh


def nearest(mesh: meshio.Mesh, name: str, point: Sequence[float]) -> int:
    """The node at a point, or a MeshError if there is none."""
    distance = np.hypot.reduce(mesh.points - point, axis=1)
    best = int(distance.argmin())
    if distance[best] > SLACK * np.ptp(mesh.points, axis=0).max():
        raise MeshError.at(name, f" = {as_text(point)}: expected a point of the body")
    return best


def edge_sets(mesh: meshio.Mesh, edges: Mapping[str, Sequence[Point]]) -> dict[str, Index]:
    """Point sets of the nodes on polylines along the outline."""
    slack = SLACK * float(np.ptp(mesh.points, axis=0).max())
    sets = {}
    for name, line in edges.items():
        on = [nodes_on_segment(mesh.points, a, b, slack) for a, b in pairwise(line)]
        sets[name] = np.flatnonzero(np.any(on, axis=0))
    return sets
