"""A crack band from a crack: the two faces of the crack mesh moved apart, its zero-thickness cells elements between them."""

from __future__ import annotations

import math

import meshio
import numpy as np
import scipy.sparse as sp
from scipy.spatial import cKDTree

from ..arrays import Array, Index, Mask
from ..cells import CELLS
from ..errors import MeshError
from ..paths import SLACK, as_text
from .stars import Star, numbered

#: the bulk gives way up to this many widths from the path, which takes an eighth of its height on the mean
_REACH = 4.0

#: sweeps that spread the motion of the faces over the nodes around
_SWEEPS = 200

#: weight of the outer faces against that of the crack's where a node cannot be right for both
_OUTER = 0.01

#: at a lesser part of the largest singular value, which is an outer face at 20 degrees from the crack, the crack alone counts
_LEAST = 0.0012


def open_cracks(mesh: meshio.Mesh, width: float, places: Array | None = None, shifts: Array | None = None) -> meshio.Mesh:
    """The mesh of a crack band of some width, from that of a crack as `insert_cracks` or `mirror_cracks` gives it.

    Each face moves by half the width along its normal. A copy of a node between several faces, at a kink, a branch or a
    crossing, moves so that its distance from each of them is half the width; on the outer faces of the body it slides along
    them. The nodes around give way, those on outer faces along them. A tip inside the body stays, and so the band ends there
    in a point; where paths meet a hole of about the width stays open. Notches without width are opened like the cracks.

    Parameters
    ----------
    width : mm
    places, shifts : (k, d) arrays, nodes whose motions are known, mm, and these motions; both sides of the crack may be at one
        place, where a motion is that of the side that it leads to

    Returns
    -------
    meshio.Mesh
        The blocks and sets of `mesh`, but cell sets `band` and `row` in place of `crack`: the crack cells, each now as
        thick as the band. `point_data["closed"]` holds the coordinates before.

    Raises
    ------
    MeshError
        If an element would turn over: the band leaves the body, or overlaps itself or another one.
    """
    if not 0 < width < math.inf:
        raise MeshError.at("band.width", f" = {width!r}: expected a finite number above 0, in mm")
    nothing = np.empty((0, mesh.points.shape[1]))
    motion = _motion(mesh, width, nothing if places is None else places, nothing if shifts is None else shifts)
    _check_shapes(mesh, motion, width)
    sets = mesh.cell_sets
    return meshio.Mesh(
        mesh.points + motion,
        mesh.cells,
        point_data=mesh.point_data | {"closed": mesh.points},
        point_sets=mesh.point_sets,
        cell_sets={"body": sets["body"], "band": sets["crack"], "row": sets["crack"]},
        cell_data=mesh.cell_data,
        info=mesh.info,
    )


def _motion(mesh: meshio.Mesh, width: float, places: Array, shifts: Array) -> Array:
    """Motion of each node that opens the crack, (m, d)."""
    points, d = mesh.points, mesh.points.shape[1]
    cells = [(block.type, block.data) for block in mesh.cells[:-1]]
    inward, squares, is_cut = _faces(mesh)
    motion: Array = np.zeros_like(points)
    at = np.flatnonzero(is_cut)
    motion[at] = (np.linalg.pinv(squares[at], rcond=_LEAST, hermitian=True) @ inward[at, :, None])[..., 0] * width / 2
    slack = SLACK * float(np.ptp(points, axis=0).max())
    is_free = ~is_cut
    for here, shift in zip(cKDTree(points).query_ball_point(places, slack), shifts, strict=True):
        for node in here:
            if not is_cut[node] or motion[node] @ shift > 0:
                motion[node], is_free[node] = shift, False
    moving = points[motion.any(axis=1)]
    is_free &= cKDTree(moving).query(points, distance_upper_bound=_REACH * width)[0] < math.inf
    edges = np.concatenate([block[:, np.array(CELLS[kind].edges)[:, :2]].reshape(-1, 2) for kind, block in cells])
    edges = np.unique(np.sort(edges[is_free[edges].any(axis=1)], axis=1), axis=0)
    stiff = np.tile(1.0 / np.linalg.norm(points[edges[:, 1]] - points[edges[:, 0]], axis=1), 2)
    ring = sp.coo_array((stiff, (edges.T.ravel(), edges[:, ::-1].T.ravel())), shape=(len(points),) * 2)
    inner = np.flatnonzero(is_free & (ring.sum(axis=1) > 0))
    mean = (sp.diags_array(1.0 / ring.sum(axis=1)[inner]) @ ring.tocsr()[inner]).tocsr()
    normals = squares[inner]
    along = np.eye(d) - np.linalg.pinv(normals, rcond=_LEAST, hermitian=True) @ normals
    for _ in range(_SWEEPS if len(inner) else 0):
        motion[inner] = np.einsum("nij,nj->ni", along, mean @ motion)
    for kind, block in cells:
        for edge in CELLS[kind].edges:
            if len(edge) == 3:
                a, b, mid = block[:, edge].T
                motion[mid] = 0.5 * (motion[a] + motion[b])
    minus, plus = _mirrored(mesh)
    if len(minus):
        normal = inward[plus].sum(axis=(0, 1)) / np.linalg.norm(inward[plus].sum(axis=(0, 1)))
        motion[minus] = motion[plus] - 2.0 * (motion[plus] @ normal)[..., None] * normal
    return motion


