"""gmsh: its session, geometry, element sizes, and the mesh as a meshio.Mesh."""

from __future__ import annotations

import ctypes
import math
import os
import signal
import threading
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise
from types import ModuleType

import meshio
import numpy as np

from ..arrays import Array, Index
from ..cells import CELLS, counter_clockwise
from ..errors import MeshError
from ..paths import Line, Point
from .refinement import LAST_AT_HINGE, halved
from .sizes import GROWTH, MeshSizes

#: growth in a mesh whose cells are divided afterwards: more would spoil their shapes
_MOST_GROWTH = 0.5

#: growth of the element size around a hinge
GROWTH_AT_HINGE = 0.8

#: meshio's name by gmsh's element number
_NAMES = {cell.gmsh: name for name, cell in CELLS.items() if cell.gmsh is not None}


#: gmsh has one state for the whole process
_ONE_AT_A_TIME = threading.RLock()

#: signals whose handlers gmsh replaces when it first starts, and room for one struct sigaction of any system
_REPLACED, _ROOM = ("SIGHUP", "SIGQUIT", "SIGFPE", "SIGPIPE", "SIGTERM"), 1024


def load_gmsh() -> ModuleType:
    """The gmsh module, or a MeshError with the install command if its system libraries are missing."""
    try:
        import gmsh
    except OSError as error:
        raise MeshError(
            f"gmsh needs system libraries that are missing here ({error}); on Debian or Ubuntu: "
            "apt-get install -y libgl1 libglu1-mesa libxcursor1 libxft2 libxinerama1 libgomp1"
        ) from None
    module: ModuleType = gmsh
    return module


@contextmanager
def session() -> Iterator[ModuleType]:
    """gmsh between its start and its end: quiet, on one thread, its errors as MeshErrors.

    gmsh has one state for the whole process: a second thread waits until the first is done.
    """
    gmsh = load_gmsh()
    with _ONE_AT_A_TIME:
        with _signals_kept():
            gmsh.initialize(readConfigFiles=False, interruptible=False)
        try:
            gmsh.option.setNumber("General.Verbosity", 0)
            gmsh.option.setNumber("General.NumThreads", 1)  # the same mesh on every machine
            yield gmsh
        except Exception as error:
            if type(error) is Exception:  # gmsh raises nothing more specific
                raise MeshError(f"gmsh cannot mesh this geometry: {error}") from None
            raise
        finally:
            gmsh.finalize()


@contextmanager
def _signals_kept() -> Iterator[None]:
    """The process's handlers of signals, which gmsh replaces, as they were: those that C code has set too, and in any thread,
    neither of which Python's own module can do."""
    sigaction = getattr(ctypes.CDLL(None), "sigaction", None) if os.name == "posix" else None
    if sigaction is None:
        yield
        return
    numbers = [getattr(signal, name) for name in _REPLACED]
    before = [ctypes.create_string_buffer(_ROOM) for _ in numbers]
    for number, action in zip(numbers, before, strict=True):
        sigaction(number, None, action)
    try:
        yield
    finally:
        for number, action in zip(numbers, before, strict=True):
            sigaction(number, action, None)


def add_face(
    gmsh: ModuleType, corners: Iterable[Sequence[float]], holes: Iterable[Iterable[Sequence[float]]] = ()
) -> tuple[int, int]:
    """A polygon in gmsh, in the plane z = 0 if its corners have two coordinates, without some holes: (2, tag)."""
    occ = gmsh.model.occ
    loops = []
    for face in (corners, *holes):
        points = [occ.addPoint(*p, *[0.0] * (3 - len(p))) for p in face]
        loops.append(occ.addCurveLoop([occ.addLine(a, b) for a, b in zip(points, points[1:] + points[:1], strict=True)]))
    return (2, occ.addPlaneSurface(loops))


def add_lines(gmsh: ModuleType, line: Line) -> list[tuple[int, int]]:
    """The segments of a polyline in gmsh: (1, tag) each."""
    tags = [gmsh.model.occ.addPoint(*p, 0) for p in line]
    return [(1, gmsh.model.occ.addLine(a, b)) for a, b in pairwise(tags)]


def divide(gmsh: ModuleType, curve: int, size: float) -> None:
    """Divide a straight curve evenly, into at least one element."""
    a, b = (gmsh.model.getValue(0, p, []) for _, p in gmsh.model.getBoundary([(1, curve)], oriented=False))
    gmsh.model.mesh.setTransfiniteCurve(curve, max(1, round(math.dist(a, b) / size)) + 1)


