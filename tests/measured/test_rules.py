"""Which columns of a measured table are taken, and what is asked about: the same numbers, or one sentence."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cohesive import SceneError, read_measured
from cohesive.measured.curve import Measured
from cohesive.measured.evaluation import evaluate
from tests.measured.files import BEAM, X, Y, numbers, read, semicolons, table

T = np.arange(len(X)) * 0.5
POUND = 4.4482216152605

SAME: dict[str, str] = {
    "kip": table("CMOD [mm],Load [kip]", X, Y / (1e3 * POUND)),
    "kips after a line": table("load_kips,cmod_mm", Y / (1e3 * POUND), X),
    "tf in a row": semicolons("CMOD;Kraft", X, Y / 9806.65, units="mm;tf"),
    "dN": table("CMOD [mm]\tLoad [dN]", X, 10.0 * Y, separator="\t"),
    "inches and lbs": table("CMOD (inches),Load (lbs)", X / 25.4, Y / POUND),
    "in. and lbf": table("Force / lbf,CMOD (in.)", Y / POUND, X / 25.4),
    "mil": table("CMOD [mil],Load [N]", X / 0.0254, Y),
    "Zoll": semicolons("Kraft in kp;Rissöffnung in Zoll", Y / 9.80665, X / 25.4),
    "10^-3 mm": table("CMOD [10^-3 mm],Load [N]", 1e3 * X, Y),
    "10^-3 mm without brackets": table("CMOD 10^-3 mm,Load N", 1e3 * X, Y),
    "mm/1000": semicolons("Kraft (kN);CMOD (mm/1000)", 1e-3 * Y, 1e3 * X),
    "1/1000 mm in a row": table("CMOD\tForce", 1e3 * X, Y, units="1/1000 mm\tN", separator="\t"),
    "0,001 mm": semicolons("CMOD (0,001 mm);Kraft (N)", 1e3 * X, Y),
    "superscript": table("CMOD [10⁻³ mm],Load [10³ N]", 1e3 * X, 1e-3 * Y),
    "French": semicolons("Temps (s);Effort (kN);Ouverture (mm)", T, 1e-3 * Y, X),
    "French charge": semicolons("Ouverture de fissure [mm];Charge [kN]", X, 1e-3 * Y),
    "German": semicolons("Zeit;Standardkraft;Rissöffnung", T, 1e-3 * Y, X, units="s;kN;mm"),
    "a load step first": table("Load step,CMOD [mm],Load [N]", T, X, Y),
    "a limit of the load": table("Load limit [N],Load [N],CMOD [mm]", np.full_like(Y, 2e4), Y, X),
    "a limit without units": table("cmod,load limit,load", X, np.full_like(Y, 2e4), Y),
    "a stress called load": table("CMOD [mm],Load [MPa],Force [N]", X, Y / 1e4, Y),
    "a column without a unit": semicolons("Kraft Kanal 7;Kraft [kN];CMOD [mm]", 0.1 * T, 1e-3 * Y, X),
    "an opening besides": table("opening,cmod,load", 0.7 * X, X, Y),
    "a crack opening besides": table("crack opening [mm],Load [N],CMOD [mm]", 0.7 * X, Y, X),
    "a deflection besides": semicolons("Durchbiegung [mm];Traversenweg [mm];CMOD [mm];Kraft [N]", X + 0.1, 2.0 * X, X, Y),
    "a gauge without a unit": table("CMOD,COD [mm],Load [N]", 7.0 * X, X, Y),
    "two gauges": semicolons("Time;Force;COD 1;COD 2", T, 1e-3 * Y, 1.1 * X, 0.9 * X, units="s;kN;mm;mm"),
    "two gauges, units apart": table("CMOD left [mm],CMOD right [um],Load [N]", 1.1 * X, 0.9e3 * X, Y),
    "two sides": semicolons("Rissöffnung links [mm];Rissöffnung rechts [mm];Kraft [N]", 1.1 * X, 0.9 * X, Y),
    "two clips": table("Clip gauge 1 (mm)\tClip gauge 2 (mm)\tForce (N)", 0.8 * X, 1.2 * X, Y, separator="\t"),
    "two of one name": table("Force,COD,COD", Y, 1.3 * X, 0.7 * X, units="N,mm,mm"),
    "three gauges": table("COD1,COD2,COD3,Force", 1.1 * X, 0.9 * X, X, Y, units="mm,mm,mm,N"),
    "a dead gauge": table("COD1,COD2,Force", np.full_like(X, 0.3), X, Y, units="mm,mm,N"),
    "a gauge not at zero": table("CMOD [mm],Load [N]", X + 1.234, Y),
    "a gauge below zero": semicolons("Kraft [kN];CMOD [mm]", 1e-3 * Y, X - 1.234),
    "a gauge in um not at zero": table("Load [N],CMOD [um]", Y, 1e3 * X + 500.0),
    "a gauge .02 mm off": table("CMOD [mm],Load [N]", X + 0.02, Y),
    "two gauges not at zero": table("COD 1 [mm],COD 2 [mm],Load [N]", X + 2.0, X - 0.5, Y),
}  # fmt: skip


@pytest.mark.parametrize("way", SAME)
def test_the_same_numbers_come_out(way: str, tmp_path: Path) -> None:
    measured = read(tmp_path, SAME[way])
    wanted = numbers(Measured.from_curve(X, Y, against="cmod"))
    assert numbers(measured) == pytest.approx(wanted, rel=1e-7)  # the files have 10 digits, their x a part of 1e-8 less
    assert measured.against == "cmod" and measured.low is None and not measured.doubt


NOTED = {
    "an opening besides": "column 2 (cmod) is taken as x; it also has 1 (opening)",
    "a deflection besides": "column 3 (CMOD) is taken as x; it also has 1 (Durchbiegung), 2 (Traversenweg)",
    "two gauges": "columns 3 (COD 1), 4 (COD 2) are gauges of one quantity: x is their mean",
    "a dead gauge": "column 2 (COD2) is taken as x; it also has 1 (COD1)",
    "a limit of the load": "column 2 (Load) is taken as load; it also has 1 (Load limit)",
    "a gauge not at zero": "cmod begins at 1.234 mm under 0 % of the largest load: it is counted from there",
    "German": None,
}


@pytest.mark.parametrize("way", NOTED)
def test_what_was_taken_is_said_with_what_else_there_was(way: str, tmp_path: Path) -> None:
    assert read(tmp_path, SAME[way]).notes == (() if NOTED[way] is None else (NOTED[way],))


BANDS = {
    "mean first": table("cmod_mm,load_mean_N,load_min_N,load_max_N", X, Y, 0.9 * Y, 1.1 * Y),
    "mean last, German": semicolons("Kraft max [kN];Kraft min [kN];Kraft Mittel [kN];CMOD [mm]", 1.1e-3 * Y, 0.9e-3 * Y, Y, X),
    "no mean": table("Load lower (N)\tLoad upper (N)\tCMOD (mm)", 0.9 * Y, 1.1 * Y, X, separator="\t"),
    "lbf": table("load_min_lbf,load_max_lbf,load_lbf,cmod_in", 0.9 * Y / POUND, 1.1 * Y / POUND, Y / POUND, X / 25.4),
    "bounds of another column": table("CMOD [mm],Load [N],Minimum load [N],Maximum load [N]", X, Y, 0.9 * Y, 1.1 * Y),
}


@pytest.mark.parametrize("way", BANDS)
def test_bounds_come_before_their_mean(way: str, tmp_path: Path) -> None:
    band = read(tmp_path, BANDS[way])
    assert band.low is not None and band.high is not None
    np.testing.assert_allclose([band.x, band.y, band.low, band.high], [X, Y, 0.9 * Y, 1.1 * Y], rtol=1e-9)
    assert bool(band.notes) == (way != "no mean")


REFUSED = {
    "two tests": (table("CMOD,Load,CMOD,Load", X, Y, X, Y), "it holds 2 specimens, '1', '2': expected reference.block"),
    "two loads": (table("CMOD,Load,Time,Load", X, Y, T, Y), r"columns 2 \(Load\), 4 \(Load\) are all loads"),
    "two loads, one x": (table("CMOD [mm],Load 1 [N],Load 2 [N]", X, Y, Y), r"2 \(Load 1\), 3 \(Load 2\) are all loads"),
    "load and force": (semicolons("Last;Kraft B1;Kraft B2;COD", T, Y, Y, X), "expected reference.x and reference.y = names"),
    "a constant load": (table("CMOD [mm],Load [N]", X, 0.0 * Y + 5.0), "its load is 5 N in every row"),
    "a gauge that hangs": (table("COD 1,COD 2,Load", X, 0.3 + 0.01 * X, Y), "gauges of one quantity move by 4 and 0.04 mm"),
    "xx": (table("CMOD [mm],Load [xx]", X, Y), r"column 2 \(Load\): its unit xx is no force that is known"),
    "xx in a row": (semicolons("Zeit;CMOD;Kraft", T, X, Y, units="s;mm;xx"), "its unit xx is no force"),
    "xx after a stroke": (table("CMOD / mm,Load / xx", X, Y), "its unit xx is no force"),
    "xx after in": (semicolons("Kraft in N;Rissöffnung in xx", Y, X), "its unit xx is no length"),
    "three bounds": (table("CMOD,Load", X, Y), "expected one column, or a list of two"),
    "tons": (semicolons("Kraft [to];CMOD [mm]", Y, X), "its unit to is no force"),
    "kilograms": (table("CMOD [mm],Load [kg]", X, Y), "its unit kg is no force"),
    "milli or mega": (table("CMOD [mm],Load [mn]", X, Y), "its unit mn is no force"),
    "range of a gauge": (table("COD (5 mm),Load (N)", X, Y), "its unit 5 mm is no length"),
    "capacity of a cell": (table("CMOD / mm,Load (100 kN)", X, Y), "its unit 100 kN is no force"),
    "a factor at the end": (table("CMOD [mm x 1000],Load [N]", X, Y), "its unit mm x 1000 is no length"),
    "half an exponent": (table("CMOD [10-3 mm],Load [N]", X, Y), "its unit 10-3 mm is no length"),
    "strain": (table("CMOD [mm/m],Load [N]", X, Y), "its unit mm/m is no length"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_told_is_refused_by_its_name(case: str, tmp_path: Path) -> None:
    text, message = REFUSED[case]
    keys = {"y": [1, 2, 3]} if case == "three bounds" else {}
    with pytest.raises(SceneError, match=f"^reference.file = 'test.csv': .*{message}") as caught:
        read(tmp_path, text, **keys)
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 250


DOUBTED = {
    "negative": (table("CMOD [mm],Load [N]", X, -Y), {}, "y_unit", "-N"),
    "negative kN": (semicolons("Kraft;CMOD", -1e-3 * Y, X, units="kN;mm"), {}, "y_unit", "-kN"),
    "negative, said": (table("CMOD,Load", X, -1e-3 * Y), {"y_unit": "kN"}, "y_unit", "-kN"),
    "kN": (table("cmod;load", X, 1e-3 * Y, separator=";"), {}, "y_unit", "kN"),
    "MN": (table("load\tcmod", 1e-6 * Y, X, separator="\t"), {}, "y_unit", "MN"),
    "mN": (semicolons("Kraft;Rissöffnung", 1e3 * Y, X), {}, "y_unit", "mN"),
    "um": (table("CMOD,Load [kN]", 1e3 * X, 1e-3 * Y), {}, "x_unit", "um"),
    "m": (table("Force,COD", Y, 1e-3 * X), {}, "x_unit", "m"),
    "no names": (table("1,0.001", X, 1e-3 * Y).split("\n", 1)[1], {}, "y_unit", "kN"),
}


@pytest.mark.parametrize("case", DOUBTED)
def test_what_cannot_be_meant_is_asked_about_with_the_key_that_corrects_it(case: str, tmp_path: Path) -> None:
    text, keys, key, unit = DOUBTED[case]
    measured = read(tmp_path, text, **keys)
    assert f"reference.{key} = '{unit}'" in measured.doubt and measured.doubt == measured.notes[-1]
    with pytest.raises(SceneError, match=f"reference.{key} = '{unit}'"):
        evaluate(measured, "en-14651", BEAM)
    corrected = read(tmp_path, text, **keys | {key: unit})
    assert not corrected.doubt
    wanted = numbers(Measured.from_curve(X, Y, against="cmod"))
    assert numbers(corrected) == pytest.approx(wanted, rel=1e-7)


def test_a_unit_that_a_key_says_is_not_asked_about(tmp_path: Path) -> None:
    assert read(tmp_path, table("CMOD [mm],Load [N]", X, 1e-3 * Y)).doubt
    assert not read(tmp_path, table("CMOD [mm],Load [N]", X, 1e-3 * Y), y_unit="N").doubt
    assert not read(tmp_path, table("CMOD,Load", X, 1e-3 * Y), y_unit="N").doubt
    assert not read(tmp_path, table("CMOD,Load", X, 0.1 * Y)).doubt  # a weak specimen


def test_a_load_at_the_start_is_said(tmp_path: Path) -> None:
    measured = read(tmp_path, table("CMOD [mm],Load [N]", X + 1.234, Y + 300.0))
    assert measured.x[0] == 0.0 and measured.y[0] == 300.0
    assert "the load at the start is 300 N, 2.5 % of the largest one, and is kept" in measured.notes[-1]
    assert read(tmp_path, table("CMOD [mm],Load [N]", X + 1.234, Y + 300.0), y_offset=300.0).y[0] == 0.0


def test_a_curve_that_begins_late_has_no_limit_of_proportionality() -> None:
    late = X > 0.2
    values = evaluate(Measured.from_curve(X[late], Y[late], against="cmod"), "en-14651", BEAM).values
    assert values["fct,L"] is None and values["fR1"] is not None


@pytest.mark.parametrize("load", [-Y, 0.0 * Y, 0.0 * Y + 1.0])
def test_a_load_that_never_rises_is_refused_without_a_warning(load: np.ndarray) -> None:
    with pytest.raises(SceneError, match="does not change, or is nowhere above 0"):
        evaluate(Measured.from_curve(X, load, against="cmod"), "en-14651", BEAM)


def test_a_steep_start_gives_no_modulus() -> None:
    """Two rows of one load between a tenth and four tenths of the peak, a motion that runs back against the load."""
    x, y = np.array([0.01, 0.02, 0.03, 0.04, 1.0]), np.array([3e3, 3e3, 1.5e3, 12e3, 1e3])
    assert evaluate(Measured.from_curve(x, y, against="cmod"), "en-14651", BEAM).values["E"] is None
    level = evaluate(Measured.from_curve(x[[0, 1, 3, 4]], y[[0, 1, 3, 4]], against="cmod"), "en-14651", BEAM).values["E"]
    assert level is not None and np.isfinite(level)


@pytest.mark.parametrize(
    ("first", "offset", "is_doubted"),
    [(0.2, 1.234, True), (0.2, -2.5, True), (0.11, 1.234, True), (0.5, 0.3, True), (0.2, 0.0, False), (0.5, 0.0, False),
     (0.9, 0.0, False), (0.05, 1.234, False)],
)  # fmt: skip
def test_a_curve_from_under_load_leads_back_to_zero(first: float, offset: float, is_doubted: bool, tmp_path: Path) -> None:
    """A softening curve from some part of its peak on, by a gauge that shows an offset; a small load is counted from there."""
    x = np.linspace(0.0, 0.2, 400)
    y = 1e4 * (x / 0.03) * np.exp(1.0 - x / 0.03)
    at = int(np.argmax(y >= first * y.max()))
    path = tmp_path / "late.csv"
    path.write_text(table("cmod_mm,load_N", x[at:] + offset, y[at:]), encoding="utf-8")
    measured = read_measured(path)
    assert ("does not lead back to 0" in measured.doubt) == is_doubted
    if is_doubted:
        with pytest.raises(SceneError, match=r"^reference.file = 'late.csv': its cmod begins at"):
            measured.without_doubt()


def test_a_curve_that_begins_behind_its_peak_is_not_doubted(tmp_path: Path) -> None:
    path = tmp_path / "tail.csv"
    path.write_text(table("cmod_mm,load_N", np.array([0.1, 0.2, 0.4]), np.array([900.0, 400.0, 100.0])), encoding="utf-8")
    assert read_measured(path).doubt == ""
