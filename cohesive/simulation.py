"""From a scene to a result: the only place that wires meshing, law, elements and solver together."""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from pathlib import Path

import meshio
import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from meshing import MeshError, Specimen, front_length, read_band_mesh, read_mesh

from .assembly import Points, Unknowns, bulk_stiffness
from .continuum import BAND_COLUMNS, ElasticBlock, ElementError, elasticity
from .fixtures import gauge, ties
from .linear import NotConverged
from .loading import March, Step
from .model import Model, band_note, band_part, depth, interface_part, is_row
from .options import UserMesh
from .problem import Problem, State
from .reduction import Body, reduce
from .reference import load_reference
from .result import HistoryWriter, Result
from .scene import Scene, SceneError

Array = NDArray[np.float64]
Index = NDArray[np.int64]


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
        unknowns = Unknowns.build(leader, supports, drives, mirror)
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
    seen[unknowns.drives] = seen[unknowns.turns] = True  # each sees a whole face
    for row in measures.values():
        seen |= abs(row) > 1e-12
    active = np.flatnonzero(seen)
    body = Body(points, elastic, cracking, leader, unknowns, operator, active, K)
    try:
        if scene.solver.reduction == "petsc":
            from .petsc import unreduced  # with petsc4py, which need not be installed

            reduced = unreduced(body)
        else:
            reduced = reduce(body, scene.solver.reduction)
    except SceneError:
        raise
    except ValueError as error:
        raise SceneError(f"specimen: {error}") from None
    number = np.full(len(seen), -1)
    number[reduced.unknowns] = np.arange(len(reduced.unknowns))
    operator = operator[:, reduced.unknowns].tocsr()
    measures = {name: row[reduced.unknowns] for name, row in measures.items()}
    drives_at = number[unknowns.drives]
    timings["condense"] = time.perf_counter() - clock
    problem = Problem(
        cracks.law,
        Points.build(operator, cracks.weights, cracks.where),
        reduced.stiffness,
        drives_at,
        np.eye(len(drives_at))[0],
        cracks.area or extent * (scene.specimen.thickness or extent),  # without one, its order
        measures,
        scene.solver.tol,
        spring=getattr(scene.specimen, "restraint", 0.0),
        secant=scene.solver.tangent == "secant",
    )
    if not problem.is_held():
        raise SceneError("specimen: the body is not held, its stiffness is singular; expected supports against every motion")
    return Model(mesh, elastic, cracking, cracks, problem, reduced, len(seen), timings)


def run(
    scene: Scene,
    model: str | None = None,
    output: str | Path | None = None,
    on_step: Callable[[Step, dict[str, float]], None] | None = None,
) -> Result:
    """Run a scene.

    Parameters
    ----------
    scene : Scene
    model : overrides the scene's model.kind.
    output : folder whose history.csv grows row by row during the run; `Result.save` writes the rest.
    on_step : called after every converged step with it and its row of the history.

    Returns
    -------
    Result

    Raises
    ------
    SceneError, MeshError
        For bad input.
    NotConverged, KeyboardInterrupt, and SceneError where history.csv cannot grow
        With everything computed so far in the exception's `result`.
    """
    if not isinstance(scene, Scene):
        raise TypeError(f"run(scene) got {scene!r}: expected a Scene, as from Scene.load(name)")
    if model is not None:
        scene = scene.with_(**{"model.kind": model})
    reference = load_reference(scene)
    built = build(scene)
    _check_stages(scene, built.problem, built.cracks.width)
    march = March(built.problem, scene.stages, built.record, scene.solver.largest_step)
    if built.is_smeared and (warning := band_note(scene, built.cracks.width)):
        march.notes.append(warning)
    if isinstance(scene.specimen, Specimen) and scene.specimen.is_off_the_notch():
        march.notes.append("warning: the crack path neither begins nor ends at a notch, which stays closed to it")
    if isinstance(scene.specimen, UserMesh) and not built.is_smeared and (length := front_length(built.mesh)):
        march.notes.append(f"the crack surface ends inside the body along {length:.4g} mm of its edge; there is the front")
    done: list[tuple[dict[str, float], State]] = []
    clock = time.perf_counter()

    def result() -> Result:
        built.timings["newton"] = time.perf_counter() - clock
        return Result(scene, built, [row for row, _ in done], [state for _, state in done], march.notes, reference)

    with HistoryWriter(output) as writer:
        try:
            for step in march:
                row = {
                    "step": len(done) + 1,
                    **built.record(step.trial.state),
                    "iterations": step.trial.iterations,
                    "cuts": step.cuts,
                    "residual": step.trial.residuals[-1],
                    "wall_time": time.perf_counter() - clock,
                    "stage": step.stage,
                }
                done.append((row, step.trial.state))  # both or, where an interruption comes between, none
                writer.write(row)
                if on_step is not None:
                    on_step(step, row)
        except (NotConverged, KeyboardInterrupt, SceneError) as error:
            march.notes.append(f"stopped: {str(error) or 'interrupted'}")
            error.result = result()  # type: ignore[union-attr]
            raise
    return result()


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


def _check_stages(scene: Scene, problem: Problem, width: float) -> None:
    """Refuse targets that this body cannot reach."""
    m = scene.material
    shear = max(1.0, m.r_sigma**2 * m.E / m.G)
    available = shear * (m.Gf + m.ft**2 * width / (2 * m.E)) * problem.area
    for i, stage in enumerate(scene.stages):
        for key in ("angle", "ratio", "hold"):
            if (value := getattr(stage, key)) is not None and len(problem.drives) == 1:
                raise SceneError(f"stage.{i}.{key} = {value!r}: this specimen is driven in one direction; expected no {key}")
        if stage.control == "dissipation" and max(stage.targets) > available:
            raise SceneError(
                f"stage.{i}.to = {max(stage.targets):g}: the crack can dissipate {available:.4g} N mm at most; expected less"
            )
    first = scene.stages[0]
    if first.targets[0] == 0:
        raise SceneError("stage.0.to = 0: the run starts there; expected another first target")
    if len(problem.drives) == 2:
        problem = problem.driven(first.direction or 0.0, first.hold is not False)
    if first.control in problem.measures:
        elastic = problem.response(problem.law.elastic())
        row = problem.measures[first.control]
        if abs(row @ elastic) <= 1e-9 * abs(row).sum() * abs(elastic).max():
            raise SceneError(
                f"stage.0.control = '{first.control}': the drive does not change it while the body is elastic; expected a "
                "gauge for the specimen (without one the mean jump over the crack is measured), or another control"
            )


def _clean(operator: sp.csr_array) -> sp.csr_array:
    """Without the entries that cancel: a jump does not see the mean motion of the faces."""
    operator = operator.tocsr()
    operator.data[abs(operator.data) < 1e-12] = 0.0
    operator.eliminate_zeros()
    return operator
