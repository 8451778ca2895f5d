"""Scripts of gmsh's geometry: those that only describe a shape are run, all others refused."""

from __future__ import annotations

import io
import json
import tomllib
from pathlib import Path

import pytest

from cohesive import Scene, SceneError, run
from cohesive.commands.command_line import main
from cohesive.results.archive import packed, unpacked
from cohesive.results.checkpoints import NAME
from cohesive.solver.stepper import EVERY
from meshing import MeshError
from meshing.files.geo import read_outline
from meshing.files.geo_script import Refused, harmless

PLATE = """
Point(1) = {0, 0, 0}; Point(2) = {4, 0, 0}; Point(3) = {4, 3, 0}; Point(4) = {0, 3, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1:4}; Plane Surface(1) = {1}; Physical Curve("base") = {1};
"""

#: statements that gmsh runs and a shape does not need; CANARY stands for a file that none of them may make
HARMFUL = [
    'SystemCall "touch CANARY";',
    'NonBlockingSystemCall "touch CANARY";',
    'Printf("x") > "CANARY";',
    'Printf("%g", 1) >> "CANARY";',
    'Save "CANARY";',
    'Print "CANARY";',
    'CreateDir "CANARY";',
    'Include "other.geo";',
    'Merge "other.msh";',
    'ShapeFromFile("other.stp");',
    'Plugin(Skin).Run;',
    "Exit;",
    "Abort;",
    "Sleep 1000;",
    "For i In {1:10}\nPoint(10 + i) = {i, 0, 0};\nEndFor",
    "If (1)\nEndIf",
    "Macro m\nReturn",
    "Call m;",
    "General.Verbosity = 99;",
    'Solver.Executable0 = "touch CANARY";',
    'General.ExecutableFileName = "CANARY";',
    'name = "text";',
    'name = Str("text");',
    'OnelabRun("touch CANARY");',
    "DefineConstant[ h = {1, Name \"h\"} ];",
    'x = GetNumber("x", 1);',
    "Extrude {0, 0, 1} { Surface{1}; }",
    "Delete Model;",
    "Physical Curve(7) = {1};",
    "Physical Curve(\"more\") = {1}; SyncModel;",
    "x = 1; Error(\"x\");",
    "a[] = {1:1000000000};",
    "a[] = {1:60000}; b[] = {a[], a[]};",
    "x = 1/0;",
    "x = 1e400;",
    "x = " + 100 * "(" + "1" + 100 * ")" + ";",
    "Point(9) = {0, 0",
    "`touch CANARY`;",
    "y = x;",
]


@pytest.mark.parametrize("statement", HARMFUL, ids=lambda text: text[:24])
def test_what_is_no_shape_is_refused_and_not_run(statement: str, tmp_path: Path) -> None:
    canary, path = tmp_path / "canary", tmp_path / "plate.geo"
    path.write_text(PLATE + statement.replace("CANARY", str(canary)))
    with pytest.raises(MeshError, match=r"plate.geo', line 5, .*--run-scripts"):
        read_outline(path)
    assert not canary.exists()


@pytest.mark.parametrize("name", ["plate.geo.opt", "outline.geo.opt", ".gmshrc", ".gmsh-options"])
def test_files_of_options_are_not_run(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    canary = tmp_path / "canary"
    (tmp_path / "plate.geo").write_text(PLATE)
    (tmp_path / name).write_text(f'SystemCall "touch {canary}";\n')
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path))
    assert read_outline(tmp_path / "plate.geo").area == pytest.approx(12.0)
    assert not canary.exists()


def test_with_consent_a_script_is_run(tmp_path: Path) -> None:
    path = tmp_path / "plate.geo"
    path.write_text(PLATE + f'Printf("ran") > "{tmp_path / "ran"}";\n')
    assert read_outline(path, run_scripts=True).area == pytest.approx(12.0)
    assert (tmp_path / "ran").exists()


@pytest.mark.parametrize(
    ("script", "area"),
    [
        (PLATE, 12.0),
        ("/* of\n two lines */" + PLATE.replace("4, 3", "2*2, Sqrt(9)") + "// end", 12.0),
        ("w = 3; w += 1; c[] = {1:4};" + PLATE.replace("{4,", "{w,").replace("Loop(1) = {1:4}", "Loop(1) = {c[]}"), 12.0),
        ('SetFactory("OpenCASCADE"); Rectangle(1) = {0, 0, 0, 4, 3}; Rectangle(2) = {3, 2, 0, 5, 5};'
         "BooleanDifference(3) = { Surface{1}; Delete; }{ Surface{2}; Delete; };", 11.0),
        (PLATE + "Characteristic Length {1:4} = 0.5; MeshSize {1} = 1e-1;", 12.0),
        (PLATE.replace("Point(1) =", "p = newp; Point(p) =").replace("Point(2)", "Point(newp)"), 12.0),
    ],
    ids=["plate", "comments", "numbers", "Boolean", "sizes", "next tags"],
)  # fmt: skip
def test_shapes_are_read(script: str, area: float, tmp_path: Path) -> None:
    (tmp_path / "plate.geo").write_text(script)
    assert read_outline(tmp_path / "plate.geo").area == pytest.approx(area)


