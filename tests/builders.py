"""What several tests are made of: scenes of blocks and beams, plane and solid meshes built by hand, whole or cracked."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise, product
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest

from cohesive import Result, Scene, SceneError, run
from cohesive.algebra.bordered import Border, Stiffness
from cohesive.arrays import Array, Index
from cohesive.model.build import build
from cohesive.model.model import Model
from cohesive.solver.problem import State
from cohesive.solver.stages import Stage
from cohesive.solver.stepper import LoadStepper, solve
from meshing import MeshError
from meshing.generation.refinement import with_mid_nodes


def block(**changes: Any) -> Scene:
    """A block of 40 x 40 x 10 mm with one crack, 8 steps; `changes` with __ for the dots of the keys."""
    data: dict[str, Any] = {
        "title": "block",
        "specimen": {"kind": "single-crack", "width": 40.0, "height": 40.0, "thickness": 10.0},
        "mesh": {"crack_size": 8.0, "far_size": 8.0, "order": 1},
        "material": {"preset": "reinhardt"},
        "interface": {"width": 0.3},
        "solver": {"tol": 1e-11},
        "stage": [{"control": "opening", "to": 0.05, "steps": 8}],
    }
    return Scene(data).with_(**{key.replace("__", "."): value for key, value in changes.items()})


COARSE = {
    "mesh.shape": "quad", "mesh.order": 1, "mesh.crack_size": 2.5, "mesh.far_size": 12.0, "stage.0.steps": 8,
    "solver.tol": 1e-11,
}  # fmt: skip


def coarse_beam(name: str, plane: str, **changes: Any) -> Scene:
    """The built-in beam on a coarse mesh, "notched-beam" or, extruded in two layers, "notched-beam-3d"."""
    keys = COARSE | {"model.plane": plane} | ({"mesh.layers": 2} if name.endswith("3d") else {})
    return Scene.load(name).with_(**keys | {k.replace("__", "."): v for k, v in changes.items()})


def plate(**changes: Any) -> Scene:
    return Scene.load("jacobsen-mixed-mode").with_(
        **{"mesh.crack_size": 8.0, "mesh.far_size": 25.0, "output.frames": 0} | changes
    )


class Interfered:
    """The stiffness of a body; `before` is called with each system that is to be solved, and may raise."""

    def __init__(self, stiffness: Stiffness, before: Callable[[Border], None]) -> None:
        self._stiffness, self._before = stiffness, before

    def solve(self, border: Border, *given: Any) -> Array:
        self._before(border)
        return self._stiffness.solve(border, *given)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stiffness, name)


def interfered_march(scene: Scene, before: Callable[[Border], None], stages: list[Stage] | None = None) -> LoadStepper:
    """The march of a scene whose every linear system is seen, or spoiled, before it is solved."""
    model = build(scene)
    problem = replace(model.problem, stiffness=Interfered(model.problem.stiffness, before))
    return solve(problem, stages or scene.stages, model.recorded)


def run_and_keep(scene: Scene, model: str | None = None) -> tuple[Result, list[State], Model]:
    """A run with the state of every row, and a model of the same scene."""
    scene = scene if model is None else scene.with_(**{"model.kind": model})
    built = build(scene)
    states = [built.problem.initial()]
    result = run(scene, on_step=lambda step, row: states.append(step.equilibrium.state))
    return result, states, built


#: columns of a history that belong to a state, and those whose scale another one gives, as they may be rounding only
COMPARED = ("load", "opening", "sliding", "driven", "work", "elastic", "stored", "dissipated", "contact_work")
SCALES = {"sliding": "driven", "stored": "work", "contact_work": "work"}


def assert_same_history(one: Result, other: Result, tolerance: float, names: tuple[str, ...] = COMPARED) -> None:
    """Equal columns, in parts of the largest value of the other's."""
    for name in names:
        scale = abs(other.history[SCALES.get(name, name)]).max()
        np.testing.assert_allclose(one.history[name], other.history[name], atol=tolerance * scale, rtol=0.0, err_msg=name)


#: a scene on a mesh of the user's; the file is not there
OF_A_FILE: dict[str, Any] = {
    "specimen": {
        "kind": "mesh", "file": "a.msh", "thickness": 1.0, "crack": "c",
        "supports": [{"at": "b", "direction": [0, 1]}], "drive": {"at": "t", "direction": [0, 1]},
    },
    "material": {"preset": "reinhardt"},
    "stage": [{"control": "driven", "to": 0.1}],
}  # fmt: skip


