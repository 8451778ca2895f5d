"""From a scene to a result: the only place that wires meshing, law, elements and solver together."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import meshio
import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from meshing import MeshError, read_mesh

from .assembly import CrackPoints, Unknowns, bulk_stiffness
from .concrete import Concrete
from .condensation import Condensed, nested_dissection
from .continuum import ElasticBlock, ElementError, elasticity
from .crackplane import CrackPlane
from .fixtures import gauge, ties
from .interface import Interface
from .linear import DenseStiffness, NotConverged, SparseStiffness, Stiffness
from .loading import March, Step
from .options import UserMesh
from .reference import load_reference
from .result import HistoryWriter, Result
from .scene import Scene, SceneError
from .solver import Problem, State

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: the default width of the interface: this part of the crack length, and at most this part of E Gf / ft^2
WIDTH_OF_CRACK, WIDTH_OF_MATERIAL = 0.01, 0.004

#: above this number of active unknowns a dense matrix is not worth its memory (0.8 GB)
_LARGEST_DENSE = 10_000


@dataclass(frozen=True)
class Model:
    """A meshed and assembled scene, ready for the march.

    Attributes
    ----------
    mesh : meshio.Mesh with crack cells
    blocks : the elastic elements
    interface : integration points of the crack
    problem : Problem on the active unknowns (all of them, where nothing is condensed)
    recover : displacements of the mesh nodes, (m, 2), from the unknowns of `problem`
    total_dofs, active_dofs : numbers of unknowns
    reduction : "condensed" or "none"
    timings : seconds, "mesh", "assemble" and "condense"
    """

    mesh: meshio.Mesh
    blocks: list[ElasticBlock]
    interface: Interface
    problem: Problem
    recover: Callable[[Array], Array]
    total_dofs: int
    active_dofs: int
    reduction: str
    timings: dict[str, float]

    def record(self, state: State) -> dict[str, float]:
        """The quantities of the history that belong to a state."""
        problem = self.problem
        mean = problem.points.weights @ state.traction / problem.points.weights.sum()
        return {
            "load": state.load,
            "opening": problem.measure("opening", state),
            "sliding": problem.measure("sliding", state),
            "driven": problem.measure("driven", state),
            "stress_n": float(mean[0]),
            "stress_s": float(mean[1]),
            "work": state.work,
            "elastic": state.elastic,
            "stored": state.stored,
            "dissipated": state.dissipated,
            "contact_work": state.contact_work,
        }


def default_width(crack_length: float, concrete: Concrete) -> float:
    """Width of the crack plane in mm where the scene names none: the smaller of 1 % of the crack length and
    0.4 % of E Gf / ft^2. On the built-in beam it costs less than 1 % of the load at small opening and of the
    peak against a vanishing width."""
    return min(WIDTH_OF_CRACK * crack_length, WIDTH_OF_MATERIAL * concrete.characteristic_length)


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
        named = re.match(r"\w+ = ", str(error))
        raise MeshError(f"specimen{'.' if named else ': '}{error}") from None
    timings["mesh"] = time.perf_counter() - clock

    clock = time.perf_counter()
    thickness = scene.specimen.thickness
    points = np.asarray(mesh.points, dtype=float)
    D = elasticity(scene.material.E, scene.material.nu, scene.model.plane)
    *bulk, crack = mesh.cells
    blocks = [ElasticBlock(block.type, points, block.data, D, thickness) for block in bulk]
    interface = Interface.from_cells(crack.type, points, crack.data, thickness, scene.interface.quadrature)
    original: Index = mesh.point_data["original"]
    on_crack = np.isin(original, original[crack.data])
    leader = np.where(on_crack, original, np.arange(len(original)))
    supports, drive, mirror = ties(scene, mesh)
    try:
        unknowns = Unknowns.build(leader, supports, drive, mirror)
        K = bulk_stiffness(blocks, len(points), unknowns.transform)
        if scene.model.half:
            K *= 2.0  # load and energies are those of the whole
    except ElementError as error:
        raise MeshError(str(error)) from None
    except ValueError as error:
        raise SceneError(f"specimen.{error}") from None
    crack_length = interface.area / thickness
    width = scene.interface.width
    if width is None:
        width = default_width(crack_length, scene.material)
    _check_units(scene, crack_length, width)
    law = CrackPlane(scene.material, None if isinstance(width, str) else width)  # a string is "h"
    jump_operator = _clean(interface.jump_operator @ unknowns.transform)
    measures = {name: row @ unknowns.transform for name, row in gauge(scene, mesh, interface).items()}
    timings["assemble"] = time.perf_counter() - clock

    clock = time.perf_counter()
    seen = np.zeros(K.shape[0], dtype=bool)
    seen[jump_operator.indices] = True
    seen[unknowns.drive] = True
    for row in measures.values():
        seen |= abs(row) > 1e-12
    active = np.flatnonzero(seen)
    reduction = scene.solver.reduction
    if reduction == "auto":
        reduction = "condensed" if _dense_is_cheaper(len(active), K.shape[0]) else "none"
    stiffness: Stiffness
    if reduction == "condensed":
        try:
            order = nested_dissection(points, [leader[block.data] for block in bulk], np.flatnonzero(on_crack))
            condensed = Condensed.eliminate(K, active, unknowns.node, order)
        except ValueError as error:
            raise SceneError(f"specimen: {error}") from None
        stiffness = DenseStiffness(condensed.stiffness)
        number = np.full(K.shape[0], -1)
        number[active] = np.arange(len(active))
        jump_operator = jump_operator[:, active].tocsr()
        measures = {name: row[active] for name, row in measures.items()}
        drive_number = int(number[unknowns.drive])

        def recover(v: Array) -> Array:
            return np.asarray(unknowns.transform @ condensed.recover(v)).reshape(-1, 2)
    else:
        stiffness, drive_number = SparseStiffness(K), unknowns.drive

        def recover(v: Array) -> Array:
            return np.asarray(unknowns.transform @ v).reshape(-1, 2)

    timings["condense"] = time.perf_counter() - clock
    problem = Problem(
        law,
        CrackPoints.build(jump_operator, interface.weights, interface.points),
        stiffness,
        drive_number,
        measures,
        scene.solver.tol,
    )
    if not problem.is_held():
        raise SceneError("specimen: the body is not held, its stiffness is singular; expected supports against every motion")
    return Model(mesh, blocks, interface, problem, recover, K.shape[0], len(measures["opening"]), reduction, timings)


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
    NotConverged, KeyboardInterrupt
        With everything computed so far in the exception's `result`.
    """
    if not isinstance(scene, Scene):
        raise TypeError(f"run(scene) got {scene!r}: expected a Scene, as from Scene.load(name)")
    if model is not None:
        scene = scene.with_(**{"model.kind": model})
    reference = load_reference(scene)
    built = build(scene)
    _check_stages(scene, built.problem)
    march = March(built.problem, scene.stages, built.record)
    rows: list[dict[str, float]] = []
    states: list[State] = []
    clock = time.perf_counter()

    def result() -> Result:
        built.timings["newton"] = time.perf_counter() - clock
        return Result(scene, built, rows, states, march.notes, reference)

    with HistoryWriter(output) as writer:
        try:
            for step in march:
                row = {
                    "step": len(rows) + 1,
                    **built.record(step.trial.state),
                    "iterations": step.trial.iterations,
                    "cuts": step.cuts,
                    "residual": step.trial.residuals[-1],
                    "wall_time": time.perf_counter() - clock,
                }
                rows.append(row)
                states.append(step.trial.state)
                writer.write(row)
                if on_step is not None:
                    on_step(step, row)
        except (NotConverged, KeyboardInterrupt) as error:
            march.notes.append(f"stopped: {str(error) or 'interrupted'}")
            error.result = result()  # type: ignore[union-attr]
            raise
    return result()


