"""3D meshes by extrusion of 2D ones over the thickness: the same edges, paths and nodes in every layer."""

from __future__ import annotations

from dataclasses import replace

import meshio
import numpy as np

from ..arrays import Array, Index
from ..cells import CELLS
from ..cutting.edges import edges_on_path
from ..cutting.insertion import cut_slits, insert_cracks, mirror_cracks
from ..errors import MeshError
from .band import mesh_band
from .outline import Outline
from .polygon import mesh_face
from .refinement import with_mid_nodes
from .sizes import MeshSizes

#: more elements than a machine holds
_MOST_IN_ALL = 5e6


def mesh_prism(outline: Outline, sizes: MeshSizes, thickness: float) -> meshio.Mesh:
    """Mesh a body of some thickness with its crack: the extrusion of what `mesh_polygon` gives.

    Returns
    -------
    meshio.Mesh
        As `insert_cracks` gives it, of hexahedra or tetrahedra; x and y as in 2D, z from -thickness/2 to
        thickness/2. The point sets of `outline` run through the thickness; `back` and `front` are the faces at the smallest
        and the largest z, and `pin` is one node: a corner of the back.

    Raises
    ------
    MeshError
        As `mesh_polygon`; for hexahedra of second order, or too many layers.
    """
    solid, crack, slit = _uncut(outline, sizes, thickness, conforming=True)
    return mirror_cracks(solid, crack) if outline.half else insert_cracks(solid, crack, slit)


def mesh_prism_body(outline: Outline, sizes: MeshSizes, thickness: float) -> meshio.Mesh:
    """Mesh a body of some thickness without its crack: the extrusion of what `mesh_body` gives; sets as in `mesh_prism`."""
    solid, _, slit = _uncut(outline, sizes, thickness, conforming=False)
    return cut_slits(solid, slit)


def mesh_prism_band(outline: Outline, sizes: MeshSizes, width: float, thickness: float) -> meshio.Mesh:
    """Mesh a body of some thickness with a crack band: the extrusion of what `mesh_band` gives.

    Returns
    -------
    meshio.Mesh
        Hexahedra; those over a triangle of the 2D mesh have two pairs of equal nodes, which makes them prisms.
        The band is the last block, each cell [a-, b-, c-, d-, a+, b+, c+, d+] with the minus face first, the normal
        (b - a) x (c - a) across the band, layer after layer in the order of the path. Sets as those of `mesh_band` and
        `mesh_prism`.

    Raises
    ------
    MeshError
        As `mesh_band`; for elements of second order, or too many layers.
    """
    check_band_order(sizes)
    flat = mesh_band(outline, replace(sizes, layers=None), width)
    return extrude(flat, _levels(flat, sizes, thickness))


def check_band_order(sizes: MeshSizes) -> None:
    """Refuse a crack band of second order; MeshError."""
    if sizes.order == 2:
        raise MeshError.at(
            "mesh.order", " = 2: the elements of a crack band in three dimensions are hexahedra of first order; expected 1"
        )


def extrude(mesh: meshio.Mesh, levels: Array, tetrahedra: bool = False) -> meshio.Mesh:
    """A 3D mesh of the layers between levels, from a 2D mesh of triangles and quadrilaterals.

    Parameters
    ----------
    mesh : meshio.Mesh
        Of first order.
    levels : (n + 1,) ascending z, mm.
    tetrahedra : split the prism over each triangle into three; there must be no quadrilaterals. Else all cells become
        hexahedra, those over a triangle with two pairs of equal nodes.

    Returns
    -------
    meshio.Mesh
        The blocks of `mesh` in their order. Node i of level k has the number k m + i, if the 2D mesh has m nodes.
        A quadrilateral [a, b, c, d] between levels 0 and 1 becomes [a1, b1, b0, a0, d1, c1, c0, d0]: of a crack or a band
        [a-, b-, b+, a+] the minus face, then the plus face. Sets and `point_data["original"]` are extruded too; see
        `mesh_prism` for those that are new.
    """
    n, m = len(levels) - 1, len(mesh.points)
    every = np.arange(n + 1)[:, None]
    points = np.column_stack([np.tile(mesh.points, (n + 1, 1)), np.repeat(levels, m)])
    blocks, copies = [], []
    for block in mesh.cells:
        cells = block.data.astype(np.int64)
        if tetrahedra:
            blocks.append(("tetra", _prisms_split(cells, m, n)))
        else:
            ring = cells if cells.shape[1] == 4 else cells[:, CELLS["triangle"].as_cube]
            columns, up = ring[:, [0, 1, 1, 0, 3, 2, 2, 3]], m * np.array([1, 1, 0, 0, 1, 1, 0, 0])
            blocks.append(("hexahedron", np.concatenate([columns + up + k * m for k in range(n)])))
        copies.append(np.arange(n * (3 if tetrahedra else 1))[:, None] * len(cells))
    sets = {name: (every * m + nodes).ravel() for name, nodes in mesh.point_sets.items()}
    back = np.arange(m)
    sets |= {"back": back, "front": n * m + back, "pin": np.lexsort(mesh.points.T[::-1])[:1]}
    solid = meshio.Mesh(points, blocks, point_sets=sets)
    for name, members in mesh.cell_sets.items():
        solid.cell_sets[name] = [(copy + at).ravel() for copy, at in zip(copies, members, strict=True)]
    if "original" in mesh.point_data:
        original = mesh.point_data["original"]
        solid.point_data["original"] = (every * (original.max() + 1) + original).ravel()
    if "closed" in mesh.point_data:
        solid.point_data["closed"] = np.column_stack([np.tile(mesh.point_data["closed"], (n + 1, 1)), points[:, 2]])
    return solid


