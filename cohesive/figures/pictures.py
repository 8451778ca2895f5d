"""The pictures among a run's files. One that cannot be drawn is reported; the run continues."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import SceneError
from ..results.files import PICTURES
from .body import save_deformed
from .drawing import save_curve, write_figure
from .mesh import save_mesh

if TYPE_CHECKING:
    from ..results.run_data import RunData


def write_pictures(data: RunData, folder: Path) -> list[str]:
    """mesh.png, curve.png and deformed.png; without a converged step the first one only. Those of an earlier run go.

    Returns
    -------
    notes : a sentence for each picture that could not be drawn

    Raises
    ------
    SceneError
        If a file cannot be written.
    """
    notes = []
    mesh = partial(save_mesh, data.scene, data.fields.mesh, off_path=data.off_path)
    draws = mesh, partial(save_curve, data), partial(save_deformed, data)
    for name, draw in zip(PICTURES, draws, strict=True):
        path = folder / name
        if not data.steps and name != "mesh.png":
            path.unlink(missing_ok=True)
            continue
        try:
            write_figure(path, draw, data.scene.output)
        except SceneError:
            raise
        except Exception as error:  # whatever a title, a label or a mesh brings about: the numbers are worth more
            path.unlink(missing_ok=True)
            notes.append(f"warning: {name} could not be drawn: {type(error).__name__}: {error}")
    return notes
