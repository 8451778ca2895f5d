"""Every element once, by meshio's name of its cells: shape functions and quadrature. Its topology is in `meshing.cells`.

A line, a triangle or a quadrilateral is besides the facet of a crack cell; `tests/elements` runs over all rows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshing.cells import CELLS, CellType

from ..arrays import Array
from .shapes import (
    Rule,
    Shape,
    gauss_cube,
    gauss_simplex,
    linear_cube,
    linear_simplex,
    quadratic_along,
    quadratic_line,
    quadratic_simplex,
    serendipity,
)


@dataclass(frozen=True)
class Element:
    """What is computed with the cells of a type; a field that they have no use for is empty.

    Attributes
    ----------
    cell : their topology.
    shape : shape functions.
    rule : quadrature that integrates the stiffness of a straight element exactly.
    gauss : interior rule for the jumps over a facet.
    nodal : rule on the node pairs of a facet.
    in_band : the element that a cell of a row of a band is, if it is another one.
    """

    cell: CellType
    shape: Shape
    rule: Rule
    gauss: Rule | None = None
    nodal: Rule | None = None
    in_band: str = ""

    @property
    def centre(self) -> Array:
        """Local point at the centre, (1, local dimension)."""
        d = self.cell.dimension
        return (gauss_simplex(1, d) if self.cell.collapsed else gauss_cube(1, d))[0]

    @property
    def has_constant_strain(self) -> bool:
        """Whether one point sees every deformation."""
        return len(self.rule[1]) == 1

    @property
    def shares(self) -> Array:
        """Of the nodes in a uniform load, (nodes,), with sum 1."""
        at, weights = self.rule if self.gauss is None else self.gauss
        return np.asarray(weights @ self.shape(at)[0] / weights.sum())


#: corners, mid-sides and centre. No rule on the node pairs of a quadratic triangle has weight left for the corners: with the
#: mid-sides alone the corners part freely, which between stiff faces costs 2 % of the stiffness of a notched block. With the
#: centre besides, the only point that couples pairs, Newton-Cotes has positive weights and degree 3, and the tractions
#: oscillate by a third of those of the interior rule of degree 4 (`pytest -k stiff_faces`).
_TRIANGLE = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5], [1 / 3, 1 / 3]])

_LINE, _SQUARE = np.array([[-1.0], [1.0], [0.0]]), np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])

#: "quad6" is a "quad8" without mid-sides across a band
ELEMENTS = {
    "line": Element(CELLS["line"], linear_cube, gauss_cube(1, 1), gauss_cube(2, 1), (_LINE[:2], np.ones(2))),
    "line3": Element(
        CELLS["line3"], quadratic_line, gauss_cube(2, 1), gauss_cube(3, 1), (_LINE, np.array([1.0, 1.0, 4.0]) / 3.0)
    ),
    "triangle": Element(
        CELLS["triangle"], linear_simplex, gauss_simplex(1, 2), gauss_simplex(2, 2), (_TRIANGLE[:3], np.full(3, 1 / 6))
    ),
    "triangle6": Element(
        CELLS["triangle6"],
        quadratic_simplex,
        gauss_simplex(2, 2),
        gauss_simplex(4, 2),
        (_TRIANGLE, np.repeat([3.0, 8.0, 27.0], [3, 3, 1]) / 120.0),
    ),
    "quad": Element(CELLS["quad"], linear_cube, gauss_cube(2, 2), gauss_cube(2, 2), (_SQUARE, np.ones(4))),
    "quad8": Element(CELLS["quad8"], serendipity, gauss_cube(3, 2), in_band="quad6"),
    "quad6": Element(CELLS["quad8"], quadratic_along, gauss_cube(3, 2)),
    "tetra": Element(CELLS["tetra"], linear_simplex, gauss_simplex(1, 3)),
    "tetra10": Element(CELLS["tetra10"], quadratic_simplex, gauss_simplex(2, 3)),
    "hexahedron": Element(CELLS["hexahedron"], linear_cube, gauss_cube(2, 3)),
}


def facet_of(kind: str) -> Element:
    """The facet of a type of cells, of crack cells that of either side."""
    return ELEMENTS[CELLS[kind].facet]


def element_in_band(kind: str) -> tuple[str, list[int]]:
    """The element that a cell of a row of a band is, and the columns of the cell that are its nodes: those of its sides."""
    minus, plus = CELLS[kind].sides
    return ELEMENTS[kind].in_band or kind, sorted(minus + plus)


def centre_rule(kind: str) -> Rule:
    """The rule of an element of a band with one point across: on its centre line or mid plane, where a crack that opens
    linearly causes no shear.

    With points off it that shear stiffens the band: on the built-in beam with elements of 5 mm the energy is 6 % too high,
    with planes across the principal stress 19 %, and on finer elements too. Two points along see every deformation of a quad;
    what three do not see of a quad6, bending about the centre line, and what two by two do not see of a hexahedron, twisting
    about the mid plane, the bulk resists.
    """
    d, (_, every) = ELEMENTS[kind].cell.dimension, ELEMENTS[kind].rule
    at, weights = gauss_cube(round(len(every) ** (1 / d)), d - 1)
    return np.column_stack([at, np.zeros(len(at))]), 2.0 * weights
