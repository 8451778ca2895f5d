"""gmsh: a plane polygon with lines that the mesh conforms to, as a meshio.Mesh."""

from __future__ import annotations

import math
import signal
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from itertools import pairwise
from types import ModuleType

import meshio
import numpy as np
from numpy.typing import NDArray

from .cracks import Line, Point, as_text, cut_slits, edges_on_path, insert_cracks, mirror_cracks, nodes_on_segment, path_length
from .errors import MeshError

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: gmsh element type -> meshio name (the node orders agree)
_CELLS = {2: "triangle", 9: "triangle6", 3: "quad", 16: "quad8", 4: "tetra"}

#: growth of the element size with the distance from the path
GROWTH = 0.25

#: points nearer than this part of the size of the body are one
SLACK = 1e-6


@dataclass(frozen=True)
class MeshSizes:
    """How a specimen is meshed.

    Parameters
    ----------
    crack_size : element size along the crack path, mm.
    far_size : element size far from it, mm.
    shape : "triangle" | "quad"; in three dimensions they stand for tetrahedra and hexahedra.
    order : 1 | 2; hexahedra are of first order.
    layers : elements through the thickness of a specimen that is extruded; default: as thick as `far_size`, one at least.
        Refused by any other.

    Raises
    ------
    ValueError
        Naming the key, its value and what was expected.
    """

    crack_size: float
    far_size: float
    shape: str = "triangle"
    order: int = 1
    layers: int | None = None

    def __post_init__(self) -> None:
        for name in ("crack_size", "far_size"):
            value = getattr(self, name)
            if not 0 < value < math.inf:
                raise ValueError(f"{name} = {value!r}: expected a finite number above 0, in mm")
        if self.far_size < self.crack_size:
            raise ValueError(f"far_size = {self.far_size!r}: expected at least crack_size = {self.crack_size!r}")
        if self.shape not in ("triangle", "quad"):
            raise ValueError(
                f"shape = {self.shape!r}: expected 'triangle' or 'quad', in three dimensions for tetrahedra or hexahedra"
            )
        if self.order not in (1, 2):
            raise ValueError(f"order = {self.order!r}: expected 1 or 2")
        if self.layers is not None and not (isinstance(self.layers, int) and self.layers >= 1):
            raise ValueError(f"layers = {self.layers!r}: expected a whole number of at least 1")

    def layers_through(self, thickness: float) -> int:
        """Number of elements through a thickness, mm."""
        return max(1, round(thickness / self.far_size)) if self.layers is None else self.layers


@dataclass(frozen=True)
class Outline:
    """A plane body before it is meshed. Lengths in mm.

    Parameters
    ----------
    outline : corners, counter-clockwise.
    crack, slits : polylines of the crack and of notches without width, inside the body.
    nodes : points that must be nodes, by the name of the point set they end up in.
    edges : straight parts of the outline, by the name of the point set of their nodes.
    half : the crack runs along the outline, and a mirror image stands on its other side.
    """

    corners: Line
    crack: Sequence[Line]
    slits: Sequence[Line] = ()
    nodes: Mapping[str, Sequence[Point]] = field(default_factory=dict)
    edges: Mapping[str, tuple[Point, Point]] = field(default_factory=dict)
    half: bool = False


#: more elements along a crack, or in a body, than any of these cases needs or this machine holds
_MOST_ALONG, _MOST_IN_ALL = 1e5, 2e7


def check_not_layered(sizes: MeshSizes) -> None:
    """Refuse layers; MeshError."""
    if sizes.layers is not None:
        raise MeshError(
            f"mesh.layers = {sizes.layers!r}: this specimen is not extruded over a thickness; expected no such key"
        )


def check_sizes(body: Outline, sizes: MeshSizes) -> None:
    """Refuse what gmsh has no word for: lines without length, and element sizes that would fill the memory; MeshError."""
    check_not_layered(sizes)
    path_length("notch", body.slits)
    corners = np.asarray(body.corners, dtype=float)
    x, y = corners.T
    area = 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))
    check_count("crack_size", sizes.crack_size, "along the crack", path_length("crack", body.crack), 1, _MOST_ALONG)
    check_count("far_size", sizes.far_size, "in the body", area, 2, _MOST_IN_ALL)


def check_count(name: str, size: float, where: str, extent: float, dimension: int, most: float) -> None:
    """Refuse an element size that gives more than `most` elements in a length, area or volume; MeshError."""
    if (count := extent / size**dimension) > most:
        raise MeshError(
            f"mesh.{name} = {size:g}: {count:.2g} elements {where}; expected at least "
            f"{(extent / most) ** (1 / dimension):.2g} mm"
        )


