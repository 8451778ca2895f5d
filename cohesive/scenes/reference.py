"""The measured curves that a scene names, as its run can be compared with them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from ..errors import SceneError
from ..measured.curve import Measured, Reference
from ..measured.reading import read_measured
from .scene import Scene
from .tables import ReferenceOptions

#: keys of [reference] that `read_measured` takes as they are
_PASSED_ON = ("x", "y", "x_unit", "y_unit", "block", "sheet", "y_offset", "rows", "from_load", "toe", "smooth")


def load_reference(scene: Scene) -> Reference | None:
    """The measured curves that the scene names.

    Raises
    ------
    SceneError
        As `read_measured`; naming the key, if the run has no column to compare with.
    """
    options = scene.reference
    if options is None:
        return None
    motions = _motions_of(scene)
    if scene.specimen.has_main_gauge and options.against is None:  # it is the clip gauge of the test
        motions = [motion for motion in motions if motion != "cmod"]
    if options.against is not None:
        _check_motion(options.against, motions)
    against, curves = options.against, []
    for each in options.each:
        curves.append(read_with(each, scene.file(each.files[0]), against, motions, scene.specimen.crack_area))
        against = curves[0].against  # the first file says it for all
    return Reference(options.label, curves[0].against, tuple(curves))


def read_with(
    options: ReferenceOptions, path: Path, against: str | None, motions: Sequence[str], crack_area: float | None
) -> Measured:
    """A file by the keys of [reference], which name this one."""
    offset = options.x_offset[0] if isinstance(options.x_offset, list) else options.x_offset
    given = {name: getattr(options, name) for name in _PASSED_ON}
    return read_measured(path, **given, against=against, motions=motions, crack_area=crack_area, x_offset=offset)


def reference_to(scene: Scene, measured: Measured, default: str) -> Reference:
    """A measured curve as the reference of a scene; `default` is what its x is if nobody said."""
    is_main = measured.against == "cmod" and scene.specimen.has_main_gauge
    curve = replace(measured, against="opening" if is_main else measured.against or default)
    _check_motion(curve.against, _motions_of(scene))
    return Reference(curve.name, curve.against, (curve,))


def _motions_of(scene: Scene) -> list[str]:
    """Columns of the history that a measured x may be, those in mm."""
    return [column.name for column in scene.columns if column.unit == "mm"]


def _check_motion(against: str, motions: Sequence[str]) -> None:
    if against not in motions:
        raise SceneError.at(
            "reference.against", f" = {against!r}: expected a column of the history in mm: {', '.join(motions)}"
        )