def _mirrored(mesh: meshio.Mesh) -> tuple[Index, Index]:
    """Minus and plus nodes of the crack cells of one half of a body, whose minus nodes no bulk cell has; none of a whole."""
    crack, in_bulk = mesh.cells[-1], np.zeros(len(mesh.points), dtype=bool)
    for block in mesh.cells[:-1]:
        in_bulk[block.data] = True
    minus, plus = (crack.data[:, side] for side in CELLS[crack.type].sides)
    if in_bulk[minus].any():
        minus = plus = minus[:0]
    return minus, plus


def _faces(mesh: meshio.Mesh) -> tuple[Array, Array, Mask]:
    """For each node the sum of the unit normals n of the crack's faces around it, into the body, (m, d), the sum of n n^T of
    these and of the outer faces, (m, d, d), and whether it lies on a face of the crack."""
    points, original = mesh.points, mesh.point_data["original"]
    star = Star.from_cells([(block.type, block.data) for block in mesh.cells[:-1]])
    outer = np.flatnonzero(np.bincount(star.facet)[star.facet] == 1)
    corners = star.nodes[outer, : star.corners]
    minus, _ = _mirrored(mesh)
    twin = numbered(original[np.concatenate([corners, minus[:, : star.corners]])], directed=False)
    is_cut = (np.bincount(twin)[twin] == 2)[: len(outer)]
    normal = -star.outward(points)[outer]
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    weight = np.where(is_cut, 1.0, _OUTER)[:, None, None]
    inward, squares = np.zeros_like(points), np.zeros((*points.shape, points.shape[1]))
    on_crack = np.zeros(len(points), dtype=bool)
    for column in corners.T:
        np.add.at(inward, column[is_cut], normal[is_cut])
        np.add.at(squares, column, weight * normal[:, :, None] * normal[:, None])
        on_crack[column[is_cut]] = True
    return inward, squares, on_crack


def _check_shapes(mesh: meshio.Mesh, motion: Array, width: float) -> None:
    """Refuse elements that turn over; MeshError."""
    crack = mesh.cells[-1]
    for block in mesh.cells:
        cells = block.data[motion[block.data].any(axis=(1, 2))]
        least = (-1e-9 if block is crack else 1e-9) * width**2  # at a tip the two sides of the band meet
        wrong = cells[_least_corner(mesh.points + motion, block.type, cells) < least]
        if not len(wrong):
            continue
        parts = np.linspace(0.0, 1.0, 101)
        fits = [bool((_least_corner(mesh.points + part * motion, block.type, wrong) >= least).all()) for part in parts]
        most = width * parts[max(fits.index(False) - 1, 0)] if False in fits else width
        here = as_text(np.round(mesh.points[wrong[0, : CELLS[block.type].n_corners]].mean(axis=0), 3))
        raise MeshError.at(
            "band.width",
            f" = {width:g}: too wide for the crack path and what lies beside it at {here}, where elements turn over; expected "
            f"at most {most:.3g}",
        )


def _least_corner(points: Array, kind: str, cells: Index) -> Array:
    """The least area of the parallelograms at the corners of each cell."""
    p = points[cells[:, : CELLS[kind].n_corners]]
    a, b = np.roll(p, -1, axis=1) - p, np.roll(p, 1, axis=1) - p
    return np.asarray((a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]).min(axis=1))