def test_ranges_are_written_as_they_were_counted() -> None:
    """However gmsh reads the sign of a power, its range is ours."""
    assert "{ 1.0 : -4.0 : -1.0 }" in harmless("a[] = {1:-2^2};")


def test_the_line_is_that_of_the_statement() -> None:
    with pytest.raises(Refused) as refused:
        harmless("x = 1;\n\n/* \n */ Exit;")
    assert refused.value.line == 4


#: a scene on the plate, pulled up at its top
SCENE = """
[specimen]
kind = "outline"
file = "plate.geo"
thickness = 10.0
crack = [[[0.0, 1.5], [4.0, 1.5]]]
supports = [{at = "base", direction = [0, 1]}, {at = "corner", direction = [1, 0]}]
drive = {at = [2.0, 3.0], direction = [0, 1]}
[mesh]
crack_size = 1.0
[material]
E = 30000.0
nu = 0.2
ft = 3.0
Gf = 0.1
[[stage]]
control = "driven"
to = 0.0001
steps = 1
"""
NAMED = PLATE + 'Physical Point("corner") = {1};'


def folder_with(path: Path, script: str) -> Path:
    (path / "plate.geo").write_text(script)
    (path / "plate.toml").write_text(SCENE)
    return path / "plate.toml"


@pytest.mark.parametrize("command", ["show", "run", "compare", "sweep", "explore"])
def test_no_command_runs_a_script_unasked(command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    canary = tmp_path / "canary"
    source = folder_with(tmp_path, NAMED + f'SystemCall "touch {canary}";')
    more = ["--vary", "material.ft=2:3:2"] if command == "sweep" else []
    assert main([command, str(source), *more]) == 2
    assert "line 5, 'SystemCall" in capsys.readouterr().err
    assert not canary.exists()


def test_a_folder_that_somebody_sent_runs_no_script(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Its scene names one: in scene.toml, which `report` reads, and in its checkpoint, from which `run --resume` goes on."""
    canary, sent = tmp_path / "canary", tmp_path / "sent"
    source = folder_with(tmp_path, NAMED)
    kept: list[bytes] = []

    def on_step(*_: object) -> None:
        if (sent / NAME).is_file():
            kept.append((sent / NAME).read_bytes())

    run(Scene.load(source).with_(**{"stage.0.steps": 2 * EVERY}), output=sent, on_step=on_step).save(sent)
    folder_with(sent, NAMED + f'SystemCall "touch {canary}";')
    (sent / "scene.toml").write_text((sent / "plate.toml").read_text())
    assert main(["report", str(sent)]) == 2
    assert "line 5, 'SystemCall" in capsys.readouterr().err
    with_script = tomllib.loads((sent / "plate.toml").read_text())
    file = io.BytesIO(kept[-1])
    forged = unpacked(file) | {"scene": json.dumps(with_script), "folder": str(sent)}
    (sent / NAME).write_bytes(packed(forged) + file.read())
    assert main(["run", "--resume", str(sent)]) == 2
    assert "line 5, 'SystemCall" in capsys.readouterr().err
    assert not canary.exists()


def test_consent_is_not_inherited(tmp_path: Path) -> None:
    """Read once: copies, saved scenes and results carry the shape, and the script may be gone."""
    count = tmp_path / "count"
    source = folder_with(tmp_path, NAMED + f'Printf("run") >> "{count}";\n')
    with pytest.raises(SceneError, match=r"^specimen.file = .*--run-scripts"):
        Scene.load(source)
    scene = Scene.load(source, run_scripts=True)
    assert count.read_text().split() == ["run"]
    (tmp_path / "plate.geo").unlink()
    assert "file" not in scene.data["specimen"] and scene.data["specimen"]["points"] == {"corner": [[0.0, 0.0]]}
    result = run(scene.with_(title="again"))
    result.save(tmp_path / "out")
    again = Scene.load(tmp_path / "out" / "scene.toml")
    assert again.data["specimen"] == scene.data["specimen"]
    assert main(["report", str(tmp_path / "out")]) == 0
    assert count.read_text().split() == ["run"]
    assert main(["run", str(source), "-o", str(tmp_path / "more"), "--run-scripts"]) == 2  # the script is gone


def test_corners_and_a_script_say_the_same(tmp_path: Path) -> None:
    (tmp_path / "mesh").mkdir()
    by_script = Scene.load(folder_with(tmp_path, NAMED))
    by_hand = Scene(by_script.data)
    assert by_hand.data == by_script.data
    assert run(by_hand).peak_load == run(by_script).peak_load > 0
