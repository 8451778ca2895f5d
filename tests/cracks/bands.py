"""Points of a crack band, in plane stress, plane strain or 3D, how they are led, and what holds at any state of theirs."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np

from cohesive import Concrete, CrackPlane
from cohesive.arrays import Array
from cohesive.cracks.band_iteration import TOL
from cohesive.cracks.band_points import BandState, CrackBand
from cohesive.elements.bulk import elasticity
from cohesive.elements.rotations import PAIRS, rotations, stress_tensor, stress_transformation
from tests.builders import CUBE, rotation

CONCRETE = Concrete.preset("reinhardt")
Zm, FT, YIELD = CONCRETE.Zm, CONCRETE.ft, CONCRETE.ft / CONCRETE.E
SPACES = ["stress", "strain", "space"]


def plane_turns(*degrees: float) -> Array:
    """Columns normal and tangent of planes whose normals stand at these angles to the x axis."""
    angle = np.radians(degrees)
    return rotations(np.stack([np.cos(angle), np.sin(angle)], axis=1)).transpose(0, 2, 1)


#: columns: the normal and the tangents of a plane
TURNS = {
    "stress": plane_turns(0.0, 30.0, 45.0, 90.0, 137.2),
    "strain": plane_turns(0.0, 30.0, 45.0, 90.0, 137.2),
    "space": np.stack([np.eye(3), *(rotation(seed) for seed in range(5))]),
}


def dimension(space: str) -> int:
    return 3 if space == "space" else 2


def band(
    side: float = 20.0, space: str = "stress", turns: Array | None = None, scaled: bool = True, **options: Any
) -> CrackBand:
    """Squares or cubes that are turned, by default one that is not; options of the band, and of Concrete."""
    own = {f.name for f in fields(CrackBand)} & options.keys()
    material = replace(CONCRETE, **{key: options[key] for key in options.keys() - own})
    if dimension(space) == 3:
        shape, D = CUBE, elasticity(material.E, material.nu)
    else:  # along normal and -tangent
        shape, D = np.array([[-0.5, 0.5], [-0.5, -0.5], [0.5, -0.5], [0.5, 0.5]]), elasticity(material.E, material.nu, space)
        shape = shape * [1, -1]
    turns = TURNS[space][:1] if turns is None else turns
    corners = np.einsum("nij,cj->nci", turns, side * shape)
    law = CrackPlane(replace(material, shear_scaling=scaled), side)
    return CrackBand(law, D, corners, **{key: options[key] for key in own})


def shear(d: int) -> Array:
    """What makes engineering strains of the components of a tensor."""
    return np.array([1.0 if i == j else 2.0 for i, j in PAIRS[d]])


def turned(strain: Any, turns: Array) -> Array:
    """Strains (k,) or (n, k) of a frame, seen from outside: (n, k)."""
    d = turns.shape[1]
    tensor = stress_tensor(np.atleast_2d(np.asarray(strain, dtype=float)) / shear(d))
    i, j = np.array(PAIRS[d]).T
    return np.asarray((turns @ tensor @ turns.transpose(0, 2, 1))[..., i, j] * shear(d))


def turned_stress(stress: Any, turns: Array) -> Array:
    factor = shear(turns.shape[1])
    return turned(np.asarray(stress) * factor, turns) / factor


def advance(law: CrackBand, strain: Array, start: BandState) -> tuple[BandState, BandState]:
    """A step as the solver takes it, planes growing on the committed state until none is due: that state and the new one."""
    state, _ = law.update(strain, start)
    while (grown := law.nucleate(start, state)) is not None:
        start = grown
        state, _ = law.update(strain, start)
    return start, state


def follow(law: CrackBand, start: BandState, *targets: Any, steps: int = 15) -> BandState:
    """Straight legs in the strain."""
    for target in targets:
        begin = start.deformation
        for part in np.linspace(0, 1, steps + 1)[1:]:
            _, start = advance(law, begin + part * (np.asarray(target, dtype=float) - begin), start)
    return start


def check(law: CrackBand, state: BandState) -> None:
    """On every plane the stress is the traction of the law at its jump, eq. (41), and the strain splits as in eq. (30)."""
    cracks, allowed = state.planes, 2 * TOL * FT + 1e-13 * abs(state.stress).max()
    assert np.isfinite(state.stress).all()
    N, release = stress_transformation(cracks.rotation), np.zeros_like(state.stress)
    for i, point in enumerate(cracks.point):
        plane = CrackPlane(law.law.concrete, float(cracks.length[i]))
        traction, Z = plane.traction(cracks.jump[[i]], cracks.history[[i]])
        np.testing.assert_allclose([N[i] @ state.stress[point], cracks.traction[i]], [*traction, *traction], atol=allowed)
        assert Z[0] == cracks.history[i]
        release[point] += N[i].T @ (cracks.strain[i] - law.compliance * traction[0])
    np.testing.assert_allclose(state.stress, (state.deformation - release) @ law.D, atol=10 * allowed, rtol=1e-12)
