"""Five hundred scenes damaged at random: a message of one line that names the key, never another exception."""

from __future__ import annotations

import copy
import json
import math
import random
from typing import Any

import pytest

from cohesive import NotConverged, Scene, SceneError, run
from cohesive.scenes.keys import scene_keys
from cohesive.scenes.scene import built_in
from meshing import MeshError

VALUES: list[Any] = [
    -1, 0, 0.0, -1.0, 1e-30, 1e-9, 1e30, 1e308, 10**40, 10**400, math.nan, math.inf, -math.inf, "abc", "", "h", True, False,
    None, [], [1, 2], [[0, 0]], [[0, 0], [1, 1]], [math.nan], {}, {"a": 1}, 3, 0.5, 100.0, -0.1,
]  # fmt: skip
#: so that all keys of these tables are there to be damaged
TABLES: dict[str, dict[str, Any]] = {
    table: {key.name: json.loads(key.default) for key in scene_keys() if key.table == table and key.default}
    for table in ("band", "model", "interface", "solver", "output")
}
TABLES["interface"]["width"] = 0.5
TABLES["output"]["frames"] = 0


class FirstStep(Exception):
    """Enough has been seen."""


def stop(*_: object) -> None:
    raise FirstStep


def damaged(chance: random.Random, data: dict[str, Any]) -> dict[str, Any]:
    data = copy.deepcopy(data)
    for _ in range(chance.choice([1, 1, 1, 2])):
        tables = [table for table in (*data.values(), *(data.get("stage") or [])) if isinstance(table, dict) and table]
        if not tables or chance.random() < 0.15:
            data[chance.choice(list(data))] = chance.choice(VALUES)
            if not isinstance(data.get("stage"), list):
                break
            continue
        table = chance.choice(tables)
        key = chance.choice(list(table))
        kind = chance.random()
        if kind < 0.15:
            del table[key]
        elif kind < 0.3:
            at = chance.randrange(len(key))
            table[key[:at] + chance.choice("abcxyz_1") + key[at + 1 :]] = table.pop(key)
        else:
            table[key] = chance.choice(VALUES)
    return data


@pytest.mark.parametrize("count", [100, pytest.param(500, marks=pytest.mark.long)])
def test_damaged_scenes_are_refused_in_one_line(count: int) -> None:
    scenes = []
    for name in built_in():
        scene = Scene.load(name)
        data = TABLES | copy.deepcopy(scene.data)
        assert scene.sizes is not None
        size = 3 * scene.sizes.crack_size
        data["mesh"] = data.get("mesh", {}) | {"crack_size": size, "far_size": 2 * max(size, scene.sizes.far_size)}
        scenes.append((data, scene.folder))
    refused = 0
    for seed in range(count):
        chance = random.Random(seed)
        data, folder = chance.choice(scenes)
        changed = damaged(chance, data)
        if chance.random() < 0.4 and isinstance(changed.get("model"), dict) and changed["model"].get("kind") == "discrete":
            changed["model"]["kind"] = "smeared"
        try:
            with pytest.raises((FirstStep, SceneError, MeshError, NotConverged)) as caught:
                run(Scene(changed, folder), on_step=stop)
        except BaseException as error:
            raise AssertionError(f"seed {seed}: {changed}") from error
        if isinstance(caught.value, (SceneError, MeshError)):
            assert "\n" not in str(caught.value), seed
            refused += 1
    assert refused > 0.7 * count  # the rest is harmless
