"""Files that no one should trust: meshes and scenes, each with what is said of it, or that it runs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import meshio
import numpy as np

from cohesive.arrays import Array, Index
from tests.builders import cubes, grid

Cells = list[tuple[str, Any]]
Mesh = tuple[Any, Cells, dict[str, Any]]

_SQUARES = grid(4, 4)
_P: Array = _SQUARES.points
_Q: Index = _SQUARES.cells[0].data
_C = cubes("hexahedron", 2)
_T = cubes("tetra", 2)
_N = len(_P)


def _at(*place: float) -> int:
    return int(np.flatnonzero((_P == place).all(axis=1))[0])


def _with(cells: Index, row: int, values: list[int]) -> Index:
    changed = cells.copy()
    changed[row] = values
    return changed


def _right(points: Array, by: float) -> Array:
    return points + by * np.eye(points.shape[1])[0]


def _moved(points: Array, node: int, to: list[float]) -> Array:
    changed = np.array(points, dtype=float)
    changed[node] = to
    return changed


def _second_order(torn: bool) -> Mesh:
    mesh = grid(4, 4, "quad8")
    points, cells = mesh.points, mesh.cells[0].data.copy()
    if torn:
        points, cells[5, 4] = np.vstack([points, points[cells[5, 4]]]), len(points)
    return points, [("quad8", cells)], {}


_COPY = np.vstack([_Q, _Q + _N])
_SPLIT = np.where((_Q == _at(1, 0)) & (_P[_Q].mean(axis=1)[:, 0] > 1)[:, None], _N, _Q)
_HINGED = np.vstack([_Q, [_at(4, 4), _N, _N + 1, _N + 2]])

#: by name: the mesh, its sets, and what is said; "" if it runs. 4 x 4 unit squares, cut at x = 2, or 2 x 2 x 2 cubes at z = 1
MESHES: dict[str, tuple[Callable[[], Mesh], str]] = {
    "plain": (lambda: (_P, [("quad", _Q)], {}), ""),
    "clockwise": (lambda: (_P, [("quad", _Q[:, ::-1])], {}), ""),
    "some clockwise": (lambda: (_P, [("quad", _with(_Q, 5, _Q[5][::-1].tolist()))], {}), ""),
    "two blocks": (lambda: (_P, [("quad", _Q[:7]), ("quad", _Q[7:])], {}), ""),
    "with lines and vertices": (lambda: (_P, [("line", [[0, 1]]), ("vertex", [[3]]), ("quad", _Q)], {}), ""),
    "unused nodes": (lambda: (np.vstack([_P, [[9, 9]]]), [("quad", _Q)], {}), ""),
    "a slit": (lambda: (np.vstack([_P, [1, 0]]), [("quad", _SPLIT)], {}), ""),
    "triangles": (lambda: (_P, [("triangle", np.vstack([_Q[:, :3], _Q[:, [0, 2, 3]]]))], {}), ""),
    "triangles and squares": (lambda: (_P, [("quad", _Q[1:]), ("triangle", [_Q[0, :3], _Q[0, [0, 2, 3]]])], {}), ""),
    "tiny": (lambda: (1e-6 * _P, [("quad", _Q)], {}), "0 mm of it follow element edges"),
    "second order": (lambda: _second_order(torn=False), ""),
    "mid node of its own": (lambda: _second_order(torn=True), "share the corners of an edge but not its mid node, 1 in all"),
    "twice": (lambda: (_P, [("quad", np.vstack([_Q, _Q[3]]))], {}), "has the corners of quad 3, 1 in all are given twice"),
    "three times": (lambda: (_P, [("quad", np.vstack([_Q, _Q[3], _Q[3]]))], {}), "2 in all are given twice"),
    "all twice": (lambda: (_P, [("quad", _Q), ("quad", _Q)], {}), "quad 16 .* has the corners of quad 0, 16 in all"),
    "twice, turned": (lambda: (_P, [("quad", np.vstack([_Q, np.roll(_Q[3], 1)]))], {}), "are given twice"),
    "twice, clockwise": (lambda: (_P, [("quad", np.vstack([_Q, _Q[3][::-1]]))], {}), "are given twice"),
    "a triangle on a square": (
        lambda: (_P, [("quad", _Q), ("triangle", _Q[[3], :3])], {}),
        "quad 3 at .* and triangle 16 at .* are on the same side of an edge",
    ),
    "a second copy on the first": (lambda: (np.vstack([_P, _P]), [("quad", _COPY)], {}), "lies on quad 16"),
    "a copy half beside": (lambda: (np.vstack([_P, _P + 0.5]), [("quad", _COPY)], {}), "lies on quad"),
    "a large one on all": (
        lambda: (np.vstack([_P, [[-1, -1], [5, -1], [5, 5], [-1, 5]]]), [("quad", np.vstack([_Q, _N + np.arange(4)]))], {}),
        "lies on quad 16",
    ),
    "a small one inside one": (
        lambda: (np.vstack([_P, [[0.4, 0.4], [0.6, 0.4], [0.6, 0.6]]]), [("quad", _Q), ("triangle", [_N + np.arange(3)])], {}),
        "overlap",
    ),
    "a copy beside": (
        lambda: (np.vstack([_P, _right(_P, 4)]), [("quad", _COPY)], {}),
        "the body is in 2 pieces, and 10 nodes of the boundary touch",
    ),
    "a copy nearly beside": (lambda: (np.vstack([_P, _right(_P, 4 + 1e-5)]), [("quad", _COPY)], {}), "2 pieces, and 10 nodes"),
    "a copy far away": (
        lambda: (np.vstack([_P, _right(_P, 9)]), [("quad", _COPY)], {}),
        "nothing holds its part of 16 elements at .* along x and y and against turning",
    ),
    "finer beside coarser": (
        lambda: (np.vstack([_P, _right(_P / 2, 4)]), [("quad", _COPY)], {}),
        "2 pieces, and 8 nodes of the boundary touch elements that do not have them",
    ),
    "a piece on a hinge": (
        lambda: (np.vstack([_P, [[5, 4], [5, 5], [4, 5]]]), [("quad", _HINGED)], {}),
        r"nothing holds its part of 1 element at \(4.5, 4.5\) against turning about \(4, 4\)",
    ),
    "every square by itself": (
        lambda: (_P[_Q].reshape(-1, 2), [("quad", np.arange(64).reshape(-1, 4))], {}),
        "the body is in 16 pieces, and 60 nodes",
    ),
    "a bow": (
        lambda: (_P, [("quad", _with(_Q, 5, _Q[5, [0, 2, 1, 3]].tolist()))], {}),
        "not convex, 1 in all",
    ),
    "not convex": (lambda: (_moved(_P, _at(1, 1), [1.7, 1.7]), [("quad", _Q)], {}), "flat, folded or not convex"),
    "a node far off": (lambda: (_moved(_P, _at(1, 1), [50, 50]), [("quad", _Q)], {}), "flat, folded or not convex"),
    "all on a line": (lambda: (_P * [1, 0], [("quad", _Q)], {}), "flat, folded or not convex, 16 in all"),
    "all at a point": (lambda: (_P * 0, [("quad", _Q)], {}), "flat, folded or not convex, 16 in all"),
    "one node four times": (lambda: (_P, [("quad", _with(_Q, 5, [7, 7, 7, 7]))], {}), "flat, folded or not convex"),
    "not a number": (lambda: (_moved(_P, 7, [np.nan, 0]), [("quad", _Q)], {}), "node 7 is not finite"),
    "infinite": (lambda: (_moved(_P, 7, [np.inf, 0]), [("quad", _Q)], {}), "node 7 is not finite"),
    "huge": (lambda: (1e200 * _P, [("quad", _Q)], {}), "expected"),
    "not plane": (lambda: (np.column_stack([_P, _P[:, 0]]), [("quad", _Q)], {}), "expected a plane mesh"),
    "lines only": (lambda: (_P, [("line", [[0, 1]])], {}), "its cells are line; expected triangle"),
    "no cells": (lambda: (_P, [], {}), "its cells are none; expected|cannot read it"),
    "no nodes": (lambda: (np.zeros((0, 2)), [], {}), "expected|cannot read it"),
    "pyramids": (lambda: (_C.points, [("pyramid", [[0, 1, 4, 3, 9]])], {}), "its cells are pyramid; expected tetra"),
    "first and second order": (
        lambda: (grid(4, 4, "quad8").points, [("quad8", grid(4, 4, "quad8").cells[0].data[1:]), ("quad", [[0, 1, 2, 3]])], {}),
        "mixes first and second order|convex",
    ),
    "a node that is not there": (
        lambda: (_P, [("quad", _with(_Q, 5, [0, 1, 2, 999]))], {}),
        "cells name node 999 of 25,",
    ),
    "a negative node": (lambda: (_P, [("quad", _with(_Q, 5, [0, 1, 2, -1]))], {}), "cells name node -1 of 25"),
    "a set without nodes": (lambda: (_P, [("quad", _Q)], {"top": []}), ""),
    "a set of unused nodes": (lambda: (np.vstack([_P, [[9, 9]]]), [("quad", _Q)], {"lost": [_N]}), ""),
    "a node of a set that is not there": (lambda: (_P, [("quad", _Q)], {"far": [999]}), "names node 1000"),
    "solid": (lambda: (_C.points, [("hexahedron", _C.cells[0].data)], {}), ""),
    "solid, twice": (
        lambda: (_C.points, [("hexahedron", np.vstack([_C.cells[0].data, _C.cells[0].data[3]]))], {}),
        "hexahedron 8 at .* has the corners of hexahedron 3",
    ),
    "solid, inverted": (
        lambda: (_C.points, [("hexahedron", _C.cells[0].data[:, [4, 5, 6, 7, 0, 1, 2, 3]])], {}),
        "hexahedron 0 at .* is inverted or flat",
    ),
    "solid, a copy": (
        lambda: (
            np.vstack([_C.points, _C.points]),
            [("hexahedron", np.vstack([_C.cells[0].data, _C.cells[0].data + len(_C.points)]))],
            {},
        ),
        "hexahedron 0 at .* lies on hexahedron 8",
    ),
    "solid, a copy beside": (
        lambda: (
            np.vstack([_C.points, _right(_C.points, 2)]),
            [("hexahedron", np.vstack([_C.cells[0].data, _C.cells[0].data + len(_C.points)]))],
            {},
        ),
        "2 pieces, and 18 nodes",
    ),
    "solid, moved copy": (
        lambda: (
            np.vstack([_T.points, _T.points + 0.3]),
            [("tetra", np.vstack([_T.cells[0].data, _T.cells[0].data + len(_T.points)]))],
            {},
        ),
        "lies on tetra",
    ),
    "solid, flat": (lambda: (_T.points * [1, 1, 0], [("tetra", _T.cells[0].data)], {}), "is inverted or flat"),
    "solid and plane": (
        lambda: (_C.points, [("hexahedron", _C.cells[0].data), ("quad", [[0, 2, 8, 6]])], {}),
        "is no face of a solid cell",
    ),
}


def write_mesh(folder: Path, mesh: Mesh) -> str:
    """Into a file of a format that keeps what is wrong with it; its name."""
    points, cells, sets = mesh
    points = np.asarray(points, dtype=float)
    if points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    arrays = [(kind, np.asarray(data, dtype=np.int64)) for kind, data in cells]
    made = meshio.Mesh(points, arrays, point_sets={name: np.asarray(at, dtype=np.int64) for name, at in sets.items()})
    name = "mesh.inp" if sets else "mesh.vtk"
    meshio.write(folder / name, made, **({} if sets else {"binary": False}))
    return name


_LIES = "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 99999999 double\n0 0 0\n"

#: files that are no meshes: name and text
NO_MESHES: dict[str, tuple[str, str]] = {
    "empty": ("a.msh", ""),
    "no format": ("a.msh", "hello\n"),
    "cut short": ("a.msh", "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 9 1 9\n"),
    "a count that lies": (
        "a.vtk",
        _LIES,
    ),
    "no suffix": ("mesh", "1 2 3\n"),
    "another suffix": ("a.docx", "1 2 3\n"),
    "words for numbers": ("a.inp", "*NODE\n1, one, two, three\n"),
    "an element of one node": ("a.inp", "*NODE\n1, 0, 0, 0\n*ELEMENT, TYPE=CPS4\n1, 1, 1\n"),
    "an unknown element": ("a.inp", "*NODE\n1, 0, 0, 0\n*ELEMENT, TYPE=XYZ9\n1, 1\n"),
    "no XML": ("a.vtu", "<VTKFile"),
}