def _uncut(outline: Outline, sizes: MeshSizes, thickness: float, conforming: bool) -> tuple[meshio.Mesh, Index, Index]:
    """The uncut 3D mesh, and the faces of crack and slits."""
    tetrahedra = not sizes.has_quads
    if not tetrahedra and sizes.order == 2:
        raise MeshError.at(
            "mesh.order", " = 2: hexahedra are of first order; expected 1, or mesh.shape = 'triangle' for tetrahedra"
        )
    flat = mesh_face(outline, replace(sizes, order=1, layers=None), conforming)
    levels = _levels(flat, sizes, thickness)
    solid = extrude(flat, levels, tetrahedra)
    crack, slit = (
        _lines_swept(edges_on_path(flat, name, lines), len(flat.points), len(levels) - 1, tetrahedra)
        for name, lines in (("crack", outline.crack if conforming else ()), ("notch", outline.slits))
    )
    return (with_mid_nodes(solid) if sizes.order == 2 else solid), crack, slit


def _levels(flat: meshio.Mesh, sizes: MeshSizes, thickness: float) -> Array:
    """z of the layers' faces."""
    layers = sizes.layers_through(thickness)
    in_layer = sum(len(block.data) for block in flat.cells)
    if layers * in_layer > _MOST_IN_ALL:
        raise MeshError.at(
            "mesh.layers",
            f" = {layers}: {in_layer * layers:.2g} elements in the body, {in_layer} in each layer; expected at "
            f"most {int(_MOST_IN_ALL / in_layer)}, or larger elements",
        )
    return np.linspace(-thickness / 2, thickness / 2, layers + 1)


def _prisms_split(cells: Index, m: int, n: int) -> Index:
    """Three tetrahedra for the prism over each triangle in each layer.

    The sides of a prism are divided from the node with the lower number at one level to that with the higher number at the
    other: neighbours agree. The level alternates from layer to layer, so that no diagonal prevails.
    """
    order = np.argsort(cells, axis=1)
    v = np.take_along_axis(cells, order, axis=1)
    is_odd = (order[:, 1] - order[:, 0]) % 3 == 2  # permutation
    layers = []
    for k in range(n):
        low, high = (v + k * m, v + (k + 1) * m)[:: 1 if k % 2 == 0 else -1]
        (a, b, c), (A, B, C) = low.T, high.T
        tetrahedra = np.stack([np.stack(t, axis=1) for t in ((a, b, c, C), (a, b, C, B), (a, A, B, C))])
        inverted = is_odd ^ (k % 2 == 1)
        tetrahedra[:, inverted] = tetrahedra[:, inverted][..., list(CELLS["tetra"].flip)]
        layers.append(tetrahedra.reshape(-1, 4))
    return np.concatenate(layers)


def _lines_swept(lines: Index, m: int, n: int, tetrahedra: bool) -> Index:
    """Faces over 2D edges; the normal points to the left of the edge. Divided as the prisms are, if `tetrahedra`."""
    a, b = lines.T
    faces = []
    for k in range(n):
        ring = np.stack([a + (k + 1) * m, b + (k + 1) * m, b + k * m, a + k * m], axis=1)
        if tetrahedra:
            from_a0 = ((a < b) ^ (k % 2 == 1))[:, None]
            faces.append(np.where(from_a0, ring[:, [0, 1, 3]], ring[:, [0, 1, 2]]))
            faces.append(np.where(from_a0, ring[:, [1, 2, 3]], ring[:, [0, 2, 3]]))
        else:
            faces.append(ring)
    return np.concatenate(faces)
