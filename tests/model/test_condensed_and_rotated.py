"""The same answer in other ways: condensed and full, straight and rotated, in 2D and in 3D; and the law's own."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import meshio
import numpy as np
import pytest

from cohesive import CrackPlane, Result, Scene, run
from cohesive.arrays import Array, Index
from cohesive.elements.rotations import major_stress
from meshing import MeshSizes, SingleCrack
from meshing.specimens import SPECIMENS, Drive, Specimen, Support, register_specimen
from tests.builders import as_file, assert_same_history, block, box, rotation, run_and_keep

SIZE = (40.0, 10.0, 40.0)
AREA = SIZE[0] * SIZE[1]
WIDTH = 0.3

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


@dataclass(frozen=True)
class HandMade(Specimen):
    """A box of elements made by hand, rotated: held on its base, or clamped at base and top, and driven on its top along z,
    or also along x."""

    solid: str  # of SOLIDS
    rotation: Any  # rows of its matrix
    clamped: bool = False

    dimensions: ClassVar[tuple[int, ...]] = (3,)
    is_sized: ClassVar[bool] = False
    thickness = None

    def _mesh(self, cells: list[tuple[str, Index]], **sets: list[Index]) -> meshio.Mesh:
        solid = SOLIDS[self.solid]
        x, _, z = solid.points.T
        on_edge = np.linalg.norm(solid.points[:, 1:], axis=1) < 1e-6
        places = {"base": z < 1e-6, "top": z > SIZE[2] - 1e-6, "corner": on_edge & (x < 1e-6)}
        places["other"] = on_edge & (x > SIZE[0] - 1e-6)
        points, named = solid.points @ np.array(self.rotation).T, {name: np.flatnonzero(at) for name, at in places.items()}
        return meshio.Mesh(points, cells, {"original": solid.representative}, point_sets=named, cell_sets=sets)

    def mesh(self, sizes: MeshSizes, *, half: bool = False, dimension: int = 2) -> meshio.Mesh:
        solid = SOLIDS[self.solid]
        assert solid.crack is not None
        in_crack = [np.zeros(0, dtype=int), np.arange(len(solid.crack))]
        return self._mesh([(solid.kind, solid.cells), (solid.crack_kind, solid.crack)], crack=in_crack)

    def mesh_band(self, sizes: MeshSizes, width: float, *, half: bool = False, dimension: int = 2) -> meshio.Mesh:
        """The layer in the middle is the band."""
        solid = SOLIDS[self.solid]
        middle = abs(solid.points[solid.cells].mean(axis=1)[:, 2] - SIZE[2] / 2) < 1e-6
        in_band = [np.zeros(0, dtype=int), np.arange(middle.sum())]
        return self._mesh([(solid.kind, solid.cells[at]) for at in (~middle, middle)], band=in_band, row=in_band)

    def mesh_body(self, sizes: MeshSizes, *, dimension: int = 2) -> meshio.Mesh:
        raise NotImplementedError

    def held(self, *, half: bool = False) -> list[Support]:
        x, y, z = (tuple(axis) for axis in np.array(self.rotation).T)
        if self.clamped:
            return [Support("base", z), Support("base", x), Support("base", y), Support("top", y)]
        return [Support("base", z), Support("corner", x), Support("corner", y), Support("other", y)]

    def drives(self, *, half: bool = False) -> Mapping[str, Drive]:
        x, _, z = (tuple(axis) for axis in np.array(self.rotation).T)
        return {"top": Drive("top", z, x if self.clamped else None)}


@pytest.fixture(autouse=True)
def hand_made() -> Iterator[None]:
    """Scenes know the specimen for the time of a test."""
    register_specimen("hand-made")(HandMade)
    yield
    del SPECIMENS["hand-made"]


def scene_of(kind: str, **changes: Any) -> Scene:
    """The plane block of 40 x 40 x 10 mm, whose options the one in 3D takes."""
    return block(material__m_g=0.3, model__kind=kind, interface__width=WIDTH, band__width=2.0, **changes)


def solid_of(name: str, Q: Array, clamped: bool = False, **changes: Any) -> Scene:
    """The same scene on one of SOLIDS, rotated by Q; its mesh gives the band's width."""
    data = {table: value for table, value in scene_of(SCENES[name], **changes).data.items() if table not in ("mesh", "band")}
    return Scene(data | {"specimen": {"kind": "hand-made", "solid": name, "rotation": Q.tolist(), "clamped": clamped}})


PANEL = {"mesh.crack_size": 100.0, "mesh.far_size": 100.0, "stage.0.steps": 20, "stage.1.steps": 10}
OPENINGS = [0.0005, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1]


