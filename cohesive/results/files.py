"""The files of a run: each is written under a temporary name and then renamed, but the history, which grows by rows."""

from __future__ import annotations

import csv
import json
import os
import platform
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import asdict
from functools import partial
from importlib import metadata
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import ParameterError, SceneError
from ..law.softening_choice import softening_data
from ..scenes.scene import dump_toml
from .agreement import agreement_facts
from .frames import frame_mesh, write_frame
from .measures import curve_measures
from .report import summary

if TYPE_CHECKING:
    from ..scenes.scene import Scene
    from .run_data import RunData


#: pictures of a run, but for those of a search for crack paths
PICTURES = ("mesh.png", "curve.png", "deformed.png")

#: what a result is read back from, with scene.toml
RESULT = "result.npz"

#: folder of the copies of a run's inputs
INPUTS = "inputs"

#: all files of a run but its frames, its inputs and its checkpoint
FILES = (*PICTURES, "path.png", "path.csv", "history.csv", RESULT, "frames.pvd", "run.json", "scene.toml")


@contextmanager
def history_writer(folder: str | Path | None, names: Sequence[str]) -> Iterator[Callable[[dict[str, float]], None]]:
    """What appends a row to history.csv, whose columns have some names; without a folder it writes nothing.

    Raises
    ------
    SceneError
        If the folder cannot be written, or the disk is full; a row is then written whole or not at all.
    """
    if folder is None:
        yield lambda row: None
        return
    path = Path(folder) / "history.csv"
    make_folder(path.parent)
    check_names(path.parent)
    try:
        path.unlink(missing_ok=True)  # it may be a link to elsewhere
        file = open(path, "xb", buffering=0)  # noqa: SIM115  closed below
    except OSError as error:
        raise _refused(path, error) from None

    def append(cells: Sequence[str]) -> None:
        rest = (",".join(cells) + "\n").encode()
        whole = file.tell()
        try:
            while rest:  # one call, unless the disk is getting full
                rest = rest[file.write(rest) :]
        except OSError as error:
            with suppress(OSError):
                file.truncate(whole)
            raise _refused(path, error) from None

    with closing(file):
        append(names)
        yield lambda row: append([repr(row[name]) for name in names])  # with all digits


def make_folder(folder: Path) -> None:
    """Create the output folder; SceneError if it cannot be written."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise SceneError(f"output folder '{folder}': cannot be written: {error.strerror}") from None


def write_file(path: Path, write: Callable[[Path], object]) -> None:
    """Let `write` fill a temporary file beside `path`, then rename it: nothing is ever half-written."""
    temporary = path.with_name(f".{path.stem}.partial{path.suffix}")
    try:
        temporary.unlink(missing_ok=True)  # it may be a link to elsewhere
        write(temporary)
        os.replace(temporary, path)
    except OSError as error:
        raise _refused(path, error) from None
    finally:
        with suppress(OSError):  # whatever was in the way of writing
            temporary.unlink(missing_ok=True)


def _refused(path: Path, error: OSError) -> SceneError:
    return SceneError(f"'{path}': cannot be written: {error.strerror or error}")


def package_version(name: str) -> str:
    """Version of an installed package, or that it is not installed."""
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "not installed"


def write_text(path: Path, text: str) -> None:
    """Write UTF-8 text, whole."""
    write_file(path, lambda temporary: temporary.write_text(text, encoding="utf-8"))


def write_table(path: Path, names: Iterable[str], rows: Iterable[Iterable[object]], comment: str = "") -> None:
    """Write a CSV table with a heading, whole; a comment is a line before it."""
    text = StringIO()
    if comment:
        text.write(f"# {comment}\n")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(names)
    writer.writerows(rows)
    write_text(path, text.getvalue())


def write_history(data: RunData, folder: Path) -> None:
    """history.csv, whole."""
    rows = zip(*(values.tolist() for values in data.history.values()), strict=True)
    write_table(folder / "history.csv", data.history, (map(repr, row) for row in rows))


def write_scene(scene: Scene, data: Mapping[str, Any], folder: Path) -> None:
    """scene.toml, which runs from there: `data` are those of the scene with the names of the copied files; SceneError if the
    material has a softening curve that no file can hold."""
    try:
        softening_data(scene.material.softening)
    except ParameterError as error:
        raise SceneError(f"material.{error}", "material.softening") from None
    write_text(folder / "scene.toml", dump_toml(data))


def frame_files(folder: Path) -> list[Path]:
    """The frames of an earlier run."""
    return [path for path in folder.glob("frame_*.vtu") if path.stem.removeprefix("frame_").isdigit()]


def remove(folder: Path, names: Sequence[str]) -> None:
    """Without these files of an earlier run."""
    for name in names:
        (folder / name).unlink(missing_ok=True)


def check_names(folder: Path) -> None:
    """Refuse a folder in which something stands in the way of a run's files; SceneError."""
    for path in (*(folder / name for name in FILES), *frame_files(folder)):
        if os.path.isdir(path):
            raise SceneError(f"output folder '{folder}': {path.name} is a folder; expected a file of this name, or none")
    if os.path.islink(folder / INPUTS):
        raise SceneError(f"output folder '{folder}': {INPUTS} is a link to elsewhere; expected a folder of this name, or none")


def write_frames(data: RunData, folder: Path) -> None:
    """Frames as VTU with one PVD, in place of those of an earlier run.

    The time of a frame is the motion of the drive, which counts on where it turns: times must rise.
    """
    for old in (*frame_files(folder), folder / "frames.pvd"):
        old.unlink(missing_ok=True)
    collection, time, digits = [], -1.0, max(4, len(str(data.steps)))
    for row in data.frame_rows():
        frame = data.frame(row)
        name = f"frame_{frame.step:0{digits}d}.vtu"
        mesh = frame_mesh(data.fields, frame, data.scene.model.plane == "strain")
        write_file(folder / name, partial(write_frame, mesh=mesh))
        time = max(float(data.drive_travel[row]), time + 1e-9 * max(float(data.drive_travel[-1]), 1e-300))
        collection.append(f'    <DataSet timestep="{time:.12g}" part="0" file="{name}"/>')
    if collection:
        pvd = '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n  <Collection>\n'
        pvd += "\n".join(collection) + "\n  </Collection>\n</VTKFile>\n"
        write_text(folder / "frames.pvd", pvd)


def write_run(data: RunData, folder: Path) -> None:
    """run.json: the scene, what came out, what it took, and the versions of what it ran with."""
    energies = ("work", "elastic", "stored", "dissipated", "contact_work", "released")
    packages = ("cohesive-cracks", "numpy", "scipy", "gmsh", "meshio", "matplotlib")
    facts = {
        "scene": data.scene.data,
        "notes": data.notes,
        "summary": summary(data).splitlines(),
        "peak_load": data.peak_load,
        "opening_at_peak": data.opening_at_peak,
        "dissipated_energy": data.dissipated_energy,
        "curve": curve_measures(data),
        "energies": {name: float(data.history[name][-1]) for name in energies} if data.steps else {},
        "full_energy": data.full_energy,
        "energy_error": data.energy_error,
        "model": data.scene.model.kind,
        **asdict(data.facts),
        "steps": data.steps,
        "iterations": data.iterations,
        "timings": data.timings,
        "reference": agreement_facts(data.reference, data.history, data.peak_load),
        "versions": {"python": platform.python_version()} | {name: package_version(name) for name in packages},
    }
    write_text(folder / "run.json", json.dumps(facts, indent=2, default=repr) + "\n")
