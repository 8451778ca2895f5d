"""The equations of a body with cracks: what is assembled, condensed, and left to Newton's method."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..algebra.bulk_matrix import bulk_stiffness
from ..algebra.choice import Bulk, Condensation, condense
from ..algebra.crack_operator import CrackOperator
from ..algebra.unknowns import Unknowns
from ..arrays import Array
from ..errors import SceneError
from ..scenes.scene import Scene
from ..solver.loading import DEAD, Actuator, Loading
from ..solver.problem import Problem, Springs
from .boundary import Boundary
from .cracks import CrackPart
from .elements import Elements
from .gauges import measures
from .mesh import CrackedMesh
from .setup import Setup


@dataclass(frozen=True)
class Assembled:
    """A body before it is condensed.

    Attributes
    ----------
    bulk : Bulk, its stiffness and its dead loads over `Elements.unit`
    measures : by name, each a linear measure of all unknowns
    weights, where : of the points with cracks, see `CrackPart`
    """

    bulk: Bulk
    measures: dict[str, Array]
    weights: Array
    where: Array

    @property
    def total_dofs(self) -> int:
        """Number of all unknowns."""
        return int(self.bulk.unknowns.transform.shape[1])


def assembled(
    scene: Scene,
    mesh: CrackedMesh,
    elements: Elements,
    cracks: CrackPart,
    setup: Setup,
    constraints: Boundary,
    dead: Array | None,
) -> Assembled:
    """The bulk with its unknowns, its dead loads and its measures.

    Parameters
    ----------
    dead : of `dead_loads`, over `Elements.unit`

    Raises
    ------
    SceneError
        For supports that contradict each other, and gauges or dead loads that the mesh has no place for.
    """
    half, representative = scene.model.half, mesh.representative
    rows = measures(scene.specimen, setup.gauges, mesh, cracks.faces)
    try:
        unknowns = Unknowns.from_constraints(
            representative, constraints.supports, constraints.motions, constraints.mirror, int(dead is not None)
        )
    except ValueError as error:
        raise SceneError(f"specimen.{error}", "specimen") from None
    K = bulk_stiffness(elements.of_unit, mesh.points.size)
    if half:
        K *= 2.0  # load and energies are those of the whole
        dead = None if dead is None else 2.0 * dead
    operator = unknowns.seen_by(cracks.operator)
    rows = {name: row @ unknowns.transform for name, row in rows.items()}
    seen = np.zeros(unknowns.transform.shape[1], dtype=bool)
    seen[operator.indices] = True
    seen[unknowns.drives] = seen[unknowns.rotations] = True  # each sees a whole face
    for row in rows.values():
        seen |= abs(row) > 1e-12
    points = np.asarray(mesh.points, dtype=float)
    bulk = Bulk(points, elements.elastic, elements.cracking, representative, unknowns, operator, np.flatnonzero(seen), K, dead)
    return Assembled(bulk, rows, cracks.weights, cracks.where)


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
        raise SceneError.at("specimen", f": {error}") from None


def problem_of(whole: Assembled, condensation: Condensation, constraints: Boundary, **law: Any) -> Problem:
    """The equations on the unknowns that are left.

    Parameters
    ----------
    law : of the problem, what another law changes
    """
    bulk, at = whole.bulk, condensation.unknowns
    number = np.full(bulk.unknowns.transform.shape[1], -1)
    number[at] = np.arange(len(at))
    drives = number[bulk.unknowns.drives]
    loads, springs = dict(constraints.drives), (constraints.acting, constraints.later)
    if bulk.dead is not None:
        loads[DEAD] = Actuator((len(drives) - 1,))
        springs = (np.append(constraints.acting, 0.0), np.append(constraints.later, 0.0))
    return Problem(
        operator=CrackOperator.from_matrix(bulk.operator[:, at].tocsr(), whole.weights, whole.where),
        drives=drives,
        loading=Loading.from_drives(loads, len(drives)),
        springs=Springs.from_stiffness(*springs),
        measures={name: row[at] for name, row in whole.measures.items()},
        **law,
    )
