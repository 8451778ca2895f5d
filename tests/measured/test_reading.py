"""Measured files: twenty ways of writing one curve are read alike, broken ones are refused in one sentence."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cohesive import Scene, SceneError
from cohesive.measured.curve import Measured, Reference
from cohesive.scenes.reference import load_reference

#: a part of the load-deflection curve of Olsen's beam, mm and N, as in the identification benchmark of Tin-Loi and Que
OLSEN = np.array(
    [[0.0197, 528.118], [0.0917, 1715.61], [0.1698, 2675.61], [0.257, 1689.16], [0.6423, 426.543], [1.1141, 133.748]]
)

BEAM = {key: value for key, value in Scene.load("notched-beam").data.items() if key != "reference"}


def read(folder: Path, content: str | bytes, specimen: dict[str, Any] = BEAM["specimen"], **keys: Any) -> Reference:
    (folder / "olsen.csv").write_bytes(content if isinstance(content, bytes) else content.encode())
    reference = load_reference(Scene(BEAM | {"specimen": specimen, "reference": {"file": "olsen.csv"} | keys}, folder))
    assert reference is not None
    return reference


def curve(folder: Path, content: str | bytes, **keys: Any) -> Measured:
    (measured,) = read(folder, content, **keys).curves
    return measured


def rows(separator: str = ",", decimal: str = ".", x: float = 1.0, y: float = 1.0, quote: str = "", end: str = "\n") -> str:
    """The curve in other units: x and y are what 1 mm and 1 N are in them."""
    lines = [[f"{quote}{value:.10g}{quote}".replace(".", decimal) for value in (a * x, b * y)] for a, b in OLSEN]
    return "".join(separator.join(line) + end for line in lines)


def with_time(separator: str, decimal: str) -> str:
    """The curve between columns that are no part of it, one of them no numbers."""
    lines = [
        f"12:00:0{i}{separator}{i}{decimal}5{separator}{row}" for i, row in enumerate(rows(separator, decimal).splitlines())
    ]
    return "\n".join(f"{line}{separator}ok" for line in lines)


ALIKE: dict[str, tuple[str | bytes, dict[str, Any]]] = {
    "plain": ("driven,load\n" + rows(), {}),
    "semicolon, decimal comma": ("driven;load\n" + rows(";", ","), {}),
    "tab": ("driven\tload\n" + rows("\t"), {}),
    "tab, decimal comma": ("driven\tload\n" + rows("\t", ","), {}),
    "spaces": ("  driven   load\n" + rows("   "), {}),
    "spaces, decimal comma": ("driven [mm] load [N]\n" + rows(" ", ","), {}),
    "quoted": ('"driven","load"\n' + rows(quote='"'), {}),
    "quoted, comma twice": ('"driven","load"\n' + rows(decimal=",", quote='"'), {}),
    "mark of UTF-8": (("driven,load\n" + rows()).encode("utf-8-sig"), {}),
    "UTF-16": (("driven;load\n" + rows(";", ",")).encode("utf-16"), {}),
    "UTF-16 without a mark": (("driven;load\n" + rows(";", ",")).encode("utf-16-le"), {}),
    "latin-1": (("Prüfkörper 3\ndriven [µm];load\n" + rows(";", ",", x=1e3)).encode("latin-1"), {}),
    "Windows and old Mac": ("driven,load\r\n" + rows(end="\r"), {}),
    "lines before": ("Test 3\n\nSpan;800;mm\nOperator;Olsen\n\ndriven;load\n" + rows(";"), {}),
    "comments": ("# Olsen\n# driven,load\n" + rows() + "# end\n\n", {}),
    "units in brackets": ("Displacement (um);Force [kN]\n" + rows(";", ",", x=1e3, y=1e-3), {}),
    "units after a comma": ("Stroke, mm\tLoad, kN\n" + rows("\t", y=1e-3), {}),
    "units as columns": ("Stroke,mm,Load,kN\n" + rows(y=1e-3), {}),
    "units in a row": ("Zeit;t;Standardweg;Standardkraft;Status\n;s;mm;N;-\n" + with_time(";", ","), {"x": "Standardweg"}),
    "units as suffixes": ("driven_m,load_kN\n" + rows(x=1e-3, y=1e-3), {}),
    "units from the scene": ("driven,load\n" + rows(x=1e3, y=1e-3), {"x_unit": "um", "y_unit": "kN"}),
    "names of one's choice": ("Load point,F2\n" + rows(), {"x": "Load point", "y": "F2"}),
    "numbers of columns": ("a,b,a,b\n" + "".join(f"0,0,{row}\n" for row in rows().splitlines()), {"x": 3, "y": 4}),
    "no names": (rows(), {}),
    "turned": ("driven,load\n" + rows(x=-1.0, y=-1e-3), {"x_unit": "-mm", "y_unit": "-kN"}),
    "exponents": ("driven,load\n" + "".join(f"{a:.6e},{b:+.6E}\n" for a, b in OLSEN), {}),
    "separator at the end": ("driven,load\n" + rows(end=",\n"), {}),
    "blank rows": ("driven;load\n" + rows(";", end="\n;\n\n"), {}),
}


@pytest.mark.parametrize("way", ALIKE)
def test_one_curve_written_in_many_ways_is_read_alike(way: str, tmp_path: Path) -> None:
    content, keys = ALIKE[way]
    measured = curve(tmp_path, content, **keys | {"against": "driven"})
    np.testing.assert_allclose([measured.x, measured.y], OLSEN.T, rtol=1e-9)  # the files have 10 digits
    assert not measured.is_band


HEAD = "driven,load\n"
WRONG: dict[str, tuple[str | bytes, dict[str, Any], str]] = {
    "a word": (HEAD + "1,2\n2,much\n", {}, r"line 3, column 2 \(load\): 'much' is no number"),
    "a word at once": (HEAD + "1,much\n2,3\n3,4\n", {}, "line 2, column 2: 'much' is no number"),
    "nothing": ("", {}, "is empty"),
    "no numbers": ("a\nb\n", {}, "no row with two numbers; its last one, line 2, is 'b'"),
    "an empty field": (HEAD + "1,2\n2,\n", {}, r"line 3, column 2 \(load\): it is empty"),
    "NaN": (HEAD + "1,2\n2,nan\n3,4\n", {}, r"line 3, column 2 \(load\): 'nan' is no value; expected at most 10 %"),
    "infinite": (HEAD + "1,2\n1e999,2\n3,4\n", {}, r"line 3, column 1 \(driven\): '1e999' is not finite"),
    "thousands of four digits": (HEAD + "1,2\n2,1'0835\n", {}, r"line 3, column 2 \(load\): \"1'0835\" is no number"),
    "mixed decimal signs": ("driven;load\n0,5;2\n0.6;3\n0,7;4\n", {}, r"line 3, column 1 \(driven\): '0.6' is no number"),
    "a field too many": (HEAD + "1,2\n2,3\n3,4,5\n", {}, "line 4: it has 3 fields, the rows before it 2"),
    "a field too few": (HEAD + "1,2\n2,3\n3\n", {}, "line 4: it has 1 field, the rows before it 2"),
    "comma twice": (HEAD + "0,1,2,5\n0,2,3,5\n", {}, "line 1: the heading has 2 fields and the rows below it 4"),
    "a heading of its own": ("x,y\n1,2\n", {}, "its columns are x, y; expected an opening or a deflection"),
    "no load": ("driven,time\n1,2\n", {}, "its columns are driven, time; expected a load"),
    "no such column": (HEAD + "1,2\n", {"y": "Kraft"}, r"no column 'Kraft' \(reference.y\); its columns are driven, load"),
    "no such number": (HEAD + "1,2\n", {"x": 3}, "it has 2 columns; expected reference.x = 3 to be one of them"),
    "twice the same": ("driven,load,Load\n1,2,3\n", {}, r"columns 2 \(load\), 3 \(Load\) are all loads: are they different"),
    "no names of three": ("1,2,3\n4,5,6\n", {}, "its 3 columns have no names; expected reference.x = number"),
    "a unit of another kind": ("driven [V],load\n1,2\n", {}, r"column 1 \(driven\): its unit V is no length"),
    "a stress": ("driven,load [MPa]\n1,2\n", {}, r"column 2 \(load\): its unit MPa is no force"),
    "an unknown unit": (HEAD + "1,2\n", {"y_unit": "bananas"}, "reference.y_unit = 'bananas': expected one of N, kN"),
    "against nothing": (
        HEAD + "1,2\n",
        {"against": "load"},
        "reference.against = 'load': expected a column of the history in mm",
    ),
    "a name that says nothing": (
        "a,load\n1,2\n",
        {"x": "a"},
        "'a', says no column .* expected reference.against = 'opening' or",
    ),
    "another gauge": ("tilt,load\n1,2\n", {"against": "tilt"}, "reference.against = 'tilt': expected a column of the history"),
    "crossed bounds": ("driven,load_min,load_max\n1,2,3\n2,5,4\n", {}, "line 3: the lower bound 5 N is above the upper, 4 N"),
    "a band that runs back": (
        "driven,load_min,load_max\n1,2,3\n1,3,4\n",
        {},
        r"line 3, column 1 \(driven\): it does not rise",
    ),
    "the other way": (HEAD + "-1,2\n-2,3\n", {}, "expected it to rise, or reference.x_unit = '-mm'"),
    "a long field": (HEAD + f"1,{'9' * 200_000}\n", {}, "line 2: it has 200002 characters"),
    "a long quoted field": (HEAD + f'1,"{"9" * 200_000}"\n', {}, "line 2: it has 200004 characters"),
    "a spreadsheet": (b"PK\x03\x04\x14\x00\x06\x00\x08\x00\x00\x00", {}, "is no workbook that can be read"),
    "an old spreadsheet": (b"\xd0\xcf\x11\xe0" + bytes(600), {}, "is a workbook of the time before 2007"),
    "a picture": (b"\x89PNG\0\0\0\0\0", {}, "is not text; expected a table of text"),
    "three bounds": (HEAD + "1,2\n", {"y": [1, 2, 3]}, "expected a list of two columns"),
    "no files": (HEAD, {"file": []}, r"reference.file = \[\]: expected a file or a list of different files"),
    "twice the same file": (HEAD, {"file": ["a.csv", "a.csv"]}, "expected a file or a list of different files"),
    "a long name": (HEAD, {"file": "a" * 5000}, "can be no name of a file"),
    "a folder": (HEAD, {"file": "."}, "is not a regular file"),
    "a device": (HEAD, {"file": "/dev/zero"}, "/dev/zero is not a regular file"),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_broken_file_is_refused_in_one_sentence(case: str, tmp_path: Path) -> None:
    content, keys, message = WRONG[case]
    with pytest.raises(SceneError, match=message) as caught:
        curve(tmp_path, content, **keys)
    said = str(caught.value)
    assert "\n" not in said and len(said) < 400
    assert said.startswith("reference.")
    if not {"file", "against", "y_unit"} & keys.keys() and case != "three bounds":
        assert said.startswith("reference.file = 'olsen.csv': ")


def test_a_fifo_is_refused_and_does_not_block(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.csv")
    with pytest.raises(SceneError, match=r"pipe.csv is not a regular file"):
        Scene(BEAM | {"reference": {"file": "pipe.csv"}}, tmp_path)


def test_the_name_of_x_says_what_it_is_drawn_against(tmp_path: Path) -> None:
    for title, column in {"CMOD [mm]": "opening", "Stroke (mm)": "driven", "crack-sliding": "sliding"}.items():
        assert read(tmp_path, f"time,{title},Force\n0,1,2\n1,2,3\n").against == column
    both = "Stroke,CMOD,Load\n1,0.1,3\n2,0.2,4\n"
    assert read(tmp_path, both).against == "opening"  # whatever their order
    np.testing.assert_array_equal(curve(tmp_path, both, against="driven").x, [1.0, 2.0])
    assert read(tmp_path, both, x="Stroke").against == "driven"
    assert read(tmp_path, "Deflection [mm],Load\n1,2\n2,3\n").against == "deflection"
    with pytest.raises(SceneError, match=r"says ctod, which this run has not; expected reference.against = 'opening' or"):
        read(tmp_path, "CTOD,Load\n1,2\n2,3\n", specimen=BEAM["specimen"] | {"notch": 0.0})


def test_a_clip_gauge_is_the_main_gauge_if_there_is_one(tmp_path: Path) -> None:
    text = "CMOD,Load\n1,2\n2,3\n"
    assert read(tmp_path, text).against == "opening"
    assert read(tmp_path, text, against="cmod").against == "cmod"
    assert read(tmp_path, text, specimen=BEAM["specimen"] | {"gauge": 0.0}).against == "cmod"


def test_bands_and_curves(tmp_path: Path) -> None:
    band = curve(tmp_path, "cmod_mm,load_min_kN,load_max_kN\n0.1,1,2\n0.2,3,4\n")
    assert band.is_band
    np.testing.assert_array_equal([band.low, band.high, band.y], [[1e3, 3e3], [2e3, 4e3], [1.5e3, 3.5e3]])
    named = curve(tmp_path, "cmod,a,b\n0.1,1,2\n0.2,3,4\n", y=["a", "b"])
    assert named.is_band


def test_what_runs_back_is_left_out_and_said(tmp_path: Path) -> None:
    measured = curve(tmp_path, "driven [mm],load [N]\n0,0\n0.1,1000\n0.05,100\n0.08,500\n0.2,800\n")
    np.testing.assert_array_equal(measured.x, [0.0, 0.1, 0.2])
    assert measured.notes == ("driven runs back in 2 of its 5 rows, in 1 unloading(s) by up to 0.05 mm, which are left out",)


@pytest.mark.parametrize("failed", ["#N/A", "#DIV/0!", "#VALUE!", "#REF!", "#NUM!", "#NAME?"])
def test_what_a_spreadsheet_writes_for_a_failed_cell_is_no_comment(failed: str, tmp_path: Path) -> None:
    """A row that began with it parted its table in two specimens, or was lost without a word."""
    rows = [f"{10 * i},{0.01 * i:.2f}" for i in range(20)]
    rows[12] = f"{failed},0.12"
    measured = curve(tmp_path, "load [N],driven [mm]\n" + "\n".join(rows) + "\n")
    assert len(measured.x) == 19
    assert f"the first is line 14, column 1 (load): '{failed}' is no value" in measured.notes[-1]


@pytest.mark.parametrize("foot", ["End of test", "end,of test", "Peak 290 N", "End\nOperator: A. B.", "load [N],driven [mm]"])
def test_text_below_the_rows_is_left_out_and_said(foot: str, tmp_path: Path) -> None:
    rows = "".join(f"{10 * i},{0.01 * i:.2f}\n" for i in range(20))
    measured = curve(tmp_path, f"load [N],driven [mm]\n{rows}{foot}\n")
    assert len(measured.x) == 20
    first, *more = foot.split("\n")
    assert measured.notes == (f"{1 + len(more)} line(s) below its rows are text, from {first!r} on, and are left out",)


def test_a_wrong_last_row_is_no_text(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"line 4, column 1 .*: 'Peak' is no number"):
        curve(tmp_path, "load [N],driven [mm]\n0,0\n10,0.01\nPeak,0.01\n")


def a_million(write: Callable[[float, float], str]) -> str:
    x = np.linspace(0.0, 1.0, 10**5)  # repeated ten times: the file is what takes time, not its making
    return "".join(write(a, b) for a, b in zip(x, np.exp(-x), strict=True)) * 10


@pytest.mark.parametrize(
    ("heading", "y", "said"),
    [("load", 1e-3, "no unit is named: if it is in kN"), ("load [N]", 1e-3, "its heading says N: if it is in kN"),
     ("load [kN]", 1.0, "its heading says kN: if it is in N")],
)  # fmt: skip
def test_a_load_that_no_concrete_bears_is_asked_about(heading: str, y: float, said: str, tmp_path: Path) -> None:
    text, unit = f"opening [mm],{heading}\n" + rows(y=y), said.split()[-1]
    assert said in curve(tmp_path, text).doubt
    told = curve(tmp_path, text, y_unit=unit)  # a key decides
    assert not told.doubt
    assert told.y.max() == pytest.approx(y * {"kN": 1e3, "N": 1.0}[unit] * OLSEN[:, 1].max())


@pytest.mark.long
def test_a_million_rows_take_seconds(tmp_path: Path) -> None:
    """1.9 s on a shared core, 115 s row by row in Python; the bound leaves room for a machine that is busy."""
    text = "Zeit;CMOD [mm];Kraft [N]\n" + a_million(lambda a, b: f"0,5;{a:.7f};{b:.5f}\n".replace(".", ","))
    clock = time.process_time()
    measured = curve(tmp_path, text, y="Kraft")
    assert time.process_time() - clock < 10.0
    assert abs(len(measured.x) - 10**5) < 20  # near its turns a row may be taken for noise of the last digit
    assert "in 9 unloading(s) by up to 1 mm" in measured.notes[0]
