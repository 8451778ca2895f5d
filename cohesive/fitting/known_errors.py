"""What errors that are known, or can be computed, do to fitted numbers: scatter of the test, and the mesh."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Array
from ..errors import SceneError
from ..scenes.scene import Scene
from ..solver.stages import Stage
from .data import ROWS
from .problem import FAILURES, FitEvaluation, FitProblem, at_rows
from .repeated_run import RepeatedRun, value_of

#: by what the sizes are divided for the finer mesh, and the error over the change that this makes if it is of first order
_FINER = 2.0
_ERROR = 1.0 / (1.0 - 1.0 / _FINER)

#: waves of the computed curve that are said, part of the peak
_WAVES = 3e-3

#: part to which a finer mesh must bring the residuals to be said
_REMOVED = 0.95


def scatter_of(problem: FitProblem, evaluation: FitEvaluation, scatter: Mapping[str, float]) -> Array | None:
    """What known scatter of other numbers adds to the covariance, (m, m): each moves the fit by -(J'J)^-1 J' dr.

    Raises
    ------
    SceneError
        For a number that is varied, or a standard deviation that is none.
    """
    if not scatter:
        return None
    varied_keys = {each.key for each in problem.parameters}
    jacobian = problem.jacobian(evaluation.z)
    added = np.zeros((len(evaluation.z), len(evaluation.z)))
    for key, deviation in scatter.items():
        if key in varied_keys:
            raise SceneError(f"scatter {key}: it is varied; expected a number that the fit takes as known", key)
        if isinstance(deviation, bool) or not isinstance(deviation, (int, float)) or not 0.0 < deviation < np.inf:
            raise SceneError(f"scatter {key} = {deviation}: expected a standard deviation above 0", key)
        loads = []
        for i, repeated in enumerate(problem.repeated):
            values = problem.values(evaluation.z, i)
            base = values.get(key, value_of(repeated.scene, key))
            moved = RepeatedRun(repeated.scene.with_(**{**values, key: base + deviation}))
            loads.append(at_rows(moved.run({}, problem.stages_of(evaluation.z, i)), problem.rows(evaluation.z, i))[0])
        shift = _shift(problem, evaluation, jacobian, loads)
        added += np.outer(shift, shift)
    return added


def _shift(problem: FitProblem, evaluation: FitEvaluation, jacobian: Array, loads: Sequence[Array]) -> Array:
    """How far the fitted numbers move if the computed loads are others, (m,), scaled."""
    three = zip(problem.data, loads, evaluation.loads, strict=True)
    parts = [data.residuals(other) - data.residuals(load) for data, other, load in three]
    return np.asarray(-np.linalg.lstsq(jacobian, np.concatenate(parts), rcond=1e-10)[0])


@dataclass(frozen=True)
class MeshPart:
    """What the mesh does to fitted numbers.

    Attributes
    ----------
    error : (m,) array, of each number, scaled, above 0; NaN if no finer mesh was run
    notes : why not, or what waves the mesh leaves
    """

    error: Array
    notes: tuple[str, ...] = ()

    @classmethod
    def of(cls, problem: FitProblem, evaluation: FitEvaluation, scenes: Sequence[Scene]) -> MeshPart:
        """From one run of each scene with the fitted numbers on elements of half the size, with steps of half the length and
        the width that the rule gives with these numbers; the error is twice the change, as of first order.

        Parameters
        ----------
        scenes : as they were given, with the fitted numbers.
        """
        unknown = np.full(len(evaluation.z), np.nan)
        loads = []
        for i, scene in enumerate(scenes):
            sizes = problem.repeated[i].scene.sizes
            if sizes is None or scene.is_solid:
                what = "a mesh of the user's" if sizes is None else "a solid"
                return cls(unknown, (f"mesh: its part is not known, as {what} is not refined; compare with a finer one",))
            finer = {"mesh.crack_size": sizes.crack_size / _FINER, "mesh.far_size": sizes.far_size / _FINER}
            try:
                rows = RepeatedRun(scene.with_(**finer)).run(
                    {}, [_halved(stage) for stage in problem.stages_of(evaluation.z, i)]
                )
                loads.append(at_rows(rows, problem.rows(evaluation.z, i))[0])
            except FAILURES as error:
                return cls(unknown, (f"warning: the part of the mesh is not known, a finer one does not run: {error}",))
        shift = _shift(problem, evaluation, problem.jacobian(evaluation.z), loads)
        notes = []
        for i, (data, load) in enumerate(zip(problem.data, evaluation.loads, strict=True)):
            change = loads[i] - load + problem.slopes(i, evaluation) @ shift
            notes += _waves(change / data.peak, (load - data.middle) / data.peak, scenes[i].title if len(loads) > 1 else "")
        return cls(_ERROR * abs(shift), tuple(notes))

    def added(self, z: Array, ends: Array) -> Array:
        """Ends of intervals, (m, 2), wider by the part of the mesh if that is more than a tenth of their half widths."""
        error = np.nan_to_num(self.error)[:, None]
        return np.asarray(ends + np.where(error > 0.1 * abs(ends - z[:, None]), error, 0.0) * [-1.0, 1.0])


def _halved(stage: Stage) -> Stage:
    """A stage with a target between each two, if they are few measured places."""
    targets = np.array(stage.targets)
    if stage.steps is None and len(targets) < ROWS / 2:
        between = 0.5 * (np.r_[0.0, targets[:-1]] + targets)
        return replace(stage, to=np.ravel(np.stack([between, targets], axis=1)).tolist())
    return stage


def _waves(change: Array, residuals: Array, title: str) -> list[str]:
    """A sentence, if the finer mesh has a curve that no number follows."""
    largest = float(abs(change).max())
    if largest < _WAVES:
        return []
    before, after = (float(np.sqrt(np.mean(np.square(each)))) for each in (residuals, residuals + change))
    removed = f", which leaves rms {100 * after:.2g} in place of {100 * before:.2g} %" if after < _REMOVED * before else ""
    return [
        f"{title}{': ' if title else ''}waves of up to {100 * largest:.2g} % of the peak in the residuals are of the mesh or "
        f"its steps: elements of half the size have them not{removed}"
    ]
