"""What a problem cannot do in its stages: refused before the first step."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace

import numpy as np

from ..arrays import Array
from ..errors import SceneError
from .controls import control_of
from .loading import Loading
from .problem import Problem
from .stages import Stage


def check_stages(stages: Sequence[Stage], problem: Problem, available: float, missing: Collection[str] = ()) -> None:
    """Refuse targets that this body cannot reach.

    Parameters
    ----------
    available : energy that its cracks can dissipate at most, N mm
    missing : gauges of the specimen between the sides of a crack that this mesh does not have.

    Raises
    ------
    SceneError
        Naming the key, its value and what was expected.
    """
    for i, stage in enumerate(stages):
        for key, names in (("control", [stage.control]), ("until", stage.until or {}), ("unload", stage.unload or {})):
            for name in names:
                if name in missing:
                    raise SceneError.at(
                        f"stage.{i}.{key}", f" = '{name}': no crack parts the nodes of this gauge; expected another quantity"
                    )
        if max(stage.targets) > control_of(stage.control).most(available):
            raise SceneError.at(
                f"stage.{i}.to",
                f" = {max(stage.targets):g}: the crack can dissipate {available:.4g} N mm at most; expected less",
            )
    if stages[0].targets[0] == 0:
        raise SceneError.at("stage.0.to", " = 0: the run starts there; expected another first target")
    _check_first_control(stages[0], problem)


def loadings_of(stages: Sequence[Stage], loading: Loading) -> Iterator[Loading]:
    """The loading in each stage, but for its forces, from that before the first one.

    Raises
    ------
    SceneError
        For drives that the specimen does not have.
    """
    for i, stage in enumerate(stages):
        loading = _check_drives(i, stage, loading)
        yield loading


def _check_drives(i: int, stage: Stage, loading: Loading) -> Loading:
    """Refuse drives that the specimen does not have; the loading in the stage, but for its forces."""
    for key, names in (("drive", [stage.drive]), ("others", list(stage.others or {}))):
        for name in names:
            if name is not None and name not in loading.names:
                raise SceneError.at(
                    f"stage.{i}.{key}", f": the specimen has no drive '{name}'; it has {', '.join(loading.names)}"
                )
    moved = loading.active if stage.drive is None else stage.drive
    if moved in (stage.others or {}):
        raise SceneError.at(
            f"stage.{i}.others", f": the stage moves drive '{moved}' itself; expected the others, or another drive"
        )
    loading = loading.after(stage.drive, stage.others or {}, np.zeros(loading.count))
    for key in ("angle", "hold"):
        if (value := getattr(stage, key)) is not None and not loading.moved.is_platen:
            raise SceneError.at(
                f"stage.{i}.{key}", f" = {value!r}: this specimen is driven in one direction; expected no {key}"
            )
    return loading.turned(stage.angle, stage.hold)


def _check_first_control(first: Stage, problem: Problem) -> None:
    """Refuse a measure that the drive does not change while the body is elastic."""
    loading = problem.loading.after(first.drive, first.others or {}, np.zeros(problem.loading.count))
    problem = replace(problem, loading=loading.turned(first.angle, first.hold))
    control, start = control_of(first.control), problem.initial()
    if not control.is_motion or (row := control.equation(problem, 0.0, start, start).row) is problem.drive:
        return
    elastic = problem.response(problem.point_law.elastic())

    def responds(row: Array) -> bool:
        return bool(abs(row @ elastic) > 1e-9 * abs(row).sum() * abs(elastic).max())

    if not responds(row):
        others = [name for name, other in problem.measures.items() if name != first.control and responds(other)]
        instead = " or ".join(repr(name) for name in [*others, "driven"])
        raise SceneError.at(
            "stage.0.control",
            f" = '{first.control}': the drive does not change it while the body is elastic; expected {instead}, or a "
            "gauge for the specimen (without one the mean jump over the crack is measured)",
        )
