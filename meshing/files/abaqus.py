"""Input files of Abaqus: nodes, elements and sets. Keywords and names are the same whatever their case; sets add up."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import meshio
import numpy as np

from ..arrays import Index
from ..cells import CELLS
from ..errors import MeshError

#: meshio's name by the beginning of an element type; what may follow says how it is integrated
_TYPES = {begin: name for name, cell in CELLS.items() for begin in cell.abaqus}
_FORMULATION = re.compile(r"[RIHMS5]*")

#: keywords that say where nodes are in a way that is not read here
_REFUSED = {
    "INCLUDE": "it names another file; expected one file with everything",
    "SYSTEM": "coordinates of another system; expected those of the body",
    "NGEN": "nodes by a rule; expected all nodes",
    "NCOPY": "nodes by a rule; expected all nodes",
    "NFILL": "nodes by a rule; expected all nodes",
    "NMAP": "nodes by a rule; expected all nodes",
    "ELGEN": "elements by a rule; expected all elements",
    "ELCOPY": "elements by a rule; expected all elements",
}

#: most entries of all sets, which may name each other and be generated
_MOST = 10_000_000


def read_abaqus(path: Path) -> meshio.Mesh:
    """Nodes, elements and their sets.

    Returns
    -------
    meshio.Mesh
        With (n, 3) points, a block for each type of element, `point_sets` and `cell_sets`.

    Raises
    ------
    MeshError
        Naming the line, for what is not understood: an element type, several parts, another file, numbers that are none.
    """
    reader = _Reader(f" = '{path}'")
    for number, keyword, options, rows in _sections(path):
        reader.take(number, keyword, options, rows)
    return reader.mesh()


def _sections(path: Path) -> Iterator[tuple[int, str, dict[str, str], list[tuple[int, list[str]]]]]:
    """Each keyword with its line, its options, and the data lines below it."""
    number, keyword, options = 0, "", dict[str, str]()
    rows: list[tuple[int, list[str]]] = []
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        for at, raw in enumerate(file, start=1):
            line = raw.strip()
            if not line or line.startswith("**"):
                continue
            if line.startswith("*"):
                if keyword:
                    yield number, keyword, options, rows
                parts = [part.strip() for part in line[1:].split(",")]
                number, keyword, rows = at, " ".join(parts[0].upper().split()), []
                pairs = [part.partition("=") for part in parts[1:] if part]
                options = {key.strip().upper(): value.strip().strip('"') for key, _, value in pairs}
                continue
            rows.append((at, [entry for part in line.split(",") if (entry := part.strip())]))
    if keyword:
        yield number, keyword, options, rows


@dataclass
class _Reader:
    """What was read so far. Sets are kept by their name in capitals."""

    where: str
    nodes: dict[int, list[float]] = field(default_factory=dict)
    elements: dict[int, tuple[str, list[int]]] = field(default_factory=dict)  # type and nodes
    node_sets: dict[str, list[int]] = field(default_factory=dict)
    element_sets: dict[str, list[int]] = field(default_factory=dict)
    names: dict[str, str] = field(default_factory=dict)  # as first written
    parts: list[str] = field(default_factory=list)
    entries: int = 0  # of all sets

    def take(self, line: int, keyword: str, options: dict[str, str], rows: list[tuple[int, list[str]]]) -> None:
        """One keyword with its data lines."""
        if keyword in _REFUSED:
            raise self._error(line, f"*{keyword}: {_REFUSED[keyword]}")
        if keyword in ("PART", "INSTANCE") and options.get("NAME"):
            self._check_single(line, keyword, options, rows)
        elif keyword == "NODE":
            if "INPUT" in options:
                raise self._error(line, f"*NODE: {_REFUSED['INCLUDE']}")
            self._take_nodes(options, rows)
        elif keyword == "ELEMENT":
            self._take_elements(line, options, rows)
        elif keyword == "NSET" and "ELSET" in options:
            cells = self._members(line, self.element_sets, [options["ELSET"]])
            corners = [node for number in cells for node in self.elements[number][1]]
            self._add(self.node_sets, options.get("NSET", ""), corners)
        elif keyword in ("NSET", "ELSET"):
            sets = self.node_sets if keyword == "NSET" else self.element_sets
            self._add(sets, options.get(keyword, ""), self._listed(sets, options, rows))

    def _check_single(self, line: int, keyword: str, options: dict[str, str], rows: list[tuple[int, list[str]]]) -> None:
        """Refuse a second part or instance, and one that is moved."""
        name = f"{keyword} {options['NAME'].upper()}"
        others = [other for other in self.parts if other.startswith(keyword)]
        if others and name not in others:
            raise self._error(line, f"*{keyword}: a second one, '{options['NAME']}'; expected one body in one part")
        if rows and keyword == "INSTANCE" and any(float(entry) for _, row in rows for entry in row if _is_number(entry)):
            raise self._error(line, f"*{keyword}: '{options['NAME']}' is moved or turned; expected it where its part is")
        self.parts.append(name)

    def _take_nodes(self, options: dict[str, str], rows: list[tuple[int, list[str]]]) -> None:
        numbers = []
        for line, row in rows:
            number = self._number(line, row[0]) if row else 0
            place = [self._coordinate(line, entry) for entry in row[1:4]]
            if len(place) < 2:
                raise self._error(line, f"node {number} has {len(place)} coordinates; expected 2 or 3")
            self.nodes[number] = [*place, 0.0][:3]
            numbers.append(number)
        if "NSET" in options:
            self._add(self.node_sets, options["NSET"], numbers)

    def _take_elements(self, line: int, options: dict[str, str], rows: list[tuple[int, list[str]]]) -> None:
        if "INPUT" in options:
            raise self._error(line, f"*ELEMENT: {_REFUSED['INCLUDE']}")
        given = options.get("TYPE", "").upper()
        kind = _kind_of(given)
        if not kind:
            raise self._error(line, f"*ELEMENT: type {given or 'missing'}; expected one of {', '.join(_TYPES)}")
        count = meshio._mesh.num_nodes_per_cell[kind]
        numbers, entries = [], list[int]()
        for at, row in rows:
            entries += [self._number(at, entry) for entry in row]
            if len(entries) < count + 1 and row is not rows[-1][1]:
                continue  # a long element goes on in the next line
            if len(entries) != count + 1:
                raise self._error(at, f"element {entries[0]} of type {given} has {len(entries) - 1} nodes; expected {count}")
            if entries[0] in self.elements:
                raise self._error(at, f"element {entries[0]} is given twice; expected each once")
            self.elements[entries[0]] = (kind, entries[1:])
            numbers.append(entries[0])
            entries = []
        if "ELSET" in options:
            self._add(self.element_sets, options["ELSET"], numbers)

    def _listed(self, sets: dict[str, list[int]], options: dict[str, str], rows: list[tuple[int, list[str]]]) -> list[int]:
        """The numbers of a set: one by one, by ranges with GENERATE, or those of other sets."""
        found: list[int] = []
        for line, row in rows:
            if "GENERATE" in options:
                first, last, step = [*(self._number(line, entry) for entry in row), 1][:3] if len(row) > 1 else (0, -1, 0)
                if step < 1 or (last - first) / step > _MOST:
                    raise self._error(line, f"{', '.join(row)}: expected first, last and step of numbers that are generated")
                found += range(first, last + 1, step)
                self._check_count(line, len(found))
                continue
            entries = [entry.rpartition(".")[2] if entry.rpartition(".")[2].isdecimal() else entry for entry in row]
            for entry in entries:
                found += [int(entry)] if entry.isdecimal() else self._members(line, sets, [entry])
        return found

    def _members(self, line: int, sets: dict[str, list[int]], names: list[str]) -> list[int]:
        found: list[int] = []
        for name in names:
            if name.upper() not in sets:
                raise self._error(line, f"'{name}': there is no such set above it")
            found += sets[name.upper()]
            self._check_count(line, len(found))
        return found

    def _check_count(self, line: int, more: int) -> None:
        if self.entries + more > _MOST:
            raise self._error(line, f"the sets have more than {_MOST:,} entries; expected those of a mesh")

    def _add(self, sets: dict[str, list[int]], name: str, numbers: list[int]) -> None:
        self.names.setdefault(name.upper(), name)
        sets.setdefault(name.upper(), []).extend(numbers)
        self.entries += len(numbers)

    def mesh(self) -> meshio.Mesh:
        """What was read, nodes and elements counted from 0."""
        index = {number: i for i, number in enumerate(self.nodes)}
        at: dict[int, tuple[int, int]] = {}
        kinds = list(dict.fromkeys(kind for kind, _ in self.elements.values()))
        cells: list[list[list[int]]] = [[] for _ in kinds]
        for number, (kind, nodes) in self.elements.items():
            block = kinds.index(kind)
            at[number] = (block, len(cells[block]))
            cells[block].append([index[self._there("node", f"element {number}", node, index)] for node in nodes])
        blocks = [(kind, np.array(own, dtype=np.int64)) for kind, own in zip(kinds, cells, strict=True)]
        point_sets = {}
        for name, members in self.node_sets.items():
            point_sets[self.names[name]] = _unique(
                [index[self._there("node", f"set '{self.names[name]}'", n, index)] for n in members]
            )
        cell_sets = {}
        for name, members in self.element_sets.items():
            places = [at[self._there("element", f"set '{self.names[name]}'", n, at)] for n in members]
            cell_sets[self.names[name]] = [_unique([i for b, i in places if b == own]) for own in range(len(blocks))]
        points = np.array(list(self.nodes.values()), dtype=float).reshape(-1, 3)
        return meshio.Mesh(points, blocks, point_sets=point_sets, cell_sets=cell_sets)

    def _there(self, what: str, by: str, number: int, known: Mapping[int, object]) -> int:
        if number not in known:
            raise MeshError.at("file", f"{self.where}: {by} names {what} {number}, which the file has not")
        return number

    def _number(self, line: int, entry: str) -> int:
        if not entry.isdecimal():
            raise self._error(line, f"{entry!r}: expected a whole number")
        return int(entry)

    def _coordinate(self, line: int, entry: str) -> float:
        if not _is_number(entry):
            raise self._error(line, f"{entry!r}: expected a coordinate")
        return float(entry.upper().replace("D", "E"))

    def _error(self, line: int, what: str) -> MeshError:
        return MeshError.at("file", f"{self.where}, line {line}: {what}")


def _kind_of(given: str) -> str:
    """meshio's name of an element type, empty if it is not read."""
    for begin in sorted(_TYPES, key=len, reverse=True):
        if given.startswith(begin) and _FORMULATION.fullmatch(given[len(begin) :]):
            return _TYPES[begin]
    return ""


def _is_number(entry: str) -> bool:
    try:
        float(entry.upper().replace("D", "E"))
    except ValueError:
        return False
    return True


def _unique(numbers: list[int]) -> Index:
    return np.unique(np.array(numbers, dtype=np.int64))
