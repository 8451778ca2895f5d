"""The one list of keys: printed by the command, checked in scenes, and what the README names."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from cohesive import Scene, SceneError
from cohesive.commands.command_line import main
from cohesive.scenes.keys import scene_keys, specimen_kinds
from cohesive.scenes.scene import built_in
from cohesive.scenes.table_reader import TABLES
from cohesive.solver.columns import COLUMN_NAMES

REFERENCE = Path(__file__).parents[2] / "examples" / "guide" / "reference"


@pytest.mark.parametrize("kind", specimen_kinds())
def test_every_key_says_what_it_means(kind: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["keys", kind]) == 0
    said = capsys.readouterr().out
    for key in scene_keys(kind):
        assert key.meaning and not key.meaning.endswith("."), key
        assert f"\n  {key.name}: " in said, key
    assert {key.table for key in scene_keys(kind)} - {"law"} == {*TABLES, "specimen", ""}  # laws that other tests register


def test_an_unknown_kind_is_refused_with_the_one_that_was_meant(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["keys", "notched-beem"]) == 2
    assert "did you mean 'notched-beam'?" in capsys.readouterr().err


def test_all_keys_of_the_built_in_scenes_are_in_the_list() -> None:
    for name in built_in():
        scene = Scene.load(name)
        known = {(key.table, key.name) for key in scene_keys(scene.kind)} | {("material", "preset")}
        for table, entries in scene.data.items():
            for entry in entries if isinstance(entries, list) else [entries]:
                if isinstance(entry, dict):
                    assert {(table, key) for key in entry} <= known


def test_the_guide_names_the_same_keys_and_columns() -> None:
    scenes, python = ((REFERENCE / name).read_text(encoding="utf-8") for name in ("scenes.md", "python.md"))
    block = scenes[scenes.index("    [specimen]   kind =") : scenes.index("`cohesive keys notched-beam` lists")]
    for key in scene_keys():
        if key.table not in ("", "specimen", "material", "law"):
            assert re.search(rf"\b{key.name}\b", block), f"{key.table}.{key.name}"
    for kind in specimen_kinds():
        assert f'"{kind}"' in block
    columns = python[python.index("`history` holds the state") :]
    assert tuple(re.findall(r"\w+", columns[columns.index("`step,") : columns.index("stage`") + 5])) == COLUMN_NAMES


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"solver.reduction": "none"}, r"solver.reduction: this key is gone; expected solver.condensation"),
        ({"solver.largest_step": 2.0}, "expected solver.step_growth"),
        ({"solver.tangent": "secant"}, r"expected run\(scene, tangent='secant'\)"),
        ({"band.shear_scaling": False}, "expected material.shear_scaling"),
        ({"band.tol": 1e-6}, "expected none"),
        ({"stage.0.ratio": 1.0}, "expected stage.angle"),
        ({"specimen.kind": "notched-beam-3d"}, "expected specimen.kind = 'notched-beam' and model.dimension = 3"),
        ({"specimen.kind": "push-off-3d"}, "expected specimen.kind = 'push-off' and model.dimension = 3"),
        ({"model.dimension": 4}, "model.dimension = 4: expected a number of at least 2 and at most 3"),
    ],
)
def test_an_old_name_is_refused_with_the_new_one(change: dict[str, object], expected: str) -> None:
    with pytest.raises(SceneError, match=expected):
        Scene.load("notched-beam").with_(**change)
