"""Public members of scenes of every kind: a value, or one sentence that says what is not known."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

import pytest

from cohesive import Scene, SceneError
from cohesive.scenes.scene import built_in
from meshing.specimens import SPECIMENS
from tests.builders import OF_A_FILE

OUTLINE: dict[str, Any] = {
    "specimen": {
        "kind": "outline", "thickness": 50.0, "corners": [[-80, 0], [80, 0], [80, 40], [-80, 40]], "crack": [[0, 0], [0, 40]],
        "supports": [{"at": [-60, 0], "direction": [0, 1]}, {"at": [60, 0], "direction": [0, 1]}],
        "drive": {"at": [0, 40], "direction": [0, -1]}, "gauge_minus": [-10, 0], "gauge_plus": [10, 0],
    },
    "material": {"preset": "reinhardt"},
    "stage": [{"control": "opening", "to": 0.1}],
}  # fmt: skip

SCENES = {name: Scene.load(name) for name in built_in()} | {"outline": Scene(OUTLINE), "mesh": Scene(OF_A_FILE)}


def test_every_kind_is_here() -> None:
    assert {scene.kind for scene in SCENES.values()} >= set(SPECIMENS) - {"my-split-cube"}


@pytest.mark.parametrize("name", SCENES)
def test_every_property_is_a_value_or_a_sentence(name: str) -> None:
    scene, refused = SCENES[name], []
    for one in (scene, scene.specimen, scene.material):
        for member, value in inspect.getmembers(type(one)):
            if isinstance(value, property) and not member.startswith("_"):
                try:
                    getattr(one, member)
                except SceneError as error:
                    assert "expected" in str(error) and error.key == "specimen.kind"
                    refused.append(member)
    assert refused == (["band_rule", "band_width", "crack_area", "crack_length"] if name == "mesh" else [])


@pytest.mark.parametrize(
    ("member", "what"),
    [
        (lambda scene: scene.crack_area, "the area of its crack"),
        (lambda scene: scene.crack_length, "the length of its crack"),
        (lambda scene: scene.band_width, "the width of its band"),
        (lambda scene: scene.along([[(0.0, 0.0), (0.0, 1.0)]]), "the size of its elements"),
        (lambda scene: scene.with_(**{"model.kind": "smeared"}).band_width, "the width of its band"),
    ],
)
def test_what_a_mesh_does_not_tell_before_it_is_read_is_said(member: Callable[[Scene], object], what: str) -> None:
    with pytest.raises(SceneError, match=f"specimen.kind = 'mesh': {what} is not known before its mesh is read; expected"):
        member(SCENES["mesh"])
