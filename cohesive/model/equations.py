"""The equations of a body with cracks: what is assembled, condensed, and left to Newton's method."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from ..algebra.bulk_matrix import bulk_stiffness
from ..algebra.choice import Bulk, Condensation, condense
from ..algebra.crack_operator import CrackOperator
from ..algebra.unknowns import Unknowns
from ..arrays import Array
from ..errors import SceneError
from ..law.concrete import Concrete
from ..scenes.scene import Scene
from ..solver.loading import DEAD, Actuator, Loading
from ..solver.problem import Problem, Springs
from .boundary import Boundary
from .cracks import CrackPart
from .dead_loads import dead_loads
from .elements import Elements
from .gauges import measures
from .mesh import CrackedMesh


@dataclass(frozen=True)
class Assembled:
    """A body before it is condensed.

    Attributes
    ----------
    bulk : Bulk
    measures : by name, each a linear measure of all unknowns
    """

    bulk: Bulk
    measures: dict[str, Array]


def assembled(scene: Scene, mesh: CrackedMesh, elements: Elements, cracks: CrackPart, held: Boundary) -> Assembled:
    """The bulk with its unknowns, its dead loads and its measures.

    Raises
    ------
    SceneError
        For supports that contradict each other, and gauges or dead loads that the mesh has no place for.
    """
    half, leader = scene.model.half, mesh.leader
    dead = dead_loads(scene.specimen, mesh, elements)
    rows = measures(scene.specimen, half, mesh, cracks.faces)
    try:
        unknowns = Unknowns.from_constraints(leader, held.supports, held.motions, held.mirror, int(dead is not None))
    except ValueError as error:
        raise SceneError(f"specimen.{error}", "specimen") from None
    K = bulk_stiffness(elements.elastic, mesh.points.size)
    if half:
        K *= 2.0  # load and energies are those of the whole
        dead = None if dead is None else 2.0 * dead
    if dead is not None:  # by a motion of the size of the others, whose force is then of theirs
        dead /= cracks.point_law.onset_jump
    operator = _without_cancelled(cracks.operator @ unknowns.transform)
    rows = {name: row @ unknowns.transform for name, row in rows.items()}
    seen = np.zeros(unknowns.transform.shape[1], dtype=bool)
    seen[operator.indices] = True
    seen[unknowns.drives] = seen[unknowns.rotations] = True  # each sees a whole face
    for row in rows.values():
        seen |= abs(row) > 1e-12
    points = np.asarray(mesh.points, dtype=float)
    bulk = Bulk(points, elements.elastic, elements.cracking, leader, unknowns, operator, np.flatnonzero(seen), K, dead)
    return Assembled(bulk, rows)


def _without_cancelled(operator: sp.csr_array) -> sp.csr_array:
    """Without the entries that cancel: a jump does not see the mean motion of the faces."""
    operator = operator.tocsr()
    operator.data[abs(operator.data) < 1e-12] = 0.0
    operator.eliminate_zeros()
    return operator


def condensed(bulk: Bulk, wanted: str) -> Condensation:
    """The bulk as the solver sees it, see `algebra.choice.condense`; "petsc" leaves it whole.

    Raises
    ------
    SceneError
        If a part of the body is not held.
    """
    if wanted == "petsc":
        from ..algebra.petsc.stiffness import uncondensed  # with petsc4py, which need not be installed

        return uncondensed(bulk)
    try:
        return condense(bulk, wanted)
    except SceneError:  # which names its own key
        raise
    except ValueError as error:
        raise SceneError(f"specimen: {error}", "specimen") from None


def problem_of(
    whole: Assembled,
    condensation: Condensation,
    cracks: CrackPart,
    held: Boundary,
    concrete: Concrete,
    area: float,
    tol: float,
) -> Problem:
    """The equations on the unknowns that are left.

    Parameters
    ----------
    area : of the crack, mm^2, or its order
    tol : relative tolerance of Newton's method
    """
    bulk, at = whole.bulk, condensation.unknowns
    number = np.full(bulk.unknowns.transform.shape[1], -1)
    number[at] = np.arange(len(at))
    drives = number[bulk.unknowns.drives]
    loads, springs = dict(held.drives), (held.acting, held.later)
    if bulk.dead is not None:
        loads[DEAD] = Actuator((len(drives) - 1,))
        springs = (np.append(held.acting, 0.0), np.append(held.later, 0.0))
    return Problem(
        cracks.point_law,
        CrackOperator.from_matrix(bulk.operator[:, at].tocsr(), cracks.weights, cracks.where),
        condensation.stiffness,
        drives,
        Loading.from_drives(loads, len(drives)),
        Springs.from_stiffness(*springs),
        concrete.ft * area,
        concrete.Gf * area,
        {name: row[at] for name, row in whole.measures.items()},
        tol,
        dead_factor=0.0 if bulk.dead is None else cracks.point_law.onset_jump,
    )


def with_law(
    problem: Problem, condensation: Condensation, cracks: CrackPart, concrete: Concrete, area: float, tol: float, factor: float
) -> Problem:
    """The equations of a body that differs in its law and in the modulus of its bulk, see `problem_of`.

    Parameters
    ----------
    condensation : whose stiffness is scaled already
    factor : the new modulus over that of `problem`
    """
    return replace(
        problem,
        point_law=cracks.point_law,
        stiffness=condensation.stiffness,
        strength=concrete.ft * area,
        energy=concrete.Gf * area,
        tol=tol,
        dead_factor=problem.dead_factor / factor,  # the coupling to it grows with the stiffness
    )
