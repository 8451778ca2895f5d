"""A plane body of the user's own geometry, with its notches, supports and drive."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from typing import Any, ClassVar

import meshio

from ..errors import MeshError
from ..files.geo import read_outline, read_step
from ..generation.outline import Outline
from ..generation.sizes import MeshSizes
from ..keys import key
from ..paths import Line, Point, contains, signed_area
from .base import MAIN_GAUGE, Gauge, Location, PlaneSpecimen, polylines
from .registry import register_specimen
from .user_entries import StatedSetup, unit_vector

#: straight sides in place of a circle, as in place of a curved side of a .geo file
_SIDES = 24


@register_specimen("outline")
@dataclass(frozen=True)
class OwnOutline(StatedSetup, PlaneSpecimen):
    """A plane body of the user's own geometry.

    A location is the name of a part of the outline, or a point [x, y] of the body, which becomes a node.
    """

    thickness: float = key("thickness of the body", unit="mm", above=0)
    supports: Any = key("list of {at = location, direction = [x, y]}, as of kind 'mesh'")
    corners: Any = key("corners of the body in a row, [[x, y], ...]; or give file or step", None)
    file: str | None = key(
        "file of gmsh (.geo) with one face, with or without holes, whose curved sides become 24 straight ones each; its "
        "physical curves and points are locations",
        None,
    )
    step: str | None = key(
        "STEP file with one face in the plane z = 0, with or without holes, curved sides as in file; its lengths become mm "
        "from the unit that it states",
        None,
    )
    holes: Any = key("holes of the body: list of polygons [[x, y], ...] and circles {center = [x, y], radius = r}", None)
    edges_: Any = key("{name = [[x, y], [x, y]]}: straight parts of the outline that are locations", None)
    points_: Any = key("{name = [[x, y], ...]}: points of the body that are locations and become nodes", None)
    notches: Any = key(
        "polyline, or list of polylines, of notches without width; cracks grow from their ends in the body", None
    )
    drive: Any = key("{at = location, direction = [x, y]}, as of kind 'mesh'", None)
    drives_: Any = key("instead of drive, several: list of {name = ..., at = location, direction = [x, y]}", None)
    gauge_minus: Any = key(
        "location from which the opening is measured, between points along the line from one to the other, else along the "
        "crack's mean normal; default: the mean jump over the crack",
        None,
    )
    gauge_plus: Any = key("location to which the opening is measured", None)
    gauges_: Any = key("further gauges, as of kind 'mesh'", None)
    crack: Any = key("polyline (or list of polylines) of the crack, or 'grow'", None)

    #: the body alone, without notches
    shape: ClassVar[Outline | None] = None

    def __post_init__(self) -> None:
        super().__post_init__()
        files = {name: value for name, value in (("file", self.file), ("step", self.step)) if value is not None}
        if (self.corners is not None) + len(files) != 1:
            raise MeshError.at("corners", ", file, step: expected one of these keys")
        self.read_setup()
        object.__setattr__(self, "notches", [] if self.notches is None else _lines("notches", self.notches))
        object.__setattr__(self, "edges_", _named_lines("edges", self.edges_))
        object.__setattr__(self, "points_", _named_points(self.points_))
        for name, value in files.items():
            raise MeshError.at(name, f" = {value!r}: a scene reads it; expected corners")
        (corners,) = _lines("corners", [self.corners])
        object.__setattr__(self, "shape", Outline(_counter_clockwise(corners), [], holes=_holes(self.holes, corners)))

    @classmethod
    def without_script(cls, table: dict[str, Any], find: Callable[[str], Path], run_scripts: bool) -> dict[str, Any]:
        """Corners, edges and points in place of a .geo or a STEP file."""
        given = [name for name in ("corners", "file", "step") if table.get(name) is not None]
        if given not in (["file"], ["step"]) or not isinstance(name := table[given[0]], str):
            return table  # which is refused, if it does not do, by its keys
        shape = read_step(find(name)) if given == ["step"] else read_outline(find(name), run_scripts)
        return {key: value for key, value in table.items() if key != given[0]} | stated(shape, table)

    @property
    def paths(self) -> list[Line]:
        """The crack path; none before it is found."""
        return self.crack or []

    @property
    def path_length(self) -> float:
        """Length of the crack path; of one that is not found yet, half the longest side of the body, mm."""
        if self.paths:
            return super().path_length
        corners = self._outline().corners
        return 0.5 * max(max(p[i] for p in corners) - min(p[i] for p in corners) for i in (0, 1))

    @property
    def tips(self) -> list[Point]:
        """The ends of the notches in the body."""
        return [tip for tip, _ in self.starts]

    @property
    def starts(self) -> list[tuple[Point, Point]]:
        """The ends of the notches in the body, and the directions of the notches there."""
        shape, ends = self._outline(), []
        for line in self.notches:
            for (x0, y0), (x, y) in ((line[1], line[0]), (line[-2], line[-1])):
                if not shape.has_on_face((x, y)):
                    length = math.dist((x0, y0), (x, y))
                    ends.append(((x, y), ((x - x0) / length, (y - y0) / length)))
        return ends

    def outline(self, half: bool = False) -> Outline:
        """The geometry."""
        shape = self._outline()
        named = {*self.edges_, *self.points_}
        points = [at for at in self._locations() if not isinstance(at, str)]
        if unknown := sorted({at for at in self._locations() if isinstance(at, str)} - named):
            raise MeshError(f"at = '{unknown[0]}': expected one of {', '.join(sorted(named)) or 'edges'}, or a point", "edges")
        nodes = {**self.points_, "points": [(float(p[0]), float(p[1])) for p in points]}
        return replace(shape, crack=self.paths, slits=self.notches, nodes=nodes, edges=self.edges_)

    def _outline(self) -> Outline:
        """Of the body alone."""
        assert self.shape is not None
        return self.shape

    def _locations(self) -> Iterator[Location]:
        """All places that supports, drives and gauges name."""
        for support in self.supports:
            yield support.at
        for drive in self.drives_.values():
            yield from (at for at in (drive.at, drive.against) if at is not None)
        for gauge in self.gauges().values():
            yield from (at for at in (gauge.plus, gauge.minus) if at is not None)

    def mesh(self, sizes: MeshSizes, *, half: bool = False, dimension: int = 2) -> meshio.Mesh:
        """Mesh for a discrete crack, see `PlaneSpecimen`."""
        if not self.paths:
            raise MeshError.at("crack", " is missing: expected a polyline, or 'grow'")
        return super().mesh(sizes, half=half, dimension=dimension)

    def gauges(self, *, half: bool = False) -> Mapping[str, Gauge]:
        """As the keys `gauge_minus`, `gauge_plus` and `gauges` say."""
        if self.gauge_plus is None:
            return dict(self.gauges_)
        direction = None
        if not isinstance(self.gauge_plus, str) and not isinstance(self.gauge_minus, str):  # cracks may have no mean normal
            apart = [b - a for a, b in zip(self.gauge_minus, self.gauge_plus, strict=True)]
            direction = unit_vector("gauge_plus", apart)
        return {MAIN_GAUGE: Gauge(self.gauge_plus, self.gauge_minus, direction), **self.gauges_}


def stated(shape: Outline, table: Mapping[str, Any]) -> dict[str, Any]:
    """An outline as keys of a scene, with what a table says of holes, edges and points besides."""
    holes, edges, points = (table.get(name) or kind() for name, kind in (("holes", list), ("edges", dict), ("points", dict)))
    if not isinstance(holes, list) or not isinstance(edges, dict) or not isinstance(points, dict):
        return {"corners": _plain(shape.corners)}  # the keys are refused as they are
    keys = {
        "corners": _plain(shape.corners),
        "holes": [*map(_plain, shape.holes), *holes],
        "edges": {name: _plain(line) for name, line in shape.edges.items()} | edges,
        "points": {name: _plain(at) for name, at in shape.nodes.items()} | points,
    }
    return {key: value for key, value in keys.items() if value}


def _lines(name: str, value: Any) -> list[Line]:
    """Polylines; MeshError naming the key."""
    try:
        lines = polylines(value)
    except MeshError:
        lines = []
    if not lines or any(len(line) < 2 for line in lines):
        raise MeshError.at(name, f" = {value!r}: expected a list of points [[x, y], [x, y], ...]")
    return lines


def _holes(value: Any, corners: Line) -> list[Line]:
    """Polygons, and circles as polygons; MeshError unless their corners lie inside the body."""
    if value is not None and not isinstance(value, (list, tuple)):
        raise MeshError.at("holes", f" = {value!r}: expected a list of polygons and circles")
    holes = []
    for i, each in enumerate(value or []):
        try:
            if isinstance(each, Mapping):
                (x, y), r = each["center"], float(each["radius"])
                is_circle = set(each) == {"center", "radius"} and r > 0
                turns = [2 * math.pi * j / _SIDES for j in range(_SIDES)] if is_circle else []
                hole: Line = [(float(x) + r * math.cos(turn), float(y) + r * math.sin(turn)) for turn in turns]
            else:
                hole = [(float(x), float(y)) for x, y in each]
        except (KeyError, TypeError, ValueError):
            hole = []
        if len(hole) < 3 or not all(map(math.isfinite, chain.from_iterable(hole))) or not signed_area(hole):
            expected = "a polygon [[x, y], ...] or a circle {center = [x, y], radius = r}"
            raise MeshError.at(f"holes.{i}", f" = {each!r}: expected {expected}")
        if not all(contains(corners, point) for point in hole):
            raise MeshError.at(f"holes.{i}", f" = {each!r}: expected a hole inside the body")
        holes.append(_counter_clockwise(hole))
    return holes


def _named_lines(name: str, value: Any) -> dict[str, Line]:
    """{name = [[x, y], [x, y]]}"""
    if value is None:
        return {}
    if not isinstance(value, Mapping):
        raise MeshError.at(name, f" = {value!r}: expected {{name = [[x, y], [x, y]]}}")
    return {own: _lines(f"{name}.{own}", [line])[0] for own, line in value.items()}


def _named_points(value: Any) -> dict[str, Line]:
    """{name = [[x, y], ...]}"""
    try:
        points: dict[str, Line] = {name: [(float(x), float(y)) for x, y in at] for name, at in (value or {}).items()}
    except (AttributeError, TypeError, ValueError):
        points = {"": [(math.nan, math.nan)]}
    if not all(at and all(map(math.isfinite, chain.from_iterable(at))) for at in points.values()):
        raise MeshError.at("points", f" = {value!r}: expected {{name = [[x, y], ...]}}")
    return points


def _plain(points: Sequence[Point]) -> list[list[float]]:
    return [[float(x), float(y)] for x, y in points]


def _counter_clockwise(corners: Sequence[Point]) -> Line:
    """Corners the other way round, if they run clockwise."""
    return list(corners) if signed_area(corners) > 0 else list(corners)[::-1]
