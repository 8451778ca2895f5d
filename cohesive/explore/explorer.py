"""A scene whose numbers are moved: each answer is a run on a mesh and a condensed stiffness that are kept."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from meshing.errors import MeshError

from ..arrays import Array
from ..errors import NotConverged, ParameterError, SceneError
from ..fitting.fit import fit
from ..law.softening import SOFTENING
from ..measured.curve import Reference
from ..model.prepared import Prepared, prepare
from ..outcome.result import Result
from ..results.measures import peak_text
from ..scenes.reference import load_reference
from ..scenes.scene import Scene, dump_toml
from ..simulation import run

#: numbers that have a slider, with the factors of its ends; a notch goes by the depth of its specimen
_NUMBERS = {"material.E": (0.5, 2.0), "material.ft": (0.4, 2.5), "material.Gf": (0.25, 4.0)}
_NOTCH, _NOTCH_ENDS = "specimen.notch", (0.1, 0.8)

#: numbers that `fit` varies
_FITTED = ("material.ft", "material.Gf")

#: meshes that are kept; the one that was used longest ago goes
_KEPT = 8

#: points of the softening curve
_POINTS = 100


@dataclass
class Explorer:
    """Answers what a page asks. It keeps nothing of who asked, so that two pages do not disturb each other.

    Attributes
    ----------
    scene : Scene, as it is given; frames are left out
    """

    scene: Scene
    _prepared: Callable[[Any], Prepared] = field(init=False, repr=False)  # by the notch; None: that of the scene

    def __post_init__(self) -> None:
        self.scene = self.scene.with_(**{"output.frames": 0})
        self._prepared = lru_cache(_KEPT)(lambda notch: prepare(self._changed({} if notch is None else {_NOTCH: notch})))

    def controls(self) -> dict[str, Any]:
        """What the page offers: numbers with their ends and start, and choices."""
        offered: dict[str, Any] = {}
        for key, (low, high) in _NUMBERS.items():
            value = getattr(self.scene.material, key.split(".")[1])
            offered[key] = {"low": low * value, "high": high * value, "start": value}
        specimen = self.scene.given("specimen")
        if isinstance(specimen.get("notch"), (int, float)) and isinstance(specimen.get("depth"), (int, float)):
            low, high = (part * specimen["depth"] for part in _NOTCH_ENDS)
            offered[_NOTCH] = {"low": low, "high": high, "start": specimen["notch"]}
        material = self.scene.given("material")
        softening = material.get("softening", "exponential")
        if isinstance(softening, str):
            offered["material.softening"] = {"choices": list(SOFTENING), "start": softening}
        offered["material.contact"] = {"choices": ["printed", "potential"], "start": material.get("contact", "printed")}
        return offered

    def answer(self, changes: Mapping[str, Any], over: str | None = None) -> dict[str, Any]:
        """Curve, crack profile at the peak and at the end, softening curve and numbers of a run with some keys changed; or
        `error`, one sentence, with what was computed before it if there is anything.

        Parameters
        ----------
        over : the column of the history, mm, that the curve is drawn over; default: the measure in charge.
        """
        clock, error, result = time.perf_counter(), "", None
        try:
            scene = self._changed(changes)
            result = run(scene, self._prepared(scene.given(_NOTCH) if _NOTCH in self.controls() else None))
        except NotConverged as stopped:
            error, result = str(stopped), stopped.result if isinstance(stopped.result, Result) else None
        except (SceneError, MeshError, ParameterError) as refused:
            return {"error": str(refused)}
        facts = {"error": error, "seconds": time.perf_counter() - clock}
        return facts | (_shown(result, over) if result is not None and result.steps else {})

    def toml(self, changes: Mapping[str, Any]) -> str:
        """The scene as a file."""
        return dump_toml(self._changed(changes, frames=True).data)

    def python(self, changes: Mapping[str, Any]) -> str:
        """The scene as lines of Python."""
        given = {key: value for key, value in changes.items() if key in self.controls()}
        return (
            "from cohesive import Scene, run\n\n"
            f"scene = Scene({self.scene.data!r})\nresult = run(scene.with_(**{given!r}))\nprint(result.summary())\n"
        )

    def measured(self, text: str | None = None, name: str = "") -> dict[str, Any]:
        """The measured curves as the page draws them, and the column of the history that they were measured over; or `error`.

        Parameters
        ----------
        text, name : of a file; default: what the scene names, and an empty dict if it names none.
        """
        try:
            reference = self._reference(text, name)
            if reference is None:
                return {}
            curves = [each.without_doubt() for each in reference.curves]
        except (SceneError, ParameterError) as refused:
            return {"error": str(refused)}
        drawn = [
            {"name": each.name, "x": _numbers(each.x), "low": _numbers(each.bounds[0]), "high": _numbers(each.bounds[1])}
            for each in curves
        ]
        notes = [f"{each.name}: {note}" for each in curves for note in each.notes]
        return {"over": reference.against, "curves": drawn, "notes": notes}

    def fitted(self, changes: Mapping[str, Any], text: str | None = None, name: str = "") -> dict[str, Any]:
        """ft and Gf that `fit` finds from the changed scene within the ends of their sliders, and its summary; or `error`.

        Parameters
        ----------
        text, name : of the measured file; default: what the scene names.
        """
        try:
            ends = {key: (self.controls()[key]["low"], self.controls()[key]["high"]) for key in _FITTED}
            fitted = fit(self._changed(changes), ends, reference=self._reference(text, name))
        except (SceneError, MeshError, ParameterError, NotConverged) as refused:
            return {"error": str(refused)}
        return {"values": fitted.values, "summary": fitted.summary()}

    def _reference(self, text: str | None, name: str) -> Reference | None:
        """The measured curves of a file with this text, or those of the scene."""
        if text is None:
            return load_reference(self.scene)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, Path(name).name or "measured.csv")
            path.write_text(text, encoding="utf-8")
            try:
                return load_reference(self.scene.with_(reference={"file": str(path)}))
            except SceneError as refused:
                raise SceneError(str(refused).replace(str(path), path.name), refused.key) from None

    def _changed(self, changes: Mapping[str, Any], frames: bool = False) -> Scene:
        offered = self.controls()
        if unknown := sorted(set(changes) - set(offered)):
            raise SceneError(f"{unknown[0]}: not a control of this page; expected one of {', '.join(offered)}", unknown[0])
        scene = self.scene.with_(**{"output.frames": 5}) if frames else self.scene
        return scene.with_(**changes)


def _shown(result: Result, over: str | None) -> dict[str, Any]:
    material, profiles = result.scene.material, {}
    w = np.linspace(0.0, min(float(material.curve.end), 5.0 * material.Gf / material.ft), _POINTS)
    for name, row in (("at the peak", result.peak_row), ("at the end", len(result.history["load"]) - 1)):
        _, opening = result.opening_profile(row)
        profiles[name] = [_numbers(result.profile_distance()), _numbers(opening)]
    over = over if over is not None and result.unit_of(over) == "mm" else result.controlled
    return {
        "over": over,
        "x": _numbers(result.history[over]),
        "load": _numbers(result.history["load"]),
        "profiles": profiles,
        "softening": [_numbers(w), _numbers(material.curve.stress(w))],
        "said": f"peak {peak_text(result, over)}, {result.iterations} iterations",
    }


def _numbers(values: Array) -> list[float]:
    return [float(f"{value:.5g}") for value in values.tolist()]
