"""Scenes and changes that no one should trust: one sentence and status 2, or they are taken."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

from cohesive import Scene, SceneError, run
from cohesive.commands.command_line import main
from cohesive.scenes.scene import dump_toml

GOOD = """
title = "a block"
[specimen]
kind = "single-crack"
width = 40.0
height = 40.0
thickness = 10.0
[mesh]
crack_size = 10.0
far_size = 20.0
[material]
preset = "reinhardt"
[[stage]]
control = "opening"
to = 0.001
steps = 1
[output]
frames = 0
"""

#: TOML texts by name; `GOOD` stands for the text above, in which the first part may take the place of the second one
TEXTS: dict[str, tuple[str | bytes | tuple[str, str], str]] = {
    "good": (GOOD, ""),
    "with a BOM": (b"\xef\xbb\xbf" + GOOD.encode(), ""),
    "latin-1": (GOOD.replace("block", "blöck").encode("latin-1"), "not valid TOML: .*utf-8"),
    "UTF-16": (GOOD.encode("utf-16"), ""),
    "Windows line ends": (GOOD.replace("\n", "\r\n").encode(), ""),
    "empty": ("", r"\[specimen\] is missing"),
    "zeros": (b"\0" * 5000, "not valid TOML"),
    "an image": (b"\x89PNG\r\n\x1a\n" + bytes(range(256)), "not valid TOML"),
    "JSON": ('{"title": 1}', "not valid TOML"),
    "cut short": (GOOD[:60], "not valid TOML|is missing"),
    "a number of 5,000 digits": (("thickness = 10.0", "thickness = 1" + "0" * 5000), "not valid TOML: Exceeds the limit"),
    "a number of 4,000 digits": (
        ("thickness = 10.0", "thickness = 1" + "0" * 4000),
        "specimen.thickness: a whole number of about 4",
    ),
    "digits in a list": (("to = 0.001", "to = [1" + "0" * 400 + "]"), "stage.to: a whole number of about 40"),
    "a fraction of 5,000 digits": (("thickness = 10.0", "thickness = 10." + "0" * 5000), ""),
    "an exponent too large": (
        ("thickness = 10.0", "thickness = 1e99999"),
        "specimen.thickness = inf: expected a finite number",
    ),
    "not a number": (("thickness = 10.0", "thickness = nan"), "specimen.thickness = nan: expected"),
    "arrays 1,000 deep": (("to = 0.001", "to = " + "[" * 1000 + "]" * 1000), "not valid TOML|nested more than 20 levels"),
    "arrays 50 deep": (("to = 0.001", "to = " + "[" * 50 + "]" * 50), "nested more than 20 levels"),
    "tables 1,000 deep": (("frames = 0", "a = " + "{a = " * 1000 + "1" + "}" * 1000), "not valid TOML|nested more than 20"),
    "a key 1,000 deep": (("frames = 0", ".".join("a" * 1000) + " = 1"), "nested more than 20 levels"),
    "a table 1,000 deep": (("[output]", "[" + ".".join("a" * 1000) + "]"), "unknown key|nested more than 20 levels"),
    "a name of 5,000 characters": (("frames = 0", "x" * 5000 + " = 1"), r"output.xxx+\.\.\.x+: unknown key"),
    "a table of 5,000 characters": (("[output]", "[" + "x" * 5000 + "]"), r"xxx+\.\.\.x+: unknown key"),
    "a kind of 5,000 characters": (("single-crack", "x" * 5000), "specimen.kind = 'x+...x+': expected one of"),
    "a preset of 5,000 characters": (("reinhardt", "x" * 5000), "material.preset = 'x+...x+': expected one of"),
    "a control of 5,000 characters": (('"opening"', '"' + "x" * 5000 + '"'), "stage.0.control = "),
    "a title of 5,000 characters": (("a block", "x" * 5000), ""),
    "a name with a line end": (("frames = 0", '"a\\nb" = 1'), r"output.a\\nb: unknown key"),
    "a value with a line end": (("reinhardt", "a\\nb"), r"material.preset = 'a\\nb': expected"),
    "an empty name": (("frames = 0", '"" = 1'), "output.: unknown key"),
    "a key twice": (("frames = 0", "frames = 0\nframes = 1"), "not valid TOML"),
    "a table twice": (("[output]", "[mesh]"), "not valid TOML"),
    "a list for a table": (("[output]", "[[output]]"), r"output = .*: expected a table \[output\]"),
    "a table for stages": (("[[stage]]", "[stage]"), "stage is missing or not a list of tables"),
    "lists for a table": (("[mesh]", "[[mesh]]"), "mesh = .*: expected a table"),
    "a string for a number": (("thickness = 10.0", 'thickness = "10"'), "specimen.thickness = '10': expected a finite number"),
    "true for a number": (("thickness = 10.0", "thickness = true"), "specimen.thickness = True: expected a finite number"),
    "a date for a number": (
        ("thickness = 10.0", "thickness = 1979-05-27"),
        "specimen.thickness = .*: expected a finite number",
    ),
    "a list for a number": (("thickness = 10.0", "thickness = [10.0]"), "specimen.thickness = .*: expected a finite number"),
    "a table for a number": (("thickness = 10.0", "thickness = {a = 1}"), "specimen.thickness = .*: expected a finite number"),
    "a list for a string": (('"opening"', '["opening"]'), "stage.0.control = .*: expected"),
    "below zero": (("thickness = 10.0", "thickness = -1"), "specimen.thickness = -1: expected"),
    "zero": (("thickness = 10.0", "thickness = 0"), "specimen.thickness = 0: expected"),
    "as small as can be": (("thickness = 10.0", "thickness = 5e-324"), "the body is not held: its stiffness is singular"),
    "as large as can be": (
        ("thickness = 10.0", "thickness = 1.7e308"),
        "specimen.thickness = 1.7e.308: expected a finite number",
    ),
    "a target that is a table": (("to = 0.001", "to = {a = 1}"), "stage.0.to = "),
    "a target that is text": (("to = 0.001", 'to = "far"'), "stage.0.to = "),
    "no target": (("to = 0.001", "to = []"), "stage.0.to = "),
    "half a step": (("steps = 1", "steps = 0.5"), "stage.0.steps = 0.5: expected a whole number"),
    "no steps": (("steps = 1", "steps = 0"), "stage.0.steps = 0"),
    "an event that is a list": (("steps = 1", "until = [1]"), "stage.0.until = "),
    "an event of nothing": (("steps = 1", "until = {}"), "stage.0.until = "),
    "an event of two": (("steps = 1", "until = {load = 1, opening = 2}"), "stage.0.until = "),
    "a width of words": (("[output]", '[interface]\nwidth = "wide"\n[output]'), "interface.width = 'wide'"),
    "softening of numbers": (("[[stage]]", "softening = 3\n[[stage]]"), "material.softening"),
    "softening points that are text": (("[[stage]]", 'softening = {points = [["a", 1]]}\n[[stage]]'), "material.softening"),
    "three proportions, one of them text": (("[[stage]]", 'p = [1, 2, "x"]\n[[stage]]'), "material.p = "),
    "a path of text": (("height = 40.0", 'height = 40.0\ncrack = "along"'), "specimen"),
    "a reference that is a folder": (("[output]", '[reference]\nfile = "."\n[output]'), "reference.file = "),
    "a reference of 5,000 characters": (("[output]", '[reference]\nfile = "' + "x" * 5000 + '"\n[output]'), "reference.file"),
}

#: --set by name
CHANGES: dict[str, tuple[str, str]] = {
    "a superscript": ("stage.².to=1", "stage.².to: there is no such key"),
    "an Arabic digit": ("stage.\u0660.to=0.002", ""),
    "a negative stage": ("stage.-1.to=1", "stage.-1.to: there is no such key"),
    "a stage of 5,000 digits": ("stage." + "9" * 5000 + ".to=1", "there is no such key|digits"),
    "a number of 5,000 digits": ("specimen.thickness=1" + "0" * 5000, "--set specimen.*Exceeds the limit"),
    "a number of 400 digits": ("specimen.thickness=1" + "0" * 400, "specimen.thickness: a whole number of about 40. digits"),
    "arrays 1,000 deep": ("stage.0.to=" + "[" * 1000 + "]" * 1000, "--set stage.0.to=|nested more than 20"),
    "tables 1,000 deep": ("output.a=" + "{a=" * 1000 + "1" + "}" * 1000, "--set output.a=|nested more than 20"),
    "a key 1,000 deep": (".".join("a" * 1000) + "=1", "unknown key|nested more than 20"),
    "a key 1,000 deep in a table": ("output." + ".".join("a" * 1000) + "=1", "nested more than 20"),
    "a name of 5,000 characters": ("x" * 5000 + "=1", "unknown key"),
    "a value of 5,000 characters": ("model.kind=" + "x" * 5000, "model.kind = 'x+...x+': expected"),
    "no name": ("=1", "expected KEY=VALUE"),
    "dots": ("...=1", "unknown key"),
    "a dot at the end": ("stage.0.=1", "stage.0.: unknown key"),
    "two lines": ("title=a\nb=1", ""),
    "a comment": ("specimen.thickness=10.0 # mm", ""),
    "a date": ("specimen.thickness=1979-05-27", "specimen.thickness = .*: expected a finite number"),
    "a line end in a name": ("a\nb=1", r"a\\nb: unknown key"),
    "into a number": ("specimen.thickness.x=1", "there is no such key"),
    "into a list": ("stage.x=1", "there is no such key"),
}


def assert_said(arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Status 2 and one line with a message; status 0 without one."""
    status = main(arguments)
    error = capsys.readouterr().err
    assert (status, len(error.splitlines())) == ((2, 1) if message else (0, 0)), error[-2000:]
    assert re.search(message, error) and len(error) < 2500, error
    assert "Traceback" not in error