@pytest.mark.parametrize("quadrature", ["nodal", "gauss"])
@pytest.mark.parametrize("name", SOLIDS)
def test_tension_follows_the_softening_curve(name: str, quadrature: str, tmp_path: Path) -> None:
    """Free of lateral stress, so that the state stays uniform: the law's traction, and the bulk's elastic stretch."""
    width = 2.0 if name == "band" else WIDTH
    stage = [{"control": "opening", "to": OPENINGS, "steps": 1}]
    result = run(solid_of(name, rotation(1), interface__quadrature=quadrature, stage=stage))
    h = {name: values[1:] for name, values in result.history.items()}
    law = CrackPlane(result.scene.material, width)
    np.testing.assert_allclose(h["opening"], OPENINGS, rtol=1e-9)
    t, bulk = law.traction(np.stack([OPENINGS, 0 * h["load"]], axis=1), np.zeros(len(OPENINGS)))[0][:, 0], SIZE[2]
    bulk -= width if name == "band" else 0.0
    np.testing.assert_allclose(h["load"], t * AREA, rtol=1e-8)
    np.testing.assert_allclose(h["driven"], OPENINGS + t * bulk / result.scene.material.E, rtol=1e-8)
    np.testing.assert_allclose(h["stress_n"], t, rtol=1e-8)
    np.testing.assert_allclose(h["stress_s"], 0.0, atol=1e-8 * t.max())
    frame = result.frame(len(t))
    for stress in frame.stress:
        np.testing.assert_allclose(major_stress(stress), t[-1], rtol=1e-7)
    for key, value in {"traction_n": t[-1], "traction_s": 0.0, "sliding": 0.0, "planes": 1.0}.items():
        np.testing.assert_allclose(frame.cracks[key], value, atol=1e-7 * t[-1], err_msg=key)
    written = result.frame_mesh(frame)
    assert written.points.shape == written.point_data["displacement"].shape == (len(frame.displacement), 3)
    meshio.write(tmp_path / "frame.vtu", written)
    assert {"stress", "stress_max", "is_crack"} < set(written.cell_data)


@pytest.mark.parametrize("kind", ["discrete", "smeared"])
def test_the_plane_answer(kind: str) -> None:
    """Without a Poisson's ratio the block in 3D is the plane scene, closing and reopening included."""
    stage = [{"control": "opening", "to": [0.01, 0.05, 0.01, 0.03], "steps": 4}]
    plane = run(scene_of(kind, material__nu=0.0, stage=stage)).history
    name = "hexahedron" if kind == "discrete" else "band"
    space = run(solid_of(name, np.eye(3), material__nu=0.0, stage=stage)).history
    for name in ("load", "opening", "driven", "stress_n", "elastic", "stored", "dissipated", "contact_work", "work"):
        size = abs(plane["work" if name in ("stored", "contact_work") else name]).max()
        np.testing.assert_allclose(space[name], plane[name], atol=1e-8 * size, err_msg=name)


def pulled_and_sheared(name: str, Q: Array, condensation: str = "always") -> Scene:
    """Two drives at 60 degrees between pull and shear, clamped faces: nothing is uniform."""
    stage = [{"control": "driven", "to": [0.004, 0.012, 0.03], "steps": 2, "angle": 60.0}]
    return solid_of(name, Q, clamped=True, solver__condensation=condensation, stage=stage)


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
    assert condensed.facts.condensation == "condensed"
    assert full.active_dofs == full.total_dofs == condensed.total_dofs > condensed.active_dofs
    assert_same_history(condensed, full, 1e-8)
    for row in (3, len(full.history["load"]) - 1):
        a, b = condensed.frame(row), full.frame(row)
        np.testing.assert_allclose(a.displacement, b.displacement, atol=1e-8 * abs(b.displacement).max())
        for one, other in zip(a.stress, b.stress, strict=True):
            np.testing.assert_allclose(one, other, atol=1e-7 * full.scene.material.ft)


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.long] * ("beam" in name)) for name in PLANE])
def test_condensed_is_full(name: str) -> None:
    changes, part = PLANE[name]
    kind = {"beam": "notched-beam", "plate": "jacobsen-mixed-mode", "panel": "sandwich-panel"}[name.split()[0].rstrip(",")]
    exact = Scene.load(kind).with_(**changes, **{"solver.tol": 1e-11, "output.frames": 0})
    condensed, full = (run(exact.with_(**{"solver.condensation": each})) for each in ("always", "never"))
    assert_condensed_is_full(condensed, full)
    assert condensed.active_dofs < part * condensed.total_dofs


@pytest.mark.parametrize("name", SOLIDS)
def test_condensed_is_full_and_rotated_is_straight_in_3d(name: str) -> None:
    condensed, full = (run(pulled_and_sheared(name, np.eye(3), each)) for each in ("always", "never"))
    turned = run(pulled_and_sheared(name, rotation(4)))
    assert condensed.facts.condensation == "condensed" and full.active_dofs == full.total_dofs > condensed.active_dofs
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
def test_mean_tractions_carry_the_drives(name: str) -> None:
    """With the crack's normal along y the first tangent is x, as in the plane: the direction of the push."""
    Q = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
    result, states, built = run_and_keep(pulled_and_sheared(name, Q))
    problem = built.problem
    pull, push = problem.internal_force(states[-1])[problem.drives] / AREA
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
