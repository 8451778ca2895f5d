"""How interface points answer to a change of the material, with the crack-plane law: derivatives of tractions, histories and
energies.

What a parameter changes at a fixed state is differenced, with two planes whose parameter lies a millionth below and above.
On a fixed branch (loading or not, in contact or not) the law is smooth but for the kinks of a softening curve, so that a
central difference keeps nine digits: the truncation is some 1e-12, the rounding 1e-10. What the unknowns change comes from the
consistent tangent of eq. (21). All steps of a run are looked at together, which costs little more than one of them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Array, Index, Mask
from ..law.crack_plane import CrackPlane
from .interface_points import InterfaceLaw, InterfaceState
from .point_law import PointLaw

#: relative change of a history for the derivative in it
_CHANGE = 1e-6

#: a point this close to its history, relative, does not load: it stands where its damage begins
_CORNER = 1e-9


@dataclass(frozen=True)
class InterfaceVariation:
    """The law of interface points with one parameter changed both ways.

    Attributes
    ----------
    below, above : CrackPlane
    half : half the difference of the parameter between them, in its unit
    """

    below: CrackPlane
    above: CrackPlane
    half: float

    @classmethod
    def from_laws(cls, below: PointLaw, above: PointLaw, half: float) -> InterfaceVariation:
        """Of the points of two problems."""
        return cls(_plane(below), _plane(above), half)

    def differences(self, answer: Callable[[CrackPlane, float], Array]) -> Array:
        """Derivative of an answer; it is asked of a law and the change of the parameter that belongs to it."""
        return (answer(self.above, self.half) - answer(self.below, -self.half)) / (2.0 * self.half)

    @property
    def onset_jump(self) -> float:
        """Derivative of Zt = w ft/E, at which damage starts."""
        return float(self.above.Zt - self.below.Zt) / (2.0 * self.half)


@dataclass(frozen=True)
class InterfaceSteps:
    """The steps of p points between converged states, n of them below each other, on the branches that the points are on.

    Attributes
    ----------
    plane : CrackPlane
    start, now : InterfaceState with n p points
    count : n
    loading : (n p,) array, whether damage grows
    kept : (n p,) array, whether the point keeps an older history: neither loading nor undamaged
    slope : (n p, d) array, dZeq/du
    tangent : (n p, d, d) array, the consistent one, MPa/mm
    stress_Z : (n p, d) array, derivative of the traction in a history that is kept, MPa/mm
    touching, touched : indices of the points that are in contact, and of those that are or were
    """

    plane: CrackPlane
    start: InterfaceState
    now: InterfaceState
    count: int
    loading: Mask
    kept: Mask
    slope: Array
    tangent: Array
    stress_Z: Array
    touching: Index
    touched: Index

    @classmethod
    def from_states(cls, law: PointLaw, states: Sequence[InterfaceState]) -> InterfaceSteps:
        """The steps from each of n + 1 states to the next."""
        plane = _plane(law)
        start, now = (_stacked(part) for part in (states[:-1], states[1:]))
        _, tangent, _ = plane.update(now.deformation, start.history)
        Zeq, slope = plane.equivalent_jump(now.deformation)
        history = np.maximum(start.history, plane.Zt)
        loading = Zeq > history * (1.0 + _CORNER)
        corner = ~loading & (Zeq >= history)  # taken by `update` for loading
        if corner.any():
            tangent[corner] = plane.update(now.deformation[corner], start.history[corner], frozen=True)[1]
        kept = ~loading & (start.history > plane.Zt)
        touching, before = (_in_contact(plane, state) for state in (now, start))
        at, jump, Z = np.flatnonzero(touching), now.deformation, now.history
        far, near = (_traction(plane, jump, Z * (1.0 + by), at) for by in (_CHANGE, -_CHANGE))
        stress_Z = np.where(kept[:, None], (far - near) / (2.0 * _CHANGE * Z)[:, None], 0.0)
        touched = np.flatnonzero(touching | before)
        return cls(plane, start, now, len(states) - 1, loading, kept, slope, tangent, stress_Z, at, touched)

    def one(self, i: int) -> InterfaceSteps:
        """One of the steps."""
        p = len(self.loading) // self.count
        here = slice(i * p, (i + 1) * p)
        start, now = (InterfaceState(s.deformation[here], s.stress[here], s.history[here]) for s in (self.start, self.now))
        touching, touched = (at[(at >= here.start) & (at < here.stop)] - here.start for at in (self.touching, self.touched))
        return InterfaceSteps(
            self.plane, start, now, 1, self.loading[here], self.kept[here], self.slope[here], self.tangent[here],
            self.stress_Z[here], touching, touched,
        )  # fmt: skip

    def at_fixed_jumps(self, variation: InterfaceVariation) -> tuple[Array, Array]:
        """Derivatives of the tractions (n p, d) and of the histories (n p,) at constant jumps and kept histories."""

        def stress(plane: CrackPlane, by: float) -> Array:
            return _traction(plane, self.now.deformation, self._history(plane, self.now.deformation), self.touching)

        def history(plane: CrackPlane, by: float) -> Array:
            return self._history(plane, self.now.deformation)

        return variation.differences(stress), variation.differences(history)

    def stored(self, variation: InterfaceVariation, started: InterfaceState, motion: Array) -> Array:
        """Derivative of the stored energy per weight, (n p,).

        Parameters
        ----------
        started : derivatives of the start.
        motion : (n p, d) array, those of the jumps.
        """

        def stored(plane: CrackPlane, by: float) -> Array:
            return plane.stored_energy(*self._moved(plane, by, started, motion))

        return variation.differences(stored)

    def dissipation(self, variation: InterfaceVariation, started: InterfaceState, motion: Array) -> Array:
        """Derivative of the dissipation of each step per weight, (n p,); parameters as in `stored`."""

        def dissipation(plane: CrackPlane, by: float) -> Array:
            before, after = self._started(plane, by, started), self._moved(plane, by, started, motion)
            return plane.dissipation(*before, *after)[0]

        return variation.differences(dissipation)

    def contact_work(self, variation: InterfaceVariation, started: InterfaceState, motion: Array) -> Array:
        """Derivative of the work of contact in each step per weight, (n p,); parameters as in `stored`."""
        at, total = self.touched, np.zeros(len(self.loading))
        if not at.size:
            return total

        def work(plane: CrackPlane, by: float) -> Array:
            (jump0, Z0), (jump, Z) = self._started(plane, by, started), self._moved(plane, by, started, motion)
            both = plane.contact_traction(jump0[at], Z0[at]) + plane.contact_traction(jump[at], Z[at])
            return np.asarray(0.5 * np.einsum("pi,pi->p", both, jump[at] - jump0[at]))

        total[at] = variation.differences(work)
        return total

    def onset(self, i: int, variations: Sequence[InterfaceVariation], histories: Array, weights: Array) -> tuple[Array, Array]:
        """A step that ended where the next point begins to be damaged further, and Zeq is its history: derivatives of Zeq in
        the jumps over the weight, (p, d), and those of what it lacks at constant jumps, (m,).

        Parameters
        ----------
        histories : (m, p) array, derivatives of the histories before the step
        """
        p = len(self.loading) // self.count
        jump, Z = (part[i * p : (i + 1) * p] for part in (self.now.deformation, self.start.history))
        at = int(np.argmax(self.plane.equivalent_jump(jump)[0] / Z))
        gradient = np.zeros_like(jump)
        gradient[at] = self.slope[i * p + at] / weights[at]

        def equivalent(plane: CrackPlane, by: float) -> Array:
            return plane.equivalent_jump(jump[[at]], gradient=False)[0]

        gaps = np.array([float(each.differences(equivalent)[0]) for each in variations])
        return gradient, gaps - histories[:, at]

    def _started(self, plane: CrackPlane, by: float, started: InterfaceState) -> tuple[Array, Array]:
        """Jumps and histories of the start with the parameter changed by so much."""
        Z = np.maximum(self.start.history + by * started.history, plane.Zt)
        return self.start.deformation + by * started.deformation, Z

    def _moved(self, plane: CrackPlane, by: float, started: InterfaceState, motion: Array) -> tuple[Array, Array]:
        """Jumps and histories of the step with the parameter changed by so much, each point on its branch."""
        jump = self.now.deformation + by * motion
        return jump, self._history(plane, jump) + np.where(self.kept, by * started.history, 0.0)

    def _history(self, plane: CrackPlane, jump: Array) -> Array:
        """Histories at jumps, each point on its branch, those that are kept as they are."""
        Zeq, _ = plane.equivalent_jump(jump, gradient=False)
        Z = np.where(self.loading, Zeq, np.where(self.kept, self.start.history, plane.Zt))
        return np.asarray(np.maximum(Z, plane.Zt))


def _plane(law: PointLaw) -> CrackPlane:
    """The law of points, which `is_differentiated`."""
    assert isinstance(law, InterfaceLaw) and isinstance(law.law, CrackPlane)
    return law.law


def _stacked(states: Sequence[InterfaceState]) -> InterfaceState:
    """The points of some states below each other."""
    names = ("deformation", "stress", "history")
    return InterfaceState(*(np.concatenate([getattr(s, name) for s in states]) for name in names))


def _traction(plane: CrackPlane, jump: Array, Z: Array, touching: Index) -> Array:
    """Traction of eq. (21) at histories as they stand, (n, d), with contact at the points `touching`."""
    traction = plane.intact(np.maximum(Z, plane.Zt))[:, None] * plane.stiffness(jump.shape[1]) * jump
    if touching.size:
        traction[touching] += plane.contact_traction(jump[touching], Z[touching])
    return np.asarray(traction)


def _in_contact(plane: CrackPlane, state: InterfaceState) -> Mask:
    """Whether the faces touch at each point, (n,)."""
    phi, _ = plane.contact_distance(state.deformation, state.history)
    return np.asarray(phi < plane.contact_reach(state.history))
