"""A body that is not held is refused whatever rounding says, and the free motion is named."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest

import cohesive.model.build as building
from cohesive import Scene, SceneError
from cohesive.arrays import Array
from cohesive.model.build import build
from cohesive.scenes.scene import built_in
from tests.builders import box, grid

X, Y, Z = [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]


def scene_on(folder: Path, mesh: meshio.Mesh, supports: list[dict[str, Any]], **changes: Any) -> Scene:
    """A scene on a mesh, cut at x = 2 in the plane or z = 1 in space, with the drive at its last node."""
    d = mesh.points.shape[1]
    crack: Any = [[2.0, 0.0], [2.0, 1.0]]
    sets = dict(mesh.point_sets or {})
    if d == 3:
        crack = "crack"
        sets["crack"] = np.flatnonzero(abs(mesh.points[:, 2] - 1.0) < 1e-9)
    points = mesh.points if d == 3 else np.column_stack([mesh.points, np.zeros(len(mesh.points))])
    meshio.Mesh(points, mesh.cells, point_sets=sets).write(folder / "own.inp", file_format="abaqus")
    data: dict[str, Any] = {
        "specimen": {
            "kind": "mesh", "file": "own.inp", "crack": crack, "supports": supports,
            "drive": {"at": mesh.points[-1].tolist(), "direction": Y[:d]},
        },
        "material": {"preset": "reinhardt"},
        "solver": {"condensation": "never"},
        "stage": [{"control": "driven", "to": 0.1}],
    }  # fmt: skip
    if d == 2:
        data["specimen"]["thickness"] = 1.0
    data["specimen"] |= changes
    return Scene(data, folder)


def held(*entries: tuple[list[float], list[float]]) -> list[dict[str, Any]]:
    return [{"at": at, "direction": direction} for at, direction in entries]


#: a beam of 4 x 1 squares: what holds it, and what is said
PLANE: dict[str, tuple[list[tuple[list[float], list[float]]], str]] = {
    "four points and no support along x": ([([0, 0], [0, 1]), ([4, 0], [0, 1])], "nothing holds it along x;"),
    "three rollers that slide": ([([x, 0], [0, 1]) for x in (0, 2, 4)], "nothing holds it along x;"),
    "one pin": ([([0, 0], [1, 0]), ([0, 0], [0, 1])], r"nothing holds it against turning about \(0, 0\);"),
    "one roller": ([([0, 0], [0, 1])], "nothing holds it along x and against turning;"),
    "rollers on a line": (
        [([0, 0], [1, 0]), ([1, 0], [1, 0]), ([4, 0], [1, 0])],
        r"nothing holds it along y and against turning;",
    ),
    "forces that meet": (
        [([0, 0], [2, 3]), ([4, 0], [-2, 3]), ([2, 0], [0, 1])],
        r"nothing holds it against turning about \(2, 3\);",
    ),
    "rollers on a slope": ([([0, 0], [1, 2]), ([2, 0], [1, 2])], r"nothing holds it along \(0.894427, -0.447214\);"),
    "held": ([([0, 0], [1, 0]), ([0, 0], [0, 1]), ([4, 0], [0, 1])], ""),
    "held by three lines that do not meet": ([([0, 0], [2, 3]), ([4, 0], [-2, 3]), ([1, 0], [0, 1])], ""),
}


def assert_said(scene: Scene, message: str) -> None:
    """Refused with a message, or built if there is none."""
    if not message:
        build(scene)
        return
    with pytest.raises(SceneError, match=message) as caught:
        build(scene)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("case", PLANE)
def test_a_plane_body(case: str, tmp_path: Path) -> None:
    supports, message = PLANE[case]
    assert_said(scene_on(tmp_path, grid(4, 1), held(*supports)), message)


#: a box of 2 x 1 x 2: the corner (0, 0, 0) and others
SOLID: dict[str, tuple[list[tuple[Any, list[float]]], str]] = {
    "on a plane": ([("base", Z)], "nothing holds it along x and y and against turning about z;"),
    "on a plane, one node pinned": ([("base", Z), ([0, 0, 0], X), ([0, 0, 0], Y)], "it against turning about z;"),
    "on an edge": ([([0, 0, 0], a) for a in (X, Y, Z)] + [([2, 0, 0], a) for a in (Y, Z)], "it against turning about x;"),
    "one node pinned": ([([0, 0, 0], a) for a in (X, Y, Z)], "it against turning about x, y and z;"),
    "along no axis": ([([0, 0, 0], X)], "it along y and z and against turning about x, y and z;"),
    "held": ([("base", Z), ([0, 0, 0], X), ([0, 0, 0], Y), ([2, 0, 0], Y)], ""),
}


@pytest.mark.parametrize("case", SOLID)
def test_a_solid_body(case: str, tmp_path: Path) -> None:
    supports, message = SOLID[case]
    solid = box("hexahedron", (2, 1, 2), (2.0, 1.0, 2.0))
    base = np.flatnonzero(solid.points[:, 2] < 1e-9)
    mesh = meshio.Mesh(solid.points, [(solid.kind, solid.cells)], point_sets={"base": base})
    assert_said(scene_on(tmp_path, mesh, held(*supports)), message)


def test_a_piece_that_hangs_on_one_node_turns_about_it(tmp_path: Path) -> None:
    mesh = grid(4, 1)
    beyond = np.array([[5.0, 1.0], [5.0, 2.0], [4.0, 2.0]])
    corner = int(np.flatnonzero((mesh.points == [4.0, 1.0]).all(axis=1))[0])
    more = [corner, *(len(mesh.points) + np.arange(3))]
    hinged = meshio.Mesh(np.concatenate([mesh.points, beyond]), [("quad", np.vstack([mesh.cells[0].data, more]))])
    three = held(*PLANE["held"][0])
    assert_said(
        scene_on(tmp_path, hinged, three), r"holds its part of 1 element at \(4.5, 1.5\) against turning about \(4, 1\);"
    )
    assert_said(scene_on(tmp_path, hinged, [*three, *held(([5, 2], [1, 0]))]), "")
    # by itself it is not held at all
    more[0] = len(hinged.points)
    loose = meshio.Mesh(np.vstack([hinged.points, [4.5, 0.9]]), [("quad", np.vstack([mesh.cells[0].data, more]))])
    assert_said(scene_on(tmp_path, loose, three), r"holds its part of 1 element at .* along x and y and against turning;")


def net(nx: int, ny: int) -> list[list[list[float]]]:
    """Paths along all inner edges of a grid."""
    upright = [[[float(x), 0.0], [float(x), float(ny)]] for x in range(1, nx)]
    return upright + [[[0.0, float(y)], [float(nx), float(y)]] for y in range(1, ny)]


@pytest.mark.parametrize(
    ("nx", "ny", "kind"), [(67, 3, "quad"), (101, 2, "triangle"), (202, 1, "quad"), (67, 3, "quad8"), (40, 40, "quad")]
)
def test_a_crack_on_every_edge_leaves_one_body(nx: int, ny: int, kind: str, tmp_path: Path) -> None:
    """More than 200 pieces, which crack elements hold together until they break."""
    three = held(([0, 0], [1, 0]), ([0, 0], [0, 1]), ([nx, 0], [0, 1]))
    mesh = grid(nx, ny, kind)
    assert_said(scene_on(tmp_path, mesh, three, crack=net(nx, ny)), "")
    assert_said(scene_on(tmp_path, mesh, three[:2], crack=net(nx, ny)), r"nothing holds it against turning about \(0, 0\);")
    # a square beside it that no crack element holds is named by itself
    at = len(mesh.points)
    beside = np.array([[-2.0, 0.0], [-1.0, 0.0], [-1.0, 1.0], [-2.0, 1.0]])
    if kind == "quad":
        two = meshio.Mesh(np.concatenate([mesh.points, beside]), [(kind, np.vstack([mesh.cells[0].data, at + np.arange(4)]))])
        drive = {"at": [float(nx), float(ny)], "direction": Y[:2]}
        loose = scene_on(tmp_path, two, three, crack=net(nx, ny), drive=drive)
        assert_said(loose, r"nothing holds its part of 1 element at \(-1.5, 0.5\) along x and y and against turning;")


def test_a_support_that_gives_way_holds(tmp_path: Path) -> None:
    supports = held(*PLANE["held"][0])
    supports[0]["stiffness"] = 1e-3
    assert_said(scene_on(tmp_path, grid(4, 1), supports), "")


def test_what_another_drive_holds_may_be_let_go(tmp_path: Path) -> None:
    """A force holds nothing, a motion does."""
    drives = [{"name": "pull", "at": [4, 1], "direction": [0, 1]}, {"name": "push", "at": [0, 0], "direction": [1, 0]}]
    own = scene_on(tmp_path, grid(4, 1), held(*PLANE["four points and no support along x"][0]), drive=None, drives=drives)
    stage = {"control": "driven", "to": 0.1}
    for ways, message in (
        (("motion", "motion"), ""),
        (("force", "motion"), "^specimen: the body is not held, nothing holds it along x;"),
        (("motion", "free"), "^stage.1: the body is held no longer, nothing holds it along x;"),
    ):
        assert_said(own.with_(stage=[stage | {"others": {"push": way}} for way in ways]), message)


def _stiffness(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> Array:
    """Of the elastic body with its crack closed, whether it is held or not."""
    with monkeypatch.context() as patch:
        patch.setattr(building, "check_supports", lambda *_: None)
        patch.setattr(building, "check_stages", lambda *_: None)
        problem = build(scene).problem
    matrix = np.column_stack([problem.stiffness.apply(column) for column in np.eye(problem.operator.size)])
    rows, columns, values = problem.border(problem.point_law.elastic(), problem.drive, 0.0).crack
    np.add.at(matrix, (rows, columns), values)
    return matrix


@pytest.mark.parametrize("seed", range(12))
def test_the_rank_is_that_of_the_stiffness(seed: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Random supports: a body is refused if and only if its stiffness has no full rank."""
    rng = np.random.default_rng(seed)
    mesh, directions = grid(4, 1), np.array([[1, 0], [0, 1], [3, 4]])
    nodes = rng.choice(len(mesh.points) - 1, size=rng.integers(2, 5), replace=False)
    supports = held(*((mesh.points[i].tolist(), rng.choice(directions).tolist()) for i in nodes))
    scene = scene_on(tmp_path, mesh, supports)
    size = np.linalg.eigvalsh(_stiffness(scene, monkeypatch))
    try:
        build(scene)
        is_held = True
    except SceneError:
        is_held = False
    assert is_held == (size[0] > 1e-9 * size[-1])


@pytest.mark.parametrize("name", built_in())
def test_built_in_specimens_are_held(name: str) -> None:
    scene = Scene.load(name)
    length = scene.crack_length
    build(scene.with_(**{"mesh.crack_size": length / 4, "mesh.far_size": length / 2}))


@pytest.mark.parametrize("name", ["notched-beam", "notched-tension"])
def test_a_half_is_held_by_its_plane_of_symmetry(name: str) -> None:
    scene = Scene.load(name)
    length = scene.crack_length
    build(scene.with_(**{"mesh.crack_size": length / 4, "mesh.far_size": length / 2, "model.half": True}))
