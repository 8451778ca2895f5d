"""`cohesive fit` and `cohesive evaluate`."""

from __future__ import annotations

from pathlib import Path

import pytest

from cohesive.commands.command_line import main

CURVE = Path(__file__).parents[2] / "examples" / "data" / "olsen-normal-strength-beam.csv"

SCENE = f"""
[specimen]
kind = "notched-beam"
length = 840.0
span = 800.0
depth = 100.0
thickness = 100.0
notch = 10.0
[mesh]
crack_size = 9.0
far_size = 30.0
[material]
E = 26110.0
nu = 0.2
ft = 2.7
Gf = 0.11
softening = "hordijk"
[[stage]]
control = "driven"
to = 1.0
steps = 20
[reference]
file = "{CURVE}"
"""


def test_fit(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = tmp_path / "beam.toml"
    scene.write_text(SCENE, encoding="utf-8")
    out = tmp_path / "out"
    vary = ["--vary", "material.ft=1:6", "--vary", "material.Gf=0.03:0.4"]
    assert main(["fit", str(scene), *vary, "-o", str(out), "--export", "abaqus"]) == 0
    printed = capsys.readouterr().out
    assert "rms 2." in printed
    assert "*CONCRETE TENSION STIFFENING" in printed
    assert (out / "fit.png").stat().st_size > 1e4
    assert main(["run", str(out / "scene.toml"), "-o", str(tmp_path / "run"), "--set", "output.frames=0"]) == 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--vary", "material.ft=6"], "expected KEY=LOW:HIGH"),
        (["--vary", "material.ft=6:2"], "the first below the second"),
        (["--vary", "material.fd=1:2"], "the scene has no number there"),
        (["--vary", "ft=1:2"], "number there (did you mean 'material.ft'?)"),
        ([], "vary is empty"),
    ],
)
def test_bad_input(arguments: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = tmp_path / "beam.toml"
    scene.write_text(SCENE, encoding="utf-8")
    assert main(["fit", str(scene), *arguments, "-o", str(tmp_path / "out")]) == 2
    assert message in capsys.readouterr().err


def test_evaluate(capsys: pytest.CaptureFixture[str]) -> None:
    sizes = {"span": 800, "depth": 100, "thickness": 100, "notch": 10, "length": 840}
    given = [part for key, value in sizes.items() for part in ("--set", f"specimen.{key}={value}")]
    assert main(["evaluate", str(CURVE), "--standard", "rilem-tc-50", *given, "--set", "mass=20.2"]) == 0
    assert "GF" in capsys.readouterr().out
    assert main(["evaluate", str(CURVE), "--standard", "rilem-tc-50", *given]) == 2
    assert "mass is missing" in capsys.readouterr().err
