"""Names of gauges, and those that stages give: checked against what the specimen has."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from meshing.specimens.base import MAIN_GAUGE

from ..errors import SceneError
from ..solver.columns import COLUMN_NAMES, LOAD_RATIO, columns_of, unloaded, watched
from ..solver.controls import CONTROLS
from ..solver.stages import Stage
from .checks import hint, refuse


def check_gauge_names(kind: str, names: Sequence[str]) -> None:
    """Refuse a gauge whose name means something else in the history or in a stage.

    Raises
    ------
    SceneError
    """
    for name in names:
        if name != MAIN_GAUGE and (name in COLUMN_NAMES or name == LOAD_RATIO or name in CONTROLS):
            raise SceneError(
                f"specimen.gauges: a gauge of this {kind} is called '{name}', which every run has as a column or a control; "
                "expected another name",
                "specimen.gauges",
            )


def check_curve(curve: Any, gauges: Sequence[str], drives: Sequence[str], forces: Sequence[str]) -> None:
    """Refuse a curve that is not two columns of the history.

    Raises
    ------
    SceneError
    """
    names = [column.name for column in columns_of(gauges, drives, forces)]
    given = curve if isinstance(curve, list) else []
    unknown = [name for name in given if name not in names]
    if curve is not None and (len(given) != 2 or unknown):
        near = hint(unknown[0], names) if unknown and isinstance(unknown[0], str) else ""
        raise refuse("output.curve", curve, f"two of {', '.join(names)}{near}")


def check_stage_names(stages: Sequence[Stage], gauges: Sequence[str], drives: Sequence[str], forces: Sequence[str]) -> None:
    """Refuse a control, or a quantity to watch, that neither every run nor this specimen has.

    Raises
    ------
    SceneError
        Naming the key, its value, and what there is.
    """
    columns = columns_of(gauges, drives, forces)
    controls = [*CONTROLS, *(name for name in gauges if name not in CONTROLS)]
    for i, stage in enumerate(stages):
        if stage.control not in controls:
            meant = f"one of {', '.join(controls)}{hint(stage.control, controls)}"
            raise refuse(f"stage.{i}.control", stage.control, meant)
        for key, event, names in (("until", stage.until, watched(columns)), ("unload", stage.unload, unloaded(columns))):
            for name in event or {}:
                if name not in names:
                    raise refuse(f"stage.{i}.{key}", event, f"a number for one of {', '.join(names)}{hint(name, names)}")
