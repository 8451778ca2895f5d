"""Names that a scene gives to gauges, controls and columns: checked against what the specimen has."""

from __future__ import annotations

import difflib
import reprlib
from collections.abc import Iterable, Sequence
from typing import Any

from meshing.specimens.base import MAIN_GAUGE

from ..errors import SceneError
from ..solver.columns import COLUMN_NAMES, LOAD_RATIO, Column, unloaded, watched
from ..solver.controls import CONTROLS
from ..solver.stages import Stage


def refuse(key: str, value: Any, expected: str) -> SceneError:
    """The error for a key whose value is not what was expected."""
    return SceneError.at(key, f" = {reprlib.repr(value)}: expected {expected}")


def hint(word: str, names: Iterable[str]) -> str:
    """What was meant by a misspelt word."""
    close = difflib.get_close_matches(str(word), list(names), 1)
    return f" (did you mean '{close[0]}'?)" if close else ""


def check_names(kind: str, gauges: Sequence[str], stages: Sequence[Stage], curve: Any, columns: Sequence[Column]) -> None:
    """Refuse names that mean something else, or nothing: of gauges, controls, quantities to watch, and columns to draw.

    Raises
    ------
    SceneError
        Naming the key, its value, and what there is.
    """
    for name in gauges:
        if name != MAIN_GAUGE and (name in COLUMN_NAMES or name == LOAD_RATIO or name in CONTROLS):
            raise SceneError.at(
                "specimen.gauges",
                f": a gauge of this {kind} is called '{name}', which every run has as a column or a control; "
                "expected another name",
            )
    controls = [*CONTROLS, *(name for name in gauges if name not in CONTROLS)]
    for i, stage in enumerate(stages):
        if stage.control not in controls:
            meant = f"one of {', '.join(controls)}{hint(stage.control, controls)}"
            raise refuse(f"stage.{i}.control", stage.control, meant)
        for key, event, names in (("until", stage.until, watched(columns)), ("unload", stage.unload, unloaded(columns))):
            for name in event or {}:
                if name not in names:
                    raise refuse(f"stage.{i}.{key}", event, f"a number for one of {', '.join(names)}{hint(name, names)}")
    drawn = [column.name for column in columns]
    given = curve if isinstance(curve, list) else []
    unknown = [name for name in given if name not in drawn]
    if curve is not None and (len(given) != 2 or unknown):
        near = hint(unknown[0], drawn) if unknown and isinstance(unknown[0], str) else ""
        raise refuse("output.curve", curve, f"two of {', '.join(drawn)}{near}")
