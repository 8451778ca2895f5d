"""The same answer in other ways: condensed and full, straight and rotated, in 2D and in 3D; and the law's own."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from numpy.typing import NDArray

from cohesive import CrackPlane, Result, Scene, run
from cohesive.algebra.unknowns import Constraint
from cohesive.elements.rotations import major_stress
from cohesive.model import build
from meshing import MeshSizes, SingleCrack
from tests.builders import Patch, as_file, assert_same_history, block, box, rotation

Array = NDArray[np.float64]
Place = Callable[..., None]

SIZE = (40.0, 10.0, 40.0)
AREA = SIZE[0] * SIZE[1]
WIDTH = 0.3


def scene_of(kind: str, **changes: Any) -> Scene:
    """The plane block of 40 x 40 x 10 mm, whose options the one in space takes."""
    return block(material__m_g=0.3, model__kind=kind, interface__width=WIDTH, band__width=2.0, **changes)


@pytest.fixture
def place(monkeypatch: pytest.MonkeyPatch) -> Place:
    """Puts a solid, turned by Q, in the place of the specimen's mesh: held on its base, or `clamped` at base and top, and
    driven on its top along z, or also along x."""

    def put(solid: Patch, Q: Array, clamped: bool = False) -> None:
        flat = solid.points
        mesh = meshio.Mesh(flat @ Q.T, [(solid.kind, solid.cells)], point_data={"original": solid.leader})
        if solid.crack is not None:
            mesh.cells.append(meshio.CellBlock(solid.crack_kind, solid.crack))
        else:  # the layer in the middle is a band
            middle = abs(flat[solid.cells].mean(axis=1)[:, 2] - SIZE[2] / 2) < 1e-6
            mesh.cells = [meshio.CellBlock(solid.kind, solid.cells[at]) for at in (~middle, middle)]
            mesh.cell_sets["band"] = mesh.cell_sets["row"] = [np.zeros(0, dtype=int), np.arange(middle.sum())]
        x, y, z = (tuple(axis) for axis in Q.T)
        base, top = (np.flatnonzero(abs(flat[:, 2] - at) < 1e-6) for at in (0.0, SIZE[2]))
        corner, other = (np.flatnonzero(np.linalg.norm(flat - [at, 0, 0], axis=1) < 1e-6) for at in (0.0, SIZE[0]))
        supports, drives = [Constraint("base", base, z)], [Constraint("pull", top, z)]
        if clamped:
            supports += [Constraint("base", base, x), Constraint("base", base, y), Constraint("top", top, y)]
            drives.append(Constraint("push", top, x))
        else:
            supports += [Constraint("corner", corner, x), Constraint("corner", corner, y), Constraint("other", other, y)]
        monkeypatch.setattr(SingleCrack, "mesh", lambda *_: mesh)
        monkeypatch.setattr(SingleCrack, "mesh_band", lambda *_: mesh)
        monkeypatch.setattr(build, "ties", lambda scene, mesh: (supports, drives, None))

    return put


PANEL = {"mesh.crack_size": 100.0, "mesh.far_size": 100.0, "stage.0.steps": 20, "stage.1.steps": 10}
OPENINGS = [0.0005, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1]
SOLIDS = {
    "tetra": box("tetra", (2, 2, 2), SIZE, split=20.0),
    "tetra10": box("tetra10", (2, 2, 2), SIZE, split=20.0),
    "hexahedron": box("hexahedron", (2, 2, 2), SIZE, split=20.0),
}
#: five layers, the middle one of 2 mm
BAND = box("hexahedron", (2, 2, 5), SIZE)
BAND.points[:, 2] = np.interp(BAND.points[:, 2], [0, 8, 16, 24, 32, 40], [0, 10, 19, 21, 30, 40])
SCENES = {**dict.fromkeys(SOLIDS, "discrete"), "band": "smeared"}
SOLIDS["band"] = BAND


@pytest.mark.parametrize("quadrature", ["nodal", "gauss"])
@pytest.mark.parametrize("name", SOLIDS)
def test_tension_follows_the_softening_curve(name: str, quadrature: str, place: Place, tmp_path: Path) -> None:
    """Free of lateral stress, so that the state stays uniform: the law's traction, and the bulk's elastic stretch."""
    Q = rotation(1)
    place(SOLIDS[name], Q)
    width = 2.0 if name == "band" else WIDTH
    stage = [{"control": "opening", "to": OPENINGS, "steps": 1}]
    result = run(scene_of(SCENES[name], interface__quadrature=quadrature, stage=stage))
    h, law = result.history, CrackPlane(result.scene.material, width)
    np.testing.assert_allclose(h["opening"], OPENINGS, rtol=1e-9)
    t, bulk = law.traction(np.stack([OPENINGS, 0 * h["load"]], axis=1), np.zeros(len(OPENINGS)))[0][:, 0], SIZE[2]
    bulk -= width if name == "band" else 0.0
    np.testing.assert_allclose(h["load"], t * AREA, rtol=1e-8)
    np.testing.assert_allclose(h["driven"], OPENINGS + t * bulk / result.scene.material.E, rtol=1e-8)
    np.testing.assert_allclose(h["stress_n"], t, rtol=1e-8)
    np.testing.assert_allclose(h["stress_s"], 0.0, atol=1e-8 * t.max())
    frame = result.frame(len(t) - 1)
    for stress in frame.stress:
        np.testing.assert_allclose(major_stress(stress), t[-1], rtol=1e-7)
    for key, value in {"traction_n": t[-1], "traction_s": 0.0, "sliding": 0.0, "planes": 1.0}.items():
        np.testing.assert_allclose(frame.cracks[key], value, atol=1e-7 * t[-1], err_msg=key)
    written = result.frame_mesh(frame)
    assert written.points.shape == written.point_data["displacement"].shape == (len(frame.displacement), 3)
    meshio.write(tmp_path / "frame.vtu", written)
    assert {"stress_zz", "stress_yz", "stress_max", "is_crack"} < set(written.cell_data)


@pytest.mark.parametrize("kind", ["discrete", "smeared"])
def test_the_plane_answer(kind: str, place: Place) -> None:
    """Without a Poisson's ratio the block in space is the plane scene, closing and reopening included."""
    stage = [{"control": "opening", "to": [0.01, 0.05, 0.01, 0.03], "steps": 4}]
    scene = scene_of(kind, material__nu=0.0, stage=stage)
    plane = run(scene).history
    place(SOLIDS["hexahedron" if kind == "discrete" else "band"], np.eye(3))
    space = run(scene).history
    for name in ("load", "opening", "driven", "stress_n", "elastic", "stored", "dissipated", "contact_work", "work"):
        size = abs(plane["work" if name in ("stored", "contact_work") else name]).max()
        np.testing.assert_allclose(space[name], plane[name], atol=1e-8 * size, err_msg=name)


