"""Physical groups of gmsh: told by dimension and tag, every group of an entity, in both formats, as text and binary."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cohesive import run
from meshing import MeshError
from meshing.files.reading import cell_members, load
from meshing.generation.session import session
from tests.meshing.files.plate import LOAD, MOTION, E, scene


def write_plate(path: Path, version: float, binary: bool, save_all: bool = False) -> Path:
    """Two rows of squares. Tag 1 is a curve and a surface; the top is in two groups, and so is the lower half."""
    with session() as gmsh:
        occ = gmsh.model.occ
        parts = [(2, occ.addRectangle(0, y, 0, 100, 30)) for y in (0, 30)]
        occ.fragment(parts[:1], parts[1:])
        occ.synchronize()
        level = {}
        for _, curve in gmsh.model.getEntities(1):
            gmsh.model.mesh.setTransfiniteCurve(curve, 3)
            _, low, _, _, high, _ = gmsh.model.getBoundingBox(1, curve)
            if high - low < 1.0:
                level[round(low)] = curve
        for _, surface in gmsh.model.getEntities(2):
            gmsh.model.mesh.setTransfiniteSurface(surface)
            gmsh.model.mesh.setRecombine(2, surface)
        groups = [(1, [0], 1, "bottom"), (1, [60], 2, "top"), (1, [30], 3, "fault"), (1, [0, 60], 7, "ends")]
        for dimension, at, tag, name in groups:
            gmsh.model.addPhysicalGroup(dimension, [level[y] for y in at], tag, name)
        gmsh.model.addPhysicalGroup(2, [1], 1, "lower")
        gmsh.model.addPhysicalGroup(2, [1, 2], 2, "body")
        gmsh.model.addPhysicalGroup(0, [gmsh.model.getEntitiesInBoundingBox(-1, -1, -1, 1, 1, 1, 0)[0][1]], 1, "corner")
        gmsh.model.mesh.generate(2)
        for option, value in (("MshFileVersion", version), ("Binary", binary), ("SaveAll", save_all)):
            gmsh.option.setNumber(f"Mesh.{option}", value)
        gmsh.write(str(path))
    return path


@pytest.mark.parametrize("binary", [False, True])
@pytest.mark.parametrize("version", [2.2, 4.1])
def test_every_group_holds_its_own(version: float, binary: bool, tmp_path: Path) -> None:
    path = write_plate(tmp_path / "plate.msh", version, binary)
    sizes = {name: sum(map(len, at)) for name, at in cell_members(load(path)).items()}
    assert sizes == {"bottom": 2, "top": 2, "fault": 2, "ends": 4, "lower": 4, "body": 8, "corner": 1}
    pinned = [{"at": "bottom", "direction": [0, 1]}, {"at": "corner", "direction": [1, 0]}]
    assert run(scene(path, supports=pinned)).history["load"][-1] == pytest.approx(LOAD, rel=1e-12)
    both = {"name": {"plus": "top", "minus": "bottom", "direction": [0, 1]}}
    gauged = run(scene(path, gauges=both))
    assert gauged.history["name"][-1] == pytest.approx(MOTION, rel=1e-12)
    pressed = scene(path, pressures=[{"at": "top", "value": -0.1}]).with_(**{"stage.0.to": 1e-9})
    assert run(pressed).history["load"][-1] == pytest.approx(E * 2000.0 * 1e-9 / 60.5, rel=1e-6)  # measured from there
    soft = run(scene(path, regions={"lower": {"E": 15e3, "nu": 0.2}}))
    stiffness = 2000.0 / (30.0 / 15e3 + 30.5 / E)
    assert soft.history["load"][-1] == pytest.approx(stiffness * MOTION, rel=0.02)  # the halves narrow differently


def test_an_element_that_is_given_twice_stays_a_defect(tmp_path: Path) -> None:
    path = write_plate(tmp_path / "plate.msh", 2.2, False)
    lines = path.read_text().splitlines()
    at = lines.index("$Elements")
    last = lines[at + int(lines[at + 1]) + 1].split()
    lines[at + 1] = str(int(lines[at + 1]) + 1)
    lines.insert(lines.index("$EndElements"), " ".join(["999", *last[1:]]))
    path.write_text("\n".join(lines) + "\n")
    with pytest.raises(MeshError, match="are given twice"):
        scene(path).specimen.mesh(None)  # type: ignore[arg-type]


def test_a_file_with_elements_of_no_group_says_so(tmp_path: Path) -> None:
    with pytest.raises(MeshError, match=r"as Mesh\.SaveAll writes them"):
        load(write_plate(tmp_path / "plate.msh", 4.1, False, save_all=True))


def test_a_cell_that_cannot_be_computed_is_refused_among_others(tmp_path: Path) -> None:
    import meshio

    x, y = np.meshgrid(np.linspace(0, 2, 5), np.linspace(0, 1, 3))
    points = np.column_stack([x.ravel(), y.ravel(), 0.0 * x.ravel()])
    eight, nine = [[0, 2, 12, 10, 1, 7, 11, 5]], [[2, 4, 14, 12, 3, 9, 13, 7, 8]]
    meshio.Mesh(points, [("quad8", eight), ("quad9", nine)]).write(tmp_path / "mixed.vtu")
    with pytest.raises(MeshError, match="its cells are quad9; expected triangle"):
        scene(tmp_path / "mixed.vtu", crack=[[[1, 0], [1, 1]]]).specimen.mesh(None)  # type: ignore[arg-type]
