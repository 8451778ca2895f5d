"""gmsh: a plane polygon with lines that the mesh conforms to, as a meshio.Mesh."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from types import ModuleType

import meshio
import numpy as np
from numpy.typing import NDArray

from .cracks import Line, Point, edges_on_path, insert_cracks, mirror_cracks, nodes_on_segment, path_length
from .errors import MeshError

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: gmsh element type -> meshio name (the node orders agree)
_CELLS = {2: "triangle", 9: "triangle6", 3: "quad", 16: "quad8"}

#: growth of the element size with the distance from the path
GROWTH = 0.25


@dataclass(frozen=True)
class MeshSizes:
    """How a specimen is meshed.

    Parameters
    ----------
    crack_size : element size along the crack path, mm.
    far_size : element size far from it, mm.
    shape : "triangle" | "quad".
    order : 1 | 2.

    Raises
    ------
    ValueError
        Naming the key, its value and what was expected.
    """

    crack_size: float
    far_size: float
    shape: str = "triangle"
    order: int = 1

    def __post_init__(self) -> None:
        for name in ("crack_size", "far_size"):
            value = getattr(self, name)
            if not 0 < value < math.inf:
                raise ValueError(f"{name} = {value!r}: expected a finite number above 0, in mm")
        if self.far_size < self.crack_size:
            raise ValueError(f"far_size = {self.far_size!r}: expected at least crack_size = {self.crack_size!r}")
        if self.shape not in ("triangle", "quad"):
            raise ValueError(f"shape = {self.shape!r}: expected 'triangle' or 'quad'")
        if self.order not in (1, 2):
            raise ValueError(f"order = {self.order!r}: expected 1 or 2")


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
def _session() -> Iterator[ModuleType]:
    gmsh = load_gmsh()
    gmsh.initialize(interruptible=False)
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
    edges: dict[str, tuple[Point, Point]] | None = None,
    half: bool = False,
) -> meshio.Mesh:
    """Mesh a polygon, cut it along `crack` (with crack cells) and `slits` (without).

    Parameters
    ----------
    outline : corners of the body, counter-clockwise.
    crack, slits : polylines inside the body; the mesh conforms to them.
    sizes : MeshSizes
    nodes : points that must be nodes, by the name of the point set they end up in.
    edges : straight parts of the outline, by the name of the point set of their nodes.
    half : the crack runs along the outline, and a mirror image stands on its other side.

    Returns
    -------
    meshio.Mesh
        As `insert_cracks` gives it.

    Raises
    ------
    MeshError
        Naming the entity: a polyline that is degenerate or leaves the body, a point outside it.
    """
    nodes, edges = nodes or {}, edges or {}
    path_length("crack", crack), path_length("notch", slits)  # gmsh has no word for a line without length
    with _session() as gmsh:
        occ = gmsh.model.occ
        corners = [occ.addPoint(*p, 0) for p in outline]
        loop = [occ.addLine(a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]
        face = (2, occ.addPlaneSurface([occ.addCurveLoop(loop)]))
        tools: list[tuple[int, int]] = []
        for line in (*crack, *slits):
            tags = [occ.addPoint(*p, 0) for p in line]
            tools += [(1, occ.addLine(a, b)) for a, b in pairwise(tags)]
        n_crack = sum(len(line) - 1 for line in crack)
        tools += [(0, occ.addPoint(*p, 0)) for group in nodes.values() for p in group]
        _, image = occ.fragment([face], tools)
        occ.synchronize()
        _set_sizes(gmsh, [tag for pieces in image[1 : 1 + n_crack] for dim, tag in pieces if dim == 1], sizes)
        gmsh.model.mesh.generate(2)
        if sizes.order == 2:
            gmsh.option.setNumber("Mesh.SecondOrderIncomplete", 1)
            gmsh.model.mesh.setOrder(2)
        mesh = _collect(gmsh)
    mesh.point_sets = {name: np.array([_nearest(mesh, name, p) for p in group]) for name, group in nodes.items()}
    slack = 1e-6 * float(np.ptp(mesh.points, axis=0).max())
    mesh.point_sets |= {name: np.flatnonzero(nodes_on_segment(mesh.points, *ends, slack)) for name, ends in edges.items()}
    if half:
        return mirror_cracks(mesh, edges_on_path(mesh, "crack", crack))
    return insert_cracks(mesh, edges_on_path(mesh, "crack", crack), edges_on_path(mesh, "notch", slits))


def _set_sizes(gmsh: ModuleType, crack: list[int], sizes: MeshSizes) -> None:
    mesh, option = gmsh.model.mesh, gmsh.option.setNumber
    # quadrilaterals come from a mesh of twice the size, each of whose cells is divided: no triangle is left over
    double = 2.0 if sizes.shape == "quad" else 1.0
    near, far = double * sizes.crack_size, double * sizes.far_size
    for tag in crack:
        a, b = (gmsh.model.getValue(0, p, []) for _, p in gmsh.model.getBoundary([(1, tag)], oriented=False))
        mesh.setTransfiniteCurve(tag, max(1, round(math.dist(a, b) / near)) + 1)
    distance = mesh.field.add("Distance")
    mesh.field.setNumbers(distance, "CurvesList", crack)
    mesh.field.setNumber(distance, "Sampling", 200)
    size = mesh.field.add("MathEval")
    mesh.field.setString(size, "F", f"Min({far!r}, {near!r} + {GROWTH} * F{distance})")
    mesh.field.setAsBackgroundMesh(size)
    for extra in ("MeshSizeExtendFromBoundary", "MeshSizeFromPoints", "MeshSizeFromCurvature"):
        option(f"Mesh.{extra}", 0)
    if sizes.shape == "quad":
        option("Mesh.Algorithm", 8)
        option("Mesh.RecombineAll", 1)
        option("Mesh.RecombinationAlgorithm", 1)
        option("Mesh.SubdivisionAlgorithm", 1)
    else:
        option("Mesh.Algorithm", 6)


def _collect(gmsh: ModuleType) -> meshio.Mesh:
    """Mesh of the faces; nodes that no face uses are dropped."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    kinds, _, connectivity = gmsh.model.mesh.getElements(2)
    blocks = [
        (_CELLS[kind], np.asarray(flat, dtype=np.int64).reshape(-1, gmsh.model.mesh.getElementProperties(kind)[3]))
        for kind, flat in zip(kinds, connectivity, strict=True)
    ]
    used = np.unique(np.concatenate([block.ravel() for _, block in blocks]))
    index = np.zeros(int(max(tags)) + 1, dtype=np.int64)
    index[used] = np.arange(len(used))
    position = np.empty((len(index), 2))
    position[np.asarray(tags, dtype=np.int64)] = coordinates.reshape(-1, 3)[:, :2]
    points = position[used]
    return meshio.Mesh(points, [(kind, counter_clockwise(points, index[block])) for kind, block in blocks])


def counter_clockwise(points: Array, cells: Index) -> Index:
    """gmsh may turn a face over when it cuts it: flip clockwise cells."""
    a, b, c = (points[cells[:, i]] for i in range(3))
    clockwise = ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) < 0
    if clockwise.any():
        flip = {3: [0, 2, 1], 6: [0, 2, 1, 5, 4, 3], 4: [0, 3, 2, 1], 8: [0, 3, 2, 1, 7, 6, 5, 4]}
        cells = cells.copy()
        cells[clockwise] = cells[clockwise][:, flip[cells.shape[1]]]
    return cells


def _nearest(mesh: meshio.Mesh, name: str, point: Point) -> int:
    distance = np.hypot(*(mesh.points - point).T)
    best = int(distance.argmin())
    if distance[best] > 1e-6 * np.ptp(mesh.points, axis=0).max():
        raise MeshError(f"{name} = ({point[0]:g}, {point[1]:g}): expected a point of the body")
    return best