def load_gmsh() -> ModuleType:
    """The gmsh module, or a MeshError with the install command where its system libraries are missing."""
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
    gmsh = load_gmsh()
    gmsh.initialize(interruptible=False)
    with suppress(ValueError, TypeError):  # gmsh takes SIGTERM away; not from another thread or an embedding program
        signal.signal(signal.SIGTERM, signal.getsignal(signal.SIGTERM))
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


def mesh_polygon(
    outline: Line,
    crack: Sequence[Line],
    sizes: MeshSizes,
    slits: Sequence[Line] = (),
    nodes: Mapping[str, Sequence[Point]] | None = None,
    edges: Mapping[str, tuple[Point, Point]] | None = None,
    half: bool = False,
) -> meshio.Mesh:
    """Mesh a polygon, cut it along `crack` (with crack cells) and `slits` (without).

    Parameters
    ----------
    outline, crack, slits, nodes, edges, half : as those of `Outline`.
    sizes : MeshSizes

    Returns
    -------
    meshio.Mesh
        As `insert_cracks` gives it.

    Raises
    ------
    MeshError
        Naming the entity: a polyline that is degenerate or leaves the body, a point outside it.
    """
    body = Outline(outline, crack, slits, nodes or {}, edges or {}, half)
    mesh = mesh_face(body, sizes, conforming=True)
    path = edges_on_path(mesh, "crack", crack)
    if half:
        return mirror_cracks(mesh, path)
    return insert_cracks(mesh, path, edges_on_path(mesh, "notch", slits))


def mesh_body(body: Outline, sizes: MeshSizes) -> meshio.Mesh:
    """Mesh a body without its crack, for cracks that may form anywhere.

    Returns
    -------
    meshio.Mesh
        Bulk blocks only, fine near the crack path but not aligned with it; cut along the slits. Cell set `body`,
        the point sets of `body`, and `point_data["original"]`: the node numbers before the slits were cut.

    Raises
    ------
    MeshError
        As `mesh_polygon`.
    """
    mesh = mesh_face(body, sizes, conforming=False)
    return cut_slits(mesh, edges_on_path(mesh, "notch", body.slits))


def mesh_face(body: Outline, sizes: MeshSizes, conforming: bool) -> meshio.Mesh:
    """The uncut mesh with its point sets; element edges follow the slits, and the crack if `conforming`."""
    check_sizes(body, sizes)
    with session() as gmsh:
        occ = gmsh.model.occ
        face = add_face(gmsh, body.corners)
        crack = [line for path in body.crack for line in add_lines(gmsh, path)]
        tools = [*crack] if conforming else []
        tools += [line for path in body.slits for line in add_lines(gmsh, path)]
        tools += [(0, occ.addPoint(*p, 0)) for group in body.nodes.values() for p in group]
        image = [[face]]
        if tools:
            _, image = occ.fragment([face], tools)
        occ.synchronize()
        # quadrilaterals come from a mesh of twice the size, each of whose cells is divided: no triangle is left over
        double = 2.0 if sizes.shape == "quad" else 1.0
        if conforming:
            crack = [(dim, tag) for pieces in image[1 : 1 + len(crack)] for dim, tag in pieces if dim == 1]
            for _, tag in crack:
                divide(gmsh, tag, double * sizes.crack_size)
        set_sizes(gmsh, [tag for _, tag in crack], sizes, double)
        generate(gmsh, sizes)
        mesh = collect(gmsh)
    mesh.point_sets = {name: np.array([nearest(mesh, name, p) for p in group]) for name, group in body.nodes.items()}
    mesh.point_sets |= edge_sets(mesh, body.edges)
    return mesh


