"""The columns of the history: the one list that the file, the figures, the reference page and the stages take them from."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Column:
    """One column of the history.

    Attributes
    ----------
    name : key of `result.history`, heading in history.csv.
    unit : "mm", "N", "MPa", "N mm", "s"; empty for a number without unit.
    meaning : a phrase for the reference page.
    watched : whether a stage's `until` may name it.
    unloaded : whether a stage's `unload` may name it.
    """

    name: str
    unit: str
    meaning: str
    watched: bool = False
    unloaded: bool = False


COLUMNS = (
    Column("step", "", "number of the converged step; 0 before the first one"),
    Column("load", "N", "force along the motion of the drive that the stage moves", watched=True, unloaded=True),
    Column(
        "opening",
        "mm",
        "normal motion between the points of the main gauge; of a specimen without one the mean jump over the crack",
        watched=True,
        unloaded=True,
    ),
    Column("sliding", "mm", "tangential motion between the same points, or its mean", watched=True, unloaded=True),
    Column(
        "driven",
        "mm",
        "motion of the drive that the stage moves, on which the load does its work",
        watched=True,
        unloaded=True,
    ),
    Column("stress_n", "MPa", "mean normal traction on the crack", watched=True, unloaded=True),
    Column("stress_s", "MPa", "mean shear traction on the crack", watched=True, unloaded=True),
    Column("work", "N mm", "work of all loads so far", watched=True),
    Column("elastic", "N mm", "elastic energy of the bulk, and of the specimen's springs", watched=True),
    Column("stored", "N mm", "energy stored on the cracks, given back on unloading", watched=True),
    Column("dissipated", "N mm", "energy that damage has dissipated so far", watched=True),
    Column("contact_work", "N mm", "work of the contact tractions so far", watched=True),
    Column("released", "N mm", "energy that snaps of the crack have set free so far"),
    Column("cohesive_length", "mm", "length of the crack path that is damaged and keeps more than 1 % of ft"),
    Column(
        "effective_length",
        "mm",
        "length of the crack without tractions, notch included, that gives the body its secant compliance (of cmod, else "
        "opening, else driven, over load); nan if there is not one notch, one straight or kinked path from it and one drive",
    ),
    Column("iterations", "", "iterations of Newton's method in the step"),
    Column("cuts", "", "how often the step was cut before it converged"),
    Column("residual", "", "residual of the step, relative to its forces"),
    Column("wall_time", "s", "time since the first step began"),
    Column("stage", "", "number of the stage, the first is 1"),
)

COLUMN_NAMES = tuple(column.name for column in COLUMNS)

#: the load over the largest load so far: `until` may watch it, though it is no column
LOAD_RATIO = "load_ratio"


def columns_of(
    gauges: Iterable[str], drives: Sequence[str] = (), forces: Iterable[str] = (), of_law: Mapping[str, str] | None = None
) -> tuple[Column, ...]:
    """All columns of a run: those of every run, one for each further gauge and force, of several drives two for each, and one
    for each quantity of the law's own, given with its unit."""
    motions = (Column(name, "mm", f"motion that the gauge {name} measures", True, True) for name in gauges)
    further = [column for column in motions if column.name not in COLUMN_NAMES]
    further += [Column(name, "N", f"{name.replace('_', ' ')}, in proportion to the load", True, True) for name in forces]
    for name in drives if len(drives) > 1 else ():
        further.append(Column(f"load.{name}", "N", f"force of the drive {name}", True, True))
        further.append(Column(f"driven.{name}", "mm", f"motion of the drive {name}", True, True))
    further += [Column(f"law.{name}", unit, f"mean of {name} over the crack", True) for name, unit in (of_law or {}).items()]
    return (*COLUMNS, *further)


def watched(columns: Iterable[Column]) -> tuple[str, ...]:
    """What `until` may watch."""
    return (*(column.name for column in columns if column.watched), LOAD_RATIO)


def unloaded(columns: Iterable[Column]) -> tuple[str, ...]:
    """What `unload` may go back to."""
    return tuple(column.name for column in columns if column.unloaded)