def as_file(tmp_path: Path, mesh: meshio.Mesh, turn: Array, name: str, crack: list[list[float]], **changes: Any) -> Scene:
    """A scene on a mesh that is turned with everything that belongs to it."""
    plain = meshio.Mesh(np.column_stack([mesh.points @ turn.T, np.zeros(len(mesh.points))]), mesh.cells[:-1])
    plain.write(tmp_path / name)
    data = {
        "specimen": {
            "kind": "mesh", "file": name, "thickness": 10.0, "crack": [(turn @ p).tolist() for p in np.array(crack)],
            "supports": [
                {"at": (turn @ [x, -15.0]).tolist(), "direction": (turn @ d).tolist()}
                for x, d in ((-20.0, [1.0, 0.0]), (-20.0, [0.0, 1.0]), (20.0, [0.0, 1.0]))
            ],
            "drive": {"at": (turn @ [-20.0, 15.0]).tolist(), "direction": (turn @ [-0.6, 0.8]).tolist()},
            "gauge_minus": (turn @ [-20.0, -15.0]).tolist(), "gauge_plus": (turn @ [-20.0, 15.0]).tolist(),
        },
        "material": {"preset": "reinhardt"},
        "interface": {"width": 0.3},
        "solver": {"tol": 1e-11},
        "stage": [{"control": "opening", "to": [0.1, 0.06], "steps": 8}],
    }  # fmt: skip
    return Scene(data, tmp_path).with_(**changes)


def assert_refused(scene: Scene, message: str) -> None:
    with pytest.raises((SceneError, MeshError), match=message) as caught:
        run(scene)
    assert "\n" not in str(caught.value)


#: mid nodes of second-order cells, and the corners between which they are
MIDS = {
    "triangle6": [(3, 0, 1), (4, 1, 2), (5, 2, 0)],
    "quad8": [(4, 0, 1), (5, 1, 2), (6, 2, 3), (7, 3, 0)],
    "tetra10": [(4, 0, 1), (5, 1, 2), (6, 2, 0), (7, 0, 3), (8, 1, 3), (9, 2, 3)],
}

#: corners of a unit cube about the origin, in the order of a hexahedron
CUBE = np.array([[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]]) / 2.0

#: a cube, in the order of a hexahedron, as six tetrahedra around its diagonal 0-6
_TETRAHEDRA = [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]]


