"""Physical groups of a solid body of gmsh: volumes as regions, surfaces as supports, drive, pressure and crack."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from cohesive import Scene, run
from meshing.files.reading import cell_members, load
from meshing.generation.session import session

#: a block A x A x 2 H with a crack plane of width w across its middle, its lower half softer; nu = 0, so that each half is in
#: uniform tension: 1/k = H/E + H/E_lower + w/E over the area
A, H, WIDTH, E, SOFT, MOTION = 20.0, 15.0, 0.5, 30e3, 12e3, 1e-3
STIFFNESS = A * A / (H / E + H / SOFT + WIDTH / E)


def write_block(path: Path, version: float, binary: bool) -> Path:
    """Hexahedra. A volume, a surface and a point have tag 1; the lower half is in three groups, the top in two."""
    with session() as gmsh:
        occ = gmsh.model.occ
        parts = [(3, occ.addBox(0, 0, z, A, A, H)) for z in (0.0, H)]
        occ.fragment(parts[:1], parts[1:])
        occ.synchronize()

        def at(dimension: int, low: float, high: float) -> list[int]:
            box = (-1e-3, -1e-3, low - 1e-3, A + 1e-3, A + 1e-3, high + 1e-3)
            return [tag for _, tag in gmsh.model.getEntitiesInBoundingBox(*box, dimension)]

        for _, tag in gmsh.model.getEntities(1):
            gmsh.model.mesh.setTransfiniteCurve(tag, 3)
        for _, tag in gmsh.model.getEntities(2):
            gmsh.model.mesh.setTransfiniteSurface(tag)
            gmsh.model.mesh.setRecombine(2, tag)
        for _, tag in gmsh.model.getEntities(3):
            gmsh.model.mesh.setTransfiniteVolume(tag)
        lower, upper = at(3, 0.0, H), at(3, H, 2 * H)
        groups = [
            (3, lower, 1, "lower"), (3, lower + upper, 2, "body"), (3, upper, 3, "upper"), (3, lower, 7, "soft"),
            (2, at(2, 0.0, 0.0), 1, "bottom"), (2, at(2, 2 * H, 2 * H), 2, "top"), (2, at(2, H, H), 3, "fault"),
            (2, at(2, 0.0, 0.0) + at(2, 2 * H, 2 * H), 7, "ends"), (0, at(0, 0.0, 0.0)[:1], 1, "corner"),
        ]  # fmt: skip
        for dimension, tags, number, name in groups:
            gmsh.model.addPhysicalGroup(dimension, tags, number, name)
        gmsh.model.mesh.generate(3)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.option.setNumber("Mesh.Binary", binary)
        gmsh.write(str(path))
    return path


def scene(path: Path, **specimen: Any) -> Scene:
    supports = [{"at": "bottom", "direction": [0, 0, 1]}]
    supports += [{"at": "corner", "direction": axis} for axis in ([1, 0, 0], [0, 1, 0])]
    supports += [{"at": [A, 0.0, 0.0], "direction": [0, 1, 0]}]
    supports += [{"at": [0.0, 0.0, 2 * H], "direction": axis} for axis in ([1, 0, 0], [0, 1, 0])]
    supports += [{"at": [A, 0.0, 2 * H], "direction": [0, 1, 0]}]
    block = {"kind": "mesh", "file": str(path), "crack": "fault", "supports": supports}
    return Scene(
        {
            "specimen": block | {"drive": {"at": "top", "direction": [0, 0, 1]}} | specimen,
            "material": {"E": E, "nu": 0.0, "ft": 3.0, "Gf": 0.1},
            "interface": {"width": WIDTH},
            "stage": [{"control": "driven", "to": MOTION, "steps": 1}],
        }
    )


@pytest.mark.parametrize("binary", [False, True])
@pytest.mark.parametrize("version", [2.2, 4.1])
def test_groups_of_volumes_and_surfaces(version: float, binary: bool, tmp_path: Path) -> None:
    path = write_block(tmp_path / "block.msh", version, binary)
    sizes = {name: sum(map(len, at)) for name, at in cell_members(load(path)).items()}
    assert sizes == {
        "lower": 8, "body": 16, "upper": 8, "soft": 8, "bottom": 4, "top": 4, "fault": 4, "ends": 8, "corner": 1,
    }  # fmt: skip
    uniform = run(scene(path))
    assert uniform.history["load"][-1] == pytest.approx(E * A * A * MOTION / (2 * H + WIDTH), rel=1e-9)
    for name in ("lower", "soft"):
        softer = run(scene(path, regions={name: {"E": SOFT, "nu": 0.0}}))
        assert softer.history["load"][-1] == pytest.approx(STIFFNESS * MOTION, rel=1e-9)
    gauged = run(scene(path, gauges={"whole": {"plus": "top", "minus": "bottom", "direction": [0, 0, 1]}}))
    assert gauged.history["whole"][-1] == pytest.approx(MOTION, rel=1e-9)
    pulled = run(scene(path, pressures=[{"at": "top", "value": -0.5}]).with_(**{"stage.0.to": MOTION}))
    assert pulled.history["load"][-1] == pytest.approx(E * A * A * MOTION / (2 * H + WIDTH), rel=1e-6)  # from there on
    assert pulled.history["stress_n"][-1] == pytest.approx(0.5 + E * MOTION / (2 * H + WIDTH), rel=1e-6)
