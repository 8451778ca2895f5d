"""How interface points answer to a change of the material: derivatives of tractions, histories and energies.

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
from .interface_points import InterfaceLaw, InterfaceState

#: relative change of a history for the derivative in it
_CHANGE = 1e-6

#: a point this close to its history, relative, does not load: it stands where its damage begins
_CORNER = 1e-9


@dataclass(frozen=True)
class InterfaceVariation:
    """The law of interface points with one parameter changed both ways.

    Attributes
    ----------
    below, above : InterfaceLaw
    half : half the difference of the parameter between them, in its unit
    """

    below: InterfaceLaw
    above: InterfaceLaw
    half: float

    def differences(self, answer: Callable[[InterfaceLaw, float], Array]) -> Array:
        """Derivative of an answer; it is asked of a law and the change of the parameter that belongs to it."""
        return (answer(self.above, self.half) - answer(self.below, -self.half)) / (2.0 * self.half)

    @property
    def onset_jump(self) -> float:
        """Derivative of Zt = w ft/E, at which damage starts."""
        return float(self.above.plane.Zt - self.below.plane.Zt) / (2.0 * self.half)


@dataclass(frozen=True)
class InterfaceSteps:
    """The steps of p points between converged states, n of them below each other, on the branches that the points are on.

    Attributes
    ----------
    start, now : InterfaceState with n p points
    count : n
    loading : (n p,) array, whether damage grows
    kept : (n p,) array, whether the point keeps an older history: neither loading nor undamaged
    slope : (n p, d) array, dZeq/du
    tangent : (n p, d, d) array, the consistent one, MPa/mm
    stress_Z : (n p, d) array, derivative of the traction in a history that is kept, MPa/mm
    touching, touched : indices of the points that are in contact, and of those that are or were
    """

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
    def from_states(cls, law: InterfaceLaw, states: Sequence[InterfaceState]) -> InterfaceSteps:
        """The steps from each of n + 1 states to the next."""
        start, now = (_stacked(part) for part in (states[:-1], states[1:]))
        _, tangent = law.update(now.deformation, start)
        Zeq, slope = law.plane.equivalent_jump(now.deformation)
        history = np.maximum(start.Z, law.plane.Zt)
        loading = Zeq > history * (1.0 + _CORNER)
        corner = ~loading & (Zeq >= history)  # taken by `update` for loading
        if corner.any():
            unloading = InterfaceState(start.deformation[corner], start.stress[corner], start.Z[corner])
            tangent[corner] = law.update(now.deformation[corner], unloading, frozen=True)[1]
        kept = ~loading & (start.Z > law.plane.Zt)
        touching, before = (_in_contact(law, state) for state in (now, start))
        at, jump, Z = np.flatnonzero(touching), now.deformation, now.Z
        far, near = (_traction(law, jump, Z * (1.0 + by), at) for by in (_CHANGE, -_CHANGE))
        stress_Z = np.where(kept[:, None], (far - near) / (2.0 * _CHANGE * Z)[:, None], 0.0)
        return cls(start, now, len(states) - 1, loading, kept, slope, tangent, stress_Z, at, np.flatnonzero(touching | before))

    def one(self, i: int) -> InterfaceSteps:
        """One of the steps."""
        p = len(self.loading) // self.count
        here = slice(i * p, (i + 1) * p)
        start, now = (InterfaceState(s.deformation[here], s.stress[here], s.Z[here]) for s in (self.start, self.now))
        touching, touched = (at[(at >= here.start) & (at < here.stop)] - here.start for at in (self.touching, self.touched))
        return InterfaceSteps(
            start, now, 1, self.loading[here], self.kept[here], self.slope[here], self.tangent[here], self.stress_Z[here],
            touching, touched,
        )  # fmt: skip

    def at_fixed_jumps(self, variation: InterfaceVariation) -> tuple[Array, Array]:
        """Derivatives of the tractions (n p, d) and of the histories (n p,) at constant jumps and kept histories."""

        def stress(law: InterfaceLaw, by: float) -> Array:
            return _traction(law, self.now.deformation, self._history(law, self.now.deformation), self.touching)

        def history(law: InterfaceLaw, by: float) -> Array:
            return self._history(law, self.now.deformation)

        return variation.differences(stress), variation.differences(history)

    def stored(self, variation: InterfaceVariation, started: InterfaceState, motion: Array) -> Array:
        """Derivative of the stored energy per weight, (n p,).

        Parameters
        ----------
        started : derivatives of the start.
        motion : (n p, d) array, those of the jumps.
        """

        def stored(law: InterfaceLaw, by: float) -> Array:
            return law.plane.stored_energy(*self._moved(law, by, started, motion))

        return variation.differences(stored)

    def dissipation(self, variation: InterfaceVariation, started: InterfaceState, motion: Array) -> Array:
        """Derivative of the dissipation of each step per weight, (n p,); parameters as in `stored`."""

        def dissipation(law: InterfaceLaw, by: float) -> Array:
            before, after = self._started(law, by, started), self._moved(law, by, started, motion)
            return law.plane.dissipation(*before, *after)[0]

        return variation.differences(dissipation)

    def contact_work(self, variation: InterfaceVariation, started: InterfaceState, motion: Array) -> Array:
        """Derivative of the work of contact in each step per weight, (n p,); parameters as in `stored`."""
        at, total = self.touched, np.zeros(len(self.loading))
        if not at.size:
            return total

        def work(law: InterfaceLaw, by: float) -> Array:
            (jump0, Z0), (jump, Z) = self._started(law, by, started), self._moved(law, by, started, motion)
            both = law.plane.contact_traction(jump0[at], Z0[at]) + law.plane.contact_traction(jump[at], Z[at])
            return np.asarray(0.5 * np.einsum("pi,pi->p", both, jump[at] - jump0[at]))

        total[at] = variation.differences(work)
        return total

    def _started(self, law: InterfaceLaw, by: float, started: InterfaceState) -> tuple[Array, Array]:
        """Jumps and histories of the start with the parameter changed by so much."""
        Z = np.maximum(self.start.Z + by * started.Z, law.plane.Zt)
        return self.start.deformation + by * started.deformation, Z

    def _moved(self, law: InterfaceLaw, by: float, started: InterfaceState, motion: Array) -> tuple[Array, Array]:
        """Jumps and histories of the step with the parameter changed by so much, each point on its branch."""
        jump = self.now.deformation + by * motion
        return jump, self._history(law, jump) + np.where(self.kept, by * started.Z, 0.0)

    def _history(self, law: InterfaceLaw, jump: Array) -> Array:
        """Histories at jumps, each point on its branch, those that are kept as they are."""
        Zeq, _ = law.plane.equivalent_jump(jump, gradient=False)
        Z = np.where(self.loading, Zeq, np.where(self.kept, self.start.Z, law.plane.Zt))
        return np.asarray(np.maximum(Z, law.plane.Zt))


def _stacked(states: Sequence[InterfaceState]) -> InterfaceState:
    """The points of some states below each other."""
    return InterfaceState(*(np.concatenate([getattr(s, name) for s in states]) for name in ("deformation", "stress", "Z")))


def _traction(law: InterfaceLaw, jump: Array, Z: Array, touching: Index) -> Array:
    """Traction of eq. (21) at histories as they stand, (n, d), with contact at the points `touching`."""
    traction = law.plane.intact(np.maximum(Z, law.plane.Zt))[:, None] * law.plane.stiffness(jump.shape[1]) * jump
    if touching.size:
        traction[touching] += law.plane.contact_traction(jump[touching], Z[touching])
    return np.asarray(traction)


def _in_contact(law: InterfaceLaw, state: InterfaceState) -> Mask:
    """Whether the faces touch at each point, (n,)."""
    phi, _ = law.plane.contact_distance(state.deformation, state.Z)
    return np.asarray(phi < law.plane.contact_reach(state.Z))
