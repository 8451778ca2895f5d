"""Many runs of one scene over a grid of values, with one mesh and one condensation for what only changes the law."""

from __future__ import annotations

import itertools
import pickle
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, as_completed
from contextlib import nullcontext
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from meshing.errors import MeshError

from ..algebra.threads import cores
from ..errors import Interrupted, NotConverged, SceneError
from ..model.prepared import Prepared, is_kept, prepare
from ..outcome.result import Result
from ..results.files import make_folder, write_table, write_text
from ..scenes.reference import load_reference
from ..scenes.scene import Scene
from ..simulation import run
from .pool import workers as processes

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: runs of the largest grid
LARGEST = 10_000

#: units of the numbers of the table
_UNITS = {"peak": "N", "dissipated": "N mm", "seconds": "s"}


@dataclass(frozen=True)
class SweptRun:
    """One run of a sweep.

    Attributes
    ----------
    name : "run-07", also that of its folder
    values : what was changed, by key
    result : Result, as far as it came; None if it did not begin
    reason : why it did not come to its end; empty if it did
    """

    name: str
    values: dict[str, Any]
    result: Result | None
    reason: str

    @property
    def is_done(self) -> bool:
        """Whether it came to its end."""
        return not self.reason

    def numbers(self, measure: str) -> dict[str, float]:
        """The numbers of the table, with the place of the peak on a measure, a column of the history in mm."""
        names = ("peak", f"{measure}_at_peak", "dissipated", "energy_error", "iterations", "seconds")
        r = self.result
        if r is None or not r.steps:
            return dict.fromkeys(names, float("nan"))
        at = r.at_peak(r.history[measure])
        numbers = (r.peak_load, at, r.dissipated_energy, r.energy_error, r.iterations, r.solution_time)
        return dict(zip(names, map(float, numbers), strict=True))


@dataclass(frozen=True)
class Sweep:
    """Runs over a grid of values.

    Attributes
    ----------
    scene : Scene, which is varied
    vary : values by key
    runs : list of SweptRun, in the order of the grid, the last key fastest
    notes : what the reader should know of the sizes
    """

    scene: Scene
    vary: dict[str, list[Any]]
    runs: list[SweptRun]
    notes: list[str]

    @property
    def results(self) -> list[Result | None]:
        """Results in the order of the grid."""
        return [each.result for each in self.runs]

    @property
    def measure(self) -> str:
        """The measure in charge, as "opening" or "cmod": that of the first run whose measure all of them have."""
        begun = [each for each in self.results if each is not None]
        return next((one.controlled for one in begun if all(one.controlled in other.history for other in begun)), "opening")

    @property
    def table(self) -> dict[str, list[Any]]:
        """Columns: the varied keys; peak (N) and where it comes on the measure in charge, as opening_at_peak or cmod_at_peak
        (mm); dissipated (N mm), energy_error, iterations, seconds; and `reason`, empty for a run that came to its end."""
        columns: dict[str, list[Any]] = {key: [each.values[key] for each in self.runs] for key in self.vary}
        numbers = [each.numbers(self.measure) for each in self.runs]
        columns |= {name: [row[name] for row in numbers] for name in numbers[0]}
        return columns | {"reason": [each.reason for each in self.runs]}

    def summary(self) -> str:
        """The table in words, and the notes."""
        units = _UNITS | {f"{self.measure}_at_peak": "mm"}
        table = {name: column for name, column in self.table.items() if name != "reason"}
        head = ["run", *(f"{name} ({units[name]})" if name in units else name for name in table)]
        columns = (map(_text, column) for column in table.values())
        rows = [list(row) for row in zip((each.name for each in self.runs), *columns, strict=True)]
        width = [max(len(row[i]) for row in (head, *rows)) for i in range(len(head))]
        lines = ["  ".join(cell.rjust(w) for cell, w in zip(row, width, strict=True)) for row in (head, *rows)]
        reasons = [f"{each.name}: {each.reason}" for each in self.runs if each.reason]
        return "\n".join([*lines, *reasons, *self.notes])

    def plot(self) -> Figure:
        """All curves."""
        from .sweep_figure import sweep_figure  # with matplotlib, which is slow to import

        drawn = [
            (each.values, each.result, each.is_done) for each in self.runs if each.result is not None and each.result.steps
        ]
        return sweep_figure(self.scene, self.vary, self.measure, drawn)

    def save(self, folder: str | Path) -> None:
        """Write sweep.csv, sweep.txt and, if a run began, sweep.png; SceneError if the folder cannot be written."""
        folder, table = Path(folder), self.table
        make_folder(folder)
        rows = zip((each.name for each in self.runs), *(map(_exact, column) for column in table.values()), strict=True)
        write_table(folder / "sweep.csv", ["run", *table], rows)
        write_text(folder / "sweep.txt", self.summary() + "\n")
        if any(result is not None and result.steps for result in self.results):
            from ..figures.drawing import save, write_figure  # with matplotlib

            output = self.scene.output
            write_figure(folder / "sweep.png", partial(save, self.plot(), output=output, dpi=150), output)


