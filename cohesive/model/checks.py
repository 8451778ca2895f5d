"""What a body cannot do, or what belongs to other units: refused before the first step."""

from __future__ import annotations

from collections.abc import Sequence

from ..errors import SceneError
from ..law.concrete import Concrete
from ..solver.controls import CONTROLS
from ..solver.problem import Problem
from ..solver.stages import Stage


def check_units(concrete: Concrete, crack_length: float) -> None:
    """Refuse numbers that belong to other units: their ratios are far from any concrete's."""
    m = concrete
    if not 1e-6 < m.ft / m.E < 1e-2:
        raise SceneError(
            f"material.E = {m.E:g}, material.ft = {m.ft:g}: ft / E = {m.ft / m.E:.1e}; expected about 1e-4, both in MPa",
            "material.E",
        )
    if m.Zm > crack_length:
        raise SceneError(
            f"material.Gf = {m.Gf:g}: softening would end at an opening of {m.Zm:.3g} mm, more than the crack's length of "
            f"{crack_length:.3g} mm; expected Gf in N/mm (MPa mm) and lengths in mm",
            "material.Gf",
        )


def check_stages(stages: Sequence[Stage], problem: Problem, concrete: Concrete, width: float) -> None:
    """Refuse targets that this body cannot reach.

    Parameters
    ----------
    width : of the crack plane, mm.
    """
    m = concrete
    shear = max(1.0, m.r_sigma**2 * m.E / m.G)
    available = shear * (1.0 + m.ft**2 * width / (2 * m.E * m.Gf)) * problem.energy
    for i, stage in enumerate(stages):
        for key in ("angle", "hold"):
            if (value := getattr(stage, key)) is not None and len(problem.drives) == 1:
                raise SceneError(
                    f"stage.{i}.{key} = {value!r}: this specimen is driven in one direction; expected no {key}",
                    f"stage.{i}.{key}",
                )
        if max(stage.targets) > CONTROLS[stage.control].most(available):
            raise SceneError(
                f"stage.{i}.to = {max(stage.targets):g}: the crack can dissipate {available:.4g} N mm at most; expected less",
                f"stage.{i}.to",
            )
    if stages[0].targets[0] == 0:
        raise SceneError("stage.0.to = 0: the run starts there; expected another first target", "stage.0.to")
    _check_first_control(stages[0], problem)


def _check_first_control(first: Stage, problem: Problem) -> None:
    """Refuse a measure that the drive does not change while the body is elastic."""
    if len(problem.drives) == 2:
        problem = problem.driven(first.angle or 0.0, first.hold is not False)
    control, start = CONTROLS[first.control], problem.initial()
    if not control.is_motion or (row := control.equation(problem, 0.0, start, start).row) is problem.drive:
        return
    elastic = problem.response(problem.point_law.elastic())
    if abs(row @ elastic) <= 1e-9 * abs(row).sum() * abs(elastic).max():
        raise SceneError(
            f"stage.0.control = '{first.control}': the drive does not change it while the body is elastic; expected a "
            "gauge for the specimen (without one the mean jump over the crack is measured), or another control",
            "stage.0.control",
        )
