"""What a result keeps of its model besides the fields: a few numbers, and what was modelled in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..elements.bulk import ElasticBlock

if TYPE_CHECKING:
    from ..cracks.crack_planes import CrackPlanes
    from ..model.model import Model
    from ..scenes.scene import Scene
    from ..solver.problem import State

#: a plane of points that is this much stiffer has no width
_WITHOUT_WIDTH = 1e6

#: a plane that keeps more of its strength has hardly begun to be a crack
_BEGUN = 0.95


@dataclass(frozen=True)
class ModelFacts:
    """Numbers and words about the model of a run.

    Attributes
    ----------
    modelled : three lines: what was modelled, how, and what was left out
    total_dofs, active_dofs : unknowns of the whole body, and those that Newton's method works on
    condensation : kind of the condensation, see `Condensation`
    library : what solved the linear systems
    crack_area : mm^2; None if there is neither a path nor a row of elements that tells
    width : of the crack plane: w, or the l_ch of a crack along the path, mm
    has_platen : whether a platen moves along two directions, so that the load is not always that of the opening
    initial_stiffness : load over motion of the undamaged body, N/mm, by gauge and for "driven"; None if it does not move
    added_compliance : what the width of the crack plane adds to the elastic compliance of opening under load, as a part of
        it; 0 for a band, whose elements are part of the body. With the mean jump as gauge, which has no elastic part, the
        driven motion stands for the opening
    departure : mean angle between the open planes of a band and its path, degrees, weighted with their opening
    damaged : what became of the crack planes of a band, in words; empty for a discrete crack
    """

    modelled: list[str]
    total_dofs: int
    active_dofs: int
    condensation: str
    library: str
    crack_area: float | None
    width: float
    has_platen: bool
    initial_stiffness: dict[str, float | None]
    added_compliance: float
    departure: float
    damaged: str

    @classmethod
    def from_run(cls, scene: Scene, model: Model, last: State | None) -> ModelFacts:
        """Of a run whose last state is given; None if there is none."""
        problem, cracks = model.problem, model.cracks
        elastic = problem.response(problem.point_law.elastic())
        rows = {**problem.measures, "driven": problem.drive}
        moved = {name: float(row @ elastic) for name, row in rows.items()}
        added = 0.0
        if not model.is_smeared:
            row = rows["opening" if scene.specimen.has_main_gauge else "driven"]
            stiffer = problem.response(_WITHOUT_WIDTH * problem.point_law.elastic())
            added = float(row @ elastic) / float(row @ stiffer) - 1.0
        planes = last.cracks.planes if model.is_smeared and last is not None else None
        return cls(
            list(_modelled(scene, model)),
            model.total_dofs,
            model.active_dofs,
            model.condensation.kind,
            model.library,
            cracks.area,
            cracks.width,
            problem.loading.moved.is_platen,
            {name: 1.0 / motion if motion else None for name, motion in moved.items()},
            added,
            0.0 if planes is None else _departure(model, planes),
            "" if planes is None else _damaged(scene, model, planes),
        )


def _modelled(scene: Scene, model: Model) -> Sequence[str]:
    """Three lines: what was modelled, how, and what was left out."""

    def count(blocks: Sequence[ElasticBlock], what: str = "") -> str:
        kinds = " and ".join(sorted({block.kind for block in blocks}))
        return f"{sum(len(block.cells) for block in blocks)} {what}{kinds} elements"

    whole = "one half of a symmetric body, " if scene.model.half else ""
    bulk = count(model.bulk, "linear elastic ") + " and " if model.bulk else ""
    points = f"{len(model.cracks.weights)} points"
    left_out = "cracks off the given path, "
    if model.mesh.crack is not None:
        width = f", width {model.cracks.width:.3g} mm" if scene.law.takes_width else ""
        cracks = f"{len(model.mesh.crack.data)} zero-thickness crack cells, {points}{width}"
    elif model.cracks.faces is not None:
        cracks = f"a crack band of {count(model.band)}, {points}, width {model.cracks.width:.3g} mm"
        left_out = "cracks off the band, "
    else:
        cracks = f"{count(model.band)} that may crack, {points}"
        left_out = "cracks off the band, " if model.bulk else ""
    return (
        f"modelled: {whole}{bulk}{cracks}, {model.cracks.point_law.law.described}, {_dimension(scene, model)}",
        f"solved: {model.active_dofs} of {model.total_dofs} unknowns"
        + (", the rest eliminated once" if model.condensation.kind == "condensed" else ", nothing condensed")
        + (f" ({model.condensation.why})" if model.condensation.why else "")
        + (f"; {model.library}" if model.condensation.kind == "petsc" else ""),
        f"left out: {left_out}crushing, time, temperature, large rotations",
    )


def _dimension(scene: Scene, model: Model) -> str:
    """Dimension of the body, and what holds its faces."""
    if model.mesh.dimension == 2:
        return f"in plane {scene.model.plane}"
    if not scene.is_extruded:
        return "in three dimensions"
    return f"in three dimensions with front and back {'held' if scene.model.plane == 'strain' else 'free'}"


def _damaged(scene: Scene, model: Model, planes: CrackPlanes) -> str:
    """How many planes of a band are damaged, and what their width adds to Gf."""
    m = scene.material
    damaged = np.isfinite(model.cracks.point_law.strength_left(planes))
    if not damaged.any():
        return "no crack has opened"
    count = np.bincount(planes.point[damaged])
    lengths = planes.length[damaged]
    excess = m.ft**2 * lengths.mean() / (2 * m.E * m.Gf)
    return (
        f"cracks: {damaged.sum()} damaged planes at {(count > 0).sum()} points, l_ch {lengths.min():.3g} to "
        f"{lengths.max():.3g} mm, which adds {100 * excess:.1f} % to Gf"
    )


def _departure(model: Model, planes: CrackPlanes) -> float:
    """Mean angle between the open planes of a band and its path, degrees, weighted with their opening."""
    rotations = model.cracks.rotations
    if rotations is None:
        return 0.0
    opening = np.maximum(planes.jump[:, 0], 0.0) * (model.cracks.point_law.strength_left(planes) < _BEGUN)
    if not opening.any():
        return 0.0
    cosine = abs(np.einsum("ci,ci->c", planes.rotation[:, 0], rotations[planes.point, 0]))
    return float(opening @ np.degrees(np.arccos(np.minimum(cosine, 1.0))) / opening.sum())
