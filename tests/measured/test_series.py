"""A series of specimens: its table of dimensions, and the statistics of EN 1990 with the factors that its table D1 prints."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cohesive import SceneError
from cohesive.measured.curve import Measured
from cohesive.measured.evaluation import evaluate
from cohesive.measured.series import Series, Specimen, k_n, specimens_of, statistics
from tests.measured.files import BEAM

#: EN 1990:2002, table D1, 5 % characteristic value, V_X unknown
PRINTED = {3: 3.37, 4: 2.63, 5: 2.33, 6: 2.18, 8: 2.00, 10: 1.92, 20: 1.76, 30: 1.73}


@pytest.mark.parametrize("count", PRINTED)
def test_the_factor_is_that_of_the_table(count: int) -> None:
    assert k_n(count) == pytest.approx(PRINTED[count], abs=0.015)  # the table rounds 2.010 to 2.00 and 1.772 to 1.76
    assert k_n(10**8) == pytest.approx(1.64, abs=0.005)


def test_statistics_by_hand() -> None:
    """No example of the standard: 4, 5, 6 and 9 have mean 6 and the sum of squares 14, and k_4 = 2.63."""
    found = statistics([4.0, 5.0, 6.0, 9.0])
    assert (found.count, found.mean) == (4, 6.0)
    assert found.deviation == pytest.approx(math.sqrt(14.0 / 3.0))
    assert found.variation == pytest.approx(found.deviation / 6.0)
    assert found.characteristic == pytest.approx(6.0 - 2.63 * found.deviation, abs=0.01)
    one = statistics([4.0])
    assert one.mean == 4.0 and math.isnan(one.deviation) and math.isnan(one.characteristic)


def test_the_table_has_each_and_leaves_out_what_a_curve_does_not_reach() -> None:
    series = Series(["B1", "B2", "B3"], {"fR1": [4.0, 5.0, 6.0], "fR4": [1.0, None, 2.0]}, {"fR1": "MPa", "fR4": "MPa"})
    rows = {str(row[0]): row[1:] for row in series.rows()}
    assert rows["specimen"] == ["fR1 [MPa]", "fR4 [MPa]"] and rows["B2"] == [5.0, None]
    assert rows["n"] == [3, 2] and rows["mean"] == [5.0, 1.5]
    assert "EN 1990 Annex D, table D1, V_X unknown" in series.summary()
    seen = replace(series, intervals={"fR1": [[3.5, 4.5], [None, None], [5.0, 7.0]]})
    rows = {str(row[0]): row[1:] for row in seen.rows()}
    assert rows["specimen"] == ["fR1 [MPa]", "fR1 from", "fR1 to", "fR4 [MPa]"]
    assert rows["B1"] == [4.0, 3.5, 4.5, 1.0] and rows["B2"] == [5.0, None, None, None]
    assert rows["mean"] == [5.0, None, None, 1.5]


def test_strengths_of_the_model_code_by_hand() -> None:
    """No worked example: (5.6-5) and (5.6-6) of the Model Code 2010 for f_R1 = 4 and f_R3 = 3 MPa give 1.8 and .7 MPa."""
    factor = 3 * 500.0 / (2 * 150.0 * 125.0**2)
    x, y = np.array([0.02, 0.05, 0.5, 1.5, 2.5, 3.5]), np.array([9e3, 12e3, 4.0 / factor, 3.5 / factor, 3.0 / factor, 3e3])
    values = evaluate(Measured.from_curve(x, y, against="cmod"), "en-14651", BEAM).values
    assert values["fFts"] == pytest.approx(1.8) and values["fFtu"] == pytest.approx(0.7)
    brittle = evaluate(Measured.from_curve(x, y * [1, 1, 1, 0.1, 0.1, 0.1], against="cmod"), "en-14651", BEAM).values
    assert brittle["fFtu"] == 0.0
    short = evaluate(Measured.from_curve(x[:4], y[:4], against="cmod"), "en-14651", BEAM).values
    assert short["fFts"] == pytest.approx(1.8) and short["fFtu"] is None


TABLES = {
    "keys": "file,specimen.depth,specimen.thickness,mass\na.csv,150.4,150.2,29.9\nb.csv,149.8,150,30\n",
    "German": "Datei;Höhe [cm];Breite [mm];Masse [kg]\na.csv;15,04;150,2;29,9\nb;14,98;150,0;30,0\n".replace("Datei", "file"),
    "a name": "name\tfile\twidth\tdepth\tmass [g]\nB1\ta\t150.2\t150.4\t29900\nB2\tb.csv\t150\t149.8\t30000\n",
}


@pytest.mark.parametrize("way", TABLES)
def test_a_table_of_specimens(way: str, tmp_path: Path) -> None:
    table = tmp_path / "table.csv"
    table.write_text(TABLES[way], encoding="utf-8")
    found = specimens_of([tmp_path / "a.csv", tmp_path / "b.csv"], table)
    assert [each.name for each in found] == (["B1", "B2"] if way == "a name" else ["a", "b"])
    wanted = [(150.4, 150.2, 29.9), (149.8, 150.0, 30.0)]
    keys = ("specimen.depth", "specimen.thickness", "mass")
    for each, numbers in zip(found, wanted, strict=True):
        assert [each.values[key] for key in keys] == pytest.approx(list(numbers), rel=1e-12)


def test_rows_of_one_file(tmp_path: Path) -> None:
    table, book = tmp_path / "table.csv", tmp_path / "beams.xlsx"
    table.write_text("sheet,block,span,notch,y\nTabelle1,B1,500,,\nTabelle1,B2,500,25,3\n", encoding="utf-8")
    first, second = specimens_of([book], table)
    assert first == Specimen("B1", book, {"reference.sheet": "Tabelle1", "reference.block": "B1", "specimen.span": 500.0})
    assert second.values["specimen.notch"] == 25.0 and second.values["reference.y"] == 3
    assert specimens_of([book]) == [Specimen("beams", book, {})]


REFUSED = {
    "a word": ("file,span\na.csv,long\nb.csv,5\n", r"line 2, column 'span': 'long': expected a number of at least 0"),
    "a force": ("file,span [kN]\na.csv,5\nb.csv,5\n", "expected a number of at least 0, in mm or kg"),
    "below 0": ("file,span\na.csv,-5\nb.csv,5\n", "expected a number of at least 0"),
    "a stranger": ("file,speed\na.csv,5\nb.csv,5\n", "column 'speed' is not known; expected file, sheet"),
    "another file": ("file,span\na.csv,5\nc.csv,5\n", "line 3: 'c.csv' is none of the files"),
    "no file": ("span,depth\n5,4\n5,4\n", "line 2: it names no file"),
    "one is left": ("file,span\na.csv,5\na.csv,5\n", "no row names the file"),
    "a field too few": ("file,span\na.csv,5\nb.csv\n", "line 3: it has 1 fields, the heading 2"),
    "nothing": ("file,span\n", "expected a heading and a row for each specimen"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_table_that_does_not_fit_is_refused_in_one_sentence(case: str, tmp_path: Path) -> None:
    text, message = REFUSED[case]
    table = tmp_path / "table.csv"
    table.write_text(text, encoding="utf-8")
    with pytest.raises(SceneError, match=message) as caught:
        specimens_of([tmp_path / "a.csv", tmp_path / "b.csv"], table)
    assert str(caught.value).startswith("--specimens ") and "\n" not in str(caught.value)


def test_a_table_that_is_missing(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"--specimens .*: is not a regular file"):
        specimens_of([tmp_path / "a.csv"], tmp_path / "none.csv")
