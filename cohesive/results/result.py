"""The outcome of a run as its user sees it."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import meshio
import numpy as np

from ..errors import SceneError
from ..scenes.reference import load_reference
from .files import PICTURES, check_names, make_folder, remove, write_frames, write_history, write_run, write_scene
from .frames import Frame, frame_mesh
from .inputs import copy_inputs
from .notebook import html_of
from .report import summary
from .run_data import RunData
from .saved import Saved, SavedStates

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class Result(RunData):
    """The outcome of a run: its data (see `RunData`), a summary in words, and its files. It can be pickled."""

    def frame_mesh(self, frame: Frame) -> meshio.Mesh:
        """Bulk and crack cells with the fields of a frame; warp by `displacement` to see the crack open."""
        return frame_mesh(self.model, frame, self.scene.model.plane == "strain")

    def summary(self) -> str:
        """The printed summary."""
        return summary(self) if self.told is None else self.told

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the curve, that of curve.png, into axes (default: new ones of pyplot), and return them."""
        from .figures import draw_curve  # with matplotlib, which is slow to import

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
            If the state of this row was not kept.
        """
        from .body_figures import draw_deformed  # with matplotlib

        self.states[row]  # before a figure is made
        axes = _new_axes(is_solid=self.model.mesh.dimension == 3) if ax is None else ax
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
        """The result that `save` wrote into a folder: scene, history, measured curves, numbers and summary.

        It draws its curve and gives its table. The mesh, the states and the equations are not among the files: what needs
        them is a LookupError or an AttributeError that says so.

        Raises
        ------
        SceneError
            If a file is missing or broken.
        """
        saved = Saved.read(Path(folder))
        loaded = cls.__new__(cls)
        facts = saved.facts
        loaded.__dict__.update(
            scene=saved.scene, model=saved.model, history=saved.history, notes=facts["notes"], found=None,
            reference=load_reference(saved.scene), timings=facts["timings"], states=SavedStates(len(saved.history["step"])),
            way=np.array(facts["way"] or []), _displacements={}, _added_compliance=facts["added_compliance"],
            _initial_stiffness={facts["curve"].get("over"): facts["curve"].get("initial_stiffness")},
            told="\n".join(facts["summary"]), warned=None,
        )  # fmt: skip
        return loaded

    def save(self, folder: str | Path, pictures: bool = True) -> None:
        """Write history.csv, mesh.png, curve.png, deformed.png, frames as VTU with one PVD, scene.toml and run.json, copies
        of the files that the scene names in inputs, and path.csv and path.png, if the crack path was looked for.

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
        from .path_files import write_found  # with matplotlib, which is slow to import

        if self.told is not None:
            raise ValueError("a result that was loaded from its folder is not written again; expected a copy of its folder")
        clock = time.perf_counter()
        folder = Path(folder)
        make_folder(folder)
        check_names(folder)
        failed = None
        try:  # first: a measured file may be the history of an earlier run into this folder
            measured = () if self.reference is None else self.reference.curves
            copied = copy_inputs(self.scene, folder, [each.content for each in measured])
        except SceneError as error:  # which does not cost the results
            failed, copied = error, self.scene.data
        write_history(self, folder)
        if pictures:
            from .pictures import write_pictures

            self.notes += [note for note in write_pictures(self, folder) if note not in self.notes]
        else:
            remove(folder, PICTURES)
        write_frames(self, folder)
        write_found(self, folder)
        self.timings["output"] = time.perf_counter() - clock
        write_run(self, folder)
        write_scene(self.scene, copied, folder)  # last: a curve of the user's own may not be saved
        if failed is not None:
            raise failed


def _new_axes(is_solid: bool = False) -> Axes:
    """Axes of pyplot, which a notebook or a window shows."""
    from matplotlib import pyplot

    figure = pyplot.figure(figsize=(7.5, 6.0) if is_solid else (6.4, 4.4), layout="constrained")
    axes: Axes = figure.add_subplot(projection="3d", proj_type="ortho") if is_solid else figure.add_subplot()
    return axes