def _mesh(scene: Scene) -> meshio.Mesh:
    if isinstance(scene.specimen, UserMesh):
        return read_mesh(scene.file(scene.specimen.file), scene.specimen.crack)
    assert scene.sizes is not None
    return scene.specimen.mesh(scene.sizes, scene.model.half)


def _check_units(scene: Scene, crack_length: float, width: float | str) -> None:
    """Refuse numbers that belong to other units: their ratios are far from any concrete's."""
    m = scene.material
    if not 1e-6 < m.ft / m.E < 1e-2:
        raise SceneError(
            f"material.E = {m.E:g}, material.ft = {m.ft:g}: ft / E = {m.ft / m.E:.1e}; expected about 1e-4, both in MPa"
        )
    if m.Zm > crack_length:
        raise SceneError(
            f"material.Gf = {m.Gf:g}: softening would end at an opening of {m.Zm:.3g} mm, more than the crack's length of "
            f"{crack_length:.3g} mm; expected Gf in N/mm (MPa mm) and lengths in mm"
        )
    if not isinstance(width, str) and not 1e-6 * crack_length <= width <= max(m.h, crack_length):
        raise SceneError(
            f"interface.width = {width:g}: expected between {1e-6 * crack_length:.1e} and {max(m.h, crack_length):g} mm"
        )


