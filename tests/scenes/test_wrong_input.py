"""Scenes: loading, changing, and the message for every kind of wrong input."""

from __future__ import annotations

import copy
import pickle
import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cohesive import Scene, SceneError, run
from cohesive.commands.command_line import main
from cohesive.scenes.scene import built_in, dump_toml
from meshing import MeshError
from tests.builders import block, coarse_beam

BEAM = Scene.load("notched-beam").data | {"mesh": {"crack_size": 1.25, "far_size": 10.0}}


def changed(**changes: Any) -> dict[str, Any]:
    """The beam's data with dotted keys (written with __) set, or removed where the value is ...."""
    data = copy.deepcopy(BEAM)
    for key, value in changes.items():
        *path, last = key.split("__")
        place: Any = data
        for part in path:
            place = place[int(part)] if isinstance(place, list) else place.setdefault(part, {})
        if value is ...:
            del place[last]
        else:
            place[last] = value
    return data


WRONG = {
    # keys
    "a key without its table": (changed(Gf=0.1), r"Gf: unknown key \(did you mean 'material.Gf'\?\)"),
    "a key without its stage": (changed(steps=3), r"steps: unknown key \(did you mean 'stage.0.steps'\?\)"),
    "unknown table": (changed(meterial={}), r"meterial: unknown key \(did you mean 'material'\?\)"),
    "misspelt key": (changed(material__Gff=0.1), r"material.Gff: unknown key \(did you mean 'Gf'\?\)"),
    "missing key": (changed(specimen__span=...), r"specimen.span is missing"),
    "missing table": (changed(material=...), r"\[material\] is missing"),
    "no stage": (changed(stage=...), r"stage is missing .*\[\[stage\]\]"),
    "stage is no list": (changed(stage={"control": "opening", "to": 1.0}), r"stage is missing or not a list"),
    "no specimen": (changed(specimen=...), r"\[specimen\] is missing"),
    "no kind": (changed(specimen__kind=...), r"specimen.kind is missing"),
    "unknown kind": (changed(specimen__kind="notched-beem"), r"specimen.kind = 'notched-beem'.*did you mean 'notched-beam'"),
    "table is a number": (changed(mesh=3), r"mesh = 3: expected a table"),
    "key of another kind": (changed(specimen__faces="free"), r"specimen.faces: unknown key"),
    "title": (changed(title=3), r"title = 3: expected a string"),
    # types
    "string for number": (changed(material__E="37 GPa"), r"material.E = '37 GPa': expected a finite number"),
    "nan": (changed(material__Gf=float("nan")), r"material.Gf = nan: expected a finite number"),
    "infinite": (changed(specimen__length=float("inf")), r"specimen.length = inf: expected a finite number"),
    "boolean for number": (changed(specimen__depth=True), r"specimen.depth = True: expected a finite number"),
    "fraction of a step": (changed(stage__0__steps=1.5), r"stage.0.steps = 1.5: expected a whole number"),
    "list for number": (changed(mesh__crack_size=[1.0]), r"mesh.crack_size = \[1.0\]: expected a finite number"),
    "text in the targets": (changed(stage__0__to=[0.1, "end"]), r"stage.0.to = .*expected a finite number"),
    # values
    "E in GPa": (changed(material__E=-37.0), r"material.E = -37.0: expected a number above 0"),
    "nu": (changed(material__nu=0.5), r"material.nu = 0.5: expected 0 <= nu < 0.5"),
    "p": (changed(material__p=[0.5, 0.3, 0.1]), r"material.p = .*sum 1, got sum 0.9"),
    "preset": (changed(material__preset="granite"), r"material.preset = 'granite': expected one of"),
    "width": (changed(interface={"width": 0.0}), r"interface.width = 0.0: expected a number above 0"),
    "width word": (changed(interface={"width": "H"}), r"interface.width = 'H': expected .*'h'"),
    "quadrature": (changed(interface={"quadrature": "simpson"}), r"interface.quadrature = 'simpson': expected 'nodal' or"),
    "plane": (changed(model={"plane": "stres"}), r"model.plane = 'stres': expected 'stress' or 'strain'"),
    "model": (changed(model={"kind": "both"}), r"model.kind = 'both': expected 'discrete' or 'smeared'"),
    "half, anywhere": (
        changed(model={"kind": "smeared", "half": True}, band={"where": "everywhere"}),
        r"model.half = true: cracks may form everywhere; expected false, or band.where = 'path'",
    ),
    "band": (changed(band={"widht": 2.0}), r"band.widht: unknown key.*did you mean 'width'"),
    "band width": (changed(band={"width": -2.0}), r"band.width = -2.0: expected a number above 0"),
    "band place": (changed(band={"where": "here"}), r"band.where = 'here': expected 'path' or 'everywhere'"),
    "band cracks": (changed(band={"max_cracks": 4}), r"band.max_cracks = 4: expected a number of at least 1 and at most 3"),
    "band planes": (changed(band={"planes": "free"}), r"band.planes = 'free': expected 'path' or 'principal'"),
    "planes everywhere": (
        changed(band={"planes": "path", "where": "everywhere"}),
        r"band.planes = 'path': with where = 'everywhere' cracks follow no path; expected 'principal'",
    ),
    "band angle": (changed(band={"threshold_angle": 0.0}), r"band.threshold_angle = 0.0: expected a number above 0"),
    "band tolerance": (changed(band={"tol": 1.0}), r"band.tol: this key is gone; expected none"),
    "tolerance": (changed(solver={"tol": 0.0}), r"solver.tol = 0.0: expected"),
    "condensation": (changed(solver={"condensation": "full"}), r"solver.condensation = 'full': expected"),
    "reduction": (changed(solver={"reduction": "full"}), r"solver.reduction: this key is gone; expected solver.condensation"),
    "control": (changed(stage__0__control="cmot"), r"stage.0.control = 'cmot': expected one of opening"),
    "steps": (changed(stage__0__steps=0), r"stage.0.steps = 0: expected"),
    "until": (changed(stage__0__until={"lode": 1.0}), r"stage.0.until = .*expected a number for one of load"),
    "falling dissipation": (
        changed(stage__0__control="dissipation", stage__0__to=[2.0, 1.0]), r"stage.0.to = .*dissipation cannot fall"),
    "frames": (changed(output={"frames": -1}), r"output.frames = -1: expected"),
    # geometry
    "notch through the beam": (changed(specimen__notch=50.0), r"specimen.notch = 50.0: expected less than depth = 50"),
    "span beyond the beam": (changed(specimen__span=200.0), r"specimen.span = 200.0: expected at most length"),
    "notch off the beam": (changed(specimen__notch_position=90.0), r"specimen.gauge = 20.0: expected both gauge points"),
    "gauge inside the notch": (changed(specimen__notch_width=30.0), r"specimen.gauge = 20.0: expected more than notch_width"),
    "notch off the span": (changed(specimen__notch_position=70.0), r"specimen.notch_position = 70.0: expected the notch"),
    "negative depth": (changed(specimen__depth=-50.0), r"specimen.depth = -50.0: expected a number above 0"),
    "shape": (changed(mesh__shape="hexagon"), r"mesh.shape = 'hexagon': expected"),
    "order": (changed(mesh__order=3), r"mesh.order = 3: expected a number of at least 1 and at most 2"),
    "sizes": (changed(mesh__far_size=0.5), r"mesh.far_size = 0.5: expected at least crack_size"),
    "crack is a word": (changed(specimen__crack="up"), r"specimen.crack = 'up': expected a list of points"),
    "crack with nan": (changed(specimen__crack=[[0.0, 25.0], [0.0, float("nan")]]), r"specimen.crack = .*expected a list"),
    "half of an eccentric beam": (changed(model={"half": True}, specimen__notch_position=5.0), r"model.half = true: .*not sy"),
    # files
    "no reference": (changed(reference__file="none.csv"), r"reference.file = 'none.csv': there is no file"),
    "mesh table with a mesh file": (
        changed(specimen={"kind": "mesh", "file": "a.msh", "thickness": 1.0, "crack": "c",
                          "supports": [{"at": "base", "direction": [0, 1]}], "drive": {"at": "top", "direction": [0, 1]}}),
        r"mesh: a specimen of kind 'mesh' brings its own mesh"),
    "support without direction": (
        changed(specimen={"kind": "mesh", "file": "a.msh", "thickness": 1.0, "crack": "c", "supports": [{"at": "base"}],
                          "drive": {"at": "top", "direction": [0, 1]}}, mesh=...),
        r"specimen.supports = .*expected {at = ..., direction = \[x, y\]}"),
    "drive without length": (
        changed(specimen={"kind": "mesh", "file": "a.msh", "thickness": 1.0, "crack": "c",
                          "supports": [{"at": "base", "direction": [0, 1]}], "drive": {"at": "top", "direction": [0, 0]}},
                mesh=...),
        r"specimen.drive.direction = \[0, 0\]: expected a vector that is not zero"),
}  # fmt: skip