@dataclass(frozen=True)
class _Task:
    """One run to be done in some process.

    Attributes
    ----------
    run : its name and values
    scene : Scene, or why there is none
    start : pickled Scene that is prepared for it and others like it; None: it has a mesh of its own
    folder : for its files, or None
    pictures : whether they are among them
    """

    run: SweptRun
    scene: Scene | str
    start: bytes | None
    folder: Path | None
    pictures: bool


def sweep(
    scene: Scene,
    vary: Mapping[str, Sequence[Any]],
    workers: int | None = None,
    *,
    executor: Executor | None = None,
    output: str | Path | None = None,
    pictures: bool = False,
    on_run: Callable[[SweptRun], None] | None = None,
) -> Sweep:
    """Run a scene with every combination of some values.

    Runs that differ in the law, the modulus and the stages only share a mesh, and the sizes that the scene does not name,
    which follow from its own material. A run that fails or stops does not end the sweep.

    Parameters
    ----------
    scene : Scene
    vary : values by dotted key, as {"material.Gf": [0.05, 0.1]}
    workers : processes; default: one for each core; 1: this one. A script that uses several calls this below
        `if __name__ == "__main__":`.
    executor : runs the scenes in place of these processes, as that of a Dask client does.
    output : folder for the files of each run, in subfolders; `Sweep.save` writes table and figure.
    pictures : whether they are drawn for each run, which takes longer than a small run.
    on_run : called after every run with it.

    Raises
    ------
    SceneError
        If no scene of the grid can be used.
    Interrupted
        With the runs that were finished, as a Sweep, in `result`.

    Examples
    --------
    >>> from cohesive import Scene, sweep
    >>> swept = sweep(Scene.load("notched-beam"), {"material.Gf": [0.08, 0.1]}, workers=1)
    >>> [each.is_done for each in swept.runs]
    [True, True]
    """
    values = _checked(vary)
    moved = [key for key in values if not is_kept(scene, key)]
    tasks = _tasks(scene, values, moved, None if output is None else Path(output), pictures)
    done: dict[str, SweptRun] = {}
    reference = load_reference(scene)
    notes = [] if reference is None else list(reference.notes)
    if len(moved) < len(values):
        apart = f" for each of {', '.join(moved)}" if moved else ""
        notes.insert(0, f"one mesh{apart}; sizes and widths that the scene does not name follow from its own material")

    def so_far() -> Sweep:
        left = (replace(task.run, reason="interrupted") for task in tasks)
        return Sweep(scene, values, [done.get(each.name, each) for each in left], notes)

    count = min(cores() if workers is None else workers, len(tasks))
    try:
        outcomes = _here(tasks) if executor is None and count == 1 else _elsewhere(tasks, count, executor)
        for each in outcomes:
            done[each.name] = each
            if on_run is not None:
                on_run(each)
    except KeyboardInterrupt as error:
        interrupted = Interrupted(*error.args)
        interrupted.result = so_far()
        raise interrupted from error
    return so_far()


