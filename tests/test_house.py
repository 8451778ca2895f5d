"""The house keeps its rules: which room imports which, no circles, private names, functions of a screen, short files.

Every import counts, those inside functions and under TYPE_CHECKING too.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pytest

import tests
from cohesive.elements.registry import ELEMENTS
from meshing.cells import CELLS

ROOT = Path(__file__).parents[1]

#: a room, and all rooms that are below it; what one floor shares does not see each other
FLOORS = [
    "commands",
    "studies explore",
    "fitting",
    "simulation",
    "outcome",
    "figures",
    "results",
    "growth",
    "model",
    "scenes",
    "measured",
    "solver",
    "cracks",
    "law algebra",
    "elements",
]
#: those of meshing, which knows nothing of cohesive; the last floor is its files that are in no room
FLOORS_OF_MESHING = ["specimens", "files", "generation", "cutting", "cells paths keys errors arrays"]


def below(floors: list[str]) -> dict[str, set[str]]:
    return {room: set(" ".join(floors[i + 1 :]).split()) for i, floor in enumerate(floors) for room in floor.split()}


BELOW, BELOW_IN_MESHING = below(FLOORS), below(FLOORS_OF_MESHING)
#: of the whole package: the public names, the entry of the command, and the module with which an MPI script begins
FACADES = {"__init__", "__main__", "petsc"}
OPEN_TO_ALL = {"errors", "arrays"}

#: of meshing: what all rooms may see, the law too
OPEN_OF_MESHING = {"meshing.errors", "meshing.keys"}
WHOLE_MESHING = {"scenes", "model"}
GEOMETRY = {"meshing.cells", "meshing.cutting.stars", "meshing.paths"}
SEES_GEOMETRY = {"outcome", "figures", "results", "studies", "growth", "elements"}

MAX_FUNCTION, MAX_FILE = 60, 400

#: private names of other packages that have no public one
OTHERS = {"meshio._mesh", "os._exit"}


@dataclass(frozen=True)
class Import:
    """A line that imports `name` of `module`, both in full; the name is empty where the module itself is imported."""

    file: Path
    line: int
    module: str
    name: str

    def __str__(self) -> str:
        return f"{self.file.relative_to(ROOT)}:{self.line} imports {self.module}{self.name and '.' + self.name}"


@cache
def files(*folders: str) -> list[Path]:
    return sorted(path for folder in folders for path in (ROOT / folder).rglob("*.py"))


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def module(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


@cache
def modules() -> dict[str, Path]:
    return {module(path): path for path in files("cohesive", "meshing")}


@cache
def imports(path: Path) -> list[Import]:
    """All imports of a file; a name that is a module of ours counts as this module."""
    found = []
    package = path.relative_to(ROOT).parent.parts
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.Import):
            found += [Import(path, node.lineno, alias.name, "") for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            home = ".".join([*package[: len(package) - node.level + 1], *([node.module] if node.module else [])])
            home = home if node.level else str(node.module)
            for alias in node.names:
                inner = f"{home}.{alias.name}"
                is_module = inner in modules()
                found.append(Import(path, node.lineno, inner if is_module else home, "" if is_module else alias.name))
    return found


def room(name: str) -> str:
    """Of a module: its folder, or itself at the top."""
    parts = name.split(".")
    return parts[1] if len(parts) > 1 else "__init__"


def fails(findings: Iterator[str] | list[str]) -> None:
    found = list(findings)
    if found:
        pytest.fail("\n".join([f"{len(found)} found:", *found]), pytrace=False)


# -- rule 1 -----------------------------------------------------------------------------------------


def test_every_file_is_in_a_room() -> None:
    homes = {"cohesive": BELOW.keys() | FACADES | OPEN_TO_ALL, "meshing": BELOW_IN_MESHING.keys() | {"__init__"}}
    fails(f"{name}: no room of the house" for name in modules() if room(name) not in homes[name.split(".")[0]])


def test_rooms_import_from_rooms_below() -> None:
    def wrong() -> Iterator[str]:
        for path in files("cohesive"):
            here = room(module(path))
            allowed = OPEN_TO_ALL | (BELOW.get(here, set()) | {here} if here not in OPEN_TO_ALL else set())
            for each in imports(path):
                if each.module.split(".")[0] == "cohesive" and here not in FACADES and room(each.module) not in allowed:
                    yield f"{each}, which is not below {here}"

    fails(wrong())


def test_few_rooms_import_meshing() -> None:
    def wrong() -> Iterator[str]:
        for path in files("cohesive"):
            here = room(module(path))
            if here in WHOLE_MESHING or here in FACADES:
                continue
            allowed = OPEN_OF_MESHING | (GEOMETRY if here in SEES_GEOMETRY else set())
            for each in imports(path):
                if each.module.split(".")[0] == "meshing" and each.module not in allowed:
                    yield f"{each}; {here} sees {', '.join(sorted(allowed))} only"

    fails(wrong())


def test_rooms_of_meshing_import_from_rooms_below() -> None:
    def wrong() -> Iterator[str]:
        ground = set(FLOORS_OF_MESHING[-1].split())
        for path in files("meshing"):
            here = room(module(path))
            allowed = BELOW_IN_MESHING.get(here, set()) | (ground if here in ground else {here})
            for each in imports(path):
                if each.module.split(".")[0] == "meshing" and here != "__init__" and room(each.module) not in allowed:
                    yield f"{each}, which is not below {here}"

    fails(wrong())


def test_meshing_knows_nothing_of_cohesive() -> None:
    fails(str(each) for path in files("meshing") for each in imports(path) if each.module.split(".")[0] == "cohesive")


def test_there_are_no_circles() -> None:
    """Files that reach themselves by their imports, each circle once."""
    graph = {
        name: {each.module for each in imports(path) if each.module in modules() and each.module != name}
        for name, path in modules().items()
    }

    @cache
    def reached(start: str) -> frozenset[str]:
        seen: set[str] = set()
        waiting = [start]
        while waiting:
            new = graph[waiting.pop()] - seen
            seen |= new
            waiting += new
        return frozenset(seen)

    circles = {tuple(sorted(other for other in reached(name) if name in reached(other))) for name in graph}
    fails(f"circle of {', '.join(circle)}" for circle in sorted(circles) if circle)


# -- rule 2 -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["law", "measured"])
def test_law_and_measured_data_stand_on_numpy_and_scipy(name: str) -> None:
    def wrong() -> Iterator[str]:
        for path in files(f"cohesive/{name}"):
            for each in imports(path):
                top = each.module.split(".")[0]
                is_ours = each.module in OPEN_OF_MESHING or (top == "cohesive" and room(each.module) in {name, *OPEN_TO_ALL})
                extra = {"openpyxl"} if path.name == "workbook.py" else set()  # which only a workbook asks for
                if not is_ours and top not in {"numpy", "scipy", *extra} and top not in sys.stdlib_module_names:
                    yield str(each)

    fails(wrong())


def identifiers(path: Path) -> Iterator[tuple[int, str]]:
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.Name):
            yield node.lineno, node.id
        elif isinstance(node, ast.Attribute):
            yield node.lineno, node.attr
        elif isinstance(node, ast.arg):
            yield node.lineno, node.arg
        elif isinstance(node, ast.alias):
            yield node.lineno, (node.asname or node.name).split(".")[-1]


def test_algebra_and_solver_do_not_know_the_scene() -> None:
    specimens = {
        node.name
        for path in files("meshing")
        if path.parent.name == "specimens" or path.stem == "block"
        for node in tree(path).body
        if isinstance(node, ast.ClassDef)
    }
    assert {"NotchedBeam", "SingleCrack"} <= specimens
    forbidden = specimens | {"Concrete", "concrete", "Scene", "scene", "specimen"}
    fails(
        f"{path.relative_to(ROOT)}:{line} names {name}"
        for path in files("cohesive/algebra", "cohesive/solver")
        for line, name in identifiers(path)
        if name in forbidden
    )


def test_bodies_are_loaded_by_one_function() -> None:
    """`solver.stepper.solve` alone knows dead loads and what they leave: whoever made a stepper would leave them out."""
    names = {"LoadStepper", "TargetPath"}
    fails(
        f"{path.relative_to(ROOT)}:{node.lineno} makes a {called[0]}; expected solve"
        for path in files("cohesive", "examples", "tests")
        if path.parent != ROOT / "cohesive" / "solver"
        for node in ast.walk(tree(path))
        if isinstance(node, ast.Call)
        and (called := [name for name in (getattr(node.func, "id", ""), getattr(node.func, "attr", "")) if name in names])
    )


# -- rule 6 -----------------------------------------------------------------------------------------


def is_private(name: str) -> bool:
    return name.startswith("_") and not name.startswith("__") and name != "_"


@cache
def defined(path: Path) -> set[str]:
    """Private names that a file makes: functions, classes, variables, attributes of self, fields."""
    found = set()
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            found.add(node.name)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            found.add(node.id)
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store) and isinstance(node.value, ast.Name):
            found |= {node.attr} if node.value.id in ("self", "cls") else set()
    return {name for name in found if is_private(name)}


def private_names(path: Path) -> Iterator[tuple[int, str]]:
    """Private names that a file imports, reads from another object, or patches by a string."""
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.ImportFrom | ast.Import):
            source = getattr(node, "module", None) or ""
            for alias in node.names:
                yield from ((node.lineno, part) for part in [*source.split("."), *alias.name.split(".")] if is_private(part))
        elif isinstance(node, ast.Attribute) and is_private(node.attr) and ast.unparse(node) not in OTHERS:
            yield node.lineno, node.attr
        elif isinstance(node, ast.Call):
            function = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            if function in {"setattr", "delattr", "getattr", "hasattr", "patch"}:
                for argument in node.args[:2]:
                    if isinstance(argument, ast.Constant) and isinstance(argument.value, str):
                        yield from ((node.lineno, part) for part in argument.value.split(".") if is_private(part))


def test_private_names_stay_in_their_file() -> None:
    fails(
        f"{path.relative_to(ROOT)}:{line} uses {name}"
        for path in files("cohesive", "meshing", "examples", "tests")
        for line, name in private_names(path)
        if name not in defined(path) and name != "_repr_html_"  # what notebooks ask for
    )


# -- rule 7 -----------------------------------------------------------------------------------------

#: files that hold a name of a cell type, and why
NAMES_OF_CELLS = {
    "meshing/cells.py": "their topology",
    "cohesive/elements/registry.py": "their shapes and quadrature",
    "meshing/generation/sizes.py": "the key mesh.shape",
    "cohesive/studies/parameters.py": "the key mesh.shape",
    "meshing/generation/extrusion.py": "what triangles and quadrilaterals are extruded to",
    "meshing/specimens/wedge_splitting.py": "a drive of this name",
}


def test_cell_types_stand_once() -> None:
    """A table or a case over cell types outside of the two registries would be forgotten by who adds one."""
    naming = {
        str(path.relative_to(ROOT)): node.lineno
        for path in files("cohesive", "meshing")
        for node in ast.walk(tree(path))
        if isinstance(node, ast.Constant) and node.value in CELLS.keys() | ELEMENTS.keys()
    }
    fails(f"{name}:{line} names a cell type" for name, line in naming.items() if name not in NAMES_OF_CELLS)
    assert set(NAMES_OF_CELLS) == set(naming)


# -- tests ----------------------------------------------------------------------------------------


def test_what_is_long_is_listed() -> None:
    """In the docstring of the tests, by files."""
    home, listed = ROOT / "tests", set(re.findall(r"^    (\S+\.py) +\w", str(tests.__doc__), flags=re.MULTILINE))
    marked = {str(path.relative_to(home)) for path in files("tests") if re.search(r"mark\.long\b", path.read_text())}
    assert listed == marked


# -- sizes ------------------------------------------------------------------------------------------


def length(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Lines of a function without its decorators and its docstring."""
    assert function.end_lineno is not None
    first = function.body[0]
    has_docstring = ast.get_docstring(function) is not None
    docstring = first.end_lineno - first.lineno + 1 if has_docstring and first.end_lineno else 0
    return function.end_lineno - function.lineno + 1 - docstring


def test_functions_fit_a_screen() -> None:
    fails(
        f"{path.relative_to(ROOT)}:{node.lineno} {node.name} has {length(node)} lines; expected at most {MAX_FUNCTION}"
        for path in files("cohesive", "meshing")
        for node in ast.walk(tree(path))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and length(node) > MAX_FUNCTION
    )


def test_files_are_short() -> None:
    fails(
        f"{path.relative_to(ROOT)} has {count} lines; expected at most {MAX_FILE}"
        for path in files("cohesive", "meshing", "tests")
        if (count := len(path.read_text(encoding="utf-8").splitlines())) > MAX_FILE
    )
