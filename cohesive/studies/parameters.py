"""The settings of a scene that trade accuracy for cost, and how their values are carried from one scene to another."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from typing import Any

from ..errors import SceneError
from ..law.widths import default_width
from ..scenes.scene import Scene
from ..solver.controls import control_of
from ..solver.stages import Stage

#: values by setting: a factor on what the scene has (the first five and "finer"), or the value itself
Settings = dict[str, Any]

#: dotted keys of a scene
Changes = dict[str, Any]

_FACTORS = ("crack size", "far size", "layers", "width", "steps", "finer")

#: settings that change the physics: they do not solve the same problem cheaper
PHYSICS = ("smoothing c_zn", "model")

SETTINGS = (
    "crack size", "far size", "layers", "order", "shape", "width", "quadrature", "steps", "step growth", "tolerance",
    "condensation", "half", *PHYSICS,
)  # fmt: skip


def label(settings: Settings) -> str:
    """Settings as words."""

    def one(name: str, value: Any) -> str:
        if value is True:
            return name
        return f"{name} {'x ' if name in _FACTORS else ''}{value if isinstance(value, str) else format(value, 'g')}"

    return ", ".join(one(name, value) for name, value in settings.items()) or "as it is"


def single(scene: Scene, names: Iterable[str] | None = None) -> list[Settings]:
    """Each setting changed alone; `names` tells which, default: all that the scene has."""
    wanted = SETTINGS if names is None else tuple(names)
    for name in wanted:
        if name not in SETTINGS:
            raise SceneError(f"settings: '{name}' is unknown; expected some of {', '.join(SETTINGS)}")
    sizes = scene.sizes
    assert sizes is not None
    discrete = scene.model.kind == "discrete"
    values: dict[str, tuple[Any, ...]] = {
        "crack size": (4.0, 2.0, 0.75 if scene.is_solid else 0.5),
        "far size": (2.0, 0.5),
        "layers": (0.5, 2.0) if scene.is_extruded else (),
        "order": (3 - sizes.order,),
        "shape": ("quad" if sizes.shape == "triangle" else "triangle",) if _has_shapes(scene) else (),
        "width": (4.0, 2.0, 0.5, 0.25) if _has_width(scene) else (),
        "quadrature": ("gauss" if scene.interface.quadrature == "nodal" else "nodal",) if discrete else (),
        "steps": (0.125, 0.25, 0.5, 2.0),
        "step growth": tuple(most for most in (2.0, 4.0) if most != scene.solver.step_growth),
        "tolerance": (1e-2, 1e-3, 1e-6),
        "condensation": ("never",) if scene.solver.condensation != "never" else (),
        "half": (True,) if _can_be_halved(scene) and not scene.model.half else (),
        "smoothing c_zn": tuple(c for c in (5.0, 9.0, 50.0) if c != scene.material.c_zn),
        "model": ("smeared" if discrete else "discrete",),
    }
    alone = [{name: value} for name in wanted for value in values[name]]
    return [settings for settings in alone if _is_changed(scene, settings)]


def _is_changed(scene: Scene, settings: Settings) -> bool:
    """Whether settings change a scene, and to one that can be built; a far size below the crack size changes nothing."""
    keys = changes(scene, settings)
    try:
        scene.with_(**keys)
    except SceneError:  # as of a specimen without a crack band
        return False
    return bool(keys)


def changes(scene: Scene, settings: Settings, like: Scene | None = None) -> Changes:
    """The keys of a scene that settings change, measured on the scene itself or on another one.

    Sizes are carried over by the ratio of the crack lengths or that of the characteristic lengths E Gf / ft^2, whichever
    asks for the finer mesh: the first keeps the number of elements along the crack, the second that in its process zone.
    Layers through a thickness keep their shape. Steps keep their number, and become more if they would grow longer in
    units of Gf / ft. Widths follow their own rules. Half a body, a shape and an order are taken over if the
    specimen has them; all else is taken as it is.

    Parameters
    ----------
    scene : Scene of a built-in specimen.
    settings : Settings
    like : the scene on which the settings were measured; default: `scene`.
    """
    like = like or scene
    sizes, model = like.sizes, settings.get("model", scene.model.kind)
    assert sizes is not None
    finer = settings.get("finer", 1.0)
    scale = min(_ratios(scene, like))
    shape = settings.get("shape", sizes.shape) if _has_shapes(scene) else "triangle"
    is_linear = scene.is_solid and (shape == "quad" or (model == "smeared" and scene.band.where == "path"))
    crack = sizes.crack_size * scale * settings.get("crack size", 1.0) / finer
    keys: Changes = {
        "mesh.crack_size": crack,
        "mesh.far_size": max(sizes.far_size * scale * settings.get("far size", 1.0) / finer, crack),
        "mesh.order": 1 if is_linear else settings.get("order", sizes.order),
        "mesh.shape": shape,
        "solver.tol": settings.get("tolerance", min(like.solver.tol, 1e-7) if finer > 1.0 else like.solver.tol),
        "solver.step_growth": settings.get("step growth", like.solver.step_growth),
        "solver.condensation": settings.get("condensation", like.solver.condensation),
        "material.c_zn": settings.get("smoothing c_zn", scene.material.c_zn),
        "model.kind": model,
        "model.half": model == "discrete"
        and (settings.get("half", like.model.half or scene.model.half) and _can_be_halved(scene)),
    }
    keys |= _layers(scene, like, settings)
    if scene.model.kind == "discrete":
        keys["interface.quadrature"] = settings.get("quadrature", like.interface.quadrature)
    keys |= _width(scene, like, settings)
    keys |= _steps(scene, like, settings.get("steps", 1.0) * finer)
    changed = {key: value for key, value in keys.items() if value != _current(scene, key)}
    if "mesh.crack_size" in changed and scene.given("mesh.far_size") is None:  # which would follow it
        changed["mesh.far_size"] = keys["mesh.far_size"]
    return changed


def _layers(scene: Scene, like: Scene, settings: Settings) -> Changes:
    """Layers through the thickness, which keep their shape; without a number they follow the far size."""
    sizes = like.sizes
    assert sizes is not None
    has_layers = scene.is_extruded and like.is_extruded
    if not has_layers or (sizes.layers is None and "layers" not in settings):
        return {}
    thickness, like_thickness = (each.crack_area / each.crack_length for each in (scene, like))
    count = sizes.layers_through(like_thickness) * thickness / like_thickness / min(_ratios(scene, like))
    count *= settings.get("layers", 1.0) * settings.get("finer", 1.0)
    return {"mesh.layers": max(1, round(count))}


def _width(scene: Scene, like: Scene, settings: Settings) -> Changes:
    """Width of the interface, or of the band, each after its own rule."""
    if not _has_width(scene):
        return {}
    is_band = scene.model.kind == "smeared"
    (here, rule), (there, rule_there) = (
        (each.band.width, each.band_rule)
        if is_band
        else (each.interface.width, default_width(each.crack_length, each.zone_length))
        for each in (scene, like)
    )
    factor = settings.get("width", 1.0) / settings.get("finer", 1.0)
    factor *= there / rule_there if isinstance(there, (int, float)) else 1.0
    key = "band.width" if is_band else "interface.width"
    return {key: rule * factor} if here is not None or factor != 1.0 else {}


def distance(scene: Scene, like: Scene) -> float:
    """How far two scenes are apart in size: the logarithm of the ratio of their crack lengths or of their characteristic
    lengths, whichever is larger."""
    return max(abs(math.log(ratio)) for ratio in _ratios(scene, like))


def _ratios(scene: Scene, like: Scene) -> tuple[float, float]:
    lengths = scene.crack_length / like.crack_length
    return lengths, scene.zone_length / like.zone_length


def _has_width(scene: Scene) -> bool:
    """Whether the width of the crack plane is free: not eq. (21) as printed, nor given by the elements."""
    return scene.interface.width != "h" if scene.model.kind == "discrete" else scene.band.where == "path"


def _has_shapes(scene: Scene) -> bool:
    """Whether the specimen may be meshed with either shape."""
    return len(scene.specimen.shapes) > 1


def _can_be_halved(scene: Scene) -> bool:
    return scene.model.kind == "discrete" and scene.specimen.symmetry() is not None


def _current(scene: Scene, key: str) -> Any:
    """Value of a dotted key, or its default."""
    table, *number, name = key.split(".")
    part: Any = {"mesh": scene.sizes, "stage": scene.stages}.get(table) or getattr(scene, table)
    return getattr(part[int(number[0])] if number else part, name)


def _lengths(stages: Sequence[Stage]) -> list[float]:
    """The longest distance to a target of each stage, mm, N or N mm."""
    lengths, last, control = [], 0.0, ""
    for stage in stages:
        start = last if stage.control == control else 0.0
        ends = [start, *stage.targets]
        lengths.append(
            max(abs(target if stage.unload else target - end) for target, end in zip(stage.targets, ends, strict=False))
        )
        last, control = ends[-1], stage.control
    return lengths


def _steps(scene: Scene, like: Scene, factor: float) -> Changes:
    """Steps of every stage, taken from the stage of the same number (or the last one) of the other scene."""
    opening, opening_there = (m.Gf / m.ft for m in (scene.material, like.material))
    keys: Changes = {}
    for i, (stage, length) in enumerate(zip(scene.stages, _lengths(scene.stages), strict=True)):
        j = min(i, len(like.stages) - 1)
        other, length_there = like.stages[j], _lengths(like.stages)[j]
        count = other.count(length_there)
        if control_of(stage.control).is_motion and control_of(other.control).is_motion:
            count *= max(1.0, (length / opening) / (length_there / opening_there))
        if stage.step is not None:
            if not math.isclose(step := length / (count * factor), stage.step):
                keys[f"stage.{i}.step"] = step
        elif (steps := math.ceil(count * factor - 1e-9)) != stage.count(length):
            keys[f"stage.{i}.steps"] = steps
    return keys


def problem(scene: Scene) -> dict[str, Any]:
    """What a scene asks, apart from how it is solved: scenes with the same problem may share a trade."""
    is_discrete = scene.model.kind == "discrete"
    as_printed = scene.interface.width == "h" if is_discrete else None
    return {
        "specimen": (scene.kind, vars(scene.specimen)),
        "material": asdict(scene.material),
        "model": (scene.model.kind, scene.model.plane, scene.is_solid, as_printed),
        "band": None if is_discrete else asdict(scene.band) | {"width": None},
        "stage": [asdict(stage) | {"steps": None, "step": None} for stage in scene.stages],
    }
