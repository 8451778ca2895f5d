"""`fit_curves`: which softening curve a test asks for."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import SceneError
from ..law.softening import SOFTENING
from ..results.files import make_folder, write_table
from ..scenes.scene import Scene
from .data import effective_count
from .fit import fit
from .intervals import interval_words, sequences
from .parameters import OFFSET
from .result import Fit

#: bounds of the numbers of a kink, and where it starts
_KINK, _KINK_BOUNDS = [0.8, 0.3], {"material.softening.kink.0": (0.1, 1.7), "material.softening.kink.1": (0.03, 0.7)}

#: where free points start, between a steep branch and a tail: parts of ft, each falling over an opening in Gf/ft, of area 1
_BRANCHES = ((0.8, 0.4), (0.2, 3.4))

#: their first and last opening in Gf/ft, and by which factor openings and stresses may change
_FIRST, _LAST, _FACTOR = 0.3, 8.0, 3.0

#: free points of a curve: more than the rows of most measured curves determine none
_LEAST_POINTS, _MOST_POINTS = 3, 50

#: what follows from points
_OF_POINTS = ("material.ft", "material.Gf")

#: independent residuals that a number should have
_FOR_EACH = 3.0


@dataclass(frozen=True)
class CurveChoice:
    """Fits with several softening curves.

    Attributes
    ----------
    fits : {curve: Fit}
    table : list of dict, one for each curve: "curve", "numbers", "rms", "aic", "bic"; of a fit that meets a whole band both
        are -inf
    warnings : sentences
    """

    fits: dict[str, Fit]
    table: list[dict[str, Any]]
    warnings: list[str]

    @property
    def best(self) -> str:
        """The curve with the least AIC."""
        return str(min(self.table, key=lambda row: (row["aic"], row["numbers"]))["curve"])

    def summary(self) -> str:
        """The printed summary."""
        lines = [f"{'curve':<14}{'numbers':>8}{'rms %':>8}{'AIC':>9}{'BIC':>9}"]
        lines += [
            f"{row['curve']:<14}{row['numbers']:>8}{100 * row['rms']:>8.2f}{row['aic']:>9.1f}{row['bic']:>9.1f}"
            for row in self.table
        ]
        lines.append(f"least AIC: {self.best}")
        for name, one in self.fits.items():
            ends = "; ".join(
                f"{key.removeprefix('material.')} {value:.4g} ({interval_words(*one.intervals[key])})"
                for key, value in one.values.items()
            )
            lines.append(f"{name}: {ends}")
        return "\n".join(lines + self.warnings)

    def save(self, folder: str | Path) -> None:
        """Write curves.csv, curves.png, and the files of each fit into a folder of its own."""
        from ..figures.drawing import save, write_figure  # with matplotlib, which is slow to import
        from .figures import draw_choice

        folder = Path(folder)
        make_folder(folder)
        write_table(folder / "curves.csv", self.table[0], (row.values() for row in self.table))
        figure = draw_choice({name: (one.problem, one.best, one.scenes[0]) for name, one in self.fits.items()})
        output = self.fits[self.best].scenes[0].output
        write_figure(folder / "curves.png", lambda path: save(figure, path, output, dpi=150), output)
        for name, one in self.fits.items():
            one.save(folder / name.replace(":", "-"))


def fit_curves(
    scenes: Scene | Sequence[Scene], vary: Mapping[str, tuple[float, float]], curves: Sequence[str], **options: Any
) -> CurveChoice:
    """Fit with each of several softening curves.

    Parameters
    ----------
    scenes, vary : as in `fit`; the numbers of a curve are added
    curves : names of registered curves, "kink" with both its numbers free, or "points:4", 4 points with free
        openings and stresses, in place of ft and Gf
    options : as in `fit`

    Raises
    ------
    SceneError
        For a curve that is not known, and as in `fit`.
    """
    each = [scenes] if isinstance(scenes, Scene) else list(scenes)
    fits: dict[str, Fit] = {}
    for curve in curves:
        changed, bounds = _with_curve(each, vary, curve, list(fits.values()))
        fits[curve] = fit(changed, bounds, **options)
    count = min(effective_count(sequences(one.problem, one.best.residuals)) for one in fits.values())
    table = []
    for name, one in fits.items():
        m = len(one.values)
        mean = float(np.mean(np.square(one.best.residuals)))
        fits_all = one.interval_kind == "feasible" or mean == 0.0
        likelihood = -math.inf if fits_all else count * math.log(mean)
        row = {"curve": name, "numbers": m, "rms": one.rms, "aic": likelihood + 2.0 * m}
        table.append(row | {"bic": likelihood + math.log(max(count, 1.0)) * m})
    return CurveChoice(fits, table, _warnings(fits))


def _warnings(fits: Mapping[str, Fit]) -> list[str]:
    sentences = []
    for name, one in fits.items():
        m = len(one.values)
        if one.effective_rows < _FOR_EACH * m and one.interval_kind not in ("feasible", "unknown"):
            sentences.append(
                f"warning: {name} asks {m} numbers of residuals that are worth {one.effective_rows:.1f} independent ones; its "
                "intervals say what they are good for"
            )
    return sentences


def _with_curve(
    scenes: Sequence[Scene], vary: Mapping[str, tuple[float, float]], curve: str, done: Sequence[Fit]
) -> tuple[list[Scene], dict[str, tuple[float, float]]]:
    """Scenes with a curve, and what is varied."""
    kept = {key: bounds for key, bounds in vary.items() if not key.startswith("material.softening")}
    if curve == "kink":
        return [scene.with_(**{"material.softening": {"kink": list(_KINK)}}) for scene in scenes], kept | _KINK_BOUNDS
    name, _, number = curve.partition(":")
    if name == "points" and number in map(str, range(_LEAST_POINTS, _MOST_POINTS + 1)):
        return _with_points(scenes, kept, int(number), done)
    if curve in SOFTENING:
        return [scene.with_(**{"material.softening": curve}) for scene in scenes], kept
    raise SceneError(
        f"softening = {curve!r}: expected some of {', '.join(SOFTENING)}, kink, points:N with N from "
        f"{_LEAST_POINTS} to {_MOST_POINTS}",
        "softening",
    )


def _with_points(
    scenes: Sequence[Scene], vary: Mapping[str, tuple[float, float]], number: int, done: Sequence[Fit]
) -> tuple[list[Scene], dict[str, tuple[float, float]]]:
    """Scenes with free points, on the best curve so far."""
    best = min(done, key=lambda one: one.rms, default=None)
    known = {} if best is None else best.values
    carried = {key: known[key] for key in vary if key in known and key not in (*_OF_POINTS, OFFSET)}
    start = [scene.with_(**carried) for scene in scenes]
    material = (scenes[0] if best is None else best.scenes[0]).material
    ft, unit = float(material.ft), float(material.Gf) / float(material.ft)
    w = np.r_[0.0, np.geomspace(_FIRST, _LAST, number - 1)]
    stress = ft * sum(part * np.exp(-w / fall) for part, fall in _BRANCHES)
    points = [[float(a), float(b)] for a, b in zip(w * unit, stress, strict=True)]
    points[-1][1] = 0.0
    key = "material.softening.points"
    bounds = {k: b for k, b in vary.items() if k not in _OF_POINTS}
    bounds[f"{key}.0.1"] = vary.get("material.ft", (ft / _FACTOR, ft * _FACTOR))
    for i in range(1, number):
        bounds[f"{key}.{i}.0"] = (points[i][0] / _FACTOR, points[i][0] * _FACTOR)
        if i < number - 1:
            bounds[f"{key}.{i}.1"] = (points[i][1] / _FACTOR, points[i][1] * _FACTOR)
    changed = []
    for scene in start:
        data = {**scene.data, "material": {**scene.given("material"), "softening": {"points": points}}}
        for name in ("ft", "Gf"):
            data["material"].pop(name, None)
        changed.append(Scene(data, scene.folder))
    return changed, bounds