def set_sizes(
    gmsh: ModuleType,
    curves: Sequence[int],
    sizes: MeshSizes,
    factor: float,
    is_divided: bool = False,
    hinges: Sequence[Point] = (),
) -> None:
    """Shape of the elements, and sizes that grow with the distance from some curves.

    Parameters
    ----------
    curves : tags of the crack path.
    factor : by which the elements that gmsh makes are larger than wanted, since their edges are halved afterwards.
    is_divided : whether gmsh itself halves those of quadrilaterals once.
    hinges : points from which on the sizes grow from that of the divided element there.
    """
    field, option = gmsh.model.mesh.field, gmsh.option.setNumber
    distance = field.add("Distance")
    field.setNumbers(distance, "CurvesList", curves)
    field.setNumber(distance, "Sampling", 200)
    growth = max(GROWTH, min(_MOST_GROWTH, (factor / 2 if is_divided else factor) * GROWTH))
    size_field(gmsh, f"F{distance}", factor * sizes.crack_size, factor * sizes.far_size, growth, hinges)
    if sizes.has_quads:
        option("Mesh.Algorithm", 8)
        option("Mesh.RecombineAll", 1)
        option("Mesh.RecombinationAlgorithm", 1)
        option("Mesh.SubdivisionAlgorithm", 1 if is_divided else 0)
    else:
        option("Mesh.Algorithm", 6)


def size_field(
    gmsh: ModuleType, distance: str, near: float, far: float, growth: float = GROWTH, hinges: Sequence[Point] = ()
) -> None:
    """Element sizes that grow from `near` to `far` (mm) with a distance, an expression of gmsh in x, y, z and fields; faster
    around hinges, each from that of its last element."""
    field = gmsh.model.mesh.field
    size = field.add("MathEval")
    expression = f"Min({far!r}, {near!r} + {growth} * {distance})"
    for x, y in hinges:
        squares = f"(x - ({float(x)!r}))^2 + (y - ({float(y)!r}))^2"  # gmsh has no word for "x - -1" and ends the process
        expression = f"Min({expression}, {near * LAST_AT_HINGE!r} + {GROWTH_AT_HINGE} * Sqrt({squares}))"
    field.setString(size, "F", expression)
    field.setAsBackgroundMesh(size)
    for extra in ("MeshSizeExtendFromBoundary", "MeshSizeFromPoints", "MeshSizeFromCurvature"):
        gmsh.option.setNumber(f"Mesh.{extra}", 0)


def generate(gmsh: ModuleType, order: int) -> None:
    """Generate the 2D mesh, of second order without interior nodes if so wanted."""
    gmsh.model.mesh.generate(2)
    if order == 2:
        gmsh.option.setNumber("Mesh.SecondOrderIncomplete", 1)
        gmsh.model.mesh.setOrder(2)


def collect(gmsh: ModuleType, apart: Sequence[tuple[int, int]] = (), dimension: int = 2) -> meshio.Mesh:
    """Mesh of the faces, or of the volumes, a block for each type of cell, then one for each type on each face `apart`.

    Nodes that no cell uses are dropped; 2D cells are counter-clockwise.
    """
    return _collect(gmsh, apart, dimension)[0]


def collect_halved(gmsh: ModuleType, times: int, order: int) -> meshio.Mesh:
    """Mesh of the faces with all edges halved some times, see `refinement.halved`; new nodes of curves lie on them."""
    mesh, index = _collect(gmsh, (), 2)
    curves = {}
    for _, tag in gmsh.model.getEntities(1):
        if gmsh.model.getType(1, tag) != "Line":
            kinds, _, nodes = gmsh.model.mesh.getElements(1, tag)
            curves[tag] = index[np.concatenate([np.asarray(flat, dtype=np.int64).reshape(-1, 2) for flat in nodes])]
            assert list(kinds) == [CELLS["line"].gmsh]

    def project(tag: int, points: Array) -> Array:
        flat = np.column_stack([points, np.zeros(len(points))]).ravel()
        closest, _ = gmsh.model.getClosestPoint(1, tag, flat)
        return np.asarray(closest).reshape(-1, 3)[:, :2]

    return halved(mesh, curves, project, times, order)


def _collect(gmsh: ModuleType, apart: Sequence[tuple[int, int]], dimension: int) -> tuple[meshio.Mesh, Index]:
    """The mesh as `collect` gives it, and its node by gmsh's tag."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    bulk: dict[str, list[Index]] = {}
    last: list[tuple[str, Index]] = []
    for entity in [*(entity for entity in gmsh.model.getEntities(dimension) if entity not in apart), *apart]:
        kinds, _, connectivity = gmsh.model.mesh.getElements(*entity)
        for kind, flat in zip(kinds, connectivity, strict=True):
            cells = np.asarray(flat, dtype=np.int64).reshape(-1, gmsh.model.mesh.getElementProperties(kind)[3])
            if entity in apart:
                last.append((_NAMES[kind], cells))
            else:
                bulk.setdefault(_NAMES[kind], []).append(cells)
    blocks = [*((kind, np.concatenate(parts)) for kind, parts in bulk.items()), *last]
    used = np.unique(np.concatenate([block.ravel() for _, block in blocks]))
    index = np.zeros(int(max(tags)) + 1, dtype=np.int64)
    index[used] = np.arange(len(used))
    position = np.empty((len(index), dimension))
    position[np.asarray(tags, dtype=np.int64)] = coordinates.reshape(-1, 3)[:, :dimension]
    points, blocks = position[used], [(kind, index[block]) for kind, block in blocks]
    if dimension == 2:
        blocks = [(kind, counter_clockwise(points, kind, block)) for kind, block in blocks]
    return meshio.Mesh(points, blocks), index