def add_face(gmsh: ModuleType, outline: Line) -> tuple[int, int]:
    """A polygon in gmsh: (2, tag)."""
    occ = gmsh.model.occ
    corners = [occ.addPoint(*p, 0) for p in outline]
    loop = [occ.addLine(a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]
    return (2, occ.addPlaneSurface([occ.addCurveLoop(loop)]))


def add_lines(gmsh: ModuleType, line: Line) -> list[tuple[int, int]]:
    tags = [gmsh.model.occ.addPoint(*p, 0) for p in line]
    return [(1, gmsh.model.occ.addLine(a, b)) for a, b in pairwise(tags)]


def divide(gmsh: ModuleType, curve: int, size: float) -> None:
    """Divide a straight curve evenly, into at least one element."""
    a, b = (gmsh.model.getValue(0, p, []) for _, p in gmsh.model.getBoundary([(1, curve)], oriented=False))
    gmsh.model.mesh.setTransfiniteCurve(curve, max(1, round(math.dist(a, b) / size)) + 1)


def set_sizes(gmsh: ModuleType, curves: Sequence[int], sizes: MeshSizes, factor: float) -> None:
    """Element sizes that grow with the distance from some curves; shape of the elements.

    A `factor` of 2 stands for quadrilaterals that are divided into four in the end, 1 for those that are not.
    """
    field, option = gmsh.model.mesh.field, gmsh.option.setNumber
    distance = field.add("Distance")
    field.setNumbers(distance, "CurvesList", curves)
    field.setNumber(distance, "Sampling", 200)
    grow(gmsh, f"F{distance}", factor * sizes.crack_size, factor * sizes.far_size)
    if sizes.shape == "quad":
        option("Mesh.Algorithm", 8)
        option("Mesh.RecombineAll", 1)
        option("Mesh.RecombinationAlgorithm", 1)
        option("Mesh.SubdivisionAlgorithm", 1 if factor == 2.0 else 0)
    else:
        option("Mesh.Algorithm", 6)


def grow(gmsh: ModuleType, distance: str, near: float, far: float) -> None:
    """Element sizes from `near` up to `far` with a distance, an expression of gmsh in x, y, z and fields."""
    field = gmsh.model.mesh.field
    size = field.add("MathEval")
    field.setString(size, "F", f"Min({far!r}, {near!r} + {GROWTH} * {distance})")
    field.setAsBackgroundMesh(size)
    for extra in ("MeshSizeExtendFromBoundary", "MeshSizeFromPoints", "MeshSizeFromCurvature"):
        gmsh.option.setNumber(f"Mesh.{extra}", 0)


def generate(gmsh: ModuleType, sizes: MeshSizes) -> None:
    """The mesh, of second order without interior nodes if so wanted."""
    gmsh.model.mesh.generate(2)
    if sizes.order == 2:
        gmsh.option.setNumber("Mesh.SecondOrderIncomplete", 1)
        gmsh.model.mesh.setOrder(2)


def collect(gmsh: ModuleType, apart: Sequence[tuple[int, int]] = (), dimension: int = 2) -> meshio.Mesh:
    """Mesh of the faces, or of the volumes, a block for each type of cell, then one for each type on each face `apart`.

    Nodes that no cell uses are dropped; plane cells are counter-clockwise.
    """
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    bulk: dict[str, list[Index]] = {}
    last: list[tuple[str, Index]] = []
    for entity in [*(entity for entity in gmsh.model.getEntities(dimension) if entity not in apart), *apart]:
        kinds, _, connectivity = gmsh.model.mesh.getElements(*entity)
        for kind, flat in zip(kinds, connectivity, strict=True):
            cells = np.asarray(flat, dtype=np.int64).reshape(-1, gmsh.model.mesh.getElementProperties(kind)[3])
            if entity in apart:
                last.append((_CELLS[kind], cells))
            else:
                bulk.setdefault(_CELLS[kind], []).append(cells)
    blocks = [*((kind, np.concatenate(parts)) for kind, parts in bulk.items()), *last]
    used = np.unique(np.concatenate([block.ravel() for _, block in blocks]))
    index = np.zeros(int(max(tags)) + 1, dtype=np.int64)
    index[used] = np.arange(len(used))
    position = np.empty((len(index), dimension))
    position[np.asarray(tags, dtype=np.int64)] = coordinates.reshape(-1, 3)[:, :dimension]
    points, blocks = position[used], [(kind, index[block]) for kind, block in blocks]
    if dimension == 2:
        blocks = [(kind, counter_clockwise(points, block)) for kind, block in blocks]
    return meshio.Mesh(points, blocks)


def counter_clockwise(points: Array, cells: Index) -> Index:
    """gmsh may turn a face over when it cuts it: flip clockwise cells."""
    a, b, c = (points[cells[:, i]] for i in range(3))
    clockwise = ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) < 0
    if clockwise.any():
        flip = {3: [0, 2, 1], 6: [0, 2, 1, 5, 4, 3], 4: [0, 3, 2, 1], 8: [0, 3, 2, 1, 7, 6, 5, 4]}
        cells = cells.copy()
        cells[clockwise] = cells[clockwise][:, flip[cells.shape[1]]]
    return cells


def nearest(mesh: meshio.Mesh, name: str, point: Sequence[float]) -> int:
    """The node at a point, or a MeshError if there is none."""
    distance = np.hypot.reduce(mesh.points - point, axis=1)
    best = int(distance.argmin())
    if distance[best] > SLACK * np.ptp(mesh.points, axis=0).max():
        raise MeshError(f"{name} = {as_text(point)}: expected a point of the body")
    return best


def edge_sets(mesh: meshio.Mesh, edges: Mapping[str, tuple[Point, Point]]) -> dict[str, Index]:
    """Nodes on straight lines, by name."""
    slack = SLACK * float(np.ptp(mesh.points, axis=0).max())
    return {name: np.flatnonzero(nodes_on_segment(mesh.points, *ends, slack)) for name, ends in edges.items()}