def pulled_and_sheared(name: str, reduction: str = "always") -> Result:
    """Two drives at 60 degrees between pull and shear, clamped faces: nothing is uniform."""
    stage = [{"control": "driven", "to": [0.004, 0.012, 0.03], "steps": 2, "angle": 60.0}]
    return run(scene_of(SCENES[name], solver__condensation=reduction, stage=stage))


#: scenes of plane bodies, which are condensed to at most this part of their unknowns
PLANE: dict[str, tuple[dict[str, Any], float]] = {
    "beam, interface": (
        {"stage.0.to": [0.06, 0.03, 0.1], "specimen.notch_position": 10.0, "mesh.crack_size": 2.5, "mesh.far_size": 12.0,
         "stage.0.steps": 20}, 0.1),
    "beam, band": (
        {"model.kind": "smeared", "stage.0.to": [0.06, 0.02, 0.09], "mesh.crack_size": 2.5, "mesh.far_size": 12.0,
         "stage.0.steps": 10}, 0.3),
    "plate on hinges": (
        {"mesh.crack_size": 8.0, "mesh.far_size": 25.0, "specimen.platens": "hinged", "stage.1.to": 0.1, "stage.1.step": 0.02},
        0.3),
    "panel, interface": (PANEL | {"model.kind": "discrete"}, 0.9),
    "panel, band": (PANEL | {"model.kind": "smeared"}, 0.9),
}  # fmt: skip


def assert_condensed_is_full(condensed: Result, full: Result) -> None:
    """Histories and what a frame shows."""
    assert condensed.model.condensation.kind == "condensed"
    assert full.active_dofs == full.total_dofs == condensed.total_dofs > condensed.active_dofs
    assert_same_history(condensed, full, 1e-8)
    for row in (3, len(full.history["load"]) - 1):
        a, b = condensed.frame(row), full.frame(row)
        np.testing.assert_allclose(a.displacement, b.displacement, atol=1e-8 * abs(b.displacement).max())
        for one, other in zip(a.stress, b.stress, strict=True):
            np.testing.assert_allclose(one, other, atol=1e-7 * full.scene.material.ft)


@pytest.mark.parametrize("name", PLANE)
def test_condensed_is_full(name: str) -> None:
    changes, part = PLANE[name]
    kind = {"beam": "notched-beam", "plate": "jacobsen-mixed-mode", "panel": "sandwich-panel"}[name.split()[0].rstrip(",")]
    exact = Scene.load(kind).with_(**changes, **{"solver.tol": 1e-11, "output.frames": 0})
    condensed, full = (run(exact.with_(**{"solver.condensation": reduction})) for reduction in ("always", "never"))
    assert_condensed_is_full(condensed, full)
    assert condensed.active_dofs < part * condensed.total_dofs


