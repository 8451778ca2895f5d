"""What every specimen can be meshed as, and the checks of their keys."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod

import meshio

from .band import mesh_band
from .errors import MeshError
from .outline import Outline
from .paths import Line, Point
from .polygon import mesh_body, mesh_polygon
from .sizes import MeshSizes


class Specimen(ABC):
    """What every specimen can be meshed as. Errors of the geometry are MeshErrors that name what is wrong."""

    @abstractmethod
    def mesh(self, sizes: MeshSizes, half: bool = False) -> meshio.Mesh:
        """Mesh for a discrete crack: crack cells along the path, as `insert_cracks` gives it."""

    @abstractmethod
    def mesh_band(self, sizes: MeshSizes, width: float) -> meshio.Mesh:
        """Mesh for a crack band of `width` (mm), one element wide along the path."""

    @abstractmethod
    def mesh_body(self, sizes: MeshSizes) -> meshio.Mesh:
        """Mesh for cracks that may form anywhere, fine near the path."""

    @abstractmethod
    def check_band(self, sizes: MeshSizes) -> None:
        """A MeshError that names the key, if these sizes give no crack band."""

    def is_off_the_notch(self) -> bool:
        """Whether there are notches, and no crack path begins or ends in one."""
        return False


class PlaneSpecimen(Specimen):
    """A specimen that is given by a plane body."""

    @property
    @abstractmethod
    def paths(self) -> list[Line]:
        """The crack path."""

    @property
    def tips(self) -> list[Point]:
        """Centres of the notches' ends."""
        return []

    def is_off_the_notch(self) -> bool:
        """Whether there are notches, and no crack path begins or ends in one."""
        reach = 1e-6 + getattr(self, "notch_width", 0.0) / 2
        ends = [p for line in self.paths for p in (line[0], line[-1])]
        return bool(self.tips) and all(math.dist(p, tip) > reach for p in ends for tip in self.tips)

    @abstractmethod
    def outline(self, half: bool = False) -> Outline:
        """The geometry, or one half of it."""

    def mesh(self, sizes: MeshSizes, half: bool = False) -> meshio.Mesh:
        """Mesh for a discrete crack: crack cells along the path, as `insert_cracks` gives it."""
        body = self.outline(half)
        return mesh_polygon(body.corners, body.crack, sizes, body.slits, body.nodes, body.edges, body.half)

    def mesh_band(self, sizes: MeshSizes, width: float) -> meshio.Mesh:
        """Mesh for a crack band of `width` (mm), one element wide along the path; see `meshing.band.mesh_band`."""
        return mesh_band(self.outline(), sizes, width)

    def check_band(self, sizes: MeshSizes) -> None:
        """All sizes give one."""

    def mesh_body(self, sizes: MeshSizes) -> meshio.Mesh:
        """Mesh for cracks that may form anywhere, fine near the path; see `meshing.plane.mesh_body`."""
        return mesh_body(self.outline(), sizes)


def expect(specimen: object, name: str, holds: bool, expected: str) -> None:
    """A MeshError that names a key, its value and what was expected, if the latter does not hold."""
    if not holds:
        raise MeshError(f"{name} = {getattr(specimen, name)!r}: expected {expected}")


def positive(specimen: object, *names: str) -> None:
    """A MeshError for a key that is not above 0."""
    for name in names:
        expect(specimen, name, getattr(specimen, name) > 0, "a number above 0")


def at_least_zero(specimen: object, *names: str) -> None:
    """A MeshError for a key that is below 0."""
    for name in names:
        expect(specimen, name, getattr(specimen, name) >= 0, "a number of at least 0")
