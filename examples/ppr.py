"""The potential of Park, Paulino and Roesler (2009), J. Mech. Phys. Solids 57, 891-908, as a law of a user's script."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cohesive import Law, register_law
from cohesive.__main__ import entry
from meshing.keys import key


class Mode:
    """One of the two factors of the potential, g(x) = (1 - x)^a (1 + x/r)^m with g(0) = 1 and g(1) = 0, r = m/a."""

    def __init__(self, energy: float, strength: float, a: float, peak: float) -> None:
        self.a, self.m = a, a * (a - 1) * peak**2 / (1 - a * peak**2)
        self.r = self.m / a
        shape = a * peak * (1 - peak) ** (a - 1) * (a / self.m + 1) * (a / self.m * peak + 1) ** (self.m - 1)
        self.end = energy / strength * shape
        self.stiffness = energy * (a + self.m) / (self.r * self.end**2)

    def __call__(self, jump: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """g and its derivatives in the jump, 0 beyond the end."""
        x, a, m, r = np.minimum(jump / self.end, 1 - 1e-12), self.a, self.m, self.r
        inside = jump < self.end
        g = (1 - x) ** a * (1 + x / r) ** m
        slope = -(a + m) / r * x * (1 - x) ** (a - 1) * (1 + x / r) ** (m - 1)
        bend = (1 - x) * (1 + x / r) - (a - 1) * x * (1 + x / r) + (m - 1) * x * (1 - x) / r
        bend *= -(a + m) / r * (1 - x) ** (a - 2) * (1 + x / r) ** (m - 2)
        return inside * g, inside * slope / self.end, inside * bend / self.end**2


@register_law("ppr")
@dataclass(frozen=True)
class PPR(Law):
    """Unloads to the origin in each mode by itself, at the other jump as it is, which makes energy in loops."""

    Gn: float = key("fracture energy of opening", 0.2, unit="N/mm", above=0)
    Gt: float = key("fracture energy of sliding", 0.4, unit="N/mm", above=0)
    sigma: float = key("strength of opening", 4.0, unit="MPa", above=0)
    tau: float = key("strength of sliding", 5.0, unit="MPa", above=0)
    alpha: float = key("shape of opening; 2 is about straight, more falls faster", 5.0, above=1)
    beta: float = key("shape of sliding", 1.8, above=1)
    peak_n: float = key("opening at the strength over that at the end", 0.01, above=0, below=0.5)
    peak_t: float = key("sliding at the strength over that at the end", 0.01, above=0, below=0.5)
    makes_energy = True

    @cached_property
    def modes(self) -> tuple[Mode, Mode]:
        return Mode(self.Gn, self.sigma, self.alpha, self.peak_n), Mode(self.Gt, self.tau, self.beta, self.peak_t)

    def scales(self) -> tuple[float, float]:
        return self.sigma, self.Gn

    def stiffness(self, components: int) -> np.ndarray:
        return np.array([self.modes[0].stiffness, *[self.modes[1].stiffness] * (components - 1)])

    def initial(self, points: int) -> np.ndarray:
        return np.zeros((points, 2))

    def update(self, jump: np.ndarray, history: np.ndarray, frozen: bool = False) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        d, size = jump.shape[1], np.linalg.norm(jump[:, 1:], axis=1)
        way = jump[:, 1:] / np.maximum(size, 1e-300)[:, None]
        now = np.stack([np.maximum(jump[:, 0], 0), size], axis=1)
        new = np.maximum(now, history)
        largest, stiffness = max(self.Gn, self.Gt), self.stiffness(2)
        t, T = np.zeros((len(jump), 2)), np.zeros((len(jump), 2, 2))
        for i, (own, other, energy) in enumerate(zip(self.modes, self.modes[::-1], (self.Gn, self.Gt), strict=True)):
            g, slope, _ = other(now[:, 1 - i])
            factor = largest * g - (largest - energy)  # of the other mode, until it has used up the energy
            _, f, df = own(new[:, i])
            secant = np.where(new[:, i] > 0, -f / np.maximum(new[:, i], 1e-300), stiffness[i] / energy)
            rate = np.where((now[:, i] >= history[:, i]) & (not frozen) & (new[:, i] > 0), -df, secant)
            t[:, i] = secant * now[:, i] * np.maximum(factor, 0)
            T[:, i, i] = rate * np.maximum(factor, 0)
            T[:, i, 1 - i] = secant * now[:, i] * largest * slope * (factor > 0)
        closed = jump[:, 0] < 0
        t[:, 0] += stiffness[0] * np.minimum(jump[:, 0], 0)
        T[closed, 0, 0], T[closed, 0, 1], T[closed, 1, 0] = stiffness[0], 0, 0
        tangent = np.zeros((len(jump), d, d))
        tangent[:, 0, 0], tangent[:, 0, 1:], tangent[:, 1:, 0] = T[:, 0, 0], T[:, 0, 1, None] * way, T[:, 1, 0, None] * way
        secant = np.where(size > 0, t[:, 1] / np.maximum(size, 1e-300), T[:, 1, 1])
        both = way[:, :, None] * way[:, None]
        tangent[:, 1:, 1:] = T[:, 1, 1, None, None] * both + secant[:, None, None] * (np.eye(d - 1) - both)
        tangent[size == 0, 1:, 1:] = T[size == 0, 1, 1, None, None] * np.eye(d - 1)
        return np.column_stack([t[:, 0], t[:, 1, None] * way]), tangent, new

    def stored_energy(self, jump: np.ndarray, history: np.ndarray) -> np.ndarray:
        return 0.5 * (self.update(jump, history)[0] * jump).sum(axis=1)


if __name__ == "__main__":
    entry()