@pytest.mark.parametrize("case", WRONG)
def test_wrong_input_is_named(case: str) -> None:
    data, message = WRONG[case]
    with pytest.raises(SceneError, match=message) as caught:
        Scene(data, Scene.load("notched-beam").folder)
    assert "\n" not in str(caught.value)


WRONG_GEOMETRY = {
    "path leaves the body": ([[0.0, 25.0], [0.0, 60.0]], r"crack path of length 35 mm: 25 mm of it follow element edges"),
    "path outside": ([[0.0, 60.0], [10.0, 70.0]], r"0 mm of it"),
    "path along an edge": ([[10.0, 50.0], [40.0, 50.0]], r"along its boundary"),
    "path without length": ([[0.0, 25.0], [0.0, 25.0]], r"has length 0"),
    "path of one point": ([[0.0, 25.0]], r"at least two points"),
    "path that cuts nothing": ([[20.0, 25.0], [20.0, 25.6]], r"cuts nothing"),
    "path over the notch": ([[0.0, 20.0], [0.0, 50.0]], r"along a notch or along itself"),
}


@pytest.mark.parametrize("case", WRONG_GEOMETRY)
def test_a_path_that_does_not_work_is_named(case: str) -> None:
    path, message = WRONG_GEOMETRY[case]
    with pytest.raises((MeshError, SceneError), match=message):
        run(Scene(BEAM).with_(**{"specimen.crack": path, "mesh.crack_size": 1.0}))


