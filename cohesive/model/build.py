"""From a scene to a model: mesh, elements, cracks, unknowns, condensation, problem. Here the scene ends."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import scipy.sparse as sp

from meshing.errors import MeshError
from meshing.specimens.base import MAIN_GAUGE

from ..algebra.bulk_matrix import bulk_stiffness
from ..algebra.choice import Bulk, Condensation, condense
from ..algebra.crack_operator import CrackOperator
from ..algebra.unknowns import Unknowns
from ..arrays import Array, Index
from ..elements.bulk import BAND_COLUMNS, ElasticBlock, elasticity
from ..errors import ElementError, SceneError
from ..scenes.scene import Scene
from ..solver.loading import DEAD, Actuator, Loading
from ..solver.problem import Problem, Springs
from .band import band_note, band_part
from .boundary import Boundary, boundary
from .checks import check_stages, loadings_of
from .cracks import CrackPart
from .dead_loads import dead_loads
from .gauges import measures
from .held import check_held
from .interface import interface_part
from .lengths import CrackLengths
from .mesh import CrackedMesh, cracked_mesh
from .model import Model
from .path_size import path_size_note

#: stress, MPa, whose strain over the size of the body is the motion that stands for the dead loads
_DEAD_STRESS = 0.03


def build(scene: Scene, tangent: str = "consistent", on_phase: Callable[[str], None] | None = None) -> Model:
    """Mesh and assemble a scene.

    Parameters
    ----------
    tangent : "consistent" (Newton's method, quadratic convergence) or "secant": the stiffness at constant damage in every
        iteration, which converges linearly.
    on_phase : called with "mesh", "assemble" and "condense" as each begins.

    Raises
    ------
    SceneError, MeshError
        Naming the key or the entity, its value and what was expected.
    """
    if scene.grow is not None:
        raise SceneError("specimen.crack = 'grow': the path is not found yet; run(scene) finds it", "specimen.crack")
    timings: dict[str, float] = {}
    with _timed(timings, "mesh", on_phase), _keys_named():
        mesh = cracked_mesh(scene)
    with _timed(timings, "assemble", on_phase), _keys_named():
        elastic, cracking = elements(scene, mesh)
        cracks = _cracks(scene, mesh, cracking)
        held = boundary(scene.specimen, mesh, scene.model.plane, scene.model.half)
        bulk, rows = _unknowns(scene, mesh, (elastic, cracking), cracks, held)
        _check_held(scene, mesh, held)
    with _timed(timings, "condense", on_phase):
        condensation = _condensed(bulk, scene.solver.condensation)
        problem = _problem(scene, mesh, cracks, bulk, condensation, held, rows)
    total = bulk.unknowns.transform.shape[1]
    lengths = CrackLengths.from_specimen(scene.specimen, cracks, problem.measures)
    forces, notes = scene.specimen.forces(), _notes(scene, mesh, cracks)
    model = Model(mesh, elastic, cracking, cracks, lengths, forces, problem, condensation, total, timings, notes)
    return _checked(scene, model, tangent)


def with_law(model: Model, own: Scene, scene: Scene, tangent: str = "consistent") -> Model:
    """The model of a scene from that of another one which differs in the law, the modulus and the stages only.

    Parameters
    ----------
    model : of the scene `own`, as built
    tangent : see `build`

    Raises
    ------
    SceneError
        Naming the key, its value and what was expected.
    """
    timings = dict.fromkeys(("mesh", "assemble", "condense"), 0.0)
    with _timed(timings, "assemble"), _keys_named():
        _check_held(scene, model.mesh, boundary(scene.specimen, model.mesh, scene.model.plane, scene.model.half))
        elastic, cracking = elements(scene, model.mesh)
        cracks = _cracks(scene, model.mesh, cracking)
        area = _area(scene, model.mesh, cracks)
        problem = replace(
            model.problem,
            point_law=cracks.point_law,
            stiffness=model.condensation.stiffness.scaled(_unit(scene)),
            strength=scene.material.ft * area,
            energy=scene.material.Gf * area,
            tol=scene.solver.tol,
            dead_factor=_dead_factor(model.mesh, scene.material.E) if model.problem.dead_factor else 0.0,
        )
    changed = replace(
        model,
        bulk=elastic,
        band=cracking,
        cracks=cracks,
        lengths=CrackLengths.from_specimen(scene.specimen, cracks, problem.measures),
        problem=problem,
        timings=timings,
        notes=_notes(scene, model.mesh, cracks),
    )
    return _checked(scene, changed, tangent)


def _check_held(scene: Scene, mesh: CrackedMesh, held: Boundary) -> None:
    """Refuse a body that is not held in one of the stages."""
    check_held(mesh, held, loadings_of(scene.stages, Loading.from_drives(held.drives, len(held.motions))))


def _checked(scene: Scene, model: Model, tangent: str) -> Model:
    """The model with its tangent, once it is known that the stages are possible."""
    unmeasured = {*scene.specimen.gauges()} - {MAIN_GAUGE, *model.problem.measures}
    check_stages(scene.stages, model.problem, scene.material, model.cracks.width, unmeasured)
    return replace(model, problem=replace(model.problem, secant=True)) if tangent == "secant" else model


@contextmanager
def _timed(timings: dict[str, float], name: str, on_phase: Callable[[str], None] | None = None) -> Iterator[None]:
    if on_phase is not None:
        on_phase(name)
    clock = time.perf_counter()
    yield
    timings[name] = time.perf_counter() - clock


@contextmanager
def _keys_named() -> Iterator[None]:
    """Errors of the rooms below name the specimen's key by itself; here it gets its table."""
    try:
        yield
    except MeshError as error:
        if "." in error.key and not error.key.startswith("specimen"):
            raise
        named = "." if error.key else ": "
        raise MeshError(f"specimen{named}{error}", f"specimen.{error.key}" if error.key else "specimen") from None
    except ElementError as error:
        raise MeshError(str(error)) from None


def _thickness(scene: Scene, mesh: CrackedMesh) -> float:
    """What a 2D mesh is to be multiplied with, mm; 1 in 3D."""
    if mesh.dimension == 3:
        return 1.0
    assert scene.specimen.thickness is not None
    return scene.specimen.thickness


def elements(scene: Scene, mesh: CrackedMesh) -> tuple[list[ElasticBlock], list[ElasticBlock]]:
    """The elastic elements, and those that may crack."""
    if mesh.dimension == 3 and scene.model.plane == "strain" and 2 not in scene.specimen.dimensions:
        raise SceneError(
            "model.plane = 'strain': the mesh is solid; expected no such key, and supports that hold its faces", "model.plane"
        )
    D = _elasticity(scene, mesh, scene.material.E)
    t, points = _thickness(scene, mesh), np.asarray(mesh.points, dtype=float)
    elastic = [
        ElasticBlock(block.type, points, block.data, _of_regions(scene, mesh, D, region), t)
        for block, region in zip(mesh.bulk, mesh.regions, strict=True)
    ]
    cracking = []
    for block in mesh.band:
        kind, columns = BAND_COLUMNS[block.type] if mesh.is_row else (block.type, list(range(block.data.shape[1])))
        cracking.append(ElasticBlock(kind, points, block.data[:, columns], D, t))
    return elastic, cracking


def _elasticity(scene: Scene, mesh: CrackedMesh, E: float) -> Array:
    return elasticity(E, scene.material.nu, scene.model.plane if mesh.dimension == 2 else None)


def _of_regions(scene: Scene, mesh: CrackedMesh, D: Array, region: Index) -> Array:
    """The elasticity of each element, or one if they are alike."""
    if not region.any():
        return D
    plane = scene.model.plane if mesh.dimension == 2 else None
    found = [D, *(elasticity(each.E, each.nu, plane) for each in scene.specimen.regions().values())]
    return np.stack(found)[region]


def _dead_loads(scene: Scene, mesh: CrackedMesh, elements: tuple[list[ElasticBlock], list[ElasticBlock]]) -> Array | None:
    """Forces of own weight and pressures on the nodes, (d m,), N."""
    own = scene.material.density
    densities = np.array([own, *(own if r.density is None else r.density for r in scene.specimen.regions().values())])
    elastic, cracking = elements
    blocks = [(block, densities[region]) for block, region in zip(elastic, mesh.regions, strict=True)]
    blocks += [(block, np.full(len(block.cells), own)) for block in cracking]
    return dead_loads(scene.specimen, mesh, blocks, _thickness(scene, mesh))


def _cracks(scene: Scene, mesh: CrackedMesh, cracking: Sequence[ElasticBlock]) -> CrackPart:
    """The points with cracks of either model."""
    t, length_of = _thickness(scene, mesh), scene.specimen.crack_length_of
    if mesh.crack is not None:
        return interface_part(scene.material, scene.interface, mesh, t, length_of)
    known = (scene.crack_area, scene.band_width) if scene.sizes is not None else None
    return band_part(scene.material, scene.band, mesh, cracking, t, length_of, known)


def _unit(scene: Scene) -> float:
    """Modulus by which the stiffness of the bulk is divided before it is condensed, MPa, so that another modulus gives the
    same numbers whether it came before or after; 1 if regions have moduli of their own."""
    return 1.0 if scene.specimen.regions() else scene.material.E


def _dead_factor(mesh: CrackedMesh, E: float) -> float:
    """Motion at which the dead loads act whole, mm, with some modulus: of the size of the others, so that the force on it is
    of theirs."""
    return _DEAD_STRESS * float(np.ptp(mesh.points, axis=0).max()) / E


def _area(scene: Scene, mesh: CrackedMesh, cracks: CrackPart) -> float:
    """Area of the crack, mm^2; if nothing tells, its order."""
    extent = float(np.ptp(mesh.points, axis=0).max())
    return cracks.area or extent * (scene.specimen.thickness or extent)


def _unknowns(
    scene: Scene,
    mesh: CrackedMesh,
    elements: tuple[list[ElasticBlock], list[ElasticBlock]],
    cracks: CrackPart,
    held: Boundary,
) -> tuple[Bulk, dict[str, Array]]:
    """The bulk to be condensed, and the measures on all unknowns."""
    leader = mesh.leader
    dead = _dead_loads(scene, mesh, elements)
    try:
        factors = int(dead is not None)
        unknowns = Unknowns.from_constraints(leader, held.supports, held.motions, held.mirror, factors)
    except ValueError as error:
        raise SceneError(f"specimen.{error}", "specimen") from None
    blocks, unit = elements[0], _unit(scene)
    if not scene.specimen.regions():
        blocks = [replace(block, D=_elasticity(scene, mesh, 1.0)) for block in blocks]
    K = bulk_stiffness(blocks, mesh.points.size)
    if scene.model.half:
        K *= 2.0  # load and energies are those of the whole
        dead = None if dead is None else 2.0 * dead
    if dead is not None:
        dead /= _dead_factor(mesh, scene.material.E / unit)
    operator = _without_cancelled(cracks.operator @ unknowns.transform)
    rows = measures(scene.specimen, scene.model.half, mesh, cracks.faces)
    rows = {name: row @ unknowns.transform for name, row in rows.items()}
    seen = np.zeros(unknowns.transform.shape[1], dtype=bool)
    seen[operator.indices] = True
    seen[unknowns.drives] = seen[unknowns.rotations] = True  # each sees a whole face
    for row in rows.values():
        seen |= abs(row) > 1e-12
    points = np.asarray(mesh.points, dtype=float)
    return Bulk(points, elements[0], elements[1], leader, unknowns, operator, np.flatnonzero(seen), K, dead), rows


def _without_cancelled(operator: sp.csr_array) -> sp.csr_array:
    """Without the entries that cancel: a jump does not see the mean motion of the faces."""
    operator = operator.tocsr()
    operator.data[abs(operator.data) < 1e-12] = 0.0
    operator.eliminate_zeros()
    return operator


def _condensed(bulk: Bulk, wanted: str) -> Condensation:
    """The bulk as the solver sees it."""
    if wanted == "petsc":
        from ..algebra.petsc.stiffness import uncondensed  # with petsc4py, which need not be installed

        return uncondensed(bulk)
    try:
        return condense(bulk, wanted)
    except SceneError:  # which names its own key
        raise
    except ValueError as error:
        raise SceneError(f"specimen: {error}", "specimen") from None


def _problem(
    scene: Scene,
    mesh: CrackedMesh,
    cracks: CrackPart,
    bulk: Bulk,
    condensation: Condensation,
    held: Boundary,
    rows: dict[str, Array],
) -> Problem:
    """The equations on the unknowns that are left."""
    at = condensation.unknowns
    number = np.full(bulk.unknowns.transform.shape[1], -1)
    number[at] = np.arange(len(at))
    drives = number[bulk.unknowns.drives]
    loads, springs = dict(held.drives), (held.acting, held.later)
    if bulk.dead is not None:
        loads[DEAD] = Actuator((len(drives) - 1,))
        springs = (np.append(held.acting, 0.0), np.append(held.later, 0.0))
    area = _area(scene, mesh, cracks)
    return Problem(
        cracks.point_law,
        CrackOperator.from_matrix(bulk.operator[:, at].tocsr(), cracks.weights, cracks.where),
        condensation.stiffness.scaled(_unit(scene)),
        drives,
        Loading.from_drives(loads, len(drives)),
        Springs.from_stiffness(*springs),
        scene.material.ft * area,
        scene.material.Gf * area,
        {name: row[at] for name, row in rows.items()},
        scene.solver.tol,
        dead_factor=0.0 if bulk.dead is None else _dead_factor(mesh, scene.material.E),
    )


def _notes(scene: Scene, mesh: CrackedMesh, cracks: CrackPart) -> list[str]:
    """What the reader of the results should know about the model."""
    found = mesh.remarks
    if mesh.crack is None and (warning := band_note(scene.material, cracks.width)):
        found.append(warning)
    if (
        scene.sizes is None
        and cracks.area
        and (coarse := path_size_note(mesh, scene.material, scene.specimen.crack_length_of(cracks.area)))
    ):
        found.append(coarse)
    if scene.specimen.is_off_the_notch():
        found.append("warning: the crack path neither begins nor ends at a notch, which stays closed to it")
    if scene.sizes is None and (length := mesh.crack_front):
        found.append(f"the crack surface ends inside the body along {length:.4g} mm of its edge; there is the front")
    return found
