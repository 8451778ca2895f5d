"""From a scene to a result: the only place that wires meshing, law, elements and solver together."""

from __future__ import annotations

import re
import time
from dataclasses import dataclass

import meshio
import numpy as np
import scipy.sparse as sp

from meshing import MeshError, read_band_mesh, read_mesh

from ..algebra.bulk_matrix import bulk_stiffness
from ..algebra.choice import Bulk, Condensation, condense
from ..algebra.crack_operator import CrackOperator
from ..algebra.unknowns import Unknowns
from ..arrays import Array, Index
from ..elements.bulk import BAND_COLUMNS, ElasticBlock, elasticity
from ..errors import ElementError, SceneError
from ..scenes.scene import Scene
from ..scenes.tables import UserMesh
from ..solver.problem import Problem, State
from .boundary import gauge, ties
from .cracks import CrackPart, band_part, depth, interface_part, is_row


def build(scene: Scene) -> Model:
    """Mesh and assemble a scene.

    Raises
    ------
    SceneError, MeshError
        Naming the key or the entity, its value and what was expected.
    """
    timings: dict[str, float] = {}
    clock = time.perf_counter()
    try:
        mesh = _mesh(scene)
    except MeshError as error:  # name the key, where the message begins with one
        if str(error).startswith(("band.", "mesh.")):
            raise
        named = re.match(r"\w+ = |band is missing", str(error))
        raise MeshError(f"specimen{'.' if named else ': '}{error}") from None
    timings["mesh"] = time.perf_counter() - clock

    clock = time.perf_counter()
    points = np.asarray(mesh.points, dtype=float)
    extent = float(np.ptp(points, axis=0).max())
    D = elasticity(scene.material.E, scene.material.nu, scene.model.plane if points.shape[1] == 2 else None)
    smeared = scene.model.kind == "smeared"
    elastic, cracking = _blocks(scene, mesh, points, D)
    original: Index = mesh.point_data["original"]
    leader = np.arange(len(original))
    if not smeared:
        on_crack = np.isin(original, original[mesh.cells[-1].data])
        leader = np.where(on_crack, original, leader)
    try:
        cracks = band_part(scene, mesh, cracking) if smeared else interface_part(scene, mesh)
        supports, drives, mirror = ties(scene, mesh)
        unknowns = Unknowns.from_constraints(leader, supports, drives, mirror)
        K = bulk_stiffness(elastic, points.size)
        if scene.model.half:
            K *= 2.0  # load and energies are those of the whole
    except ElementError as error:
        raise MeshError(str(error)) from None
    except SceneError:
        raise
    except ValueError as error:
        raise SceneError(f"specimen.{error}") from None
    operator = _clean(cracks.operator @ unknowns.transform)
    measures = {name: row @ unknowns.transform for name, row in gauge(scene, mesh, cracks.faces).items()}
    timings["assemble"] = time.perf_counter() - clock

    clock = time.perf_counter()
    seen = np.zeros(unknowns.transform.shape[1], dtype=bool)
    seen[operator.indices] = True
    seen[unknowns.drives] = seen[unknowns.rotations] = True  # each sees a whole face
    for row in measures.values():
        seen |= abs(row) > 1e-12
    active = np.flatnonzero(seen)
    bulk = Bulk(points, elastic, cracking, leader, unknowns, operator, active, K)
    try:
        if scene.solver.reduction == "petsc":
            from ..algebra.petsc.stiffness import uncondensed  # with petsc4py, which need not be installed

            condensation = uncondensed(bulk)
        else:
            condensation = condense(bulk, {"condensed": "always", "none": "never"}.get(scene.solver.reduction, "auto"))
    except SceneError:
        raise
    except ValueError as error:
        raise SceneError(f"specimen: {error}") from None
    number = np.full(len(seen), -1)
    number[condensation.unknowns] = np.arange(len(condensation.unknowns))
    operator = operator[:, condensation.unknowns].tocsr()
    measures = {name: row[condensation.unknowns] for name, row in measures.items()}
    drives_at = number[unknowns.drives]
    timings["condense"] = time.perf_counter() - clock
    area = cracks.area or extent * (scene.specimen.thickness or extent)  # without one, its order
    problem = Problem(
        cracks.point_law,
        CrackOperator.from_matrix(operator, cracks.weights, cracks.where),
        condensation.stiffness,
        drives_at,
        np.eye(len(drives_at))[0],
        scene.material.ft * area,
        scene.material.Gf * area,
        measures,
        scene.solver.tol,
        spring=getattr(scene.specimen, "restraint", 0.0),
        secant=scene.solver.tangent == "secant",
    )
    if not problem.is_held():
        raise SceneError("specimen: the body is not held, its stiffness is singular; expected supports against every motion")
    return Model(mesh, elastic, cracking, cracks, problem, condensation, len(seen), timings)


