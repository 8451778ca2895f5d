"""The outcome of a run as its user sees it."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import meshio
import numpy as np

from ..errors import SceneError
from ..results.crushing import looked_at
from ..results.fields import Fields
from ..results.files import PICTURES, check_names, make_folder, remove, write_frames, write_history, write_run, write_scene
from ..results.frames import frame_mesh
from ..results.inputs import copy_inputs
from ..results.model_facts import ModelFacts
from ..results.off_path import off_path
from ..results.report import summary
from ..results.run_data import RunData, spread
from ..results.saved import read_folder, write_result
from .notebook import html_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..growth.found import FoundPath
    from ..measured.curve import Reference
    from ..model.model import Model
    from ..results.fields import Frame
    from ..results.record import Record
    from ..scenes.scene import Scene


class Result(RunData):
    """The outcome of a run: its data (see `RunData`), a summary in words, and its files."""

    @classmethod
    def from_run(
        cls,
        scene: Scene,
        model: Model,
        record: Record,
        notes: list[str],
        seconds: float,
        reference: Reference | None,
        found: FoundPath | None,
    ) -> Result:
        """The result of a run that has ended or stopped: what it keeps of the model and the states.

        Parameters
        ----------
        seconds : that the march took
        """
        own, states = record.history, record.states
        history = {column.name: own.get(column.name, np.zeros(0)) for column in model.columns}
        needed: set[int] = set()
        if len(states):
            looked = looked_at(history["load"], history["stress_n"])
            rows = [*looked, *spread(len(states) - 1, max(scene.output.frames, 1)), len(states) - 1]
            needed = {states.nearest(row) for row in rows}
        result = cls(
            scene,
            history,
            record.drive_travel,
            notes,
            model.timings | {"newton": seconds, "output": 0.0},
            ModelFacts.from_run(scene, model, states[-1] if len(states) else None),
            Fields.from_run(model, states, sorted(needed)),
            reference,
            found,
        )
        result.off_path = off_path(result)
        result.notes += [] if result.off_path is None else [result.off_path.sentence]
        return result

    def frame_mesh(self, frame: Frame) -> meshio.Mesh:
        """Bulk and crack cells with the fields of a frame; warp by `displacement` to see the crack open."""
        return frame_mesh(self.fields, frame, self.scene.model.plane == "strain")

    def summary(self) -> str:
        """The printed summary."""
        return summary(self)

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the curve, that of curve.png, into axes (default: new ones of pyplot), and return them."""
        from ..figures.drawing import draw_curve  # with matplotlib, which is slow to import

        axes = _new_axes() if ax is None else ax
        draw_curve(axes, self)
        return axes

    def plot_deformed(self, ax: Axes | None = None, row: int = -1) -> Axes:
        """Draw the deformed body in a row of the history into axes (default: new ones of pyplot), and return them.

        Raises
        ------
        ValueError
            If the body is solid and the axes are not 3D.
        LookupError
            If the fields of this row were not kept.
        """
        from ..figures.body import draw_deformed  # with matplotlib

        self.frame(row)  # before a figure is made
        axes = _new_axes(is_solid=self.fields.mesh.dimension == 3) if ax is None else ax
        draw_deformed(axes, self, row)
        return axes

    def to_frame(self) -> Any:
        """The history as a table of pandas, one row each; units of its columns are in `attrs["units"]`.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        try:
            import pandas
        except ImportError:
            raise ImportError("Result.to_frame needs pandas: pip install pandas") from None
        table = pandas.DataFrame(self.history)
        table.attrs["units"] = {name: self.unit_of(name) for name in self.history}
        return table

    def _repr_html_(self) -> str:
        """What a notebook shows."""
        return html_of(self)

    @classmethod
    def load(cls, folder: str | Path) -> Result:
        """The result that `save` wrote into a folder: equal to it, but that its scene names the copies of the files.

        Raises
        ------
        SceneError
            If a file is missing or broken.
        """
        return cls(**read_folder(Path(folder)))

    def save(self, folder: str | Path, pictures: bool = True) -> None:
        """Write history.csv, result.npz, mesh.png, curve.png, deformed.png, frames as VTU with one PVD, scene.toml and
        run.json, copies of the files that the scene names in inputs, and path.csv and path.png, if the crack path was looked
        for.

        Each file is written under a temporary name and then renamed. Pictures and frames of an earlier run into the same
        folder are replaced. A picture that cannot be drawn is left out, and a note says why.

        Parameters
        ----------
        pictures : whether mesh, curve and deformed body are drawn, which takes most of the time after a small run.

        Raises
        ------
        SceneError
            If the folder cannot be written, a folder has the name of a file, or scene.toml cannot hold a softening curve
            that is not registered; all other files are there then.
        """
        from ..figures.found_path import write_found  # with matplotlib, which is slow to import

        clock = time.perf_counter()
        folder = Path(folder)
        make_folder(folder)
        check_names(folder)
        failed = None
        try:  # first: a measured file may be the history of an earlier run into this folder
            copied = copy_inputs(self.scene, folder, [each.content for each in self.measured])
        except SceneError as error:  # which does not cost the results
            failed, copied = error, self.scene.data
        write_history(self, folder)
        if pictures:
            from ..figures.pictures import write_pictures

            self.notes += [note for note in write_pictures(self, folder) if note not in self.notes]
        else:
            remove(folder, PICTURES)
        write_frames(self, folder)
        write_found(self, folder)
        self.timings["output"] = time.perf_counter() - clock
        write_run(self, folder)
        write_result(self, folder)
        write_scene(self.scene, copied, folder)  # last: a curve of the user's own may not be saved
        if failed is not None:
            raise failed


def _new_axes(is_solid: bool = False) -> Axes:
    """Axes of pyplot, which a notebook or a window shows."""
    from matplotlib import pyplot

    figure = pyplot.figure(figsize=(7.5, 6.0) if is_solid else (6.4, 4.4), layout="constrained")
    axes: Axes = figure.add_subplot(projection="3d", proj_type="ortho") if is_solid else figure.add_subplot()
    return axes
