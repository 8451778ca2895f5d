"""The measured curves that a scene names, as its run can be compared with them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from ..errors import SceneError
from ..measured.curve import Measured, Reference
from ..measured.reading import read_measured
from ..solver.columns import columns_of
from .scene import Scene
from .tables import ReferenceOptions


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
    if options.against is not None and options.against not in motions:
        raise SceneError(
            f"reference.against = {options.against!r}: expected a column of the history in mm: {', '.join(motions)}",
            "reference.against",
        )
    against, curves = options.against, []
    for name in options.files:
        curves.append(read_with(options, scene.file(name), against, motions, scene.specimen.crack_area))
        against = curves[0].against  # the first file says it for all
    return Reference(options.label, curves[0].against, tuple(curves))


def read_with(
    options: ReferenceOptions, path: Path, against: str | None, motions: Sequence[str], crack_area: float | None
) -> Measured:
    """A file by the keys of [reference]."""
    return read_measured(
        path, options.x, options.y, options.x_unit, options.y_unit, against, motions=motions, crack_area=crack_area
    )


def reference_to(scene: Scene, measured: Measured, default: str) -> Reference:
    """A measured curve as the reference of a scene; `default` is what its x is if nobody said."""
    is_main = measured.against == "cmod" and scene.specimen.has_main_gauge
    curve = replace(measured, against="opening" if is_main else measured.against or default)
    if curve.against not in (motions := _motions_of(scene)):
        raise SceneError(
            f"reference.against = {curve.against!r}: expected a column of the history in mm: {', '.join(motions)}",
            "reference.against",
        )
    return Reference(curve.name, curve.against, (curve,))


def _motions_of(scene: Scene) -> list[str]:
    """Columns of the history that a measured x may be, those in mm."""
    every = columns_of(scene.specimen.gauges(), list(scene.specimen.drives()))
    return [column.name for column in every if column.unit == "mm"]
