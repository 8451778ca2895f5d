"""The registry of elements: every type of a body has a row, and so have the facets of the crack cells between them."""

from __future__ import annotations

import numpy as np
import pytest

from cohesive.elements.registry import ELEMENTS, element_in_band, facet_of
from meshing.cells import BULK_2D, BULK_3D, CELLS

BULK = [*BULK_2D, *BULK_3D]
CRACKS = sorted({CELLS[kind].crack_cell for kind in BULK})

#: of the nodes of a facet in a uniform load, from the integrals of the shape functions
SHARES = {
    "line": [1 / 2, 1 / 2],
    "line3": [1 / 6, 1 / 6, 2 / 3],
    "triangle": [1 / 3] * 3,
    "quad": [1 / 4] * 4,
    "triangle6": [0.0] * 3 + [1 / 3] * 3,
}


@pytest.mark.parametrize("kind", BULK)
def test_a_body_has_elements_and_facets(kind: str) -> None:
    element, facet = ELEMENTS[kind], facet_of(kind)
    assert element.cell is CELLS[kind]
    assert facet.cell.dimension == CELLS[kind].dimension - 1
    np.testing.assert_allclose(facet.shares, SHARES[CELLS[kind].facet], atol=1e-15)
    assert len(CELLS[kind].as_cube) == 2**element.cell.dimension
    N = element.shape(element.centre)[0]
    assert N.sum() == pytest.approx(1.0, rel=1e-14)
    np.testing.assert_allclose(N[0, : CELLS[kind].n_corners], N[0, 0], rtol=1e-14)


@pytest.mark.parametrize("kind", CRACKS)
def test_a_crack_cell_has_two_sides_with_rules(kind: str) -> None:
    facet, (minus, plus) = facet_of(kind), CELLS[kind].sides
    assert not set(minus) & set(plus)
    n = facet.shape(facet.rule[0])[0].shape[1]
    assert len(minus) == len(plus) == n
    for rule in (facet.gauss, facet.nodal):
        assert rule is not None
        size = facet.rule[1].sum()
        np.testing.assert_allclose(rule[1] @ facet.shape(rule[0])[0], size * facet.shares, atol=1e-15)


def test_a_cell_of_a_band_has_no_mid_nodes_across() -> None:
    assert element_in_band("quad") == ("quad", [0, 1, 2, 3])
    assert element_in_band("quad8") == ("quad6", [0, 1, 2, 3, 4, 6])
    assert element_in_band("hexahedron") == ("hexahedron", [*range(8)])
