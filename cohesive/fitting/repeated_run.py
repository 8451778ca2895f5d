"""A scene that is run again and again with other values: mesh and condensed stiffness are kept for as long as they hold."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..algebra.bordered import INEXACT, Border, Stiffness
from ..arrays import Array, Index
from ..errors import SceneError, TooCostly
from ..law.concrete import Concrete
from ..model.build import build
from ..model.model import Model
from ..model.prepared import Prepared, prepare
from ..scenes.scene import Scene
from ..scenes.table_reader import table_hint
from ..solver.problem import Problem
from ..solver.sensitivity import Parameter, Sensitivity, is_differentiated, moved
from ..solver.stages import Stage
from ..solver.stepper import Step, solve

#: relative change of a parameter for the derivative of the law at a fixed state, and for that of a whole run
_AT_A_STATE, _OF_A_RUN = 1e-6, 1e-4

#: tolerance of the runs that are differenced
_TIGHT = 1e-10

#: tables of a scene whose numbers are no parameters of what is computed
_NO_PARAMETERS = ("stage", "mesh", "solver", "output", "reference", "model", "grow")

#: parameters of the material that change more than the law and a factor of the stiffness
_NOT_OF_THE_LAW = ("material.nu", "material.density")


@dataclass(frozen=True)
class Rows:
    """What a run has recorded.

    Attributes
    ----------
    scene : Scene that was run: `run` gives these rows again
    model : Model
    steps : list of Step
    dead : list of Step that brought the body under its dead loads
    notes : of the run
    history : {column: (n,) array} of what belongs to a state
    """

    scene: Scene
    model: Model
    steps: list[Step]
    dead: Sequence[Step]
    notes: list[str]
    history: dict[str, Array]


@dataclass
class RepeatedRun:
    """Runs a scene with changed values on one mesh.

    The sizes of the mesh and the width of the crack plane are those of the scene as it was given: their defaults follow the
    material, and would make the response jump.

    Attributes
    ----------
    scene : Scene, with sizes and width fixed
    most : solutions of linear systems that a run may take; None: any number. A crack that snaps takes very many
    runs, condensations, sensitivities : how often each was done so far
    """

    scene: Scene
    most: int | None = None
    runs: int = field(default=0, init=False)
    condensations: int = field(default=0, init=False)
    sensitivities: int = field(default=0, init=False)
    _prepared: Prepared = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self._prepared = self._prepare(self.scene)
        self.scene = self._prepared.scene

    def _prepare(self, scene: Scene) -> Prepared:
        self.condensations += 1
        return prepare(scene)

    def model(self, scene: Scene, keeps: bool = True) -> Model:
        """The model of a scene that differs from the last one in some values; of another mesh or another stiffness one that is
        kept for the runs to come, or not."""
        try:
            return build(self._prepared.scene_of(scene), kept=self._prepared.model)
        except SceneError:
            prepared = self._prepare(scene)
            self._prepared = prepared if keeps else self._prepared
            return prepared.model

    def run(self, values: Mapping[str, float], stages: Sequence[Stage] | None = None, tol: float | None = None) -> Rows:
        """Run with some values changed.

        Parameters
        ----------
        stages : instead of those of the scene.
        tol : tolerance instead of that of the scene.

        Raises
        ------
        SceneError, NotConverged
        TooCostly
            If it takes more than `most`.
        """
        changes: dict[str, Any] = {**values}
        if stages is not None:
            changes["stage"] = [stage.data for stage in stages]
        if tol is not None:
            changes["solver.tol"] = tol
        scene = self.scene.with_(**changes)
        model = self.model(scene)
        problem = model.problem
        if self.most is not None:
            problem = replace(problem, stiffness=_Counted(problem.stiffness, self.most))
        stepper = solve(problem, scene.stages, model.recorded, scene.solver.step_growth)
        model = replace(model, problem=stepper.problem)
        steps = list(stepper)
        self.runs += 1
        records = [model.record(step.equilibrium.state) for step in steps]
        history = {name: np.array([r[name] for r in records]) for name in (records[0] if records else ())}
        return Rows(scene, model, steps, stepper.dead, stepper.notes, history)

    def is_exact(self, keys: Sequence[str], stages: Sequence[Stage]) -> bool:
        """Whether the steps of these stages can be differentiated in some keys."""
        whole = self.scene.model.kind == "discrete" and self.scene.solver.condensation != "petsc"
        whole = whole and self.scene.law.is_differentiated
        plain = all(is_differentiated(stage.control) and not stage.redirects for stage in stages)
        return whole and plain and all(_is_of_law(key) or _is_of_body(key) for key in keys)

    def derivatives(
        self, rows: Rows, values: Mapping[str, float], keys: Sequence[str], energies: bool = True
    ) -> dict[str, dict[str, Array]]:
        """Derivatives of all columns of a run in some keys, {key: {column: (n,) array}}, see `is_exact`."""
        parameters, halves = [], []
        for key in keys:
            value = value_of(rows.scene, key)
            half = _AT_A_STATE * (abs(value) or 1.0)
            below, above = (self._changed(rows, values, key, value + by) for by in (-half, half))
            parameters.append(Parameter(below, above, half, key == "material.E" or not _is_of_law(key)))
            halves.append(half)
        problem, first = rows.model.problem, rows.model.problem.initial()
        rates = Sensitivity(problem, rows.steps, parameters, rows.dead).rates(energies)
        self.sensitivities += 1
        by_key = {}
        states = [step.equilibrium.state for step in rows.steps]
        for key, half, (start, *rate) in zip(keys, halves, rates, strict=True):
            there = replace(problem, start=moved(first, start, half)) if rows.dead else problem
            far = [rows.model.recorded(there, moved(state, each, half)) for state, each in zip(states, rate, strict=True)]
            by_key[key] = {
                name: (np.array([record[name] for record in far]) - column) / half for name, column in rows.history.items()
            }
        return by_key

    def _changed(self, rows: Rows, values: Mapping[str, float], key: str, value: float) -> Problem:
        """The problem of a run with another number; one of the law needs no scene, and no model."""
        problem = rows.model.problem
        if not _is_of_law(key) or (key == "material.E" and rows.scene.specimen.regions()):
            return self.model(self.scene.with_(**{**values, key: value}), keeps=False).problem
        own = rows.scene.material
        material = _with_number(own, key, value)
        ratio = material.E / own.E
        stiffness = problem.stiffness if ratio == 1.0 else problem.stiffness.scaled(ratio)
        point_law = problem.point_law.of_material(material)
        return replace(problem, point_law=point_law, stiffness=stiffness, dead_factor=problem.dead_factor / ratio)

    def differences(
        self, values: Mapping[str, float], keys: Sequence[str], stages: Sequence[Stage], targets: Callable[[Rows], Index]
    ) -> dict[str, dict[str, Array]]:
        """Central differences of whole runs at the rows of given targets, {key: {column: (k,) array}}."""
        by_key = {}
        for key in keys:
            value = value_of(self.scene.with_(**values), key)
            half = _OF_A_RUN * (abs(value) or 1.0)
            below, above = (
                self.run({**values, key: value + by}, stages, tol=min(_TIGHT, self.scene.solver.tol)) for by in (-half, half)
            )
            at = [targets(rows) for rows in (below, above)]
            k = min(len(rows) for rows in at)
            by_key[key] = {
                name: (above.history[name][at[1][:k]] - below.history[name][at[0][:k]]) / (2.0 * half)
                for name in above.history
            }
        return by_key


class _Counted:
    """A stiffness that solves a number of systems and no more; in all else it is the one it is made of."""

    def __init__(self, stiffness: Stiffness, most: int) -> None:
        self._stiffness, self._most, self._count = stiffness, most, 0

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stiffness, name)

    @property
    def scale(self) -> float:
        return self._stiffness.scale

    def apply(self, v: Array) -> Array:
        return self._stiffness.apply(v)

    def solve(self, border: Border, right: Array, last: float, forcing: float = INEXACT) -> Array:
        self._count += 1
        if self._count > self._most:
            raise TooCostly(f"more than {self._most} iterations: the crack snaps, or other steps are needed")
        return self._stiffness.solve(border, right, last, forcing)


def _with_number(material: Concrete, key: str, value: float) -> Concrete:
    """A material with another number under a dotted key."""
    _, name, *path = key.split(".")
    if not path:
        changed: dict[str, Any] = {name: value}
        return replace(material, **changed)
    whole = place = copy.deepcopy(getattr(material, name))
    if isinstance(whole, tuple):
        whole = place = list(whole)
    *path, last = path
    for part in path:
        place = place[int(part)] if isinstance(place, list) else place[part]
    place[int(last) if isinstance(place, list) else last] = value
    return replace(material, **{name: whole})


def _is_of_law(key: str) -> bool:
    return key.startswith("material.") and key not in _NOT_OF_THE_LAW


def _is_of_body(key: str) -> bool:
    """Whether it changes a spring or a dead load, and the unknowns stay what they are."""
    is_of_specimen = key.startswith("specimen.") and key.endswith(("stiffness", ".value"))
    return is_of_specimen or key == "material.density"


def value_of(scene: Scene, key: str) -> float:
    """The number that a scene has for a dotted key in which its history may be differentiated.

    Raises
    ------
    SceneError
        If there is none, or if it says how the scene is solved, not what it is.
    """
    if key.split(".")[0] in _NO_PARAMETERS:
        raise SceneError(f"{key}: the history has no derivative in it; expected a number of the material or the specimen", key)
    place = scene.given(key)
    if place is None and key.startswith(("material.", "law.")) and key.count(".") == 1:  # a default, or one of a preset
        table, name = key.split(".")
        place = getattr(getattr(scene, table), name, None)
    if isinstance(place, bool) or not isinstance(place, (int, float)):
        meant = table_hint(key)
        raise SceneError(f"{key}: the scene has no number there{meant}; expected a key with a number as its start", key)
    return float(place)
