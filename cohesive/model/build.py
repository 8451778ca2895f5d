"""From a scene to a model: mesh and supports, elements, cracks, equations. Here the scene ends."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import Any

from meshing.errors import MeshError
from meshing.specimens.base import MAIN_GAUGE

from ..errors import ElementError, SceneError
from ..law.widths import band_note
from ..scenes.scene import Scene
from ..solver.loading import Loading
from ..solver.stage_checks import check_stages, loadings_of
from .band import band_part
from .boundary import boundary
from .cracks import CrackPart
from .dead_loads import dead_loads, dead_motion
from .elements import Elements
from .equations import assembled, condensed, problem_of
from .interface import interface_part
from .lengths import CrackLengths
from .mesh import CrackedMesh, cracked_mesh
from .model import Model
from .path_size import path_size_note
from .setup import Setup
from .supports import check_supports


def build(
    scene: Scene,
    tangent: str = "consistent",
    on_phase: Callable[[str], None] | None = None,
    kept: Model | None = None,
) -> Model:
    """Mesh and assemble a scene.

    Parameters
    ----------
    tangent : "consistent" (Newton's method, quadratic convergence) or "secant": the stiffness at constant damage in every
        iteration, which converges linearly.
    on_phase : called with "mesh", "assemble" and "condense" as each begins.
    kept : model of a scene that differs in the law, the modulus and the stages only: its mesh and its condensed stiffness
        serve again.

    Raises
    ------
    SceneError, MeshError
        Naming the key or the entity, its value and what was expected.
    """
    if scene.grow is not None:
        raise SceneError.at("specimen.crack", " = 'grow': the path is not found yet; run(scene) finds it")
    timings: dict[str, float] = {}
    concrete, specimen, options = scene.material, scene.specimen, scene.model
    with _timed(timings, "mesh", on_phase), _keys_named():
        mesh = cracked_mesh(scene) if kept is None else kept.mesh
    with _timed(timings, "assemble", on_phase), _keys_named():
        elements = Elements.from_mesh(scene, mesh)
        cracks = _cracks(scene, mesh, elements)
        setup = Setup.from_specimen(specimen, mesh, options.plane, options.half)
        constraints = boundary(setup, mesh, options.half)
        check_supports(
            mesh, constraints, loadings_of(scene.stages, Loading.from_drives(constraints.drives, len(constraints.motions)))
        )
        dead = None if kept is not None else dead_loads(specimen, mesh, elements, concrete.E / elements.unit)
        is_loaded = dead is not None if kept is None else kept.problem.dead_factor > 0
        area = cracks.area or mesh.extent * (specimen.thickness or mesh.extent)  # if nothing tells, its order
        plane = cracks.point_law.law
        law: dict[str, Any] = {
            "point_law": cracks.point_law,
            "strength": plane.strength * area,
            "energy": plane.energy * area,
            "tol": scene.solver.tol,
            "secant": tangent == "secant",
            "dead_factor": dead_motion(mesh, concrete.E) if is_loaded else 0.0,
        }
        notes = _notes(scene, mesh, cracks)
        whole = assembled(scene, mesh, elements, cracks, setup, constraints, dead) if kept is None else None
    with _timed(timings, "condense", on_phase):
        if kept is None:
            assert whole is not None
            condensation, total = condensed(whole.bulk, scene.solver.condensation), whole.total_dofs
            with_law = partial(problem_of, whole, condensation, constraints)
        else:
            condensation, total, with_law = kept.condensation, kept.total_dofs, partial(replace, kept.problem)
        problem = with_law(stiffness=condensation.stiffness.scaled(elements.unit), **law)
    unmeasured = {*specimen.gauges()} - {MAIN_GAUGE, *problem.measures}
    check_stages(scene.stages, problem, plane.most_dissipated * area, unmeasured)
    lengths = CrackLengths.from_specimen(specimen, cracks, problem.measures)
    return Model(
        mesh, elements.elastic, elements.cracking, cracks, lengths, specimen.forces(), problem, condensation, total,
        timings, notes,
    )  # fmt: skip


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


def _cracks(scene: Scene, mesh: CrackedMesh, elements: Elements) -> CrackPart:
    """The points with cracks of either model."""
    t, length_of = elements.thickness, scene.specimen.crack_length_of
    if mesh.crack is not None:
        return interface_part(scene.law, scene.material, scene.interface, mesh, t, length_of)
    known = (scene.crack_area, scene.band_width) if scene.sizes is not None else None
    return band_part(scene.law, scene.material, scene.band, mesh, elements.cracking, t, length_of, known)


def _notes(scene: Scene, mesh: CrackedMesh, cracks: CrackPart) -> list[str]:
    """What the reader of the results should know about the model."""
    notes = mesh.remarks
    if mesh.crack is None and (warning := band_note(scene.material, cracks.width)):
        notes.append(warning)
    if cracks.area:
        length = scene.specimen.crack_length_of(cracks.area)
        notes += filter(None, [path_size_note(mesh, scene.zone_length, length, scene.is_extruded)])
    if scene.specimen.is_off_the_notch():
        notes.append("warning: the crack path neither begins nor ends at a notch, which stays closed to it")
    if scene.sizes is None and (length := mesh.crack_front):
        notes.append(f"the crack surface ends inside the body along {length:.4g} mm of its edge; there is the front")
    return notes
