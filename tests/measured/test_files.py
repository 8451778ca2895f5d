"""Files as testing machines and laboratories write them, with several specimens in one: the right numbers, or one question."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cohesive import SceneError, read_measured
from cohesive.arrays import Array
from cohesive.measured.curve import Measured
from tests.measured.files import LIGAMENT, X, Y, read, semicolons, table

openpyxl = pytest.importorskip("openpyxl")

T = np.arange(len(X)) * 0.5
ROWS = np.array_split(np.arange(len(X)), 4)


def grouped(value: float, sign: str, decimal: str, digits: int) -> str:
    return f"{value:_.{digits}f}".replace(".", decimal).replace("_", sign)


def thousands(sign: str, decimal: str, separator: str, quote: str = "", digits: int = 2) -> str:
    pairs = [(f"{x:.9f}".replace(".", decimal), grouped(y, sign, decimal, digits)) for x, y in zip(X, Y, strict=True)]
    rows = [separator.join(f"{quote}{text}{quote}" for text in pair) for pair in pairs]
    return "\n".join([f"CMOD [mm]{separator}Load [N]", *rows])


def repeated(heading: str, separator: str = "\t") -> str:
    """A file whose machine writes its heading again and again."""
    return "\n\n".join(table(heading.replace("@", str(k)), T[rows], X[rows], Y[rows], separator=separator)
                       for k, rows in enumerate(ROWS))  # fmt: skip


def stacked(first: str, second: str, heading: str = "CMOD;Kraft") -> str:
    one, two = semicolons(heading, X, 1e-3 * Y, units="mm;kN"), semicolons(heading, X, 0.9e-3 * Y, units="mm;kN")
    return f"{first}\n{one}\n{second}\n{two}"


#: files of one specimen
ONE: dict[str, str] = {
    "1,075.0": thousands(",", ".", ",", '"'),
    "1,075.0 and tabs": thousands(",", ".", "\t"),
    "1.075,0": thousands(".", ",", ";"),
    "1 075,0": thousands("\u202f", ",", ";"),
    "1'075.0": thousands("'", ".", ","),
    "MTS": repeated("MTS793|MPT|ENU\n\nBlock @\tTime:\t@\tSec\nTime\tCMOD\tAxial Force\nSec\tmm\tN"),
    "comments between": repeated("# segment @\n# time [s];CMOD [mm];Load [N]", ";"),
    "one name, repeated": repeated("Specimen\tB1\nTime [s]\tCMOD [mm]\tLoad [N]"),
    "times that are one": repeated("Test name;B1\nZeit [s];CMOD [mm];Kraft [N]", ";"),
}  # fmt: skip


@pytest.mark.parametrize("way", ONE)
def test_one_specimen_is_read_whatever_its_machine_adds(way: str, tmp_path: Path) -> None:
    measured = read(tmp_path, ONE[way])
    np.testing.assert_allclose([measured.x, measured.y], [X, Y], rtol=1e-6, atol=6e-3)  # 2 digits of the load
    assert any(note.startswith("4 tables of one heading go on") for note in measured.notes) == ("075" not in way)


#: files of two specimens of which the second bears nine tenths; how the first and the second are called
TWO: dict[str, tuple[str, list[Any]]] = {
    "stacked": (stacked("Probe;B1", "Probe;B2"), ["B1", "b2"]),
    "stacked, a colon": (stacked("Specimen: B1", "Specimen: B2", "CMOD;Load"), ["B1", 2]),
    "stacked, a line": (stacked("Beam 1", "Beam 2"), ["Beam 1", "beam_2"]),
    "stacked, no names": (stacked("", ""), [1, 2]),
    "comments": (f"# CMOD [mm],Load [N]\n# B1\n{table('#', X, Y)}# B2\n{table('#', X, 0.9 * Y)}", [1, 2]),
    "gnuplot": (f"cmod,load\n{table('#', X, Y)}\n\n{table('#', X, 0.9 * Y)}", ["1", "2"]),
    "another order": (table("CMOD,Load", X, Y) + table("Load,CMOD", 0.9 * Y, X), [1, 2]),
    "side by side, a row over it": (
        "Zeit;B1;;B2;\n" + semicolons(";CMOD;Kraft;CMOD;Kraft", T, X, 1e-3 * Y, X, 0.9e-3 * Y, units="s;mm;kN;mm;kN"),
        ["B1", "B2"],
    ),
    "side by side, in the titles": (table("Time,Load B1,CMOD B1,Load B2,CMOD B2", T, Y, X, 0.9 * Y, X), ["B1", "B2"]),
    "side by side, under lines": (table("cmod_1_mm,load_1_N,cmod_2_mm,load_2_N", X, Y, X, 0.9 * Y), [1, 2]),
    "side by side, letters": (table("Force A [N],COD A [mm],Force B [N],COD B [mm]", Y, X, 0.9 * Y, X), ["A", "B"]),
    "the same titles": (table("CMOD\tLoad\tCMOD\tLoad", X, Y, X, 0.9 * Y, separator="\t"), [1, 2]),
    "as pandas writes them": (table("cmod,load,cmod.1,load.1", X, Y, X, 0.9 * Y), [1, 2]),
}


@pytest.mark.parametrize("way", TWO)
def test_a_specimen_is_taken_by_its_name_and_asked_for_without(way: str, tmp_path: Path) -> None:
    text, names = TWO[way]
    with pytest.raises(SceneError, match=r"^reference.file = 'test.csv': it holds 2 specimens, .*expected reference.block"):
        read(tmp_path, text)
    for name, part in zip(names, (1.0, 0.9), strict=True):
        measured = read(tmp_path, text, block=name)
        np.testing.assert_allclose([measured.x, measured.y], [X, part * Y], rtol=1e-9)  # the files have 10 digits
    with pytest.raises(SceneError, match=r"reference.block = 'B7': expected one of '"):
        read(tmp_path, text, block="B7")


def test_a_table_continues_by_its_numbers_and_by_its_name(tmp_path: Path) -> None:
    """A second test that was recorded from under load is no continuation, nor is one of another specimen that is."""
    late = table("CMOD,Load", X, Y) + table("CMOD,Load", X[8:], 0.9 * Y[8:])
    with pytest.raises(SceneError, match="it holds 2 specimens"):
        read(tmp_path, late)
    np.testing.assert_allclose(read(tmp_path, late, block=2).y, 0.9 * Y[8:], rtol=1e-9)
    halves = [table("Time,CMOD,Load", T[part], X[part], Y[part]) for part in np.array_split(np.arange(len(X)), 2)]
    assert len(read(tmp_path, "Specimen,B1\n" + "Specimen,B1\n".join(halves)).x) == len(X)
    with pytest.raises(SceneError, match="it holds 2 specimens, 'B1', 'B2'"):
        read(tmp_path, "Specimen,B1\n" + "Specimen,B2\n".join(halves))


OPEN = {
    "thousands or decimals": ("1\t950\n2\t1.075\n3\t1.180\n", "'1.075' stands in one column with '950'"),
    "four digits beside three": ("0.1\t1234\n0.2\t1,075\n0.3\t1,180\n", "'1,075' stands in one column with '1234'"),
    "a stray comma": ("0.1\t1.5\n0.2\t1,600\n0.3\t1.7\n", "'1,600' stands in one column with '1.5'"),
}


@pytest.mark.parametrize("case", OPEN)
def test_a_sign_that_may_be_two_things_is_refused(case: str, tmp_path: Path) -> None:
    rows, message = OPEN[case]
    with pytest.raises(SceneError, match=rf"column 2 \(Load\): {message}.*written alike"):
        read(tmp_path, "CMOD\tLoad\n" + rows)


@pytest.mark.parametrize("word", ["---", "", "NaN", "#N/A", "n/a", "****", "#DIV/0!", "null", "OVER"])
def test_rows_without_a_value_are_left_out_and_said(word: str, tmp_path: Path) -> None:
    lines = table("CMOD;Load;Time", X, Y, T, separator=";").splitlines()
    for row in (8, 31):
        lines[row] = ";".join([lines[row].split(";")[0], word, "1"])
    measured = read(tmp_path, "\n".join(lines))
    assert len(measured.x) == len(X) - 2 and X[7] not in measured.x
    said = "2 of its 66 rows are left out, because a value is lost; the first is line 9, column 2"
    assert measured.notes[0].startswith(said)
    lines[10:20] = [f"{x};{word};0" for x in X[9:19]]
    with pytest.raises(SceneError, match="expected at most 10 % of the rows without a value"):
        read(tmp_path, "\n".join(lines))


def test_a_shorter_specimen_beside_a_longer_one_ends_where_it_does(tmp_path: Path) -> None:
    lines = table("CMOD B1,Load B1,CMOD B2,Load B2", X, Y, X, 0.9 * Y).splitlines()
    lines[41:] = [",".join([*line.split(",")[:2], "", ""]) for line in lines[41:]]
    short = read(tmp_path, "\n".join(lines), block="B2")
    np.testing.assert_allclose([short.x, short.y], [X[:40], 0.9 * Y[:40]], rtol=1e-9)
    assert short.notes == () and len(read(tmp_path, "\n".join(lines), block="B1").x) == len(X)
    with pytest.raises(SceneError, match=r"column 2 \(Load\) is empty"):
        read(tmp_path, "CMOD,Load,Time\n" + "".join(f"0.{i},,{i}\n" for i in range(9)), y="Load", x="Load", against="cmod")


def test_the_mean_of_gauges_that_are_named(tmp_path: Path) -> None:
    text = semicolons("COD 1;COD 2;COD 3;Kraft", 0.9 * X, 1.1 * X, 3.0 * X, 1e-3 * Y, units="mm;mm;mm;kN")
    np.testing.assert_allclose(read(tmp_path, text, x=["COD 1", "COD 2"]).x, X, rtol=1e-9)
    with pytest.raises(SceneError, match=r"reference.x = \[1, 1\]: expected different columns"):
        read(tmp_path, text, x=[1, 1])


def test_dimensions_of_the_heading_are_offered(tmp_path: Path) -> None:
    heading = "Probe;B1\nBreite;150,2;mm\nHöhe:;15,04;cm\nStützweite [mm];500\nMasse;29,8;kg\nDatum;12;\n"
    measured = read(tmp_path, heading + semicolons("Kraft;CMOD", Y, X, units="N;mm"))
    offered = {"specimen.thickness": 150.2, "specimen.depth": 150.4, "specimen.span": 500.0, "mass": 29.8}
    assert measured.dimensions == pytest.approx(offered)
    said = "its heading says thickness 150.2, depth 150.4, span 500, mass 29.8 (mm, kg); nothing of it is taken"
    assert measured.notes == (said,)
    other = "Width: 100 mm\nSpan: 400 mm\nDepth: 100\n\n" + table("CMOD (mm),Load (N)", X, Y)
    assert read(tmp_path, other).dimensions == {"specimen.thickness": 100.0, "specimen.span": 400.0}  # one has no unit


def workbook(path: Path, sheets: dict[str, list[list[Any]]]) -> Path:
    book = openpyxl.Workbook()
    book.remove(book.active)
    for name, rows in sheets.items():
        sheet = book.create_sheet(name)
        for row in rows:
            sheet.append(row)
    book.save(path)
    return path


def cells(y: Array, *above: list[Any]) -> list[list[Any]]:
    rows = [list(row) for row in zip(range(len(X)), y.tolist(), X.tolist(), strict=True)]
    return [*above, ["Zeit", "Kraft", "CMOD"], ["s", "N", "mm"], *rows]


def read_book(path: Path, **keys: Any) -> Measured:
    return read_measured(path, crack_area=LIGAMENT, **keys)


def test_a_sheet_of_a_workbook(tmp_path: Path) -> None:
    info = [["Probe", "B1"], ["Breite", 150.2]]
    measured = read_book(workbook(tmp_path / "one.xlsx", {"Info": info, "Werte": cells(Y, ["Höhe", 150.4, "mm"], [])}))
    np.testing.assert_allclose([measured.x, measured.y], [X, Y], rtol=1e-14)  # a workbook has 16 digits
    assert measured.notes[0] == "sheet 'Werte' is read; 'Info' has no table of numbers"
    assert measured.dimensions == {"specimen.depth": 150.4}
    two = workbook(tmp_path / "two.xlsx", {"B1": cells(Y), "Tabelle2": cells(np.round(0.9 * Y))})
    with pytest.raises(SceneError, match=r"it has tables on the sheets 'B1', 'Tabelle2': expected reference.sheet"):
        read_book(two)
    for sheet in ("Tabelle2", 2):
        np.testing.assert_array_equal(read_book(two, sheet=sheet).y, np.round(0.9 * Y))  # whole numbers beside others
    with pytest.raises(SceneError, match=r"reference.sheet = 'B3': expected one of 'B1', 'Tabelle2'"):
        read_book(two, sheet="B3")


def test_whole_numbers_of_a_sheet_are_not_taken_for_thousands(tmp_path: Path) -> None:
    rows = [["CMOD [mm]", "Kraft [kN]"], [0.1, 1], [0.2, 1.075], [0.3, 2.125], [0.4, 3]]
    np.testing.assert_array_equal(read_book(workbook(tmp_path / "w.xlsx", {"1": rows})).y, [1e3, 1075.0, 2125.0, 3e3])


def test_specimens_side_by_side_on_a_sheet(tmp_path: Path) -> None:
    rows = [["B1", None, "B2", None], ["CMOD [mm]", "Kraft [kN]"] * 2]
    rows += [[x, 1e-3 * y, x, 0.9e-3 * y] for x, y in zip(X.tolist(), Y.tolist(), strict=True)]
    path = workbook(tmp_path / "beside.xlsx", {"Tabelle1": rows})
    np.testing.assert_allclose(read_book(path, sheet="Tabelle1", block="B2").y, 0.9 * Y, rtol=1e-12)


def test_a_text_has_no_sheets(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"reference.sheet = 'B1': it is no workbook"):
        read(tmp_path, table("CMOD,Load", X, Y), sheet="B1")
