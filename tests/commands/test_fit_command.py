"""`cohesive fit` and `cohesive evaluate`."""

from __future__ import annotations

import json
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


#: three files of the first half of Olsen's beam, the second and third with loads that are less
SERIES = {"A": 1.0, "B": 0.95, "C": 0.9}


def three_beams(folder: Path) -> list[str]:
    lines = CURVE.read_text(encoding="utf-8").splitlines()
    start = next(i for i, line in enumerate(lines) if line[:1].isdigit())
    names = []
    for name, part in SERIES.items():
        rows = [line.split(",") for line in lines[start:]]
        text = "\n".join(["driven_mm,load_N", *(f"{x},{part * float(y)}" for x, y in rows)])
        (folder / f"{name}.csv").write_text(text, encoding="utf-8")
        names.append(str(folder / f"{name}.csv"))
    (folder / "table.csv").write_text(
        "file,span,length,depth,thickness,notch,mass\nA,800,840,100,100,10,20.2\nB,800,840,100,95,10,20.2\nC,800,840,100,90,10,20.2\n",
        encoding="utf-8",
    )
    return names


def test_a_series_is_evaluated_each_by_its_dimensions(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files, out = three_beams(tmp_path), tmp_path / "out"
    given = ["--specimens", str(tmp_path / "table.csv"), "--standard", "rilem-tc-50", "-o", str(out)]
    assert main(["evaluate", *files, *given]) == 0
    assert "characteristic value" in capsys.readouterr().out
    facts = json.loads((out / "series.json").read_text(encoding="utf-8"))
    works = facts["values"]["W0"]
    assert works["C"] == pytest.approx(0.9 * works["A"])  # as their loads, and by areas that shrink alike:
    assert facts["values"]["GF, tail"]["C"] == pytest.approx(facts["values"]["GF, tail"]["A"])
    assert facts["statistics"]["W0"]["k_n"] == pytest.approx(3.37, abs=0.005)
    assert (out / "series.csv").read_text(encoding="utf-8").splitlines()[0].startswith("specimen,GF [N/mm],W0 [N mm]")
    assert (out / "series.png").stat().st_size > 1e4


@pytest.mark.long
def test_a_series_is_fitted_each_by_itself(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Loads and thickness are in proportion: three times the same numbers."""
    scene, out = tmp_path / "beam.toml", tmp_path / "out"
    scene.write_text(SCENE.split("[reference]")[0], encoding="utf-8")
    files = three_beams(tmp_path)
    vary = ["--vary", "material.ft=1:6", "--vary", "material.Gf=0.03:0.4"]
    assert main(["fit", str(scene), *files, "--specimens", str(tmp_path / "table.csv"), *vary, "-o", str(out)]) == 0
    assert "k_n" in capsys.readouterr().out
    facts = json.loads((out / "series.json").read_text(encoding="utf-8"))
    assert facts["statistics"]["material.ft"]["variation"] < 1e-3  # to what the fit stops at
    assert (out / "B" / "fit.json").exists() and (out / "series.png").exists()
    assert main(["fit", str(scene), "--specimens", "table.csv", *vary, "-o", str(out)]) == 2
    assert main(["fit", files[0], *vary, "-o", str(out)]) == 2
    assert "0 scenes with files of curves: expected one" in capsys.readouterr().err
