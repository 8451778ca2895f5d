"""`sensitivities`: how the history of a scene changes with its parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Array, Index
from ..errors import SceneError
from ..scenes.scene import Scene
from ..solver.stages import Stage
from .repeated_run import RepeatedRun, Rows


@dataclass(frozen=True)
class Sensitivities:
    """Derivatives of the history in parameters, at the targets of the stages.

    A row stands at each target and at each of the equal steps towards it, whether or not the run has cut its steps or
    inserted one. What is prescribed in a row does not change.

    Attributes
    ----------
    keys : the parameters
    history : {column: (k,) array} at the targets
    derivatives : {key: {column: (k,) array}}, in the unit of the column over that of the parameter
    is_exact : whether the converged steps were differentiated; else whole runs, by central differences
    """

    keys: tuple[str, ...]
    history: dict[str, Array]
    derivatives: dict[str, dict[str, Array]]
    is_exact: bool

    def __getitem__(self, key: str) -> dict[str, Array]:
        return self.derivatives[key]


def sensitivities(scene: Scene, keys: Sequence[str]) -> Sensitivities:
    """Derivatives of every column of the history in some numbers of a scene.

    Mesh, and width of the crack plane, stay as the scene has them. With the discrete model, parameters of the material and
    stiffnesses of supports the converged steps are differentiated, which costs less than half of a run. Else, as with the
    smeared model, a change of the drive or another Poisson's ratio, two runs for each parameter are differenced.

    Parameters
    ----------
    keys : dotted keys, as "material.ft" or "material.softening.kink.0"

    Raises
    ------
    SceneError
        For a key without a number, or a stage that ends with an event.

    Examples
    --------
    >>> from cohesive import Scene, sensitivities
    >>> moved = sensitivities(Scene.load("notched-beam"), ["material.ft"])
    >>> bool(moved.derivatives["material.ft"]["load"].max() > 0), moved.is_exact
    (True, True)
    """
    for i, stage in enumerate(scene.stages):
        for name in ("until", "unload"):
            if getattr(stage, name) is not None:
                raise SceneError(
                    f"stage.{i}.{name} = {getattr(stage, name)!r}: where it ends moves with the parameters, and with it all "
                    "rows that follow; expected targets",
                    f"stage.{i}.{name}",
                )
    repeated = RepeatedRun(scene)
    stages = with_all_steps(repeated.scene.stages)
    exact = repeated.is_exact(keys, stages)
    rows = repeated.run({}, stages)
    at = target_rows(rows)
    if exact:
        by_key = repeated.derivatives(rows, {}, keys)
        derivatives = {key: {name: column[at] for name, column in columns.items()} for key, columns in by_key.items()}
    else:
        derivatives = repeated.differences({}, keys, stages, target_rows)
    history = {name: column[at] for name, column in rows.history.items()}
    return Sensitivities(tuple(keys), history, derivatives, exact)


def with_all_steps(stages: Sequence[Stage]) -> list[Stage]:
    """The stages with each of their equal steps as a target, so far as it is known where they begin."""
    refined: list[Stage] = []
    last, control = 0.0, stages[0].control
    for stage in stages:
        known = stage.control == control and not (stage.redirects and refined)
        targets: list[float] = []
        for target in stage.targets:
            if known:
                count = max(round(stage.count(abs(target - last))), 1)
                targets += np.linspace(last, target, count + 1)[1:].tolist()
            else:
                targets.append(target)
            last, known = target, True
        whole = len(targets) > len(stage.targets)
        refined.append(replace(stage, to=targets, steps=1, step=None) if whole else stage)
        control = stage.control
    return refined


def target_rows(rows: Rows) -> Index:
    """The rows of a run that stand at a target of its stages, as far as the run has come."""
    tol = max(rows.model.problem.tol, 1e-9)
    wanted = [(i, stage.control, target) for i, stage in enumerate(rows.scene.stages, start=1) for target in stage.targets]
    spread = max(abs(target) for _, _, target in wanted)
    rows_at_targets, k = [], 0
    for row, step in enumerate(rows.steps):
        while k < len(wanted) and wanted[k][0] < step.stage:
            k += 1
        if k == len(wanted):
            break
        number, control, target = wanted[k]
        if step.stage == number and step.control == control and abs(step.value - target) <= 4.0 * tol * spread:
            rows_at_targets.append(row)
            k += 1
    return np.array(rows_at_targets, dtype=np.intp)
