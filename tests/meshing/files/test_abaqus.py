"""Input files of Abaqus: sets that add up, in any case, and what is refused by its line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from meshing import MeshError
from meshing.files.abaqus import read_abaqus

NODES = "*NODE\n1, 0, 0\n2, 1, 0\n3, 2, 0\n4, 0, 1\n5, 1, 1\n6, 2, 1\n"
CELLS = "*ELEMENT, TYPE=CPS4\n10, 1, 2, 5, 4\n20, 2, 3, 6, 5\n"


def read(path: Path, text: str) -> tuple[dict[str, list[int]], dict[str, list[list[int]]]]:
    """Sets of nodes, and of elements by blocks."""
    (path / "mesh.inp").write_text(text)
    mesh = read_abaqus(path / "mesh.inp")
    assert mesh.points.shape == (6, 3)
    nodes = {name: at.tolist() for name, at in mesh.point_sets.items()}
    return nodes, {name: [at.tolist() for at in blocks] for name, blocks in mesh.cell_sets.items()}


@pytest.mark.parametrize(
    ("text", "nodes", "cells"),
    [
        ("*NSET, NSET=top\n4, 5\n*NSET, NSET=top\n6\n", {"top": [3, 4, 5]}, {}),
        ("*NSET, NSET=Top\n4\n*nset, nset=TOP\n5, 6,\n", {"Top": [3, 4, 5]}, {}),
        ("*NSET, NSET=top, GENERATE\n4, 6, 1\n", {"top": [3, 4, 5]}, {}),
        ("*NSET, NSET=odd, generate\n1, 3, 2\n5, 5\n", {"odd": [0, 2, 4]}, {}),
        ("*NSET, NSET=a\n4\n*NSET, NSET=b\na, 6\n", {"a": [3], "b": [3, 5]}, {}),
        ("*NSET, NSET=a, INSTANCE=P-1\nP-1.4, 5\n", {"a": [3, 4]}, {}),
        ("*ELSET, ELSET=low\n10\n*NSET, NSET=of, ELSET=low\n", {"of": [0, 1, 3, 4]}, {"low": [[0]]}),
        ("*ELSET, ELSET=all\n10\n*Elset, elset=ALL\n20\n", {}, {"all": [[0, 1]]}),
        ("*ELSET, ELSET=all, GENERATE\n10, 20, 10\n", {}, {"all": [[0, 1]]}),
        ("*ELEMENT, TYPE=T3D2, ELSET=base\n1, 1, 2\n*ELEMENT, TYPE=T3D2, ELSET=BASE\n2, 2, 3\n", {}, {"base": [[], [0, 1]]}),
        ("** a comment\n*SURFACE, NAME=S\n10, S1\n*STEP\n*STATIC\n1., 1.\n*END STEP\n", {}, {}),
    ],
)  # fmt: skip
def test_sets_add_up(text: str, nodes: dict[str, list[int]], cells: dict[str, list[list[int]]], tmp_path: Path) -> None:
    assert read(tmp_path, NODES + CELLS + text) == (nodes, cells)


def test_blocks_of_nodes_and_elements_are_joined(tmp_path: Path) -> None:
    first, second = NODES[: NODES.index("4, 0, 1")], "*Node, nset=upper\n" + NODES[NODES.index("4, 0, 1") :]
    one = "*ELEMENT, TYPE=CPE4R, ELSET=one\n10, 1, 2, 5, 4\n*ELSET, ELSET=two\n10\n"
    elements = one + "*ELEMENT, TYPE=CPS4I\n20, 2, 3,\n6, 5\n"
    nodes, cells = read(tmp_path, first + second + elements)
    assert nodes == {"upper": [3, 4, 5]} and cells == {"one": [[0]], "two": [[0]]}


@pytest.mark.parametrize(
    ("given", "name", "count"),
    [("CPE4", "quad", 4), ("cps4r", "quad", 4), ("CPS8R", "quad8", 8), ("CPE6M", "triangle6", 6), ("CPE3H", "triangle", 3)],
)
def test_plane_types_are_read_whatever_their_formulation(given: str, name: str, count: int, tmp_path: Path) -> None:
    """Of nodes on a circle: only how many there are matters here."""
    at = 2 * np.pi * np.arange(count) / count
    nodes = "".join(f"{i + 1}, {np.cos(a)}, {np.sin(a)}\n" for i, a in enumerate(at))
    numbers = ", ".join(str(i + 1) for i in range(count))
    (tmp_path / "mesh.inp").write_text(f"*NODE\n{nodes}*ELEMENT, TYPE={given}\n1, {numbers}\n")
    (block,) = read_abaqus(tmp_path / "mesh.inp").cells
    assert block.type == name


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (NODES + "*ELEMENT, TYPE=CAX4\n1, 1, 2, 5, 4\n", r"line 8: \*ELEMENT: type CAX4; expected"),
        (NODES + "*ELEMENT, TYPE=CPS4RT\n1, 1, 2, 5, 4\n", "line 8: .*type CPS4RT"),
        (NODES + "*ELEMENT\n1, 1, 2, 5, 4\n", "type missing"),
        (NODES + "*ELEMENT, TYPE=CPS4\n1, 1, 2, 5\n", "line 9: element 1 of type CPS4 has 3 nodes; expected 4"),
        (NODES + CELLS + CELLS, "line 12: element 10 is given twice"),
        (NODES + "*ELEMENT, TYPE=CPS4\n1, 1, 2, 5, 9\n", "element 1 names node 9, which the file has not"),
        (NODES + CELLS + "*NSET, NSET=a\n9\n", "set 'a' names node 9"),
        (NODES + CELLS + "*ELSET, ELSET=a\n9\n", "set 'a' names element 9"),
        (NODES + CELLS + "*NSET, NSET=a\nb\n", "line 12: 'b': there is no such set above it"),
        (NODES + CELLS + "*NSET, NSET=a, GENERATE\n1, 6, 0\n", "line 12: .*expected first, last and step"),
        (NODES + CELLS + "*NSET, NSET=a, GENERATE\n1, 1000000000000\n", "expected first, last and step"),
        ("*INCLUDE, INPUT=other.inp\n", "line 1: .INCLUDE: it names another file"),
        ("*NODE, INPUT=nodes.txt\n", "it names another file"),
        ("*PART, NAME=A\n*END PART\n*PART, NAME=B\n", "line 3: .PART: a second one, 'B'"),
        ("*INSTANCE, NAME=A, PART=A\n1., 0., 0.\n", "is moved or turned"),
        ("*NODE\n1, 0, zero\n", "line 2: 'zero': expected a coordinate"),
        ("*NODE\n1, 0\n", "line 2: node 1 has 1 coordinates"),
        ("*NODE\none, 0, 0\n", "line 2: 'one': expected a whole number"),
    ],
)
def test_what_is_not_understood_is_refused_by_its_line(text: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "mesh.inp").write_text(text)
    with pytest.raises(MeshError, match=message):
        read_abaqus(tmp_path / "mesh.inp")
