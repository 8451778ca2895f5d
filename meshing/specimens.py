"""Parametric plane specimens, meshed with their crack path inserted. Lengths in mm, angles in degrees."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from .base import PlaneSpecimen, at_least_zero, expect, positive
from .outline import Outline
from .paths import Line, Point


@dataclass(frozen=True)
class NotchedBeam(PlaneSpecimen):
    """A beam on two supports with a notch in its lower face, loaded at mid-span from above.

    Origin at mid-span on the lower face; x along the beam, y upwards. Point sets: `support_left`,
    `support_right`, `load`, `gauge_plus` (left of the notch) and `gauge_minus`.

    Parameters
    ----------
    length, span, depth, thickness : of the beam.
    notch : depth of the notch.
    notch_position : of the notch, from mid-span.
    notch_width : 0 for a slit without width.
    gauge : distance between the two points on the lower face that measure the opening; 0: mean jump over the crack.
    crack : polyline (or list of polylines) of the crack; default: from the notch tip straight up.
    """

    length: float
    span: float
    depth: float
    thickness: float
    notch: float
    notch_position: float = 0.0
    notch_width: float = 0.0
    gauge: float = 0.0
    crack: Any = None

    def __post_init__(self) -> None:
        positive(self, "length", "span", "depth", "thickness")
        at_least_zero(self, "notch", "notch_width", "gauge")
        expect(self, "span", self.span <= self.length, f"at most length = {self.length:g}")
        expect(self, "notch", self.notch < self.depth, f"less than depth = {self.depth:g}")
        expect(self, "gauge", self.gauge < self.length - 2 * abs(self.notch_position), "both gauge points on the beam")
        reach = abs(self.notch_position) + self.notch_width / 2
        expect(self, "notch_position", reach < self.span / 2, f"the notch between the supports, span = {self.span:g}")
        if self.gauge:
            expect(self, "gauge", self.gauge > self.notch_width, f"more than notch_width = {self.notch_width:g}")
        object.__setattr__(self, "crack", polylines(self.crack))

    @property
    def paths(self) -> list[Line]:
        """The crack path."""
        x = self.notch_position
        return self.crack or [[(x, self.notch), (x, self.depth)]]

    @property
    def tips(self) -> list[Point]:
        """The end of the notch."""
        return [(self.notch_position, self.notch)] if self.notch else []

    @property
    def is_symmetric(self) -> bool:
        """Whether the half on the plus side of the crack may stand for the whole."""
        return self.notch_position == 0.0 and not self.crack

    def outline(self, half: bool = False) -> Outline:
        """The geometry, of the left half if so wanted."""
        a, b, x, w = self.length / 2, self.depth, self.notch_position, self.notch_width / 2
        if half:
            corners: list[Point] = [(-a, 0.0), (-w, 0.0), (-w, self.notch), (0.0, self.notch), (0.0, b), (-a, b)]
            points: dict[str, Sequence[Point]] = {"support_left": [(-self.span / 2, 0.0)], "load": [(0.0, b)]}
            if self.gauge:
                points["gauge_plus"] = [(-self.gauge / 2, 0.0)]
            return Outline(_without_repeats(corners), self.paths, (), points, half=True)
        outline: list[Point] = [(a, 0), (a, b), (-a, b), (-a, 0)]
        slits: list[Line] = []
        if self.notch and self.notch_width:
            outline += [(x - w, 0), (x - w, self.notch), (x + w, self.notch), (x + w, 0)]
        elif self.notch:
            slits = [[(x, 0.0), (x, self.notch)]]
        nodes: dict[str, Sequence[Point]] = {
            "support_left": [(-self.span / 2, 0.0)],
            "support_right": [(self.span / 2, 0.0)],
            "load": [(0.0, b)],
        }
        if self.gauge:
            nodes |= {"gauge_plus": [(x - self.gauge / 2, 0.0)], "gauge_minus": [(x + self.gauge / 2, 0.0)]}
        return Outline(outline, self.paths, slits, nodes)


@dataclass(frozen=True)
class NotchedTension(PlaneSpecimen):
    """A plate with notches at mid-length, pulled between two rigid platens.

    Origin in the centre; x across the plate, y along the pull. Point sets: `base`, `top` and the gauge
    points on both edges, `gauge_minus` below and `gauge_plus` above.

    Parameters
    ----------
    length, width, thickness : of the plate; length is measured along the pull.
    notch : depth of each notch.
    notches : "double" (from both edges) or "single" (from the left edge).
    notch_width : 0 for slits without width.
    gauge : length over which the opening is measured, mean of both edges; 0: mean jump over the crack.
    platens : "fixed" (they do not turn) or "hinged" (each turns about the centre of its face). Between hinged platens the
        even opening of a symmetric plate is an unstable equilibrium, from which only a path that is not symmetric departs.
    crack : polyline (or list of polylines) of the crack; default: straight through the ligament.
    """

    length: float
    width: float
    thickness: float
    notch: float
    notches: str = "double"
    notch_width: float = 0.0
    gauge: float = 0.0
    platens: str = "fixed"
    crack: Any = None

    def __post_init__(self) -> None:
        positive(self, "length", "width", "thickness")
        at_least_zero(self, "notch", "notch_width", "gauge")
        expect(self, "platens", self.platens in ("fixed", "hinged"), "'fixed' or 'hinged'")
        expect(self, "notches", self.notches in ("single", "double"), "'single' or 'double'")
        depth = self.notch * (2 if self.notches == "double" else 1)
        expect(self, "notch", depth < self.width, f"a ligament to be left of width = {self.width:g}")
        expect(self, "notch_width", self.notch_width < self.length, f"less than length = {self.length:g}")
        if self.gauge:
            inside = self.notch_width < self.gauge < self.length
            expect(self, "gauge", inside, f"between notch_width = {self.notch_width:g} and length = {self.length:g}")
        object.__setattr__(self, "crack", polylines(self.crack))

    @property
    def paths(self) -> list[Line]:
        """The crack path."""
        right = self.width / 2 - (self.notch if self.notches == "double" else 0.0)
        return self.crack or [[(-self.width / 2 + self.notch, 0.0), (right, 0.0)]]

    @property
    def tips(self) -> list[Point]:
        """The ends of the notches."""
        x = self.width / 2 - self.notch
        return ([(-x, 0.0), (x, 0.0)] if self.notches == "double" else [(-x, 0.0)]) if self.notch else []

    @property
    def is_symmetric(self) -> bool:
        """Whether the half on the plus side of the crack may stand for the whole."""
        return not self.crack and self.platens == "fixed"

    @property
    def _gauge_at(self) -> tuple[float, float]:
        """Where across the plate the opening is measured."""
        return -self.width / 2, self.width / 2

    def outline(self, half: bool = False) -> Outline:
        """The geometry, of the upper half if so wanted."""
        a, b, w = self.width / 2, self.length / 2, self.notch_width / 2
        tip = a - self.notch
        both = self.notches == "double"
        if half:
            right = tip if both else a
            corners = [(-a, w), (-tip, w), (-tip, 0.0), (right, 0.0), (right, w if both else 0.0), (a, w if both else 0.0)]
            corners += [(a, b), (-a, b)]
            points = {"gauge_plus": [(x, self.gauge / 2) for x in self._gauge_at]} if self.gauge else {}
            edge = {"top": ((-a, b), (a, b))}
            return Outline(_without_repeats(corners), self.paths, (), points, edge, half=True)
        outline: list[Point] = [(-a, -b), (a, -b)]
        if self.notch and w and both:
            outline += [(a, -w), (tip, -w), (tip, w), (a, w)]
        outline += [(a, b), (-a, b)]
        if self.notch and w:
            outline += [(-a, w), (-tip, w), (-tip, -w), (-a, -w)]
        slits: list[Line] = [[(-a, 0.0), (-tip, 0.0)], [(tip, 0.0), (a, 0.0)]]
        if w or not self.notch:
            slits = []
        elif not both:
            slits = slits[:1]
        g = self.gauge / 2
        nodes: dict[str, Sequence[Point]] = {}
        if g:
            nodes = {"gauge_minus": [(x, -g) for x in self._gauge_at], "gauge_plus": [(x, g) for x in self._gauge_at]}
        return Outline(outline, self.paths, slits, nodes, {"base": ((-a, -b), (a, -b)), "top": ((-a, b), (a, b))})


@dataclass(frozen=True)
class MixedModePlate(NotchedTension):
    """A plate with deep notches from both edges whose top platen moves along and across it.

    As `NotchedTension`, but the gauge points lie at the notch tips, and stages may give the direction of the platen:
    Jefferson and Mihai (2015), Example 3. Between hinged platens no shear force is in equilibrium.
    """

    is_symmetric = False

    def __post_init__(self) -> None:
        super().__post_init__()
        expect(self, "notches", self.notches == "double", "'double'")

    @property
    def _gauge_at(self) -> tuple[float, float]:
        return -self.width / 2 + self.notch, self.width / 2 - self.notch


@dataclass(frozen=True)
class SingleCrack(PlaneSpecimen):
    """A rectangular block with one crack through its centre, moved at its top face.

    Origin in the centre, before `rotation` turns the whole. Point sets: `base`, `top`, one corner of
    the base (`base_corner`) and, with a gauge, `gauge_minus` and `gauge_plus` on the crack's normal.

    Parameters
    ----------
    width, height, thickness : of the block.
    angle : between the crack and the base, above -90 and at most 90.
    crack_length : None: through the whole block; else a crack with both tips inside.
    drive_angle : between the motion of the top face and its outer normal: 0 pulls, 90 shears, 180 pushes.
    faces : "free" (base and top move freely across the drive, but for one corner of the base) or "clamped".
    rotation : turns the block, its supports and its drive.
    gauge : length over which the opening is measured across the crack's centre; 0: mean jump over the crack.
    crack : polyline (or list of polylines) in the block's axes, instead of angle and crack_length.
    """

    width: float
    height: float
    thickness: float
    angle: float = 0.0
    crack_length: float | None = None
    drive_angle: float = 0.0
    faces: str = "free"
    rotation: float = 0.0
    gauge: float = 0.0
    crack: Any = None

    def __post_init__(self) -> None:
        positive(self, "width", "height", "thickness")
        at_least_zero(self, "gauge")
        expect(self, "angle", -90 < self.angle <= 90, "above -90 and at most 90 degrees")
        expect(self, "faces", self.faces in ("free", "clamped"), "'free' or 'clamped'")
        if self.crack_length is not None:
            through = math.dist(*self._through())
            expect(self, "crack_length", 0 < self.crack_length < through, f"above 0 and below {through:g}")
        expect(self, "gauge", self.gauge < min(self.width, self.height), "less than width and height")
        object.__setattr__(self, "crack", polylines(self.crack))

    def _through(self) -> tuple[Point, Point]:
        t = math.radians(self.angle)
        reach = min(
            self.width / 2 / abs(math.cos(t)) if abs(math.cos(t)) > 1e-12 else math.inf,
            self.height / 2 / abs(math.sin(t)) if abs(math.sin(t)) > 1e-12 else math.inf,
        )
        x, y = reach * math.cos(t), reach * math.sin(t)
        return (-x, -y), (x, y)

    def turned(self, x: float, y: float) -> Point:
        """A point or direction of the block's axes in space."""
        c, s = math.cos(math.radians(self.rotation)), math.sin(math.radians(self.rotation))
        return (c * x - s * y, s * x + c * y)

    @property
    def paths(self) -> list[Line]:
        """The crack path, in space."""
        ends = self._through()
        scale = 1.0 if self.crack_length is None else self.crack_length / math.dist(*ends)
        lines: list[Line] = self.crack or [[(scale * x, scale * y) for x, y in ends]]
        return [[self.turned(*p) for p in line] for line in lines]

    @property
    def normal(self) -> Point:
        """Unit normal of the straight crack, in space, towards its plus side."""
        t = math.radians(self.angle)
        return self.turned(-math.sin(t), math.cos(t))

    is_symmetric = False

    def outline(self, half: bool = False) -> Outline:
        """The geometry; there is no half of it."""
        a, b, g = self.width / 2, self.height / 2, self.gauge / 2
        corners = [self.turned(*p) for p in ((-a, -b), (a, -b), (a, b), (-a, b))]
        nodes: dict[str, Sequence[Point]] = {"base_corner": [corners[0]]}
        if g:
            n = self.normal
            nodes |= {"gauge_minus": [(-g * n[0], -g * n[1])], "gauge_plus": [(g * n[0], g * n[1])]}
        edges = {"base": (corners[0], corners[1]), "top": (corners[3], corners[2])}
        return Outline(corners, self.paths, (), nodes, edges)


