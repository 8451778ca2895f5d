"""A model that is kept: its mesh and its condensed stiffness serve all scenes that differ in what neither depends on."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from ..errors import SceneError
from ..scenes.scene import Scene
from .build import build
from .model import Model

#: keys of the tables below that change neither the mesh nor the condensed stiffness
_FREE = {
    "band": ("width", "planes", "max_cracks", "threshold_angle"),  # the width as it follows, below
    "interface": ("width",),
    "solver": ("tol", "step_growth"),
    "mesh": (),
    "model": (),
    "specimen": (),
}


@dataclass(frozen=True)
class Prepared:
    """A meshed, assembled and condensed scene, to be run with other materials.

    The condensed stiffness depends on nu and density, on the specimen, its mesh and its supports; it is proportional to E,
    unless the specimen has regions with a modulus of their own. Strength, softening curve, contact, stages, reference and
    output may change. Where a scene names no sizes, those hold that followed from the start values.

    Attributes
    ----------
    scene : Scene, as prepared, which names all sizes
    fixed : sizes that the scene did not name, by key ("mesh.crack_size", "mesh.far_size", "interface.width"), mm
    model : Model of the scene
    """

    scene: Scene
    fixed: dict[str, float]
    model: Model

    @property
    def crack_size(self) -> float | None:
        """Size of elements along the crack, mm; None with a user mesh."""
        return None if self.scene.sizes is None else self.scene.sizes.crack_size

    @property
    def far_size(self) -> float | None:
        """Size of elements far from the crack, mm; None with a user mesh."""
        return None if self.scene.sizes is None else self.scene.sizes.far_size

    @property
    def width(self) -> float:
        """Width of the crack plane or of the band, mm."""
        return self.model.cracks.width

    def __repr__(self) -> str:
        sizes = {"crack_size": self.crack_size, "far_size": self.far_size, "width": self.width}
        named = ", ".join(f"{name} = {size:.4g} mm" for name, size in sizes.items() if size is not None)
        rule = f" ({', '.join(self.fixed)} by rule)" if self.fixed else ""
        return (
            f"Prepared({self.scene.kind}, {self.scene.model.kind}: {named}{rule}; "
            f"{self.model.active_dofs} of {self.model.total_dofs} unknowns)"
        )

    def scene_of(self, scene: Scene) -> Scene:
        """A scene with the sizes that it leaves out as they are here: what `run(scene, prepared)` runs.

        Raises
        ------
        SceneError
            Naming the first key that asks for another mesh or another stiffness.
        """
        missing = {key: size for key, size in self.fixed.items() if scene.given(key) is None}
        scene = scene.with_(**missing) if missing else scene
        if self.model.problem.point_law is not self.model.cracks.point_law:
            raise SceneError(
                f"prepared: its problem has a law of its own, {self.model.problem.point_law!r}; expected what prepare(scene) "
                "returns, for the law is that of the scene that is run"
            )
        for key, was, now in _pairs(self.scene, scene):
            if not _are_same(was, now):
                raise SceneError.at(key, f" = {now!r}: the mesh and its stiffness were prepared with {was!r}; expected that")
        return scene


def prepare(scene: Scene, model: str | None = None) -> Prepared:
    """Mesh and condense a scene once, for many runs: `run(other, prepared)`.

    Parameters
    ----------
    scene : Scene; its material gives the sizes that it does not name.
    model : overrides the scene's model.kind.

    Returns
    -------
    Prepared

    Raises
    ------
    SceneError, MeshError
        For bad input.

    Examples
    --------
    >>> from cohesive import Scene, prepare, run
    >>> beam = Scene.load("notched-beam")
    >>> prepared = prepare(beam)
    >>> loads = [run(beam.with_(**{"material.Gf": Gf}), prepared).peak_load for Gf in (0.08, 0.1)]
    >>> loads[0] < loads[1]
    True
    """
    if not isinstance(scene, Scene):
        raise TypeError(f"prepare(scene) got {scene!r}: expected a Scene, as from Scene.load(name)")
    if model is not None:
        scene = scene.with_(**{"model.kind": model})
    fixed: dict[str, float] = {}
    if scene.sizes is not None:
        fixed = {"mesh.crack_size": scene.sizes.crack_size, "mesh.far_size": scene.sizes.far_size}
    built = build(scene)
    if scene.model.kind == "discrete" and scene.law.takes_width:
        fixed["interface.width"] = built.cracks.width
    fixed = {key: size for key, size in fixed.items() if scene.given(key) is None}
    return Prepared(scene.with_(**fixed) if fixed else scene, fixed, built)


def is_kept(scene: Scene, key: str) -> bool:
    """Whether mesh and stiffness of a scene are kept if this key changes."""
    table, _, rest = key.partition(".")
    name = rest.partition(".")[0]
    if table == "material":
        return name not in ("preset", *_needed(scene))
    return table in ("title", "law", "stage", "reference", "output") or (name in _FREE.get(table, ()) and key != "band.width")


def _needed(scene: Scene) -> tuple[str, ...]:
    """Parameters of the material on which mesh and stiffness depend."""
    return ("nu", "density", "E") if scene.specimen.regions() else ("nu", "density")


def _pairs(own: Scene, other: Scene) -> Iterator[tuple[str, Any, Any]]:
    """What must be the same in both scenes, by key."""
    yield "specimen.kind", own.kind, other.kind
    if other.grow is not None:
        yield "specimen.crack", own.specimen.paths, "grow"
    for table, free in _FREE.items():
        part = "sizes" if table == "mesh" else table
        was, now = getattr(own, part), getattr(other, part)
        for name in [] if was is None else [each.name for each in fields(was) if each.name not in free]:
            yield f"{table}.{name}", getattr(was, name), getattr(now, name)
    if own.sizes is not None and own.model.kind == "smeared":
        yield "band.width", own.band_width, other.band_width
    for name in _needed(own):
        yield f"material.{name}", getattr(own.material, name), getattr(other.material, name)


def _are_same(one: Any, other: Any) -> bool:
    """Whether two values of a key are equal; arrays may be among them."""
    same = one == other
    return bool(np.array_equal(one, other)) if isinstance(same, np.ndarray) else bool(same)
