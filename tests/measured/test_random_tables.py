"""Random tables of a known curve, written as testing machines and people do: read right, or refused in one sentence.

    python -m tests.measured.test_random_tables [--count 500] [--first SEED]

prints what became of them. A table that is whole is read to its digits; of a damaged one that is read every point is a point
of the curve.
"""

from __future__ import annotations

import argparse
import collections
import tempfile
import time
from pathlib import Path

import numpy as np
import pytest

from cohesive import SceneError, read_measured
from cohesive.arrays import Array
from tests.measured.files import LIGAMENT, X, Y

#: millimetres and newtons in a unit
LENGTHS = {"mm": 1.0, "um": 1e-3, "µm": 1e-3, "cm": 10.0, "m": 1e3, "in": 25.4, "mil": 0.0254, "10^-3 mm": 1e-3}
FORCES = {"N": 1.0, "kN": 1e3, "daN": 10.0, "MN": 1e6, "kgf": 9.80665, "lbf": 4.4482216152605, "kip": 4448.2216152605}

#: names of the two columns
MOTIONS = ["CMOD", "cmod", "Clip gauge", "Crack mouth opening", "Rissöffnung", "Ouverture", "COD", "Opening"]
LOADS = ["Load", "load", "Force", "Kraft", "Standardkraft", "Charge", "Force appliquée", "Last Kraft"]

#: what a broken sensor leaves
HOLES = ["NaN", "nan", "---", "", "#N/A", "inf", "-1.#IND", "n/a", "OVERFLOW", "*****"]

#: what becomes of a whole file: nothing, its end is lost, a line is lost, one byte is another one, a field is a word
DAMAGES = ["none", "none", "none", "cut", "line", "byte", "hole"]