@dataclass(frozen=True)
class SandwichPanel(PlaneSpecimen):
    """A rectangular panel with a layer that cracks across its mid-height, clamped between two rigid platens.

    The layer of cracking material between two elastic blocks of Jefferson and Mihai (2015), Example 1; the paper prints
    no dimensions. Origin in the centre, x along the layer. Point sets: `base` and `top`. There is no gauge.

    Parameters
    ----------
    width, height, thickness : of the panel.
    """

    width: float
    height: float
    thickness: float

    def __post_init__(self) -> None:
        positive(self, "width", "height", "thickness")

    @property
    def paths(self) -> list[Line]:
        """The crack path."""
        return [[(-self.width / 2, 0.0), (self.width / 2, 0.0)]]

    # not keys of a scene: the opening is the mean jump over the crack
    gauge = 0.0
    is_symmetric = False

    def outline(self, half: bool = False) -> Outline:
        """The geometry; there is no half of it."""
        a, b = self.width / 2, self.height / 2
        corners: list[Point] = [(-a, -b), (a, -b), (a, b), (-a, b)]
        edges = {"base": (corners[0], corners[1]), "top": (corners[3], corners[2])}
        return Outline(corners, self.paths, edges=edges)


@dataclass(frozen=True)
class PushOff(SandwichPanel):
    """A block that is sheared along a plane at its mid-height, with bars that restrain its opening.

    Jefferson and Mihai (2015), Example 4, in the plane: `width` is the length of the shear plane.

    Parameters
    ----------
    width, height, thickness : of the block.
    restraint : stiffness of the bars across the plane, N/mm; they act from the first stage with hold = false on.
    """

    restraint: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        at_least_zero(self, "restraint")


def polylines(crack: Any) -> list[Line]:
    """A polyline, or a list of them, as a list of polylines; ValueError for anything else."""
    if crack is None:
        return []
    try:
        nested = isinstance(crack[0][0], (list, tuple))
        lines = [[(float(x), float(y)) for x, y in line] for line in (crack if nested else [crack])]
        if all(math.isfinite(c) for line in lines for p in line for c in p):
            return list(lines)
    except (TypeError, ValueError, IndexError, KeyError):
        pass
    raise ValueError(f"crack = {crack!r}: expected a list of points [[x, y], [x, y], ...], or a list of such lists")


def _without_repeats(corners: list[Point]) -> list[Point]:
    return [p for p, before in zip(corners, [corners[-1], *corners[:-1]], strict=True) if p != before]