def _check_stages(scene: Scene, problem: Problem) -> None:
    """Refuse targets that this body cannot reach."""
    m, law = scene.material, problem.law
    shear = max(1.0, m.r_sigma**2 * m.E / m.G)
    available = shear * (m.Gf + m.ft**2 * law.width / (2 * m.E)) * float(problem.points.weights.sum())
    for i, stage in enumerate(scene.stages):
        if stage.control == "dissipation" and max(stage.targets) > available:
            raise SceneError(
                f"stage.{i}.to = {max(stage.targets):g}: the crack can dissipate {available:.4g} N mm at most; expected less"
            )
    first = scene.stages[0]
    if first.targets[0] == 0:
        raise SceneError("stage.0.to = 0: the run starts there; expected another first target")
    if first.control in problem.measures:
        elastic = problem.response(problem.elastic_tangent())
        row = problem.measures[first.control]
        if abs(row @ elastic) <= 1e-9 * abs(row).sum() * abs(elastic).max():
            raise SceneError(
                f"stage.0.control = '{first.control}': the drive does not change it in this body; expected another control"
            )


def _clean(operator: sp.csr_array) -> sp.csr_array:
    """Without the entries that cancel: a jump does not see the mean motion of the faces."""
    operator = operator.tocsr()
    operator.data[abs(operator.data) < 1e-12] = 0.0
    operator.eliminate_zeros()
    return operator


def _dense_is_cheaper(active: int, total: int) -> bool:
    """Compare the cost of an iteration: dense LU, n^3 / 1.5 operations, against a sparse plane factorization,
    about 12 N^1.5 operations at a tenth of the speed."""
    return active < _LARGEST_DENSE and active**3 / 1.5 < 120.0 * total**1.5


def describe(scene: Scene, model: Model) -> Sequence[str]:
    """Three lines: what was modelled, how, and what was left out."""
    n_bulk = sum(len(block.cells) for block in model.blocks)
    kinds = " and ".join(sorted({block.kind for block in model.blocks}))
    whole = "one half of a symmetric body, " if scene.model.half else ""
    return (
        f"modelled: {whole}{n_bulk} linear elastic {kinds} elements in plane "
        f"{scene.model.plane}; {len(model.mesh.cells[-1].data)} zero-thickness crack cells, "
        f"{len(model.interface.weights)} points, width {model.problem.law.width:.3g} mm",
        f"solved: {model.active_dofs} of {model.total_dofs} unknowns"
        + (", the rest eliminated once" if model.reduction == "condensed" else ", nothing condensed"),
        "left out: cracks off the given path, crushing, time, temperature, large rotations",
    )