def _mesh(scene: Scene) -> meshio.Mesh:
    specimen, smeared = scene.specimen, scene.model.kind == "smeared"
    everywhere = scene.band.where == "everywhere"
    if isinstance(specimen, UserMesh):
        return _user_mesh(scene, specimen)
    assert scene.sizes is not None
    if smeared and everywhere:
        return specimen.mesh_body(scene.sizes)
    if smeared:
        return specimen.mesh_band(scene.sizes, scene.band_width)
    return specimen.mesh(scene.sizes, scene.model.half)


def _user_mesh(scene: Scene, specimen: UserMesh) -> meshio.Mesh:
    file, everywhere = scene.file(specimen.file), scene.band.where == "everywhere"
    if scene.model.kind == "discrete":
        mesh = read_mesh(file, specimen.crack)
    elif specimen.band is None and not everywhere:
        raise MeshError(
            "band is missing: expected the name of the set of elements that form the band, or band.where = 'everywhere'"
        )
    else:
        along = None if isinstance(specimen.crack, str) else np.subtract(specimen.crack[0][-1], specimen.crack[0][0])
        mesh = read_band_mesh(file, None if everywhere else specimen.band, along)
    is_solid = mesh.points.shape[1] == 3
    if not is_solid and specimen.thickness is None:
        raise SceneError("specimen.thickness is missing: the mesh is plane")
    if is_solid and specimen.thickness is not None:
        raise SceneError(f"specimen.thickness = {specimen.thickness:g}: the mesh is solid; expected no thickness")
    if is_solid and scene.model.plane == "strain":
        raise SceneError("model.plane = 'strain': the mesh is solid; expected no such key, and supports that hold its faces")
    return mesh


def _blocks(scene: Scene, mesh: meshio.Mesh, points: Array, D: Array) -> tuple[list[ElasticBlock], list[ElasticBlock]]:
    """The elastic elements, and those that may crack."""
    t = depth(scene, mesh)
    if scene.model.kind == "discrete":
        return [ElasticBlock(block.type, points, block.data, D, t) for block in mesh.cells[:-1]], []
    sides: tuple[list[ElasticBlock], list[ElasticBlock]] = ([], [])
    for i, block in enumerate(mesh.cells):
        in_band = scene.band.where == "everywhere" or bool(len(mesh.cell_sets["band"][i]))
        kind, columns = block.type, list(range(block.data.shape[1]))
        if in_band and is_row(mesh):
            kind, columns = BAND_COLUMNS[kind]
        sides[in_band].append(ElasticBlock(kind, points, block.data[:, columns], D, t))
    return sides


def _clean(operator: sp.csr_array) -> sp.csr_array:
    """Without the entries that cancel: a jump does not see the mean motion of the faces."""
    operator = operator.tocsr()
    operator.data[abs(operator.data) < 1e-12] = 0.0
    operator.eliminate_zeros()
    return operator


@dataclass(frozen=True)
class Model:
    """A meshed and assembled scene, ready for the march.

    Attributes
    ----------
    mesh : meshio.Mesh; crack cells, or the elements of the band, come last
    blocks : the elastic elements
    band : the elements that may crack, in the smeared model
    cracks : CrackPart
    problem : Problem on the condensation unknowns
    condensation : Condensation
    total_dofs : number of all unknowns
    timings : seconds, "mesh", "assemble" and "condense"
    """

    mesh: meshio.Mesh
    blocks: list[ElasticBlock]
    band: list[ElasticBlock]
    cracks: CrackPart
    problem: Problem
    condensation: Condensation
    total_dofs: int
    timings: dict[str, float]

    @property
    def is_smeared(self) -> bool:
        return bool(self.band)

    @property
    def library(self) -> str:
        """What solves the linear systems."""
        return getattr(self.problem.stiffness, "library", "SciPy")

    @property
    def active_dofs(self) -> int:
        """Number of unknowns that Newton's method works on."""
        return len(self.condensation.unknowns)

    def record(self, state: State) -> dict[str, float]:
        """The quantities of the history that belong to a state."""
        problem, mean = self.problem, self.cracks.mean_traction(state)
        return {
            "load": state.load,
            "opening": problem.measure("opening", state),
            "sliding": problem.measure("sliding", state),
            "driven": state.driven,
            "stress_n": float(mean[0]),
            "stress_s": float(mean[1]),
            "work": state.work,
            "elastic": state.elastic,
            "stored": state.stored,
            "dissipated": state.dissipated,
            "contact_work": state.contact_work,
        }
