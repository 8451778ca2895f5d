"""Every cell type once: nodes, edges, faces, crack cell. Local numbers are those of meshio's node order.

To add an element, add a row here and one to `cohesive/elements/registry.py`; `tests/meshing/test_cells.py` runs over all rows.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import meshio

from .arrays import Array, Index

# meshio 5.3 reads and writes this cell type, but its table of dimensions, without which there is no such block, leaves it out
meshio._mesh.topological_dimension.setdefault("wedge15", 3)

Row = tuple[int, ...]


@dataclass(frozen=True)
class CellType:
    """Topology of a cell type; a field that its cells have no use for is empty.

    Attributes
    ----------
    dimension : 1, 2 or 3.
    n_corners : number of corners; corners come first, then the mid nodes of edges.
    facet : type of a facet, which is what two cells share: an edge in 2D, a face in 3D. Of a crack cell, that of either
        side.
    edges : (first corner, second corner[, mid node]) each, in the order of the mid nodes. In 2D the cell is to the left.
    faces : corners in a ring[, mid nodes, in the order of the ring's edges]; the ring's normal points into the cell.
    flip : node order that reverses the orientation of the cell, its own inverse.
    neighbours : for each corner to be tested, the three corners beside it, with a positive triple product if the cell is not
        inverted.
    crack_cell : type of the crack cell between two facets; only bulk cells have one.
    crack_columns : of a crack cell, where its nodes stand in the nodes of the minus facet followed by those of the plus
        facet. Its edges across the crack have no mid node of their own: a corner of the minus side (in quad8 of either) stands
        in.
    second_order : type with the same corners and mid nodes.
    children : of a cell whose edges are halved, the corners of its parts: by its corners 0, 1, ..., then the middles of its
        edges, then its centre.
    collapsed : of a simplex, its corners as those of a quadrilateral or hexahedron, some of them repeated.
    density : of a bulk cell, nodes for each square or cube of the element size: from meshes; the least would be 1.15 corners
        of triangles.
    gmsh : element number of gmsh, if the node orders agree.
    abaqus : how its element types in files of Abaqus begin, what follows being how they are integrated; the last ones of those
        that meshio writes for any plane element.
    """

    dimension: int
    n_corners: int
    facet: str = ""
    edges: tuple[Row, ...] = ()
    faces: tuple[Row, ...] = ()
    flip: Row = ()
    neighbours: tuple[Row, ...] = ()
    crack_cell: str = ""
    crack_columns: Row = ()
    second_order: str = ""
    children: tuple[Row, ...] = ()
    collapsed: Row = ()
    density: float = 0.0
    gmsh: int | None = None
    abaqus: tuple[str, ...] = ()

    @property
    def facets(self) -> tuple[Row, ...]:
        """Edges of a 2D cell, faces of a 3D cell."""
        return self.edges if self.dimension == 2 else self.faces

    @property
    def facet_corners(self) -> int:
        """Number of corners of a facet."""
        return CELLS[self.facet].n_corners

    @property
    def is_row_cell(self) -> bool:
        """Whether a row of such cells may be a band: a crack cell with a thickness is one of them."""
        return bool(self.crack_cell) and self is CELLS[self.crack_cell]

    @property
    def as_cube(self) -> list[int]:
        """The corners as those of a quadrilateral or hexahedron."""
        return list(self.collapsed or range(self.n_corners))

    @cached_property
    def sides(self) -> tuple[list[int], list[int]]:
        """Of a crack cell, the columns of the nodes of its minus and its plus side, in the order of the facet's nodes."""
        at = [self.crack_columns.index(node) for node in range(max(self.crack_columns) + 1)]
        return at[: len(at) // 2], at[len(at) // 2 :]


#: by the name of meshio
CELLS: dict[str, CellType] = {
    #   0 --2-- 1
    "line": CellType(dimension=1, n_corners=2, gmsh=1, abaqus=("T2D2", "T3D2", "B21", "B31")),
    "line3": CellType(dimension=1, n_corners=2, gmsh=8, abaqus=("T2D3", "T3D3", "B22", "B32", "B33")),
    #   2
    #   | \
    #   5   4
    #   |     \
    #   0 --3-- 1
    "triangle": CellType(
        dimension=2,
        n_corners=3,
        facet="line",
        edges=((0, 1), (1, 2), (2, 0)),
        flip=(0, 2, 1),
        crack_cell="quad",
        second_order="triangle6",
        children=((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)),
        collapsed=(0, 1, 2, 2),
        density=1.25,
        gmsh=2,
        abaqus=("CPS3", "CPE3", "S3", "STRI3", "M3D3", "SFM3D3", "R3D3"),
    ),
    "triangle6": CellType(
        dimension=2,
        n_corners=3,
        facet="line3",
        edges=((0, 1, 3), (1, 2, 4), (2, 0, 5)),
        flip=(0, 2, 1, 5, 4, 3),
        crack_cell="quad8",
        collapsed=(0, 1, 2, 2),
        density=5.0,
        gmsh=9,
        abaqus=("CPS6", "CPE6", "S6", "STRI65", "M3D6", "SFM3D6"),
    ),
    #   3 --6-- 2          as a crack cell
    #   |       |          a+ -mid+- b+
    #   7       5          |         |
    #   |       |          a- -mid-- b-    along the path from a to b
    #   0 --4-- 1
    "quad": CellType(
        dimension=2,
        n_corners=4,
        facet="line",
        edges=((0, 1), (1, 2), (2, 3), (3, 0)),
        flip=(0, 3, 2, 1),
        crack_cell="quad",
        crack_columns=(0, 1, 3, 2),
        second_order="quad8",
        children=((0, 4, 8, 7), (4, 1, 5, 8), (8, 5, 2, 6), (7, 8, 6, 3)),
        density=1.5,
        gmsh=3,
        abaqus=("CPS4", "CPE4", "S4", "M3D4", "SFM3D4", "CAX4P"),
    ),
    "quad8": CellType(
        dimension=2,
        n_corners=4,
        facet="line3",
        edges=((0, 1, 4), (1, 2, 5), (2, 3, 6), (3, 0, 7)),
        flip=(0, 3, 2, 1, 7, 6, 5, 4),
        crack_cell="quad8",
        crack_columns=(0, 1, 4, 3, 2, 1, 5, 3),
        density=4.5,
        gmsh=16,
        abaqus=("CPS8", "CPE8", "S8", "M3D8", "SFM3D8"),
    ),
    # quad8 with a node in the middle; on crack surfaces in files only
    "quad9": CellType(dimension=2, n_corners=4, gmsh=10),
    #        3
    #       /|\
    #      7 | 9
    #     /  8  \
    #    0 --6|-- 2
    #     \  |  /
    #      4 | 5
    #       \|/
    #        1
    "tetra": CellType(
        dimension=3,
        n_corners=4,
        facet="triangle",
        edges=((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)),
        faces=((0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)),
        flip=(0, 1, 3, 2),
        neighbours=((1, 2, 3),),
        crack_cell="wedge",
        second_order="tetra10",
        collapsed=(0, 1, 2, 2, 3, 3, 3, 3),
        density=1.4,
        gmsh=4,
        abaqus=("C3D4",),
    ),
    "tetra10": CellType(  # gmsh has nodes 8 and 9 the other way round
        dimension=3,
        n_corners=4,
        facet="triangle6",
        edges=((0, 1, 4), (1, 2, 5), (0, 2, 6), (0, 3, 7), (1, 3, 8), (2, 3, 9)),
        faces=((0, 1, 2, 4, 5, 6), (0, 3, 1, 7, 8, 4), (0, 2, 3, 6, 9, 7), (1, 3, 2, 8, 9, 5)),
        flip=(0, 1, 3, 2, 4, 8, 7, 6, 5, 9),
        neighbours=((1, 2, 3),),
        crack_cell="wedge15",
        collapsed=(0, 1, 2, 2, 3, 3, 3, 3),
        density=10.0,
        abaqus=("C3D10",),
    ),
    #       7 ------- 6
    #      /|        /|    as a crack cell: 0 1 2 3 the minus side, 4 5 6 7 the plus side
    #     4 ------- 5 |
    #     | 3 ------|-2
    #     |/        |/
    #     0 ------- 1
    "hexahedron": CellType(
        dimension=3,
        n_corners=8,
        facet="quad",
        edges=((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)),
        faces=((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)),
        flip=(0, 3, 2, 1, 4, 7, 6, 5),
        neighbours=((1, 3, 4), (2, 0, 5), (3, 1, 6), (0, 2, 7), (7, 5, 0), (4, 6, 1), (5, 7, 2), (6, 4, 3)),
        crack_cell="hexahedron",
        crack_columns=(0, 1, 2, 3, 4, 5, 6, 7),
        gmsh=5,
        abaqus=("C3D8",),
    ),
    #     3 --11-- 5
    #     |\      /|
    #     | 9   10 |
    #     |  \  /  |       crack cells only: 0 1 2 the minus side, 3 4 5 the plus side
    #    12   4   14
    #     |   |    |
    #     0 --|8-- 2
    #      \  13  /
    #       6 |  7
    #        \| /
    #         1
    "wedge": CellType(dimension=3, n_corners=6, facet="triangle", crack_columns=(0, 1, 2, 3, 4, 5), gmsh=6),
    "wedge15": CellType(  # gmsh orders the mid nodes otherwise
        dimension=3,
        n_corners=6,
        facet="triangle6",
        crack_columns=(0, 1, 2, 6, 7, 8, 3, 4, 5, 9, 10, 11, 0, 1, 2),
    ),
}

#: cells that a body may consist of
BULK_2D = tuple(name for name, cell in CELLS.items() if cell.crack_cell and cell.dimension == 2)
BULK_3D = tuple(name for name, cell in CELLS.items() if cell.crack_cell and cell.dimension == 3)


def counter_clockwise(points: Array, kind: str, cells: Index) -> Index:
    """2D cells, those that are clockwise flipped: gmsh may flip a face when it cuts it.

    Parameters
    ----------
    points : (m, 2)
    kind : cell type of the block `cells`, (n, nodes of a cell).
    """
    a, b, c = (points[cells[:, i]] for i in range(3))
    clockwise = ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) < 0
    if clockwise.any():
        cells = cells.copy()
        cells[clockwise] = cells[clockwise][:, list(CELLS[kind].flip)]
    return cells
