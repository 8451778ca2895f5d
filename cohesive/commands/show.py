"""`cohesive show SCENE`."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..model.estimate import estimate
from ..model.marks import DRIVE, GAUGE, PRESSURE, SUPPORT, marks
from ..model.mesh import CrackedMesh, cracked_mesh
from ..results.files import make_folder, write_file
from .common import Commands, add_model, add_scene, load_scene

if TYPE_CHECKING:
    from ..scenes.scene import Scene

#: kinds of marks, as the table calls them
_TITLES = {SUPPORT: "held", DRIVE: "driven", PRESSURE: "pressed", GAUGE: "measured"}


def add_parser(commands: Commands) -> None:
    """The command's arguments."""
    p = commands.add_parser(
        "show",
        help="draw a scene before it runs",
        description="Mesh a scene and show it: sets, crack path, what is held, driven and measured. Nothing is solved.",
    )
    add_scene(p, "the scene's name", "mesh.crack_size=2")
    add_model(p)
    p.set_defaults(execute=_execute)


def _execute(options: argparse.Namespace) -> int:
    from ..figures.mesh import save_mesh  # with matplotlib, which is slow to import

    scene = load_scene(options)
    folder = Path(options.output or Path(options.scene).stem)
    make_folder(folder)
    mesh = cracked_mesh(scene)
    for line in table(scene, mesh):
        print(line)
    write_file(folder / "mesh.png", partial(save_mesh, scene, mesh))
    print(f"files: {folder}/  (mesh.png)")
    return 0


def table(scene: Scene, mesh: CrackedMesh) -> Iterator[str]:
    """What a scene is made of, in lines."""
    low, high = mesh.points.min(axis=0), mesh.points.max(axis=0)
    yield scene.title
    half = ", one half of the body" if scene.model.half else ""
    yield _line("specimen", f"{scene.kind}, {' x '.join(f'{side:.4g}' for side in high - low)} mm{half}")
    yield _line("mesh", f"{len(mesh.points)} nodes, {_cells(mesh)}")
    if (expected := estimate(scene)) is not None:
        yield _line("expected", expected.text)
    yield _line("crack", _crack(scene, mesh))
    for mark in marks(scene.specimen, mesh, scene.model.plane, scene.model.half):
        named = f"{mark.name}, " if mark.name else ""
        yield _line(_TITLES[mark.kind], f"{named}{mark.text}")
    for i, stage in enumerate(scene.stages, start=1):
        targets = ", ".join(f"{target:.4g}" for target in stage.targets)
        yield _line(f"stage {i}", f"{stage.control} to {targets}")
    for name, nodes in sorted(mesh.sets.items()):
        low, high = mesh.points[nodes].min(axis=0), mesh.points[nodes].max(axis=0)
        spans = [f"{x} {a:.4g}" + (f" to {b:.4g}" if b - a >= 1e-9 else "") for x, a, b in zip("xyz", low, high, strict=False)]
        yield _line("set", f"{name}: {len(nodes)} node{'s' if len(nodes) > 1 else ''}, {', '.join(spans)}")


def _line(title: str, text: str) -> str:
    return f"{title + ':':11s}{text}"


def _cells(mesh: CrackedMesh) -> str:
    count: dict[str, int] = {}
    for block in (*mesh.bulk, *mesh.band):
        count[block.type] = count.get(block.type, 0) + len(block.data)
    return ", ".join(f"{number} {kind}" for kind, number in count.items())


def _crack(scene: Scene, mesh: CrackedMesh) -> str:
    """The crack path and what stands for it."""
    if mesh.crack is not None:
        text = f"{len(mesh.crack.data)} zero-thickness cells"
    else:
        text = f"{sum(len(block.data) for block in mesh.band)} elements that may crack"
    if scene.grow is not None:
        return f"{text}; the run looks for its path"
    for line in scene.specimen.paths:
        points = [f"({x:.4g}, {y:.4g})" for x, y in line]
        shown = points if len(points) <= 4 else [*points[:2], "...", points[-1]]
        text += f", path {' to '.join(shown)}, {np.hypot(*np.diff(line, axis=0).T).sum():.4g} mm"
    return text