class Table:
    """A table of the curve of `tests.measured.files` by a seed; `content` is the file, `damage` what was done to it."""

    def __init__(self, seed: int) -> None:
        rng = np.random.default_rng([seed, 30])

        def one(choices: list[str]) -> str:
            return str(rng.choice(choices))

        self.damage = one(DAMAGES)
        self.separator = one([",", ";", "\t", "  ", " ; "])
        decimal = one([".", ","]) if "," not in self.separator else "."
        self.length, self.force = one(list(LENGTHS)), one(list(FORCES))
        if " " in self.separator.strip("\t;") and self.length == "10^-3 mm":
            self.length = "um"
        columns: list[tuple[str, str, Array]] = [
            (one(MOTIONS), self.length, X / LENGTHS[self.length]),
            (one(LOADS), self.force, Y / FORCES[self.force]),
        ]
        if rng.random() < 0.5:
            columns.insert(int(rng.integers(3)), (one(["Time", "Zeit", "Temps"]), "s", 0.5 * np.arange(len(X))))
        if rng.random() < 0.3:
            columns.append(
                (one(["Channel 7", "Temperature", "Machine"]), one(["V", "°C", ""]), 20.0 + np.sin(np.arange(len(X))))
            )
        if rng.random() < 0.5:
            columns.reverse()
        spaced = self.separator.strip(" ") == ""
        style = one(["[]", "()", "row", "comma"]) if not spaced else one(["[]", "()"])
        if "," in self.separator and style == "comma":
            style = "[]"
        names = [name.replace(" ", "_") if spaced else name for name, _, _ in columns]
        if style in ("[]", "()"):
            heading = [f"{n} {style[0]}{u}{style[1]}" if u else n for n, (_, u, _) in zip(names, columns, strict=True)]
            heading = [title.replace(" ", "") for title in heading] if spaced else heading
        elif style == "comma":
            heading = [f"{n}, {u}" if u else n for n, (_, u, _) in zip(names, columns, strict=True)]
        else:
            heading = names
        digits = one([".9g", ".12g", ".8e", "+.10E"])
        rows = [
            [f"{value:{digits}}".replace(".", decimal) for value in row] for row in zip(*(c[2] for c in columns), strict=True)
        ]
        quote = '"' if rng.random() < 0.2 and not spaced and self.separator != " ; " else ""
        lines = [] if rng.random() < 0.5 else [one(["Test 3", "# made on 2026-01-05", "Probe Nr. 7", "% A. Tester"]), ""]
        lines.append(self.separator.join(f"{quote}{title}{quote}" for title in heading))
        if style == "row":
            lines.append(self.separator.join(u or "-" for _, u, _ in columns))
        self.first = len(lines)
        fields = [self.separator.join(f"{quote}{field}{quote}" for field in row) for row in rows]
        if self.damage == "hole":
            row, column = int(rng.integers(len(rows))), int(rng.integers(len(columns)))
            rows[row][column] = one(HOLES)
            fields[row] = self.separator.join(rows[row])
        lines += fields
        if rng.random() < 0.3:
            lines += ["", "# end"]
        ends = [one(["\n", "\r\n", "\r"])] if rng.random() < 0.8 else ["\n", "\r\n"]
        text = "".join(line + ends[i % len(ends)] for i, line in enumerate(lines))
        encoding = one(["utf-8", "utf-8-sig", "utf-16", "cp1252"])
        if encoding == "cp1252":
            text = text.replace("μ", "µ")
        content = bytearray(text.encode(encoding))
        at = int(rng.integers(len(content)))
        if self.damage == "cut":
            content = content[:at]
        elif self.damage == "byte":
            content[at] = int(rng.integers(256))
        elif self.damage == "line":
            parts = text.splitlines(keepends=True)
            del parts[int(rng.integers(len(parts)))]
            content = bytearray("".join(parts).encode(encoding))
        self.content = bytes(content)

    def outcome(self, folder: Path) -> str:
        """Whether it is read or refused; AssertionError if a value is wrong, or a whole file is refused."""
        path = folder / "table.csv"
        path.write_bytes(self.content)
        clock = time.process_time()
        try:
            measured = read_measured(path, crack_area=LIGAMENT)
        except SceneError as error:
            assert "\n" not in str(error) and str(error)[:9] == "reference"
            assert self.damage != "none", str(error)
            return "refused"
        assert time.process_time() - clock < 5.0
        if self.damage == "none":
            np.testing.assert_allclose([measured.x, measured.y], [X, Y], rtol=1e-7, atol=1e-9)
            return "read"
        if self.damage != "byte":  # a digit may be another one
            near = np.isclose(measured.x[:, None], X, rtol=1e-7, atol=1e-9)
            wrong = ~(near & np.isclose(measured.y[:, None], Y, rtol=1e-7, atol=1e-6)).any(axis=1)
            if self.damage == "cut":  # the last number may have lost its last digits
                wrong = wrong[:-1]
            assert measured.notes or not wrong.any()  # without its heading it says what it was taken for
        return "read"


def _try(seeds: range) -> collections.Counter[tuple[str, str]]:
    counts: collections.Counter[tuple[str, str]] = collections.Counter()
    with tempfile.TemporaryDirectory() as folder:
        for seed in seeds:
            table = Table(seed)
            try:
                counts[table.damage, table.outcome(Path(folder))] += 1
            except Exception as error:
                raise AssertionError(f"seed {seed}, {table.damage}: {error}\n{table.content[:400]!r}") from error
    return counts


@pytest.mark.parametrize("first", [0, *(pytest.param(50 * i, marks=pytest.mark.long) for i in range(1, 10))])
def test_random_tables_are_read_right_or_refused(first: int) -> None:
    """50 by default, 500 in all."""
    assert _try(range(first, first + 50)).total() == 50


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--first", type=int, default=0)
    options = parser.parse_args()
    for (damage, status), number in sorted(_try(range(options.first, options.first + options.count)).items()):
        print(f"{damage:6s} {status:8s} {number}")