@pytest.mark.parametrize("name", SOLIDS)
def test_condensed_is_full_and_rotated_is_straight_in_3d(name: str, place: Place) -> None:
    place(SOLIDS[name], np.eye(3), clamped=True)
    condensed, full = pulled_and_sheared(name), pulled_and_sheared(name, "none")
    place(SOLIDS[name], rotation(4), clamped=True)
    turned = pulled_and_sheared(name)
    assert condensed.model.condensation.kind == "condensed" and full.active_dofs == full.total_dofs > condensed.active_dofs
    assert full.dissipated_energy > 1.0  # N mm
    energy = full.history["work"].max()
    for one, tolerance in ((condensed, 1e-9), (turned, 1e-8)):
        for key in ("load", "opening", "driven", "stress_n"):
            size = abs(full.history[key]).max()
            np.testing.assert_allclose(one.history[key], full.history[key], atol=tolerance * size, err_msg=key)
        for key in ("work", "elastic", "stored", "dissipated", "contact_work"):
            np.testing.assert_allclose(one.history[key], full.history[key], atol=tolerance * energy, err_msg=key)
    frames = [result.frame(len(full.history["load"]) - 1) for result in (full, condensed, turned)]
    u, same, other = (frame.displacement for frame in frames)
    np.testing.assert_allclose(same, u, atol=1e-9 * abs(u).max())
    np.testing.assert_allclose(other @ rotation(4), u, atol=1e-8 * abs(u).max())
    for key, values in frames[0].cracks.items():
        np.testing.assert_allclose(frames[2].cracks[key], values, atol=1e-7 * abs(values).max(), err_msg=key)
    assert frames[0].cracks["sliding"].min() > 0 and frames[0].cracks["traction_s"].min() > 0  # sizes, whatever the axes


@pytest.mark.parametrize("name", SOLIDS)
def test_mean_tractions_carry_the_drives(name: str, place: Place) -> None:
    """With the crack's normal along y the first tangent is x, as in the plane: the direction of the push."""
    Q = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
    place(SOLIDS[name], Q, clamped=True)
    result = pulled_and_sheared(name)
    problem, last = result.problem, result.last
    pull, push = problem.internal_force(last)[problem.drives] / AREA
    assert abs(push) > 0.1
    # every row of the condensed forces is balanced to the solver's tolerance
    np.testing.assert_allclose([result.history[key][-1] for key in ("stress_n", "stress_s")], [pull, push], atol=1e-8)
    top = SOLIDS[name].points[:, 2] > SIZE[2] - 1e-6
    moved = result.frame(len(result.history["load"]) - 1).displacement[top].mean(axis=0)
    assert problem.describe(0).count(",") == 2
    assert 0.2 * moved[0] < result.history["sliding"][-1] < moved[0]


@pytest.mark.parametrize("angle", [30.0, 45.0, 90.0, 137.2])
def test_rotating_the_whole_scene_changes_nothing(tmp_path: Path, angle: float) -> None:
    path = [[-20.0, 0.0], [0.0, 4.0], [10.0, 0.0]]  # a kinked crack with its tip inside
    specimen = SingleCrack(40.0, 30.0, 10.0, crack=path)
    mesh = specimen.mesh(MeshSizes(5.0, 8.0))
    # the uncut mesh: copies given back their first number
    original = mesh.point_data["original"]
    mesh.cells[0].data[:] = original[mesh.cells[0].data]
    mesh.points = mesh.points[: original.max() + 1]
    t = np.radians(angle)
    turn = np.array([[np.cos(t), -np.sin(t)], [np.sin(t), np.cos(t)]])
    straight = run(as_file(tmp_path, mesh, np.eye(2), "straight.vtu", path))
    turned = run(as_file(tmp_path, mesh, turn, "turned.vtu", path))
    assert straight.dissipated_energy > 1.0
    assert_same_history(turned, straight, 1e-8)


@pytest.mark.parametrize(("shape", "order"), [("triangle", 1), ("quad", 1), ("triangle", 2)])
@pytest.mark.parametrize("angle", [0.0, 20.0])
def test_a_rotated_block_has_the_same_history(angle: float, shape: str, order: int) -> None:
    """Opened and nearly closed, also on an inclined path, where the crack slides. There gmsh pairs the triangles of a
    turned block to other quadrilaterals: two meshes, whose loads differ by 2e-4."""
    options: dict[str, Any] = {"mesh__shape": shape, "mesh__order": order, "specimen__angle": angle}
    options["stage__0__to"] = [0.05, 0.01]
    straight = run(block(model__kind="smeared", **options))
    assert straight.dissipated_energy > 1.0
    assert (abs(straight.history["sliding"]).max() > 1e-3) == (angle > 0)
    for turn in (45.0, 90.0, 137.2):
        other_mesh = angle > 0 and shape == "quad"
        turned = run(block(model__kind="smeared", specimen__rotation=turn, **options))
        assert_same_history(turned, straight, 1e-3 if other_mesh else 1e-8)
