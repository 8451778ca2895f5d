"""Smeared cracks at the points of a band: eqs (22)-(43) and Box 1 of the paper.

The strain of a point splits into an elastic part and the fracture strains of its crack planes. On each plane the stress
equals the traction of a law at the jump l_ch e, where e is the plane's local strain [normal, engineering shear] and l_ch the
length of the element along its normal: of the crack-plane law with the width l_ch, eq. (24), or of another that takes a width.

    sigma = De ( eps - sum_j N_j^T (e_j - C s_j) ),   s_j = law(l_ch e_j),   psi_i = N_i sigma - s_i = 0     (26)-(30), (41)

With T = ds/de the matrix M = T + N De N^T (I - C T), stacked over the planes of a point, drives the local iteration,
M de = psi (42), (43), and gives the consistent tangent, M de = N De deps, dsigma = De (deps - N^T (I - C T) de), which
is eq. (37) without an inverse. Open planes share shear stress: M of two has rank 3 of 4 in the plane and 5 of 6 in space,
there M of three 6 of 9 at most, and de of minimum norm is taken.

The number of components follows from De, see `elements.rotations.PAIRS`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Array, Index
from ..elements.chords import longest_chord
from ..elements.rotations import rotations, stress_tensor, stress_transformation
from ..errors import PointFailure
from ..law.concrete import Concrete
from ..law.registry import Law
from .band_iteration import LocalIteration
from .crack_planes import CrackPlanes

#: planes due whose excess over ft is at least this part of the largest excess are formed together
_WORST = 0.5


@dataclass(frozen=True)
class BandState:
    """Strain (p, k), stress (p, k) in MPa, and the crack planes."""

    deformation: Array
    stress: Array
    planes: CrackPlanes


@dataclass(frozen=True)
class CrackBand:
    """Smeared cracks at p points: a `PointLaw` whose deformation is the strain.

    Parameters
    ----------
    law : Law that takes a width, of any; each crack takes l_ch for its own.
    D : (k, k) array, MPa, elasticity.
    corners : (p, m, d) array, mm, corners of the element of each point, see `longest_chord`.
    max_cracks : planes per point.
    threshold_angle : least angle between the normals of two planes of a point, degrees.
    path_normal : (p, d) array, or None. With it each point has one plane, across this normal and there from the beginning,
        as a discrete crack along the path. Without it planes form across the major principal stress: ahead of a crack the
        principal stresses are close, and the least asymmetry of a mesh turns a new plane at will.
    """

    law: Law
    D: Array
    corners: Array
    max_cracks: int = 3
    threshold_angle: float = 60.0
    path_normal: Array | None = None
    quantity = "strain"

    @property
    def onset_jump(self) -> float:
        span = np.ptp(self.corners, axis=1).max(axis=1).min()
        return self.law.with_width(float(span)).onset_jump

    @property
    def is_checked(self) -> bool:
        return self.law.is_checked

    def of_material(self, concrete: Concrete) -> CrackBand:
        return replace(self, law=self.law.built_for(concrete, self.law.width, self.corners.shape[2]))

    @property
    def compliance(self) -> Array:
        """Diagonal of C, 1/MPa: (d,)."""
        d = self.corners.shape[2]
        return np.asarray(1.0 / self.law.with_width(1.0).stiffness(d))

    def initial(self) -> BandState:
        p, k, d = len(self.corners), len(self.D), self.corners.shape[2]
        zeros, none = np.zeros((p, k)), np.zeros((0, d))
        at = np.zeros(0, dtype=np.intp)
        cracks = CrackPlanes(at, np.zeros((0, d, d)), np.zeros(0), none, none, self.law.initial(0), np.zeros((0, d, k)))
        state = BandState(zeros, zeros, cracks)
        return state if self.path_normal is None else self._with_planes(state, np.arange(p), self.path_normal)

    def elastic(self) -> Array:
        return np.broadcast_to(self.D, (len(self.corners), *self.D.shape))

    def update(self, deformation: Array, start: BandState, frozen: bool = False) -> tuple[BandState, Array]:
        """Stress and consistent tangent, eqs (30) and (37).

        Parameters
        ----------
        deformation : (p, k) array, strain.
        start : BandState, the last converged one; it is not changed, and no iterate raises its history.
        frozen : tangent of the unloading branch, if a plane has two.

        Raises
        ------
        PointFailure
            If the planes of a point have no solution that continues the committed one.
        """
        stress = deformation @ self.D.T
        tangent = self.elastic().copy()
        cracks = start.planes
        e, traction = cracks.strain.copy(), cracks.traction.copy()
        history, slope = cracks.history.copy(), cracks.slope.copy()
        if len(cracks.point):
            local = LocalIteration(self.law, self.D, self.compliance, cracks, deformation)
            failed = np.flatnonzero(~local.solve(start.deformation, frozen))
            if failed.size:
                raise PointFailure(
                    f"the crack planes of {failed.size} point(s) have no solution that continues the last one"
                    f"{self.law.advice}; first",
                    int(local.points[failed[0]]),
                )
            points, planes = local.points, local.planes
            stress[points], tangent[points], *rest = local.respond(frozen)
            traction[planes], history[planes], slope[planes] = (local.on_planes(each) for each in rest)
            e[planes] = local.on_planes(local.e.reshape(local.shape))
        cracks = replace(cracks, strain=e, traction=traction, history=history, slope=slope)
        return BandState(deformation, stress, cracks), tangent

    def nucleate(self, start: BandState, state: BandState) -> BandState | None:
        """One more plane at the points whose major principal stress in `state` exceeds ft most, undamaged in `start`; none if
        the planes lie on a path."""
        if self.path_normal is not None:
            return None
        ft, cracks = self.law.strength, state.planes
        count = np.bincount(cracks.point, minlength=len(self.corners))
        value, vector = np.linalg.eigh(stress_tensor(state.stress))
        value, normal = value[:, ::-1], vector[:, :, ::-1].transpose(0, 2, 1)  # (p, which, component), major first
        due = (value > ft * (1.0 + 1e-11)) & (count < self.max_cracks)[:, None]
        # no plane whose normal lies closer than the threshold to one that is there
        if len(cracks.point):
            cosine = abs(np.einsum("cwx,cx->cw", normal[cracks.point], cracks.rotation[:, 0]))
            near = cosine > np.cos(np.radians(self.threshold_angle)) + 1e-9
            crowded = np.zeros_like(due)
            np.logical_or.at(crowded, cracks.point, near)
            due &= ~crowded
        if not due.any():
            return None
        which = due.argmax(axis=1)  # the largest one that is due
        excess = np.where(due.any(axis=1), value[np.arange(len(value)), which] - ft, 0.0)
        points = np.flatnonzero(excess >= _WORST * excess.max())
        return self._with_planes(start, points, normal[points, which[points]])

    def _with_planes(self, start: BandState, points: Index, normal: Array) -> BandState:
        """A committed state with one more plane at some points, inert: its strain there is elastic."""
        rotation, count = rotations(normal), np.bincount(start.planes.point, minlength=len(self.corners))
        N = stress_transformation(rotation)
        traction = np.einsum("ndk,nk->nd", N, start.stress[points])
        strain = self.compliance * traction
        length = longest_chord(self.corners[points], rotation[:, 0])
        old = start.planes
        # elastic at a point without others, whose slopes it would depend on
        slope = np.where((count[points] == 0)[:, None, None], self.compliance[:, None] * (N @ self.D), 0.0)
        fresh = (points, rotation, length, strain, traction, self.law.with_width(length).initial(len(length)), slope)
        names = ("point", "rotation", "length", "strain", "traction", "history", "slope")
        grown = {name: np.concatenate([getattr(old, name), new]) for name, new in zip(names, fresh, strict=True)}
        return replace(start, planes=CrackPlanes(**grown))

    def law_of(self, cracks: CrackPlanes) -> Law:
        """The law of some planes, each with its own width."""
        return self.law.with_width(cracks.length)

    def strength_left(self, cracks: CrackPlanes) -> Array:
        """See `Law.strength_left`, of each plane."""
        return self.law_of(cracks).strength_left(cracks.history) if len(cracks.point) else np.zeros(0)

    def is_damaging(self, deformation: Array, start: BandState) -> bool:
        state, _ = self.update(deformation, start)
        damaging = self.law_of(start.planes).is_damaging(state.planes.jump, start.planes.history)
        return bool(damaging.any()) or self.nucleate(start, state) is not None

    def is_on_surface(self, state: BandState) -> bool:
        cracks = state.planes
        return bool(len(cracks.point) and self.law_of(cracks).is_on_surface(cracks.jump, cracks.history).any())

    def is_separated(self, state: BandState) -> bool:
        cracks = state.planes
        gone = abs(cracks.traction).max(axis=1, initial=0.0) < 1e-8 * self.law.strength
        if len(np.unique(cracks.point[gone])) < len(self.corners):
            return False
        gone &= self.law_of(cracks).is_fully_softened(cracks.history)
        return len(np.unique(cracks.point[gone])) == len(self.corners)

    def energies(self, state: BandState) -> tuple[Array, Array]:
        """Elastic energy of the stress, and what the planes store beyond it: the energy of the undamaged part of
        a plane less its share s.C.s / 2 of the former."""
        cracks = state.planes
        elastic = 0.5 * np.einsum("pi,pi->p", state.stress, np.linalg.solve(self.D, state.stress.T).T)
        law = self.law_of(cracks)
        stored = law.stored_energy(cracks.jump, cracks.history) / cracks.length
        stored -= 0.5 * (cracks.traction**2 * self.compliance).sum(axis=1)
        return elastic, self._sum(cracks, stored)

    def dissipation(self, start: BandState, state: BandState) -> tuple[Array, Array]:
        before, after = start.planes, state.planes
        law = self.law_of(after)
        value, gradient = law.dissipation(before.jump, before.history, after.jump, after.history)
        along = np.einsum("cd,cdk->ck", gradient, after.slope)
        total = np.zeros_like(state.deformation)
        np.add.at(total, after.point, along)
        return self._sum(after, value / after.length), total

    def contact_work(self, start: BandState, state: BandState) -> Array:
        before, after = start.planes, state.planes
        law = self.law_of(after)
        contact = law.contact_traction(before.jump, before.history) + law.contact_traction(after.jump, after.history)
        return self._sum(after, 0.5 * np.einsum("ci,ci->c", contact, after.strain - before.strain))

    def _sum(self, cracks: CrackPlanes, values: Array) -> Array:
        return np.bincount(cracks.point, values, len(self.corners)).astype(float)
