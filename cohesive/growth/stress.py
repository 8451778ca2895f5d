"""The stress ahead of a crack's tip, as linear measures of the nodes' displacements, and the direction that it tells.

Stresses at the nodes are means of those in the elements around them, each weighted with its volume; the two faces of a cut
have nodes of their own. Between nodes they are interpolated.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.spatial import cKDTree

from meshing.paths import Point

from ..arrays import Array, Index
from ..elements.bulk import ElasticBlock

#: angles of the rays from the heading of a crack, radians; none lies on the path, whose two sides have stresses of their own
RAYS = np.radians(np.arange(-111.25, 111.3, 2.5))

#: points along a ray
_ON_RAY = 16

#: the hoop stress of neighbouring rays is averaged with Gaussian weights of this width, radians: the mesh has less to say
_SMOOTHING = np.radians(10.0)

#: a direction means nothing if the hoop stress so far off it, radians, is lower by less than this part of it
_APART, _CONTRAST = np.radians(45.0), 0.08

#: nor if it is farther than this from that across the major principal stress, radians; a singular field makes up to 22 degrees
_DISPUTED = np.radians(30.0)


@dataclass(frozen=True)
class NodalStress:
    """Stress at the corners of the elements.

    Attributes
    ----------
    operator : three (m, d m) matrices, displacements to [xx, yy, xy], MPa/mm
    points : (m, 2), mm
    triangles : (n, 3), nodes of the elements, of quadrilaterals cut in two
    """

    operator: tuple[sp.csr_array, ...]
    points: Array
    triangles: Index

    @classmethod
    def from_blocks(cls, blocks: list[ElasticBlock]) -> NodalStress:
        """The stress in linear elastic elements of a plane body."""
        points = blocks[0].points
        m = len(points)
        volume = np.zeros(m)
        total: list[sp.csr_array] = [sp.csr_array((m, points.size)) for _ in range(3)]
        triangles = []
        for block in blocks:
            strain, volumes, _, _ = block.strain_points((block.element.centre, np.ones(1)))
            corners = block.cells[:, : block.element.cell.n_corners]
            share = sp.csr_array(
                (
                    np.repeat(volumes, corners.shape[1]),
                    (corners.ravel(), np.repeat(np.arange(len(corners)), corners.shape[1])),
                ),
                shape=(m, len(corners)),
            )
            volume += share @ np.ones(len(corners))
            at_centre = [strain[i::3] for i in range(3)]
            for i in range(3):
                total[i] = total[i] + share @ sum(block.D[i, j] * at_centre[j] for j in range(3))
            triangles += [corners[:, [0, *pair]] for pair in ([1, 2], [2, 3])[: corners.shape[1] - 2]]
        mean = sp.diags_array(1.0 / np.where(volume > 0, volume, 1.0))
        return cls(tuple((mean @ part).tocsr() for part in total), points, np.concatenate(triangles))

    def interpolation(self, at: Array, near: Point, reach: float) -> sp.csr_array:
        """Values at the nodes to those at points (p, 2) within `reach` of a place: (p, m) matrix, whose row is empty for a
        point outside the body."""
        centre = self.points[self.triangles].mean(axis=1)
        size = np.linalg.norm(self.points[self.triangles] - centre[:, None], axis=-1).max(axis=1)
        cells = np.flatnonzero(np.hypot(*(centre - near).T) < reach + size)
        inside = cKDTree(at).query_ball_point(centre[cells], (1.0 + 1e-6) * size[cells])  # of the circle around each
        cell = self.triangles[np.repeat(cells, [len(each) for each in inside])]
        point = np.concatenate([np.array(each, dtype=np.int64) for each in inside])
        a, b, c = (self.points[cell[:, i]] for i in range(3))
        p = at[point]
        shares = np.stack([_cross(b - p, c - p), _cross(c - p, a - p), _cross(a - p, b - p)], axis=-1)
        shares /= _cross(b - a, c - a)[:, None]
        least = shares.min(axis=1)
        order = np.lexsort([-least, point])
        order = order[np.unique(point[order], return_index=True)[1]]  # the best cell of each point
        order = order[least[order] >= -1e-9]
        rows = np.repeat(point[order], 3)
        return sp.csr_array((shares[order].ravel(), (rows, cell[order].ravel())), shape=(len(at), len(self.points)))


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


@dataclass(frozen=True)
class Reading:
    """What the stress ahead of a tip says in one state.

    Attributes
    ----------
    rays : (3, len(RAYS)) array, [xx, yy, xy] averaged along each ray, MPa
    half_disc : (3,) array, averaged over the half disc ahead
    """

    rays: Array
    half_disc: Array

    def towards(self, other: Reading, share: float) -> Reading:
        """The reading between two states, `share` of the way to another one."""
        return Reading(
            self.rays + share * (other.rays - self.rays), self.half_disc + share * (other.half_disc - self.half_disc)
        )


@dataclass(frozen=True)
class Probe:
    """The stress ahead of a tip.

    Attributes
    ----------
    tip : Point
    heading : of the path there, radians
    radius : length of the rays, mm
    operator : (3 (len(RAYS) + 1), d m) matrix: displacements to the stresses of a `Reading`
    inside : (len(RAYS),) part of each ray that lies within the body
    """

    tip: Point
    heading: float
    radius: float
    operator: sp.csr_array
    inside: Array

    @classmethod
    def from_tip(cls, stress: NodalStress, tip: Point, heading: float, radius: float) -> Probe:
        """The probe of a tip.

        Parameters
        ----------
        radius : length of the rays, mm
        """
        r = radius * (np.arange(_ON_RAY) + 0.5) / _ON_RAY
        angle = heading + RAYS
        at = np.asarray(tip) + r[None, :, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)[:, None, :]
        points = stress.interpolation(at.reshape(-1, 2), tip, radius)
        inside = (np.diff(points.indptr) > 0) & (points @ np.ones(len(stress.points)) > 0.5)
        weight = np.tile(r * np.exp(-0.5 * (2.0 * r / radius) ** 2), (len(RAYS), 1)) * inside.reshape(len(RAYS), -1)
        ahead = weight * (abs(RAYS) <= np.pi / 2 + 1e-9)[:, None]
        mean = np.zeros((len(RAYS) + 1, at[..., 0].size))
        for i, (row, whole) in enumerate(zip(weight, weight.sum(axis=1), strict=True)):
            mean[i, i * _ON_RAY : (i + 1) * _ON_RAY] = row / max(whole, 1e-300)
        mean[-1] = (ahead / max(float(ahead.sum()), 1e-300)).ravel()
        operator = sp.vstack([sp.csr_array(mean) @ points @ part for part in stress.operator]).tocsr()
        return cls(tip, heading, radius, operator, inside.reshape(len(RAYS), -1).mean(axis=1))

    @property
    def nothing(self) -> Reading:
        """Of the unloaded body."""
        return Reading(np.zeros((3, len(RAYS))), np.zeros(3))

    def read(self, displacement: Array) -> Reading:
        """From the displacements of the nodes, (m, 2), mm."""
        values = (self.operator @ displacement.ravel()).reshape(3, -1)
        return Reading(values[:, :-1], values[:, -1])

    def hoop(self, reading: Reading) -> Array:
        """Hoop stress of each ray, averaged along it and with its neighbours, MPa; that of a ray outside the body is
        -inf."""
        angle = self.heading + RAYS
        n = np.stack([-np.sin(angle), np.cos(angle)])
        xx, yy, xy = reading.rays
        raw = xx * n[0] ** 2 + yy * n[1] ** 2 + 2 * xy * n[0] * n[1]
        weights = np.exp(-0.5 * ((RAYS[:, None] - RAYS) / _SMOOTHING) ** 2) * self.inside
        smooth = weights @ raw / np.maximum(weights.sum(axis=1), 1e-300)
        return np.where(self.inside > 0.5, smooth, -np.inf)

    def strongest(self, reading: Reading, largest_turn: float) -> tuple[float, float]:
        """Turn from the heading to the ray of the largest hoop stress, radians, and this stress, MPa."""
        hoop = np.where(abs(RAYS) <= largest_turn + 1e-9, self.hoop(reading), -np.inf)
        i = int(hoop.argmax())
        if i in (0, len(RAYS) - 1) or not np.isfinite(hoop[[i - 1, i + 1]]).all():
            return float(RAYS[i]), float(hoop[i])
        low, mid, high = hoop[i - 1 : i + 2]
        bend = low - 2 * mid + high
        shift = 0.0 if bend >= 0 else float(np.clip(0.5 * (low - high) / bend, -1.0, 1.0))
        return float(RAYS[i] + shift * (RAYS[1] - RAYS[0])), float(mid - 0.25 * (low - high) * shift)

    def is_clear(self, reading: Reading, turn: float, stress: float) -> bool:
        """Whether a direction means something: the hoop stress is tensile there and lower to both sides, and the major
        principal stress tells much the same."""
        if abs(turn - self.principal_turn(reading)) > _DISPUTED:
            return False
        hoop = self.hoop(reading)
        hoop = np.where(np.isfinite(hoop), hoop, np.nan)
        sides = [float(np.interp(turn + side, RAYS, hoop)) for side in (-_APART, _APART)]
        sides = [value for value in sides if np.isfinite(value)]
        return stress > 0 and bool(sides) and max(sides) < (1.0 - _CONTRAST) * stress

    def principal_turn(self, reading: Reading) -> float:
        """Turn from the heading to the direction across the major principal stress of the half disc, radians, within 90
        degrees."""
        xx, yy, xy = reading.half_disc
        across = 0.5 * np.arctan2(2 * xy, xx - yy) + np.pi / 2
        return float((across - self.heading + np.pi / 2) % np.pi - np.pi / 2)
