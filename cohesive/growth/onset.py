"""Where a crack starts in a body without a notch: at the face that is pulled most while the body is elastic."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
from scipy.spatial import cKDTree

from meshing.paths import Point

from ..arrays import Array
from ..elements.rotations import stress_tensor
from ..errors import SceneError
from ..model.boundary import nodes_at
from ..model.build import build
from ..model.model import Model
from ..scenes.scene import Scene
from ..solver.stepper import solve
from .body import Body

#: radius of the average: this part of E Gf/ft^2, at least so many elements along the crack
_OF_LENGTH, _ELEMENTS = 0.02, 1.5

#: what is nearer to loads and supports than so many radii, or than this part of the narrowest side, does not count
_BESIDE, _PART_BESIDE = 2.0, 0.05

#: tension over the largest stress that is none
_NO_PULL = 1e-3

#: places whose tension is more than this part of the largest one, beside it, have a share in where it is
_ALIKE = 0.95

#: elastic runs, each on a mesh that is fine where the one before found the place
_MOST_RUNS = 4

#: motion of the drive that leaves the body elastic, part of ft/E times its size
_ELASTIC = 1e-3


def onset(scene: Scene, body: Body) -> tuple[Point, Point]:
    """The place of a face with the largest principal tension, averaged over a small radius, and the direction of a crack
    across it.

    Raises
    ------
    SceneError, MeshError
        For bad input, or if no face is pulled.
    """
    assert scene.sizes is not None
    size, m = scene.sizes.crack_size, scene.material
    radius = max(_OF_LENGTH * m.E * m.Gf / m.ft**2, _ELEMENTS * size)
    sides = [side for face in body.faces for side in pairwise([*face, face[0]])]
    places, tangents = map(np.concatenate, zip(*(_along(np.array(a), np.array(b), size) for a, b in sides), strict=True))
    a, b = max(pairwise([*body.faces[0], body.faces[0][0]]), key=lambda side: math.dist(*side))
    at, along = 0.5 * np.add(a, b), np.subtract(b, a) / math.dist(a, b)
    heading = np.array([-along[1], along[0]])
    for _ in range(_MOST_RUNS):
        hit = body.first_hit(_point(at), heading)
        assert hit is not None  # it leads into the body
        before = at
        at, heading = _pulled_most(scene.along([[_point(at), hit.point]]), body, places, tangents, radius)
        if np.hypot(*(at - before)) < size:
            break
    return _point(at), _point(heading)


def _pulled_most(scene: Scene, body: Body, places: Array, tangents: Array, radius: float) -> tuple[Array, Array]:
    """The place that is pulled most along its face on the mesh of a scene, whose crack stays closed, and the unit vector
    across the principal tension there, into the body; tangents (p, 2) of the faces at the places (p, 2)."""
    model = build(scene.with_(**{"material.density": 0.0}))
    displacement = _elastic(model, scene, body.size)
    centres = np.concatenate([block.points[block.cells].mean(axis=1) for block in model.bulk])
    stress = np.concatenate([block.stress(displacement) for block in model.bulk])
    volume = np.concatenate([block.volumes() for block in model.bulk])
    near = cKDTree(centres).query_ball_point(places, radius)
    nearest = cKDTree(centres).query(places)[1].tolist()  # if the elements are large
    means = np.array(
        [volume[i] @ stress[i] / volume[i].sum() for each, one in zip(near, nearest, strict=True) for i in [each or [one]]]
    )
    specimen = scene.specimen
    drives = specimen.drives().values()
    ends = [support.at for support in specimen.held()] + [at for d in drives for at in (d.at, d.against) if at is not None]
    nodes = np.unique(np.concatenate([nodes_at(model.mesh, "supports.at", at) for at in ends]))
    beside = max(_BESIDE * radius, _PART_BESIDE * float(np.ptp(np.array(body.faces[0]), axis=0).min()))
    tensors = stress_tensor(means)
    pull = np.einsum("pi,pij,pj->p", tangents, tensors, tangents)
    pull = np.where(cKDTree(model.mesh.points[nodes]).query(places)[0] > beside, pull, -np.inf)
    if not pull.max() > _NO_PULL * abs(means).max():
        why = "no face is pulled away from loads and supports"
        raise SceneError.at("specimen.crack", f" = 'grow': {why}; expected grow.starts")
    weight = np.where(np.hypot(*(places - places[pull.argmax()]).T) < _BESIDE * radius, pull - _ALIKE * pull.max(), 0.0)
    weight = np.maximum(weight, 0.0)  # the mesh has its say on which of a few alike is the largest
    best = int(np.hypot(*(places - weight @ places / weight.sum()).T).argmin())
    u, v = np.linalg.eigh(tensors[best])[1][:, -1]
    inward = 1.0 if body.contains(_point(places[best] + radius * np.array([-v, u]))) else -1.0
    return places[best], inward * np.array([-v, u])


def _elastic(model: Model, scene: Scene, size: float) -> Array:
    """Displacements of the nodes (m, d), mm, under a small motion of the drive of the first stage, in its sense."""
    first = scene.stages[0]
    motion = math.copysign(_ELASTIC * size * scene.material.ft / scene.material.E, first.targets[0])
    stage = replace(first, control="driven", to=motion, step=None, steps=1, until=None, unload=None)
    (step,) = solve(model.problem, [stage], model.recorded)
    return model.condensation.recover(step.equilibrium.state.v)


def _along(a: Array, b: Array, size: float) -> tuple[Array, Array]:
    """Points of a side, at most `size` apart, its middle among them, and its unit tangent at each, (n, 2)."""
    length = float(np.hypot(*(b - a)))
    n = 2 * math.ceil(0.5 * length / size)
    return a + (b - a) * (np.arange(n) / n)[:, None], np.tile((b - a) / length, (n, 1))


def _point(at: Array) -> Point:
    return float(at[0]), float(at[1])
