"""CSV tables: a heading, rows, a comment, and quoted cells."""

from __future__ import annotations

import csv
from pathlib import Path

from cohesive.results.files import write_table


def test_a_table_is_read_back_as_it_was_written(tmp_path: Path) -> None:
    rows = [["a, b", 1, "0.5"], ['"c"', 2, ""]]
    write_table(tmp_path / "table.csv", ["name", "number", "value"], rows, comment="about it")
    first, *lines = (tmp_path / "table.csv").read_text(encoding="utf-8").splitlines()
    assert first == "# about it"
    assert list(csv.reader(lines)) == [["name", "number", "value"], ["a, b", "1", "0.5"], ['"c"', "2", ""]]
    assert [path.name for path in tmp_path.iterdir()] == ["table.csv"]
