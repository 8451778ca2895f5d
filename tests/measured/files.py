"""A measured curve of a notched beam (EN 14651), and tables of it as testing machines write them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cohesive.arrays import Array
from cohesive.measured.curve import Measured
from cohesive.measured.evaluation import evaluate
from cohesive.measured.reading import read_measured

BEAM: dict[str, Any] = {"specimen.span": 500.0, "specimen.depth": 150.0, "specimen.thickness": 150.0, "specimen.notch": 25.0}
LIGAMENT = 150.0 * 125.0

#: crack mouth opening, mm, and load, N, of a concrete of about 3.8 MPa
X = np.r_[np.linspace(0.0, 0.03, 16), np.geomspace(0.035, 4.0, 50)]
Y = np.where(X < 0.04, 300e3 * X, 12e3 * (0.04 / np.maximum(X, 0.04)) ** 0.6)


def table(heading: str, *columns: Array, units: str = "", separator: str = ",", decimal: str = ".") -> str:
    """A table of columns; the heading, and a row of units if there is one, stand as they are."""
    rows = [[f"{value:.10g}".replace(".", decimal) for value in row] for row in zip(*columns, strict=True)]
    return "\n".join([heading, *([units] if units else []), *(separator.join(row) for row in rows)]) + "\n"


def semicolons(heading: str, *columns: Array, units: str = "") -> str:
    return table(heading, *columns, units=units, separator=";", decimal=",")


def read(folder: Path, text: str, **keys: Any) -> Measured:
    path = folder / "test.csv"
    path.write_text(text, encoding="utf-8")
    return read_measured(path, crack_area=LIGAMENT, **keys)


def numbers(measured: Measured, standard: str = "en-14651", beam: dict[str, Any] = BEAM) -> Sequence[float | None]:
    """What a standard takes from it."""
    return list(evaluate(measured, standard, beam).values.values())
