"""model/checks"""

from __future__ import annotations

from ..errors import SceneError
from ..scenes.scene import Scene
from ..solver.controls import CONTROLS
from ..solver.problem import Problem


def check_stages(scene: Scene, problem: Problem, width: float) -> None:
    """Refuse targets that this body cannot reach."""
    m = scene.material
    shear = max(1.0, m.r_sigma**2 * m.E / m.G)
    available = shear * (1.0 + m.ft**2 * width / (2 * m.E * m.Gf)) * problem.energy
    for i, stage in enumerate(scene.stages):
        for key in ("angle", "ratio", "hold"):
            if (value := getattr(stage, key)) is not None and len(problem.drives) == 1:
                raise SceneError(f"stage.{i}.{key} = {value!r}: this specimen is driven in one direction; expected no {key}")
        if max(stage.targets) > CONTROLS[stage.control].most(available):
            raise SceneError(
                f"stage.{i}.to = {max(stage.targets):g}: the crack can dissipate {available:.4g} N mm at most; expected less"
            )
    first = scene.stages[0]
    if first.targets[0] == 0:
        raise SceneError("stage.0.to = 0: the run starts there; expected another first target")
    if len(problem.drives) == 2:
        problem = problem.driven(first.direction or 0.0, first.hold is not False)
    control, start = CONTROLS[first.control], problem.initial()
    if control.is_motion and (row := control.equation(problem, 0.0, start, start).row) is not problem.drive:
        elastic = problem.response(problem.point_law.elastic())
        if abs(row @ elastic) <= 1e-9 * abs(row).sum() * abs(elastic).max():
            raise SceneError(
                f"stage.0.control = '{first.control}': the drive does not change it while the body is elastic; expected a "
                "gauge for the specimen (without one the mean jump over the crack is measured), or another control"
            )