def grid(nx: int = 4, ny: int = 4, kind: str = "quad") -> meshio.Mesh:
    """Unit squares (nx by ny) from the origin, as quadrilaterals, or as triangles of either order."""
    step = 2 if kind in ("quad8", "triangle6") else 1
    numbers: dict[tuple[int, int], int] = {}

    def node(i: int, j: int) -> int:
        return numbers.setdefault((i, j), len(numbers))

    cells = []
    for j in range(0, ny * step, step):
        for i in range(0, nx * step, step):
            c = [(i, j), (i + step, j), (i + step, j + step), (i, j + step)]
            corners = [c] if kind.startswith("quad") else [[c[0], c[1], c[2]], [c[0], c[2], c[3]]]
            for ring in corners:
                cell = [node(*p) for p in ring]
                if step == 2:
                    cell += [
                        node((a[0] + b[0]) // 2, (a[1] + b[1]) // 2) for a, b in zip(ring, ring[1:] + ring[:1], strict=True)
                    ]
                cells.append(cell)
    points = np.array(list(numbers), dtype=float) / step
    return meshio.Mesh(points, [(kind, np.array(cells))])


def cubes(kind: str = "hexahedron", n: int = 4) -> meshio.Mesh:
    """Unit cubes (n x n x n) from the origin, or the six tetrahedra around the diagonal of each."""
    numbers = {p: i for i, p in enumerate(product(range(n + 1), repeat=3))}
    ring = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    cells = np.array([[numbers[tuple(np.add(o, r))] for r in ring] for o in product(range(n), repeat=3)])
    points = np.array(list(numbers), dtype=float)
    if kind == "hexahedron":
        return meshio.Mesh(points, [(kind, cells)])
    mesh = meshio.Mesh(points, [("tetra", cells[:, _TETRAHEDRA].reshape(-1, 4))])
    return with_mid_nodes(mesh) if kind == "tetra10" else mesh


@dataclass
class Patch:
    """Points (m, d), cells of one kind, and where they are split: crack cells and the representative of each node."""

    points: Array
    kind: str
    cells: Index
    representative: Index
    crack_kind: str = ""
    crack: Index | None = None


def rectangle(kind: str, counts: tuple[int, int] = (1, 1), size: tuple[float, float] = (1.0, 1.0)) -> Patch:
    """A rectangle of counts squares in x, y, as "triangle", "triangle6", "quad" or "quad8" elements."""
    mesh = grid(*counts, kind)
    return Patch(mesh.points * np.divide(size, counts), kind, mesh.cells[0].data, np.arange(len(mesh.points)))


def box(
    kind: str,
    counts: tuple[int, int, int] = (1, 1, 1),
    size: tuple[float, float, float] = (1.0, 1.0, 1.0),
    split: float | None = None,
) -> Patch:
    """A box of counts cubes in x, y, z, as "hexahedron", "tetra" or "tetra10" elements; split at z = `split`."""
    axes = [np.linspace(0.0, length, n + 1) for length, n in zip(size, counts, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    ids = np.arange(len(points)).reshape([n + 1 for n in counts])
    lower = [ids[dx : dx + counts[0], dy : dy + counts[1], :-1].ravel() for dx, dy in ((0, 0), (1, 0), (1, 1), (0, 1))]
    cells = np.stack([*lower, *(corner + 1 for corner in lower)], axis=1)
    if kind != "hexahedron":
        cells = cells[:, _TETRAHEDRA].reshape(-1, 4)
    if kind == "tetra10":
        points, cells = _with_mids(points, cells, [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)])
    solid = Patch(points, kind, cells, np.arange(len(points)))
    return solid if split is None else _split(solid, split)


def _with_mids(points: Array, cells: Index, pairs: list[tuple[int, int]]) -> tuple[Array, Index]:
    ends = np.sort(cells[:, pairs].reshape(-1, 2), axis=1)
    edges, number = np.unique(ends, axis=0, return_inverse=True)
    mids = len(points) + number.reshape(len(cells), -1)
    return np.concatenate([points, points[edges].mean(axis=1)]), np.column_stack([cells, mids])


def _split(solid: Patch, z: float) -> Patch:
    points, cells = solid.points, solid.cells.copy()
    on = np.flatnonzero(abs(points[:, 2] - z) < 1e-9)
    twin = np.arange(len(points))
    twin[on] = len(points) + np.arange(len(on))
    above = points[cells].mean(axis=1)[:, 2] > z
    n_corners = {"hexahedron": 8}.get(solid.kind, 4)
    facets, mids = [], []
    edge_mids = {(0, 1): 4, (1, 2): 5, (0, 2): 6, (0, 3): 7, (1, 3): 8, (2, 3): 9}
    for cell in cells[~above]:
        at = [i for i in range(n_corners) if cell[i] in set(on)]
        if len(at) < (4 if solid.kind == "hexahedron" else 3):
            continue
        if solid.kind == "hexahedron":
            at = [4, 5, 6, 7]
        p = points[cell[at]]
        if np.cross(p[1] - p[0], p[2] - p[0])[2] < 0:
            at = at[::-1]
        facets.append(cell[at])
        if solid.kind == "tetra10":
            mids.append([cell[edge_mids[min(a, b), max(a, b)]] for a, b in pairwise([*at, at[0]])])
    cells[above] = twin[cells[above]]
    a = np.array(facets)
    crack = np.column_stack([a, twin[a]])
    if mids:
        crack = np.column_stack([crack, np.array(mids), twin[np.array(mids)], a])
    representative = np.concatenate([solid.representative, on])
    kind = {"hexahedron": "hexahedron", "tetra": "wedge", "tetra10": "wedge15"}[solid.kind]
    return Patch(np.concatenate([points, points[on]]), solid.kind, cells, representative, kind, crack)


def rotation(seed: int, d: int = 3) -> Array:
    """A rotation of space, or of the plane, at random."""
    Q = np.linalg.qr(np.random.default_rng(seed).normal(size=(d, d)))[0]
    Q[:, 0] *= np.linalg.det(Q)
    return np.asarray(Q)