@pytest.mark.parametrize("name", TEXTS)
def test_a_text(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text, message = TEXTS[name]
    if isinstance(text, tuple):
        old, new = text
        assert old in GOOD
        text = GOOD.replace(old, new, 1)
    (tmp_path / "scene.toml").write_bytes(text.encode() if isinstance(text, str) else text)
    if not message:  # without pictures, which are another matter
        assert run(Scene.load(tmp_path / "scene.toml"), output=tmp_path / "out").steps == 1
        return
    assert_said(["run", str(tmp_path / "scene.toml"), "-o", str(tmp_path / "out")], message, capsys)


@pytest.mark.parametrize("name", CHANGES)
def test_a_change(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    change, message = CHANGES[name]
    (tmp_path / "scene.toml").write_text(GOOD)
    assert_said(["run", str(tmp_path / "scene.toml"), "-o", str(tmp_path / "out"), "--set", change], message, capsys)


def test_what_is_no_file_is_no_scene(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    os.mkfifo(tmp_path / "pipe.toml")
    (tmp_path / "zero.toml").symlink_to("/dev/zero")
    (tmp_path / "folder.toml").mkdir()
    (tmp_path / "loop.toml").symlink_to(tmp_path / "loop.toml")
    for source, message in (
        (str(tmp_path / "pipe.toml"), "it is a pipe or a device; expected a file"),
        (str(tmp_path / "zero.toml"), "it is a pipe or a device; expected a file"),
        ("/dev/zero", "it is a pipe or a device; expected a file"),
        (str(tmp_path / "folder.toml"), "cannot be read: Is a directory"),
        (str(tmp_path / "loop.toml"), "cannot be read: Too many levels"),
        ("x" * 5000, "no such file, and no built-in scene"),
        ("x" * 5000 + ".toml", "cannot be read: File name too long"),
    ):
        assert_said(["scenes", source], message, capsys)


def test_python_values_without_end_are_refused() -> None:
    endless: dict[str, object] = {}
    endless["a"] = endless
    for data, message in (
        (endless, "nested more than 20 levels"),
        ({"title": 10**5000}, "title: a whole number of about 5000 digits"),
        ({"stage": [[[[[[[[[[[[[[[[[[[[[[1]]]]]]]]]]]]]]]]]]]]]]}, "stage: it is nested more than 20"),
    ):
        with pytest.raises(SceneError, match=message):
            Scene(data)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be"])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_a_file_of_another_shell_is_read(encoding: str, end: str, tmp_path: Path) -> None:
    """PowerShell's `>` writes a byte order mark, and before version 6 UTF-16."""
    scene = Scene.load("notched-beam").with_(title="Bruchz\u00e4higkeit \u6df7")
    text = dump_toml(scene.data).replace("\n", end)
    mark = "\ufeff" if encoding in ("utf-16-le", "utf-16-be") else ""
    (tmp_path / "beam.toml").write_bytes((mark + text).encode(encoding))
    assert Scene.load(tmp_path / "beam.toml").data == scene.data


def test_text_that_is_no_text_is_refused(tmp_path: Path) -> None:
    text = "title = 'x'\n"
    wide = text.encode("utf-16-le")
    for content in (wide, b"\xff\xfe" + wide[:-1], text.encode("utf-32"), b"\xfe\xff\xd8"):
        (tmp_path / "wide.toml").write_bytes(content)
        with pytest.raises(SceneError, match="not valid TOML"):
            Scene.load(tmp_path / "wide.toml")
    with pytest.raises(SceneError, match="characters that no file can hold"):
        Scene.load("notched-beam").with_(title="a\udcff")  # as bytes that are no UTF-8 come from a command line
