"""The law at the points of crack cells."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp

from cohesive import Concrete, CrackPlane
from cohesive.algebra.crack_operator import CrackOperator
from cohesive.cracks.interface_points import InterfaceLaw
from cohesive.elements.interface import Interface
from tests.builders import box, rotation


def test_the_axes_in_a_facet_are_arbitrary() -> None:
    """Tangents turned at random at every point: the same forces, stiffness and energies."""
    law = CrackPlane(Concrete.preset("reinhardt"), 0.5)
    solid = box("hexahedron", (3, 2, 2), split=0.5)
    points, cells = solid.points.copy(), solid.crack
    assert cells is not None
    points[:, 2] += 0.4 * (points[:, 0] ** 2 - 0.5 * points[:, 0] * points[:, 1])
    points = points @ rotation(3).T
    interface = Interface.from_cells("hexahedron", points, cells)
    p, random = len(interface.weights), np.random.default_rng(5)
    angle = random.uniform(0, 2 * np.pi, p)
    turn = np.zeros((p, 3, 3))
    turn[:, 0, 0] = 1.0
    turn[:, 1, 1], turn[:, 1, 2], turn[:, 2, 1], turn[:, 2, 2] = np.cos(angle), np.sin(angle), -np.sin(angle), np.cos(angle)
    operators = [interface.jump_operator, (sp.block_diag(list(turn)) @ interface.jump_operator).tocsr()]
    u0, u1 = random.normal(size=(2, points.size)) * 0.3 * law.concrete.Zm
    results = []
    for operator in operators:
        of, points_law = CrackOperator.from_matrix(operator, interface.weights, interface.points), InterfaceLaw(law, p, 3)
        start = points_law.update(of.deformation(u0), points_law.initial())[0]
        state, tangent = points_law.update(of.deformation(u1), start)
        rows, columns, values = of.stiffness(tangent)
        stiffness = sp.coo_array((values, (rows, columns)), shape=(points.size,) * 2).toarray()
        energies = [
            points_law.energies(state)[1],
            points_law.dissipation(start, state)[0],
            points_law.contact_work(start, state),
        ]
        results.append([of.force(state.stress), stiffness, state.history, *energies])
    assert points_law.dissipation(start, state)[0].max() > 0 and abs(energies[2]).max() > 0
    for one, other in zip(*results, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-11 * abs(one).max())


@pytest.mark.parametrize(("openings", "separated"), [((1.0, 1.0), True), ((1.0, 0.0), False), ((1.0, 0.3), False)])
def test_separated_is_where_every_point_is(openings: tuple[float, float], separated: bool) -> None:
    """Opened to 100 Zm, or one of the two points not at all, or to 30 Zm and pressed together again."""
    law = CrackPlane(Concrete.preset("reinhardt"), 0.5)
    points = InterfaceLaw(law, 2)
    jump = 100 * law.concrete.Zm * np.array([[opening, 0.0] for opening in openings])
    state = points.update(jump, points.initial())[0]
    if openings[1] == 0.3:
        state = points.update(jump * [[1.0, 0.0], [-1e-4, 0.0]], state)[0]
        assert law.is_fully_softened(state.history).all() and state.stress[1, 0] < 0
    assert points.is_separated(state) == separated
