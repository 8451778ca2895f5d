"""Tension of the bulk off the crack path, which the model leaves out: the body would rather break there."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp
from scipy.spatial import cKDTree

from meshing.paths import Point

from ..arrays import Array, Index, Mask
from ..elements.rotations import major_stress, stress_tensor
from ..growth.body import Body
from .crushing import beside_loads, looked_at
from .run_data import OffPath

if TYPE_CHECKING:
    from ..elements.bulk import ElasticBlock
    from .fields import Fields
    from .run_data import RunData

#: radius of the average as a part of E Gf/ft^2, and in elements along the crack: larger ones find the corners of platens too
_OF_LENGTH, _ELEMENTS = 0.02, 1.5

#: and as a part of a coarse element far away, so that there are points to average
_OF_COARSE = 0.375

#: what is nearer to the crack than this times the radius, and than so many elements along it, belongs to the crack
_RADII_OFF, _ELEMENTS_OFF = 2.0, 3.0

#: averaged tension over ft that is too much: built-in scenes whose path is the right one stay at or below 1.00
_TOO_MUCH = 1.1

#: of the largest load, below which the tail of a curve is not looked at: what cracks there does not change the peak
_PART_OF_PEAK = 0.5

#: a place is free to lie elsewhere if the body is pulled there as at the crack, within this part, in the first step and in
#: the last one before the place is pulled beyond ft
_EVEN = 0.1


@dataclass(frozen=True)
class _Points:
    """The quadrature points of some elements, over which a stress is averaged.

    Attributes
    ----------
    strain : for each block, displacements of the nodes to the strains at its points
    D : for each block, (k, k) or, for each point, (p, k, k), MPa
    where, volume : (p, d), mm, and (p,)
    """

    strain: list[sp.csr_array]
    D: list[Array]
    where: Array
    volume: Array

    @classmethod
    def from_elements(cls, blocks: list[ElasticBlock], chosen: list[Mask]) -> _Points:
        """Of the chosen elements of each block."""
        parts, D = [], []
        for block, mine in zip(blocks, chosen, strict=True):
            own = block.D if block.D.ndim == 2 else block.D[mine]
            if mine.any():
                parts.append(replace(block, cells=block.cells[mine], D=own).strain_points())
                D.append(own if own.ndim == 2 else own[parts[-1][3]])
        return cls([p[0] for p in parts], D, np.concatenate([p[2] for p in parts]), np.concatenate([p[1] for p in parts]))

    def means(self, displacement: Array, centres: Array, radius: Array) -> Array:
        """Mean stresses (c, k) over radii (c,) around centres (c, d)."""
        stress = []
        for strain, D in zip(self.strain, self.D, strict=True):
            values = (strain @ displacement.ravel()).reshape(-1, D.shape[-1], 1)
            stress.append((D @ values)[..., 0])
        tree = cKDTree(self.where)
        nearest = tree.query(centres)[1].tolist()  # if there is no other
        near = [each or [i] for each, i in zip(tree.query_ball_point(centres, radius), nearest, strict=True)]
        all_of_them = np.concatenate(stress)
        return np.array([self.volume[each] @ all_of_them[each] / self.volume[each].sum() for each in near])


def off_path(data: RunData) -> OffPath | None:
    """The place away from crack, loads and supports where the averaged principal tension of the bulk exceeds 1.1 ft most;
    None if there is none. Some rows are looked at, as of `crushing`."""
    fields, m = data.fields, data.scene.material
    if not data.steps or not fields.bulk or not len(fields.where):
        return None
    body = _Body.from_data(data)
    load = abs(data.history["load"])
    looked = sorted({*fields.nearest(looked_at(data.history["load"], data.history["stress_n"]))})
    worst = (_TOO_MUCH * m.ft, -1, 0)
    for row in looked:
        if load[row] < _PART_OF_PEAK * load.max():
            continue
        pull = body.pull(fields.displaced(row))
        off = np.flatnonzero(body.is_off & (pull > m.ft))
        places = body.hottest(off[~beside_loads(data, body.places[off])], pull)  # a face is pulled more than centres beside it
        if len(places):
            at = body.points_around(places)
            means = major_stress(at.means(fields.displaced(row), body.places[places], body.radius[places]))
            worst = max(worst, (float(means.max()), int(places[means.argmax()]), row))
    tension, place, row = worst
    if place < 0:
        return None
    values = body.means(place)
    pulls = major_stress(values)
    across = np.linalg.eigh(stress_tensor(values[fields.rows == row]))[1][0, :, -1]
    before = max(int((pulls > m.ft).argmax()) - 1, int(fields.rows[0] == 0))  # the last one in which it is below ft
    first = int(fields.rows[0] == 0)  # a step in which little has cracked
    pull = body.pull(fields.displaced(int(fields.rows[first])))
    at_crack = major_stress(body.means(int(np.where(body.is_at_crack & ~beside_loads(data, body.places), pull, 0.0).argmax())))
    is_even = all(abs(at_crack[i] - pulls[i]) < _EVEN * pulls[i] for i in (first, before))
    return OffPath(
        body.places[place],
        across,
        tension / m.ft,
        int(data.history["step"][row]),
        _load_where(data.history["load"][fields.rows], pulls, m.ft),
        float(body.radius[place]),
        _straight_crack(data, body.places[place], across, body.reach / _ELEMENTS_OFF),
        is_even,
    )


@dataclass(frozen=True)
class _Body:
    """The elements, and the places around which their stress is averaged: all nodes, then the centres of the elements.

    Attributes
    ----------
    fields : Fields
    own : of each block, (n,) whether an element is of the material whose strength is known
    places : (q, d), mm
    radius : (q,) of the average around each place, mm; infinite for one that is nothing of such an element
    distance : (q,) of each place from the crack, mm; infinite for one further away than what its radius and `reach` ask
    reach : within which it belongs to the crack, mm
    """

    fields: Fields
    own: list[Mask]
    places: Array
    radius: Array
    distance: Array
    reach: float

    @classmethod
    def from_data(cls, data: RunData) -> _Body:
        """Of a run."""
        fields, m = data.fields, data.scene.material
        points = fields.mesh.points
        own = [region == 0 for region in fields.mesh.regions]
        longest = []
        for block in fields.bulk:
            corners = points[block.cells[:, : block.element.cell.n_corners]]
            longest.append(np.linalg.norm(corners[:, :, None] - corners[:, None], axis=-1).max(axis=(1, 2)))
        blocks = list(zip(fields.bulk, own, longest, strict=True))
        size = -_most([(block, mine, -sizes) for block, mine, sizes in blocks], len(points))
        places = np.concatenate([points, *(points[block.cells].mean(axis=1) for block in fields.bulk)])
        crack = cKDTree(fields.where)
        if data.scene.sizes is None:
            nearest = np.argsort(np.where(np.isfinite(size), crack.query(places)[0], np.inf))[: 1 + fields.cell.max()]
            along = float(np.median(size[nearest]))
        else:
            along = data.scene.sizes.crack_size
        least = max(_OF_LENGTH * m.E * m.Gf / m.ft**2, _ELEMENTS * along)
        radius, reach = np.maximum(least, _OF_COARSE * size), max(_RADII_OFF * least, _ELEMENTS_OFF * along)
        furthest = max(reach, float(radius[np.isfinite(radius)].max(initial=0.0)))
        distance = crack.query(places, distance_upper_bound=np.nextafter(furthest, np.inf))[0]
        return cls(fields, own, places, radius, distance, reach)

    @property
    def is_off(self) -> Mask:
        """Which places are off the path, (q,)."""
        return np.isfinite(self.radius) & (self.distance > self.reach)

    @property
    def is_at_crack(self) -> Mask:
        """Which places have the crack within their radius, (q,)."""
        return np.isfinite(self.radius) & (self.distance < self.radius)

    def pull(self, displacement: Array) -> Array:
        """The largest principal tension at the centres of the elements at each place, (q,), MPa."""
        blocks = zip(self.fields.bulk, self.own, strict=True)
        return _most([(b, mine, major_stress(b.stress(displacement))) for b, mine in blocks], len(self.fields.mesh.points))

    def hottest(self, places: Index, pull: Array) -> Index:
        """Of some places those that are pulled most in each box of half the least radius."""
        order = places[np.argsort(-pull[places], kind="stable")]
        boxes = np.floor(self.places[order] / (0.5 * self.radius.min()))
        kind = order >= len(self.fields.mesh.points)  # one node and one centre: the mean at a face is another one
        return np.asarray(order[np.unique(np.column_stack([boxes, kind]), axis=0, return_index=True)[1]])

    def points_around(self, places: Index) -> _Points:
        """The quadrature points within the radii around some places, and some beyond."""
        n = len(self.fields.mesh.points)
        near = np.isfinite(cKDTree(self.places[places]).query(self.places, distance_upper_bound=self.radius[places].max())[0])
        chosen, first = [], n
        for block, mine in zip(self.fields.bulk, self.own, strict=True):
            chosen.append(mine & (near[:n][block.cells].any(axis=1) | near[first : first + len(mine)]))
            first += len(mine)
        return _Points.from_elements(self.fields.bulk, chosen)

    def means(self, place: int) -> Array:
        """Mean stresses around a place in all rows of which the body is known, (f, k), MPa."""
        here = np.array([place])
        patch = self.points_around(here)
        rows = self.fields.rows.tolist()
        return np.concatenate([patch.means(self.fields.displaced(row), self.places[here], self.radius[here]) for row in rows])


def _most(blocks: list[tuple[ElasticBlock, Mask, Array]], m: int) -> Array:
    """The largest value of the elements around each of m nodes, then that of each element; -inf if it does not count.

    Parameters
    ----------
    blocks : of each, the elements, (n,) which of them count, and their values (n,)
    """
    nodes, elements = np.full(m, -np.inf), []
    for block, mine, values in blocks:
        corners = block.cells[mine][:, : block.element.cell.n_corners]
        np.maximum.at(nodes, corners, np.broadcast_to(values[mine, None], corners.shape))
        elements.append(np.where(mine, values, -np.inf))
    return np.concatenate([nodes, *elements])


def _straight_crack(data: RunData, place: Array, across: Array, slack: float) -> list[Point]:
    """Through a place from face to face, or to a node that lies within a slack of its end."""
    specimen = data.scene.specimen
    if not specimen.has_outline or len(place) == 3 or "crack" not in vars(specimen):
        return []
    outline = specimen.outline(half=False)  # type: ignore[attr-defined]
    body = Body.from_outline(outline)
    at, heading = (float(place[0]), float(place[1])), np.array([-across[1], across[0]])
    ends = [hit.point for sense in (-heading, heading) if (hit := body.first_hit(at, sense)) is not None]
    named = [point for group in outline.nodes.values() for point in group]
    ends = [next((p for p in named if math.dist(p, end) < slack), end) for end in ends]  # no sliver of an element beside it
    return [at, *ends[:1]] if any(body.is_on(at, [*face, face[0]]) for face in body.faces) else ends


def _load_where(loads: Array, pulls: Array, ft: float) -> float:
    """The load where a pull (r,) first passes ft, between the rows."""
    i = max(int((pulls > ft).argmax()), 1)
    share = float(np.clip((ft - pulls[i - 1]) / (pulls[i] - pulls[i - 1]), 0.0, 1.0))
    return float(loads[i - 1] + share * (loads[i] - loads[i - 1]))
