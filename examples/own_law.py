"""A traction law of a user's script, bilinear and mixed-mode: `python own_law.py run scene.toml -o out`, and all commands."""

from dataclasses import dataclass

import numpy as np

from cohesive import Law, register_law
from cohesive.__main__ import entry
from meshing.keys import key


@register_law("my-bilinear")
@dataclass(frozen=True)
class Bilinear(Law):
    """Damage grows with sqrt(max(u1, 0)^2 + (r s)^2); a plane of the width of the scene, so that it makes a band, too."""

    r: float = key("weight of sliding against opening", 0.5, above=0)
    takes_width = True

    def stiffness(self, components: int) -> np.ndarray:
        moduli = np.array([self.concrete.E, self.concrete.G, self.concrete.G])[:components]
        return moduli / np.expand_dims(self.width, -1)

    def initial(self, points: int) -> np.ndarray:
        return np.broadcast_to(self.strength * self.width / self.concrete.E, points).astype(float)

    def intact(self, history: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        first, last = self.initial(len(history)), 2 * self.energy / self.strength
        left = first * (first + last - history) / (history * last)
        return np.maximum(left, 0), np.where(left > 0, -first * (first + last) / (history**2 * last), 0)

    def update(self, jump: np.ndarray, history: np.ndarray, frozen: bool = False) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        weighted = jump * np.where(np.arange(jump.shape[1]) > 0, self.r, jump > 0)
        size, k = np.linalg.norm(weighted, axis=1), self.stiffness(jump.shape[1])
        new = np.maximum(size, history)
        left, slope = self.intact(new)
        share = np.where((np.arange(jump.shape[1]) > 0) | (jump > 0), left[:, None], 1.0)
        way = weighted * np.where(np.arange(jump.shape[1]) > 0, self.r, 1.0) / np.maximum(size, 1e-300)[:, None]
        grows = (size >= history) & (size > self.initial(len(size))) & (not frozen)
        damaged = np.where(share < 1, k * jump * (slope * grows)[:, None], 0.0)
        return share * k * jump, (share * k)[:, :, None] * np.eye(jump.shape[1]) + damaged[:, :, None] * way[:, None], new

    def stored_energy(self, jump: np.ndarray, history: np.ndarray) -> np.ndarray:
        share = np.where((np.arange(jump.shape[1]) > 0) | (jump > 0), self.intact(history)[0][:, None], 1.0)
        return 0.5 * (share * self.stiffness(jump.shape[1]) * jump**2).sum(axis=1)


if __name__ == "__main__":
    entry()