WRONG_PHYSICS = {
    "E in GPa": ({"material.E": 37.0}, r"material.E = 37: is it in MPa\?"),
    "ft in Pa": ({"material.ft": 3.4e6}, r"material.ft = 3.4e\+06: is it in MPa\?"),
    "Gf in N/m": ({"material.Gf": 70.0}, r"material.Gf = 70: is it in N/mm\?"),
    "ft with its point a digit off": ({"material.ft": 33.0}, r"material.ft = 33: is it in MPa\?"),
    "ft far below E": ({"material.ft": 0.03}, r"material.E = 37000, material.ft = 0.03: .*both in MPa"),
    "much fibre, small beam": ({"material.Gf": 17.0, "material.c1": 10.0}, r"material.Gf = 17: softening would end .*N/mm"),
    "a width of a metre": ({"interface.width": 1000.0}, r"interface.width = 1000: expected between"),
    "no width at all": ({"interface.width": 1e-9}, r"interface.width = 1e-09: expected between"),
    "sliding of a symmetric beam": ({"stage.0.control": "sliding"}, r"stage.0.control = 'sliding': the drive does not"),
    "nothing to do": ({"stage.0.to": 0.0}, r"stage.0.to = 0: the run starts there"),
    "more than there is": (
        {"stage.0.control": "dissipation", "stage.0.to": 600.0},
        r"stage.0.to = 600: the crack can dissipate",
    ),
}


@pytest.mark.parametrize("case", WRONG_PHYSICS)
def test_numbers_that_do_not_fit_together_are_named(case: str) -> None:
    changes, message = WRONG_PHYSICS[case]
    with pytest.raises(SceneError, match=message):
        # central by symmetry of the half, so that the beam cannot slide at all
        run(Scene.load("notched-beam").with_(**changes, **{"model.half": True}))


def test_python_mistakes_are_named() -> None:
    with pytest.raises(SceneError, match=r"Scene\('notched-beam'\): expected a dict"):
        Scene("notched-beam")  # type: ignore[arg-type]
    with pytest.raises(SceneError, match=r"Scene.load\(\{\}\): expected a file or the name"):
        Scene.load({})  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"expected a Scene"):
        run("notched-beam")  # type: ignore[arg-type]


def test_numpy_numbers_are_numbers() -> None:
    scene = Scene.load("notched-beam").with_(**{"stage.0.steps": np.int64(5), "stage.0.to": np.array([0.1, 0.2])})
    assert scene.stages[0].targets == [0.1, 0.2]
    assert tomllib.loads(dump_toml(scene.data)) == scene.data


