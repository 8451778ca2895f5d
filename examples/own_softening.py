"""A softening curve of a user's script: a straight line that ends at 2 Gf/ft."""

import numpy as np

from cohesive import Result, Scene, register_softening, run


@register_softening("my-line")
class Line:
    """Stress over the jump beyond the onset of damage."""

    def __init__(self, ft: float, Gf: float) -> None:
        self.ft, self.end = ft, 2 * Gf / ft  # the area is Gf

    def stress(self, w: np.ndarray) -> np.ndarray:
        """MPa, 0 from the end on."""
        return np.maximum(self.ft * (1 - w / self.end), 0.0)

    def slope(self, w: np.ndarray) -> np.ndarray:
        """MPa/mm."""
        return np.where(w < self.end, -self.ft / self.end, 0.0)

    def work(self, w: np.ndarray) -> np.ndarray:
        """Area up to w, N/mm."""
        w = np.minimum(w, self.end)
        return self.ft * w * (1 - w / (2 * self.end))


def main() -> Result:
    """Run the notched beam with it."""
    return run(Scene.load("notched-beam").with_(**{"material.softening": "my-line"}))


if __name__ == "__main__":
    print(main().summary())