def _checked(vary: Mapping[str, Sequence[Any]]) -> dict[str, list[Any]]:
    """Values by key, refused if there are none or too many."""
    values = {key: list(each) for key, each in vary.items()}
    count = 1
    for key, each in values.items():
        if not each:
            raise SceneError(f"{key}: no values to vary; expected at least one", key)
        count *= len(each)
    if not values or count > LARGEST:
        raise SceneError(f"a sweep of {count if values else 'no'} runs: expected keys with values, and at most {LARGEST} runs")
    return values


def _tasks(scene: Scene, values: dict[str, list[Any]], moved: list[str], folder: Path | None, pictures: bool) -> list[_Task]:
    """The runs of the grid; keys that are `moved` ask for a mesh of their own."""
    points = [dict(zip(values, each, strict=True)) for each in itertools.product(*values.values())]
    starts: dict[str, bytes | None] = {}
    tasks, errors = [], []
    for number, point in enumerate(points, start=1):
        name = f"run-{number:0{len(str(len(points)))}d}"
        where = None if folder is None else folder / name
        own = {key: point[key] for key in moved}
        try:
            if repr(own) not in starts:
                starts[repr(own)] = None
                if len(moved) < len(values):
                    starts[repr(own)] = pickle.dumps(scene.with_(**own))
            one: Scene | str = scene.with_(**point)
        except (SceneError, MeshError) as error:
            one = str(error)
            errors.append(error)
        tasks.append(_Task(SweptRun(name, point, None, ""), one, starts[repr(own)], where, pictures))
    if len(errors) == len(tasks):
        raise errors[0]
    return tasks


def _here(tasks: list[_Task]) -> Iterator[SweptRun]:
    """Run in this process, those with a common mesh one after the other."""
    try:
        yield from map(_done, sorted(tasks, key=lambda task: task.start or b""))
    finally:
        _prepared.cache_clear()


def _elsewhere(tasks: list[_Task], count: int, executor: Executor | None) -> Iterator[SweptRun]:
    """Run in other processes; yield the runs as they end."""
    with processes(count) if executor is None else nullcontext(executor) as pool:
        ordered = sorted(tasks, key=lambda task: task.start or b"")
        # a cluster need not see the folders of this machine
        futures = {pool.submit(_done, task if executor is None else replace(task, folder=None)): task for task in ordered}
        try:
            for future in as_completed(futures):
                each = future.result()
                yield _saved(each, futures[future]) if executor is not None else each
        finally:
            for future in futures:
                future.cancel()


def _done(task: _Task) -> SweptRun:
    """A run that has been done, whatever became of it."""
    if isinstance(task.scene, str):
        return replace(task.run, reason=task.scene)
    result, reason = None, ""
    try:
        result = run(task.scene, None if task.start is None else _prepared(task.start), output=task.folder)
    except (NotConverged, SceneError, MeshError) as error:
        result, reason = getattr(error, "result", None), str(error)
    except Exception as error:  # one run of many: its row says so
        reason = f"{type(error).__name__}: {error}"
    each = replace(task.run, result=result if isinstance(result, Result) else None, reason=reason)
    return _saved(each, task)


def _saved(each: SweptRun, task: _Task) -> SweptRun:
    """A run whose files are written, or its reason tells why not."""
    if task.folder is None or each.result is None:
        return each
    try:
        each.result.save(task.folder, task.pictures)
    except SceneError as error:
        return replace(each, reason=each.reason or str(error))
    return each


@lru_cache(maxsize=1)
def _prepared(start: bytes) -> Prepared:
    """Mesh and condensation of a scene, kept in this process for the runs to come."""
    return prepare(pickle.loads(start))


def _text(value: Any) -> str:
    return f"{value:.5g}" if isinstance(value, float) else str(value)


def _exact(value: Any) -> str:
    return f"{value:.12g}" if isinstance(value, float) else str(value)
