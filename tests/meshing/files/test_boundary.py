"""Meshes of the user's in which a crack grows: their boundary and sets as an outline, and what gives none."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest

from cohesive import Scene, SceneError
from meshing.files.boundary import boundary_outline
from meshing.generation.outline import Outline
from meshing.generation.polygon import mesh_face
from meshing.generation.sizes import MeshSizes

CORNERS = [(0.0, 0.0), (60.0, 0.0), (60.0, 40.0), (0.0, 40.0)]
HOLE = [(30.0, 10.0), (40.0, 10.0), (40.0, 20.0)]
SETS = {"base": [(10.0, 0.0), (50.0, 0.0)], "round": [(60.0, 0.0), (60.0, 40.0), (0.0, 40.0)], "hole": [*HOLE, HOLE[0]]}


#: a square with a slit from its lower face to its middle, nodes 1 and 2 on its two sides
SLIT = [[0, 0], [1, 0], [1, 0], [2, 0], [2, 2], [1, 1], [0, 2]]


def write(path: Path, order: int = 1, shape: str = "triangle", **sets: Any) -> Path:
    """A plate with a hole, meshed: its sets of edges, one of single nodes, and others by their nodes."""
    outline = Outline(CORNERS, [], nodes={"ends": [(10.0, 0.0), (50.0, 0.0)]}, edges=SETS, holes=[HOLE])
    mesh = mesh_face(outline, MeshSizes(4.0, 4.0, shape, order), conforming=True)
    mesh.point_sets |= {name: np.flatnonzero(which(mesh.points)) for name, which in sets.items()}
    mesh.write(path)
    return path


def rotated(line: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """A polygon from its least corner on."""
    i = line.index(min(line))
    return [*line[i:], *line[:i]]


@pytest.mark.parametrize("shape", ["triangle", "quad"])
@pytest.mark.parametrize("order", [1, 2])
def test_the_outline_is_that_of_which_the_mesh_was_made(tmp_path: Path, order: int, shape: str) -> None:
    """Corners and sets come back without the nodes between them, but for those at which a set ends."""
    found = boundary_outline(write(tmp_path / "plate.inp", order, shape), ["base", "ends"])
    np.testing.assert_allclose(rotated(list(found.corners)), [(0, 0), (10, 0), (50, 0), (60, 0), (60, 40), (0, 40)], atol=1e-9)
    np.testing.assert_allclose(rotated(list(found.holes[0])), [HOLE[0], HOLE[2], HOLE[1]], atol=1e-9)
    assert {name: sorted(at) for name, at in found.nodes.items()} == {"ends": [(10.0, 0.0), (50.0, 0.0)]}
    for name in ("base", "round"):
        assert list(found.edges[name]) == SETS[name]
    assert sorted(set(found.edges["hole"])) == sorted(HOLE) and found.edges["hole"][0] == found.edges["hole"][-1]


def grown(path: Path, **changes: Any) -> Scene:
    """A scene of such a file."""
    supports = [{"at": "base", "direction": [0, 1]}, {"at": [0.0, 0.0], "direction": [1, 0]}]
    specimen = {"kind": "mesh", "file": str(path), "crack": "grow", "thickness": 10.0, "supports": supports,
                "drive": {"at": "round", "direction": [0, 1]}}  # fmt: skip
    stage = [{"control": "driven", "to": 0.01, "steps": 5}]
    material = {"E": 30000.0, "nu": 0.2, "ft": 3.0, "Gf": 0.1}
    return Scene({"specimen": specimen | changes, "material": material, "stage": stage})


def test_supports_drives_and_gauges_are_kept(tmp_path: Path) -> None:
    """The scene is that of an outline, which is meshed with the same sets, on elements of its own sizes."""
    gauges = {"gauge_minus": [30.0, 40.0], "gauge_plus": "ends"}
    scene = grown(write(tmp_path / "plate.inp"), **gauges).with_(**{"mesh.crack_size": 2.0, "mesh.far_size": 4.0})
    assert scene.kind == "outline" and scene.grow is not None
    given = scene.data["specimen"]
    assert [given[name] for name in gauges] == [*gauges.values()] and given["drive"]["at"] == "round"
    mesh = scene.along([[(30.0, 20.0), (30.0, 40.0)]]).specimen.mesh(scene.sizes)
    base = mesh.points[mesh.point_sets["base"]]
    assert base.min(axis=0).tolist() == [10.0, 0.0] and base.max(axis=0).tolist() == [50.0, 0.0]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"supports": [{"at": "both", "direction": [0, 1]}]}, r"^specimen.crack = 'grow': set both is neither a row of edges"),
        ({"drive": {"at": "no", "direction": [0, 1]}}, r"^at = 'no': expected one of base, ends, hole, round, or a point$"),
        ({"regions": {"both": {"E": 1.0, "nu": 0.0}}}, r"^specimen.regions: a body in which a crack grows is meshed again"),
        ({"file": "none.inp"}, r"^specimen.file = '.*none.inp': there is no such file$"),
    ],
)
def test_what_an_outline_does_not_say_is_refused(tmp_path: Path, changes: dict[str, Any], message: str) -> None:
    path = write(tmp_path / "plate.inp", both=lambda p: (p[:, 0] < 1e-9) | (p[:, 0] > 60 - 1e-9))
    with pytest.raises((SceneError, ValueError), match=message):
        grown(path, **changes).specimen.outline()


@pytest.mark.parametrize(
    ("points", "cells", "message"),
    [
        ([[0, 0], [1, 0], [0, 1], [1, 1], [2, 1], [1, 2]], [[0, 1, 2], [3, 4, 5]], "its elements are in 2 parts"),
        ([[0, 0], [1, 0], [0, 1], [-1, 0], [0, -1]], [[0, 1, 2], [0, 3, 4]], r"its boundary meets itself at \(0, 0\)"),
        (SLIT, [[0, 1, 5], [0, 5, 6], [2, 3, 5], [3, 4, 5], [6, 5, 4]], "its boundary has two nodes in one place"),
    ],
)
def test_what_is_no_body_is_refused(tmp_path: Path, points: Any, cells: Any, message: str) -> None:
    path = tmp_path / "odd.vtu"
    meshio.Mesh(np.array([[*p, 0.0] for p in points], dtype=float), [("triangle", np.array(cells))]).write(path)
    with pytest.raises(ValueError, match=message):
        boundary_outline(path, [])


def test_a_solid_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "solid.vtu"
    meshio.Mesh(np.vstack([np.zeros(3), np.eye(3)]), [("tetra", np.array([[0, 1, 2, 3]]))]).write(path)
    with pytest.raises(ValueError, match=r"^crack = 'grow': the mesh of '.*' is solid, and crack fronts are given"):
        boundary_outline(path, [])
