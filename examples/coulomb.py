"""Damage with Coulomb friction, Alfano and Sacco (2006), Int. J. Numer. Meth. Engng 68, 542-582, as a law of a script."""

from dataclasses import dataclass

import numpy as np

from cohesive import Law, register_law
from cohesive.__main__ import entry
from meshing.keys import key


@register_law("coulomb")
@dataclass(frozen=True)
class Coulomb(Law):
    """The damaged part D of a plane slides with friction if it is pressed, the rest is elastic. Histories: D, slip, heats."""

    GI: float = key("fracture energy of opening", 0.3, unit="N/mm", above=0)
    GII: float = key("fracture energy of sliding", 0.3, unit="N/mm", above=0)
    strength_n: float = key("strength of opening", 3.0, unit="MPa", above=0)
    strength_t: float = key("strength of sliding", 3.0, unit="MPa", above=0)
    k: float = key("stiffness of opening; that of sliding has the same brittleness", 150.0, unit="MPa/mm", above=0)
    mu: float = key("coefficient of friction", 0.5, at_least=0)
    columns = {"damage_heat": "N/mm", "friction_heat": "N/mm"}  # noqa: RUF012

    @property
    def onsets(self) -> np.ndarray:
        """Opening and sliding at which damage begins, mm."""
        first = self.strength_n / self.k
        return np.array([first, first * (self.GII / self.strength_t) / (self.GI / self.strength_n)])

    @property
    def eta(self) -> float:
        """1 - onset over end, of both modes."""
        return 1.0 - self.strength_n * self.onsets[0] / (2.0 * self.GI)

    def scales(self) -> tuple[float, float]:
        return self.strength_n, self.GI

    def stiffness(self, components: int) -> np.ndarray:
        return np.array([self.k, *[self.strength_t / self.onsets[1]] * (components - 1)])

    def initial(self, points: int) -> np.ndarray:
        return np.zeros((points, 2 + self.components))

    def update(self, jump: np.ndarray, history: np.ndarray, frozen: bool = False) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        (k, kt), d = self.stiffness(2), jump.shape[1]
        opening, shear, eye = np.maximum(jump[:, 0], 0.0), jump[:, 1:], np.eye(d - 1)
        scaled = np.column_stack([opening / self.onsets[0], shear / self.onsets[1]])
        size = np.maximum(np.linalg.norm(scaled, axis=1), 1.0)
        reached = np.minimum((size - 1.0) / (self.eta * size), 1.0)
        D = np.maximum(history[:, 0], reached)
        grows = (reached >= history[:, 0]) & (reached > 0) & (reached < 1) & (not frozen)
        scales = np.array([self.onsets[0], *[self.onsets[1]] * (d - 1)])
        dD = (grows / (self.eta * size**3))[:, None] * scaled / scales
        # friction of the damaged part
        pressed, limit = jump[:, 0] < 0, self.mu * k * np.maximum(-jump[:, 0], 0.0)
        trial = kt * (shear - history[:, 1:d])
        length = np.maximum(np.linalg.norm(trial, axis=1), 1e-300)
        slides, way = length > limit, trial / length[:, None]
        tau = np.where(slides[:, None], limit[:, None] * way, trial)
        slip = shear - tau / kt
        part = np.where(slides & (not frozen), limit / length, 1.0) * pressed
        across = (part * slides * (not frozen))[:, None, None] * way[:, :, None] * way[:, None]
        tangent = np.zeros((len(jump), d, d))
        tangent[:, 0, 0] = np.where(pressed, k, (1.0 - D) * k)
        tangent[:, 0] -= (k * opening)[:, None] * dD
        tangent[:, 1:, 1:] = ((1.0 - D) * kt)[:, None, None] * eye
        tangent[:, 1:, 1:] += (D * kt)[:, None, None] * (part[:, None, None] * eye - across)
        tangent[:, 1:, 0] = -(D * self.mu * k * (pressed & slides & (not frozen)))[:, None] * way
        tangent[:, 1:] += (tau - kt * shear)[:, :, None] * dD[:, None]
        # heat of damage, exact if the jump grows in proportion; of friction, at the tractions in the end
        energy = 0.5 * (k * opening**2 + kt * (shear**2).sum(axis=1) - (tau**2).sum(axis=1) / kt)
        before, after = (1.0 / (1.0 - self.eta * each) for each in (history[:, 0], D))
        damage_heat = history[:, -2] + np.maximum(energy, 0.0) / after**2 * (after - before) / self.eta
        friction_heat = history[:, -1] + D * (tau * (slip - history[:, 1:d])).sum(axis=1)
        normal = k * jump[:, 0] - D * k * opening
        traction = np.column_stack([normal, (1.0 - D)[:, None] * kt * shear + D[:, None] * tau])
        return traction, tangent, np.column_stack([D, slip, damage_heat, friction_heat])

    def stored_energy(self, jump: np.ndarray, history: np.ndarray) -> np.ndarray:
        (k, kt), D = self.stiffness(2), history[:, 0]
        shear, spring = (kt * (part**2).sum(axis=1) for part in (jump[:, 1:], jump[:, 1:] - history[:, 1:-2]))
        return 0.5 * (k * np.where(jump[:, 0] < 0, 1.0, 1.0 - D) * jump[:, 0] ** 2 + (1.0 - D) * shear + D * spring)

    def dissipation(
        self, jump0: np.ndarray, history0: np.ndarray, jump1: np.ndarray, history1: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        def heat(jump: np.ndarray) -> np.ndarray:
            return (self.update(jump, history0)[2] - history0)[:, -2:].sum(axis=1)

        return heat(jump1), self.slope(heat, jump1)

    def is_damaged(self, history: np.ndarray) -> np.ndarray:
        return history[:, 0] > 0

    def fields(self, jump: np.ndarray, history: np.ndarray) -> dict[str, np.ndarray]:
        return {"damage_heat": history[:, -2], "friction_heat": history[:, -1]}


if __name__ == "__main__":
    entry()
