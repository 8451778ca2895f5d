"""What a scene will take, from its element sizes and before anything is meshed."""

from __future__ import annotations

from dataclasses import dataclass, replace

from ..algebra.choice import machine_memory
from ..errors import SceneError
from ..scenes.scene import Scene
from ..solver.stages import expected_steps

#: memory of any run, bytes; bytes for each unknown in 2D; in 3D, where fronts grow, times its root of third order besides
_ANY, _FLAT, _SOLID = 2e8, 3e3, 6e2

#: CPU seconds of any run; for each unknown in 2D; in 3D for each pair of unknowns
_START, _FLAT_SECONDS, _SOLID_SECONDS = 1.5, 4e-5, 2e-9

#: CPU seconds of any step; of Newton's method in it with the jumps alone, for their number to the power 2.5, or with all
#: unknowns, for each
_STEP_SECONDS, _DENSE_SECONDS, _SPARSE_SECONDS = 1.3e-3, 2e-9, 3e-5

#: in a band, CPU seconds of a step for each jump over it, whose points iterate, and how much more Newton's method takes there
_BAND_SECONDS, _BAND_FACTOR = 2e-4, 11.0

#: by how much larger elements are tried at most, to tell which would fit
_LARGEST = 1e6


@dataclass(frozen=True)
class Estimate:
    """What a scene is expected to take, unknowns within a factor of 2, the others within one of 3.

    Attributes
    ----------
    unknowns : number of them, before condensation
    memory : bytes
    seconds : CPU time of a run with all its steps, if none is cut
    """

    unknowns: float
    memory: float
    seconds: float

    @property
    def text(self) -> str:
        """In words."""
        return f"about {self.unknowns:.2g} unknowns, {self.memory / 1e9:.2g} GB and {self.time}"

    @property
    def time(self) -> str:
        """The time in words."""
        if self.seconds < 100:
            return f"{self.seconds:.0f} s"
        return f"{self.seconds / 60:.2g} min" if self.seconds < 6000 else f"{self.seconds / 3600:.2g} h"


def estimate(scene: Scene, larger: float = 1.0) -> Estimate | None:
    """What a scene will take; None with a user mesh.

    Parameters
    ----------
    larger : factor of the element sizes.
    """
    if scene.sizes is None:
        return None
    sizes = replace(scene.sizes, crack_size=larger * scene.sizes.crack_size, far_size=larger * scene.sizes.far_size)
    d = scene.dimension
    nodes, on_face = scene.specimen.expected_nodes(sizes, half=scene.model.half, dimension=d)
    n, jumps = d * nodes, d * on_face
    is_band = scene.model.kind == "smeared"
    if is_band and scene.band.where == "everywhere":
        jumps = n
    step = min(_DENSE_SECONDS * jumps**2.5 * (_BAND_FACTOR if is_band else 1.0), _SPARSE_SECONDS * n)
    step += _BAND_SECONDS * jumps if is_band else _STEP_SECONDS
    newton = step * expected_steps(scene.stages)
    if d == 2:
        return Estimate(n, _ANY + _FLAT * n, _START + _FLAT_SECONDS * n + newton)
    return Estimate(n, _ANY + _SOLID * n ** (4 / 3), _START + _SOLID_SECONDS * n**2 + newton)


def check_fits(scene: Scene) -> None:
    """Refuse a scene that the memory of this machine will not hold.

    Raises
    ------
    SceneError
        Naming the element size, what it takes, and the least one that would fit.
    """
    expected, limit = estimate(scene), machine_memory()
    if expected is None or expected.memory <= limit:
        return
    assert scene.sizes is not None
    low, high = 1.0, _LARGEST
    while high > 1.05 * low:
        middle = (low * high) ** 0.5
        tried = estimate(scene, middle)
        assert tried is not None
        low, high = (middle, high) if tried.memory > limit else (low, middle)
    raise SceneError.at(
        "mesh.crack_size",
        f" = {scene.sizes.crack_size:.3g} and far_size = {scene.sizes.far_size:.3g} give {expected.text}, this "
        f"machine has {limit / 1e9:.2g} GB; expected at least {high * scene.sizes.crack_size:.2g} and "
        f"{high * scene.sizes.far_size:.2g} mm, or a smaller body",
    )
