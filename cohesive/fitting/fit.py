"""`fit`: from measured curves to the numbers of a scene, with intervals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import Array
from ..errors import SceneError
from ..measured.curve import Measured, Reference
from ..scenes.reference import load_reference, reference_to
from ..scenes.scene import Scene
from ..solver.controls import control_of
from .data import Data
from .intervals import Statistics, covariance_ends, feasible_ends, in_words, profile_ends, statistics, unseen_direction
from .known_errors import MeshPart, scatter_of
from .parameters import OFFSET, inside, varied
from .problem import FAILURES, FitEvaluation, FitProblem
from .repeated_run import RepeatedRun, value_of
from .result import Fit, Minimum

#: changes of the numbers, and of the sum of squares, below which a fit ends
_XTOL, _FTOL = 1e-4, 1e-5

#: change of a scaled number up to which residuals are linear
_FAR = 0.1

#: part of the sum of squares that no minimum could lose to a Gauss-Newton step, if it is worth anything: mean square above
_STUCK, _NOTHING = 0.05, 1e-6

#: how often a start that does not run is moved half the way to the first one
_PULLS = 3

#: most evaluations of a fit from one start, and of one with a number fixed
_MOST, _MOST_FIXED = 40, 8

#: residuals are outliers to soft_l1 from this part of the peak on
_OUTLIER = 0.02

#: minima are one if no scaled number differs by more than this
_DISTINCT = 0.03

#: the test does not see a number that moves no load by this part of the peak when it changes by its own size
_UNSEEN = 1e-3

#: how far an interval reaches at most, scaled: beyond a factor of 1000 the number is not known
_FURTHEST = float(np.log(1000.0))

#: places to start from, at most: each takes a fit of its own
_MOST_STARTS = 1000

#: parameters of contact and shear
_OF_SHEAR = ("h", "m_g", "r_sigma", "mu_sigma", "c1", "n_g", "r_z", "c_zn", "c_lm", "u_phi0", "Zm")

#: how often noise is told from the residuals, and the rows are weighed by it
_WEIGHINGS = 2

#: measured and computed largest loads may differ by this factor
_UNITS = 100.0

#: loads at the same place may differ by this factor, in the median of those above this part of the peak
_OFF, _HIGH = 20.0, 0.1


def fit(
    scenes: Scene | Sequence[Scene],
    vary: Mapping[str, tuple[float, float]],
    reference: Any = None,
    loss: str | None = None,
    weights: str = "arc",
    own: Sequence[str] = (),
    starts: int = 1,
    profile: bool = False,
    scatter: Mapping[str, float] | None = None,
    check: bool = True,
) -> Fit:
    """Numbers of one or several scenes with which the computed loads come closest to the measured ones.

    The mesh, its condensed stiffness and the width of the crack plane are kept: those of the scene as it is given. The
    Jacobian is exact, see `sensitivities`. A scene that is loaded once stands at the measured places, whatever its stage
    says.

    Parameters
    ----------
    scenes : one, or several that share the numbers
    vary : {key: (low, high)}; a fit starts from what the scene has
    reference : Reference, Measured, (x, y) in mm and N, or a file (see `read_measured`); a list for several
        scenes. Default: what each scene names
    loss : "linear" (least squares), "soft_l1" (outliers count less), or "band": nothing counts inside the measured bounds.
        Default: of each scene its own, "band" for a measured band, else "linear"
    weights : "arc": a curve of more than 100 rows is averaged over 100 pieces of equal length; "rows": each row counts
    own : keys of which each scene has its own number, named KEY@1, KEY@2
    starts : number of places to start from; beyond the first by Latin hypercube. All distinct minima are reported
    profile : whether intervals come from profile likelihood, else from the covariance
    scatter : {key: standard deviation} of numbers that are known to scatter, as specimen.notch; goes into the intervals
    check : whether the fitted scenes are run once more on a finer mesh, whose part goes into the intervals

    Raises
    ------
    SceneError
        For bad input, with the key, or a number that the test cannot see.

    Examples
    --------
    >>> from cohesive import Scene, fit, run
    >>> beam = Scene.load("notched-beam")
    >>> measured = run(beam.with_(**{"material.ft": 3.0})).history
    >>> fitted = fit(beam, {"material.ft": (1.0, 6.0)}, reference=(measured["opening"], measured["load"]), check=False)
    >>> print(f"{fitted.values['material.ft']:.2f} MPa")
    3.00 MPa
    """
    each = [scenes] if isinstance(scenes, Scene) else list(scenes)
    problem = _problem(each, vary, reference, loss, weights, own)
    first = _first(problem)
    _refuse_unseen(problem, first)
    distinct = weighed_minima(problem, _starts(problem, starts))
    best = problem.evaluate(distinct[0].z)
    added = scatter_of(problem, best, scatter or {})
    spread = statistics(problem, best, added)
    kind, ends = _intervals(problem, best, spread, profile)
    if profile and kind == "profile" and added is not None:
        half = spread.quantile * np.sqrt(np.diag(added))
        ends = best.z[:, None] + np.sign(ends - best.z[:, None]) * np.hypot(ends - best.z[:, None], half[:, None])
    ends[(abs(ends - best.z[:, None]) > _FURTHEST).any(axis=1)] = np.nan
    found = [scene.with_(**problem.values(best.z, i)) for i, scene in enumerate(each)]
    mesh = MeshPart.of(problem, best, found) if check else MeshPart(np.full(len(best.z), np.nan))
    ends = mesh.added(best.z, ends)
    words = in_words(problem.parameters, best.z, ends, spread, kind) + unseen_direction(problem, best)
    return Fit(each, problem, distinct, best, spread, ends, kind, words, mesh)


def _problem(
    scenes: list[Scene],
    vary: Mapping[str, tuple[float, float]],
    reference: Any,
    loss: str | None,
    weights: str,
    own: Sequence[str],
) -> FitProblem:
    """Scenes, data and numbers."""
    if not scenes or not all(isinstance(scene, Scene) for scene in scenes):
        raise TypeError(f"fit({scenes!r}): expected a Scene, or a list of them")
    given = list(reference) if isinstance(reference, list) else [reference] * len(scenes)
    if len(given) != len(scenes):
        raise SceneError(f"reference: {len(given)} for {len(scenes)} scenes; expected one for each", "reference")
    references = [_reference(scene, one) for scene, one in zip(scenes, given, strict=True)]
    data = [Data.from_reference(one, weights, loss) for one in references]
    for scene in scenes:
        for key in vary:
            if key != OFFSET:
                value_of(scene, key)
    parameters = varied(scenes, vary, own, [[curve.x_offset for curve in each.curves] for each in data])
    started = {p.key: p.start for p in reversed(parameters) if p.curve is None}
    return FitProblem([RepeatedRun(scene.with_(**started)) for scene in scenes], data, parameters)


def _reference(scene: Scene, given: Any) -> Reference:
    """The measured curve of a scene."""
    if isinstance(given, (str, Path)):
        scene = scene.with_(**{"reference.file": str(Path(given).resolve())})
        given = None
    if given is None:
        named = load_reference(scene)
        if named is None:
            raise SceneError(f"reference is missing in scene '{scene.title}': expected a measured curve to fit", "reference")
        return named
    if isinstance(given, Reference):
        return given
    control = scene.stages[0].control
    against = control if control_of(control).is_motion else "opening"
    return reference_to(scene, given if isinstance(given, Measured) else Measured.from_curve(*given), against)


def _first(problem: FitProblem) -> FitEvaluation:
    """The run from the start, whose scales must be those of the data."""
    z = inside(problem.parameters, problem.start)
    try:
        evaluation = problem.evaluate(z)
    except FAILURES as error:
        raise SceneError(f"the start of the fit does not run: {error}; expected other numbers in the scene") from error
    for data, rows, load in zip(problem.data, evaluation.rows, evaluation.loads, strict=True):
        computed = rows.history["load"][1:]
        ratio = data.peak / max(float(computed.max()), 1e-300)
        is_past = computed.argmax() == 0  # the peak: for that see the openings
        if not 1.0 / _UNITS < ratio < _UNITS and not is_past:
            raise SceneError(
                f"reference: its largest load is {data.peak:.4g} N, the scene starts from {data.peak / ratio:.4g} N; expected "
                "loads in N (see reference.y_unit)",
                "reference.y_unit",
            )
        high = data.middle > _HIGH * data.peak
        off = float(np.median(data.middle[high] / np.maximum(load[high], 1e-9 * data.peak)))
        if not 1.0 / _OFF < off < _OFF:
            raise SceneError(
                f"reference: its loads are {off:.3g} times those of the scene at the same {data.against}, its largest one is "
                f"met at {data.x[int(data.middle.argmax())]:.3g} mm; expected mm (see reference.x_unit), or other numbers in "
                "the scene",
                "reference.x_unit",
            )
    return evaluation


def _refuse_unseen(problem: FitProblem, evaluation: FitEvaluation) -> None:
    """Refuse numbers, free points excepted, that no row sees, and those of contact and shear where a symmetric crack only
    opens."""
    for each in problem.parameters:
        scenes = [problem.repeated[i].scene for i in each.scenes]
        if each.key.split(".")[-1] in _OF_SHEAR and all(map(_only_opens, scenes)):
            raise _unseen(each.key)
    moved = np.zeros(len(problem.parameters))
    for i, data in enumerate(problem.data):
        moved = np.maximum(moved, abs(problem.slopes(i, evaluation)).max(axis=0) / data.peak)
    for each, size in zip(problem.parameters, moved, strict=True):
        if size < _UNSEEN and ".softening.points." not in each.key:  # of these the direction that is not seen is named
            raise _unseen(each.key)


def _only_opens(scene: Scene) -> bool:
    """Whether the crack of a scene lies in its plane of symmetry and opens all the time."""
    targets = [target for stage in scene.stages for target in stage.targets]
    grows = len({stage.control for stage in scene.stages}) == 1 and bool(np.all(np.diff([0.0, *targets]) > 0))
    return grows and scene.specimen.symmetry() is not None and not any(stage.unload for stage in scene.stages)


def _unseen(key: str) -> SceneError:
    return SceneError(
        f"{key}: the test does not see it, changed by its own size it moves no load by .1 % of the peak. Contact, its lengths "
        "and the shear of the damage surface are not identifiable from a crack that only opens; expected a test with "
        "unloading or shear, or this key left out",
        key,
    )


def _starts(problem: FitProblem, count: int) -> list[Array]:
    """The scaled numbers from which a fit is started."""
    if not 1 <= count <= _MOST_STARTS:
        raise SceneError(f"starts = {count}: expected at least 1 and at most {_MOST_STARTS}", "starts")
    starts = [inside(problem.parameters, problem.start)]
    if count > 1:
        from scipy.stats import qmc  # slow to import

        low, high = np.array([each.bounds for each in problem.parameters]).T
        sample = qmc.LatinHypercube(len(low), seed=1).random(count - 1)
        starts += [inside(problem.parameters, z) for z in low + sample * (high - low)]
    return starts


def weighed_minima(problem: FitProblem, starts: Sequence[Array]) -> list[Minimum]:
    """The distinct minima, the best one first, with the rows weighed by the noise that the best one shows."""
    distinct = minima(problem, starts)
    for _ in range(_WEIGHINGS):
        if not problem.weigh(problem.evaluate(distinct[0].z)):
            break
        distinct = sorted((_again(problem, one) for one in distinct), key=lambda one: one.cost)
    return distinct


def minima(problem: FitProblem, starts: Sequence[Array]) -> list[Minimum]:
    """The distinct minima, the best one first."""
    distinct: list[Minimum] = []
    middle = np.array([each.bounds for each in problem.parameters]).mean(axis=1)
    for start in starts:
        solved = minimize(problem, start, strict=True)
        for _ in range(_PULLS):  # towards a start that runs
            if solved is not None:
                break
            start = 0.5 * (start + (middle if start is starts[0] else starts[0]))
            solved = minimize(problem, start, strict=True)
        if solved is None:
            continue
        twins = [one for one in distinct if abs(one.z - solved[0]).max() < _DISTINCT]
        distinct = [one for one in distinct if one not in twins]
        best = min([_minimum(problem, *solved, starts=0), *twins], key=lambda one: one.cost)
        distinct.append(replace(best, starts=1 + sum(one.starts for one in twins)))
    if not distinct:
        solved = minimize(problem, starts[0])
        if solved is None:
            raise SceneError("no start of the fit runs; expected other bounds")
        distinct.append(_minimum(problem, *solved, starts=0))
    return sorted(distinct, key=lambda one: one.cost)


def _again(problem: FitProblem, one: Minimum) -> Minimum:
    """A minimum with the weights that the rows have now."""
    solved = minimize(problem, inside(problem.parameters, one.z))
    if solved is None:
        return one
    return replace(_minimum(problem, *solved, starts=one.starts), evaluations=one.evaluations + solved[2])


def _minimum(problem: FitProblem, z: Array, cost: float, evaluations: int, starts: int) -> Minimum:
    return Minimum(z, cost, problem.by_name(z), problem.rms(problem.evaluate(z)), evaluations, starts)


def minimize(
    problem: FitProblem, start: Array, fixed: int | None = None, most: int = _MOST, ftol: float = _FTOL, strict: bool = False
) -> tuple[Array, float, int] | None:
    """The minimum next to a start: numbers, sum of squares, evaluations.

    None if the start does not run; if `strict` also if the descent ends where it leads on: at numbers with which there is no
    run, or a snap.

    Parameters
    ----------
    fixed : index of a number that stays as it is.
    """
    from scipy.optimize import least_squares  # slow to import

    free = np.array([j for j in range(len(start)) if j != fixed])
    low, high = np.array([problem.parameters[j].bounds for j in free]).reshape(-1, 2).T
    whole = np.array(start, dtype=float)

    def at(z: Array) -> Array:
        full = whole.copy()
        full[free] = z
        return full

    if not np.isfinite(problem.residuals(whole)).all():
        return None
    if not len(free):
        return whole, cost_of(problem, problem.residuals(whole)), 1
    room = 1e-6 * (high - low)
    solution = least_squares(
        lambda z: problem.residuals(at(z)),
        np.clip(whole[free], low + room, high - room),
        jac=lambda z: problem.jacobian(at(z))[:, free],
        bounds=(low, high),
        loss="soft_l1" if problem.loss == "soft_l1" else "linear",
        f_scale=_OUTLIER,
        xtol=_XTOL,
        ftol=ftol,
        gtol=1e-10,
        max_nfev=most,
    )
    if strict and is_stuck(solution.fun, solution.jac[:, solution.active_mask == 0]):
        return None
    return at(solution.x), 2.0 * float(solution.cost), int(solution.nfev)


def is_stuck(residuals: Array, jacobian: Array) -> bool:
    """Whether a descent ended though it leads on: at numbers with which there is no run, or at a snap."""
    if float(np.mean(residuals**2)) < _NOTHING or not jacobian.size:
        return False
    step = np.linalg.lstsq(jacobian, -residuals, rcond=1e-8)[0]
    step *= min(1.0, _FAR / max(float(abs(step).max()), 1e-300))  # beyond that nothing is linear
    left = residuals + jacobian @ step
    return float(left @ left) < (1.0 - _STUCK) * float(residuals @ residuals)


def cost_of(problem: FitProblem, residuals: Array) -> float:
    """The sum of squares that is minimised."""
    if problem.loss != "soft_l1":
        return float(residuals @ residuals)
    return float(_OUTLIER**2 * 2.0 * (np.sqrt(1.0 + (residuals / _OUTLIER) ** 2) - 1.0).sum())


def violation(problem: FitProblem, evaluation: FitEvaluation) -> float:
    """Sum of the squares of the distances from the bounds, 0 if every row lies inside."""
    rows = list(zip(evaluation.loads, problem.data, strict=True))
    if all(data.inside(load) == len(load) for load, data in rows):
        return 0.0
    return float(sum(np.square(data.gap(load)[0]).sum() for load, data in rows))


def _intervals(problem: FitProblem, evaluation: FitEvaluation, statistics: Statistics, profile: bool) -> tuple[str, Array]:
    """Kind and scaled ends of the intervals."""

    def refit(j: int, fixed: float, near: Array) -> tuple[Array, float]:
        start = inside(problem.parameters, near)
        start[j] = fixed
        solved = minimize(problem, start, fixed=j, most=3 if feasible else _MOST_FIXED, ftol=1e-3)
        if solved is None:
            return start, np.inf
        if feasible:
            return solved[0], violation(problem, problem.evaluate(solved[0]))
        return solved[0], solved[1]

    feasible = problem.loss == "band" and violation(problem, evaluation) == 0.0
    if feasible:
        return "feasible", feasible_ends(problem, evaluation.z, refit)
    in_band = any(data.loss == "band" for data in problem.data)
    if in_band and not (profile and statistics.count > len(evaluation.z)):
        return "unknown", np.full((len(evaluation.z), 2), np.nan)
    if profile:
        cost = cost_of(problem, evaluation.residuals)
        return "profile", profile_ends(problem, evaluation.z, cost, statistics, refit)
    return "covariance", covariance_ends(problem, evaluation.z, statistics)
