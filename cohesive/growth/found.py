"""What the search for crack paths finds."""

from __future__ import annotations

from dataclasses import dataclass, fields

from meshing.paths import Line


@dataclass(frozen=True)
class Vertex:
    """A point from which a found path goes on, as the last run sees it. Directions in degrees from the x axis.

    Attributes
    ----------
    crack : number of the crack, from 1
    x, y : mm
    direction : of the path from here
    criterion : direction that the criterion tells in the state in which the tip was critical here; nan: it was not critical
    principal : direction across the major principal stress ahead, in that state
    at_peak : direction that the stresses ahead tell at the largest load
    opening, load : in the state in which the tip was critical, mm, N
    fixed_direction : whether the direction before was kept, for the criterion means nothing here
    """

    crack: int
    x: float
    y: float
    direction: float
    criterion: float
    principal: float
    at_peak: float
    opening: float
    load: float
    fixed_direction: bool


#: columns of path.csv
VERTEX_COLUMNS = tuple(each.name for each in fields(Vertex))


@dataclass(frozen=True)
class FoundPath:
    """The outcome of a search.

    Attributes
    ----------
    lines : the path of each crack
    trials : the paths that were run on the way, each a list of lines
    vertices : of the found paths; none for a path that follows from symmetry
    faces, slits : outline of the body
    notes : for the reader of the results
    seconds : of the search
    """

    lines: list[Line]
    trials: list[list[Line]]
    vertices: list[Vertex]
    faces: list[Line]
    slits: list[Line]
    notes: list[str]
    seconds: float
