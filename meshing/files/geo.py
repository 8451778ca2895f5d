"""The outline of a plane body from a file of gmsh's geometry, or of STEP."""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from pathlib import Path
from types import ModuleType

from ..errors import MeshError
from ..generation.outline import Outline
from ..generation.session import session
from ..paths import Line, Point, signed_area
from .geo_script import Refused, harmless

#: straight sides in place of a curved one
_CHORDS = 24

#: lengths of a STEP file are in the unit that it states, or else in one that nobody knows
_STATES_UNIT = re.compile(rb"\bLENGTH_UNIT\s*\(")

#: distance from the plane z = 0 that is none, part of the size of the body
_FLAT = 1e-6


def read_outline(path: Path, run_scripts: bool = False) -> Outline:
    """The one face of a .geo file: corners counter-clockwise, its physical curves as edges and physical points as nodes.

    A .geo file is a program, and gmsh also runs a file of options beside it. It is opened as it is only with `run_scripts`;
    else what it says of a shape is written anew into an empty folder, and anything more is refused.

    Raises
    ------
    MeshError
        If there is no such file, it says more than a shape, gmsh does not read it, or its geometry is not one face.
    """
    if not os.path.isfile(path):
        raise MeshError.at("file", f" = '{path}': there is no such file")
    with tempfile.TemporaryDirectory() as folder, session() as gmsh:
        gmsh.open(str(path if run_scripts else _copied(path, Path(folder, "outline.geo"))))
        return _outline(gmsh, "file", path)


def read_step(path: Path) -> Outline:
    """The one face of a STEP file, in mm whatever its unit; it has no names of edges or points.

    Raises
    ------
    MeshError
        If there is no such file, it states no unit of length, gmsh does not read it, or its geometry is not one face in the
        plane z = 0.
    """
    if not os.path.isfile(path):
        raise MeshError.at("step", f" = '{path}': there is no such file")
    with tempfile.TemporaryDirectory() as folder, session() as gmsh:
        copy = Path(folder, "outline.step")  # gmsh also runs a file of options beside what it opens
        try:
            shutil.copyfile(path, copy)
        except OSError as error:
            raise MeshError.at("step", f" = '{path}': cannot be read: {error.strerror}") from None
        if not _STATES_UNIT.search(copy.read_bytes()):
            raise MeshError.at("step", f" = '{path}': it states no unit of length; expected a STEP file with a LENGTH_UNIT")
        gmsh.option.setString("Geometry.OCCTargetUnit", "MM")
        gmsh.open(str(copy))
        return _outline(gmsh, "step", path)


def _outline(gmsh: ModuleType, key: str, path: Path) -> Outline:
    """The one face that gmsh has, from a file that a key names."""
    faces = gmsh.model.getEntities(2)
    if len(faces) != 1:
        raise MeshError.at(key, f" = '{path}': it has {len(faces)} faces; expected one")
    x0, y0, z0, x1, y1, z1 = gmsh.model.getBoundingBox(*faces[0])
    if max(abs(z0), abs(z1)) > _FLAT * max(x1 - x0, y1 - y0):
        raise MeshError.at(key, f" = '{path}': its face has z from {z0:.4g} to {z1:.4g}; expected one in the plane z = 0")
    loops = _loops([_chords(gmsh, tag) for _, tag in gmsh.model.getBoundary(faces, oriented=True)])
    if any(loop[0] != loop[-1] for loop in loops):
        raise MeshError.at(key, f" = '{path}': the outline of its face is not closed")
    corners, *holes = sorted(loops, key=lambda loop: -abs(signed_area(loop)))
    edges = {
        gmsh.model.getPhysicalName(1, group): _joined(
            [_chords(gmsh, int(tag)) for tag in gmsh.model.getEntitiesForPhysicalGroup(1, group)],
            f"{key} = '{path}': the curves of physical group {group} are not in a row",
        )
        for _, group in gmsh.model.getPhysicalGroups(1)
    }
    nodes = {
        gmsh.model.getPhysicalName(0, group): [
            _xy(gmsh.model.getValue(0, int(tag), [])) for tag in gmsh.model.getEntitiesForPhysicalGroup(0, group)
        ]
        for _, group in gmsh.model.getPhysicalGroups(0)
    }
    holes = [hole[:-1] for hole in holes]
    return Outline(corners[:-1] if signed_area(corners) > 0 else corners[:0:-1], [], nodes=nodes, edges=edges, holes=holes)


def _copied(path: Path, copy: Path) -> Path:
    """A copy of a script with nothing in it but a shape."""
    try:
        script = harmless(path.read_text(encoding="utf-8-sig", errors="replace"))
    except Refused as error:
        raise MeshError.at(
            "file",
            f" = '{path}', {error}; expected points, curves, loops, plane surfaces and physical groups by name, as a "
            "script is not run unasked: give the mesh as .msh, or say --run-scripts (Scene.load(path, run_scripts=True)) if "
            "you trust it",
        ) from None
    except OSError as error:
        raise MeshError.at("file", f" = '{path}': cannot be read: {error.strerror}") from None
    copy.write_text(script, encoding="utf-8")
    return copy


def _chords(gmsh: ModuleType, tag: int) -> list[Point]:
    """A curve as a polyline from its start to its end; a negative tag runs back."""
    low, high = (float(bound[0]) for bound in gmsh.model.getParametrizationBounds(1, abs(tag)))
    n = 1 if gmsh.model.getType(1, abs(tag)) == "Line" else _CHORDS
    flat = gmsh.model.getValue(1, abs(tag), [low + (high - low) * i / n for i in range(n + 1)])
    points = [_xy(flat[3 * i : 3 * i + 3]) for i in range(n + 1)]
    return points if tag > 0 else points[::-1]


def _xy(at: Line) -> Point:
    return (round(float(at[0]), 9), round(float(at[1]), 9))  # type: ignore[arg-type]


def _joined(lines: list[list[Point]], otherwise: str) -> list[Point]:
    """Polylines that follow on each other, in any order and direction, as one."""
    chain, *others = _loops(lines)
    if others:
        raise MeshError(otherwise, "file")
    return chain


def _loops(lines: list[list[Point]]) -> list[list[Point]]:
    """Polylines, those that follow on each other, in any order and direction, as one."""
    loops, rest = [], list(lines)
    while rest:
        loop, rest = _followed(rest)
        loops.append(loop)
    return loops


def _followed(lines: list[list[Point]]) -> tuple[list[Point], list[list[Point]]]:
    """The first polyline with all that follow on it, and the others."""
    chain, rest = list(lines[0]), list(lines[1:])
    while rest and chain[0] != chain[-1]:
        for line in rest:
            for way in (line, line[::-1]):
                if way[0] == chain[-1]:
                    chain += way[1:]
                    break
                if way[-1] == chain[0]:
                    chain = way[:-1] + chain
                    break
            else:
                continue
            rest.remove(line)
            break
        else:
            break
    return chain, rest
