"""One suite over all kinds of specimens: a new kind is tested by being registered and having a built-in scene."""

from __future__ import annotations

import numpy as np
import pytest

from cohesive import Scene
from cohesive.scenes.scene import built_in
from meshing.specimens import SPECIMENS, register_specimen

SCENES = {Scene.load(name).kind: Scene.load(name) for name in built_in() if not name.endswith("-3d")}
SCENES["single-crack-3d"] = Scene.load("single-crack-3d")


def test_every_kind_has_a_scene() -> None:
    assert set(SCENES) == set(SPECIMENS) - {"mesh", "outline"}  # whose geometry is the user's


@pytest.mark.parametrize(("kind", "dimension"), [(kind, d) for kind in SCENES for d in SCENES[kind].specimen.dimensions])
def test_what_it_says_is_in_its_meshes(kind: str, dimension: int) -> None:
    scene = SCENES[kind]
    specimen, length = scene.specimen, scene.crack_length
    coarse = scene.with_(**{"mesh.crack_size": length / 4, "mesh.far_size": length / 2, "mesh.order": 1})
    assert coarse.sizes is not None and specimen.crack_area is not None
    halves = (False, True) if specimen.symmetry() is not None else (False,)
    for half in halves:
        mesh = specimen.mesh(coarse.sizes, half=half, dimension=dimension)
        assert mesh.points.shape[1] == dimension
        named = [each.at for each in (*specimen.held(half=half), *specimen.drives(half=half).values())]
        for gauge in specimen.gauges(half=half).values():
            named += [gauge.plus] if gauge.minus is None else [gauge.plus, gauge.minus]
        for at in named:
            assert len(mesh.point_sets[at]) >= 1, at
        assert specimen.drives(half=half)
        for held in specimen.held(half=half):
            assert held.direction is None or np.isclose(np.linalg.norm(held.direction), 1.0)
    if len(halves) == 2:
        assert len(mesh.points) < len(specimen.mesh(coarse.sizes, dimension=dimension).points)


def test_a_name_is_given_once() -> None:
    with pytest.raises(ValueError, match="NotchedBeam has this name; expected another one"):
        register_specimen("notched-beam")(SPECIMENS["single-crack"])
    with pytest.raises(ValueError, match="no dataclass derived from Specimen"):
        register_specimen("no-specimen")(int)  # type: ignore[type-var]