WRONG_FILES = {
    "no scene": (["run", "none"], "no such file, and no built-in scene"),
    "near miss": (["run", "notched-bean"], "did you mean 'notched-beam'"),
    "no toml": (["run", "{tmp}/none.toml"], "cannot be read: No such file"),
    "not toml": (["run", "{tmp}/broken.toml"], "not valid TOML"),
    "folder is a file": (["run", "notched-beam", "-o", "{tmp}/broken.toml"], "output folder .* cannot be written"),
    "folder under a file": (["run", "notched-beam", "-o", "{tmp}/broken.toml/out"], "output folder .* cannot be written"),
    "set without value": (["run", "notched-beam", "--set", "material.Gf"], "expected KEY=VALUE"),
    "set of nothing known": (["run", "notched-beam", "--set", "material.gf=0.1"], "material.gf: unknown key"),
    "set beyond the stages": (["run", "notched-beam", "--set", "stage.3.to=0.1"], "stage.3.to: there is no such key"),
    "set into a number": (["run", "notched-beam", "--set", "title.x=1"], "title.x: there is no such key"),
    "model": (["run", "notched-beam", "--model", "both"], "model.kind = 'both'"),
    "law preset": (["law", "--preset", "granite", "-o", "{tmp}/law"], "preset = 'granite'"),
    "law width": (["law", "--width", "thin", "-o", "{tmp}/law"], "width = 'thin': expected a number"),
    "law parameter": (["law", "--set", "gf=1", "-o", "{tmp}/law"], "gf: unknown parameter"),
    "scene name": (["scenes", "beam"], "no such file, and no built-in scene"),
    "reference columns": (
        ["run", "notched-beam", "--set", "reference.file={tmp}/columns.csv"],
        r"columns.csv': its columns are x, y; expected",
    ),
    "reference text": (["run", "notched-beam", "--set", "reference.file={tmp}/text.csv"], "line 2, is '1,much'"),
    "reference empty": (["run", "notched-beam", "--set", "reference.file={tmp}/empty.csv"], "empty.csv': is empty"),
}


@pytest.mark.parametrize("case", WRONG_FILES)
def test_the_command_line_says_what_is_wrong_in_one_line(
    case: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments, message = WRONG_FILES[case]
    (tmp_path / "broken.toml").write_text("a = [")
    (tmp_path / "columns.csv").write_text("x,y\n1,2\n")
    (tmp_path / "text.csv").write_text("opening,load\n1,much\n")
    (tmp_path / "empty.csv").write_text("")
    assert main([part.replace("{tmp}", str(tmp_path)) for part in arguments]) == 2
    error = capsys.readouterr().err
    assert len(error.splitlines()) == 1
    assert error.startswith("cohesive: ")
    assert re.search(message, error)


@pytest.mark.parametrize("name", built_in())
def test_built_in_scenes_survive_a_round_trip(name: str) -> None:
    scene = Scene.load(name)
    assert tomllib.loads(dump_toml(scene.data)) == scene.data


def test_with_changes_a_copy() -> None:
    scene = Scene.load("notched-beam")
    other = scene.with_(**{"material.Gf": 0.1, "stage.0.to": [0.1, 0.0], "solver.tol": 1e-6})
    assert (other.material.Gf, other.stages[0].targets, other.solver.tol) == (0.1, [0.1, 0.0], 1e-6)
    assert scene.material.Gf == 0.07
    assert "solver" not in scene.data


def test_a_scene_from_python_is_independent_of_its_dict() -> None:
    data = changed(reference=...)
    scene = Scene(data)
    data["material"]["Gf"] = 5.0
    assert scene.with_(title="again").material.Gf == 0.07


def test_a_scene_cannot_be_changed() -> None:
    scene = Scene.load("notched-beam")
    for name in ("stages", "material", "data", "folder", "new"):
        with pytest.raises(AttributeError, match=rf"^{name}: a scene cannot be changed; expected scene.with_\(...\)"):
            setattr(scene, name, [])
    for copied in (scene, copy.deepcopy(scene), pickle.loads(pickle.dumps(scene))):
        copied.data["material"]["ft"] = -1.0
        copied.data["stage"].clear()
        copied.given("stage").clear()
        assert copied.data == Scene.load("notched-beam").data and copied.stages == Scene.load("notched-beam").stages
        with pytest.raises(AttributeError):
            copied.title = "another"
    assert isinstance(scene.stages, tuple)
    assert scene.given("stage.0.steps") == 60 and scene.given("stage.1") is scene.given("specimen.no") is None


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("stage.0.hold", 3600),
        ("stage.0.creep", 2.0),
        ("material.creep", 2.0),
        ("stage.0.rate", 0.1),
    ],
)
def test_what_asks_for_time_is_told_that_there_is_none(key: str, value: object) -> None:
    with pytest.raises(SceneError, match=f"^{key}.*time is not modelled"):
        block().with_(**{key: value})


def test_a_control_that_bending_does_not_change_names_those_that_it_does() -> None:
    """A notched beam without a gauge: the controls that are named run."""
    beam = coarse_beam("notched-beam", "stress", specimen__gauge=0.0)
    with pytest.raises(
        SceneError, match=r"stage.0.control = 'opening': .* expected 'deflection' or 'cmod' or 'ctod' or 'driven', or"
    ):
        run(beam.with_(**{"stage.0.control": "opening"}))
    assert run(beam.with_(**{"stage.0.control": "cmod", "stage.0.to": 0.01, "stage.0.steps": 2})).steps == 2
