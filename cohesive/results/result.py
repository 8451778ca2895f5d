"""The outcome of a run as its user sees it."""

from __future__ import annotations

import time
from pathlib import Path

import meshio

from ..errors import SceneError
from .files import make_folder, write_frames, write_history, write_run, write_scene
from .frames import Frame, frame_mesh
from .inputs import copy_inputs
from .report import summary
from .run_data import RunData


class Result(RunData):
    """The outcome of a run: its data (see `RunData`), a summary in words, and its files. It can be pickled."""

    def frame_mesh(self, frame: Frame) -> meshio.Mesh:
        """Bulk and crack cells with the fields of a frame; warp by `displacement` to see the crack open."""
        return frame_mesh(self.model, frame)

    def summary(self) -> str:
        """The printed summary."""
        return summary(self)

    def save(self, folder: str | Path) -> None:
        """Write history.csv, curve.png, deformed.png, frames as VTU with one PVD, scene.toml and run.json, copies of the files
        that the scene names in inputs, and path.csv and path.png, if the crack path was looked for.

        Each file is written under a temporary name and then renamed. Pictures and frames of an earlier run into the same
        folder are replaced.

        Raises
        ------
        SceneError
            If the folder cannot be written, or scene.toml cannot hold a softening curve that is not registered; all other
            files are there then.
        """
        from .figures import write_figures  # with matplotlib, which is slow to import
        from .path_files import write_found

        clock = time.perf_counter()
        folder = Path(folder)
        make_folder(folder)
        failed = None
        try:  # first: a measured file may be the history of an earlier run into this folder
            measured = () if self.reference is None else self.reference.curves
            copied = copy_inputs(self.scene, folder, [each.content for each in measured])
        except SceneError as error:  # which does not cost the results
            failed, copied = error, self.scene.data
        write_history(self, folder)
        write_figures(self, folder)
        write_frames(self, folder)
        write_found(self, folder)
        self.timings["output"] = time.perf_counter() - clock
        write_run(self, folder)
        write_scene(self.scene, copied, folder)  # last: a curve of the user's own may not be saved
        if failed is not None:
            raise failed
